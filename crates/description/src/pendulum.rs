//! A pendulum, the smallest robot, for which formulas can be checked by hand.

use crate::{
    FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};

/// A point mass of `mass` \[kg\] at the end of a massless rod of `length` \[m\]: m l² v̇ − m g l cos q = τ.
///
/// At q = 0 the rod points along the world's x axis from the hinge at the origin. It rotates about y, so it
/// moves down for q > 0. The links are `ceiling` and `rod`, the joint is `hinge`, and the frame at the point
/// mass is `tip`.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let hold = model.gravity_forces(&[0.0])?; // horizontal
/// assert!((hold[0] + 2.0 * 9.81 * 0.5).abs() < 1e-14);
/// assert!((model.mass_matrix(&[0.0])?[(0, 0)] - 2.0 * 0.5 * 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a number is not positive and finite.
#[track_caller]
pub fn pendulum(mass: f64, length: f64) -> RobotDescription {
    assert!(mass > 0.0 && mass.is_finite(), "the mass must be positive and finite, got {mass} kg");
    assert!(length > 0.0 && length.is_finite(), "the length must be positive and finite, got {length} m");
    let point = MassProperties::point(mass, [length, 0.0, 0.0].into()).expect("a positive mass");
    let mut robot = RobotDescription::new("pendulum");
    robot.links.push(LinkDescription::new("ceiling", None));
    robot.links.push(LinkDescription::new("rod", point));
    let about_y = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.joints.push(JointDescription::new("hinge", about_y, "ceiling", "rod", Pose::IDENTITY));
    robot.frames.push(FrameDescription::new("tip", "rod", Pose::from_translation([length, 0.0, 0.0])));
    robot
}
