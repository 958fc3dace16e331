//! Every checked call with NaN and both infinities in each entry of each argument. The result is an error
//! that names the argument, and an `Ok` holds finite numbers only.

use dynamics::{PdHold, Reach2R, hold};
use nalgebra::{DVector, SVector};
use robot_dynamics::algorithms::{ReferenceFrame, SpatialAcceleration, Twist};
use robot_dynamics::batch;
use robot_dynamics::batch::{BatchWorkspace, Rollout, Torques};
use robot_dynamics::constraints::{
    Baumgarte, ConstraintOptions, ConstraintSet, Coupling, DriftCorrection, FrameConstraint, Plane,
    RedundantRows, RollingDisc,
};
use robot_dynamics::control::{
    BaseParameters, ComputedTorque, CubicSpline, MotionLimits, MotionRecord, PoseReference, Reference,
    TaskControl, TaskGains, TaskReference, TimeOptimal, TreePathPoint,
};
use robot_dynamics::derivatives::LinearizeStepWorkspace;
use robot_dynamics::description::{Base, JointKinds, Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{FrameId, Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    ConstantTorque, Controller, GravityCompensatedPd, Integrator, Method, RunOptions, SimulationBuilder,
    StepForces, StepWorkspace, ZeroTorque,
};

/// The result of a call: all numbers, or the message of its error.
type Answer = Result<Vec<f64>, String>;

/// An argument: its name in errors, valid numbers, and whether +∞ is a valid value (no limit).
struct Argument {
    name: &'static str,
    good: Vec<f64>,
    may_be_infinite: bool,
}

fn argument(name: &'static str, good: impl Into<Vec<f64>>) -> Argument {
    Argument { name, good: good.into(), may_be_infinite: false }
}

/// Calls with valid arguments, then with one invalid entry at a time, then with one entry so large that
/// results overflow. An overflow may be an error or not, but an `Ok` holds finite numbers only.
#[track_caller]
fn probe(call: &str, arguments: &[Argument], mut run: impl FnMut(&[Vec<f64>]) -> Answer) {
    let good: Vec<Vec<f64>> = arguments.iter().map(|argument| argument.good.clone()).collect();
    let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
    let answer = run(&good).unwrap_or_else(|error| panic!("{call} of good numbers: {error}"));
    assert!(!answer.is_empty() && finite(&answer), "{call} of good numbers: {answer:?}");
    for (which, argument) in arguments.iter().enumerate() {
        for entry in 0..argument.good.len() {
            let mut given = good.clone();
            for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                if wrong == f64::INFINITY && argument.may_be_infinite {
                    continue;
                }
                given[which][entry] = wrong;
                let place = format!("{call} with {}[{entry}] = {wrong}", argument.name);
                match run(&given) {
                    Ok(answer) => panic!("{place} gives {answer:?}"),
                    Err(error) => assert!(error.contains(argument.name), "{place}: {error}"),
                }
            }
            for large in [1e155, -1e200, 1e308] {
                given[which][entry] = large;
                if let Ok(answer) = run(&given) {
                    assert!(
                        finite(&answer),
                        "{call} with {}[{entry}] = {large:e}: {answer:?}",
                        argument.name
                    );
                }
            }
        }
    }
}

fn text<T, E: std::fmt::Display>(result: Result<T, E>) -> Result<T, String> {
    result.map_err(|error| error.to_string())
}

fn numbers<'a, E: std::fmt::Display>(result: Result<impl AsRef<[f64]> + 'a, E>) -> Answer {
    text(result).map(|x| x.as_ref().to_vec())
}

/// A floating tree with every kind of joint, and a state.
fn tree() -> (Model, [Vec<f64>; 4]) {
    let options = RandomRobotOptions { joints: 5, base: Base::Floating, ..Default::default() };
    let model = Model::new(random_robot(2, &options)).unwrap();
    assert!(model.nq() > model.nv() && model.nv() > 8);
    let state = random_state(&model, &mut SplitMix64::new(5));
    (model, [state.q, state.v, state.a, state.tau])
}

#[test]
fn inverse_kinematics_rejects_non_finite() {
    let m = &arm(7);
    let (w, hand) = (&mut Workspace::new(m), last_frame(m));
    let pose = robot_dynamics::algorithms::frame_pose(m, w, &[0.3; 7], hand);
    let options = robot_dynamics::control::InverseKinematicsOptions::default().with_restarts(1, 0);
    let arguments = [
        argument("q", vec![0.2; 7]),
        argument("position", pose.translation),
        argument("rotation", pose.rotation.as_flattened()),
    ];
    probe("inverse_kinematics", &arguments, |x| {
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| x[2][3 * i + j]));
        let target = Pose { rotation, translation: [x[1][0], x[1][1], x[1][2]] };
        let found = text(robot_dynamics::control::inverse_kinematics(m, w, hand, target, &x[0], &options))?;
        Ok([found.q, vec![found.position_error, found.angle_error]].concat())
    });
}

