//! Inverse dynamics under constraints with dependent rows: against virtual work, and against the torque that
//! caused the motion.

use std::error::Error;

use nalgebra::{DVector, Matrix3, Rotation3, Vector3};
use robot_dynamics::algorithms::{frame_pose, inverse_dynamics};
use robot_dynamics::constraints::{
    ConstrainedTorque, ConstraintOptions, ConstraintSet, FrameConstraint, NoSlip, Plane, RedundantRows,
    RollingDisc, RollingRow, SpatialAxis, constrained_forward_dynamics, constrained_inverse_dynamics,
    constraint_projections, project_velocity,
};
use robot_dynamics::description::{
    Base, FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose,
    RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

type Tested = Result<(), Box<dyn Error>>;

/// Crank, coupler, rocker and ground of a four-bar linkage \[m\], times a scale.
const LENGTHS: [f64; 4] = [0.2, 0.5, 0.4, 0.5];

/// A four-bar linkage in a rotated plane far from the origin, with a ball joint at its open corner, and a
/// separate driven pendulum.
fn linkage(scale: f64, turn: &Rotation3<f64>, away: [f64; 3]) -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("four_bar");
    for name in ["world", "base"] {
        robot.links.push(LinkDescription::new(name, None));
    }
    let mut plane = Pose::from_translation(away);
    plane.rotation = std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)]));
    robot.joints.push(JointDescription::new("mount", JointKind::Fixed, "world", "base", plane));
    let bars = [
        ("crank", "base", 0.0, LENGTHS[0]),
        ("coupler", "crank", LENGTHS[0], LENGTHS[1]),
        ("rocker", "base", LENGTHS[3], LENGTHS[2]),
        ("pendulum", "base", 0.0, 0.3),
    ];
    for (name, parent, at, length) in bars {
        let length = length * scale;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) * (length.powi(3) / 12.0);
        let rod = MassProperties::new(length, Vector3::new(length / 2.0, 0.0, 0.0), inertia)?;
        robot.links.push(LinkDescription::new(name, rod));
        let hinge = JointKind::Continuous { axis: [0.0, -1.0, 0.0] };
        let place = Pose::from_translation([at * scale, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("{name}_joint"), hinge, parent, name, place));
        let end = Pose::from_translation([length, 0.0, 0.0]);
        robot.frames.push(FrameDescription::new(format!("{name}_end"), name, end));
    }
    Ok(Model::new(robot)?)
}

/// The joint angles of the linkage for an angle of the crank, from two triangles: crank, coupler relative to
/// the crank, rocker, pendulum.
fn closed(crank: f64) -> [f64; 4] {
    let [a, b, c, g] = LENGTHS;
    let (x, z) = (a * crank.cos() - g, a * crank.sin());
    let (across, direction) = (x.hypot(z), z.atan2(x));
    let inner = ((across * across + c * c - b * b) / (2.0 * across * c)).acos();
    let rocker = direction - inner;
    let (dx, dz) = (g + c * rocker.cos() - a * crank.cos(), c * rocker.sin() - a * crank.sin());
    [crank, dz.atan2(dx) - crank, rocker, 0.4]
}

/// Rates of the joints for a crank at 1 rad/s: the distance between the ends of the coupler is constant.
fn rates(q: &[f64; 4]) -> [f64; 4] {
    let [a, b, c, _] = LENGTHS;
    let coupler = q[0] + q[1];
    let rocker = a * (q[0] - coupler).sin() / (c * (q[2] - coupler).sin());
    let turn = a * (q[2] - q[0]).sin() / (b * (coupler - q[2]).sin());
    [1.0, turn - 1.0, rocker, 0.0]
}

fn close_corner(model: &Model, rows: &[SpatialAxis]) -> Result<ConstraintSet, Box<dyn Error>> {
    let (coupler, rocker) = (model.frame_named("coupler_end")?, model.frame_named("rocker_end")?);
    Ok(ConstraintSet::new(model, [("corner", FrameConstraint::between(coupler, rocker, rows).into())])?)
}

