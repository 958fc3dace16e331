//! Analytic derivatives against dual numbers through the recursions, on every kind of robot.
//!
//! Tolerances: a derivative of τ sums terms over at most 60 bodies. Each term is an inertia times an
//! acceleration or two velocities, or a weight times an arm; 1e-13 of the largest term allows 450 roundings.
//! Solving with M adds κ(M) ε of the solution, times a modest count.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot_dynamics::InputProblem;
use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, SpatialAcceleration, Twist, frame_acceleration, frame_jacobian,
    frame_velocity,
};
use robot_dynamics::derivatives::{
    FrameAccelerationDerivativesMut, FrameAccelerationInputs, frame_acceleration_derivatives,
    frame_velocity_derivative,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::Dual;

use crate::common::{Family, Robot, dot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-13;

type First = Dual<f64, 1>;

fn constants(x: &[f64]) -> Vec<First> {
    x.iter().map(|&x| Dual::constant(x)).collect()
}

/// x + ε eₖ.
fn varied(x: &[f64], k: usize) -> Vec<First> {
    let mut varied = constants(x);
    varied[k].gradient = [1.0];
    varied
}

/// q ⊕ ε eₖ to first order: q̇ of v = eₖ, with quaternions by nalgebra.
fn moved(model: &Model, q: &[f64], k: usize) -> Vec<First> {
    let mut moved = constants(q);
    let joint = model.joints().iter().find(|joint| joint.v().contains(&k));
    let joint = joint.expect("a joint has the coordinate");
    let (i, k) = (joint.q_index, k - joint.v_index);
    if joint.nq == joint.nv {
        moved[i + k].gradient = [1.0];
        return moved;
    }
    let at = i + joint.nq - 4;
    let turn = Quaternion::new(q[at + 3], q[at], q[at + 1], q[at + 2]);
    let mut axis = Vector3::zeros();
    axis[k % 3] = 1.0;
    if joint.nq == 7 && k < 3 {
        let along = UnitQuaternion::from_quaternion(turn) * axis;
        (0..3).for_each(|j| moved[i + j].gradient = [along[j]]);
    } else {
        let rate = turn * Quaternion::from_imag(axis) * 0.5;
        (0..4).for_each(|j| moved[at + j].gradient = [rate.coords[j]]);
    }
    moved
}

/// The n×n matrix whose column k is the gradient of `f` over the k-th variation.
fn jacobian(n: usize, mut f: impl FnMut(usize, &mut [First])) -> Vec<f64> {
    let mut matrix = vec![0.0; n * n];
    let mut column = vec![Dual::constant(0.0); n];
    for k in 0..n {
        f(k, &mut column);
        (0..n).for_each(|i| matrix[i * n + k] = column[i].gradient[0]);
    }
    matrix
}

fn constant_wrenches(wrenches: &[FrameWrench]) -> Vec<FrameWrench<First>> {
    let constant = |x: [f64; 3]| x.map(Dual::constant);
    wrenches
        .iter()
        .map(|w| FrameWrench {
            frame: w.frame,
            force_in_frame: constant(w.force_in_frame),
            moment_in_frame: constant(w.moment_in_frame),
        })
        .collect()
}

#[test]
fn inverse_dynamics_match_duals() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let dual = &mut Workspace::<First>::new(model);
        let w = &mut Workspace::new(model);
        for wrenches in [vec![], robot.wrenches()] {
            let held = constant_wrenches(&wrenches);
            let mut tau = |q: &[First], v: &[First], tau: &mut [First]| {
                robot_dynamics::algorithms::inverse_dynamics_with_wrenches(
                    model,
                    dual,
                    q,
                    v,
                    &constants(a),
                    &held,
                    tau,
                );
            };
            let by_q = jacobian(n, |k, x| tau(&moved(model, q, k), &constants(v), x));
            let by_v = jacobian(n, |k, x| tau(&constants(q), &varied(v, k), x));
            // The previous content of the results is overwritten.
            let (mut found_q, mut found_v) = (vec![7.0; n * n], vec![7.0; n * n]);
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut found_q,
                by_velocity: &mut found_v,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives_with_wrenches(
                model, w, q, v, a, &wrenches, out,
            );
            let scale = robot.force_size(&robot.state.a)
                + if wrenches.is_empty() { 0.0 } else { 3.0 * wrenches.len() as f64 };
            robot.require("∂τ/∂q", max_difference(&found_q, &by_q), ROUNDING * (scale + size(&by_q)));
            robot.require("∂τ/∂v", max_difference(&found_v, &by_v), ROUNDING * (scale + size(&by_v)));
        }
    }
}

