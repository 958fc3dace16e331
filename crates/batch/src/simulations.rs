//! Many simulations of one robot that are stepped together on threads.
//!
//! Each keeps its own state, inputs and contacts. The results are those of each simulation alone, bit for
//! bit. Semi-implicit Euler and Runge–Kutta steps by machine code take several simulations in the lanes of
//! registers. Cost: that of the single steps, divided by the threads. Simulations that are copies of one
//! share its model.

#[cfg(feature = "native")]
mod kernels;
#[cfg(not(feature = "native"))]
mod no_kernels;
mod position_control;
mod steps;

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use robot_dynamics_simulation::RunError;
use robot_dynamics_simulation::simulator::Simulation;

#[cfg(feature = "native")]
use self::kernels::{SIDE_BY_SIDE, StepKernels, advance_side_by_side, kernels_for};
#[cfg(not(feature = "native"))]
use self::no_kernels::{SIDE_BY_SIDE, StepKernels, advance_side_by_side, kernels_for};
pub use self::position_control::PositionControl;
use self::steps::{advance, advance_controlled};
use crate::Threads;
use crate::tables::check_table;

/// Simulations of one robot, each with its own state, inputs and contacts, stepped together on threads.
///
/// All simulations are copies of one, or have robots of the same structure. Each keeps its state between
/// steps, such as the forces of its contacts, so single steps cost no more than a run. The results are those
/// of each simulation alone, bit for bit, for any number of threads.
///
/// ```
/// use robot_dynamics::batch::{SimulationBatch, Threads};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::SimulationBuilder;
/// use std::sync::atomic::AtomicBool;
/// let mut simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
/// let mut batch = SimulationBatch::new(&simulation, 3, &Threads::start(2)?);
/// for (k, own) in batch.simulations_mut().iter_mut().enumerate() {
///     own.reset(&[0.1 * k as f64], &[0.0])?;
/// }
/// let failed = batch.step(100, &AtomicBool::new(false));
/// simulation.reset(&[0.2], &[0.0])?;
/// (0..100).try_for_each(|_| simulation.step())?;
/// assert!(failed.is_empty() && batch.simulations()[2].q() == simulation.q());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// If machine code can take the steps (semi-implicit Euler or Runge–Kutta under torques), one call takes
/// those of several simulations in the lanes of registers.
#[derive(Debug)]
pub struct SimulationBatch {
    simulations: Vec<Simulation>,
    threads: Threads,
    /// The kernels of each thread, if machine code takes the steps.
    kernels: Vec<Mutex<StepKernels>>,
    position_control: Option<PositionControl>,
}

impl Clone for SimulationBatch {
    fn clone(&self) -> Self {
        let simulations = self.simulations.clone();
        Self {
            kernels: kernels_for(simulations.first(), &self.threads),
            simulations,
            threads: self.threads.clone(),
            position_control: self.position_control.clone(),
        }
    }
}

impl SimulationBatch {
    /// Creates `count` copies of a simulation in its current state.
    pub fn new(simulation: &Simulation, count: usize, threads: &Threads) -> Self {
        Self::of(vec![simulation.clone(); count], threads)
    }

    /// Creates a batch of simulations that may differ in their robots, grounds and methods, for example in
    /// masses and friction.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// use std::sync::atomic::AtomicBool;
    /// let of_length = |length| SimulationBuilder::new(&Model::new(pendulum(2.0, length)).unwrap()).build();
    /// let mut batch = SimulationBatch::of(vec![of_length(0.5)?, of_length(1.0)?], &Threads::start(1)?);
    /// assert!(batch.step(100, &AtomicBool::new(false)).is_empty());
    /// let [short, long] = batch.simulations() else { panic!("two simulations") };
    /// assert!(short.q()[0] > 1.9 * long.q()[0]); // both fall from level: q ≈ g t²/(2 length)
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if the simulations differ in nq, nv or their number of controls.
    #[track_caller]
    pub fn of(simulations: Vec<Simulation>, threads: &Threads) -> Self {
        let sizes = |own: &Simulation| (own.q().len(), own.v().len(), own.controls().len());
        for (k, own) in simulations.iter().enumerate() {
            let (first, other) = (sizes(&simulations[0]), sizes(own));
            assert!(first == other, "simulation {k} has (nq, nv, controls) = {other:?}, the first {first:?}");
        }
        let kernels = kernels_for(simulations.first().filter(|_| simulations.len() > 1), threads);
        Self { simulations, threads: threads.clone(), kernels, position_control: None }
    }

