//! Pullbacks against the Jacobians whose rows they combine, and against dual numbers, on every kind of robot.
//!
//! Tolerances: a pullback is λᵀ times a Jacobian, a sum of nv products of an entry of λ with a derivative of
//! a force. The terms of a force have the size `force_size`; 1e-13 of that allows 450 roundings, as for the
//! derivatives. Solving with M adds κ(M) ε of the solution, times a modest count.

use robot_dynamics::InputProblem;
use robot_dynamics::algorithms::{PARAMETERS_PER_LINK, ReferenceFrame};
use robot_dynamics::derivatives::{ParameterCotangents, parameter_count, parameter_values, with_parameters};
use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, ModelError, Pose};
use robot_dynamics::model::{InstructionSet, Model, RandomState, Workspace};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};

use crate::common::{Family, Robot, dot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-13;

type First = Dual<f64, 1>;

fn constants(x: &[f64]) -> Vec<First> {
    x.iter().map(|&x| Dual::constant(x)).collect()
}

/// A random cotangent.
fn cotangent(robot: &Robot) -> Vec<f64> {
    let random = &mut SplitMix64::new(robot.seed ^ 0xc0);
    (0..robot.model.nv()).map(|_| random.uniform(-2.0, 2.0)).collect()
}

/// λᵀJ of a row-major J.
fn transposed(jacobian: &[f64], lambda: &[f64]) -> Vec<f64> {
    let n = lambda.len();
    let columns = jacobian.len() / n;
    (0..columns).map(|j| (0..n).map(|i| lambda[i] * jacobian[i * columns + j]).sum()).collect()
}

#[test]
fn inverse_dynamics_match_the_jacobians() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let (w, lambda) = (&mut Workspace::new(model), cotangent(&robot));
        let allowed = ROUNDING * robot.force_size(a) * size(&lambda) * n as f64;
        for wrenches in [vec![], robot.wrenches()] {
            let (mut by_q, mut by_v) = (vec![0.0; n * n], vec![0.0; n * n]);
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives_with_wrenches(
                model, w, q, v, a, &wrenches, out,
            );
            // The pullback overwrites the previous content of the results.
            let [mut x, mut y, mut z] = [(); 3].map(|()| vec![7.0; n]);
            let out = robot_dynamics::derivatives::InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut [],
            };
            robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
                model,
                w,
                robot_dynamics::derivatives::InversePullbackInputs {
                    q,
                    v,
                    a,
                    wrenches: &wrenches,
                    cotangent: &lambda,
                },
                out,
            );
            robot.require("λᵀ∂τ/∂q", max_difference(&x, &transposed(&by_q, &lambda)), allowed);
            robot.require("λᵀ∂τ/∂v", max_difference(&y, &transposed(&by_v, &lambda)), allowed);
            robot.require("M λ", max_difference(&z, &times(&robot.mass(), &lambda)), allowed);
        }
    }
}

