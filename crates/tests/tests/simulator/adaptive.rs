//! Adaptive steps as a method of `Simulation`.

use robot_dynamics::description::{
    Activation, ActuatorDescription, JointKinds, Limits, PassiveForces, RandomRobotOptions,
    TendonDescription, Transmission, pendulum, random_robot,
};
use robot_dynamics::model::{Model, neutral};
use robot_dynamics::simulation::{
    AdaptiveOptions, AppliedWrench, ControlTiming, Effect, Integrator, Method, RunOptions, Simulation,
    SimulationBuilder, StepForces, StepInfo, StepWorkspace, Stepper,
};

fn to(tolerance: f64) -> AdaptiveOptions {
    AdaptiveOptions { tolerance, ..AdaptiveOptions::default() }
}

/// A random robot with damping; limits of position and effort are left out.
fn builder(seed: u64) -> SimulationBuilder<'static> {
    let mut robot = random_robot(seed, &RandomRobotOptions { massless: 0.0, ..Default::default() });
    for joint in &mut robot.joints {
        joint.passive = PassiveForces::default().with_damping(0.05);
    }
    SimulationBuilder::new(&Model::new(robot).unwrap()).without(Effect::EffortLimits)
}

/// Starts from neutral with speeds, torques and a wrench on the last link, which turns with the link.
fn start(simulation: &mut Simulation) {
    let (q, nv) = (neutral(simulation.model()), simulation.model().nv());
    let v: Vec<f64> = (0..nv).map(|k| 0.3 * (k as f64).cos()).collect();
    simulation.reset(&q, &v).unwrap();
    let torques: Vec<f64> = (0..nv).map(|k| 0.1 * (k as f64 + 1.0).sin()).collect();
    simulation.set_torques(&torques);
    let model = simulation.model();
    let last = model.frame(&model.frames().last().unwrap().name).unwrap();
    let axes = robot_dynamics::algorithms::ReferenceFrame::Local;
    let wrench = AppliedWrench { frame: last, axes, force: [0.3, -0.2, 0.5], moment: [0.0, 0.1, 0.05] };
    simulation.set_wrenches(&[wrench]);
}

/// Single steps, runs and small steps of order 4 reach the same state. The energy account closes and includes
/// the work of the wrench.
#[test]
fn steps_runs_and_small_fixed_steps_agree() {
    for seed in 0..4 {
        let mut run = builder(seed).adaptive(to(1e-11)).dt(0.05).build().unwrap();
        let mut steps = run.clone();
        let row = Method::Fixed(Integrator::RungeKutta4);
        let [mut coarse, mut fine] = [2e-4, 1e-4].map(|h| builder(seed).method(row).dt(h).build().unwrap());
        for simulation in [&mut run, &mut steps, &mut coarse, &mut fine] {
            start(simulation);
        }
        let ran = run.run_steps(4, RunOptions::new()).unwrap();
        steps.run_for(0.2).unwrap();
        coarse.run_for(0.2).unwrap();
        fine.run_for(0.2 - 1e-4).unwrap();
        let before = fine.acceleration().to_vec();
        fine.step().unwrap();
        assert_eq!((run.steps(), steps.steps(), steps.time()), (4, 4, run.time()));
        for (k, q) in run.q().iter().enumerate() {
            assert!((q - steps.q()[k]).abs() < 1e-9, "robot {seed}: {:?} {:?}", run.q(), steps.q());
            // Steps of fixed length hold the generalized force of the wrench. That causes an error of first
            // order in h, which extrapolation removes, and h² = 4e-8 times derivatives of order one to ten.
            let extrapolated = 2.0 * fine.q()[k] - coarse.q()[k];
            assert!((q - extrapolated).abs() < 1e-7, "robot {seed}: {q} {extrapolated}");
        }
        assert!(ran.energy_account.max_imbalance() < 1e-9 && steps.energy_account().max_imbalance() < 1e-9);
        assert!((ran.energy_account.work() - steps.energy_account().work()).abs() < 1e-9);
        // The acceleration is that at the end of the run; the fine steps report that of their midpoints.
        for ((a, mean), before) in run.acceleration().iter().zip(fine.acceleration()).zip(before) {
            let end = 1.5 * mean - 0.5 * before;
            assert!((a - end).abs() < 1e-3 * (1.0 + end.abs()), "{a} {end}");
        }
    }
}

