//! Contact runs against closed forms: a blade, Painlevé's rod, and the cases of SimBenchmark (Hwangbo and
//! Kang, 2018) with its error measures.

use dynamics::{KnifeEdge, PlanarBody};
use nalgebra::{Matrix3, Vector3, vector};
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription,
    Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::number::SplitMix64;

use crate::free_body::run_on;

const G: f64 = 9.81;

/// Free balls with equal mass and radius.
fn balls(count: usize, mass: f64, radius: f64) -> RobotDescription {
    let mut robot = RobotDescription::new("balls");
    robot.links.push(LinkDescription::new("world", None));
    for k in 0..count {
        let name = format!("ball{k}");
        let moment = Matrix3::identity() * (0.4 * mass * radius * radius);
        robot
            .links
            .push(LinkDescription::new(&name, MassProperties::new(mass, Vector3::zeros(), moment).unwrap()));
        // Placed side by side in the neutral configuration.
        let at = Pose::from_translation([10.0 * k as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("free{k}"), JointKind::Floating, "world", &name, at));
        let shape = LinkShape::new(&name, ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius });
        robot.shapes.push(shape);
    }
    robot
}

fn placed(at: &[[f64; 3]]) -> Vec<f64> {
    let each = at.iter().enumerate();
    each.flat_map(|(k, [x, y, z])| [x - 10.0 * k as f64, *y, *z, 0.0, 0.0, 0.0, 1.0]).collect()
}

/// SimBenchmark's bouncing case: balls of 10 kg and 0.1 m fall 5 m onto the ground with e = 1. The measure is
/// the mean square of the energy error of the 49 balls together; it is 49² times that of one ball.
fn bouncing_error(h: f64, steps: usize) -> f64 {
    let model = Model::new(balls(1, 10.0, 0.1)).unwrap();
    let ground = Ground::level(0.0).with_friction(0.0).with_restitution(1.0);
    let contacts = ContactSet::new(&model, &[ground]).unwrap();
    let energy = 10.0 * G * 5.0;
    let (mut sum, mut count) = (0.0, 0);
    run_on(&model, contacts, (&placed(&[[0.0, 0.0, 5.0]]), &[0.0; 6]), (h, steps), |info| {
        let speed: f64 = info.v[..3].iter().map(|v| v * v).sum();
        let own = 5.0 * speed + 10.0 * G * info.q[2];
        sum += (49.0 * (own - energy)).powi(2);
        count += 1;
    });
    sum / f64::from(count)
}

/// A ball that bounces without loss keeps its energy, up to the time of the impact within a sixteenth of a
/// step.
#[test]
fn bouncing_ball_keeps_its_energy() {
    let [coarse, fine] = [(1e-2, 2000), (1e-3, 20_000)].map(|(h, steps)| {
        let error = bouncing_error(h, steps);
        println!("bouncing, 20 s, h = {h}: mean square of the energy's error of 49 balls {error:e} J²");
        error
    });
    // Relative to 49·490.5 J. The height of the impact is off by at most v h/16: m g v h/16 = 62 J h/s for
    // each ball and bounce.
    let bound = |h: f64| (49.0 * 2.0 * 62.0 * h).powi(2);
    assert!(coarse < bound(1e-2) && fine < bound(1e-3), "{coarse} {fine}");
}

