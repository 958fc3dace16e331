//! The identity of a robot, which ties workspaces and frames to it.

use std::sync::Arc;

use robot_dynamics_description::{RobotDescription, fingerprint};

use crate::Model;

/// Identifies a robot by its content. It is equal for clones of a model and for models of equal descriptions.
/// It differs as soon as any name or number differs that affects the motion.
///
/// A workspace or a frame of another robot would give wrong numbers without an error, so each stores the
/// identity of its robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    hash: u64,
    name: Arc<str>,
}

impl Identity {
    pub fn of(description: &RobotDescription) -> Self {
        Self { hash: fingerprint(description), name: description.name.as_str().into() }
    }

    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// Panics with both names if `what` belongs to another robot.
    #[inline(always)]
    #[track_caller]
    pub fn check(&self, model: &Model, what: &str) {
        if self.hash != model.identity.hash {
            self.refuse(model, what);
        }
    }

    #[cold]
    #[inline(never)]
    #[track_caller]
    fn refuse(&self, model: &Model, what: &str) -> ! {
        let (own, other) = (&self.name, &model.identity.name);
        let same = if own == other { " of the same name" } else { "" };
        panic!("{what} is for robot `{own}`, not for `{other}`{same}: make one for this model");
    }
}

impl Model {
    /// A hash of the description without its shapes, sensors and poses: equal if every name and every digit
    /// is. Workspaces and frames of one robot panic when used with a robot of another fingerprint.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let robot = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(robot.fingerprint(), Model::new(pendulum(2.0, 0.5))?.fingerprint());
    /// assert_ne!(robot.fingerprint(), Model::new(pendulum(2.0_f64.next_up(), 0.5))?.fingerprint());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn fingerprint(&self) -> u64 {
        self.identity.hash()
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{RandomRobotOptions, random_robot};

    use super::*;

    #[test]
    fn equal_content_is_the_same_robot_and_the_last_digit_makes_another() {
        let robot = random_robot(5, &RandomRobotOptions::default());
        assert_eq!(Identity::of(&robot), Identity::of(&robot.clone()));
        let mut moved = robot.clone();
        moved.gravity[2] = moved.gravity[2].next_up();
        assert_ne!(Identity::of(&robot), Identity::of(&moved));
    }
}