/// The torque of the crank is that of virtual work, τ₁ = (M a + C v + g)·v for v with v₁ = 1. Any rows may
/// close the corner. The torque of the pendulum is that of the tree.
///
/// Tolerance 1e-10 of the forces: κ(A) is below 1e3, and at ten metres levers of 1 mm have twelve digits.
#[test]
fn crank_torque_is_virtual_work() -> Tested {
    use SpatialAxis::{Rx, Rz, X, Y, Z};
    let sets: [&[SpatialAxis]; 4] = [&[X, Z], &[X, Y, Z], &[X, Y, Z, Rx, Rz], &[Y, X, Rz, Z]];
    let random = &mut SplitMix64::new(5);
    for scale in [0.005, 1.0, 100.0] {
        for away in [0.0, 10.0] {
            let turn = Rotation3::from_euler_angles(
                random.uniform(-3.0, 3.0),
                random.uniform(-1.5, 1.5),
                random.uniform(-3.0, 3.0),
            );
            let model = linkage(scale, &turn, [away, -away, 0.3 * away])?;
            let w = &mut Workspace::new(&model);
            let q = closed(random.uniform(0.5, 2.5));
            let rate = rates(&q);
            let v: Vec<f64> = rate.iter().map(|x| 3.0 * x).collect();
            let a: Vec<f64> = (0..4).map(|_| random.uniform(-2.0, 2.0)).collect();
            let mut force = [0.0; 4];
            inverse_dynamics(&model, w, &q, &v, &a, &mut force);
            let largest = force.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            let expected: f64 = force.iter().zip(&rate).map(|(f, v)| f * v).sum();
            for rows in sets {
                let set = close_corner(&model, rows)?;
                let gap = set.rows(&model, w, &q, &v).position_error.amax();
                assert!(gap < 1e-12 * (scale + away), "{gap}");
                let motors = [true, false, false, true];
                let found = constrained_inverse_dynamics(&model, w, &set, &q, &v, &a, &motors)?;
                let place = format!("{rows:?}, scale {scale}, at {away}: {found:?}, {expected}");
                assert!((found.tau[0] - expected).abs() < 1e-10 * largest, "{place}");
                assert!((found.tau[3] - force[3]).abs() < 1e-10 * largest, "{place}");
                assert!(found.residual < 1e-10 * largest, "{place}");
                // A pin transmits torques by levers of the links, a few times the forces of this motion.
                assert!(found.multipliers.amax() < 100.0 * largest / scale.min(1.0), "{place}");
                // The motor of the pendulum acts on no loop: the linkage's own forces remain, the least of
                // them.
                let idle =
                    constrained_inverse_dynamics(&model, w, &set, &q, &v, &a, &[false, false, false, true])?;
                assert!((idle.tau[3] - force[3]).abs() < 1e-10 * largest, "{place}");
                let along: f64 = rate.iter().map(|x| x * x).sum();
                let left = rate.map(|x| x * expected / along);
                let largest_left = left.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                assert!((idle.residual - largest_left).abs() < 1e-10 * largest, "{place}: {idle:?}");
            }
        }
    }
    Ok(())
}

/// The torque of a motion that a known torque caused. It is equal for all velocities that the constraints
/// allow, acts on motors only, and is the shortest of its kind: τ·(τ₀ − τ) = 0, a property of projections.
fn check_made_motion(
    model: &Model,
    set: &ConstraintSet,
    q: &[f64],
    v: &[f64],
    motors: &[bool],
    random: &mut SplitMix64,
) -> Result<ConstrainedTorque, Box<dyn Error>> {
    let (w, options) = (&mut Workspace::new(model), ConstraintOptions::default());
    let drive = DVector::from_fn(model.nv(), |k, _| if motors[k] { random.uniform(-1.0, 1.0) } else { 0.0 });
    let motion = constrained_forward_dynamics(model, w, set, &options, q, v, drive.as_slice())?;
    let found = constrained_inverse_dynamics(model, w, set, q, v, motion.acceleration.as_slice(), motors)?;
    let allowed = constraint_projections(model, w, set, &options, q)?.velocity;
    let mut force = vec![0.0; model.nv()];
    inverse_dynamics(model, w, q, v, motion.acceleration.as_slice(), &mut force);
    // Products of numbers of this size lose κ(M) κ(A) of them, below 1e6 here.
    let size = DVector::from_vec(force).amax().max(1.0);
    assert!(found.residual < 1e-9 * size, "{found:?}");
    let other = allowed.tr_mul(&(&drive - &found.tau)).amax();
    assert!(other < 1e-9 * size, "{other} of {size}: {found:?}");
    let longer = found.tau.dot(&(&drive - &found.tau));
    assert!(longer.abs() < 1e-9 * size * size, "{longer}: {found:?} {drive}");
    assert!((0..model.nv()).all(|k| motors[k] || found.tau[k] == 0.0), "{found:?}");
    Ok(found)
}

