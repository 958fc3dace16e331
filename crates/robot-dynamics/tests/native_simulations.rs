//! Simulations by machine code: the motion of the recursions to rounding, the same errors, and in batches the
//! same bits as alone.
#![cfg(all(feature = "native", feature = "batch"))]
#![allow(missing_docs)]

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use robot_dynamics::batch::{
    BatchWorkspace, Rollout, RolloutStates, SimulationBatch, Threads, Torques, rollout,
};
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions, pendulum, random_robot};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Integrator, Method, Simulation, SimulationBuilder, StepForces, StepWorkspace, step,
};
use robot_dynamics::{load, with_native_code};

const ROWS: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::RungeKutta4];

fn robot(name: &str) -> Model {
    let file = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots")).join(name);
    load(file).expect("a robot of the repository").model
}

/// Robots with plain coordinates, with prismatic joints, with quaternions, and with springs and damping.
fn robots() -> Vec<Model> {
    let random = |seed, base, kinds| {
        let options = RandomRobotOptions { joints: 6, base, kinds, passive: 0.5, ..Default::default() };
        with_native_code(Model::new(random_robot(seed, &options)).expect("a random robot"))
    };
    vec![
        robot("panda.urdf"),
        robot("two_r.urdf"),
        random(3, Base::Fixed, JointKinds::VectorSpace),
        random(4, Base::Fixed, JointKinds::All),
        random(5, Base::Floating, JointKinds::All),
    ]
}

fn simulation(model: &Model, row: Integrator) -> Simulation {
    SimulationBuilder::new(model).method(Method::Fixed(row)).dt(1e-3).build().expect("a simulation")
}

/// Starts from a random state under random torques.
fn start(simulation: &mut Simulation, seed: u64) {
    let state = random_state(simulation.model(), &mut SplitMix64::new(seed));
    let v: Vec<f64> = state.v.iter().map(|v| 0.1 * v).collect();
    simulation.reset(&state.q, &v).expect("a valid state");
    simulation.set_torques(&state.tau);
}

#[test]
fn side_by_side_each_has_the_bits_that_it_has_alone() {
    const COUNT: usize = 37;
    for (model, row) in robots().iter().flat_map(|model| ROWS.map(|row| (model, row))) {
        for threads in [1, 2] {
            let mut one = simulation(model, row);
            let mut batch = SimulationBatch::new(&one, COUNT, &Threads::start(threads).expect("threads"));
            for (own, seed) in batch.simulations_mut().iter_mut().zip(0..) {
                start(own, seed);
            }
            // One state is invalid, one angle is beyond the range of the polynomials, one torque is clipped,
            // and one simulation ends early.
            let nv = model.nv();
            batch.simulations_mut()[3].set_torques(&vec![f64::NAN; nv]);
            let mut far = batch.simulations()[4].q().to_vec();
            far[0] += 2e5 * std::f64::consts::TAU;
            let takes_far =
                model.nq() == nv && batch.simulations_mut()[4].reset(&far, &vec![0.0; nv]).is_ok();
            batch.simulations_mut()[5].set_torques(&vec![1e300; nv]);
            let failed = batch.step(20, &AtomicBool::new(false));
            let mut failed = failed.into_iter().map(|(number, failure)| (number, failure.to_string()));
            for (number, seed) in (0..COUNT).zip(0..) {
                start(&mut one, seed);
                match number {
                    3 => one.set_torques(&vec![f64::NAN; nv]),
                    4 if takes_far => one.reset(&far, &vec![0.0; nv]).expect("a valid state"),
                    5 => one.set_torques(&vec![1e300; nv]),
                    _ => {}
                }
                let alone = (0..20).try_for_each(|_| one.step());
                let side = &batch.simulations()[number];
                let name = format!("{}, {row:?}, {threads} threads, simulation {number}", model.name());
                assert_eq!((one.q(), one.v(), one.steps()), (side.q(), side.v(), side.steps()), "{name}");
                assert_eq!(one.energy_account(), side.energy_account(), "{name}");
                assert_eq!(one.acceleration(), side.acceleration(), "{name}");
                if let Err(error) = alone {
                    assert_eq!(failed.next(), Some((number, error.to_string())), "{name}");
                }
            }
            assert_eq!(failed.next(), None);
        }
    }
}

/// Rounding errors grow like the distance of neighbouring motions, less than a thousandfold in 0.1 s.
#[test]
fn motions_and_energies_are_those_of_the_recursions_to_rounding() {
    for (model, row) in robots().iter().flat_map(|model| ROWS.map(|row| (model, row))) {
        let (mut native, mut plain) =
            (simulation(model, row), simulation(&model.clone().with_native(false), row));
        for own in [&mut native, &mut plain] {
            start(own, 11);
            own.run_for(0.1).expect("a short run");
        }
        let numbers = |own: &Simulation| {
            let energy_account = own.energy_account();
            let account = [
                energy_account.kinetic(),
                energy_account.potential(),
                energy_account.work(),
                energy_account.dissipated(),
            ];
            own.q().iter().chain(own.v()).copied().chain(account).collect::<Vec<f64>>()
        };
        let (found, expected) = (numbers(&native), numbers(&plain));
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-12 * size, "{}, {row:?}: {found} {expected}", model.name());
        }
        let is_compiled =
            native.model().native().functions.iter().any(|one| one.function.name().ends_with("_step"));
        assert_eq!(is_compiled, native.model().native().reason.is_none(), "{}", model.name());
    }
}

#[test]
fn a_step_alone_has_the_bits_of_a_rollout_and_of_a_simulation() {
    for (model, row) in robots().iter().flat_map(|model| ROWS.map(|row| (model, row))) {
        let mut one = simulation(model, row);
        start(&mut one, 2);
        let (mut q, mut v, tau) =
            (one.q().to_vec(), one.v().to_vec(), random_state(model, &mut SplitMix64::new(2)).tau);
        let (mut q_of_rows, mut v_of_rows) = (q.clone(), v.clone());
        let forces = StepForces::new(&tau, one.dissipates());
        let w = &mut StepWorkspace::new(model);
        for _ in 0..10 {
            one.step().expect("a good step");
            step(model, row, w, &forces, 1e-3, &mut q, &mut v).expect("a good step");
        }
        assert_eq!((one.q(), one.v()), (&q[..], &v[..]), "{}, {row:?}", model.name());
        let mut steps = Rollout::new(row, 1e-3, 10);
        steps.dissipation = one.dissipates();
        let torques = Torques::Held(&tau);
        let w = &mut BatchWorkspace::<f64>::new(model);
        rollout(model, w, &steps, torques, RolloutStates::ends(&mut q_of_rows, &mut v_of_rows), None)
            .expect("a good rollout");
        assert_eq!((q_of_rows, v_of_rows), (q, v), "{}, {row:?}", model.name());
    }
}

/// A hinge that moves no mass has no acceleration. The pivots of machine code detect this, and a robot that
/// becomes singular during the motion is refused at that step.
#[test]
fn singular_masses_are_refused_as_by_the_recursions() {
    let mut massless = pendulum(2.0, 0.5);
    massless.links[1].mass_properties = None;
    let model = with_native_code(Model::new(massless).expect("a robot"));
    let mut one = simulation(&model, Integrator::RungeKutta4);
    let native = one.reset(&[0.3], &[0.0]).expect_err("M is singular").to_string();
    let mut other = simulation(&model.clone().with_native(false), Integrator::RungeKutta4);
    assert_eq!(native, other.reset(&[0.3], &[0.0]).expect_err("M is singular").to_string());
    assert!(native.contains("hinge"), "{native}");
}
