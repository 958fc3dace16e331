//! Which robot something was made for.

use core::fmt::{self, Write};
use std::sync::Arc;

use crate::{Model, RobotDescription};

/// A robot by its content: the same for clones of a model and for models of equal descriptions, another one as soon as a
/// number or a name differs that its motion depends on.
///
/// A workspace or a frame of another robot gives numbers that look right; so each says whose it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    hash: u64,
    name: Arc<str>,
}

impl Identity {
    pub(crate) fn of(description: &RobotDescription) -> Self {
        let mut hash = Fnv1a(0xcbf2_9ce4_8422_2325);
        // All that moves the robot, so not its shapes; floats with the digits that read back as the same number.
        let RobotDescription {
            name,
            gravity,
            base,
            links,
            joints,
            frames,
            shapes: _,
            contact_exclusions: _,
            contact_pairs: _,
            tendons,
            equalities,
            actuators,
            sensors: _,
            poses: _,
            actuated_joints,
            time_step: _,
            impratio: _,
        } = description;
        let motion = (name, gravity, base, links, joints, frames);
        let written = write!(hash, "{motion:?}{:?}", (tendons, equalities, actuators));
        // Robots whose motors are not chosen keep the fingerprint that they had.
        let chosen = actuated_joints.as_ref().map_or(Ok(()), |joints| write!(hash, "{joints:?}"));
        debug_assert!(written.and(chosen).is_ok(), "a description has a text");
        Self { hash: hash.0, name: description.name.as_str().into() }
    }

    pub(crate) fn hash(&self) -> u64 {
        self.hash
    }

    /// Panics with both names where `what` was made for another robot.
    #[inline(always)]
    #[track_caller]
    pub(crate) fn check(&self, model: &Model, what: &str) {
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
    /// A number that tells robots apart: a hash of the description but its shapes, sensors and poses, equal where every name and every
    /// digit is. What
    /// was made for one robot (workspaces, frames) is refused by every robot with another.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let robot = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(robot.fingerprint(), Model::new(pendulum(2.0, 0.5))?.fingerprint());
    /// assert_ne!(robot.fingerprint(), Model::new(pendulum(2.0_f64.next_up(), 0.5))?.fingerprint());
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn fingerprint(&self) -> u64 {
        self.identity.hash()
    }
}

/// Fowler, Noll and Vo's hash, variant 1a of 64 bits.
struct Fnv1a(u64);

impl Write for Fnv1a {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RandomRobotOptions, random_robot};

    /// The published value for the bytes of `foobar`.
    #[test]
    fn the_hash_is_the_published_one() {
        let mut hash = Fnv1a(0xcbf2_9ce4_8422_2325);
        assert!(hash.write_str("foobar").is_ok());
        assert_eq!(hash.0, 0x8594_4171_f739_67e8);
    }

    #[test]
    fn equal_content_is_the_same_robot_and_the_last_digit_makes_another() {
        let robot = random_robot(5, &RandomRobotOptions::default());
        assert_eq!(Identity::of(&robot), Identity::of(&robot.clone()));
        let mut moved = robot.clone();
        moved.gravity[2] = moved.gravity[2].next_up();
        assert_ne!(Identity::of(&robot), Identity::of(&moved));
    }
}