/// The derivative along one direction by dual numbers, without a Jacobian: λᵀ δτ = q̄ᵀδq + v̄ᵀδv + āᵀδa.
#[test]
fn pullbacks_are_adjoint_to_dual_numbers() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (n, random) = (model.nv(), &mut SplitMix64::new(robot.seed ^ 0xd0));
        let mut direction = || -> Vec<f64> { (0..n).map(|_| random.uniform(-1.0, 1.0)).collect() };
        let [dq, dv, da] = [(); 3].map(|()| direction());
        let along = |x: &[f64], dx: &[f64]| -> Vec<First> {
            x.iter().zip(dx).map(|(&value, &dx)| Dual { value, gradient: [dx] }).collect()
        };
        let (q, v) = (crate::common::moved_along(model, &state.q, &dq), along(&state.v, &dv));
        let (lambda, dual) = (cotangent(&robot), &mut Workspace::<First>::new(model));
        let w = &mut Workspace::new(model);
        let (x, y, z) = (&mut vec![0.0; n], &mut vec![0.0; n], &mut vec![0.0; n]);
        let change = |result: &[First]| result.iter().map(|x| x.gradient[0]).collect::<Vec<f64>>();
        let mut result = vec![Dual::constant(0.0); n];

        robot_dynamics::algorithms::inverse_dynamics(model, dual, &q, &v, &along(&state.a, &da), &mut result);
        let out = robot_dynamics::derivatives::InversePullbackMut {
            by_position: x,
            by_velocity: y,
            by_acceleration: z,
            parameters: &mut [],
        };
        robot_dynamics::derivatives::inverse_dynamics_pullback(
            model, w, &state.q, &state.v, &state.a, &lambda, out,
        );
        let found = dot(x, &dq) + dot(y, &dv) + dot(z, &da);
        let allowed = ROUNDING * robot.force_size(&state.a) * size(&lambda) * (n * n) as f64;
        robot.require("inverse dynamics", (found - dot(&lambda, &change(&result))).abs(), allowed);

        robot_dynamics::algorithms::forward_dynamics(
            model,
            dual,
            &q,
            &v,
            &along(&state.tau, &da),
            &mut result,
        );
        let mut a = vec![7.0; n];
        let out = robot_dynamics::derivatives::ForwardPullbackMut {
            acceleration: &mut a,
            by_position: x,
            by_velocity: y,
            by_force: z,
            parameters: &mut [],
        };
        robot_dynamics::derivatives::forward_dynamics_pullback(
            model, w, &state.q, &state.v, &state.tau, &lambda, out,
        );
        let expected = dot(&lambda, &change(&result));
        let found = dot(x, &dq) + dot(y, &dv) + dot(z, &da);
        let terms = size(x) + size(y) + size(z) + size(&change(&result)) * size(&lambda);
        let allowed = 1e2 * f64::EPSILON * robot.condition() * terms * n as f64;
        robot.require("forward dynamics", (found - expected).abs(), allowed);
    }
}

#[test]
fn forward_dynamics_match_the_jacobians() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, n) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let (w, lambda) = (&mut Workspace::new(model), cotangent(&robot));
        let rounding = 1e2 * f64::EPSILON * robot.condition();
        for wrenches in [vec![], robot.wrenches()] {
            let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![0.0; n * n]);
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives_with_wrenches(
                model, w, q, v, tau, &wrenches, out,
            );
            let mut expected_a = vec![0.0; n];
            robot_dynamics::algorithms::forward_dynamics_with_wrenches(
                model,
                w,
                q,
                v,
                tau,
                &wrenches,
                &mut expected_a,
            );
            let [mut a, mut x, mut y, mut z] = [(); 4].map(|()| vec![7.0; n]);
            let out = robot_dynamics::derivatives::ForwardPullbackMut {
                acceleration: &mut a,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut [],
            };
            robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters(
                model,
                w,
                robot_dynamics::derivatives::ForwardPullbackInputs {
                    q,
                    v,
                    tau,
                    wrenches: &wrenches,
                    cotangent: &lambda,
                },
                out,
            );
            let scale = size(&lambda) * n as f64;
            robot.require("a", max_difference(&a, &expected_a), rounding * size(&expected_a));
            // ∂a/∂v is small where the velocity is small: the scale is the largest of all numbers.
            let largest = size(&by_q).max(size(&by_v)).max(size(&by_tau));
            for (law, found, jacobian) in
                [("āᵀ∂a/∂q", &x, &by_q), ("āᵀ∂a/∂v", &y, &by_v), ("āᵀM⁻¹", &z, &by_tau)]
            {
                let defect = max_difference(found, &transposed(jacobian, &lambda));
                robot.require(law, defect, rounding * scale * largest);
            }
        }
    }
}

