//! Contact with height fields against half-spaces, closed forms and laws.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};

use nalgebra::Vector3;
use robot_dynamics::InvalidInput;
use robot_dynamics::contact::{ContactSet, Ground, HeightField};
use robot_dynamics::description::{Pose, Shape, Surface};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::RunOptions;

use crate::free_body::{body, implicit_on, run_on, soft_on};

const G: f64 = 9.81;

/// The corners of the mesh shapes.
const WEDGE: [[f64; 3]; 6] = [
    [0.1, 0.1, -0.05],
    [0.1, -0.1, -0.05],
    [-0.1, 0.1, -0.05],
    [-0.1, -0.1, -0.05],
    [0.0, 0.1, 0.1],
    [0.0, -0.1, 0.1],
];

fn set(model: &Model, grounds: &[Ground]) -> ContactSet {
    ContactSet::with_meshes(model, grounds, |_| Ok(WEDGE.to_vec())).unwrap()
}

/// Heights of a function of x and y.
fn field(
    [rows, columns]: [usize; 2],
    [x, y]: [f64; 2],
    height: impl FnMut((f64, f64)) -> f64,
) -> HeightField {
    let along = |at: usize, count: usize| 2.0 * at as f64 / (count - 1) as f64 - 1.0;
    let nodes = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let heights =
        nodes.map(|(row, column)| (x * along(column, columns), y * along(row, rows))).map(height).collect();
    HeightField::new(rows, columns, [x, y], heights).unwrap()
}

/// A valley along y whose sides rise by an angle.
fn valley(angle: f64) -> HeightField {
    field([4, 7], [1.0, 1.0], |(x, _)| x.abs() * angle.tan())
}

fn shapes() -> [(f64, Shape); 6] {
    [
        (4e-3, Shape::Sphere { radius: 0.1 }),
        (2e-3, Shape::Box { size: [0.2, 0.2, 0.1] }),
        (2e-3, Shape::Capsule { radius: 0.05, length: 0.2 }),
        (4e-3, Shape::Cylinder { radius: 0.1, length: 0.15 }),
        (4e-3, Shape::Ellipsoid { half_axes: [0.1, 0.12, 0.2] }),
        (2e-3, Shape::mesh("wedge")),
    ]
}

/// A random orientation at a position, and a random velocity.
fn thrown(seed: u64, at: [f64; 3]) -> ([f64; 7], [f64; 6]) {
    let mut random = SplitMix64::new(seed);
    let mut q = [at[0], at[1], at[2], 0.0, 0.0, 0.0, 1.0];
    (3..7).for_each(|k| q[k] = random.uniform(-1.0, 1.0));
    let norm = q[3..].iter().map(|q| q * q).sum::<f64>().sqrt();
    q[3..].iter_mut().for_each(|q| *q /= norm);
    (q, std::array::from_fn(|_| random.uniform(-2.0, 2.0)))
}

/// A flat field equals the half-space in every step, for every shape while it falls, tumbles and comes to
/// rest: its triangles form one face.
#[test]
fn flat_field_equals_half_space() {
    let flat = field([6, 9], [20.0, 15.0], |_| 0.1);
    for (moment, shape) in shapes() {
        let model = Model::new(body(moment, shape.clone())).unwrap();
        for seed in 0..3 {
            let (q, v) = thrown(seed, [0.3, -0.2, 0.6]);
            let mut states = Vec::new();
            run_on(&model, set(&model, &[Ground::level(0.1)]), (&q, &v), (1e-3, 1500), |info| {
                states.push((info.q.to_vec(), info.v.to_vec(), info.contact_forces[0]));
            });
            let mut states = states.into_iter();
            let on_field = set(&model, &[]).with_height_field(&flat).unwrap();
            let run = run_on(&model, on_field, (&q, &v), (1e-3, 1500), |info| {
                let (q, v, force) = states.next().unwrap();
                let off = q.iter().zip(info.q).chain(v.iter().zip(info.v));
                let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off <= 1e-12, "{shape:?}, {seed}, step {}: {off}", info.step);
                assert_eq!(force, info.contact_forces[0], "{shape:?}, {seed}, step {}", info.step);
            });
            assert!(run.losses.unwrap().impacts > 1.0, "{shape:?}, {seed}: it never touched");
        }
    }
}