/// Soles with three and four corners carry loads as welds do: the same torque and the same forces on every
/// coordinate. At each corner the force is at most the moment of the weld over the levers.
#[test]
fn soles_at_corners_match_welds() -> Tested {
    let random = &mut SplitMix64::new(23);
    for seed in 0..12 {
        let options = RandomRobotOptions { base: Base::Floating, joints: 8, ..RandomRobotOptions::default() };
        let mut robot = random_robot(seed, &options);
        let soles: Vec<String> = robot.links.iter().rev().take(2).map(|link| link.name.clone()).collect();
        for link in &soles {
            for k in 0..4 {
                let corner = [[0.1, 0.05], [-0.1, 0.05], [-0.1, -0.05], [0.1, -0.05]][k];
                let at = Pose::from_translation([corner[0], corner[1], 0.02]);
                robot.frames.push(FrameDescription::new(format!("{link} corner {k}"), link, at));
            }
        }
        let model = Model::new(robot)?;
        let w = &mut Workspace::new(&model);
        let q = random_state(&model, random).q;
        let corners = |count: usize| {
            let balls = soles.iter().flat_map(|link| (0..count).map(move |k| format!("{link} corner {k}")));
            let balls = balls.map(|name| {
                let frame = model.frame_named(&name).expect("a corner");
                let place = frame_pose(&model, &mut Workspace::new(&model), &q, frame).translation;
                (name, FrameConstraint::point_contact(frame, place).into())
            });
            ConstraintSet::new(&model, balls.collect::<Vec<_>>())
        };
        let welds = soles.iter().map(|link| {
            let frame = model.frame_named(link).expect("a sole");
            let place = frame_pose(&model, &mut Workspace::new(&model), &q, frame);
            (link.clone(), FrameConstraint::contact(frame, place, &FrameConstraint::WELD).into())
        });
        let weld = ConstraintSet::new(&model, welds.collect::<Vec<_>>())?;
        let mut v: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
        project_velocity(&model, w, &weld, &ConstraintOptions::default(), &q, &mut v)?;
        let motors: Vec<bool> = (0..model.nv()).map(|k| k >= 6).collect();
        let from = random.clone();
        let expected = check_made_motion(&model, &weld, &q, &v, &motors, &mut from.clone())?;
        for count in [3, 4] {
            let set = corners(count)?;
            let found = check_made_motion(&model, &set, &q, &v, &motors, &mut from.clone())?;
            let size = expected.tau.amax().max(expected.multipliers.amax()).max(1.0);
            assert!(
                (&found.tau - &expected.tau).amax() < 1e-8 * size,
                "{seed} {count}: {found:?} {expected:?}"
            );
            let force = |set: &ConstraintSet, torque: &ConstrainedTorque| {
                set.rows(&model, &mut Workspace::new(&model), &q, &v).matrix.tr_mul(&torque.multipliers)
            };
            let (corners, welds) = (force(&set, &found), force(&weld, &expected));
            assert!((&corners - &welds).amax() < 1e-8 * size, "{seed} {count}: {corners} {welds}");
            // Levers of 0.1 m: moments become forces of ten times their value.
            assert!(found.multipliers.amax() < 100.0 * size, "{seed} {count}: {found:?}");
        }
    }
    Ok(())
}

