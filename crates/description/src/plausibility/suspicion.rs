//! A suspicious statistic and its likely cause.

use core::fmt;

#[cfg(feature = "serde")]
use serde::{Serialize, Serializer};

use super::Cause;

/// A statistic outside the range of correct robots.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[non_exhaustive]
pub struct Suspicion {
    /// The statistic.
    pub quantity: Quantity,
    /// The places where it is out of range, the worst first, as in `link "hand"`.
    pub places: Vec<String>,
    /// The number of places in which the file has this quantity.
    pub of: usize,
    /// The worst value; if it is out of range in more than half of the places, the median.
    #[cfg_attr(feature = "serde", serde(serialize_with = "finite_or_null"))]
    pub found: f64,
    /// The expected range; `None` for no bound.
    pub expected: (Option<f64>, Option<f64>),
    /// The likely cause.
    pub cause: Cause,
}

impl Suspicion {
    /// Whether more than half of the places are suspicious: an error of the file rather than of a link.
    pub fn is_general(&self) -> bool {
        2 * self.places.len() > self.of && self.of > 1
    }
}

impl fmt::Display for Suspicion {
    /// Formats as one sentence: the quantity, the place, the deviation, the cause.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { quantity, places, of, found, expected, cause } = self;
        let first = places.first().map_or("", String::as_str);
        write!(f, "{quantity} is {found:.2e}, expected {}: {first}", range(*expected))?;
        if *of > 1 {
            write!(f, " ({} of {of})", places.len())?;
        }
        write!(f, "; {cause}")
    }
}

/// A range in words.
fn range(expected: (Option<f64>, Option<f64>)) -> String {
    match expected {
        (Some(low), Some(high)) => format!("{low} to {high}"),
        (Some(low), None) => format!("at least {low}"),
        (None, Some(high)) => format!("at most {high}"),
        (None, None) => "anything".into(),
    }
}

/// The statistics that can be out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Quantity {
    /// m/V of the solid ellipsoid that has the link's mass and moments \[kg/m³\].
    EllipsoidDensity,
    /// √(I₃/m) over the link's extent.
    GyrationOverExtent,
    /// √(I₃/m) over the robot's size.
    GyrationOverSize,
    /// Distance of the centre of mass from the link's frame, over the robot's size.
    CenterOfMassOverSize,
    /// m over the cube of the link's extent \[kg/m³\].
    MassOverCubedExtent,
    /// m over the volume of the primitive shapes of the link \[kg/m³\].
    ShapeDensity,
    /// Largest roll, pitch or yaw, as written \[rad\].
    WrittenAngle,
    /// Largest bound of a rotation \[rad\].
    AngleLimit,
    /// Largest speed of a rotation \[rad/s\].
    TurnSpeedLimit,
    /// Largest bound of a slide, over the robot's size.
    SlideOverSize,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::EllipsoidDensity => "density of the ellipsoid with a link's mass and moments [kg/m³]",
            Self::GyrationOverExtent => "radius of gyration over the link's extent",
            Self::GyrationOverSize => "radius of gyration over the robot's size",
            Self::CenterOfMassOverSize => "distance of a centre of mass over the robot's size",
            Self::MassOverCubedExtent => "mass over the cube of the link's extent [kg/m³]",
            Self::ShapeDensity => "mass over the volume of the link's shapes [kg/m³]",
            Self::WrittenAngle => "roll, pitch or yaw as written [rad]",
            Self::AngleLimit => "position limit of a turn [rad]",
            Self::TurnSpeedLimit => "speed limit of a turn [rad/s]",
            Self::SlideOverSize => "travel of a slide over the robot's size",
        })
    }
}

/// JSON cannot represent numbers that are not finite.
#[cfg(feature = "serde")]
#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn finite_or_null<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if x.is_finite() { serializer.serialize_f64(*x) } else { serializer.serialize_none() }
}