/// A ball rolls down a tilted field with 5/7 g sin α, as on a half-space, across cells and triangles. The
/// field is tilted by its heights or by its pose.
#[test]
fn ball_rolls_down_tilted_field() {
    let (radius, angle) = (0.1, FRAC_PI_6);
    let model = Model::new(body(0.4 * radius * radius, Shape::Sphere { radius })).unwrap();
    let (sin, cos) = (-0.5 * angle).sin_cos();
    let q = [-radius * angle.sin(), 0.0, radius * angle.cos(), 0.0, sin, 0.0, cos];
    let by_heights = field([5, 30], [8.0, 2.0], |(x, _)| x * angle.tan());
    let tilted = Pose::from_xyz_rpy([0.0; 3], [0.0, -angle, 0.0]);
    let by_pose = field([5, 30], [8.0, 2.0], |_| 0.0).with_pose(tilted);
    for field in [by_heights, by_pose] {
        let contacts = set(&model, &[]).with_height_field(&field.with_friction(0.5)).unwrap();
        let run = run_on(&model, contacts, (&q, &[0.0; 6]), (1e-3, 1000), |_| {});
        let speed = Vector3::from_row_slice(&run.v[..3]).norm();
        // The error of the step on the half-space.
        assert!((speed - 5.0 / 7.0 * G * angle.sin()).abs() < 1e-3, "{speed}");
        assert!((speed - radius * run.v[4].abs()).abs() < 1e-9, "{:?}", run.v);
        let losses = run.losses.unwrap();
        // The step lifts the ball by micrometres, which decay.
        assert!(losses.sliding.abs() < 1e-9 && losses.impacts.abs() < 1e-5, "{losses:?}");
    }
}

/// A block slides down a tilted field with g (sin α − μ cos α), or sticks. μ comes from the two surfaces, or
/// from the field if it states one. Under both contact laws.
#[test]
fn block_slides_by_friction_of_surfaces() {
    let angle = FRAC_PI_6;
    let of = |friction: f64, priority: i32| {
        let mut surface = Surface::default();
        (surface.friction[0], surface.priority) = (friction, priority);
        surface
    };
    let (sin, cos) = (-0.5 * angle).sin_cos();
    let q = [-0.05 * angle.sin(), 0.0, 0.05 * angle.cos(), 0.0, sin, 0.0, cos];
    let flat = field([3, 3], [4.0, 2.0], |_| 0.0).with_pose(Pose::from_xyz_rpy([0.0; 3], [0.0, -angle, 0.0]));
    let tries = [
        (of(1.0, 0), flat.clone().with_surface(of(0.3, 1)), 0.3),
        (of(1.0, 0), flat.clone().with_surface(of(0.3, 0)), 1.0),
        (of(0.1, 0), flat.clone().with_surface(of(0.3, 0)), 0.3),
        (of(0.1, 1), flat.clone().with_surface(of(0.3, 0)), 0.1),
        (of(0.1, 0), flat.clone().with_surface(of(0.3, 1)).with_friction(0.2), 0.2),
    ];
    for (own, field, friction) in tries {
        let mut robot = body(2e-3, Shape::Box { size: [0.2, 0.2, 0.1] });
        robot.shapes[0].surface = own;
        let model = Model::new(robot).unwrap();
        let contacts = || ContactSet::new(&model, &[]).unwrap().with_height_field(&field).unwrap();
        let expected = (G * (angle.sin() - friction * angle.cos())).max(0.0);
        let speed = |v: &[f64]| Vector3::from_row_slice(&v[..3]).norm();
        let rigid = run_on(&model, contacts(), (&q, &[0.0; 6]), (1e-3, 500), |_| {});
        assert!((speed(&rigid.v) - 0.5 * expected).abs() < 1e-9, "{friction}: {:?}", rigid.v);
        let run = soft_on(&model, contacts(), 1e-3)
            .build()
            .unwrap()
            .run_steps_from(&q, &[0.0; 6], 500, RunOptions::new())
            .unwrap();
        // The block sinks at first, and creeps while it sticks.
        assert!((speed(&run.v) - 0.5 * expected).abs() < 2e-2, "{friction}, MuJoCo's law: {:?}", run.v);
    }
}

