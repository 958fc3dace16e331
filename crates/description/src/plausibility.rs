//! Checks whether a robot's numbers seem to be in the right units.
//!
//! The laws of mechanics also hold for a file with masses in grams or angles in degrees. Statistics reveal
//! the error: the density of machines, and the distribution of their links' masses within the links' extents.
//! [`suspicions`] compares these statistics with the ranges of robots in circulation:
//!
//! | statistic | equation | grows with |
//! | --- | --- | --- |
//! | density of the link's ellipsoid | ρ = m/V, V of the solid ellipsoid with the link's m and moments | m^5/2 I^−3/2 |
//! | radius of gyration over extent | √(I₃/m)/L, L the link's extent | I^1/2 m^−1/2 L^−1 |
//! | centre of mass over the robot's size | ∣c∣/D | c D^−1 |
//! | mass over the cube of the extent | m/L³ | m L^−3 |
//! | density of the link's shapes | m/V, V of the primitive shapes of the link | m |
//!
//! It also compares angles and limits with the range of angles in radians. A link's extent L is the largest
//! distance of its joint in its parent, its children's joints and its shapes in its own frame. The robot's
//! size D is the longest path of joint offsets from the root, with the shapes at its end.
//!
//! Density has one bound that follows from physics. Consider all bodies of mass m and given second moments
//! whose density is nowhere above ρ. The solid ellipsoid of density ρ has the smallest moments among them. So
//! an ellipsoid denser than any material belongs to no body.

mod angles;
mod bodies;
mod cause;
mod links;
mod suspicion;

pub use angles::WrittenAngles;
pub use cause::{Cause, Culprit};
pub use links::{LinkStatistics, RobotStatistics};
pub use suspicion::{Quantity, Suspicion};

use crate::RobotDescription;

/// Numbers that seem to be in a wrong unit or to have a misplaced decimal point, those of the whole robot
/// first.
///
/// `angles` are the angles as the file writes them, because a rotation does not show that 90 meant degrees;
/// they may be empty. O(n).
///
/// An empty result does not mean that the numbers are right. For example, a factor of ten is within the
/// variation between correct robots.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::plausibility::suspicions;
/// let mut robot = pendulum(2.0, 0.5);
/// assert!(suspicions(&robot, &[]).is_empty());
/// robot.joints[0].limits.upper = 135.0; // in degrees
/// let found = suspicions(&robot, &[]);
/// assert_eq!(found[0].places, ["joint \"hinge\""]);
/// assert_eq!(found[0].found, 135.0);
/// ```
pub fn suspicions(description: &RobotDescription, angles: &[WrittenAngles]) -> Vec<Suspicion> {
    let statistics = RobotStatistics::new(description);
    let mut found = bodies::suspicions(&statistics);
    found.extend(angles::rotations(angles));
    found.extend(angles::limits(description, statistics.size));
    found.sort_by_key(|suspicion| !suspicion.is_general());
    found
}