/// SimBenchmark's 666 case: n³ balls of 10 kg and 0.1 m fall from 1.1 m without friction and restitution.
/// They are 0.21 m apart with random offsets of 1 mm. The measure is the mean over time of the sum of squared
/// penetration depths between balls and into the ground.
fn depth_error(n: usize, (h, steps): (f64, usize)) -> (f64, f64, f64) {
    let mut robot = balls(n * n * n, 10.0, 0.1);
    robot.shapes.iter_mut().for_each(|shape| shape.surface.friction = [0.0; 3]);
    let model = Model::new(robot).unwrap();
    let contacts =
        ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.0)]).unwrap().with_links(&model);
    let mut random = SplitMix64::new(42);
    let mut at = Vec::new();
    for k in 0..n * n * n {
        let cell = [k / (n * n), k / n % n, k % n];
        let place = cell.map(|k| 0.21 * k as f64 + 1e-3 * random.uniform(0.0, 1.0));
        at.push([place[0], place[1], place[2] + 1.101]);
    }
    let (mut sum, mut count, mut deepest) = (0.0, 0, 0.0_f64);
    let energy = |q: &[f64], v: &[f64]| {
        let of = |k: usize| {
            let linear: f64 = v[6 * k..6 * k + 3].iter().map(|v| v * v).sum();
            let turning: f64 = v[6 * k + 3..6 * k + 6].iter().map(|v| v * v).sum();
            5.0 * linear + 0.5 * 0.04 * turning + 10.0 * G * q[7 * k + 2]
        };
        (0..n * n * n).map(of).sum::<f64>()
    };
    let (mut before, mut rise) = (f64::INFINITY, 0.0_f64);
    run_on(&model, contacts, (&placed(&at), &vec![0.0; 6 * at.len()]), (h, steps), |info| {
        let center = |k: usize| {
            let q = &info.q[7 * k..];
            Vector3::new(q[0] + 10.0 * k as f64, q[1], q[2])
        };
        for k in 0..n * n * n {
            let own = center(k);
            let others = (0..k).map(|other| 0.2 - (own - center(other)).norm());
            for depth in others.chain([0.1 - own.z]).filter(|depth| *depth > 0.0) {
                sum += depth * depth;
                deepest = deepest.max(depth);
            }
        }
        count += 1;
        let now = energy(info.q, info.v);
        rise = rise.max(now - before);
        before = now;
    });
    (sum / f64::from(count), deepest, rise)
}

#[test]
fn stacked_balls_penetrate_little() {
    let (error, deepest, rise) = depth_error(2, (2e-3, 500));
    println!(
        "2³ balls, 1 s, h = 2 ms: mean of the summed squares of depths {error:e} m², deepest {deepest:e} m, most energy gained in a step {rise:e} J"
    );
    assert!(deepest < 1e-4, "{deepest}");
    assert!(error < 8.0 * 1e-8, "{error}");
}

/// The first second of its 6³ balls.
#[test]
#[ignore = "takes long: cargo test … --ignored full_size"]
fn stacked_balls_penetrate_little_at_full_size() {
    for n in 3..=6 {
        let clock = std::time::Instant::now();
        let (error, deepest, rise) = depth_error(n, (2e-3, 500));
        println!(
            "{n}³ balls, 1 s, h = 2 ms: mean of the summed squares of depths {error:e} m², deepest {deepest:e} m, most energy gained in a step {rise:e} J; {:.0} s of computing",
            clock.elapsed().as_secs_f64()
        );
        assert!(deepest < 1e-3, "{deepest}");
    }
}

/// The full-size case with e = 1.
#[test]
#[ignore = "takes long: cargo test … --ignored full_size"]
fn elastic_balls_keep_their_energy_at_full_size() {
    (3..=6).for_each(|n| elastic(n, (2e-3, 500)));
}

/// SimBenchmark's elastic 666 case: these balls with e = 1 between each other and with the ground. The
/// measure is the mean square of the energy error.
#[test]
fn elastic_balls_keep_their_energy() {
    for (h, steps) in [(2e-3, 500), (5e-4, 2000)] {
        elastic(2, (h, steps));
    }
}

