//! The analytic A and B of implicit steps against central differences of the same steps.

use nalgebra::DVector;
use robot_dynamics::algorithms::mass_matrix;
use robot_dynamics::contact::Ground;
use robot_dynamics::derivatives::{LinearizationMethod, LinearizedStep, RobotState, linearize_stepper};
use robot_dynamics::description::{Base, Limits, Shape};
use robot_dynamics::model::{Model, difference, integrate, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};

use crate::free_body::body;

pub(crate) const H: f64 = 1e-3;

/// The larger increment of the differences \[rad, m, rad/s, m/s\].
const MOVE: f64 = 1e-5;

/// The comparison of one state.
struct Compared {
    method: LinearizationMethod,
    /// The columns whose difference quotients of both sides agree, and all columns.
    smooth: usize,
    columns: usize,
    /// The largest difference in those, and its row and column.
    off: (f64, usize, usize),
}

/// Compares A and B with central differences. Columns whose quotients of both sides differ have a transition
/// within the increment and are left out.
fn compare(
    model: &Model,
    stepper: &mut SimulationStepper,
    forces: &StepForces<'_>,
    state: RobotState<'_>,
) -> Compared {
    let (nv, nq) = (model.nv(), model.nq());
    let w = &mut StepWorkspace::new(model);
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let Ok(method) = linearize_stepper(model, stepper, w, forces, H, state, out) else {
        let method = LinearizationMethod::Analytic { at_transition: true };
        return Compared { method, smooth: 0, columns: 3 * nv, off: (0.0, 0, 0) };
    };
    let mut mass = vec![0.0; nv * nv];
    mass_matrix(model, w.dynamics(), state.q, &mut mass);
    let mut end = |column: usize, by: f64| {
        let (mut q, mut v, mut tau) = (vec![0.0; nq], state.v.to_vec(), forces.tau.to_vec());
        let mut way = vec![0.0; nv];
        match column / nv {
            0 => way[column] = by,
            1 => v[column - nv] += by,
            _ => tau[column - 2 * nv] += by,
        }
        integrate(model, state.q, &way, &mut q);
        let forces = StepForces::new(&tau, forces.dissipation);
        stepper.clone().step(model, w, &forces, H, &mut q, &mut v).unwrap();
        (q, v)
    };
    let middle = end(0, 0.0);
    let mut compared = Compared { method, smooth: 0, columns: 3 * nv, off: (0.0, 0, 0) };
    for column in 0..3 * nv {
        // A force changes the velocity of its coordinate about as much.
        let unit = if column < 2 * nv { 1.0 } else { mass[(column - 2 * nv) * (nv + 1)] / H };
        let mut quotient = |by: f64| {
            let end = end(column, by * unit);
            let mut way = vec![0.0; nv];
            difference(model, &middle.0, &end.0, &mut way);
            way.extend(end.1.iter().zip(&middle.1).map(|(end, middle)| end - middle));
            DVector::from_vec(way) / by
        };
        // The one-sided derivatives, without the error of first order.
        let [[after, after_far], [before, before_far]] = [1.0, -1.0].map(|sign| {
            let (near, far) = (quotient(0.5 * sign * MOVE), quotient(sign * MOVE));
            [&near * 2.0 - &far, far]
        });
        let own_error = (&after + &before - after_far - before_far) * 0.5;
        let size = after.amax().max(1.0);
        if (&after - &before).amax() > 1e-6 * size {
            continue;
        }
        compared.smooth += 1;
        for row in 0..2 * nv {
            let exact =
                if column < 2 * nv { a[row * 2 * nv + column] } else { b[row * nv + column - 2 * nv] * unit };
            let off = ((0.5 * (after[row] + before[row]) - exact).abs() - 2.0 * own_error[row].abs()) / size;
            if off > compared.off.0 {
                compared.off = (off, row, column);
            }
        }
    }
    compared
}

/// The robots of the comparison: the height of the base, and the scale of random torques.
fn cases() -> Vec<(String, Model, f64, f64)> {
    let shapes = [
        ("box", Shape::Box { size: [0.4, 0.3, 0.2] }),
        ("sphere", Shape::Sphere { radius: 0.1 }),
        ("capsule", Shape::Capsule { radius: 0.1, length: 0.3 }),
        ("cylinder", Shape::Cylinder { radius: 0.1, length: 0.3 }),
    ];
    let mut cases: Vec<_> = shapes
        .into_iter()
        .map(|(name, shape)| (name.to_owned(), Model::new(body(8e-3, shape)).unwrap(), 0.15, 0.5))
        .collect();
    let files = [
        ("panda.urdf", 0.0, 5.0),
        ("arm.xml", 0.0, 3.0),
        ("quadruped.xml", 0.4, 2.0),
        ("humanoid.urdf", 1.0, 5.0),
        ("gripper_and_box.xml", 0.0, 1.0),
    ];
    for (name, height, scale) in files {
        let path = format!("{}/../../robots/{name}", env!("CARGO_MANIFEST_DIR"));
        let mut robot = robot_dynamics::load(&path).unwrap().model.description().clone();
        if name == "humanoid.urdf" {
            robot.base = Base::Floating;
        }
        // Random torques would hold the joints at their stops.
        robot.joints.iter_mut().for_each(|joint| joint.limits = Limits::default());
        cases.push((name.to_owned(), Model::new(robot).unwrap(), height, scale));
    }
    cases
}

