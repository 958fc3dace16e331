//! A hash of everything that affects a robot's motion.

use core::fmt::{self, Write};

use crate::{Medium, RobotDescription};

/// The hash of everything that affects a robot's motion: all but its shapes, sensors, poses and groups.
#[doc(hidden)]
pub fn fingerprint(description: &RobotDescription) -> u64 {
    let mut hash = Fnv1a(0xcbf2_9ce4_8422_2325);
    // All fields that affect the motion; floats with enough digits to read back as the same number.
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
        fluid_shapes,
        medium,
        spatial_tendons,
        equalities,
        actuators,
        sensors: _,
        poses: _,
        groups: _,
        end_effectors: _,
        actuated_joints,
        time_step: _,
        impratio: _,
    } = description;
    let motion = (name, gravity, base, links, joints, frames);
    let written = write!(hash, "{motion:?}{:?}", (tendons, equalities, actuators));
    // Without spatial tendons or a list of actuated joints nothing is hashed, so that such robots keep their
    // fingerprints.
    let paths = if spatial_tendons.is_empty() { Ok(()) } else { write!(hash, "{spatial_tendons:?}") };
    let chosen = actuated_joints.as_ref().map_or(Ok(()), |joints| write!(hash, "{joints:?}"));
    // Likewise for robots without a fluid.
    let is_dry = *medium == Medium::default() && fluid_shapes.is_empty();
    let wet = if is_dry { Ok(()) } else { write!(hash, "{medium:?}{fluid_shapes:?}") };
    debug_assert!(written.and(paths).and(chosen).and(wet).is_ok(), "a description has a text");
    hash.0
}

/// The hash of Fowler, Noll and Vo, variant 1a with 64 bits.
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
    use crate::{JointKind, Pose, PoseSpring, TendonDescription, pendulum};

    /// The published value for the bytes of `foobar`.
    #[test]
    fn the_hash_is_the_published_one() {
        let mut hash = Fnv1a(0xcbf2_9ce4_8422_2325);
        assert!(hash.write_str("foobar").is_ok());
        assert_eq!(hash.0, 0x8594_4171_f739_67e8);
    }

    /// The fingerprint of one robot with every part that has a text of its own, as of version 0.1.
    #[test]
    fn fingerprints_do_not_change_with_names_of_types() {
        let mut robot = pendulum(2.0, 0.5);
        robot.joints[0].kind = JointKind::Spherical;
        robot.joints[0].spring = Some(PoseSpring { stiffness: 40.0, rest: Pose::IDENTITY });
        robot.joints[0].higher_terms.damping = [0.5, 0.25];
        robot.tendons.push(TendonDescription::new("cord", [("joint".to_owned(), 1.0)]));
        assert_eq!(fingerprint(&robot), 0xf395_6dc0_198d_2d5f);
    }
}