/// n³ of these balls.
fn elastic(n: usize, (h, steps): (f64, usize)) {
    let count = n * n * n;
    let mut robot = balls(count, 10.0, 0.1);
    robot.shapes.iter_mut().for_each(|shape| shape.surface.friction = [0.0; 3]);
    let model = Model::new(robot).unwrap();
    let ground = Ground::level(0.0).with_friction(0.0).with_restitution(1.0);
    let contacts = ContactSet::new(&model, &[ground]).unwrap().with_links(&model);
    let contacts = contacts.with_link_restitution(1.0).unwrap();
    let mut random = SplitMix64::new(42);
    let at: Vec<[f64; 3]> = (0..count)
        .map(|k| {
            let cell = [k / (n * n), k / n % n, k % n];
            let mut place = cell.map(|k| 0.21 * k as f64 + 1e-3 * random.uniform(0.0, 1.0));
            place[2] += 1.101;
            place
        })
        .collect();
    let energy = |q: &[f64], v: &[f64]| {
        let of = |k: usize| {
            let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
            let (linear, turning) = (square(&v[6 * k..6 * k + 3]), square(&v[6 * k + 3..6 * k + 6]));
            5.0 * linear + 0.5 * 0.04 * turning + 10.0 * G * q[7 * k + 2]
        };
        (0..count).map(of).sum::<f64>()
    };
    let q = placed(&at);
    let rest = vec![0.0; 6 * count];
    let start = energy(&q, &rest);
    let (mut sum, mut seen, mut bounces) = (0.0, 0, 0);
    let mut down = 0.0;
    let run = run_on(&model, contacts, (&q, &rest), (h, steps), |info| {
        sum += (energy(info.q, info.v) - start).powi(2);
        seen += 1;
        bounces += usize::from(down < 0.0 && info.v[2] > 0.0);
        down = info.v[2];
    });
    let error = sum / f64::from(seen);
    println!(
        "{n}³ elastic balls, {} s, h = {h}: mean square of the energy's error {error:e} J², of {start} J",
        run.time
    );
    // As in the bouncing case the height of each impact is off by at most v h/16. The balls have 10 kg and 5
    // m/s in about five impacts each.
    let bound = 5.0 * count as f64 * 10.0 * G * 5.0 * h / 16.0;
    assert!(bounces > 0 && error < bound * bound, "{error} {bound}");
}

/// A body on one massless wheel, which rolls along one axis and sticks along the other: the blade of
/// [`KnifeEdge`]. World, height, plane, wheel.
fn skate(m: f64, i_zz: f64, a_g: f64) -> RobotDescription {
    let mut robot = RobotDescription::new("skate");
    robot.gravity = [0.0, -a_g, -G];
    // I/r² of the wheel is 1e-5 kg; the body has 2 kg.
    let light = || MassProperties::new(1e-7, Vector3::zeros(), Matrix3::identity() * 1e-7).unwrap();
    let body = MassProperties::new(m, Vector3::zeros(), Matrix3::identity() * i_zz).unwrap();
    for (name, mass) in
        [("world", None), ("lift", Some(light())), ("body", Some(body)), ("wheel", Some(light()))]
    {
        robot.links.push(LinkDescription::new(name, mass));
    }
    let (z, y) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    for (name, kind, parent, child) in [
        ("height", JointKind::Prismatic { axis: z }, "world", "lift"),
        ("plane", JointKind::Planar { normal: z }, "lift", "body"),
        ("axle", JointKind::Continuous { axis: y }, "body", "wheel"),
    ] {
        robot.joints.push(JointDescription::new(name, kind, parent, child, Pose::IDENTITY));
    }
    let ball = Shape::Sphere { radius: 0.1 };
    robot.shapes.push(LinkShape::new("wheel", ShapeRole::Collision, Pose::IDENTITY, ball));
    robot
}

/// On a slope with a_g along −y, θ = ωt and v = v₀ − a_g(1 − cos ωt)/ω. The blade drifts across the slope
/// along a cycloid and does not descend. The side force follows its closed form, with an error of order 2.
#[test]
fn blade_on_slope_follows_cycloid() {
    let (m, i_zz, a_g, v0, w, time) = (2.0, 0.5, 3.0, 1.5, 4.0, 1.0);
    let model = Model::new(skate(m, i_zz, a_g)).unwrap();
    let blade = KnifeEdge { body: PlanarBody { m, i_zz, a_g } };
    let (sin, cos) = f64::sin_cos(w * time);
    let x = v0 * sin / w + a_g / w * (0.5 * time + (2.0 * w * time).sin() / (4.0 * w) - sin / w);
    let y = v0 * (1.0 - cos) / w + a_g / w * (0.5 * sin * sin / w - (1.0 - cos) / w);
    let speed = v0 - a_g / w * (1.0 - cos);
    let off = [(4e-3, 250), (2e-3, 500)].map(|(h, steps)| {
        let contacts = ContactSet::new(&model, &[Ground::level(0.0).with_friction(10.0)]).unwrap();
        // The wheel turns at v₀/r: rolling along x is a rotation about y.
        let (q, v) = ([0.1, 0.0, 0.0, 0.0, 0.0], [0.0, v0, 0.0, w, v0 / 0.1]);
        let run = run_on(&model, contacts, (&q, &v), (h, steps), |_| {});
        let qd = KnifeEdge::velocity(&vector![x, y, w * time], speed, w);
        let side = blade.side_force(&vector![x, y, w * time], &qd, &vector![0.0, 0.0, 0.0]);
        let [along_x, along_y, up] = run.contact_forces[0];
        let force = (along_x - side * sin).hypot(along_y + side * cos);
        let way = (run.q[1] - x).hypot(run.q[2] - y);
        println!(
            "blade, 1 s, h = {h}: way off {way:e} m, force off {force:e} N, height {:e} m",
            run.q[0] - 0.1
        );
        assert!((up - m * G).abs() < 1e-6 * m * G && (run.q[0] - 0.1).abs() < 1e-9, "{up}");
        (way, force)
    });
    assert!(off[1].0 < 1e-4 && off[0].0 > 3.0 * off[1].0, "{off:?}");
    // Relative to 2 kg · (v ω + a_g) = 20 N. The force of a step is its mean, off by half a step of its rate
    // of about 60 N/s.
    assert!(off[1].1 < 0.1 && off[0].1 > 1.5 * off[1].1, "{off:?}");
}

