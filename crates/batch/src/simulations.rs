//! Many simulations of one robot that are stepped together on threads.
//!
//! Each keeps its own state, inputs and contacts. The results are those of each simulation alone, bit for
//! bit. Semi-implicit Euler and Runge–Kutta steps by machine code take several simulations in the lanes of
//! registers. Cost: that of the single steps, divided by the threads. All simulations are copies of one: they
//! share model, method and step.

#[cfg(feature = "native")]
mod kernels;
#[cfg(not(feature = "native"))]
mod no_kernels;
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
use self::steps::advance;
use crate::Threads;
use crate::tables::check_table;

/// Simulations of one robot, each with its own state, inputs and contacts, stepped together on threads.
///
/// All simulations are copies of one. Each keeps its state between steps, such as the forces of its contacts,
/// so single steps cost no more than a run. The results are those of each simulation alone, bit for bit, for
/// any number of threads.
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
}

impl Clone for SimulationBatch {
    fn clone(&self) -> Self {
        let simulations = self.simulations.clone();
        Self {
            kernels: kernels_for(simulations.first(), &self.threads),
            simulations,
            threads: self.threads.clone(),
        }
    }
}

impl SimulationBatch {
    /// Creates `count` copies of a simulation in its current state.
    pub fn new(simulation: &Simulation, count: usize, threads: &Threads) -> Self {
        let kernels = kernels_for(Some(simulation).filter(|_| count > 1), threads);
        Self { simulations: vec![simulation.clone(); count], threads: threads.clone(), kernels }
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
        self.advance(None, steps, cancelled)
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
        self.for_each(
            |number, simulation| {
                if which[number] { advance(simulation, steps, cancelled) } else { Ok(()) }
            },
        )
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
        self.place(which, q, v, Simulation::reset)
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

    fn advance(
        &mut self,
        which: Option<&[bool]>,
        steps: usize,
        cancelled: &AtomicBool,
    ) -> Vec<(usize, RunError)> {
        let is_meant = |number: usize| which.is_none_or(|which| which[number]);
        if self.kernels.is_empty() {
            return self.for_each(|number, simulation| {
                if is_meant(number) { advance(simulation, steps, cancelled) } else { Ok(()) }
            });
        }
        let memory = &self.kernels;
        let blocks = |(block, simulations): (usize, &mut [Simulation])| {
            // Each thread has its own memory.
            let own = rayon::current_thread_index().unwrap_or(0) % memory.len();
            let mut kernels = memory[own].lock().unwrap_or_else(PoisonError::into_inner);
            let first = block * SIDE_BY_SIDE;
            let meant = simulations.iter_mut().enumerate().map(|(k, own)| (first + k, own));
            advance_side_by_side(
                &mut kernels,
                meant.filter(|(k, _)| is_meant(*k)).collect(),
                steps,
                cancelled,
            )
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
