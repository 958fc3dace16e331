//! The operational space against what forces and accelerations at a frame do, and controls that follow.

mod common;

use std::error::Error;
use std::ops::ControlFlow;

use common::{Family, families};
use dynamics::{Integrator, SplitMix64};
use multibody::{
    ClosureRow, ComputedTorque, JointKinds, Model, OperationalSpaceError, RandomRobotOptions, Reference,
    Simulation, TaskControl, TaskGains, TaskReference, Workspace, forward_dynamics,
    frame_classical_acceleration_world_aligned, frame_pose, frame_velocity_world_aligned, operational_space,
    random_robot, random_state,
};
use nalgebra::{DMatrix, DVector};

type Tested = Result<(), Box<dyn Error>>;

const ROWS: [ClosureRow; 6] =
    [ClosureRow::X, ClosureRow::Y, ClosureRow::Z, ClosureRow::Rx, ClosureRow::Ry, ClosureRow::Rz];

/// On random trees: the torque asked for gives the frame its acceleration, torques of the null space give it none,
/// J J̄ = 1, and Λ is the inverse of what unit forces do.
#[test]
fn laws_on_random_trees() {
    let mut tested = 0;
    for robot in families().iter().flat_map(|family: &Family| family.robots().take(12)) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let (q, v) = (&robot.state.q[..], &robot.state.v[..]);
        let random = &mut SplitMix64::new(robot.seed);
        let frame = model.frames().last().and_then(|frame| model.frame(&frame.name)).expect("a frame");
        let rows: Vec<ClosureRow> =
            ROWS.into_iter().filter(|_| random.uniform(0.0, 1.0) < 0.4).take(model.nv()).collect();
        if rows.is_empty() {
            continue;
        }
        let Ok(space) = operational_space(model, w, q, v, frame, &rows) else { continue };
        let eigen = space.inertia.clone().symmetric_eigenvalues();
        let condition = robot.condition() * eigen.max() / eigen.min();
        if condition > 1e8 {
            continue;
        }
        tested += 1;
        let rounding = 1e3 * condition * f64::EPSILON;
        let pick = |twist: multibody::Twist| {
            let all = [twist.linear, twist.angular].concat();
            DVector::from_iterator(rows.len(), rows.iter().map(|row| all[*row as usize]))
        };
        let accelerate = |w: &mut Workspace, tau: &[f64]| {
            let mut a = vec![0.0; model.nv()];
            forward_dynamics(model, w, q, v, tau, &mut a);
            let size = a.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            (pick(frame_classical_acceleration_world_aligned(model, w, q, v, &a, frame)), size)
        };
        let wanted = DVector::from_fn(rows.len(), |_, _| random.uniform(-3.0, 3.0));
        let tau = space.torque(wanted.as_slice()).unwrap();
        let (found, size) = accelerate(w, tau.as_slice());
        let scale = 1.0 + size + space.bias_acceleration.amax();
        robot.require("ẍ", (&found - &wanted).amax(), rounding * scale);
        let more = &tau + space.null_torque(&robot.state.tau).unwrap();
        let (again, size) = accelerate(w, more.as_slice());
        robot.require("null space", (&again - &wanted).amax(), rounding * (scale + size));
        let one = &space.jacobian * &space.consistent_inverse - DMatrix::identity(rows.len(), rows.len());
        robot.require("J J̄ = 1", one.amax(), rounding * (1.0 + space.consistent_inverse.amax()));
        // Column k of Λ⁻¹ is what the force Jᵀe_k adds to the frame's acceleration.
        for k in 0..rows.len() {
            let push = space.jacobian.row(k).transpose();
            let (pushed, size) = accelerate(w, (&tau + &push).as_slice());
            let force = &space.inertia * (pushed - &found);
            let unit = DVector::from_fn(rows.len(), |i, _| f64::from(u8::from(i == k)));
            robot.require("Λ", (force - unit).amax(), rounding * (1.0 + eigen.max() * (scale + size)));
        }
    }
    assert!(tested > 60, "{tested}");
}

fn arm() -> Result<Model, Box<dyn Error>> {
    let options = RandomRobotOptions {
        joints: 6,
        chain: 1.0,
        kinds: JointKinds::Turning,
        passive: 0.0,
        massless: 0.0,
        ..RandomRobotOptions::default()
    };
    Ok(Model::new(random_robot(4, &options))?)
}

