//! Masses, moments and centres of mass compared with the ranges of correct robots.

use std::collections::HashSet;

use super::cause::{Decades, decades, explain};
use super::{Cause, Culprit, LinkStatistics, Quantity, RobotStatistics, Suspicion};

// The ranges, with the values of correct robots (docs/explanation/unit-checks.md has the distributions).

/// The density of osmium \[kg/m³\]: above it no body has these moments. A single link is reported only if it
/// is this many times denser, because the numbers of small links are often rounded down.
const DENSEST: f64 = 22_590.0;
const DENSER: f64 = 4.0;

/// \[kg/m³\] The frame of a drone has 12, an arm of thin shells 60.
const THINNEST: f64 = 5.0;

/// The least ratio of radius of gyration to extent at which a low density counts. A planar robot's links may
/// have three equal moments, which give a low density without large moments.
const LARGE: f64 = 1.2;

/// Radius of gyration over extent: 0.29 for a rod between its joints; 0.04 to 1 for the median link of
/// robots.
const COMPACT: f64 = 0.01;
const SPREAD: f64 = 2.0;

/// |c|/D: up to 1.4, in a gripper with one short offset.
const FAR: f64 = 3.0;

/// |c| over the radius of gyration. A bob on a long massless rod has its mass many radii away, but it is the only such link.
const FAR_RADII: f64 = 30.0;

/// m/L³ of the median link \[kg/m³\]: 0.15 to 2 700.
const LIGHT: f64 = 0.01;
const HEAVY: f64 = 3e4;

/// m over the shapes' volume, median link \[kg/m³\]: 19 to 33 000, because shapes often cover only a part of
/// the link.
const HOLLOW: f64 = 0.5;
const FILLED: f64 = 1e6;

/// A single link is reported only if it changes how the robot moves. Its share of the mass, or of the whole
/// robot's m D², must exceed this fraction.
const MASS_SHARE: f64 = 1e-2;
const MOMENT_SHARE: f64 = 1e-2;
/// A smaller link that a joint moves is reported if its density is this far below the range.
const FAR_OFF: f64 = 0.1;
const MOVED_SHARE: f64 = 1e-3;

/// The fraction of m D² that is too much for a link whose mass would have to be outside the robot.
const OUTSIDE_SHARE: f64 = 1e-4;

/// The rule for one statistic.
struct Rule {
    quantity: Quantity,
    range: (Option<f64>, Option<f64>),
    value: fn(&LinkStatistics, &RobotStatistics) -> Option<f64>,
    /// Whether a single link out of range is reported; `None` for statistics that are significant only for
    /// most links.
    matters: Option<fn(&LinkStatistics, &RobotStatistics) -> bool>,
}

/// The rules, in order of precedence. Among those about mass, moments and spacing, only the first for which
/// most links are out of range makes a general suspicion.
const RULES: [Rule; 5] = [
    Rule {
        quantity: Quantity::EllipsoidDensity,
        range: (Some(THINNEST), Some(DENSEST)),
        value: |link, _| link.ellipsoid_density,
        matters: Some(|link, robot| match link.ellipsoid_density {
            Some(density) if density > DENSEST => {
                density > DENSER * DENSEST && link.mass > MASS_SHARE * robot.mass
            }
            Some(density) if link.gyration > LARGE * link.extent => {
                let share = share_of_moment(link, robot);
                let is_far_off = link.is_moved && density < FAR_OFF * THINNEST;
                share > MOMENT_SHARE
                    || is_far_off && (share > MOVED_SHARE || missing_mass(link) > MASS_SHARE * robot.mass)
            }
            _ => false,
        }),
    },
    Rule {
        quantity: Quantity::GyrationOverExtent,
        range: (Some(COMPACT), Some(SPREAD)),
        value: |link, _| link.gyration_over_extent(),
        // Joints may be close together on a large body, so only most links together show that the moments are
        // too large. A body with an ellipsoid is already reported.
        matters: Some(|link, robot| {
            link.ellipsoid_density.is_none()
                && link.gyration < COMPACT * link.extent
                && link.mass > MASS_SHARE * robot.mass
                && link.extent > 0.1 * robot.size
        }),
    },
    Rule {
        quantity: Quantity::GyrationOverSize,
        range: (None, Some(1.0)),
        value: |link, robot| (robot.size > 0.0 && link.gyration > 0.0).then(|| link.gyration / robot.size),
        matters: Some(|link, robot| share_of_moment(link, robot) > OUTSIDE_SHARE),
    },
    Rule {
        quantity: Quantity::MassOverCubedExtent,
        range: (Some(LIGHT), Some(HEAVY)),
        value: |link, _| link.mass_over_cubed_extent(),
        matters: None,
    },
    Rule {
        quantity: Quantity::ShapeDensity,
        range: (Some(HOLLOW), Some(FILLED)),
        value: |link, _| link.shape_density,
        matters: None,
    },
];

