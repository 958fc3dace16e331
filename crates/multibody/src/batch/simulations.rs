//! Many simulations of one robot, stepped together.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Threads;
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
#[derive(Clone, Debug)]
pub struct SimulationBatch {
    simulations: Vec<Simulation>,
    threads: Threads,
}

impl SimulationBatch {
    /// So many copies of a simulation as it is now.
    pub fn new(simulation: &Simulation, count: usize, threads: &Threads) -> Self {
        Self { simulations: vec![simulation.clone(); count], threads: threads.clone() }
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
        self.threads = threads.clone();
    }

    /// Takes so many steps of each simulation. Returns those that could not go on, by their numbers, in rising order; each is where its last good step
    /// ended, and the others have taken all steps. Where `cancelled` is set meanwhile, each simulation ends after the step that it is in.
    pub fn step(&mut self, steps: usize, cancelled: &AtomicBool) -> Vec<(usize, StepFailure)> {
        let advance = |(number, simulation): (usize, &mut Simulation)| {
            let go_on = |_: &usize| !cancelled.load(Ordering::Relaxed);
            let moved = (0..steps).take_while(go_on).try_for_each(|_| simulation.step());
            moved.err().map(|failure| (number, failure))
        };
        let simulations = &mut self.simulations;
        if self.threads.count() == 1 {
            return simulations.iter_mut().enumerate().filter_map(advance).collect();
        }
        self.threads.install(|| simulations.par_iter_mut().enumerate().filter_map(advance).collect())
    }
}