/// Two driven wheels on one axle roll without slip: their sideways rows are equal.
#[test]
fn wheels_on_one_axle_share_side_force() -> Tested {
    let (radius, half_track) = (0.1, 0.25);
    let mut robot = RobotDescription::new("cart");
    robot.base = Base::Floating;
    let body = MassProperties::solid_box(400.0, Vector3::new(0.4, 0.3, 0.1))?;
    robot.links.push(LinkDescription::new("body", body));
    let wheels = ["left", "right"];
    for (name, y) in wheels.into_iter().zip([half_track, -half_track]) {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25)) * (radius * radius);
        robot.links.push(LinkDescription::new(name, MassProperties::new(1.0, Vector3::zeros(), inertia)?));
        let axle = JointKind::Continuous { axis: [0.0, 1.0, 0.0] };
        let at = Pose::from_translation([0.0, y, 0.0]);
        robot.joints.push(JointDescription::new(format!("{name}_axle"), axle, "body", name, at));
    }
    robot.frames.push(FrameDescription::new("caster", "body", Pose::from_translation([0.3, 0.0, -0.05])));
    let model = Model::new(robot)?;
    let disc = |name: &str, rows: Vec<RollingRow>| {
        let frame = model.frame(name).expect("a wheel");
        RollingDisc { frame, axle: [0.0, 1.0, 0.0], radius, plane: Plane::level(0.0), rows }
    };
    let all = vec![RollingRow::Forward, RollingRow::Side, RollingRow::Normal];
    let caster = NoSlip { frame: model.frame_named("caster")?, rows: vec![SpatialAxis::Z] };
    let set = ConstraintSet::new(
        &model,
        [
            ("left", disc("left", all.clone()).into()),
            ("right", disc("right", all).into()),
            ("caster", caster.into()),
        ],
    )?;
    let random = &mut SplitMix64::new(7);
    for _ in 0..20 {
        let yaw = random.uniform(-3.0, 3.0) / 2.0;
        let q = [
            random.uniform(-5.0, 5.0),
            random.uniform(-5.0, 5.0),
            radius,
            0.0,
            0.0,
            yaw.sin(),
            yaw.cos(),
            0.3,
            -2.0,
        ];
        let mut v: Vec<f64> = (0..8).map(|_| random.uniform(-2.0, 2.0)).collect();
        project_velocity(
            &model,
            &mut Workspace::new(&model),
            &set,
            &ConstraintOptions::default(),
            &q,
            &mut v,
        )?;
        let motors: Vec<bool> = (0..8).map(|k| k >= 6).collect();
        let found = check_made_motion(&model, &set, &q, &v, &motors, random)?;
        // The wheels and the caster carry the weight, and both sides share the force that turns the cart
        // equally.
        let down: f64 = [2, 5, 6].into_iter().map(|k| found.multipliers[k]).sum();
        let weight = model.mass() * 9.81;
        assert!((down - weight).abs() < 1e-9 * weight, "{down} {weight}");
        assert!((found.multipliers[1] - found.multipliers[4]).abs() < 1e-9 * weight, "{found:?}");
        assert!(found.multipliers.amax() < 10.0 * weight, "{found:?}");
    }
    Ok(())
}

/// Duplicate rows, also in other units: torque and residual are unchanged, and the shortest λ is that of
/// `RedundantRows::Proximal`.
#[test]
fn duplicate_rows_share_force() -> Tested {
    let random = &mut SplitMix64::new(31);
    for seed in 0..10 {
        let options = RandomRobotOptions { base: Base::Floating, joints: 6, ..RandomRobotOptions::default() };
        let model = Model::new(random_robot(seed, &options))?;
        let w = &mut Workspace::new(&model);
        let q = random_state(&model, random).q;
        let frame = model.frame_named(&model.description().links.last().expect("a link").name.clone())?;
        let place = frame_pose(&model, w, &q, frame);
        let weld = FrameConstraint::contact(frame, place, &FrameConstraint::WELD);
        let ball = FrameConstraint::point_contact(frame, place.translation);
        let once = ConstraintSet::new(&model, [("weld", weld.clone().into())])?;
        let twice = ConstraintSet::new(&model, [("weld", weld.into()), ("ball", ball.into())])?;
        let rest = vec![0.0; model.nv()];
        let motors: Vec<bool> = (0..model.nv()).map(|k| k >= 6).collect();
        let drive: Vec<f64> =
            motors.iter().map(|&motor| if motor { random.uniform(-1.0, 1.0) } else { 0.0 }).collect();
        let redundant = RedundantRows::Proximal { damping: 1e-6 };
        let options = ConstraintOptions { redundant, ..ConstraintOptions::default() };
        let motion = constrained_forward_dynamics(&model, w, &twice, &options, &q, &rest, &drive)?;
        let a = motion.acceleration.as_slice();
        let one = constrained_inverse_dynamics(&model, w, &once, &q, &rest, a, &motors)?;
        let two = constrained_inverse_dynamics(&model, w, &twice, &q, &rest, a, &motors)?;
        let size = one.multipliers.amax().max(1.0);
        assert!((&one.tau - &two.tau).amax() < 1e-9 * size, "{one:?} {two:?}");
        // A floating tree held at one point: motors cause no internal load, so the forces are those of the
        // motion.
        assert!((&two.multipliers - &motion.multipliers).amax() < 1e-6 * size, "{two:?} {motion:?}");
        for k in 0..3 {
            assert!((two.multipliers[k] - 0.5 * one.multipliers[k]).abs() < 1e-9 * size, "{one:?} {two:?}");
        }
    }
    Ok(())
}