#[test]
fn forward_dynamics_match_duals() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, n) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let dual = &mut Workspace::<First>::new(model);
        let w = &mut Workspace::new(model);
        let wrenches = robot.wrenches();
        let held = constant_wrenches(&wrenches);
        let mut acceleration = |q: &[First], v: &[First], tau: &[First], a: &mut [First]| {
            robot_dynamics::algorithms::forward_dynamics_with_wrenches(model, dual, q, v, tau, &held, a);
        };
        let expected = [
            jacobian(n, |k, x| acceleration(&moved(model, q, k), &constants(v), &constants(tau), x)),
            jacobian(n, |k, x| acceleration(&constants(q), &varied(v, k), &constants(tau), x)),
            jacobian(n, |k, x| acceleration(&constants(q), &constants(v), &varied(tau, k), x)),
        ];
        let mut found = [(); 3].map(|()| vec![7.0; n * n]);
        let [by_q, by_v, by_tau] = &mut found;
        let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
            by_position: by_q,
            by_velocity: by_v,
            by_force: by_tau,
        };
        robot_dynamics::derivatives::forward_dynamics_derivatives_with_wrenches(
            model, w, q, v, tau, &wrenches, out,
        );
        // In ∂a/∂q = −M⁻¹ ∂ID/∂q, an error in M changes a once, and a changes ∂ID/∂q.
        let mut a = vec![0.0; n];
        robot_dynamics::algorithms::forward_dynamics_with_wrenches(model, w, q, v, tau, &wrenches, &mut a);
        let (mass, condition) = (size(&robot.mass()), robot.condition());
        let forces = robot.force_size(&robot.state.a) + size(tau) + 3.0 * wrenches.len() as f64;
        let a_size = forces / mass + dot(&a, &a).sqrt();
        for (name, (found, expected)) in ["∂a/∂q", "∂a/∂v", "∂a/∂τ"].iter().zip(found.iter().zip(&expected))
        {
            let scale = a_size + size(expected);
            let allowed = 64.0 * f64::EPSILON * condition * scale;
            robot.require(name, max_difference(found, expected), allowed);
        }
    }
}

/// Row i of M ∂a/∂q + ∂ID/∂q is zero, at the a of the same state. The check shares no step with the recursion
/// over dual numbers.
#[test]
fn forward_and_inverse_derivatives_are_consistent() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, n) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let w = &mut Workspace::new(model);
        let mut a = vec![0.0; n];
        robot_dynamics::algorithms::forward_dynamics(model, w, q, v, tau, &mut a);
        let [mut id_q, mut id_v, mut fd_q, mut fd_v, mut inverse] = [(); 5].map(|()| vec![0.0; n * n]);
        let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
            by_position: &mut id_q,
            by_velocity: &mut id_v,
        };
        robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, q, v, &a, out);
        let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
            by_position: &mut fd_q,
            by_velocity: &mut fd_v,
            by_force: &mut inverse,
        };
        robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, q, v, tau, out);
        let mass = robot.mass();
        let allowed = 64.0 * f64::EPSILON * robot.condition();
        for (name, fd, id) in [("q", &fd_q, &id_q), ("v", &fd_v, &id_v)] {
            for j in 0..n {
                let column = |m: &[f64]| -> Vec<f64> { (0..n).map(|i| m[i * n + j]).collect() };
                let minus: Vec<f64> = times(&mass, &column(fd)).iter().map(|x| -x).collect();
                let scale = size(id) + size(&mass) * size(fd) + robot.force_size(&robot.state.a);
                robot.require(name, max_difference(&minus, &column(id)), allowed * scale);
            }
        }
        let mut expected = vec![0.0; n * n];
        robot_dynamics::algorithms::inverse_mass_matrix(model, w, q, &mut expected);
        robot.require("∂a/∂τ = M⁻¹", max_difference(&inverse, &expected), allowed * size(&expected));
    }
}

/// The Hessian of V is the derivative of g.
#[test]
fn gravity_matches_duals() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, n) = (&state.q[..], model.nv());
        let dual = &mut Workspace::<First>::new(model);
        let expected =
            jacobian(n, |k, g| robot_dynamics::algorithms::gravity(model, dual, &moved(model, q, k), g));
        let mut found = vec![7.0; n * n];
        robot_dynamics::derivatives::gravity_derivative(model, &mut Workspace::new(model), q, &mut found);
        robot.require(
            "∂g/∂q",
            max_difference(&found, &expected),
            ROUNDING * (robot.force_size(&robot.state.a) + size(&expected)),
        );
    }
}

