//! The analytic A and B of implicit steps that an impact divides.

use nalgebra::DMatrix;
use robot_dynamics::contact::Ground;
use robot_dynamics::derivatives::{
    LinearizationMethod, LinearizedStep, LinearizedStepWithParameters, RobotState, linearize_stepper,
    linearize_stepper_with_parameters,
};
use robot_dynamics::description::{Limits, Shape, pendulum};
use robot_dynamics::model::{Model, difference, integrate, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};

use crate::free_body::body;
use crate::linearize_stepper::H;

/// A change of a velocity in one step that only an impact causes \[rad/s or m/s\].
const IMPACT: f64 = 0.3;

/// The steps of a motion from before an impact.
const STEPS: usize = 6;

/// The number of steps of the reference in one of these. Its impacts are resolved to 0.12 µs.
const FINER: usize = 512;

/// The displacement of the differences: 800 parts of steps of the reference at 1 m/s.
const MOVE: f64 = 1e-4;

type State = (Vec<f64>, Vec<f64>);

/// The end of a motion of these steps.
fn end_of(model: &Model, stepper: &SimulationStepper, (q, v): &State) -> State {
    let (mut stepper, w, still) = (stepper.clone(), &mut StepWorkspace::new(model), vec![0.0; model.nv()]);
    let (mut q, mut v, forces) = (q.clone(), v.clone(), StepForces::new(&still, true));
    for _ in 0..STEPS * FINER {
        stepper.step(model, w, &forces, H / FINER as f64, &mut q, &mut v).unwrap();
    }
    (q, v)
}

/// The derivative of the end of a motion by (δq₀, δv₀).
fn derivative_of(model: &Model, stepper: &SimulationStepper, (q, v): &State) -> DMatrix<f64> {
    let (mut stepper, w, nv) = (stepper.clone(), &mut StepWorkspace::new(model), model.nv());
    let still = vec![0.0; nv];
    let (mut q, mut v, forces) = (q.clone(), v.clone(), StepForces::new(&still, true));
    let mut product = DMatrix::identity(2 * nv, 2 * nv);
    for _ in 0..STEPS {
        let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        let state = RobotState { q: &q, v: &v };
        let method = linearize_stepper(model, &mut stepper, w, &forces, H, state, out).unwrap();
        assert_eq!(method, LinearizationMethod::Analytic { at_transition: false });
        product = DMatrix::from_row_slice(2 * nv, 2 * nv, &a) * product;
        stepper.step(model, w, &forces, H, &mut q, &mut v).unwrap();
    }
    product
}

/// Balls that fall on the ground with any spin, against differences of the motion in steps 512 times shorter.
/// The derivatives by the height contain the change of the time of the impact.
///
/// The time of an impact in a step of 1 ms is known to a part of it, 0.06 ms, or to half of a step in its
/// first part. In that time a ball turns by 0.003 rad, and the axes of its velocities with it. The
/// differences have an error of a thousandth.
#[test]
fn derivatives_through_impacts_are_those_of_finer_steps() {
    let shape = Shape::Sphere { radius: 0.1 };
    let model = &Model::new(body(8e-3, shape)).unwrap();
    let ground = Ground::level(0.0).with_friction(0.6);
    let simulation = SimulationBuilder::new(model).method(Method::Implicit).ground(ground).build().unwrap();
    let nv = model.nv();
    let w = &mut StepWorkspace::new(model);
    for fall in 0..6 {
        let mut random = SplitMix64::new(31 + fall);
        let (mut q, mut v, mut stepper) = (neutral(model), vec![0.0; nv], simulation.stepper());
        q[2] = random.uniform(0.15, 0.2);
        v.fill_with(|| random.uniform(-1.0, 1.0));
        let forces = StepForces::new(&[0.0; 6], true);
        let mut motion = Vec::new();
        loop {
            motion.push((stepper.clone(), (q.clone(), v.clone())));
            stepper.step(model, w, &forces, H, &mut q, &mut v).unwrap();
            let before = &motion[motion.len() - 1].1.1;
            if before.iter().zip(&v).any(|(before, after)| (after - before).abs() > IMPACT) {
                break;
            }
        }
        let (stepper, start) = &motion[motion.len() - 3];
        let derivative = derivative_of(model, stepper, start);
        for column in 0..2 * nv {
            let ends = [MOVE, -MOVE].map(|by| {
                let (mut way, mut from) = (vec![0.0; nv], start.clone());
                if column < nv {
                    way[column] = by;
                    integrate(model, &start.0, &way, &mut from.0);
                } else {
                    from.1[column - nv] += by;
                }
                end_of(model, stepper, &from)
            });
            let mut way = vec![0.0; nv];
            difference(model, &ends[1].0, &ends[0].0, &mut way);
            way.extend(ends[0].1.iter().zip(&ends[1].1).map(|(after, before)| after - before));
            let size = derivative.column(column).amax().max(1.0);
            let off = (0..2 * nv)
                .map(|row| (derivative[(row, column)] - way[row] / (2.0 * MOVE)).abs() / size)
                .fold(0.0, f64::max);
            assert!(off < 0.03, "{fall}, column {column}: {off}");
        }
    }
}

