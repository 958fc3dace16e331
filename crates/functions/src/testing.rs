//! Robots for the tests of this crate and of the crate `generate`.

use robot_dynamics_core::Model;
use robot_dynamics_description::{Base, JointKind, RandomRobotOptions, random_robot};

/// A robot with a floating base, a spherical joint, springs, friction and a mimic joint.
pub(crate) fn free_robot() -> Model {
    let options = RandomRobotOptions {
        joints: 4,
        base: Base::Floating,
        mimic: 0.3,
        passive: 1.0,
        ..Default::default()
    };
    let has_ball = |model: &Model| model.joints().iter().any(|joint| joint.kind == JointKind::Spherical);
    (0..1000)
        .map(|seed| Model::new(random_robot(seed, &options)).unwrap())
        .find(|model| has_ball(model) && model.has_mimic())
        .unwrap()
}
