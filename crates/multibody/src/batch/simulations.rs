//! Many simulations of one robot, stepped together.

#[cfg(not(feature = "native"))]
mod absent;
#[cfg(feature = "native")]
mod kernels;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

#[cfg(not(feature = "native"))]
use self::absent::{SIDE_BY_SIDE, StepKernels, advance_side_by_side, kernels_for};
#[cfg(feature = "native")]
use self::kernels::{SIDE_BY_SIDE, StepKernels, advance_side_by_side, kernels_for};
use super::Threads;
use super::compute::check_table;
use crate::simulator::{Simulation, StepFailure};

/// Simulations of one robot, each with its own state, inputs and contacts, stepped together on threads.
///
/// Every simulation is set up once, as a copy of one. It keeps what goes on from step to step, as the forces of its contacts, so that stepping them one
/// step a call costs what a run costs. The results are those of each simulation alone, to the bit, for any number of threads.
///
/// ```
/// use multibody::batch::{SimulationBatch, Threads};
/// use multibody::{Model, pendulum, simulator::SimulationBuilder};
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
/// Where machine code takes steps of semi-implicit Euler or Runge and Kutta under torques, one call takes those of several simulations, side by side in the
/// lanes of registers.
#[derive(Debug)]
pub struct SimulationBatch {
    simulations: Vec<Simulation>,
    threads: Threads,
    /// One for each thread, where machine code takes the steps.
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
    /// So many copies of a simulation as it is now.
    pub fn new(simulation: &Simulation, count: usize, threads: &Threads) -> Self {
        let kernels = kernels_for(Some(simulation).filter(|_| count > 1), threads);
        Self { simulations: vec![simulation.clone(); count], threads: threads.clone(), kernels }
    }

    /// The simulations.
    pub fn simulations(&self) -> &[Simulation] {
        &self.simulations
    }

    /// The simulations, to set states and inputs.
    pub fn simulations_mut(&mut self) -> &mut [Simulation] {
        &mut self.simulations
    }

    /// Computes on other threads from now on.
    ///
    /// ```
    /// use multibody::batch::{SimulationBatch, Threads};
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
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

    /// Takes so many steps of each simulation. Returns those that could not go on, by their numbers, in rising order; each is where its last good step
    /// ended, and the others have taken all steps. Where `cancelled` is set meanwhile, each simulation ends after the step that it is in.
    pub fn step(&mut self, steps: usize, cancelled: &AtomicBool) -> Vec<(usize, StepFailure)> {
        self.advance(None, steps, cancelled)
    }

    /// As [`step`](Self::step), of the simulations whose entry of `which` is set; the others stay as they are.
    ///
    /// ```
    /// use multibody::batch::{SimulationBatch, Threads};
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
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
    /// If `which` has not one entry for each simulation.
    #[track_caller]
    pub fn step_where(
        &mut self,
        which: &[bool],
        steps: usize,
        cancelled: &AtomicBool,
    ) -> Vec<(usize, StepFailure)> {
        self.check_count("which", which.len(), 1);
        self.for_each(
            |number, simulation| {
                if which[number] { advance(simulation, steps, cancelled) } else { Ok(()) }
            },
        )
    }

    /// [`Simulation::reset`] of the simulations whose entry of `which` is set, each from its row of q \[count\]\[nq\] and v \[count\]\[nv\]. Returns those that cannot
    /// start there, which stay as they were.
    ///
    /// ```
    /// use multibody::batch::{SimulationBatch, Threads};
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// let mut batch = SimulationBatch::new(&simulation, 3, &Threads::start(1)?);
    /// let failed = batch.reset_where(&[false, true, true], &[0.1, 0.2, f64::NAN], &[0.0; 3]);
    /// assert_eq!((failed.len(), failed[0].0), (1, 2));
    /// assert_eq!(batch.simulations().iter().map(|own| own.q()[0]).collect::<Vec<_>>(), [0.0, 0.2, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a table has not one row for each simulation.
    #[track_caller]
    pub fn reset_where(&mut self, which: &[bool], q: &[f64], v: &[f64]) -> Vec<(usize, StepFailure)> {
        self.place(which, q, v, Simulation::reset)
    }

    /// [`Simulation::set_state`] of the simulations whose entry of `which` is set, as [`reset_where`](Self::reset_where): time, inputs and activations stay.
    ///
    /// ```
    /// use multibody::batch::{SimulationBatch, Threads};
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
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
    /// If a table has not one row for each simulation.
    #[track_caller]
    pub fn set_states_where(&mut self, which: &[bool], q: &[f64], v: &[f64]) -> Vec<(usize, StepFailure)> {
        self.place(which, q, v, Simulation::set_state)
    }

    #[track_caller]
    fn place(&mut self, which: &[bool], q: &[f64], v: &[f64], place: Place) -> Vec<(usize, StepFailure)> {
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
    ) -> Vec<(usize, StepFailure)> {
        let is_meant = |number: usize| which.is_none_or(|which| which[number]);
        if self.kernels.is_empty() {
            return self.for_each(|number, simulation| {
                if is_meant(number) { advance(simulation, steps, cancelled) } else { Ok(()) }
            });
        }
        let memory = &self.kernels;
        let blocks = |(block, simulations): (usize, &mut [Simulation])| {
            // A thread has its own memory.
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

    /// Does the same to each simulation, on all threads. Returns those that failed, in rising order.
    fn for_each(
        &mut self,
        act: impl Fn(usize, &mut Simulation) -> Result<(), StepFailure> + Sync,
    ) -> Vec<(usize, StepFailure)> {
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

/// Puts a simulation at (q, v).
type Place = fn(&mut Simulation, &[f64], &[f64]) -> Result<(), StepFailure>;

/// So many steps, unless `cancelled` is set meanwhile.
fn advance(simulation: &mut Simulation, steps: usize, cancelled: &AtomicBool) -> Result<(), StepFailure> {
    let go_on = |_: &usize| !cancelled.load(Ordering::Relaxed);
    (0..steps).take_while(go_on).try_for_each(|_| simulation.step())
}
