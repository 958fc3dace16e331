//! Robots for the tests of this crate and of the crate `generate`.

use multibody::{Base, JointKind, Model, RandomRobotOptions, random_robot};

/// A robot that nothing holds, with a ball, springs, friction and a follower.
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
