//! The bodies that carry a body, and the coordinates that move it.

use std::collections::BTreeSet;

use super::WORLD;
use super::robot::Model;

impl Model {
    /// A body and those that carry it, up to the root of its tree. Nothing for [`WORLD`].
    pub fn body_and_ancestors(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        let moving = |body: usize| (body != WORLD).then_some(body);
        core::iter::successors(moving(body), move |&at| moving(self.bodies[at].parent))
    }

    /// The body nearest to both that carries both, or is one of them; else [`WORLD`].
    pub fn common_ancestor(&self, [a, b]: [usize; 2]) -> usize {
        let carries_b = |body: &usize| self.body_and_ancestors(b).any(|other| other == *body);
        self.body_and_ancestors(a).find(carries_b).unwrap_or(WORLD)
    }

    /// The coordinates of v that move a body relative to one that carries it, or to [`WORLD`].
    pub fn coordinates_between(&self, carrier: usize, body: usize) -> BTreeSet<usize> {
        let own = |body: usize| {
            let body = &self.bodies[body];
            self.dofs[body.dof..body.dof + body.motion.nv()].iter().map(|dof| dof.coordinate)
        };
        self.body_and_ancestors(body).take_while(|&at| at != carrier).flat_map(own).collect()
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{RandomRobotOptions, random_robot};

    use super::*;

    /// By parents that are marked one after another.
    #[test]
    fn common_ancestors_and_coordinates_follow_from_sets_of_ancestors() {
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).unwrap();
            let bodies = model.bodies.len();
            let carries = |carrier: usize, mut body: usize| {
                while body != WORLD && body != carrier {
                    body = model.bodies[body].parent;
                }
                body == carrier
            };
            for a in 0..bodies {
                assert_eq!(model.common_ancestor([a, WORLD]), WORLD);
                for b in 0..bodies {
                    // Parents have smaller indices than their children.
                    let expected = (0..bodies).rev().find(|&c| carries(c, a) && carries(c, b));
                    let common = model.common_ancestor([a, b]);
                    assert_eq!(common, expected.unwrap_or(WORLD));
                    let moving = |dof: &&crate::model::Dof| {
                        carries(dof.body, a) && (common == WORLD || !carries(dof.body, common))
                    };
                    let expected: BTreeSet<usize> =
                        model.dofs.iter().filter(moving).map(|dof| dof.coordinate).collect();
                    assert_eq!(model.coordinates_between(common, a), expected);
                }
            }
        }
    }
}