/// A chain of hinges.
fn arm(joints: usize) -> Model {
    let options = RandomRobotOptions { joints, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    Model::new(random_robot(4, &options)).unwrap()
}

fn last_frame(model: &Model) -> FrameId {
    model.frame(&model.frames()[model.frames().len() - 1].name).unwrap()
}

#[test]
fn methods_of_model_reject_non_finite() {
    let (model, [q, v, a, tau]) = tree();
    let frame = last_frame(&model);
    let q = || argument("q", q.clone());
    let v = || argument("v", v.clone());
    let m = &model;
    macro_rules! matrices {
        ($($call:ident($($x:ident),*);)*) => {$(
            let arguments = [$(stringify!($x)),*].map(|name| {
                let good = match name {
                    "q" => q().good,
                    "v" => v().good,
                    "a" => a.clone(),
                    _ => tau.clone(),
                };
                argument(name, good)
            });
            probe(stringify!($call), &arguments, |x| {
                let mut x = x.iter();
                $(let $x = x.next().unwrap();)*
                text(m.$call($($x),*)).map(|result| result.as_slice().to_vec())
            });
        )*};
    }
    matrices! {
        mass_matrix(q); inverse_mass_matrix(q); coriolis_matrix(q, v); velocity_product(q, v); gravity_forces(q);
        bias(q, v); inverse_dynamics(q, v, a); forward_dynamics(q, v, tau); center_of_mass(q);
        center_of_mass_jacobian(q); centroidal_momentum_matrix(q); joint_torque_regressor(q, v, a);
        gravity_derivative(q);
    }
    probe("kinetic_energy", &[q(), v()], |x| text(m.kinetic_energy(&x[0], &x[1])).map(|e| vec![e]));
    probe("potential_energy", &[q()], |x| text(m.potential_energy(&x[0])).map(|e| vec![e]));
    probe("centroidal_momentum", &[q(), v()], |x| {
        text(m.centroidal_momentum(&x[0], &x[1])).map(|h| [h.linear, h.angular].concat())
    });
    probe("frame_pose", &[q()], |x| {
        text(m.frame_pose(&x[0], frame)).map(|p| [p.rotation.as_flattened(), &p.translation].concat())
    });
    for seen in ReferenceFrame::ALL {
        probe("a frame's J", &[q()], |x| {
            text(m.frame_jacobian(&x[0], frame, seen)).map(|j| j.as_slice().to_vec())
        });
    }
    probe("inverse_dynamics_derivatives", &[q(), v(), argument("a", a.clone())], |x| {
        let derivatives = text(m.inverse_dynamics_derivatives(&x[0], &x[1], &x[2]))?;
        let all = [derivatives.by_position, derivatives.by_velocity, derivatives.by_acceleration];
        Ok(all.iter().flat_map(|m| m.as_slice().to_vec()).collect())
    });
    probe("forward_dynamics_derivatives", &[q(), v(), argument("tau", tau.clone())], |x| {
        let derivatives = text(m.forward_dynamics_derivatives(&x[0], &x[1], &x[2]))?;
        let all = [derivatives.by_position, derivatives.by_velocity, derivatives.by_force];
        Ok(all.iter().flat_map(|m| m.as_slice().to_vec()).collect())
    });
    let cotangent = || argument("the cotangent", tau.clone());
    probe("inverse_dynamics_pullback", &[q(), v(), argument("a", a.clone()), cotangent()], |x| {
        let by = text(m.inverse_dynamics_pullback(&x[0], &x[1], &x[2], &x[3]))?;
        let all = [by.by_position, by.by_velocity, by.by_acceleration, by.parameters];
        Ok(all.iter().flat_map(|x| x.as_slice().to_vec()).collect())
    });
    probe("forward_dynamics_pullback", &[q(), v(), argument("tau", tau.clone()), cotangent()], |x| {
        let by = text(m.forward_dynamics_pullback(&x[0], &x[1], &x[2], &x[3]))?;
        let all = [by.acceleration, by.by_position, by.by_velocity, by.by_force, by.parameters];
        Ok(all.iter().flat_map(|x| x.as_slice().to_vec()).collect())
    });
    probe("check_configuration", &[q()], |x| {
        numbers(robot_dynamics::model::check_configuration(m, &x[0]).map(|()| [0.0]))
    });
}

#[test]
fn steps_and_runs_reject_non_finite() {
    let (model, [q, v, _, tau]) = tree();
    let v: Vec<f64> = v.iter().map(|v| 0.1 * v).collect();
    let m = &model;
    let arguments = || {
        [
            argument("tau", tau.clone()),
            argument("step", [1e-5]),
            argument("q", q.clone()),
            argument("v", v.clone()),
        ]
    };
    let mut workspace = StepWorkspace::new(m);
    for integrator in Integrator::ALL {
        probe(integrator.name(), &arguments(), |x| {
            let forces = StepForces::new(&x[0], true);
            let (mut q, mut v) = (x[2].clone(), x[3].clone());
            let done = robot_dynamics::simulation::step(
                m,
                integrator,
                &mut workspace,
                &forces,
                x[1][0],
                &mut q,
                &mut v,
            );
            if done.is_err() {
                let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(
                    same(&q, &x[2]) && same(&v, &x[3]),
                    "{integrator} changed the state of a failed step"
                );
            }
            text(done).map(|()| [q, v].concat())
        });
    }
    let mut workspace = LinearizeStepWorkspace::new(m);
    for integrator in [Integrator::ExplicitEuler, Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        probe("linearize_step", &arguments(), |x| {
            let forces = StepForces::new(&x[0], true);
            let nv = m.nv();
            let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
            let w = &mut workspace;
            text(robot_dynamics::derivatives::linearize_step(
                m,
                integrator,
                w,
                &forces,
                x[1][0],
                robot_dynamics::derivatives::RobotState { q: &x[2], v: &x[3] },
                robot_dynamics::derivatives::LinearizedStep { by_state: &mut a, by_force: &mut b },
            ))?;
            Ok([a, b].concat())
        });
    }
    let cotangents =
        || [argument("the cotangent of q", tau.clone()), argument("the cotangent of v", tau.clone())];
    let mut workspace = robot_dynamics::derivatives::StepPullbackWorkspace::new(m);
    probe("step_pullback", &arguments().into_iter().chain(cotangents()).collect::<Vec<_>>(), |x| {
        let forces = StepForces::new(&x[0], true);
        let (mut by_q, mut by_v, mut by_tau) = (x[4].clone(), x[5].clone(), tau.clone());
        let mut parameters = vec![0.0; robot_dynamics::derivatives::parameter_count(m)];
        let (w, row, p) = (&mut workspace, Integrator::RungeKutta4, &mut parameters);
        text(robot_dynamics::derivatives::step_pullback(
            m,
            row,
            w,
            &forces,
            x[1][0],
            robot_dynamics::derivatives::RobotState { q: &x[2], v: &x[3] },
            robot_dynamics::derivatives::MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: p,
            },
        ))?;
        Ok([by_q, by_v, by_tau, parameters].concat())
    });
    let integrator = Integrator::SemiImplicitEuler;
    let rollout = robot_dynamics::derivatives::Rollout::new(integrator, 1e-5, 3).with_stride(1);
    let mut workspace = robot_dynamics::derivatives::RolloutPullbackWorkspace::new(m, &rollout, 0);
    let paths = ["the cotangent of the trajectory's q", "the cotangent of the trajectory's v"]
        .map(|name| argument(name, tau.repeat(3)));
    let all: Vec<_> = arguments().into_iter().chain(cotangents()).chain(paths).collect();
    probe("rollout_pullback", &all, |x| {
        let rollout = robot_dynamics::derivatives::Rollout::new(integrator, x[1][0], 3).with_stride(1);
        let (mut by_q, mut by_v, mut by_tau) = (x[4].clone(), x[5].clone(), tau.clone());
        let (w, path) = (&mut workspace, (&x[6][..], &x[7][..]));
        text(robot_dynamics::derivatives::rollout_pullback(
            m,
            &rollout,
            w,
            robot_dynamics::derivatives::RobotState { q: &x[2], v: &x[3] },
            &x[0],
            robot_dynamics::derivatives::TrajectoryCotangents { by_position: path.0, by_velocity: path.1 },
            robot_dynamics::derivatives::MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: &mut [],
            },
        ))?;
        Ok([by_q, by_v, by_tau].concat())
    });
    let torque = argument("torque", tau.clone());
    let [_, step, q, v] = arguments();
    probe("runs", &[torque, step, q, v], |x| {
        let integrator = Integrator::RungeKutta4;
        let mut simulation =
            text(SimulationBuilder::new(m).method(Method::Fixed(integrator)).dt(x[1][0]).build())?;
        let mut control = |_: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau.copy_from_slice(&x[0]);
        let ran = simulation.run_steps_from(&x[2], &x[3], 2, RunOptions::new().controller(&mut control));
        let kept = match &ran {
            Ok(run) => run,
            Err(failure) => &failure.until,
        };
        assert!(
            kept.q.iter().chain(&kept.v).chain([&kept.energy_account.now()]).all(|x| x.is_finite()),
            "{kept:?}"
        );
        text(ran).map(|run| [run.q, run.v].concat())
    });
}

