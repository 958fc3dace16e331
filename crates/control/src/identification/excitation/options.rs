//! Limits and options of exciting motions.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

use crate::dof_limits::check_dof_limits;
use crate::identification::joint_term::check_terms;
use crate::identification::record::check_noise;
use crate::identification::{IdentificationError, JointTerm};

/// Limits of a motion, one number for each coordinate; infinite without a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationLimits {
    /// The smallest and largest q \[rad or m\].
    pub position: Vec<[f64; 2]>,
    /// The largest |v| \[rad/s or m/s\].
    pub velocity: Vec<f64>,
    /// The largest |a| \[rad/s² or m/s²\].
    pub acceleration: Vec<f64>,
    /// The largest |τ| \[N·m or N\], by the robot as described, with damping and friction.
    pub torque: Vec<f64>,
}

impl ExcitationLimits {
    /// The limits of the robot's description, without acceleration limits. Those of mimic joints are not
    /// included.
    ///
    /// ```
    /// use robot_dynamics::control::identification::ExcitationLimits;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(ExcitationLimits::of(&model).acceleration, [f64::INFINITY]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(model: &Model) -> Self {
        let limits = model.coordinate_limits();
        Self {
            position: limits.iter().map(|limit| [limit.lower, limit.upper]).collect(),
            velocity: limits.iter().map(|limit| limit.velocity).collect(),
            acceleration: vec![f64::INFINITY; model.nv()],
            torque: limits.iter().map(|limit| limit.effort).collect(),
        }
    }

    /// Checks lengths and signs, and that every coordinate is limited.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        let magnitudes: [(&str, &[f64]); 3] = [
            ("the velocity limits", &self.velocity),
            ("the acceleration limits", &self.acceleration),
            ("the torque limits", &self.torque),
        ];
        check_dof_limits(model, &magnitudes, &self.position)?;
        for (i, [lower, upper]) in self.position.iter().enumerate() {
            let limited =
                (upper - lower).is_finite() || self.velocity[i].min(self.acceleration[i]).is_finite();
            if !limited {
                let quantity = format!("the limits of `{}`", model.coordinate_names()[i]);
                let requirement = "must bound the position, the velocity or the acceleration";
                return Err(InvalidInput::unmet(quantity, requirement));
            }
        }
        Ok(())
    }
}

/// The measure of information that an exciting motion improves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcitationCriterion {
    /// The determinant of WᵀW of the base parameters: the volume of the confidence ellipsoid. It does not
    /// depend on units.
    #[doc(alias = "D-optimal")]
    Determinant,
    /// The condition number of W with columns of unit length, after the determinant.
    Condition,
}

/// How an exciting motion is designed.
///
/// ```
/// use robot_dynamics::control::identification::{ExcitationCriterion, ExcitationOptions};
/// let options = ExcitationOptions::new(10.0, 5).with_criterion(ExcitationCriterion::Condition).with_seed(3);
/// assert!(options.from_rest && options.samples == 60);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExcitationOptions {
    /// T \[s\].
    pub period: f64,
    /// K.
    pub harmonics: usize,
    /// Whether velocity and acceleration are zero at the start and at the end. It needs K ≥ 2.
    pub from_rest: bool,
    /// The number of equidistant states at which the information is computed; 12 K by default.
    pub samples: usize,
    /// The joint terms that are identified as well.
    pub terms: Vec<JointTerm>,
    /// The standard deviation of each torque; empty if all are equal.
    pub noise: Vec<f64>,
    /// The measure of information.
    pub criterion: ExcitationCriterion,
    /// The most steps for each weight of the barrier; 60 by default.
    pub steps: usize,
    /// The seed of the random series from which the search starts.
    pub seed: u64,
}

impl ExcitationOptions {
    /// The options of a series with a period \[s\] and a number of harmonics.
    pub fn new(period: f64, harmonics: usize) -> Self {
        Self {
            period,
            harmonics,
            from_rest: true,
            samples: 12 * harmonics,
            terms: Vec::new(),
            noise: Vec::new(),
            criterion: ExcitationCriterion::Determinant,
            steps: 60,
            seed: 1,
        }
    }

    /// Sets whether the motion starts and ends at rest.
    #[must_use]
    pub fn with_rest(mut self, from_rest: bool) -> Self {
        self.from_rest = from_rest;
        self
    }

    /// Sets the joint terms.
    #[must_use]
    pub fn with_terms(mut self, terms: &[JointTerm]) -> Self {
        self.terms = terms.to_vec();
        self
    }

    /// Sets the standard deviations of the torques.
    #[must_use]
    pub fn with_noise(mut self, noise: &[f64]) -> Self {
        self.noise = noise.to_vec();
        self
    }

    /// Sets the measure of information.
    #[must_use]
    pub fn with_criterion(mut self, criterion: ExcitationCriterion) -> Self {
        self.criterion = criterion;
        self
    }

    /// Sets the number of states at which the information is computed.
    #[must_use]
    pub fn with_samples(mut self, samples: usize) -> Self {
        self.samples = samples;
        self
    }

    /// Sets the most steps for each weight of the barrier.
    #[must_use]
    pub fn with_steps(mut self, steps: usize) -> Self {
        self.steps = steps;
        self
    }

    /// Sets the seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    pub(super) fn check(&self, model: &Model) -> Result<(), IdentificationError> {
        check_terms(model, &self.terms)?;
        if !(self.period > 0.0 && self.period.is_finite()) {
            let requirement = "positive and finite";
            return Err(InvalidInput::out_of_range("the period", self.period, "s", requirement).into());
        }
        if self.harmonics < 1 + usize::from(self.from_rest) {
            let requirement = "must be at least 1, and at least 2 from rest";
            return Err(InvalidInput::unmet("the number of harmonics", requirement).into());
        }
        if !self.noise.is_empty() {
            check_noise(&self.noise, model.nv())?;
        }
        if !model.is_vector_space() {
            let requirement = "must have joints that turn about or slide along an axis only";
            return Err(InvalidInput::unmet("the robot of an exciting motion", requirement).into());
        }
        Ok(())
    }
}
