//! Drops ten thousand arms on a device: the speed of the simulation, and the difference from the CPU's
//! result.
//!
//! `cargo run --release --package robot-dynamics-gpu --example rollout [ROBOT]`

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use robot_dynamics::batch;
use robot_dynamics::batch::BatchWorkspace;
use robot_dynamics::model::random_state;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{Device, DeviceError, Function, Rollout, RolloutStates, Torques};
use robot_dynamics_number::SplitMix64;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let device = match Device::open() {
        Ok(device) => device,
        Err(error @ DeviceError::NoDevice { .. }) if std::env::var_os("ROBOT_DYNAMICS_DEVICE").is_none() => {
            println!("{error}");
            return Ok(());
        }
        Err(error) => return Err(error.into()),
    };
    let file = std::env::args().nth(1);
    let file = file.unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf").into());
    let model = robot_dynamics::load(&file)?.model;
    let start = Instant::now();
    let mut arms = device.compile::<f32>(&model, &[Function::SemiImplicitEulerStep])?;
    println!("{} on {}: compiled in {:.1?}", model.name(), device.name(), start.elapsed());

    let (count, mut random) = (10_000, SplitMix64::new(1));
    let (mut q, mut v) = (Vec::new(), vec![0.0_f32; count * model.nv()]);
    for _ in 0..count {
        #[allow(clippy::cast_possible_truncation)] // the device's numbers
        q.extend(random_state(&model, &mut random).q.iter().map(|&x| x as f32));
    }
    // A tenth of a second with damping and friction, all of it on the device.
    let rollout = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 100);
    let (mut q_there, mut v_there): (Vec<f64>, Vec<f64>) =
        (q.iter().map(|&x| x.into()).collect(), v.iter().map(|&x| x.into()).collect());
    let mut workspace = BatchWorkspace::<f64>::new(&model);
    let start = Instant::now();
    let torques = Torques::Zero;
    batch::rollout(
        &model,
        &mut workspace,
        &rollout,
        torques,
        batch::RolloutStates::ends(&mut q_there, &mut v_there),
        None,
    )?;
    println!("on {} threads of the CPU, in doubles: {:.1?}", workspace.threads(), start.elapsed());
    let start = Instant::now();
    arms.rollout(&rollout, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?;
    let took = start.elapsed();
    let steps = (count * rollout.steps) as f64 / took.as_secs_f64();
    println!("{count} states, {} steps each, in {took:.1?}: {steps:.2e} steps a second", rollout.steps);
    let off = q.iter().zip(&q_there).map(|(x, y)| (f64::from(*x) - y).abs()).fold(0.0, f64::max);
    println!("the largest error of q is {off:.1e}");
    Ok(())
}
