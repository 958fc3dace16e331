//! Errors of a robot description.

use robot_dynamics_number::{Classified, ErrorKind, InputProblem, InvalidInput};
use thiserror::Error;

use crate::InertiaError;

/// The plural of a sort.
fn plural(sort: &str) -> String {
    if let Some(stem) = sort.strip_suffix('y') { format!("{stem}ies") } else { format!("{sort}s") }
}

/// The reason why a [`RobotDescription`](crate::RobotDescription) is invalid, or cannot be changed or
/// written as requested: the error of `Model::new`, `JointMap::new`, the edits of descriptions and scenes,
/// and the writers.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "EditError")]
#[doc(alias = "SurgeryError")]
#[doc(alias = "WriteError")]
#[doc(alias = "ParameterError")]
pub enum ModelError {
    /// An argument of a change is invalid: a name that does not exist, a wrong number of coordinates or of
    /// parameters, or a number that is not finite.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// There is no link.
    #[error("the robot has no links; add at least one")]
    NoLinks,
    /// Two items of one sort share a name.
    #[error("two {} are named `{name}`; rename one", plural(.sort))]
    DuplicateName {
        /// `link`, `joint`, `frame`, `tendon`, `equality`, `actuator` or `sensor`.
        sort: &'static str,
        /// The shared name.
        name: String,
    },
    /// A robot that is added to a scene has a name that the scene already has.
    #[error("the scene already has a {sort} `{name}`; add the robot with a prefix")]
    NameInScene {
        /// `link or frame`, `joint`, `tendon`, `equality`, `actuator`, `sensor` or `pose`.
        sort: &'static str,
        /// The name.
        name: String,
    },
    /// The path of a spatial tendon is invalid.
    #[error("tendon `{tendon}`: {problem}")]
    TendonPath {
        /// The tendon.
        tendon: String,
        /// The fault and its remedy.
        problem: &'static str,
    },
    /// The transmission of an actuator is invalid.
    #[error("actuator `{actuator}`: {problem}")]
    Transmission {
        /// The actuator.
        actuator: String,
        /// The fault and its remedy.
        problem: &'static str,
    },
    /// A joint, frame or mimic joint refers to an unknown name.
    #[error("{user} refers to {sort} `{name}`, which does not exist")]
    UnknownName {
        /// The item that refers to it, for example ``joint `elbow` ``.
        user: String,
        /// `link`, `joint` or `tendon`.
        sort: &'static str,
        /// The unknown name.
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
    /// There are several roots: links that are not a child of any joint.
    #[error("links {} are all roots; connect them with joints", .links.join(", "))]
    SeveralRoots {
        /// The roots.
        links: Vec<String>,
    },
    /// Links without a path from the root: their joints form a loop.
    #[error("links {} form a loop of joints that the root does not reach", .links.join(", "))]
    Cycle {
        /// The links on or behind the loop.
        links: Vec<String>,
    },
    /// An axis is zero.
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
        /// The owner of the number, for example ``joint `elbow` ``.
        owner: String,
        /// The quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// The requirement, for example `finite`.
        expected: &'static str,
    },
    /// A placement's matrix is not a rotation.
    #[error("{owner}: the rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// The owner of the placement.
        owner: String,
        /// max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// A sensor's object or reference does not match its kind.
    #[error("sensor `{sensor}` ({kind}): {reason}")]
    BadSensor {
        /// The sensor.
        sensor: String,
        /// The name of its kind.
        kind: &'static str,
        /// The reason, and the remedy.
        reason: String,
    },
    /// An invalid mimic joint: its leader is itself, a joint of several DoFs, or part of a cycle.
    #[error("joint `{joint}` cannot follow joint `{leader}`: {reason}")]
    BadMimic {
        /// The mimic joint.
        joint: String,
        /// Its leader.
        leader: String,
        /// The reason.
        reason: &'static str,
    },
    /// A change of a mimic joint, whose position is that of its leader.
    #[error("joint `{joint}` follows joint `{leader}`; lock `{leader}` instead")]
    Follows {
        /// The mimic joint.
        joint: String,
        /// Its leader.
        leader: String,
    },
    /// A change of the root link reverses a joint that has no equal reversed joint.
    #[error("joint `{joint}` cannot be reversed: {reason}")]
    Irreversible {
        /// The joint.
        joint: String,
        /// The reason.
        reason: &'static str,
    },
    /// A nonzero passive force among the parameters of a floating base, which has none.
    #[error("`{joint}` is the floating base: it has no passive forces, its five parameters must be 0")]
    FloatingBase {
        /// The joint's name.
        joint: String,
    },
    /// The parameters of a link give an invalid inertia.
    #[error("link `{link}`: {error}")]
    Inertia {
        /// The moving link.
        link: String,
        /// The reason.
        error: InertiaError,
    },
    /// A link is fixed to a moving link, and different fractions of their weights are supported by gravity
    /// compensation. Parameters of the moving link do not separate the two.
    #[error(
        "link `{link}` is fixed to `{carrier}`, of whose weight another part is carried: they have no parameters together"
    )]
    Carried {
        /// The link.
        link: String,
        /// The moving link that it is fixed to.
        carrier: String,
    },
    /// The mass of a mesh cannot be computed from its file.
    #[error("mesh `{file}`: {reason}")]
    Mesh {
        /// The file.
        file: String,
        /// The reason.
        reason: String,
    },
    /// A nonzero first moment without mass among the parameters of a link.
    #[error("link `{link}` has mass 0 and a first moment m c that is not 0")]
    MomentWithoutMass {
        /// The moving link.
        link: String,
    },
    /// A reduced robot of a [`JointMap`](https://docs.rs/robot-dynamics/latest/robot_dynamics/model/struct.JointMap.html)
    /// is not the full one with some joints locked.
    #[error("joint `{joint}` {reason}")]
    #[doc(alias = "JointMapError")]
    NotReduced {
        /// The joint, or the base's joint if the base is fixed.
        joint: String,
        /// The difference, and the remedy.
        reason: String,
    },
    /// The file format cannot represent the robot; lists every reason.
    #[error("{}", .0.join("; "))]
    Unwritable(Vec<String>),
}

impl Classified for ModelError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Follows { .. } | Self::Irreversible { .. } | Self::Unwritable(_) => ErrorKind::Unsupported,
            _ => ErrorKind::Description,
        }
    }
}

/// The error of a name that does not exist, with the most similar name. `sort` is the sort of the named
/// object.
///
/// ```
/// use robot_dynamics_description::unknown_name;
/// let error = unknown_name("joint", "elbo", "robot `arm`", ["shoulder", "elbow"].into_iter());
/// assert_eq!(error.to_string(), "robot `arm` has no joint `elbo`; did you mean `elbow`?");
/// ```
#[doc(hidden)]
pub fn unknown_name<'a>(
    sort: &str,
    name: &str,
    owner: impl Into<String>,
    names: impl Iterator<Item = &'a str>,
) -> InvalidInput {
    let known = similar(name, names).map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
    InvalidInput::new(sort, InputProblem::UnknownName { name: name.into(), owner: owner.into(), known })
}

/// The name most similar to the one given: at most a third of its letters differ, or one name contains the
/// other.
#[doc(hidden)]
pub fn similar<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> Option<String> {
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