/// Painlevé's rod is at 60° with μ = 2, and its tip slides away from under it. Each newton of the ground
/// presses the tip further down: 1 + 3 cos φ (cos φ − μ sin φ) = −0.85 in units of 1/m. No finite force
/// supports the tip. The step stops the tip by an impulse, like an impact without collision. All numbers stay
/// finite, no body penetrates the ground, and no energy is gained.
#[test]
fn painleves_rod_jams_without_gaining_energy() {
    let (half, radius, slope) = (0.5, 1e-3, std::f64::consts::FRAC_PI_3);
    let mut robot = RobotDescription::new("rod");
    robot.base = Base::Floating;
    let moments = Matrix3::from_diagonal(&Vector3::new(half * half / 3.0, half * half / 3.0, 1e-6));
    robot
        .links
        .push(LinkDescription::new("rod", MassProperties::new(1.0, Vector3::zeros(), moments).unwrap()));
    let shape = Shape::Capsule { radius, length: 2.0 * half };
    robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::IDENTITY, shape));
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0).with_friction(2.0)]).unwrap();
    // The z axis of the rod along (cos φ, 0, sin φ): rotated about y by π/2 − φ.
    let turn = 0.5 * (std::f64::consts::FRAC_PI_2 - slope);
    let q = [0.0, 0.0, half * slope.sin() + radius, 0.0, turn.sin(), 0.0, turn.cos()];
    // 3 m/s along −x, in the axes of the rod.
    let v = [-3.0 * (2.0 * turn).cos(), 0.0, -3.0 * (2.0 * turn).sin(), 0.0, 0.0, 0.0];
    let energy = |q: &[f64], v: &[f64]| {
        let turning = half * half / 3.0 * (v[3] * v[3] + v[4] * v[4]) + 1e-6 * v[5] * v[5];
        0.5 * (v[..3].iter().map(|v| v * v).sum::<f64>() + turning) + G * q[2]
    };
    let first = energy(&q, &v);
    let (mut before, mut rise, mut after_one) = (first, 0.0_f64, None);
    let run = run_on(&model, contacts, (&q, &v), (1e-3, 1000), |info| {
        let now = energy(info.q, info.v);
        (rise, before) = (rise.max(now - before), now);
        if info.step == 1 {
            after_one = Some((now, info.v.to_vec()));
        }
        assert!(info.q[2] > -1e-9, "{:?}", info.q);
    });
    let laws = run.contact_laws.unwrap();
    println!(
        "rod: {first} J at the start, after one step {after_one:?}, at the end {before} J; most gained in a step {rise:e} J; {laws:?}"
    );
    assert!(run.q.iter().chain(&run.v).all(|x| x.is_finite()));
    // The allowed error of a step of 1 ms: v²h² of the energy.
    assert!(rise < 1e-5 * first && before < first, "{rise} {before}");
}