/// A ball rests in a valley on both sides: its centre is at the height R/cos β, and each side carries ½mg/cos
/// β. Under MuJoCo's law it sinks by the depth of that load.
#[test]
fn ball_rests_in_valley() {
    let radius = 0.1;
    let model = Model::new(body(0.4 * radius * radius, Shape::Sphere { radius })).unwrap();
    for angle in [0.3, FRAC_PI_6, FRAC_PI_4, 1.2] {
        let contacts = || set(&model, &[]).with_height_field(&valley(angle).with_friction(0.3)).unwrap();
        let high = radius / angle.cos();
        let q = [0.03, 0.05, high + 0.1, 0.0, 0.0, 0.0, 1.0];
        let mut simulation = implicit_on(&model, contacts()).build().unwrap();
        let end = simulation.run_steps_from(&q, &[0.0; 6], 6000, RunOptions::new().sample_ends()).unwrap();
        assert!(end.q[0].abs() < 1e-9 && (end.q[2] - high).abs() < 1e-9, "{angle}: {:?}", end.q);
        assert!(end.v.iter().all(|v| v.abs() < 1e-9), "{angle}: {:?}", end.v);
        let [x, y, z] = end.contact_forces[0];
        assert!(x.abs() < 1e-6 && y.abs() < 1e-6 && (z - G).abs() < 1e-6, "{angle}: {x} {y} {z}");

        let mut simulation = soft_on(&model, contacts(), 1e-3).build().unwrap();
        let end = simulation.run_steps_from(&q, &[0.0; 6], 6000, RunOptions::new().sample_ends()).unwrap();
        assert!((end.q[2] - high).abs() < 5e-3, "{angle}: {:?}", end.q);
    }
}

/// A brick with right-angled edges lies in a valley with sides of 45 degrees on two of its faces. Its lowest
/// corners are on both sides of the valley.
#[test]
fn brick_lies_in_valley() {
    let model = Model::new(body(2e-3, Shape::Box { size: [0.2, 0.3, 0.2] })).unwrap();
    let (sin, cos) = (0.5 * FRAC_PI_4).sin_cos();
    let high = 0.1 * 2.0_f64.sqrt();
    for lift in [0.0, 0.05] {
        let q = [0.0, 0.02, high + lift, 0.0, sin, 0.0, cos];
        let contacts = set(&model, &[]).with_height_field(&valley(FRAC_PI_4)).unwrap();
        let run = run_on(&model, contacts, (&q, &[0.0; 6]), (1e-3, 1000), |_| {});
        assert!((run.q[2] - high).abs() < 1e-9 && run.q[0].abs() < 1e-9, "{lift}: {:?}", run.q);
        assert!(run.v.iter().all(|v| v.abs() < 1e-9), "{lift}: {:?}", run.v);
        let [x, _, z] = run.contact_forces[0];
        assert!(x.abs() < 1e-6 && (z - G).abs() < 1e-6, "{lift}: {:?}", run.contact_forces);
    }
}