/// Robots that slide, roll, stick, bear on each other and move freely. Near a transition the differences mix
/// both sides, so a state counts if most of its columns are smooth.
///
/// The contact solver is accurate to about 1e-10 of the speeds, and the differences divide that by 5e-6.
#[test]
fn derivatives_are_those_of_differences() {
    let (mut compared, mut accurate) = (0_usize, 0_usize);
    for (name, model, height, scale) in &cases() {
        let (height, scale) = (*height, *scale);
        let mut builder = SimulationBuilder::new(model).method(Method::Implicit);
        if height > 0.0 && !name.contains("xml") {
            builder = builder.ground(Ground::level(0.0).with_friction(0.6));
        }
        let mut stepper = builder.build().unwrap().stepper();
        let mut random = SplitMix64::new(7);
        let (mut q, mut v) = (neutral(model), vec![0.0; model.nv()]);
        if height > 0.0 {
            q[2] = height;
            (v[0], v[1], v[5]) = (0.7, 0.2, 0.5);
        }
        let (mut tau, w) = (vec![0.0; model.nv()], &mut StepWorkspace::new(model));
        for step in 0..420 {
            if step % 40 == 0 {
                let first = if height > 0.0 && model.nv() > 6 { 6 } else { 0 };
                tau.iter_mut().skip(first).for_each(|tau| *tau = random.uniform(-scale, scale));
            }
            let forces = StepForces::new(&tau, true);
            if step % 70 == 69 {
                let Compared { method, smooth, columns, off: (off, row, column) } =
                    compare(model, &mut stepper, &forces, RobotState { q: &q, v: &v });
                if method == (LinearizationMethod::Analytic { at_transition: false }) && 2 * smooth > columns
                {
                    compared += 1;
                    accurate += usize::from(off < 1e-6);
                    assert!(off < 1e-4, "{name}, step {step}: {off:e} in row {row}, column {column}");
                }
            }
            stepper.step(model, w, &forces, H, &mut q, &mut v).unwrap();
        }
    }
    assert!(compared > 30 && 100 * accurate > 85 * compared, "{accurate} of {compared}");
}

/// A linearization leaves the stepper as it was.
#[test]
fn linearizing_does_not_change_the_steps() {
    let (_, model, height, _) = &cases()[0];
    let ground = Ground::level(0.0).with_friction(0.6);
    let simulation = SimulationBuilder::new(model).method(Method::Implicit).ground(ground).build().unwrap();
    let ends = [false, true].map(|linearizes| {
        let mut stepper = simulation.stepper();
        let (mut q, mut v, w) = (neutral(model), vec![0.3; 6], &mut StepWorkspace::new(model));
        q[2] = *height;
        let forces = StepForces::new(&[0.0; 6], true);
        for _ in 0..400 {
            if linearizes {
                let (mut a, mut b) = (vec![0.0; 144], vec![0.0; 72]);
                let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
                let state = RobotState { q: &q, v: &v };
                linearize_stepper(model, &mut stepper, w, &forces, H, state, out).unwrap();
            }
            stepper.step(model, w, &forces, H, &mut q, &mut v).unwrap();
        }
        (q, v)
    });
    assert_eq!(ends[0], ends[1]);
}

/// A ball that rolls without sliding takes over 5/7 of an impulse along the ground: v⁺ = v₀ + 5/7 h F/m. A
/// step is exact to first order in h.
#[test]
fn rolling_ball_takes_five_sevenths_of_a_push() {
    const RADIUS: f64 = 0.1;
    let model = Model::new(body(0.4 * RADIUS * RADIUS, Shape::Sphere { radius: RADIUS })).unwrap();
    let ground = Ground::level(0.0).with_friction(0.8);
    let simulation = SimulationBuilder::new(&model).method(Method::Implicit).ground(ground).build().unwrap();
    let (mut stepper, w) = (simulation.stepper(), &mut StepWorkspace::new(&model));
    let (mut q, mut v) = (neutral(&model), vec![0.0, 0.0, 0.0, 0.0, 0.3 / RADIUS, 0.0]);
    (q[2], v[0]) = (RADIUS, 0.3);
    let forces = StepForces::new(&[0.0; 6], true);
    for _ in 0..20 {
        stepper.step(&model, w, &forces, H, &mut q, &mut v).unwrap();
    }
    let (mut a, mut b) = (vec![0.0; 144], vec![0.0; 72]);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let method =
        linearize_stepper(&model, &mut stepper, w, &forces, H, RobotState { q: &q, v: &v }, out).unwrap();
    assert_eq!(method, LinearizationMethod::Analytic { at_transition: false });
    // The push acts along the ball's own x axis, which has turned by the angle of rolling.
    let turn: f64 = 2.0 * q[4].atan2(q[6]);
    let (along, across) = (b[6 * 6], b[8 * 6]);
    let speed = along * turn.cos() + across * turn.sin();
    let expected = 5.0 / 7.0 * H * turn.cos();
    assert!((speed - expected).abs() < 1e-2 * expected, "{speed} {expected}");
}
