//! Options and results of optimal control by sampling.

use std::time::Duration;

use robot_dynamics_number::{InvalidInput, check_positive};

use super::super::Termination;

/// The law by which the costs of samples change the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SamplingLaw {
    /// Model predictive path integral control: the mean becomes the average of the samples with the weights
    /// e^(−(J − J_min)/λ). Source: Williams, Drews, Goldfain, Rehg, Theodorou, *Information-theoretic model
    /// predictive control*, IEEE Trans. Robotics 34 (2018).
    #[doc(alias = "MPPI")]
    Mppi {
        /// λ, in the unit of the cost: samples whose costs differ by less count alike.
        temperature: f64,
    },
    /// The cross-entropy method: mean and deviation become those of the best samples. Source: Rubinstein,
    /// Kroese, *The Cross-Entropy Method* (2004), ch. 5.
    #[doc(alias = "CEM")]
    CrossEntropy {
        /// The number of best samples, from 2 to the number of samples.
        elites: usize,
        /// The smallest deviation, as a share of the initial one; 0.05 keeps some exploration.
        least_deviation: f64,
    },
}

/// The options of [`Sampling`](super::Sampling).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SamplingOptions {
    /// The law.
    pub law: SamplingLaw,
    /// The samples of an iteration. One of them is the mean.
    pub samples: usize,
    /// The iterations of a solution.
    pub iterations: usize,
    /// The standard deviation of each control; one number serves all.
    pub deviation: Vec<f64>,
    /// The correlation of the noise of consecutive nodes, from 0 to below 1. Correlated noise moves a robot
    /// further than white noise of the same size.
    pub correlation: f64,
    /// The random numbers follow from it, from the iteration and from the sample.
    pub seed: u64,
    /// The threads that evaluate samples; the results do not depend on their number.
    pub threads: usize,
    /// No iteration starts after this time.
    pub time_limit: Option<Duration>,
}

impl SamplingOptions {
    /// Options of a law with a deviation of the controls: 256 samples, 20 iterations, white noise, seed 0,
    /// one thread.
    pub fn new(law: SamplingLaw, deviation: &[f64]) -> Self {
        let deviation = deviation.to_vec();
        let (seed, threads, time_limit) = (0, 1, None);
        Self { law, samples: 256, iterations: 20, deviation, correlation: 0.0, seed, threads, time_limit }
    }

    /// Checks each number.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        if self.samples < 2 || self.iterations == 0 || self.threads == 0 {
            let required = "must be at least 2 samples, an iteration and a thread";
            return Err(InvalidInput::unmet("the counts of the sampling", required));
        }
        if self.deviation.is_empty() {
            return Err(InvalidInput::unmet("the deviation of the controls", "must have a number"));
        }
        for deviation in &self.deviation {
            check_positive("the deviation of a control", *deviation, "")?;
        }
        check_share("the correlation", self.correlation)?;
        match self.law {
            SamplingLaw::Mppi { temperature } => check_positive("the temperature", temperature, "")?,
            SamplingLaw::CrossEntropy { elites, least_deviation } => {
                if !(2..=self.samples).contains(&elites) {
                    let required = format!("must be from 2 to {}, got {elites}", self.samples);
                    return Err(InvalidInput::unmet("the number of elites", required));
                }
                check_share("the smallest deviation", least_deviation)?;
            }
        }
        Ok(())
    }
}

fn check_share(quantity: &str, value: f64) -> Result<(), InvalidInput> {
    if (0.0..1.0).contains(&value) {
        return Ok(());
    }
    Err(InvalidInput::out_of_range(quantity, value, "", "from 0 to below 1"))
}

/// One iteration of a sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SamplingRecord {
    /// Its index, from 0.
    pub iteration: usize,
    /// The cost of the mean before it.
    pub mean_cost: f64,
    /// The least cost of all samples so far.
    pub best_cost: f64,
    /// (Σw)²/Σw² of the weights: near 1, a single sample decides; the temperature is then too low.
    pub effective_samples: f64,
    /// The samples whose dynamics or cost could not be computed.
    pub failed: usize,
}

/// The result of a sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SamplingReport {
    /// The reason for the end: a sampling has no test of optimality, so that it never reports convergence.
    pub termination: Termination,
    /// The number of iterations.
    pub iterations: usize,
    /// The cost of the controls.
    pub cost: f64,
    /// The cost of the controls before the first iteration; infinite if their dynamics failed.
    pub initial_cost: f64,
    /// The failed samples of all iterations.
    pub failed: usize,
}
