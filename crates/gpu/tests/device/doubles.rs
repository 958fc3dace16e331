//! Double precision, on devices that support it.

use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{Device, Function, Rollout, RolloutStates, Torques};

use crate::bounds::Bounds;
use crate::robots;

const COUNT: usize = 70;

fn device() -> Option<Device> {
    crate::device().filter(|_| crate::is_cuda())
}

/// Tables of q, v, a and τ of random states.
fn states(model: &Model) -> [Vec<f64>; 4] {
    let mut tables = [const { Vec::new() }; 4];
    let mut random = SplitMix64::new(7);
    for _ in 0..COUNT {
        let state = random_state(model, &mut random);
        let rows = [state.q, state.v, state.a, state.tau];
        tables.iter_mut().zip(rows).for_each(|(table, row)| table.extend(row));
    }
    tables
}

/// Torques, accelerations and M of every robot are within the bounds of singles, times twice the ratio of the
/// two roundings. The CPU rounds as well.
#[test]
fn every_robot_agrees_with_the_library_to_the_rounding_of_doubles() {
    let Some(device) = device() else { return };
    let ratio = 2.0 * f64::EPSILON / f64::from(f32::EPSILON);
    let functions = [Function::InverseDynamics, Function::ForwardDynamics, Function::MassMatrix];
    let mut worst = [0.0_f64; 3];
    for model in robots::all().into_iter().chain([robots::with_ball()]) {
        let (nq, nv) = (model.nq(), model.nv());
        let [q, v, a, tau] = states(&model);
        let mut batches = device.compile::<f64>(&model, &functions).unwrap();
        let [mut torques, mut accelerations] = [(); 2].map(|()| vec![f64::NAN; COUNT * nv]);
        let mut mass = vec![f64::NAN; COUNT * nv * nv];
        batches.inverse_dynamics(&q, &v, &a, &mut torques).unwrap();
        batches.forward_dynamics(&q, &v, &tau, &mut accelerations).unwrap();
        batches.mass_matrix(&q, &mut mass).unwrap();
        for state in 0..COUNT {
            let at = |table: &[f64], width: usize| table[state * width..][..width].to_vec();
            let (q, v, a, tau) = (at(&q, nq), at(&v, nv), at(&a, nv), at(&tau, nv));
            let torque = model.inverse_dynamics(&q, &v, &a).unwrap();
            let acceleration = model.forward_dynamics(&q, &v, &tau).unwrap();
            let expected_mass = model.mass_matrix(&q).unwrap(); // symmetric: rows are columns
            let bounds = Bounds::new(&model, &q, &v, &a);
            let of_acceleration = Bounds::new(&model, &q, &v, acceleration.as_slice()).acceleration(&tau);
            let of_torque: Vec<f64> =
                bounds.roots.iter().map(|root| bounds.rounding * root * bounds.force).collect();
            let of_mass: Vec<f64> =
                (0..nv * nv).map(|i| bounds.rounding * bounds.roots[i / nv] * bounds.roots[i % nv]).collect();
            let compared: [(Vec<f64>, &[f64], Vec<f64>); 3] = [
                (at(&torques, nv), torque.as_slice(), of_torque),
                (at(&accelerations, nv), acceleration.as_slice(), of_acceleration),
                (at(&mass, nv * nv), expected_mass.as_slice(), of_mass),
            ];
            for (k, (found, expected, allowed)) in compared.into_iter().enumerate() {
                for ((x, y), allowed) in found.iter().zip(expected).zip(allowed) {
                    let off = (x - y).abs() / (ratio * allowed);
                    // NaN fails, too.
                    assert!(off <= 1.0, "{} of {}, state {state}: {off}", functions[k], model.name());
                    worst[k] = worst[k].max(off);
                }
            }
        }
    }
    println!("the worst are {worst:?} of what is allowed");
}

/// A rollout of 200 steps ends where the CPU's does. The rounding of a step, below 1e-13 of numbers of some
/// hundred, grows by less than a factor of a hundred within 0.2 s.
#[test]
fn a_rollout_agrees_with_the_cpu() {
    let Some(device) = device() else { return };
    for model in [robots::named("panda.urdf"), robots::named("quadruped.urdf"), robots::with_ball()] {
        let functions = [Function::SemiImplicitEulerStep, Function::Rk4Step];
        let mut batches = device.compile::<f64>(&model, &functions).unwrap();
        let [q, v, _, tau] = states(&model);
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            let how = Rollout::new(integrator, 1e-3, 200);
            let (mut q_found, mut v_found) = (q.clone(), v.clone());
            batches
                .rollout(&how, Torques::Held(&tau), RolloutStates::ends(&mut q_found, &mut v_found), None)
                .unwrap();
            let (mut q_there, mut v_there) = (q.clone(), v.clone());
            robots::roll_out_on_cpu(&model, &how, &tau, &mut q_there, &mut v_there).unwrap();
            let pairs = q_found.iter().chain(&v_found).zip(q_there.iter().chain(&v_there));
            let worst = pairs.map(|(x, y)| (x - y).abs() / y.abs().max(1.0)).fold(0.0, f64::max);
            println!("{} by {integrator}: {worst:e}", model.name());
            assert!(worst < 1e-9, "{} by {integrator}: {worst:e}", model.name());
        }
    }
}