/// A rows×n matrix whose column k has the gradients of `f` over the k-th variation.
fn columns<const ROWS: usize>(n: usize, mut f: impl FnMut(usize) -> [First; ROWS]) -> Vec<f64> {
    let mut matrix = vec![0.0; ROWS * n];
    for k in 0..n {
        f(k).iter().enumerate().for_each(|(i, x)| matrix[i * n + k] = x.gradient[0]);
    }
    matrix
}

fn six([a, b, c]: [First; 3], [d, e, f]: [First; 3]) -> [First; 6] {
    [a, b, c, d, e, f]
}

/// ∂ċ/∂q, and ∂/∂q, ∂/∂v of the velocity and the acceleration of the last link.
///
/// A velocity is a sum over at most 60 joints of a rate times an arm of at most some tens of metres, an
/// acceleration of two rates. 1e-13 of v (or v² + a) times the largest entry of J allows 450 roundings.
#[test]
fn kinematics_match_duals() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let d = &mut Workspace::<First>::new(model);
        let w = &mut Workspace::new(model);
        let frame = model.frame(&model.frames().last().expect("a frame").name).expect("its own frame");
        let (fixed_q, fixed_v, fixed_a) = (constants(q), constants(v), constants(a));
        let mut size_of_jacobian = |reference_frame| {
            let mut jacobian = vec![0.0; 6 * n];
            frame_jacobian(model, w, q, frame, reference_frame, &mut jacobian);
            size(&jacobian)
        };
        let aligned = size_of_jacobian(ReferenceFrame::LocalWorldAligned);
        // The world's origin may be farther from the joints than the frame is.
        let in_world = aligned.max(size_of_jacobian(ReferenceFrame::World));
        let slow = |largest: f64| ROUNDING * n as f64 * (1.0 + largest) * size(v);
        for reference_frame in ReferenceFrame::ALL {
            let largest = if reference_frame == ReferenceFrame::World { in_world } else { aligned };
            let arm = n as f64 * (1.0 + largest);
            let fast = ROUNDING * arm * arm * (size(v) * size(v) + size(a) + size(v));
            let [mut by_q, mut by_v] = [(); 2].map(|()| vec![7.0; 6 * n]);

            frame_velocity_derivative(model, w, q, v, frame, reference_frame, &mut by_q);
            let expected = columns(n, |k| {
                let q = moved(model, q, k);
                let Twist { linear, angular } =
                    frame_velocity(model, d, &q, &fixed_v, frame, reference_frame);
                six(linear, angular)
            });
            let difference = max_difference(&by_q, &expected);
            robot.require(&format!("∂/∂q of the velocity, {reference_frame:?}"), difference, slow(largest));

            frame_acceleration_derivatives(
                model,
                w,
                FrameAccelerationInputs { q, v, a, frame, reference_frame },
                FrameAccelerationDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v },
            );
            let mut acceleration = |q: &[First], v: &[First]| {
                let SpatialAcceleration { linear, angular } =
                    frame_acceleration(model, d, q, v, &fixed_a, frame, reference_frame);
                six(linear, angular)
            };
            let expected = columns(n, |k| acceleration(&moved(model, q, k), &fixed_v));
            let difference = max_difference(&by_q, &expected);
            robot.require(&format!("∂/∂q of the acceleration, {reference_frame:?}"), difference, fast);
            let expected = columns(n, |k| acceleration(&fixed_q, &varied(v, k)));
            let difference = max_difference(&by_v, &expected);
            robot.require(&format!("∂/∂v of the acceleration, {reference_frame:?}"), difference, fast);
        }

        if model.moving_mass() > 0.0 {
            let mut found = vec![7.0; 3 * n];
            robot_dynamics::derivatives::center_of_mass_velocity_derivative(model, w, q, v, &mut found);
            let expected = columns(n, |k| {
                robot_dynamics::algorithms::center_of_mass_velocity(model, d, &moved(model, q, k), &fixed_v)
            });
            robot.require("∂ċ/∂q", max_difference(&found, &expected), slow(aligned));
        }
    }
}