/// A body that slides off the end of the field falls freely from that step on; the previous contact force
/// does not persist.
#[test]
fn body_falls_beyond_field() {
    let mut robot = body(2e-3, Shape::mesh("tip"));
    robot.shapes[0].surface.condim = 1;
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::with_meshes(&model, &[], |_| Ok(vec![[0.0; 3]])).unwrap();
    let contacts = contacts.with_height_field(&field([3, 3], [0.5, 0.5], |_| 0.0)).unwrap();
    // It passes the end after 500.5 steps.
    let state = ([-0.0005, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let run = run_on(&model, contacts, (&state.0, &state.1), (1e-3, 600), |info| {
        assert!(info.step > 500 || info.v[2].abs() < 1e-12, "{:?}", info.v);
    });
    assert!((run.v[2] + G * 0.1).abs() < 1e-9, "{:?}", run.v);
    assert!((run.v[0] - 1.0).abs() < 1e-12, "{:?}", run.v);
}

/// A ball rolls over a ridge without a jump: it pivots about the edge as long as it is pressed on it.
#[test]
fn ball_rolls_over_ridge() {
    let radius = 0.1;
    let model = Model::new(body(0.4 * radius * radius, Shape::Sphere { radius })).unwrap();
    let angle: f64 = 0.2;
    let ridge = field([4, 5], [1.0, 1.0], |(x, _)| -x.abs() * angle.tan()).with_friction(1.0);
    let contacts = set(&model, &[]).with_height_field(&ridge).unwrap();
    let clear = contacts.clone();
    let (sin, cos) = (angle.sin(), angle.cos());
    // It rolls up one side with enough speed to reach the top and too little to leave it.
    let from = -0.06;
    let q = [from - radius * sin, 0.0, from * sin / cos + radius * cos, 0.0, 0.0, 0.0, 1.0];
    let speed = 0.55;
    let v = [speed * cos, 0.0, speed * sin, 0.0, speed / radius, 0.0];
    let (mut workspace, mut highest) = (Workspace::new(&model), 0.0_f64);
    let energy = |q: &[f64], v: &[f64]| {
        let squares = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        0.5 * (squares(&v[..3]) + 0.4 * radius * radius * squares(&v[3..])) + G * q[2]
    };
    let run = run_on(&model, contacts, (&q, &v), (1e-4, 4000), |info| {
        let gap = clear.clearance(&model, &mut workspace, info.q).unwrap();
        highest = highest.max(gap.abs());
    });
    // The error is h²v²/R a step in the curve, and it decays with a time constant of 0.1 s.
    assert!(highest < 1e-5, "{highest}");
    assert!(run.q[0] > 0.06, "it did not come over: {:?}", run.q);
    // Rolling loses no energy; of order 2.
    let lost = energy(&q, &v) - energy(&run.q, &run.v);
    assert!(lost.abs() < 1e-3, "{lost}");
}

/// Every shape falls on random bowl-shaped fields: none penetrates the field or gains energy, dissipation
/// never decreases, and the energy account closes.
#[test]
fn shapes_rest_on_random_fields() {
    for (moment, shape) in shapes() {
        let model = Model::new(body(moment, shape.clone())).unwrap();
        for seed in 0..3 {
            let mut random = SplitMix64::new(100 + seed);
            let field = field([9, 9], [2.0, 2.0], |(x, y)| 0.3 * (x * x + y * y) + random.uniform(0.0, 0.2))
                .with_friction(1.0);
            let contacts = set(&model, &[]).with_height_field(&field).unwrap();
            let clear = contacts.clone();
            let (q, v) = thrown(seed, [0.1, 0.1, 0.6]);
            let (mut deepest, mut lost, mut workspace) = (0.0_f64, 0.0, Workspace::new(&model));
            let run = run_on(&model, contacts, (&q, &v), (1e-3, 3000), |info| {
                deepest = deepest.min(clear.clearance(&model, &mut workspace, info.q).unwrap_or(0.0));
                let dissipated = info.energy_account.dissipated();
                assert!(dissipated >= lost, "{shape:?} {seed}: {dissipated} after {lost}");
                lost = dissipated;
            });
            let [x, y, z] = [run.q[0], run.q[1], run.q[2]];
            assert!(x.abs() < 2.0 && y.abs() < 2.0, "{shape:?} {seed}: it left the field");
            assert!(z > field.height(x, y).unwrap(), "{shape:?} {seed}: {:?} is below", run.q);
            assert!(deepest > -1e-6, "{shape:?} {seed}: {deepest} below the surface");
            assert!(
                run.energy_account.max_imbalance() < 0.05 * run.energy_account.scale(),
                "{shape:?} {seed}: {:?}",
                run.energy_account
            );
        }
    }
}

/// Each error of an invalid field names its quantity.
#[test]
fn invalid_fields_are_errors() {
    let model = Model::new(body(1e-3, Shape::Sphere { radius: 0.1 })).unwrap();
    for (rows, columns, half_size, heights) in [
        (1, 4, [1.0, 1.0], vec![0.0; 4]),
        (2, 2, [1.0, 0.0], vec![0.0; 4]),
        (2, 2, [f64::NAN, 1.0], vec![0.0; 4]),
        (2, 2, [1.0, 1.0], vec![0.0; 5]),
        (2, 2, [1.0, 1.0], vec![f64::INFINITY; 4]),
    ] {
        let error = HeightField::new(rows, columns, half_size, heights).unwrap_err();
        assert!(error.quantity.starts_with("a height field's "), "{error}");
    }
    let good = || HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4]).unwrap();
    let askew = Pose { rotation: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..Pose::IDENTITY };
    let mut slippery = Surface::default();
    slippery.friction[0] = f64::NAN;
    let refused = |field: &HeightField| set(&model, &[]).with_height_field(field).unwrap_err();
    let error = refused(&good().with_surface(slippery));
    assert_eq!(error.quantity, "a height field: its friction");
    let out_of_range =
        |quantity, value, requirement| InvalidInput::out_of_range(quantity, value, "", requirement);
    let friction = out_of_range("a coefficient of friction", -1.0, "finite and not negative");
    assert_eq!(refused(&good().with_friction(-1.0)), friction);
    let restitution = out_of_range("a coefficient of restitution", 2.0, "between 0 and 1");
    assert_eq!(refused(&good().with_restitution(2.0)), restitution);
    let error = refused(&good().with_pose(askew));
    assert!(error.quantity.starts_with("a height field's "), "{error}");
}
