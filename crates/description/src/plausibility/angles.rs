//! Angles and limits that seem not to be in radians.

use core::f64::consts::{FRAC_PI_2, PI};

use super::{Cause, Culprit, Quantity, Suspicion};
use crate::{JointKind, RobotDescription};

/// The angles of one frame as a file writes them, before they become a rotation.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WrittenAngles {
    /// The owner of the frame, as in `joint "elbow"`.
    pub place: String,
    /// Roll, pitch and yaw, or the three angles of the format \[rad, if the file is right\].
    pub angles: [f64; 3],
}

impl WrittenAngles {
    /// The angles of the frame of this owner.
    pub fn new(place: impl Into<String>, angles: [f64; 3]) -> Self {
        Self { place: place.into(), angles }
    }
}

/// The largest angle of a frame \[rad\]: one turn in either direction, with a hundredth of tolerance for 6.3.
const TURN: f64 = 1.01 * 2.0 * PI;

/// The largest stop of a joint \[rad\]: joints of several turns have stops at up to two or three turns in
/// either direction.
const STOP: f64 = 8.0 * PI;

/// The bound above which a joint counts as unlimited \[rad\]: 1e16 and the like.
const UNBOUNDED: f64 = 999.0;

/// The largest speed of a joint with stops \[rad/s\]: 1150 revolutions per minute.
const FASTEST: f64 = 120.0;

/// The range of a slide relative to the robot's size. It is up to 1.2 for a slide with stops. A slide with
/// equal stops on both sides may stand for a free base, and reaches a hundred sizes of a robot hand.
const TRAVEL: f64 = 20.0;
const FREE_TRAVEL: f64 = 200.0;

/// The bound above which a slide counts as unlimited \[m\].
const ENDLESS: f64 = 1e5;

/// Frames rotated by more than one turn.
pub(super) fn rotations(written: &[WrittenAngles]) -> Option<Suspicion> {
    let largest = |angles: &[f64; 3]| {
        let suspect =
            angles.iter().map(|angle| angle.abs()).filter(|&angle| angle > TURN && !is_quarters(angle));
        suspect.fold(0.0, f64::max)
    };
    let out = written.iter().map(|frame| (largest(&frame.angles), frame.place.clone()));
    let turned = written.iter().filter(|frame| frame.angles.iter().any(|&angle| angle != 0.0)).count();
    gather(Quantity::WrittenAngle, out, turned, TURN, Culprit::Angles)
}

/// Limits of rotations in degrees, and of slides in millimetres, in a robot of this size \[m\].
pub(super) fn limits(description: &RobotDescription, size: f64) -> impl Iterator<Item = Suspicion> {
    let bound = |limits: &crate::Limits| {
        let known = [limits.lower, limits.upper].map(f64::abs).into_iter().filter(|x| x.is_finite());
        known.fold(0.0, f64::max)
    };
    let turns = || description.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Revolute { .. }));
    let place = |joint: &crate::JointDescription| format!("joint {:?}", joint.name);
    let stops = turns().map(|joint| {
        let bound = bound(&joint.limits);
        let is_degrees = bound > STOP && bound < UNBOUNDED && !is_quarters(bound);
        (if is_degrees { bound } else { 0.0 }, place(joint))
    });
    let speeds = turns().map(|joint| {
        let speed = joint.limits.velocity;
        let is_degrees = speed > FASTEST && speed < UNBOUNDED && !is_power_of_ten(speed);
        (if is_degrees { speed } else { 0.0 }, place(joint))
    });
    let slides =
        || description.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Prismatic { .. }));
    let travels = slides().map(|joint| {
        let bound = bound(&joint.limits);
        let most = if joint.limits.lower == -joint.limits.upper { FREE_TRAVEL } else { TRAVEL } * size;
        let is_long = size > 0.0 && bound > most && bound < ENDLESS && !is_power_of_ten(bound);
        (if is_long { bound / size } else { 0.0 }, place(joint))
    });
    let (turns, slides) = (turns().count(), slides().count());
    let mut millimetres = gather(Quantity::SlideOverSize, travels, slides, TRAVEL, Culprit::SlideLimits);
    if let Some(suspicion) = &mut millimetres {
        suspicion.cause.factor = 1e3;
    }
    [
        gather(Quantity::AngleLimit, stops, turns, STOP, Culprit::AngleLimits),
        gather(Quantity::TurnSpeedLimit, speeds, turns, FASTEST, Culprit::AngleLimits),
        millimetres,
    ]
    .into_iter()
    .flatten()
}

/// One suspicion for all values above 0, the largest first.
fn gather(
    quantity: Quantity,
    values: impl Iterator<Item = (f64, String)>,
    of: usize,
    most: f64,
    culprit: Culprit,
) -> Option<Suspicion> {
    let mut out: Vec<(f64, String)> = values.filter(|(value, _)| *value > 0.0).collect();
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    Some(Suspicion {
        quantity,
        found: out.first()?.0,
        places: out.into_iter().map(|(_, place)| place).collect(),
        of,
        expected: (None, Some(most)),
        cause: Cause { culprit, factor: 180.0 / PI },
    })
}

/// Whether an angle is a multiple of π/2 in radians, such as 5π/2. At most ten turns, because 355 is near 226
/// quarter turns; no smaller whole number of degrees is near a multiple.
fn is_quarters(angle: f64) -> bool {
    let quarters = angle / FRAC_PI_2;
    quarters < 40.5 && (quarters - quarters.round()).abs() < 1e-3
}

/// 1000 and other powers of ten are placeholders for an unlimited value.
fn is_power_of_ten(x: f64) -> bool {
    let decades = x.log10();
    (decades - decades.round()).abs() < 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_round_number_of_degrees_is_taken_for_quarter_turns() {
        for degrees in 7..=720 {
            assert!(!is_quarters(f64::from(degrees)), "{degrees}");
        }
        for quarters in 1..=40 {
            // As printed with four decimals.
            let printed = (f64::from(quarters) * FRAC_PI_2 * 1e4).round() / 1e4;
            assert!(is_quarters(printed), "{quarters}");
        }
    }
}