/// m k² of the link over m D² of the robot; 0 for a robot without size.
fn share_of_moment(link: &LinkStatistics, robot: &RobotStatistics) -> f64 {
    let all = robot.mass * robot.size * robot.size;
    if all > 0.0 { link.mass * link.gyration * link.gyration / all } else { 0.0 }
}

/// The mass that a link should have, if its mass is the wrong number; else 0.
fn missing_mass(link: &LinkStatistics) -> f64 {
    let cause = explain(decades(link), false);
    if cause.culprit == Culprit::Masses { link.mass / cause.factor } else { 0.0 }
}

pub(super) fn suspicions(robot: &RobotStatistics) -> Vec<Suspicion> {
    let mut found: Vec<Suspicion> = Vec::new();
    let general = RULES.iter().find_map(|rule| general(rule, robot));
    if let Some(general) = general {
        found.push(general);
    } else {
        let mut told: HashSet<&str> = HashSet::new();
        for rule in &RULES {
            let Some(matters) = rule.matters else { continue };
            let of = robot.links.iter().filter(|link| (rule.value)(link, robot).is_some()).count();
            for link in &robot.links {
                let Some(value) = (rule.value)(link, robot) else { continue };
                if inside(value, rule.range) || !matters(link, robot) || !told.insert(&link.link) {
                    continue;
                }
                found.push(Suspicion {
                    quantity: rule.quantity,
                    places: vec![place(link)],
                    of,
                    found: value,
                    expected: rule.range,
                    cause: explain(decades(link), false),
                });
            }
        }
    }
    found.extend(centers_of_mass(robot));
    found
}

fn place(link: &LinkStatistics) -> String {
    format!("link {:?}", link.link)
}

fn inside(value: f64, (low, high): (Option<f64>, Option<f64>)) -> bool {
    !low.is_some_and(|low| value < low) && !high.is_some_and(|high| value > high)
}

/// A suspicion about the whole robot: more than half of the links are out of range on one side, that is, the
/// median is.
fn general(rule: &Rule, robot: &RobotStatistics) -> Option<Suspicion> {
    let values: Vec<(f64, &LinkStatistics)> =
        robot.links.iter().filter_map(|link| Some(((rule.value)(link, robot)?, link))).collect();
    let below = |value: f64| rule.range.0.is_some_and(|low| value < low);
    let above = |value: f64| rule.range.1.is_some_and(|high| value > high);
    let mut out: Vec<(f64, &LinkStatistics)> = values.iter().copied().filter(|(x, _)| below(*x)).collect();
    if 2 * out.len() <= values.len() {
        out = values.iter().copied().filter(|(x, _)| above(*x)).collect();
    }
    if values.len() < 2 || 2 * out.len() <= values.len() {
        return None;
    }
    // A statistic that is significant only for most links must be known for most links.
    if rule.matters.is_none() && 2 * values.len() <= robot.links.len() {
        return None;
    }
    let typical = middle(values.iter().map(|(x, _)| *x))?;
    let spread = middle(robot.links.iter().filter_map(LinkStatistics::gyration_over_extent));
    if rule.quantity == Quantity::EllipsoidDensity && below(typical) && spread.is_some_and(|x| x < LARGE) {
        return None;
    }
    // The farthest from the range first.
    out.sort_by(|a, b| if below(typical) { a.0.total_cmp(&b.0) } else { b.0.total_cmp(&a.0) });
    let all: Vec<Decades> = robot.links.iter().map(decades).collect();
    let traces = [0, 1, 2].map(|i| middle(all.iter().filter_map(|link| link[i])));
    Some(Suspicion {
        quantity: rule.quantity,
        places: out.iter().map(|(_, link)| place(link)).collect(),
        of: values.len(),
        found: typical,
        expected: rule.range,
        cause: explain(traces, true),
    })
}

/// The median; of an even number of values the lower one.
fn middle(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

/// Centres of mass outside the robot, in one suspicion.
fn centers_of_mass(robot: &RobotStatistics) -> Option<Suspicion> {
    if robot.size <= 0.0 {
        return None;
    }
    let far = |link: &&LinkStatistics| {
        let distance = link.center_distance;
        let is_bob = link.gyration == 0.0 && distance <= FAR_RADII * robot.size;
        distance > FAR * robot.size && distance > FAR_RADII * link.gyration && !is_bob
    };
    let mut out: Vec<&LinkStatistics> = robot.links.iter().filter(far).collect();
    out.sort_by(|a, b| b.center_distance.total_cmp(&a.center_distance));
    let worst = out.first()?;
    // A typical distance of a centre of mass from the joint: a radius of gyration, or 0.025 of the robot's
    // size.
    let near = if worst.gyration > 0.0 { worst.gyration } else { 0.025 * robot.size };
    Some(Suspicion {
        quantity: Quantity::CenterOfMassOverSize,
        places: out.iter().map(|link| place(link)).collect(),
        of: robot.links.iter().filter(|link| link.center_distance > 0.0).count(),
        found: worst.center_distance / robot.size,
        expected: (None, Some(FAR)),
        cause: Cause { culprit: Culprit::CentersOfMass, factor: worst.center_distance / near },
    })
}
