//! Spatial tendons, as a robot's file describes them.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Limits, PassiveForces, PolynomialStiffnessDamping, Pose, TendonSolverImpedance};

/// A tendon along the shortest path through points of links and around spheres and cylinders, such as a
/// cable, a belt or a muscle's tendon.
///
/// Its length ℓ(q) is that of the path, each branch divided by its divisor. Its force is that of a joint with
/// the position ℓ, −stiffness·(ℓ − rest) − damping·ℓ̇ − friction·sign ℓ̇, and acts by ∂ℓ/∂q. It has no
/// armature.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct SpatialTendonDescription {
    /// Its name, unique among all tendons.
    pub name: String,
    /// The path: at least two points in each branch, with at most one surface between two points.
    pub path: Vec<TendonPathElement>,
    /// Damping, friction and stiffness, as for a joint; `rest` is the start of the spring's dead band. The
    /// armature is 0.
    pub passive: PassiveForces,
    /// Polynomial terms of its spring and damper.
    pub higher_terms: PolynomialStiffnessDamping,
    /// The largest elastic stretch of its spring. Beyond it the spring yields: its dead band follows. 0 for a
    /// spring that never yields. If the dead band begins at 0, a stretch moves its end alone.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spring_yield: f64,
    /// The length of the dead band: the spring pulls beyond `passive.rest` plus this length.
    pub dead_band: f64,
    /// Bounds on ℓ; `effort` and `velocity` are not read.
    pub limits: Limits,
    /// Bounds on the total force of its actuators \[N\].
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::numbers_or_infinity"))]
    pub actuator_force_range: [f64; 2],
    /// The softness of its limits under MuJoCo's law.
    pub softness: TendonSolverImpedance,
}

/// A part of a spatial tendon's path.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum TendonPathElement {
    /// The path passes through the origin of a link or frame.
    Point {
        /// Its name.
        frame: String,
    },
    /// The path goes around a surface if it is in the way.
    Surface {
        /// The link of the surface.
        link: String,
        /// The pose of the surface in the link; a cylinder's axis is z.
        link_from_surface: Pose,
        /// A sphere, or a cylinder of infinite length.
        surface: TendonSurface,
        /// The radius \[m\].
        radius: f64,
        /// A link or frame whose origin is on the side of the path. If it is inside the surface, the path
        /// touches the surface from inside.
        side: Option<String>,
    },
    /// The path starts anew. The lengths of the following branch are divided by this number.
    Pulley {
        /// The divisor, positive.
        divisor: f64,
    },
}

impl TendonPathElement {
    /// The links and frames that it refers to.
    pub fn places(&self) -> impl Iterator<Item = &str> {
        let (place, side) = match self {
            Self::Point { frame } => (Some(frame), None),
            Self::Surface { link, side, .. } => (Some(link), side.as_ref()),
            Self::Pulley { .. } => (None, None),
        };
        place.into_iter().chain(side).map(String::as_str)
    }
}

/// The kind of a surface that a tendon goes around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum TendonSurface {
    /// A sphere.
    Sphere,
    /// A cylinder of infinite length along z.
    Cylinder,
}

impl SpatialTendonDescription {
    /// A tendon along this path, without passive forces and bounds.
    ///
    /// ```
    /// use robot_dynamics::description::{SpatialTendonDescription, TendonPathElement};
    /// let ends = ["base", "tip"].map(|frame| TendonPathElement::Point { frame: frame.into() });
    /// let tendon = SpatialTendonDescription::new("cable", ends);
    /// assert_eq!(tendon.path.len(), 2);
    /// ```
    pub fn new(name: impl Into<String>, path: impl IntoIterator<Item = TendonPathElement>) -> Self {
        Self {
            name: name.into(),
            path: path.into_iter().collect(),
            passive: PassiveForces::default(),
            higher_terms: PolynomialStiffnessDamping::default(),
            spring_yield: 0.0,
            dead_band: 0.0,
            limits: Limits::default(),
            actuator_force_range: [f64::NEG_INFINITY, f64::INFINITY],
            softness: TendonSolverImpedance::default(),
        }
    }

    /// Checks that every branch of a path has two points, and that each surface is between two points.
    ///
    /// # Errors
    /// A text that says what is wrong.
    pub fn check_path(path: &[TendonPathElement]) -> Result<(), &'static str> {
        let is_pulley = |element: &TendonPathElement| matches!(element, TendonPathElement::Pulley { .. });
        let is_point = |element: &TendonPathElement| matches!(element, TendonPathElement::Point { .. });
        let after_first_pulley = if path.first().is_some_and(is_pulley) { &path[1..] } else { path };
        for branch in after_first_pulley.split(is_pulley) {
            if branch.iter().filter(|element| is_point(element)).count() < 2 {
                return Err("each branch of its path needs at least two points");
            }
            let ends = [branch.first(), branch.last()].into_iter().flatten().all(is_point);
            if !ends || !branch.windows(2).all(|pair| pair.iter().any(is_point)) {
                return Err("each surface of its path must be between two points");
            }
        }
        Ok(())
    }
}