/// A snapshot also restores the length of the next step: the results are equal bit for bit.
#[test]
fn restored_steps_are_equal_bit_for_bit() {
    let mut simulation = builder(1).adaptive(to(1e-8)).dt(0.01).build().unwrap();
    start(&mut simulation);
    simulation.run_for(0.1).unwrap();
    let snapshot = simulation.snapshot();
    simulation.run_for(0.1).unwrap();
    let first = (simulation.q().to_vec(), *simulation.adaptive_record().unwrap());
    simulation.restore(&snapshot);
    simulation.run_for(0.1).unwrap();
    assert_eq!((simulation.q().to_vec(), *simulation.adaptive_record().unwrap()), first);
}

/// Torques are cut off at the effort limit, with continuous control and with a control period, and the limit
/// is reported at each sample.
#[test]
fn effort_limits_hold() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits = Limits::default().with_effort(3.0);
    let model = Model::new(robot).unwrap();
    for control in [ControlTiming::Continuous, ControlTiming::Held { period: 0.1 }] {
        let options = AdaptiveOptions { control, ..to(1e-10) };
        let ends = [3.0, 50.0].map(|torque| {
            let mut simulation = SimulationBuilder::new(&model).adaptive(options).dt(0.1).build().unwrap();
            let mut push = |_: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau[0] = torque;
            let run = simulation
                .run_steps_from(&[0.1], &[0.0], 5, RunOptions::new().controller(&mut push))
                .unwrap();
            assert_eq!((run.peak_torque[0], simulation.applied_torques()), (3.0, &[3.0][..]));
            let count = if torque > 3.0 { 5 } else { 0 };
            assert_eq!(simulation.steps_at_effort_limits(), [count]);
            run.q
        });
        assert_eq!(ends[0], ends[1]);
    }
}

/// Without an observer only the kept samples are evaluated; an observer sees every step.
#[test]
fn observer_sees_every_step() {
    let model = Model::new(pendulum(2.0, 0.5)).unwrap();
    let mut simulation = SimulationBuilder::new(&model).adaptive(to(1e-9)).dt(0.01).build().unwrap();
    let mut seen = Vec::new();
    let mut observer = |info: &StepInfo<'_>| {
        seen.push(info.time);
        std::ops::ControlFlow::Continue(())
    };
    let options = RunOptions::new().sample_every(4).observer(&mut observer);
    let run = simulation.run_steps_from(&[0.3], &[0.0], 10, options).unwrap();
    let times: Vec<f64> = run.trajectory.iter().map(|sample| sample.time).collect();
    assert_eq!(seen, (0..=10).map(|k| f64::from(k) * 0.01).collect::<Vec<_>>());
    assert_eq!(times, [0, 4, 8, 10].map(|k: u32| f64::from(k) * 0.01));
    let alone = simulation.run_steps_from(&[0.3], &[0.0], 10, RunOptions::new().sample_every(4)).unwrap();
    assert_eq!(alone.trajectory, run.trajectory);
}

/// As the stepper of a batch it takes the same steps as the simulation.
#[test]
fn stepper_takes_the_same_steps() {
    let mut simulation = builder(2).adaptive(to(1e-10)).dt(0.02).build().unwrap();
    let model = simulation.model().clone();
    let (mut q, mut v) = (neutral(&model), vec![0.2; model.nv()]);
    simulation.reset(&q, &v).unwrap();
    simulation.step().unwrap();
    let rest = vec![0.0; model.nv()];
    let (forces, workspace) = (StepForces::new(&rest, true), &mut StepWorkspace::new(&model));
    simulation.stepper().step(&model, workspace, &forces, 0.02, &mut q, &mut v).unwrap();
    for (found, expected) in q.iter().chain(&v).zip(simulation.q().iter().chain(simulation.v())) {
        assert!((found - expected).abs() < 1e-14 * (1.0 + expected.abs()), "{found} {expected}");
    }
}