/// λᵀY, row by row of the regressor.
#[test]
fn inertial_parameters_match_the_regressor() {
    for robot in families().iter().flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let (w, lambda) = (&mut Workspace::new(model), cotangent(&robot));
        let columns = PARAMETERS_PER_LINK * model.moving_links().count();
        let mut regressor = vec![0.0; n * columns];
        robot_dynamics::algorithms::joint_torque_regressor(model, w, q, v, a, &mut regressor);
        let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n]);
        // The pullback adds to the previous content.
        let mut parameters = vec![2.0; parameter_count(model)];
        let out = robot_dynamics::derivatives::InversePullbackMut {
            by_position: &mut x,
            by_velocity: &mut y,
            by_acceleration: &mut z,
            parameters: &mut parameters,
        };
        robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
            model,
            w,
            robot_dynamics::derivatives::InversePullbackInputs { q, v, a, wrenches: &[], cotangent: &lambda },
            out,
        );
        for x in &mut parameters {
            *x -= 2.0;
        }
        let found = ParameterCotangents::of(model, &parameters).inertial;
        let expected = transposed(&regressor, &lambda);
        let allowed = 1e-13 * size(&regressor).max(1.0) * size(&lambda) * n as f64;
        robot.require("λᵀY", max_difference(found, &expected), allowed);
        // Forward dynamics at its acceleration: −λᵀY with λ = M⁻¹ā.
        let mut acceleration = vec![0.0; n];
        parameters.fill(0.0);
        let out = robot_dynamics::derivatives::ForwardPullbackMut {
            acceleration: &mut acceleration,
            by_position: &mut x,
            by_velocity: &mut y,
            by_force: &mut z,
            parameters: &mut parameters,
        };
        robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters(
            model,
            w,
            robot_dynamics::derivatives::ForwardPullbackInputs {
                q,
                v,
                tau: &state.tau,
                wrenches: &[],
                cotangent: &lambda,
            },
            out,
        );
        robot_dynamics::algorithms::joint_torque_regressor(model, w, q, v, &acceleration, &mut regressor);
        let found = ParameterCotangents::of(model, &parameters).inertial;
        let expected: Vec<f64> = transposed(&regressor, &z).iter().map(|x| -x).collect();
        let allowed = 1e-13 * size(&regressor).max(1.0) * size(&z).max(1.0) * (n * n) as f64;
        robot.require("−λᵀY", max_difference(found, &expected), allowed);
    }
}

