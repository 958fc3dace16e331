//! Whether a robot's numbers look as if they were in the units they should be in.
//!
//! A file with masses in grams or angles in degrees describes a robot like any other: every law of mechanics
//! holds for it. What gives it away is experience: how dense machines are, and how their links' masses sit
//! within their links' extents. [`suspicions`] compares these statistics with ranges that hold for the robots
//! in circulation:
//!
//! | statistic | equation | grows with |
//! | --- | --- | --- |
//! | density of the link's ellipsoid | ρ = m/V, V of the solid ellipsoid with the link's m and moments | m^5/2 I^−3/2 |
//! | radius of gyration over extent | √(I₃/m)/L, L the link's extent | I^1/2 m^−1/2 L^−1 |
//! | centre of mass over the robot's size | ∣c∣/D | c D^−1 |
//! | mass over the cube of the extent | m/L³ | m L^−3 |
//! | density of the link's shapes | m/V, V of the primitives drawn on the link | m |
//!
//! and angles and limits with what they can be in radians. A link's extent L is the farthest of: its joint in
//! its parent, its children's joints and its shapes in its own frame. The robot's size D is the longest path
//! of joint offsets from the root, with the shapes at its end.
//!
//! Density has one bound that is no matter of experience: among all bodies of mass m and given second moments
//! whose density is nowhere above ρ, the solid ellipsoid of density ρ has the smallest moments. So an ellipsoid
//! denser than any material belongs to no body.

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

/// What looks like a wrong unit or a slipped decimal point, the whole robot's first.
///
/// `angles` are the angles as the file writes them, as a rotation no longer shows that 90 was meant in degrees; they may be
/// empty. Linear in the size of the robot.
///
/// No suspicion does not mean that the numbers are right. A factor of ten, for one, lies within what
/// differs between good robots.
///
/// ```
/// use multibody::pendulum;
/// use multibody::plausibility::suspicions;
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