/// The torque of a controller at t, q, v.
fn ask(controller: &mut dyn Controller, x: &[Vec<f64>]) -> Answer {
    let mut tau = vec![0.0; x[1].len()];
    text(controller.torque(x[0][0], &x[1], &x[2], &mut tau)).map(|()| tau)
}

#[test]
fn controllers_reject_non_finite() {
    let model = arm(7);
    let m = &model;
    let hand = last_frame(m);
    let w = &mut Workspace::new(m);
    let (q, v) = (vec![0.4; 7], vec![0.1; 7]);
    let state = || [argument("t", [0.3]), argument("q", q.clone()), argument("v", v.clone())];
    let [_, q_argument, v_argument] = state();
    probe("operational_space", &[q_argument, v_argument], |x| {
        let space = text(robot_dynamics::control::operational_space(
            m,
            w,
            &x[0],
            &x[1],
            hand,
            &FrameConstraint::WELD,
        ))?;
        let vectors = [space.bias_acceleration.as_slice(), space.bias_force.as_slice()].concat();
        Ok([space.inertia.as_slice(), space.consistent_inverse.as_slice(), &vectors].concat())
    });
    let space =
        robot_dynamics::control::operational_space(m, w, &q, &v, hand, &FrameConstraint::WELD).unwrap();
    let acceleration = || argument("the acceleration", [0.5; 6]);
    let posture = || argument("the posture's torque", [3.0; 7]);
    probe("torque", &[acceleration()], |x| text(space.torque(&x[0])).map(|tau| tau.as_slice().to_vec()));
    probe("null_torque", &[posture()], |x| text(space.null_torque(&x[0])).map(|tau| tau.as_slice().to_vec()));
    probe("torque_with_posture", &[acceleration(), posture()], |x| {
        let mut tau = vec![0.0; 7];
        text(space.torque_with_posture(&x[0], &x[1], &mut tau)).map(|()| tau)
    });

    let with = |more: Vec<Argument>| state().into_iter().chain(more).collect::<Vec<_>>();
    let gains = || vec![argument("the stiffness", [9.0; 7]), argument("the damping", [6.0; 7])];
    let mut pd = with(gains());
    pd.push(argument("q", [0.3; 7]));
    probe("GravityCompensatedPd", &pd, |x| {
        ask(&mut text(GravityCompensatedPd::new(m, &x[5], &x[3], &x[4]))?, x)
    });
    let mut computed = with(gains());
    computed.extend(["q", "v", "a"].map(|name| argument(name, [0.2; 7])));
    probe("ComputedTorque", &computed, |x| {
        let reference = |_| Reference { q: x[5].clone(), v: x[6].clone(), a: x[7].clone() };
        ask(&mut text(ComputedTorque::new(m, reference, &x[3], &x[4]))?, x)
    });
    let task = || {
        let mut task = with(vec![argument("the stiffness", [9.0]), argument("the damping", [6.0])]);
        task.push(argument("the null damping", [3.0]));
        task.push(argument("the posture's stiffness", [2.0]));
        task.push(argument("q", [0.3; 7]));
        task
    };
    let gains_of = |x: &[Vec<f64>]| TaskGains { stiffness: x[3][0], damping: x[4][0], null_damping: x[5][0] };
    let three = |x: &[f64]| [x[0], x[1], x[2]];
    let mut position = task();
    position.push(argument("the reference position", [0.1; 3]));
    position.push(argument("the reference velocity", [0.1; 3]));
    position.push(argument("the reference acceleration", [0.1; 3]));
    probe("TaskControl of a position", &position, |x| {
        let [position, velocity, acceleration] = [8, 9, 10].map(|i| three(&x[i]));
        let reference = |_| TaskReference { position, velocity, acceleration };
        let control = text(TaskControl::new(m, hand, reference, gains_of(x)))?;
        ask(&mut text(control.with_posture(&x[7], x[6][0]))?, x)
    });
    let mut whole = task();
    whole.push(argument("the reference position", [0.1; 3]));
    whole.push(argument("the reference velocity", [0.1; 3]));
    whole.push(argument("the reference acceleration", [0.1; 3]));
    whole.push(argument("the reference rotation", Pose::IDENTITY.rotation.as_flattened()));
    whole.push(argument("the reference angular velocity", [0.1; 3]));
    whole.push(argument("the reference angular acceleration", [0.1; 3]));
    probe("TaskControl of a pose", &whole, |x| {
        let rotation = std::array::from_fn(|i| three(&x[11][3 * i..]));
        let reference = |_| PoseReference {
            pose: Pose { rotation, translation: three(&x[8]) },
            velocity: Twist { linear: three(&x[9]), angular: three(&x[12]) },
            acceleration: SpatialAcceleration { linear: three(&x[10]), angular: three(&x[13]) },
        };
        let control = text(TaskControl::new(m, hand, reference, gains_of(x)))?;
        ask(&mut text(control.with_posture(&x[7], x[6][0]))?, x)
    });
    probe("ConstantTorque", &[argument("torque", [1.0; 7])], |x| {
        ask(&mut ConstantTorque(x[0].clone()), &[vec![0.0], q.clone(), v.clone()])
    });
    // The zero torque is valid at any state.
    assert_eq!(ask(&mut ZeroTorque, &[vec![f64::NAN], vec![f64::NAN; 7], vec![0.0; 7]]), Ok(vec![0.0; 7]));
}