/// Each number of the description is changed in turn and the robot compiled again. τ is linear in all of them
/// except for the product stiffness · rest. Central differences are therefore exact to the rounding of τ over
/// the change.
#[test]
fn passive_parameters_and_gravity_match_rebuilt_models() {
    let mut seen = [0; 5];
    for family in families().iter().filter(|family| family.name != "large") {
        for robot in family.robots().take(6) {
            let Robot { model, state, .. } = &robot;
            let (n, lambda) = (model.nv(), cotangent(&robot));
            let w = &mut Workspace::new(model);
            let (x, y, z) = (&mut vec![0.0; n], &mut vec![0.0; n], &mut vec![0.0; n]);
            let mut parameters = vec![0.0; parameter_count(model)];
            let out = robot_dynamics::derivatives::InversePullbackMut {
                by_position: x,
                by_velocity: y,
                by_acceleration: z,
                parameters: &mut parameters,
            };
            robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
                model,
                w,
                robot_dynamics::derivatives::InversePullbackInputs {
                    q: &state.q,
                    v: &state.v,
                    a: &state.a,
                    wrenches: &[],
                    cotangent: &lambda,
                },
                out,
            );
            robot_dynamics::derivatives::dissipation_pullback(model, &state.v, &lambda, y, &mut parameters);
            let by = ParameterCotangents::of(model, &parameters);
            // λᵀ(ID + b) of a changed robot.
            let power = |change: &dyn Fn(&mut robot_dynamics::description::RobotDescription, f64)| {
                let delta = 0.25;
                let side = |delta: f64| {
                    let mut changed = model.description().clone();
                    change(&mut changed, delta);
                    let changed = Model::new(changed).expect("a changed robot");
                    let w = &mut Workspace::new(&changed);
                    let (mut tau, mut b) = (vec![0.0; n], vec![0.0; n]);
                    robot_dynamics::algorithms::inverse_dynamics(
                        &changed, w, &state.q, &state.v, &state.a, &mut tau,
                    );
                    robot_dynamics::algorithms::dissipation(&changed, &state.v, &mut b);
                    dot(&lambda, &tau) + dot(&lambda, &b)
                };
                (side(delta) - side(-delta)) / (2.0 * delta)
            };
            let allowed = 1e-12 * robot.force_size(&state.a).max(1.0) * size(&lambda) * n as f64;
            for (k, found) in by.gravity.iter().enumerate() {
                let expected = power(&|robot, delta| robot.gravity[k] += delta);
                robot.require(&format!("gravity {k}"), (found - expected).abs(), allowed);
            }
            for (joint, found) in model.moving_joints().zip(by.passive.chunks_exact(5)) {
                let description = &model.description().joints;
                let Some(index) = description.iter().position(|own| own.name == joint.name) else { continue };
                let is_line = joint.kind.nq() == joint.kind.nv();
                for (which, found) in found.iter().enumerate() {
                    // Springs need joints whose q has no quaternion.
                    if !is_line && which >= 3 {
                        assert_eq!(*found, 0.0);
                        continue;
                    }
                    // Coefficients start at 2, so that none becomes negative.
                    let expected = power(&|robot, delta| {
                        let own = &mut robot.joints[index].passive;
                        match which {
                            0 => own.armature += 2.0 + delta,
                            1 => own.damping += 2.0 + delta,
                            2 => own.friction += 2.0 + delta,
                            3 => own.stiffness += 2.0 + delta,
                            _ => own.rest += delta,
                        }
                    });
                    seen[which] += usize::from(*found != 0.0);
                    robot.require(&format!("{} {which}", joint.name), (found - expected).abs(), allowed);
                }
            }
        }
    }
    assert!(seen.iter().all(|&seen| seen > 30), "{seen:?}");
}

/// The parameters of a robot give the same robot, with the mass of fixed links counted once; κ of the merging
/// is 1.
#[test]
fn robot_with_its_own_parameters_is_unchanged() {
    for robot in families().iter().filter(|family| family.name != "large").flat_map(Family::robots) {
        let Robot { model, state, .. } = &robot;
        let values = parameter_values(model);
        assert_eq!(values.len(), parameter_count(model));
        let same = Model::new(with_parameters(model, &values).expect("its own")).expect("a robot");
        let moved = max_difference(&parameter_values(&same), &values);
        robot.require("parameters", moved, ROUNDING * size(&values));
        let [mut tau, mut expected] = [(); 2].map(|()| vec![0.0; model.nv()]);
        let (q, v, a) = (&state.q, &state.v, &state.a);
        robot_dynamics::algorithms::inverse_dynamics(&same, &mut Workspace::new(&same), q, v, a, &mut tau);
        robot_dynamics::algorithms::inverse_dynamics(
            model,
            &mut Workspace::new(model),
            q,
            v,
            a,
            &mut expected,
        );
        robot.require("tau", max_difference(&tau, &expected), ROUNDING * robot.force_size(a));
        let error = with_parameters(model, &values[1..]).expect_err("one too few");
        let ModelError::Input(error) = error else { panic!("{error}") };
        let InputProblem::WrongLength { found, expected, .. } = error.problem else { panic!("{error}") };
        assert_eq!((found, expected), (values.len() - 1, values.len()));
    }
}

