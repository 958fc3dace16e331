//! States per second on a device, compared with all cores of the CPU.
//!
//! `cargo run --release --package robot-dynamics-gpu --features cuda --example throughput [cuda|wgpu]
//! [STATES] [ROBOT…]`
//!
//! Two kinds of measurement: calls with tables in host memory, copies included, and steps of a rollout, whose
//! states stay on the device. Medians of five.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use robot_dynamics::batch;
use robot_dynamics::batch::BatchWorkspace;
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{Batches, Device, DeviceFloat, Function, Rollout, RolloutStates, Torques};
use robot_dynamics_number::SplitMix64;

/// Steps of a rollout on the device, and on the CPU, which is slower.
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
    return Ok(Device::open_cuda(0, robot_dynamics_gpu::Limits::default())?);
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

/// Random states as tables, and a device to measure on.
struct Measurement<'a, T> {
    device: &'a Device,
    model: &'a Model,
    numbers: &'a str,
    count: usize,
    q: Vec<T>,
    v: Vec<T>,
    a: Vec<T>,
    tau: Vec<T>,
}

fn measure<T: DeviceFloat>(
    device: &Device,
    model: &Model,
    numbers: &str,
    count: usize,
) -> Result<(), Box<dyn Error>> {
    let mut random = SplitMix64::new(1);
    let [mut q, mut v, mut a, mut tau] = [const { Vec::new() }; 4];
    for _ in 0..count {
        let state = random_state(model, &mut random);
        let numbers = |row: Vec<f64>| row.into_iter().map(T::from_f64).collect::<Vec<_>>();
        q.extend(numbers(state.q));
        v.extend(numbers(state.v));
        a.extend(numbers(state.a));
        tau.extend(numbers(state.tau));
    }
    let measurement = Measurement { device, model, numbers, count, q, v, a, tau };
    let mut workspace = BatchWorkspace::<T>::new(model);
    for function in [Function::InverseDynamics, Function::ForwardDynamics, Function::MassMatrix] {
        measurement.function(&function, &mut workspace)?;
    }
    measurement.rollout(Integrator::SemiImplicitEuler, &Function::SemiImplicitEulerStep, &mut workspace)?;
    measurement.rollout(Integrator::RungeKutta4, &Function::Rk4Step, &mut workspace)
}

impl<T: DeviceFloat> Measurement<'_, T> {
    /// Prints a row: the time to compile, the times of `units` for each state on the device and on the CPU.
    fn print(&self, function: &str, compiled: f64, seconds: [f64; 2], units: [usize; 2]) {
        let [device, processor] = [0, 1].map(|k| (self.count * units[k]) as f64 / seconds[k] / 1e6);
        println!(
            "| {}, {function} | {} | {} | {compiled:.1} s | {device:.1} M/s | {processor:.1} M/s | {:.2} |",
            self.model.name(),
            self.numbers,
            self.count,
            device / processor
        );
    }

    /// Compiles a function, and returns the time that this took [s].
    fn compile(&self, function: &Function) -> Result<(Batches<T>, f64), Box<dyn Error>> {
        let start = Instant::now();
        let batches = self.device.compile::<T>(self.model, core::slice::from_ref(function))?;
        Ok((batches, start.elapsed().as_secs_f64()))
    }

    /// Measures calls with tables in host memory.
    fn function(&self, function: &Function, workspace: &mut BatchWorkspace<T>) -> Result<(), Box<dyn Error>> {
        let Self { model, q, v, a, tau, .. } = self;
        let nv = model.nv();
        let (mut batches, compiled) = self.compile(function)?;
        let width = if *function == Function::MassMatrix { nv * nv } else { nv };
        let mut out = vec![T::zero(); self.count * width];
        let on_device = median(|| {
            match function {
                Function::InverseDynamics => batches.inverse_dynamics(q, v, a, &mut out)?,
                Function::ForwardDynamics => batches.forward_dynamics(q, v, tau, &mut out)?,
                _ => batches.mass_matrix(q, &mut out)?,
            }
            Ok(())
        })?;
        let on_processor = median(|| {
            match function {
                Function::InverseDynamics => batch::inverse_dynamics(model, workspace, q, v, a, &mut out)?,
                Function::ForwardDynamics => batch::forward_dynamics(model, workspace, q, v, tau, &mut out)?,
                _ => batch::mass_matrix(model, workspace, q, &mut out)?,
            }
            Ok(())
        })?;
        self.print(&function.to_string(), compiled, [on_device, on_processor], [1, 1]);
        Ok(())
    }

    /// Measures steps of a rollout.
    fn rollout(
        &self,
        integrator: Integrator,
        function: &Function,
        workspace: &mut BatchWorkspace<T>,
    ) -> Result<(), Box<dyn Error>> {
        let [on_device, on_processor] = STEPS.map(|steps| Rollout::new(integrator, 1e-5, steps));
        let (mut batches, compiled) = self.compile(function)?;
        let device = median(|| {
            let (mut q, mut v) = (self.q.clone(), self.v.clone());
            Ok(batches.rollout(&on_device, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?)
        })?;
        let processor = median(|| {
            let (mut q, mut v) = (self.q.clone(), self.v.clone());
            let zero = Torques::Zero;
            let model = self.model;
            Ok(batch::rollout(
                model,
                workspace,
                &on_processor,
                zero,
                batch::RolloutStates::ends(&mut q, &mut v),
                None,
            )?)
        })?;
        self.print(&format!("steps of {integrator}"), compiled, [device, processor], STEPS);
        Ok(())
    }
}