    /// The position control of the joints, which acts in each step of [`step`](Self::step). The configuration
    /// is the target at first, and after a reset by [`reset_where`](Self::reset_where).
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// use std::sync::atomic::AtomicBool;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let mut batch = SimulationBatch::new(&simulation, 2, &Threads::start(1)?);
    /// let control = batch.position_control();
    /// control.set_gains(&[400.0, 100.0], &[40.0, 20.0], &[f64::INFINITY; 2])?;
    /// control.set_targets(&[1.0, 1.0]);
    /// batch.step(5000, &AtomicBool::new(false));
    /// for (own, stiffness) in batch.simulations().iter().zip([400.0, 100.0]) {
    ///     // At rest the spring carries the weight.
    ///     let q = own.q()[0];
    ///     assert!((stiffness * (1.0 - q) + 2.0 * 9.81 * 0.5 * q.cos()).abs() < 1e-6);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if the batch is empty.
    #[track_caller]
    pub fn position_control(&mut self) -> &mut PositionControl {
        let Self { simulations, position_control, .. } = self;
        position_control.get_or_insert_with(|| {
            let mut control = PositionControl::new(simulations[0].model(), simulations.len());
            simulations.iter().enumerate().for_each(|(number, own)| control.hold(number, own.q()));
            control
        })
    }

