//! Pairs of shapes that the robot's description names: they touch regardless of masks and exclusions.

use std::collections::{BTreeSet, HashMap, HashSet};

use robot_dynamics_core::Model;
use robot_dynamics_description::{ContactPairDescription, LinkShape, RobotDescription, Shape, Surface};

use super::convex::KNOWN;
use super::pair::Pair;
use super::{ContactError, ContactSet};

/// The shapes in named pairs, each with the planes and height fields paired with it and the surfaces of these
/// pairs.
pub(super) struct NamedPairs<'a>(HashMap<&'a str, Vec<(String, Surface)>>);

impl<'a> NamedPairs<'a> {
    /// # Errors
    /// [`ContactError::Surface`]: a number of a pair is invalid.
    pub(super) fn of(robot: &'a RobotDescription) -> Result<Self, ContactError> {
        let grounds = robot.shapes.iter().filter(|shape| is_ground(shape));
        let grounds: HashSet<&str> = grounds.map(|shape| shape.name.as_str()).collect();
        let mut stated = HashMap::new();
        for pair in &robot.contact_pairs {
            let [one, two] = [0, 1].map(|k| pair.shapes[k].as_str());
            if let Some(quantity) = pair.surface().not_finite() {
                return Err(ContactError::Surface {
                    shape: format!("pair of `{one}` and `{two}`"),
                    quantity,
                });
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

fn is_ground(shape: &LinkShape) -> bool {
    matches!(shape.shape, Shape::Plane { .. } | Shape::HeightField { .. })
}

impl ContactSet {
    /// Adds the pairs that the description names. Returns their shapes, each pair in increasing order.
    pub(super) fn add_stated(&mut self, model: &Model) -> BTreeSet<[usize; 2]> {
        let mut known = BTreeSet::new();
        let robot = model.description();
        if robot.contact_pairs.is_empty() {
            return known;
        }
        // The first of several shapes with a name counts.
        let mut numbers = HashMap::new();
        for (index, shape) in self.shapes.iter().enumerate().filter(|(_, shape)| !shape.name.is_empty()) {
            numbers.entry(shape.name.clone()).or_insert(index);
        }
        let has_ground = |names: &[String; 2]| {
            robot.shapes.iter().any(|shape| is_ground(shape) && names.contains(&shape.name))
        };
        for pair in &robot.contact_pairs {
            let found = [0, 1].map(|k| numbers.get(&pair.shapes[k]).copied());
            let reason = match found {
                [Some(one), Some(two)] => {
                    let shapes = [one.min(two), one.max(two)];
                    let bodies = shapes.map(|index| self.shapes[index].body);
                    if bodies[0] == bodies[1] {
                        "they do not move against each other"
                    } else if !self.is_known(shapes) {
                        KNOWN
                    } else {
                        if known.insert(shapes) {
                            let [one, two] = [0, 1].map(|k| (shapes[k], bodies[k]));
                            self.add_named(Pair::new(model, [one, two], pair.surface()));
                        }
                        continue;
                    }
                }
                // A pair with a plane or a height field is a contact with the ground.
                _ if has_ground(&pair.shapes) => continue,
                _ => "one of them is no shape for collisions of a kind that is known",
            };
            let ContactPairDescription { shapes: [one, two], .. } = pair;
            self.left_out_pairs.push(format!("pair of shapes `{one}` and `{two}`: {reason}"));
        }
        known
    }
}