#[test]
fn constraints_reject_non_finite() {
    let (model, [q, v, a, tau]) = tree();
    let m = &model;
    let frame = last_frame(m);
    let w = &mut Workspace::new(m);
    let place = robot_dynamics::algorithms::frame_pose(m, w, &q, frame).translation;
    let contact = [("foot", FrameConstraint::point_contact(frame, place).into())];
    let set = ConstraintSet::new(m, contact).unwrap();
    // The same contact twice: redundant rows.
    let twice = ["foot", "again"].map(|name| (name, FrameConstraint::point_contact(frame, place).into()));
    let twice = ConstraintSet::new(m, twice).unwrap();
    let q = || argument("q", q.clone());
    let v = || argument("v", v.iter().map(|v| 0.1 * v).collect::<Vec<_>>());
    let tau = || argument("tau", tau.clone());
    let options = || {
        [argument("dependence", [1e-9]), argument("Baumgarte's rate", [5.0]), argument("proximal", [1e-6])]
    };
    let options_of = |x: &[Vec<f64>]| ConstraintOptions {
        dependence: x[0][0],
        stabilization: Some(Baumgarte { rate: x[1][0] }),
        redundant: RedundantRows::Proximal { damping: x[2][0] },
        ..Default::default()
    };
    let with = |more: Vec<Argument>| options().into_iter().chain(more).collect::<Vec<_>>();
    let flat = |vectors: [&DVector<f64>; 2]| [vectors[0].as_slice(), vectors[1].as_slice()].concat();
    for set in [&set, &twice] {
        probe("constrained_forward_dynamics", &with(vec![q(), v(), tau()]), |x| {
            let options = options_of(x);
            let motion = text(robot_dynamics::constraints::constrained_forward_dynamics(
                m, w, set, &options, &x[3], &x[4], &x[5],
            ))?;
            Ok([flat([&motion.acceleration, &motion.multipliers]), vec![motion.residual]].concat())
        });
        probe("constrained_inverse_dynamics", &[q(), v(), argument("a", a.clone())], |x| {
            let motors = vec![true; m.nv()];
            let found = text(robot_dynamics::constraints::constrained_inverse_dynamics(
                m, w, set, &x[0], &x[1], &x[2], &motors,
            ))?;
            Ok([flat([&found.tau, &found.multipliers]), vec![found.residual]].concat())
        });
    }
    probe("contact_impulse", &with(vec![q(), v(), argument("the restitution", [0.5])]), |x| {
        if (x[5][0] - 0.5).abs() > 0.5 && x[5][0].is_finite() {
            return Err("no restitution".into()); // a wrong call panics
        }
        let options = options_of(x);
        let jump =
            text(robot_dynamics::constraints::contact_impulse(m, w, &set, &options, &x[3], &x[4], x[5][0]))?;
        Ok([flat([&jump.velocity, &jump.impulse]), vec![jump.energy_lost]].concat())
    });
    probe("project_position", &with(vec![q(), argument("the tolerance", [1e-9])]), |x| {
        let mut q = x[3].clone();
        let projected =
            robot_dynamics::constraints::project_position(m, w, &set, &options_of(x), x[4][0], &mut q);
        text(projected).map(|found| [q, vec![found.before, found.after]].concat())
    });
    probe("project_velocity", &with(vec![q(), v()]), |x| {
        let mut v = x[4].clone();
        let projected =
            robot_dynamics::constraints::project_velocity(m, w, &set, &options_of(x), &x[3], &mut v);
        if projected.is_err() {
            assert!(v.iter().zip(&x[4]).all(|(a, b)| a.to_bits() == b.to_bits()), "v changed");
        }
        text(projected).map(|energy| [v, vec![energy]].concat())
    });
    probe("constraint_projections", &with(vec![q()]), |x| {
        let found =
            text(robot_dynamics::constraints::constraint_projections(m, w, &set, &options_of(x), &x[3]))?;
        Ok([found.force.as_slice(), found.velocity.as_slice()].concat())
    });
    // On A v = 0.
    let mut allowed = v().good;
    robot_dynamics::constraints::project_velocity(
        m,
        w,
        &set,
        &ConstraintOptions::default(),
        &q().good,
        &mut allowed,
    )
    .unwrap();
    let v = || argument("v", allowed.clone());
    let step = || argument("step", [1e-5]);
    for integrator in
        [Integrator::RungeKutta4, Integrator::VariationalMidpoint, Integrator::VariationalYoshida4]
    {
        let options_of = |x: &[Vec<f64>]| ConstraintOptions {
            stabilization: (integrator == Integrator::RungeKutta4).then_some(Baumgarte { rate: x[1][0] }),
            integrator,
            ..options_of(x)
        };
        let mut arguments = with(vec![q(), v(), tau(), step(), argument("the tolerance", [1e-9])]);
        if integrator != Integrator::RungeKutta4 {
            arguments[1].good.clear();
        }
        // Options without a Baumgarte rate get one that is not used.
        let filled = |x: &[Vec<f64>]| {
            let mut x = x.to_vec();
            x[1].resize(1, 1.0);
            x
        };
        probe("constrained_step", &arguments, |x| {
            let x = &filled(x);
            let (mut q, mut v) = (x[3].clone(), x[4].clone());
            let forces = StepForces::new(&x[5], true);
            let correction = DriftCorrection::Position { tolerance: x[7][0] };
            let (options, h) = (options_of(x), x[6][0]);
            text(robot_dynamics::constraints::constrained_step(
                m,
                w,
                robot_dynamics::constraints::StepConstraints { set: &set, options: &options, correction },
                &forces,
                h,
                &mut q,
                &mut v,
            ))?;
            Ok([q, v].concat())
        });
        arguments[5].name = "torque";
        probe("constrained runs", &arguments, |x| {
            let x = &filled(x);
            let correction = DriftCorrection::Position { tolerance: x[7][0] };
            let builder = SimulationBuilder::new(m)
                .method(Method::Fixed(integrator))
                .constraints(set.clone())
                .constraint_options(options_of(x), correction);
            let mut simulation = text(builder.dt(x[6][0]).build())?;
            let mut control = |_: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau.copy_from_slice(&x[5]);
            let ran = simulation.run_steps_from(
                &x[3],
                &x[4],
                2,
                RunOptions::new().sample_ends().controller(&mut control),
            );
            let kept = match &ran {
                Ok(run) => run,
                Err(failure) => &failure.until,
            };
            assert!(kept.q.iter().chain(&kept.v).all(|x| x.is_finite()), "{kept:?}");
            text(ran).map(|run| [run.q, run.v].concat())
        });
    }
}

