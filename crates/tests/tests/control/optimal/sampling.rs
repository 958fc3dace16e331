//! Sampling: the solution of a linear-quadratic problem by FDDP, a swing-up, bounds, threads, failures.

use robot_dynamics::control::optimal::{
    ControlBounds, ControlResidual, Cost, Fddp, FddpOptions, Problem, Sampling, SamplingLaw, SamplingOptions,
    SmoothStep, StateResidual, Termination,
};
use robot_dynamics::description::pendulum;
use robot_dynamics::model::Model;
use robot_dynamics::nalgebra::dmatrix;
use robot_dynamics::simulation::Integrator;

use super::linear_problem;

const MPPI: SamplingLaw = SamplingLaw::Mppi { temperature: 0.05 };
const CEM: SamplingLaw = SamplingLaw::CrossEntropy { elites: 24, least_deviation: 0.02 };

/// A mass of 1 kg that is pushed to the origin.
fn mass() -> Problem {
    let (a, b) = (dmatrix![1.0, 0.2; 0.0, 1.0], dmatrix![0.02; 0.2]);
    linear_problem((&a, &b), (&[1.0, 0.1], &[0.1], &[10.0, 1.0]), &[1.0, 0.0], 8)
}

fn options(law: SamplingLaw, deviation: f64) -> SamplingOptions {
    let mut options = SamplingOptions::new(law, &[deviation]);
    options.seed = 7;
    options.iterations = 60;
    options
}

/// The Riccati solution is the minimum. Both laws close all but 1 % of the gap between the start and it; the
/// noise of the last mean keeps them from the rest.
#[test]
fn samples_approach_the_solution_of_a_linear_quadratic_problem() {
    let mut exact = Fddp::new(mass(), FddpOptions::default()).expect("options");
    let minimum = exact.solve().expect("a solution").cost;
    for law in [MPPI, CEM] {
        let mut sampling = Sampling::new(mass(), options(law, 0.5)).expect("options");
        let report = sampling.solve().expect("a solution");
        let share = (report.cost - minimum) / (report.initial_cost - minimum);
        assert!((0.0..1e-2).contains(&share), "{law:?}: {share} of {minimum}, {report:?}");
        assert_eq!((report.termination, report.iterations), (Termination::IterationLimit, 60));
        // The cost that is reported is that of the controls, by another rollout.
        let controls: Vec<Vec<f64>> = (0..8).map(|k| sampling.control(k).to_vec()).collect();
        exact.set_rollout(&controls).expect("a rollout");
        let states: f64 =
            (0..8).map(|k| 0.5 * (exact.state(k)[0].powi(2) + 0.1 * exact.state(k)[1].powi(2))).sum();
        let efforts: f64 = controls.iter().map(|u| 0.05 * u[0] * u[0]).sum();
        let last = 5.0 * exact.state(8)[0].powi(2) + 0.5 * exact.state(8)[1].powi(2);
        assert!((report.cost - states - efforts - last).abs() < 1e-12, "{report:?}");
        // The best cost never rises.
        let log = sampling.log();
        assert!(log.windows(2).all(|pair| pair[1].best_cost <= pair[0].best_cost));
        assert!(log.iter().all(|record| (1.0 - 1e-12..=256.0).contains(&record.effective_samples)));
    }
}

/// A pendulum with a motor too weak to lift it: at most half the torque that its weight needs.
fn swing_up() -> Problem {
    let (mass, length, nodes, h) = (1.0, 0.5, 60, 0.05);
    let model = Model::new(pendulum(mass, length)).expect("a robot");
    let step = SmoothStep::new(model, Integrator::SemiImplicitEuler, h).expect("a step");
    let hanging = std::f64::consts::FRAC_PI_2;
    let mut problem = Problem::new(step, &[hanging, 0.0], nodes).expect("a problem");
    let space = problem.state_space().clone();
    let upright = StateResidual::new(&space, &[-hanging, 0.0]).expect("a state");
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    running.add(upright.clone(), vec![0.1, 0.01]).expect("weights");
    running.add(ControlResidual::new(&[0.0]).expect("controls"), 1e-2).expect("weights");
    terminal.add(upright, vec![100.0, 10.0]).expect("weights");
    problem.set_running_cost(0..nodes, running).expect("a cost");
    problem.set_terminal_cost(terminal).expect("a cost");
    let limit = 0.5 * mass * 9.81 * length;
    let bounds = ControlBounds::new(&[-limit], &[limit]).expect("bounds");
    problem.set_control_bounds(0..nodes, bounds).expect("bounds");
    problem
}