/// A balloon fixed to a rod: the parameters of their common mass do not determine the part whose weight is
/// compensated.
#[test]
fn partly_compensated_body_has_no_parameters() {
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    let gas =
        robot_dynamics::description::MassProperties::point(0.1, nalgebra::Vector3::zeros()).expect("a body");
    let mut balloon = LinkDescription::new("balloon", gas);
    balloon.gravity_compensation = 1.0;
    let rod = robot.links[1].name.clone();
    robot.links.push(balloon);
    robot.joints.push(JointDescription::new("tie", JointKind::Fixed, rod, "balloon", Pose::IDENTITY));
    let model = Model::new(robot.clone()).expect("a robot");
    let error = with_parameters(&model, &parameter_values(&model)).expect_err("carried apart");
    assert!(matches!(&error, ModelError::Carried { link, .. } if link == "balloon"), "{error}");
    robot.links[2].gravity_compensation = 0.0;
    let model = Model::new(robot).expect("a robot");
    let values = parameter_values(&model);
    let together = with_parameters(&model, &values).expect("one body");
    assert_eq!(together.links[2].mass_properties, None);
    assert_eq!(values[0], 2.1);
}

/// A Hessian-vector product over dual numbers is symmetric: ∂(q̄·x)/∂q along y equals ∂(q̄·y)/∂q along x, for
/// q without quaternions.
#[test]
fn second_derivatives_are_symmetric() {
    let options = robot_dynamics::description::RandomRobotOptions {
        kinds: robot_dynamics::description::JointKinds::VectorSpace,
        ..Default::default()
    };
    for seed in 0..10 {
        let robot = Robot::new("plain trees", seed, &options);
        let Robot { model, state, .. } = &robot;
        let (n, lambda) = (model.nv(), cotangent(&robot));
        let random = &mut SplitMix64::new(seed);
        let mut direction = || -> Vec<f64> { (0..n).map(|_| random.uniform(-1.0, 1.0)).collect() };
        let (x, y) = (direction(), direction());
        let w = &mut Workspace::<First>::new(model);
        let mut along = |x: &[f64], y: &[f64]| {
            let q: Vec<First> =
                state.q.iter().zip(x).map(|(&value, &x)| Dual { value, gradient: [x] }).collect();
            let [mut by_q, mut by_v, mut by_a] = [(); 3].map(|()| constants(&vec![0.0; n]));
            let out = robot_dynamics::derivatives::InversePullbackMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_acceleration: &mut by_a,
                parameters: &mut [],
            };
            robot_dynamics::derivatives::inverse_dynamics_pullback(
                model,
                w,
                &q,
                &constants(&state.v),
                &constants(&state.a),
                &constants(&lambda),
                out,
            );
            by_q.iter().zip(y).map(|(q, y)| q.gradient[0] * y).sum::<f64>()
        };
        let (one, other) = (along(&x, &y), along(&y, &x));
        let allowed = ROUNDING * robot.force_size(&state.a) * size(&lambda) * (n * n) as f64;
        robot.require("the Hessian's symmetry", (one - other).abs(), allowed);
        assert!(one.abs() > 1e3 * allowed);
    }
}

/// τ = … − Σ Jᵀw: the cotangent of a wrench is −J λ in its frame.
#[test]
fn cotangent_of_wrench_is_frame_velocity() {
    for robot in families().iter().flat_map(|family| family.robots().take(5).collect::<Vec<_>>()) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, n) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let (w, lambda) = (&mut Workspace::new(model), cotangent(&robot));
        for wrench in robot.wrenches() {
            let (mut with, mut without) = (vec![0.0; n], vec![0.0; n]);
            robot_dynamics::algorithms::inverse_dynamics_with_wrenches(
                model,
                w,
                q,
                v,
                a,
                &[wrench],
                &mut with,
            );
            robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, &mut without);
            let twist = robot_dynamics::algorithms::frame_velocity(
                model,
                w,
                q,
                &lambda,
                wrench.frame,
                ReferenceFrame::Local,
            );
            let found =
                -dot(&twist.linear, &wrench.force_in_frame) - dot(&twist.angular, &wrench.moment_in_frame);
            let allowed = ROUNDING * robot.force_size(a) * size(&lambda) * n as f64;
            robot.require("−J λ", (found - (dot(&lambda, &with) - dot(&lambda, &without))).abs(), allowed);
        }
    }
}

