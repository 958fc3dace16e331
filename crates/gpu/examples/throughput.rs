//! How many states a second a device computes, beside all cores of the processor.
//!
//! `cargo run --release --package robot-dynamics-gpu --features cuda --example throughput [cuda|wgpu] [STATES] [ROBOT…]`
//!
//! Two kinds of number: calls whose tables lie in the processor's memory, there and back included; and steps of a rollout, whose states
//! stay on the device. Medians of five.

use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Instant;

use dynamics::Integrator;
use gpu::{Device, DeviceFloat, Function, Rollout, Torques};
use multibody::batch::{self, BatchWorkspace};
use multibody::{Model, random_state};
use number::SplitMix64;

/// Steps of a rollout on the device, and on the processor, which takes longer for each.
const STEPS: [usize; 2] = [1024, 16];

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
    let mut arguments = std::env::args().skip(1);
    let by_cuda = arguments.next().is_some_and(|name| name == "cuda");
    let states = arguments.next().map_or(Ok(100_000), |count| count.parse())?;
    let mut robots: Vec<String> = arguments.collect();
    if robots.is_empty() {
        robots.push(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf").into());
    }
    let device = open(by_cuda)?;
    println!("| {} | numbers | states | compiled in | device | processor | ratio |", device.name());
    println!("| --- | --- | ---: | ---: | ---: | ---: | ---: |");
    for robot in robots {
        let model = robot_dynamics::load(&robot)?.model;
        measure::<f32>(&device, &model, "f32", states)?;
        if by_cuda {
            measure::<f64>(&device, &model, "f64", states)?;
        }
    }
    Ok(())
}

fn open(by_cuda: bool) -> Result<Device, Box<dyn Error>> {
    if !by_cuda {
        return Ok(Device::open()?);
    }
    #[cfg(feature = "cuda")]
    return Ok(Device::open_cuda(0, gpu::Limits::default())?);
    #[cfg(not(feature = "cuda"))]
    Err("compile with `--features cuda`".into())
}

/// The median time of five calls after a first one \[s\].
fn median(mut call: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    call()?;
    let mut times = Vec::new();
    for _ in 0..5 {
        let start = Instant::now();
        call()?;
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[2])
}

fn measure<T: DeviceFloat>(
    device: &Device,
    model: &Model,
    numbers: &str,
    count: usize,
) -> Result<(), Box<dyn Error>> {
    let (nv, mut random) = (model.nv(), SplitMix64::new(1));
    let [mut q, mut v, mut a, mut tau] = [const { Vec::new() }; 4];
    for _ in 0..count {
        let state = random_state(model, &mut random);
        let numbers = |row: Vec<f64>| row.into_iter().map(T::from_f64).collect::<Vec<_>>();
        q.extend(numbers(state.q));
        v.extend(numbers(state.v));
        a.extend(numbers(state.a));
        tau.extend(numbers(state.tau));
    }
    let mut workspace = BatchWorkspace::<T>::new(model);
    let row = |function: &str, compiled: f64, seconds: [f64; 2], units: [usize; 2]| {
        let [device, processor] = [0, 1].map(|k| (count * units[k]) as f64 / seconds[k] / 1e6);
        println!(
            "| {}, {function} | {numbers} | {count} | {compiled:.1} s | {device:.1} M/s | {processor:.1} M/s | {:.2} |",
            model.name(),
            device / processor
        );
    };
    for function in [Function::InverseDynamics, Function::ForwardDynamics, Function::MassMatrix] {
        let start = Instant::now();
        let mut batches = device.compile::<T>(model, core::slice::from_ref(&function))?;
        let compiled = start.elapsed().as_secs_f64();
        let width = if function == Function::MassMatrix { nv * nv } else { nv };
        let mut out = vec![T::zero(); count * width];
        let on_device = median(|| {
            match function {
                Function::InverseDynamics => batches.inverse_dynamics(&q, &v, &a, &mut out)?,
                Function::ForwardDynamics => batches.forward_dynamics(&q, &v, &tau, &mut out)?,
                _ => batches.mass_matrix(&q, &mut out)?,
            }
            Ok(())
        })?;
        let on_processor = median(|| {
            match function {
                Function::InverseDynamics => {
                    batch::inverse_dynamics(model, &mut workspace, &q, &v, &a, &mut out)?;
                }
                Function::ForwardDynamics => {
                    batch::forward_dynamics(model, &mut workspace, &q, &v, &tau, &mut out)?;
                }
                _ => batch::mass_matrix(model, &mut workspace, &q, &mut out)?,
            }
            Ok(())
        })?;
        row(&function.to_string(), compiled, [on_device, on_processor], [1, 1]);
    }
    let go_on = |_| ControlFlow::Continue(());
    for (integrator, function) in [
        (Integrator::SemiImplicitEuler, Function::SemiImplicitEulerStep),
        (Integrator::RungeKutta4, Function::Rk4Step),
    ] {
        let courses = STEPS.map(|steps| Rollout::new(integrator, 1e-5, steps));
        let start = Instant::now();
        let mut batches = device.compile::<T>(model, core::slice::from_ref(&function))?;
        let compiled = start.elapsed().as_secs_f64();
        let on_device = median(|| {
            let (mut q, mut v) = (q.clone(), v.clone());
            Ok(batches.rollout(&courses[0], Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on)?)
        })?;
        let on_processor = median(|| {
            let (mut q, mut v) = (q.clone(), v.clone());
            let nothing = (&mut [][..], &mut [][..]);
            Ok(batch::rollout(
                model,
                &mut workspace,
                &courses[1],
                Torques::Zero,
                &mut q,
                &mut v,
                nothing,
                &go_on,
            )?)
        })?;
        row(&format!("steps of {integrator}"), compiled, [on_device, on_processor], STEPS);
    }
    Ok(())
}
