//! Torques and wrenches that a user sets act beside tendons and actuators, under every method.

use robot_dynamics::algorithms::{FrameWrench, ReferenceFrame, forward_dynamics_with_wrenches};
use robot_dynamics::description::{
    ActuatorDescription, JointDescription, Limits, PassiveForces, RandomRobotOptions, TendonDescription,
    Transmission, random_robot,
};
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Actuation, AppliedWrench, Effect, Integrator, Method, SimulationBuilder, StepScheme,
};

/// A random robot with a motor and a spring over its joints; the joints themselves have no friction.
fn robot(seed: u64) -> Option<Model> {
    let options = RandomRobotOptions { joints: 5, massless: 0.0, ..RandomRobotOptions::default() };
    let mut robot = random_robot(seed, &options);
    for joint in &mut robot.joints {
        joint.passive = PassiveForces::default();
        joint.limits = Limits::default();
    }
    let single = |joint: &&JointDescription| joint.kind.nv() == 1 && joint.mimic.is_none();
    let names: Vec<String> = robot.joints.iter().filter(single).map(|joint| joint.name.clone()).collect();
    let [first, second, ..] = &names[..] else { return None };
    let mut spring = TendonDescription::new("spring", [(first.clone(), 1.0), (second.clone(), -0.5)]);
    spring.passive = PassiveForces::default().with_spring(20.0, 0.1);
    robot.tendons.push(spring);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint(second, 3.0)));
    Model::new(robot).ok()
}

#[test]
fn torques_act_beside_actuators() {
    let rows = Integrator::ALL.into_iter().map(Method::Fixed);
    for method in rows.chain([Method::Implicit, Method::Mujoco]) {
        let mut tested = 0;
        for seed in 0..12 {
            let Some(model) = robot(seed) else { continue };
            let h = 1e-6;
            let built =
                SimulationBuilder::new(&model).dt(h).method(method).without(Effect::EffortLimits).build();
            let Ok(mut simulation) = built else { continue };
            let RandomState { q, v, tau, .. } = random_state(&model, &mut SplitMix64::new(seed));
            let frame = model.frame_named(&model.links().last().expect("a link").name).expect("its frame");
            let wrench =
                FrameWrench { frame, force_in_frame: [0.0, 2.0, -3.0], moment_in_frame: [0.4, 0.0, 0.0] };
            simulation.reset(&q, &v).expect("a state");
            simulation.set_torques(&tau);
            // Other methods leave tendons and actuators out, and say so.
            let is_driven = simulation.control_names().count() > 0;
            if is_driven {
                simulation.set_controls(&[1.5]);
            }
            let axes = ReferenceFrame::Local;
            let (force, moment) = (wrench.force_in_frame, wrench.moment_in_frame);
            simulation.set_wrenches(&[AppliedWrench { frame, axes, force, moment }]);
            simulation.step().expect("a step");
            // The same forces at once.
            let actuation = Actuation::new(&model).expect("its actuators");
            let mut forces = vec![0.0; model.nv()];
            if is_driven {
                actuation.forces(&model, &mut actuation.workspace(), &[1.5], &q, &v, &mut forces);
            }
            forces.iter_mut().zip(&tau).for_each(|(force, tau)| *force += tau);
            let mut a = vec![0.0; model.nv()];
            let w = &mut Workspace::new(&model);
            forward_dynamics_with_wrenches(&model, w, &q, &v, &forces, &[wrench], &mut a);
            let size = a.iter().fold(1.0, |most: f64, a| most.max(a.abs()));
            for k in 0..model.nv() {
                let found = (simulation.v()[k] - v[k]) / h;
                assert!((found - a[k]).abs() < 1e-3 * size, "{}, {seed}: {found} {}", method.name(), a[k]);
            }
            tested += usize::from(is_driven);
        }
        println!("{}: {tested}", method.name());
        let is_explicit =
            matches!(method, Method::Fixed(row) if matches!(row.scheme(), StepScheme::Explicit(_)));
        assert_eq!(tested > 5, is_explicit || !matches!(method, Method::Fixed(_)), "{}", method.name());
    }
}

/// The energy that set torques and controls put in is what the robot gains.
#[test]
fn work_of_torques_beside_actuators_is_accounted() {
    let mut tested = 0;
    for seed in 0..12 {
        let Some(model) = robot(seed) else { continue };
        let built =
            SimulationBuilder::new(&model).dt(1e-4).method(Method::Fixed(Integrator::RungeKutta4)).build();
        let Ok(mut simulation) = built else { continue };
        let RandomState { q, tau, .. } = random_state(&model, &mut SplitMix64::new(seed));
        simulation.reset(&q, &vec![0.0; model.nv()]).expect("a state");
        simulation.set_torques(&tau);
        simulation.set_controls(&[0.5]);
        simulation.run_for(0.1).expect("a run");
        let account = simulation.energy_account();
        assert!(account.work().abs() > 1e-3 && account.relative_imbalance() < 1e-8, "{seed}: {account:?}");
        tested += 1;
    }
    assert!(tested > 5, "{tested}");
}