#[test]
fn constraint_sets_reject_non_finite() {
    let (model, [q, ..]) = tree();
    let m = &model;
    let frame = last_frame(m);
    let w = &mut Workspace::new(m);
    let mut set_of = |constraint: robot_dynamics::constraints::Constraint| -> Answer {
        let set = text(ConstraintSet::new(m, [("one", constraint)]))?;
        let rows = set.rows(m, w, &q, &vec![0.0; m.nv()]);
        let finite = rows.matrix.iter().all(|x| x.is_finite());
        Ok(if finite { rows.matrix.as_slice().to_vec() } else { vec![0.0] })
    };
    let name = model.coordinate_names()[m.nv() - 1].clone();
    probe("Coupling::new", &[argument("coefficient", [1.5]), argument("offset", [0.2])], |x| {
        set_of(text(Coupling::new(m, &[(&name, x[0][0])], x[1][0]))?.into())
    });
    probe("an anchor", &[argument("anchor", Pose::IDENTITY.rotation.as_flattened())], |x| {
        let rotation = std::array::from_fn(|i| [x[0][3 * i], x[0][3 * i + 1], x[0][3 * i + 2]]);
        set_of(
            FrameConstraint::contact(frame, Pose { rotation, translation: [0.0; 3] }, &FrameConstraint::BALL)
                .into(),
        )
    });
    probe("an anchor", &[argument("anchor", [0.1; 3])], |x| {
        set_of(FrameConstraint::point_contact(frame, [x[0][0], x[0][1], x[0][2]]).into())
    });
    let disc = [argument("axle", [0.0, 1.0, 0.3]), argument("radius", [0.2]), argument("plane", [0.1])];
    probe("a disc", &disc, |x| {
        let disc = RollingDisc::on_floor(frame, [x[0][0], x[0][1], x[0][2]], x[1][0]);
        set_of(RollingDisc { plane: Plane::level(x[2][0]), ..disc }.into())
    });
}

