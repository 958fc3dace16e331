//! What can be wrong with a robot or an input.

use thiserror::Error;

/// Several of a sort.
fn plural(sort: &str) -> String {
    if let Some(stem) = sort.strip_suffix('y') { format!("{stem}ies") } else { format!("{sort}s") }
}

/// Why a [`RobotDescription`](crate::RobotDescription) is not a robot.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// There is no link.
    #[error("the robot has no links; add at least one")]
    NoLinks,
    /// Two things of one sort share a name.
    #[error("two {} are named `{name}`; rename one", plural(.sort))]
    DuplicateName {
        /// `link`, `joint`, `frame`, `tendon`, `equality`, `actuator` or `sensor`.
        sort: &'static str,
        /// The shared name.
        name: String,
    },
    /// A joint, frame or follower names something that is not there.
    #[error("{user} refers to {sort} `{name}`, which does not exist")]
    UnknownName {
        /// Who refers to it, for example ``joint `elbow` ``.
        user: String,
        /// `link`, `joint` or `tendon`.
        sort: &'static str,
        /// The missing name.
        name: String,
    },
    /// A link is the child of two joints.
    #[error("link `{link}` is the child of both joint `{first}` and joint `{second}`; a tree allows one")]
    TwoParents {
        /// The link.
        link: String,
        /// One joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// Not exactly one root: several links are no joint's child.
    #[error("links {} are all roots; connect them with joints", .links.join(", "))]
    SeveralRoots {
        /// The roots.
        links: Vec<String>,
    },
    /// Links that no path from the root reaches: their joints form a loop.
    #[error("links {} form a loop of joints that the root does not reach", .links.join(", "))]
    Cycle {
        /// The links on or behind the loop.
        links: Vec<String>,
    },
    /// An axis has no direction.
    #[error("joint `{joint}`: the axis {axis:?} has no direction; give a finite, non-zero vector")]
    ZeroAxis {
        /// The joint.
        joint: String,
        /// The axis given.
        axis: [f64; 3],
    },
    /// A number is NaN or infinite, or out of its range.
    #[error("{owner}: {quantity} = {value} is not {expected}")]
    BadNumber {
        /// Whose number, for example ``joint `elbow` ``.
        owner: String,
        /// Which quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What it should be, for example `finite`.
        expected: &'static str,
    },
    /// A placement's matrix is not a rotation.
    #[error("{owner}: the rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// Whose placement.
        owner: String,
        /// max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// A sensor whose object or reference does not fit its kind.
    #[error("sensor `{sensor}` ({kind}): {reason}")]
    BadSensor {
        /// The sensor.
        sensor: String,
        /// The name of its kind.
        kind: &'static str,
        /// Why not, and what to do.
        reason: String,
    },
    /// A follower cannot follow: itself, a joint of several freedoms, or in a circle.
    #[error("joint `{joint}` cannot follow joint `{leader}`: {reason}")]
    BadMimic {
        /// The follower.
        joint: String,
        /// The joint it names.
        leader: String,
        /// Why not.
        reason: &'static str,
    },
}

/// A robot has no frame of a name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("robot `{robot}` has no frame or link `{name}`{}", .similar.as_ref().map(|similar| format!("; did you mean `{similar}`?")).unwrap_or_default())]
#[non_exhaustive]
pub struct NoSuchFrame {
    /// The robot.
    pub robot: String,
    /// The name asked for.
    pub name: String,
    /// The robot's name that is most like it, if one is.
    pub similar: Option<String>,
}

/// The name most like the one asked for: at most a third of its letters changed, or a part of it, or it of them.
pub(crate) fn similar<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> Option<String> {
    let asked = asked.to_lowercase();
    let rank = |name: &str| {
        let name = name.to_lowercase();
        let changed = strsim::damerau_levenshtein(&asked, &name);
        let is_part =
            !asked.is_empty() && !name.is_empty() && (name.contains(&asked) || asked.contains(&name));
        (is_part || 3 * changed <= asked.chars().count()).then_some(changed)
    };
    let ranked = names.filter_map(|name| rank(name).map(|changed| (changed, name)));
    ranked.min_by_key(|(changed, _)| *changed).map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_found_by_part_and_by_slip() {
        let names = ["panda_link7", "panda_hand", "panda_leftfinger"];
        let of = |asked| similar(asked, names.into_iter());
        assert_eq!(of("hand").as_deref(), Some("panda_hand"));
        assert_eq!(of("panda_hnad").as_deref(), Some("panda_hand"));
        assert_eq!(of("Panda_Link7").as_deref(), Some("panda_link7"));
        assert_eq!(of("wheel"), None);
        assert_eq!(of(""), None);
    }
}
