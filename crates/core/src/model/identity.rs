//! The identity of a robot, which ties workspaces and frames to it.

use std::sync::Arc;

use robot_dynamics_description::{RobotDescription, fingerprint};

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

    /// Panics with both names: `what` belongs to the robot `owner`, not to this one.
    #[cold]
    #[inline(never)]
    #[track_caller]
    pub(super) fn refuse(&self, owner: &Self, what: &str) -> ! {
        let (own, other) = (&owner.name, &self.name);
        let same = if own == other { " of the same name" } else { "" };
        panic!("{what} is for robot `{own}`, not for `{other}`{same}: make one for this model");
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