#[test]
fn identification_and_timing_reject_non_finite() {
    let model = arm(3);
    let m = &model;
    let nv = m.nv();
    let states = || ["q", "v", "a", "tau"].map(|name| argument(name, vec![0.3; nv]));
    probe("MotionRecord::push", &states(), |x| {
        let mut record = MotionRecord::new(m, true);
        text(record.push(&x[0], &x[1], &x[2], &x[3]))?;
        assert_eq!(record.len(), 1);
        let base = BaseParameters::of(m, 60, 1);
        let mut random = SplitMix64::new(3);
        for _ in 0..60 {
            let state = random_state(m, &mut random);
            text(record.push(&state.q, &state.v, &state.a, &state.tau))?;
        }
        text(base.identify(&record)).map(|found| found.values.as_slice().to_vec())
    });
    let base = BaseParameters::of(m, 60, 1);
    let prior = robot_dynamics::algorithms::inertial_parameters(m);
    let prior = || argument("the inertial parameters", prior.clone());
    probe("values", &[prior()], |x| text(base.values(&x[0])).map(|values| values.as_slice().to_vec()));
    let values = argument("the base values", vec![0.1; base.len()]);
    probe("nearest_parameters", &[values, prior()], |x| {
        let values = DVector::from_column_slice(&x[0]);
        text(base.nearest_parameters(&values, &x[1])).map(|found| found.as_slice().to_vec())
    });
    probe("physical_consistency", &[prior()], |x| {
        let found = text(robot_dynamics::control::physical_consistency(m, &x[0]))?;
        Ok(found.iter().flat_map(|link| [link.mass, link.smallest, link.largest]).collect())
    });

    let limit = |name, good: f64| Argument { may_be_infinite: true, ..argument(name, vec![good; nv]) };
    let speed = |name| argument(name, [0.01]);
    let limits = [limit("torque", 300.0), limit("velocity", 3.0), speed("start"), speed("end")];
    let path = CubicSpline::through(&[vec![0.0; 3], vec![0.5, -0.2, 0.8], vec![0.2; 3]]).unwrap();
    let options_of = |x: &[Vec<f64>]| {
        let limits = MotionLimits::new(x[0].clone(), x[1].clone());
        let options = TimeOptimal::from_rest_to_rest(limits, 20);
        TimeOptimal { start_speed: x[2][0], end_speed: x[3][0], ..options }
    };
    let times = |timed: robot_dynamics::control::TimedPath| [timed.times(), timed.squared_speeds()].concat();
    probe("time_optimal", &limits, |x| {
        text(robot_dynamics::control::time_optimal(m, &path, &options_of(x))).map(times)
    });
    let good = [vec![300.0; nv], vec![3.0; nv], vec![0.0], vec![0.0]];
    // The position in the message is s.
    let points = ["not finite", "not finite", "not finite"].map(|name| argument(name, vec![0.2; nv]));
    probe("time_optimal along a path", &points, |x| {
        let point = |_| TreePathPoint { q: x[0].clone(), dq: x[1].clone(), ddq: x[2].clone() };
        text(robot_dynamics::control::time_optimal(m, &(point, 0.0..=0.1), &options_of(&good))).map(times)
    });
    probe("time_optimal over s", &[argument("s = ", [0.0, 0.1])], |x| {
        let point = |_| TreePathPoint { q: vec![0.2; nv], dq: vec![0.1; nv], ddq: vec![0.0; nv] };
        text(robot_dynamics::control::time_optimal(m, &(point, x[0][0]..=x[0][1]), &options_of(&good)))
            .map(times)
    });
    let waypoints = [0, 1, 2].map(|k| argument("waypoint", vec![0.3 * f64::from(k); 3]));
    probe("CubicSpline::through", &waypoints, |x| {
        let path = text(CubicSpline::through(x))?;
        let at = robot_dynamics::control::TreePath::at(&path, 0.3);
        Ok([at.q, at.dq, at.ddq, path.knots().to_vec()].concat())
    });
}