/// ∂b/∂v, away from v = 0.
#[test]
fn dissipation_matches_duals() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let n = model.nv();
        let expected =
            jacobian(n, |k, b| robot_dynamics::algorithms::dissipation(model, &varied(&state.v, k), b));
        let mut diagonal = vec![7.0; n];
        robot_dynamics::algorithms::dissipation_derivative(model, &mut diagonal);
        let mut found = vec![0.0; n * n];
        (0..n).for_each(|k| found[k * n + k] = diagonal[k]);
        // A sum of one product for each joint of a coordinate.
        robot.require("∂b/∂v", max_difference(&found, &expected), 1e-14 * size(&expected));
    }
}

/// The checked methods give the same numbers, and their errors name the invalid quantity.
#[test]
fn methods_of_model_match_functions() {
    let families = families();
    let robot = families[2].robots().next().expect("a robot");
    let Robot { model, state, .. } = &robot;
    let (q, v, n) = (&state.q[..], &state.v[..], model.nv());
    let w = &mut Workspace::new(model);
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n * n]);
    let rows = |m: &nalgebra::DMatrix<f64>| m.transpose().as_slice().to_vec();
    let inverse = model.inverse_dynamics_derivatives(q, v, &state.a).expect("a good state");
    let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
        by_position: &mut x,
        by_velocity: &mut y,
    };
    robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, q, v, &state.a, out);
    assert_eq!((rows(&inverse.by_position), rows(&inverse.by_velocity)), (x.clone(), y.clone()));
    assert_eq!(rows(&inverse.by_acceleration), robot.mass());
    let forward = model.forward_dynamics_derivatives(q, v, &state.tau).expect("a good state");
    let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
        by_position: &mut x,
        by_velocity: &mut y,
        by_force: &mut z,
    };
    robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, q, v, &state.tau, out);
    assert_eq!((rows(&forward.by_position), rows(&forward.by_velocity)), (x.clone(), y));
    assert_eq!(rows(&forward.by_force), z);
    robot_dynamics::derivatives::gravity_derivative(model, w, q, &mut x);
    assert_eq!(rows(&model.gravity_derivative(q).expect("a good configuration")), x);
    let mut wrong = v.to_vec();
    wrong[1] = f64::INFINITY;
    let error = model.inverse_dynamics_derivatives(q, &wrong, &state.a).unwrap_err();
    let robot_dynamics::algorithms::MotionError::Input(error) = error else { panic!("{error}") };
    assert_eq!(error.quantity, "v");
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(1), .. }), "{error}");
}

/// Over dual numbers the same functions give second derivatives: ∂²τ/∂v∂q is ∂²τ/∂q∂v for q without
/// quaternions.
#[test]
fn second_derivatives_commute() {
    let families = families();
    let mut tested = 0;
    for robot in families[5].robots().take(20).filter(|robot| robot.model.is_vector_space()) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], constants(&state.a), model.nv());
        let dual = &mut Workspace::<First>::new(model);
        let [mut x, mut y] = [(); 2].map(|()| vec![Dual::constant(0.0); n * n]);
        let mut qv = vec![0.0; n * n * n];
        for k in 0..n {
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(
                model,
                dual,
                &constants(q),
                &varied(v, k),
                &a,
                out,
            );
            // Entry (i, j) of ∂(∂τ_i/∂q_j)/∂v_k.
            (0..n * n).for_each(|ij| qv[k * n * n + ij] = x[ij].gradient[0]);
        }
        let largest = size(&qv);
        for j in 0..n {
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(
                model,
                dual,
                &varied(q, j),
                &constants(v),
                &a,
                out,
            );
            for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
                let defect = (y[i * n + k].gradient[0] - qv[k * n * n + i * n + j]).abs();
                robot.require("∂²τ/∂q∂v", defect, ROUNDING * (largest + robot.force_size(&robot.state.a)));
            }
        }
        tested += usize::from(largest > 1e-3);
    }
    assert!(tested > 10, "only {tested} robots have a second derivative to speak of");
}

/// A call that fails does not affect the next one.
#[test]
fn failed_call_does_not_affect_later_calls() {
    for robot in families().iter().filter_map(|family| family.robots().next()) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, n) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let w = &mut Workspace::new(model);
        let mut of = |v: &[f64]| {
            let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n * n]);
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, q, v, tau, out);
            let [mut s, mut t] = [(); 2].map(|()| vec![0.0; n * n]);
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut s,
                by_velocity: &mut t,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, q, v, tau, out);
            [x, y, z, s, t]
        };
        let before = of(v);
        assert!(of(&vec![f64::NAN; n])[0].iter().any(|x| x.is_nan()), "{}", robot.family);
        assert_eq!(before, of(v), "{}", robot.family);
    }
}