/// Computed torque: the error of every joint obeys ë + 2k ė + k² e = 0, e(t) = (e₀ + (ė₀ + k e₀) t) e^(−kt).
///
/// The torque is held over each step of h, which delays it by ½h on average: the error is off by O(h).
#[test]
fn computed_torque_has_linear_errors() -> Tested {
    let model = arm()?;
    let nv = model.nv();
    let reference = |t: f64| {
        let each = |f: &dyn Fn(f64) -> f64| (0..nv).map(|k| f(k as f64)).collect::<Vec<f64>>();
        Reference { q: each(&|k| (t + k).sin()), v: each(&|k| (t + k).cos()), a: each(&|k| -(t + k).sin()) }
    };
    let (rate, time) = (6.0, 0.5);
    let start = reference(0.0);
    let q: Vec<f64> = start.q.iter().map(|q| q - 0.2).collect();
    let mut off = Vec::new();
    for steps in [500, 2000] {
        let h = time / steps as f64;
        let mut control =
            ComputedTorque::new(&model, reference, &vec![rate * rate; nv], &vec![2.0 * rate; nv])?;
        let simulation = Simulation {
            model: &model,
            integrator: Integrator::RungeKutta4,
            step: h,
            dissipation: false,
            sample_every: 0,
        };
        let run = simulation.run(&q, &start.v, steps, &mut control, |_| ControlFlow::Continue(()))?;
        let expected = 0.2 * (1.0 + rate * time) * f64::exp(-rate * time);
        let end = reference(time);
        let worst = (0..nv).map(|k| (end.q[k] - run.q[k] - expected).abs()).fold(0.0, f64::max);
        off.push(worst);
    }
    println!("{off:?}");
    assert!(off[0] < 2e-3 && off[1] < 0.3 * off[0], "{off:?}");
    Ok(())
}

/// A frame's position comes to rest where it should, by the same law.
#[test]
fn task_control_has_linear_errors() -> Tested {
    let model = arm()?;
    let frame = model.frames().last().and_then(|frame| model.frame(&frame.name)).ok_or("no frame")?;
    let w = &mut Workspace::new(&model);
    let q = random_state(&model, &mut SplitMix64::new(8)).q;
    let v = vec![0.0; model.nv()];
    let x = frame_pose(&model, w, &q, frame).translation;
    let target = [x[0] + 0.05, x[1] - 0.03, x[2] + 0.02];
    let (rate, time, steps) = (8.0, 0.4, 2000);
    let h = time / steps as f64;
    let reference = |_| TaskReference { position: target, velocity: [0.0; 3], acceleration: [0.0; 3] };
    let gains = TaskGains { stiffness: rate * rate, damping: 2.0 * rate, null_damping: 5.0 };
    let mut control = TaskControl::new(&model, frame, reference, gains)?;
    let simulation = Simulation {
        model: &model,
        integrator: Integrator::RungeKutta4,
        step: h,
        dissipation: false,
        sample_every: 0,
    };
    let run = simulation.run(&q, &v, steps, &mut control, |_| ControlFlow::Continue(()))?;
    let found = frame_pose(&model, w, &run.q, frame).translation;
    let decay = (1.0 + rate * time) * f64::exp(-rate * time);
    for k in 0..3 {
        let expected = target[k] + (x[k] - target[k]) * decay;
        // The held torque delays by ½h: O(h) of the path of 5 cm.
        assert!((found[k] - expected).abs() < 1e-4, "{k}: {} {expected}", found[k]);
    }
    assert!(frame_velocity_world_aligned(&model, w, &run.q, &run.v, frame).linear[0] > 0.0);
    Ok(())
}

/// A pose from which the frame cannot move in a direction is refused by name.
#[test]
fn singular_poses_are_refused() -> Tested {
    let model = arm()?;
    let first = model.frame("link0").ok_or("no link")?;
    let w = &mut Workspace::new(&model);
    let (q, v) = (vec![0.3; model.nv()], vec![0.0; model.nv()]);
    let error = operational_space(&model, w, &q, &v, first, &[ClosureRow::Z]).unwrap_err();
    assert!(matches!(error, OperationalSpaceError::Singular { row: "z", .. }), "{error}");
    assert!(error.to_string().contains("`z` has the mobility"), "{error}");
    let error = operational_space(&model, w, &[f64::NAN; 6], &v, first, &[ClosureRow::Z]).unwrap_err();
    assert!(error.to_string().contains("q[0]"), "{error}");
    Ok(())
}
