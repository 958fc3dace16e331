//! Options of consistent identification.

use robot_dynamics_core::PARAMETERS_PER_LINK;
use robot_dynamics_number::InvalidInput;

use super::entropic::Block;
use super::error::check_inertial_parameters;
use super::{IdentificationError, JointTermKind, MotionRecord};

/// How a consistent estimate is regularized.
///
/// ```
/// use robot_dynamics::control::identification::{ConsistentOptions, JointTermKind};
/// let options = ConsistentOptions::new(1e-2)
///     .hold("base_link") // keeps its parameters
///     .with_joint_nominal(JointTermKind::Friction, 0.5); // the file has none
/// assert_eq!(options.held_links, ["base_link"]);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConsistentOptions {
    /// γ, positive: the weight of the divergence from the nominal parameters against squared torque errors in
    /// units of the noise.
    #[doc(alias = "gamma")]
    pub regularization: f64,
    /// The names of links that keep their nominal parameters.
    pub held_links: Vec<String>,
    /// x₀ in the order of [`MotionRecord::parameter_names`]; `None` takes the robot as described.
    pub nominal: Option<Vec<f64>>,
    /// Nominal values of joint terms, which replace those of x₀.
    pub joint_nominals: Vec<(JointTermKind, f64)>,
    /// s: how far offsets may plausibly be from their nominal values \[N·m or N\]; 1 by default.
    pub offset_deviation: f64,
    /// The least radius of gyration of nominal bodies about each principal axis plane \[m\]; 0 by default.
    /// Thin rods and points need one.
    pub least_radius: f64,
}

impl ConsistentOptions {
    /// The options with a weight γ of the divergence.
    pub fn new(regularization: f64) -> Self {
        Self {
            regularization,
            held_links: Vec::new(),
            nominal: None,
            joint_nominals: Vec::new(),
            offset_deviation: 1.0,
            least_radius: 0.0,
        }
    }

    /// Keeps the nominal parameters of a link.
    #[must_use]
    pub fn hold(mut self, link: impl Into<String>) -> Self {
        self.held_links.push(link.into());
        self
    }

    /// Sets the nominal value of a kind of joint term, for all joints.
    #[must_use]
    pub fn with_joint_nominal(mut self, kind: JointTermKind, value: f64) -> Self {
        self.joint_nominals.push((kind, value));
        self
    }

    /// Sets x₀.
    #[must_use]
    pub fn with_nominal(mut self, nominal: Vec<f64>) -> Self {
        self.nominal = Some(nominal);
        self
    }

    /// Sets the least radius of gyration of nominal bodies \[m\].
    #[must_use]
    pub fn with_least_radius(mut self, radius: f64) -> Self {
        self.least_radius = radius;
        self
    }

    /// Sets the deviation of offsets \[N·m or N\].
    #[must_use]
    pub fn with_offset_deviation(mut self, deviation: f64) -> Self {
        self.offset_deviation = deviation;
        self
    }

    pub(super) fn check(&self, record: &MotionRecord<'_>) -> Result<(), InvalidInput> {
        for (name, value) in
            [("the regularization", self.regularization), ("the deviation of offsets", self.offset_deviation)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InvalidInput::out_of_range(name, value, "", "positive and finite"));
            }
        }
        if !(self.least_radius >= 0.0 && self.least_radius.is_finite()) {
            let requirement = "zero or positive, and finite";
            return Err(InvalidInput::out_of_range("the least radius", self.least_radius, "m", requirement));
        }
        let links: Vec<&str> = record.model.moving_links().collect();
        if let Some(unknown) = self.held_links.iter().find(|held| !links.contains(&held.as_str())) {
            let owner = format!("robot `{}`", record.model.name());
            return Err(InvalidInput::unknown_name("moving link", unknown, owner, links));
        }
        if let Some(nominal) = &self.nominal {
            check_inertial_parameters(nominal, record.columns())?;
        }
        Ok(())
    }

    /// x₀.
    pub(super) fn nominal_of(&self, record: &MotionRecord<'_>) -> Vec<f64> {
        let mut nominal = self.nominal.clone().unwrap_or_else(|| record.nominal().to_vec());
        let first = PARAMETERS_PER_LINK * record.links();
        for (value, term) in nominal[first..].iter_mut().zip(record.terms()) {
            let stated = self.joint_nominals.iter().rev().find(|(kind, _)| kind.name() == term.kind.name());
            *value = stated.map_or(*value, |(_, stated)| *stated);
        }
        nominal
    }

    /// The groups of unknown parameters.
    pub(super) fn blocks(
        &self,
        record: &MotionRecord<'_>,
        nominal: &[f64],
    ) -> Result<Vec<Block>, IdentificationError> {
        let mut blocks = Vec::new();
        let (inertial, joints) = nominal.split_at(PARAMETERS_PER_LINK * record.links());
        let (links, _) = inertial.as_chunks::<PARAMETERS_PER_LINK>();
        for (k, (link, nominal)) in record.model.moving_links().zip(links).enumerate() {
            let massless = nominal.iter().all(|parameter| *parameter == 0.0);
            if massless || self.held_links.iter().any(|held| held == link) {
                continue;
            }
            let block = Block::link(PARAMETERS_PER_LINK * k, nominal, self.least_radius);
            blocks.push(block.ok_or_else(|| IdentificationError::SingularNominal { link: link.into() })?);
        }
        for (k, (term, &nominal)) in record.terms().iter().zip(joints).enumerate() {
            let index = inertial.len() + k;
            blocks.push(match term.kind {
                JointTermKind::Offset => Block::Offset { index, nominal, deviation: self.offset_deviation },
                _ if nominal > 0.0 => Block::Positive { index, nominal },
                _ => {
                    let quantity = format!("the nominal value of `{}`", term.label(record.model));
                    return Err(InvalidInput::out_of_range(quantity, nominal, "", "positive").into());
                }
            });
        }
        Ok(blocks)
    }
}