    /// A table of `width` numbers of each simulation, which `fill` writes on all threads.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let batch = SimulationBatch::new(&simulation, 3, &Threads::start(1)?);
    /// assert_eq!(batch.table(1, |own, row| row[0] = own.time()), [0.0; 3]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn table(&self, width: usize, fill: impl Fn(&Simulation, &mut [f64]) + Sync) -> Vec<f64> {
        let mut table = vec![0.0; self.simulations.len() * width];
        if width == 0 {
            return table;
        }
        let fill = |(own, row): (&Simulation, &mut [f64])| fill(own, row);
        if self.threads.count() == 1 {
            self.simulations.iter().zip(table.chunks_mut(width)).for_each(fill);
        } else {
            let rows = self.simulations.par_iter().zip(table.par_chunks_mut(width));
            self.threads.install(|| rows.for_each(fill));
        }
        table
    }

    /// The simulations.
    pub fn simulations(&self) -> &[Simulation] {
        &self.simulations
    }

    /// The simulations, for access to states and inputs.
    pub fn simulations_mut(&mut self) -> &mut [Simulation] {
        &mut self.simulations
    }

    /// Sets the threads for later calls.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let mut batch = SimulationBatch::new(&simulation, 8, &Threads::start(1)?);
    /// batch.set_threads(&Threads::start(2)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_threads(&mut self, threads: &Threads) {
        if self.threads.count() != threads.count() {
            self.kernels = kernels_for(self.simulations.first(), threads);
        }
        self.threads = threads.clone();
    }

    /// Takes `steps` steps of each simulation. Returns the index and the error of each simulation that
    /// failed, in ascending order. These are at the end of their last successful step, and the others have
    /// taken all steps. If `cancelled` is set during the call, each simulation stops after its current step.
    pub fn step(&mut self, steps: usize, cancelled: &AtomicBool) -> Vec<(usize, RunError)> {
        self.advance(steps, cancelled)
    }

    /// As [`step`](Self::step), for the simulations whose entry in `which` is set; the others do not change.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// use std::sync::atomic::AtomicBool;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let mut batch = SimulationBatch::new(&simulation, 3, &Threads::start(1)?);
    /// batch.simulations_mut()[2].set_torques(&[f64::NAN]);
    /// let failed = batch.step_where(&[true, false, true], 10, &AtomicBool::new(false));
    /// assert_eq!(failed.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [2]);
    /// assert_eq!(batch.simulations().iter().map(|own| own.steps()).collect::<Vec<_>>(), [10, 0, 0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if `which` does not have one entry for each simulation.
    #[track_caller]
    pub fn step_where(
        &mut self,
        which: &[bool],
        steps: usize,
        cancelled: &AtomicBool,
    ) -> Vec<(usize, RunError)> {
        self.check_count("which", which.len(), 1);
        self.advance_separately(Some(which), steps, cancelled)
    }

    /// Calls [`Simulation::reset`] for the simulations whose entry in `which` is set, each with its row of q
    /// \[count\]\[nq\] and v \[count\]\[nv\]. Returns the simulations with an invalid start, which do not
    /// change.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let mut batch = SimulationBatch::new(&simulation, 3, &Threads::start(1)?);
    /// let failed = batch.reset_where(&[false, true, true], &[0.1, 0.2, f64::NAN], &[0.0; 3]);
    /// assert_eq!((failed.len(), failed[0].0), (1, 2));
    /// assert_eq!(batch.simulations().iter().map(|own| own.q()[0]).collect::<Vec<_>>(), [0.0, 0.2, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if a table does not have one row for each simulation.
    #[track_caller]
    pub fn reset_where(&mut self, which: &[bool], q: &[f64], v: &[f64]) -> Vec<(usize, RunError)> {
        let failed = self.place(which, q, v, Simulation::reset);
        if let Some(control) = &mut self.position_control {
            for (number, simulation) in self.simulations.iter().enumerate().filter(|(k, _)| which[*k]) {
                control.hold(number, simulation.q());
            }
        }
        failed
    }

    /// Calls [`Simulation::set_state`] for the simulations whose entry in `which` is set, as
    /// [`reset_where`](Self::reset_where); time, inputs and activations do not change.
    ///
    /// ```
    /// use robot_dynamics::batch::{SimulationBatch, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// simulation.run_for(0.1)?;
    /// let mut batch = SimulationBatch::new(&simulation, 2, &Threads::start(1)?);
    /// assert!(batch.set_states_where(&[false, true], &[0.0, 0.3], &[0.0; 2]).is_empty());
    /// let second = &batch.simulations()[1];
    /// assert_eq!((second.q(), second.time()), (&[0.3][..], simulation.time()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if a table does not have one row for each simulation.
    #[track_caller]
    pub fn set_states_where(&mut self, which: &[bool], q: &[f64], v: &[f64]) -> Vec<(usize, RunError)> {
        self.place(which, q, v, Simulation::set_state)
    }

    #[track_caller]
    fn place(&mut self, which: &[bool], q: &[f64], v: &[f64], place: SetState) -> Vec<(usize, RunError)> {
        let Some(first) = self.simulations.first() else { return Vec::new() };
        let (nq, nv) = (first.q().len(), first.v().len());
        self.check_count("which", which.len(), 1);
        self.check_count("q", q.len(), nq);
        self.check_count("v", v.len(), nv);
        self.for_each(|k, simulation| {
            if !which[k] {
                return Ok(());
            }
            place(simulation, &q[k * nq..(k + 1) * nq], &v[k * nv..(k + 1) * nv])
        })
    }

    #[track_caller]
    fn check_count(&self, name: &str, found: usize, width: usize) {
        check_table(name, found, self.simulations.len(), width);
    }

    /// Takes steps of each simulation that is meant, without a kernel for several.
    fn advance_separately(
        &mut self,
        which: Option<&[bool]>,
        steps: usize,
        cancelled: &AtomicBool,
    ) -> Vec<(usize, RunError)> {
        let is_meant = |number: usize| which.is_none_or(|which| which[number]);
        let control = self.position_control.take();
        let failed = self.for_each(|number, simulation| match &control {
            _ if !is_meant(number) => Ok(()),
            Some(control) => advance_controlled(control, (number, simulation), steps, cancelled),
            None => advance(simulation, steps, cancelled),
        });
        self.position_control = control;
        if let Some(control) = &mut self.position_control {
            let meant = (0..self.simulations.len()).filter(|number| is_meant(*number));
            meant.for_each(|number| control.count_steps(number, steps));
        }
        failed
    }

    fn advance(&mut self, steps: usize, cancelled: &AtomicBool) -> Vec<(usize, RunError)> {
        if self.kernels.is_empty() || self.position_control.is_some() {
            return self.advance_separately(None, steps, cancelled);
        }
        let memory = &self.kernels;
        let blocks = |(block, simulations): (usize, &mut [Simulation])| {
            // Each thread has its own memory.
            let own = rayon::current_thread_index().unwrap_or(0) % memory.len();
            let mut kernels = memory[own].lock().unwrap_or_else(PoisonError::into_inner);
            let first = block * SIDE_BY_SIDE;
            let meant = simulations.iter_mut().enumerate().map(|(k, own)| (first + k, own));
            advance_side_by_side(&mut kernels, meant.collect(), steps, cancelled)
        };
        let simulations = &mut self.simulations;
        if self.threads.count() == 1 {
            return simulations.chunks_mut(SIDE_BY_SIDE).enumerate().flat_map(blocks).collect();
        }
        let chunks = simulations.par_chunks_mut(SIDE_BY_SIDE).enumerate();
        self.threads.install(|| chunks.flat_map_iter(blocks).collect())
    }

    /// Applies a function to each simulation on all threads. Returns the failures in ascending order.
    fn for_each(
        &mut self,
        act: impl Fn(usize, &mut Simulation) -> Result<(), RunError> + Sync,
    ) -> Vec<(usize, RunError)> {
        let act = |(number, simulation): (usize, &mut Simulation)| {
            act(number, simulation).err().map(|failure| (number, failure))
        };
        let simulations = &mut self.simulations;
        if self.threads.count() == 1 {
            return simulations.iter_mut().enumerate().filter_map(act).collect();
        }
        self.threads.install(|| simulations.par_iter_mut().enumerate().filter_map(act).collect())
    }
}

/// Sets the state (q, v) of a simulation.
type SetState = fn(&mut Simulation, &[f64], &[f64]) -> Result<(), RunError>;