/// A ball that falls on the ground and rolls on keeps 5/7 of its velocity along the ground, v_x⁺ = 5/7 v_x
/// without rotation. One that slides has v_x⁺ = v_x + μ v_z. With the time t = z/|v_z| of the impact,
/// x⁺ = x + v_x t + v_x⁺ (h − t). Gravity adds g h to v_z.
///
/// Velocities are along the ball's own axes, which turn by 0.002 rad after the impact. The tolerance is a few
/// times the square of that angle, and g h of the speed for times.
#[test]
fn falling_ball_keeps_its_velocity_along_the_ground() {
    const RADIUS: f64 = 0.1;
    let model = Model::new(body(0.4 * RADIUS * RADIUS, Shape::Sphere { radius: RADIUS })).unwrap();
    let mass = model.mass();
    for (friction, by_along, by_down) in [(0.8, 5.0 / 7.0, 0.0), (0.1, 1.0, 0.1)] {
        let ground = Ground::level(0.0).with_friction(friction);
        let simulation =
            SimulationBuilder::new(&model).method(Method::Implicit).ground(ground).build().unwrap();
        let (mut stepper, w) = (simulation.stepper(), &mut StepWorkspace::new(&model));
        // It hits the ground after 0.42 steps.
        let (mut q, v) = (neutral(&model), [0.5, 0.0, -1.0, 0.0, 0.0, 0.0]);
        q[2] = RADIUS + 0.42 * H;
        let (mut a, mut b, mut by_friction) = ([0.0; 144], [0.0; 72], [0.0; 12]);
        let step = LinearizedStep { by_state: &mut a, by_force: &mut b };
        let (by_control, by_inertial) = (&mut [], &mut []);
        let out =
            LinearizedStepWithParameters { step, by_control, by_inertial, by_friction: &mut by_friction };
        let (forces, state) = (StepForces::new(&[0.0; 6], true), RobotState { q: &q, v: &v });
        linearize_stepper_with_parameters(&model, &mut stepper, w, &forces, H, state, out).unwrap();
        let (mut q1, mut v1) = (q, v);
        stepper.step(&model, w, &forces, H, &mut q1, &mut v1).unwrap();
        let turn = 2.0 * q1[4].atan2(q1[6]);
        let (cos, sin) = (turn.cos(), turn.sin());
        // ∂(x, z, ẋ, ż)⁺ in the world.
        let by = |column: usize| {
            let a = |row: usize| a[row * 12 + column];
            let along = cos * a(6) + sin * a(8) + a(4) * (cos * v1[2] - sin * v1[0]);
            let up = cos * a(8) - sin * a(6) - a(4) * (cos * v1[0] + sin * v1[2]);
            [cos * a(0) + sin * a(2), cos * a(2) - sin * a(0), along, up]
        };
        let lost = 0.5 - 0.5 * by_along + by_down;
        let exact = [
            (by(0), [1.0, 0.0, 0.0, 0.0]),
            (by(2), [lost, 0.0, 0.0, 0.0]),
            (by(6), [0.42 * H + 0.58 * H * by_along, 0.0, by_along, 0.0]),
            (by(8), [(0.42 * lost + 0.58 * by_down) * H, 0.0, by_down, 0.0]),
        ];
        for (column, (by, exact)) in exact.into_iter().enumerate() {
            let off = by.iter().zip(exact).map(|(by, exact)| (by - exact).abs()).fold(0.0, f64::max);
            assert!(off < 2e-5 + 9.81 * H * lost, "{friction}, {column}: {by:?} {exact:?}");
        }
        let off = [
            b[6 * 6] - by_along * H / mass,
            b[6 * 6 + 2] - by_down * H / mass,
            // It loses μ (|v_z| + g h) while it slides.
            by_friction[6] + if by_down > 0.0 { 1.0 + 9.81 * H } else { 0.0 },
        ];
        assert!(off.iter().all(|off| off.abs() < 9.81 * H * lost), "{friction}: {off:?}");
    }
}

/// A pendulum without gravity that meets its stop stays there, wherever in the step it meets it.
#[test]
fn stop_keeps_its_position() {
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0; 3];
    robot.joints[0].limits = Limits::new(-1.0, 0.1);
    let model = Model::new(robot).unwrap();
    let mut stepper = SimulationBuilder::new(&model).method(Method::Implicit).build().unwrap().into_stepper();
    let w = &mut StepWorkspace::new(&model);
    for k in 0..16 {
        let (q, v) = ([0.1 - H * (f64::from(k) + 0.5) / 17.0], [1.0]);
        let (mut a, mut b) = (vec![0.0; 4], vec![0.0; 2]);
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        let (forces, state) = (StepForces::new(&[0.0], true), RobotState { q: &q, v: &v });
        let method = linearize_stepper(&model, &mut stepper, w, &forces, H, state, out).unwrap();
        assert!(matches!(method, LinearizationMethod::Analytic { .. }));
        assert!(a.iter().all(|x| x.abs() < 1e-9), "{k}: {a:?}");
    }
}
