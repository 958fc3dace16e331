//! Unsupported features of a description, grouped by reason.

use core::fmt;

use super::Simulation;

/// Features of a description that a simulation leaves out for the same reason; see
/// [`Simulation::unsupported_features`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct UnsupportedFeatures {
    /// The reason.
    pub reason: String,
    /// The features, in the order of the description.
    pub features: Vec<String>,
}

/// Up to this many features are all named; of a longer list only the first are named and the rest is counted.
const ALL: usize = 5;
const NAMED: usize = 2;

impl fmt::Display for UnsupportedFeatures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { reason, features } = self;
        let count = if features.len() > ALL { NAMED } else { features.len() };
        let named = features[..count].join(", ");
        match features.len() - count {
            0 => write!(f, "{named}: {reason}"),
            others => write!(f, "{named} and {others} more: {reason}"),
        }
    }
}

impl Simulation {
    /// The features that the description states and this simulation leaves out
    /// ([`left_out`](Self::left_out)), with one entry for each reason.
    ///
    /// ```
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Integrator, Method, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.5, 0.5);
    /// let model = Model::new(robot)?;
    /// let rows = Method::Fixed(Integrator::RungeKutta4);
    /// let simulation = SimulationBuilder::new(&model).method(rows).build()?;
    /// let left_out = simulation.unsupported_features();
    /// assert_eq!(left_out[0].features, ["position limits"]);
    /// assert_eq!(left_out[0].to_string(), "position limits: `rk4` does not know them, `implicit` does");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn unsupported_features(&self) -> Vec<UnsupportedFeatures> {
        let mut groups: Vec<UnsupportedFeatures> = Vec::new();
        for said in self.left_out() {
            let (feature, reason) = said.split_at_checked(end_of_feature(said)).unwrap_or((said, ""));
            let reason = reason.trim_start_matches([':', ' ']);
            match groups.iter_mut().find(|group| group.reason == reason) {
                Some(group) => group.features.push(feature.to_owned()),
                None => groups.push(UnsupportedFeatures {
                    reason: reason.to_owned(),
                    features: vec![feature.to_owned()],
                }),
            }
        }
        groups
    }
}

/// The start of the reason: the first colon outside a name in backticks.
fn end_of_feature(said: &str) -> usize {
    let mut in_name = false;
    let is_end = |(at, character): (usize, char)| {
        in_name ^= character == '`';
        (!in_name && said[at..].starts_with(": ")).then_some(at)
    };
    said.char_indices().find_map(is_end).unwrap_or(said.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colons_in_names_do_not_end_a_feature() {
        let said = "contact of links `a: b` and `c`: no shape: none at all";
        assert_eq!(&said[end_of_feature(said)..], ": no shape: none at all");
        assert_eq!(end_of_feature("all"), 3);
    }

    #[test]
    fn many_features_are_counted() {
        let features = ["one", "two", "three", "four", "five", "six"].map(String::from).to_vec();
        let few = UnsupportedFeatures { reason: "no room".into(), features: features[..3].to_vec() };
        assert_eq!(few.to_string(), "one, two, three: no room");
        let many = UnsupportedFeatures { reason: "no room".into(), features };
        assert_eq!(many.to_string(), "one, two and 4 more: no room");
    }
}