/// A servo with activation dynamics, a tendon with a spring and a damper, and a damped hinge. Adaptive steps,
/// steps of order 4 and the energy account agree. The activation and the actuator's force at the end follow
/// their laws.
#[test]
fn actuators_and_tendons_act() {
    let options = RandomRobotOptions { massless: 0.0, kinds: JointKinds::Turning, ..Default::default() };
    let mut robot = random_robot(5, &options);
    robot.joints.iter_mut().for_each(|joint| joint.passive = PassiveForces::default().with_damping(0.05));
    let names: Vec<String> = {
        let model = Model::new(robot.clone()).unwrap();
        model.joints().iter().filter(|joint| joint.nv == 1).map(|joint| joint.name.clone()).collect()
    };
    let mut servo =
        ActuatorDescription::new("servo", Transmission::joint(names[0].clone(), 1.0)).servo(5.0, 0.5);
    servo.activation = Activation::Filter { time_constant: 0.05 };
    robot.actuators.push(servo);
    let mut cable = TendonDescription::new("cable", [(names[1].clone(), 0.3), (names[2].clone(), -0.2)]);
    cable.passive = PassiveForces::default().with_spring(20.0, 0.1).with_damping(0.4);
    robot.tendons.push(cable);
    let model = Model::new(robot).unwrap();
    let builder = || SimulationBuilder::new(&model).without(Effect::EffortLimits).without(Effect::Limits);
    let mut run = builder().adaptive(to(1e-11)).dt(0.05).build().unwrap();
    assert!(run.left_out().is_empty(), "{:?}", run.left_out());
    assert_eq!(run.acting(), [Effect::Dissipation, Effect::Springs, Effect::Actuators]);
    let mut steps = run.clone();
    let mut fixed = builder().method(Method::Fixed(Integrator::RungeKutta4)).dt(5e-5).build().unwrap();
    let v: Vec<f64> = (0..model.nv()).map(|k| 0.3 * (k as f64).cos()).collect();
    for simulation in [&mut run, &mut steps, &mut fixed] {
        simulation.reset(&neutral(&model), &v).unwrap();
        simulation.set_controls(&[0.7]);
    }
    let ran = run.run_steps(8, RunOptions::new()).unwrap();
    steps.run_for(0.4).unwrap();
    fixed.run_for(0.4).unwrap();
    for (k, q) in run.q().iter().enumerate() {
        // h⁴ = 6e-18 times derivatives of order one to ten, and the rounding of 8000 steps.
        assert!((q - fixed.q()[k]).abs() < 1e-10, "{:?} {:?}", run.q(), fixed.q());
        assert!((q - steps.q()[k]).abs() < 1e-9, "{:?} {:?}", run.q(), steps.q());
    }
    let (energy_account, small) = (&ran.energy_account, fixed.energy_account());
    assert!(energy_account.max_imbalance() < 1e-9 && steps.energy_account().max_imbalance() < 1e-9);
    assert!(
        (energy_account.work() - small.work()).abs() < 1e-8 && energy_account.work().abs() > 1e-2,
        "{}",
        energy_account.work()
    );
    assert!((energy_account.dissipated() - small.dissipated()).abs() < 1e-8);
    let activation = 0.7 * (1.0 - (-0.4_f64 / 0.05).exp());
    for simulation in [&run, &steps] {
        assert!((simulation.activations()[0] - activation).abs() < 1e-12);
        let hinge = model.joints().iter().find(|joint| joint.name == names[0]).unwrap();
        let (q, v) = (simulation.q()[hinge.q_index], simulation.v()[hinge.v_index]);
        let force = 5.0 * (activation - q) - 0.5 * v;
        assert!((simulation.actuator_forces()[0] - force).abs() < 1e-12);
    }
}