#[test]
fn batches_reject_non_finite() {
    let (model, [q, v, a, tau]) = tree();
    let m = &model;
    let nv = m.nv();
    let frame = last_frame(m);
    // Blocks of several widths, the last one partly filled.
    let count = 3;
    // The error names the index of the state, not the quantity.
    let table = |row: &[f64]| argument("states are bad", row.repeat(count));
    let states = || [table(&q), table(&v), table(&a)];
    let [only_q, ..] = states();
    let only_q = [only_q];
    let w = &mut BatchWorkspace::new(m);
    macro_rules! calls {
        ($arguments:expr; $($call:ident($($i:literal),*) -> $width:expr;)*) => {$(
            probe(stringify!($call), &$arguments, |x| {
                let mut out = vec![0.0; count * $width];
                text(batch::$call(m, w, $(&x[$i],)* &mut out)).map(|()| out)
            });
        )*};
    }
    calls! { states(); inverse_dynamics(0, 1, 2) -> nv; forward_dynamics(0, 1, 2) -> nv; }
    calls! { states()[..2]; bias(0, 1) -> nv; }
    calls! { only_q; gravity(0) -> nv; mass_matrix(0) -> nv * nv; inverse_mass_matrix(0) -> nv * nv; }
    for seen in ReferenceFrame::ALL {
        probe("batch J", &only_q, |x| {
            let mut out = vec![0.0; count * 6 * nv];
            text(batch::frame_jacobian(m, w, &x[0], frame, seen, &mut out)).map(|()| out)
        });
    }
    probe("batch::frame_poses", &only_q, |x| {
        let mut out = vec![0.0; count * 12];
        text(batch::frame_poses(m, w, &x[0], &[frame], &mut out)).map(|()| out)
    });
    probe("batch::inverse_dynamics_derivatives", &states(), |x| {
        let [mut by_q, mut by_v] = [(); 2].map(|()| vec![0.0; count * nv * nv]);
        text(batch::inverse_dynamics_derivatives(
            m,
            w,
            &x[0],
            &x[1],
            &x[2],
            batch::InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v },
        ))?;
        Ok([by_q, by_v].concat())
    });
    probe("batch::forward_dynamics_derivatives", &states(), |x| {
        let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![0.0; count * nv * nv]);
        let out = batch::ForwardDynamicsDerivativesMut {
            by_position: &mut by_q,
            by_velocity: &mut by_v,
            by_force: &mut by_tau,
        };
        let done = batch::forward_dynamics_derivatives(m, w, &x[0], &x[1], &x[2], out);
        text(done).map(|()| [by_q, by_v, by_tau].concat())
    });
    for (integrator, steps) in
        [(Integrator::SemiImplicitEuler, 2), (Integrator::RungeKutta4, 2), (Integrator::RungeKutta4, 0)]
    {
        let tables = [table(&q), table(&v), argument("the step", [1e-5])];
        let tables = || tables.iter().map(|t| argument(t.name, t.good.clone()));
        let mut run = |x: &[Vec<f64>], torques: Torques<'_, f64>| {
            let (mut q, mut v) = (x[0].clone(), x[1].clone());
            let how = Rollout::new(integrator, x[2][0], steps);
            let done = batch::rollout(m, w, &how, torques, batch::RolloutStates::ends(&mut q, &mut v), None);
            text(done).map(|()| [q, v].concat())
        };
        let free: Vec<Argument> = tables().collect();
        probe("batch::rollout", &free, |x| run(x, Torques::Zero));
        if steps > 0 {
            let held: Vec<Argument> = tables().chain([table(&tau)]).collect();
            probe("batch::rollout with held torques", &held, |x| run(x, Torques::Held(&x[3])));
            let each = argument("states are bad", tau.repeat(count * steps));
            let each: Vec<Argument> = tables().chain([each]).collect();
            probe("batch::rollout with torques of each step", &each, |x| run(x, Torques::EachStep(&x[3])));
        }
    }
}