/// The end of a rollout of the controls, and the largest of them.
fn end_of(sampling: &Sampling) -> ([f64; 2], f64) {
    let nodes = sampling.problem().nodes();
    let controls: Vec<Vec<f64>> = (0..nodes).map(|k| sampling.control(k).to_vec()).collect();
    let mut rollout = Fddp::new(sampling.problem().clone(), FddpOptions::default()).expect("options");
    rollout.set_rollout(&controls).expect("a rollout");
    let most = controls.iter().fold(0.0_f64, |most, u| most.max(u[0].abs()));
    ([rollout.state(nodes)[0], rollout.state(nodes)[1]], most)
}

#[test]
fn a_weak_motor_swings_a_pendulum_up() {
    let limit = 0.5 * 9.81 * 0.5;
    for law in [SamplingLaw::Mppi { temperature: 2.0 }, CEM] {
        let mut options = options(law, 1.5);
        options.correlation = 0.8;
        let mut sampling = Sampling::new(swing_up(), options).expect("options");
        let report = sampling.solve().expect("a solution");
        let ([angle, rate], most) = end_of(&sampling);
        let off = (angle + std::f64::consts::FRAC_PI_2).abs();
        assert!(off < 0.3 && rate.abs() < 1.0, "{law:?}: {angle} {rate}, {report:?}");
        assert!(most <= limit, "{most} above {limit}");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    for law in [MPPI, CEM] {
        let of = |threads: usize, seed: u64| {
            let mut options = options(law, 0.5);
            (options.threads, options.seed, options.samples, options.iterations) = (threads, seed, 50, 5);
            let mut sampling = Sampling::new(mass(), options).expect("options");
            let report = sampling.solve().expect("a solution");
            let controls: Vec<f64> = (0..8).map(|k| sampling.control(k)[0]).collect();
            (report, controls, sampling.log().to_vec())
        };
        let one = of(1, 3);
        assert_eq!(one, of(2, 3));
        assert_eq!(one, of(7, 3));
        assert_ne!(one.1, of(1, 4).1);
    }
}

/// A controller that samples at each period brings the mass to rest, from where it is.
#[test]
fn shifted_solutions_control_a_mass() {
    let (a, b) = (dmatrix![1.0, 0.2; 0.0, 1.0], dmatrix![0.02; 0.2]);
    let mut options = options(CEM, 0.5);
    options.iterations = 3;
    let mut sampling = Sampling::new(mass(), options).expect("options");
    let mut x = dmatrix![1.0; 0.0];
    for _ in 0..40 {
        let before: Vec<f64> = (1..8).map(|k| sampling.control(k)[0]).collect();
        let mut shifted = sampling.clone();
        shifted.shift();
        let after: Vec<f64> = (0..7).map(|k| shifted.control(k)[0]).collect();
        assert_eq!(before, after);
        let u = sampling.step(x.as_slice()).expect("a step")[0];
        x = &a * x + &b * u;
    }
    // Three iterations a period leave a share of the noise of 0.5 N.
    assert!(x.norm() < 0.1, "{x}");
}

#[test]
fn invalid_samplings_are_refused() {
    let of = |change: &dyn Fn(&mut SamplingOptions)| {
        let mut options = options(CEM, 0.5);
        change(&mut options);
        Sampling::new(mass(), options).is_err()
    };
    assert!(!of(&|_| ()));
    assert!(of(&|options| options.samples = 1));
    assert!(of(&|options| options.threads = 0));
    assert!(of(&|options| options.deviation = vec![0.1, 0.1]));
    assert!(of(&|options| options.deviation = vec![0.0]));
    assert!(of(&|options| options.correlation = 1.0));
    assert!(of(&|options| options.law = SamplingLaw::Mppi { temperature: -1.0 }));
    assert!(of(&|options| options.law = SamplingLaw::CrossEntropy { elites: 500, least_deviation: 0.1 }));
    let mut sampling = Sampling::new(mass(), options(CEM, 0.5)).expect("options");
    assert!(sampling.set_controls(&[[0.0]; 7]).is_err());
    assert!(sampling.set_controls(&[[f64::NAN]; 8]).is_err());
    assert!(sampling.set_initial_state(&[0.0]).is_err());
}