/// SimBenchmark's rolling case: a box of 10 kg is pushed with 150 N at 30° from y over ground with μ = 0.4.
/// Balls of 1 kg and 0.5 m roll on it (μ = 0.8). f₁ = μ(M + nm)g and f₂ = (F − f₁)/M/(7/(2m) + n/M); the box
/// has a = (F − f₁ − nf₂)/M, the balls f₂/m. The measure is the mean over time of the summed squares of the
/// velocity errors of one ball and of the box.
#[cfg(feature = "convex")]
#[test]
fn rolling_balls_follow_closed_form() {
    roll(2, (1e-3, 500));
}

/// Its 25 balls for 1.5 s; after that the first balls roll off the box.
#[cfg(feature = "convex")]
#[test]
#[ignore = "takes minutes: cargo test … --ignored full_size"]
fn rolling_balls_follow_closed_form_at_full_size() {
    for h in [1e-2, 4e-3, 1e-3] {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousand
        roll(5, (h, (1.5 / h) as usize));
    }
}

/// side² balls.
#[cfg(feature = "convex")]
fn roll(side: usize, (h, steps): (f64, usize)) {
    use std::ops::ControlFlow;

    use nalgebra::{Quaternion, UnitQuaternion};
    use robot_dynamics::simulation::{ConstantTorque, RunOptions};
    let (count, mass, push) = (side * side, 10.0, 150.0);
    let mut robot = balls(count, 1.0, 0.5);
    let size = [10.0, 10.0, 1.0];
    let of_box =
        MassProperties::solid_box(mass / (size[0] * size[1] * size[2]), Vector3::from(size)).unwrap();
    robot.links.push(LinkDescription::new("box", of_box));
    let at = Pose::from_translation([-20.0, 0.0, 0.0]);
    robot.joints.push(JointDescription::new("free_box", JointKind::Floating, "world", "box", at));
    robot.shapes.push(LinkShape::new("box", ShapeRole::Collision, Pose::IDENTITY, Shape::Box { size }));
    robot.shapes.iter_mut().for_each(|shape| shape.surface.friction[0] = 0.8);
    let model = Model::new(robot).unwrap();
    let contacts =
        ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.4)]).unwrap().with_links(&model);
    let middle = side as f64 - 1.0;
    let places: Vec<[f64; 3]> = (0..count)
        .map(|k| [2.0 * (k / side) as f64 - middle, 2.0 * (k % side) as f64 - middle, 1.5])
        .collect();
    let mut q = placed(&places);
    q.extend([20.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]);
    let direction = [0.5, 0.75_f64.sqrt()];
    let mut tau = vec![0.0; 6 * (count + 1)];
    (0..2).for_each(|k| tau[6 * count + k] = push * direction[k]);
    let n = count as f64;
    let ground = 0.4 * (mass + n) * G;
    let each = (push - ground) / mass / (3.5 + n / mass);
    let rates = [each, (push - ground - n * each) / mass];
    let (mut sum, mut seen) = (0.0, 0);
    let clock = std::time::Instant::now();
    crate::free_body::implicit_on(&model, contacts)
        .dt(h)
        .build()
        .unwrap()
        .run_steps_from(
            &q,
            &vec![0.0; 6 * (count + 1)],
            steps,
            RunOptions::new().sample_ends().controller(&mut ConstantTorque(tau)).observer(&mut |info| {
                for (body, rate) in [(0, rates[0]), (count, rates[1])] {
                    // Linear velocity in the axes of the body.
                    let turn = &info.q[7 * body + 3..7 * body + 7];
                    let turn =
                        UnitQuaternion::from_quaternion(Quaternion::new(turn[3], turn[0], turn[1], turn[2]));
                    let v = turn * Vector3::from_column_slice(&info.v[6 * body..6 * body + 3]);
                    let expected = Vector3::new(direction[0], direction[1], 0.0) * (rate * info.time);
                    sum += (v - expected).norm_squared();
                }
                seen += 1;
                ControlFlow::Continue(())
            }),
        )
        .unwrap();
    let error = sum / f64::from(seen);
    let (time, taken) = (h * steps as f64, clock.elapsed().as_secs_f64());
    println!(
        "rolling, {count} balls, {time} s, h = {h}: mean square of the velocities' errors {error:e} m²/s², {taken:.1} s of computing"
    );
    assert!(error < 1e-6, "{error}");
}