#[test]
fn edits_reject_non_finite() {
    let description = arm(3).description().clone();
    let joint = description.joints.iter().find(|joint| joint.kind.nq() == 1).unwrap().name.clone();
    probe("lock_joint", &[argument("the position of joint", [0.3])], |x| {
        let mut robot = description.clone();
        text(robot.lock_joint(&joint, &x[0])).map(|()| vec![0.0])
    });
    probe("scale_gravity", &[argument("gravity", [0.5])], |x| {
        let mut robot = description.clone();
        text(robot.scale_gravity(x[0][0])).map(|()| robot.gravity.to_vec())
    });
}

/// The closed-loop run of the chapter's PD control.
#[test]
fn hold_of_chapter_rejects_non_finite() {
    let two = |x: &[f64]| SVector::<f64, 2>::new(x[0], x[1]);
    let arguments = [
        argument("q*", [1.6, 0.4]),
        argument("Kp", [60.0, 30.0]),
        argument("Kd", [20.0, 6.0]),
        argument("q", [1.4, 0.2]),
        argument("qd", [0.0, 0.1]),
        argument("the step", [1e-3]),
        argument("the band", [0.01]),
    ];
    probe("hold", &arguments, |x| {
        if x[5][0] <= 0.0 && x[5][0].is_finite() {
            return Err("no step".into()); // a wrong call panics
        }
        let limits = SVector::<f64, 2>::new(20.0, 12.0);
        let control = PdHold { target: two(&x[0]), stiffness: two(&x[1]), damping: two(&x[2]), limits };
        let run = dynamics::HoldRun { step: x[5][0], steps: 3, band: x[6][0] };
        let report = text(hold(&Reach2R::worked_example(), &control, &two(&x[3]), &two(&x[4]), &run))?;
        Ok([report.q, report.qd, report.peak_torque, report.peak_demand, report.overshoot]
            .iter()
            .flat_map(|x| [x[0], x[1]])
            .collect())
    });
}

#[cfg(feature = "adaptive")]
#[test]
fn adaptive_runs_reject_non_finite() {
    use robot_dynamics::simulation::{AdaptiveOptions, ControlTiming, Effect, Event};
    let (model, [q, v, _, tau]) = tree();
    let m = &model;
    let arguments = [
        argument("q", q),
        argument("v", v.iter().map(|v| 0.1 * v).collect::<Vec<_>>()),
        argument("step", [1e-4]),
        argument("tolerance", [1e-6]),
        argument("torque", tau),
        argument("event", [1.0]),
        argument("period", [1e-4]),
    ];
    for held in [false, true] {
        let mut arguments: Vec<Argument> =
            arguments.iter().map(|x| argument(x.name, x.good.clone())).collect();
        if !held {
            arguments[6].good.clear();
        }
        probe("adaptive runs", &arguments, |x| {
            let control =
                if held { ControlTiming::Held { period: x[6][0] } } else { ControlTiming::Continuous };
            let options = AdaptiveOptions {
                tolerance: x[3][0],
                control,
                max_steps: 1000,
                ..AdaptiveOptions::default()
            };
            let builder = SimulationBuilder::new(m).without(Effect::Dissipation).adaptive(options);
            let mut simulation = text(builder.dt(x[2][0]).build())?;
            let mut torque = |_: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau.copy_from_slice(&x[4]);
            let mut events = [Event::new("one", |_, _: &[f64], _: &[f64]| x[5][0])];
            let options = RunOptions::new().controller(&mut torque).events(&mut events);
            let ran = simulation.run_steps_from(&x[0], &x[1], 2, options);
            let kept = match &ran {
                Ok(run) => run,
                Err(failure) => &failure.until,
            };
            assert!(kept.q.iter().chain(&kept.v).all(|x| x.is_finite()), "{kept:?}");
            text(ran).map(|run| [run.q, run.v].concat())
        });
    }
}
