//! The shapes in pairs that the robot's description names.

use std::collections::{HashMap, HashSet};

use robot_dynamics_description::{LinkShape, RobotDescription, Shape, Surface};
use robot_dynamics_number::InvalidInput;

use super::ground::bad_surface;

/// The shapes in named pairs, each with the planes and height fields paired with it and the surfaces of these
/// pairs.
pub(super) struct NamedPairs<'a>(HashMap<&'a str, Vec<(String, Surface)>>);

impl<'a> NamedPairs<'a> {
    /// # Errors
    /// [`InvalidInput`]: a number of a pair is invalid.
    pub(super) fn of(robot: &'a RobotDescription) -> Result<Self, InvalidInput> {
        let grounds = robot.shapes.iter().filter(|shape| is_ground(shape));
        let grounds: HashSet<&str> = grounds.map(|shape| shape.name.as_str()).collect();
        let mut stated = HashMap::new();
        for pair in &robot.contact_pairs {
            let [one, two] = [0, 1].map(|k| pair.shapes[k].as_str());
            if let Some(quantity) = pair.surface().not_finite() {
                return Err(bad_surface(&format!("pair of `{one}` and `{two}`"), quantity));
            }
            for (own, other) in [(one, two), (two, one)] {
                let on_grounds: &mut Vec<(String, Surface)> = stated.entry(own).or_default();
                if grounds.contains(other) && on_grounds.iter().all(|(ground, _)| ground != other) {
                    on_grounds.push((other.to_owned(), pair.surface()));
                }
            }
        }
        Ok(Self(stated))
    }

    /// Whether a pair names this shape.
    pub(super) fn names(&self, shape: &str) -> bool {
        self.0.contains_key(shape)
    }

    /// The planes and height fields paired with the shape, and the surfaces of these pairs.
    pub(super) fn on_grounds(&self, shape: &str) -> Vec<(String, Surface)> {
        self.0.get(shape).cloned().unwrap_or_default()
    }
}

pub(super) fn is_ground(shape: &LinkShape) -> bool {
    matches!(shape.shape, Shape::Plane { .. } | Shape::HeightField { .. })
}
