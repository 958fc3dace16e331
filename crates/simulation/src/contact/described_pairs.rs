//! Pairs of shapes that the robot's description names: they touch regardless of masks and exclusions.

use std::collections::{BTreeSet, HashMap};

use robot_dynamics_core::Model;
use robot_dynamics_description::ContactPairDescription;

use super::ContactSet;
use super::convex::KNOWN;
use super::named_pairs::is_ground;
use super::pair::ShapePair;

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
                            self.add_named(ShapePair::new(model, [one, two], pair.surface()));
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