/// Both pullbacks with one workspace: q̄, v̄ and ā or τ̄ of inverse and forward dynamics, and the parameters
/// of both.
fn both<S: Scalar>(model: &Model, w: &mut Workspace<S>, state: &RandomState, lambda: &[f64]) -> Vec<Vec<S>> {
    let number = |x: &[f64]| x.iter().map(|&x| S::from_f64(x)).collect::<Vec<S>>();
    let [q, v, a, tau] = [&state.q, &state.v, &state.a, &state.tau].map(|x| number(x));
    let (lambda, vector) = (number(lambda), || vec![S::zero(); model.nv()]);
    let [mut x, mut y, mut z, mut r] = [(); 4].map(|()| vector());
    let [mut x2, mut y2, mut z2] = [(); 3].map(|()| vector());
    let [mut p, mut p2] = [(); 2].map(|()| vec![S::zero(); parameter_count(model)]);
    let out = robot_dynamics::derivatives::InversePullbackMut {
        by_position: &mut x,
        by_velocity: &mut y,
        by_acceleration: &mut z,
        parameters: &mut p,
    };
    robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
        model,
        w,
        robot_dynamics::derivatives::InversePullbackInputs {
            q: &q,
            v: &v,
            a: &a,
            wrenches: &[],
            cotangent: &lambda,
        },
        out,
    );
    let out = robot_dynamics::derivatives::ForwardPullbackMut {
        acceleration: &mut r,
        by_position: &mut x2,
        by_velocity: &mut y2,
        by_force: &mut z2,
        parameters: &mut p2,
    };
    robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters(
        model,
        w,
        robot_dynamics::derivatives::ForwardPullbackInputs {
            q: &q,
            v: &v,
            tau: &tau,
            wrenches: &[],
            cotangent: &lambda,
        },
        out,
    );
    vec![x, y, z, p, r, x2, y2, z2, p2]
}

/// With every instruction set of this machine, and in f32 with its larger rounding.
#[test]
fn every_route_agrees() {
    let mut tested = 0;
    for robot in families().iter().flat_map(|family| family.robots().take(8).collect::<Vec<_>>()) {
        let Robot { model, state, .. } = &robot;
        let (lambda, condition) = (cotangent(&robot), robot.condition());
        let portable = &mut Workspace::<f64>::limited(model, InstructionSet::Portable);
        let expected = both(model, portable, state, &lambda);
        let mut judge = |route: &str, found: &[Vec<f64>], rounding: f64| {
            for (part, numbers) in [&expected[..4], &expected[4..]].into_iter().enumerate() {
                let scale = numbers.iter().map(|x| size(x)).fold(1.0, f64::max);
                let factor = if part == 0 { 10.0 } else { condition.max(10.0) };
                for (found, expected) in found[4 * part..].iter().zip(numbers) {
                    let allowed = 1e2 * rounding * factor * scale;
                    robot.require(route, max_difference(found, expected), allowed);
                }
            }
            tested += 1;
        };
        for &set in InstructionSet::ALL.iter().filter(|set| set.is_available()) {
            let found = both(model, &mut Workspace::<f64>::limited(model, set), state, &lambda);
            judge(&format!("f64 by {set}"), &found, f64::EPSILON);
            if condition < 1e3 {
                let found = both(model, &mut Workspace::<f32>::limited(model, set), state, &lambda);
                let found: Vec<Vec<f64>> =
                    found.iter().map(|x| x.iter().map(|&x| f64::from(x)).collect()).collect();
                judge(&format!("f32 by {set}"), &found, f64::from(f32::EPSILON));
            }
        }
    }
    assert!(tested > 100, "only {tested} routes");
}
