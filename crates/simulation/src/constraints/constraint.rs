//! One constraint of any kind.

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_number::{check_number, check_positive};

use super::ConstraintError;
use super::coupling::Coupling;
use super::frame_constraint::FrameConstraint;
use super::no_slip::NoSlip;
use super::polynomial_coupling::PolynomialCoupling;
use super::rolling::RollingDisc;
use crate::equality::relation::Relation;

/// One constraint on a tree.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Constraint {
    /// Two frames joined.
    FrameConstraint(FrameConstraint),
    /// Velocity components of a frame, along its own axes, that vanish.
    NoSlip(NoSlip),
    /// A disc that rolls on a plane.
    RollingDisc(RollingDisc),
    /// A linear relation between coordinates.
    Coupling(Coupling),
    /// A polynomial relation between the positions of two joints or the lengths of two tendons.
    PolynomialCoupling(PolynomialCoupling),
}

impl Constraint {
    /// The names of its rows, which are appended to its own name.
    pub(super) fn row_names(&self) -> Vec<&'static str> {
        match self {
            Self::FrameConstraint(closure) => closure.rows.iter().map(|row| row.name()).collect(),
            Self::NoSlip(no_slip) => no_slip.rows.iter().map(|row| row.name()).collect(),
            Self::RollingDisc(disc) => disc.rows.iter().map(|row| row.name()).collect(),
            Self::Coupling(_) => vec!["sum"],
            Self::PolynomialCoupling(_) => vec!["position"],
        }
    }

    /// Its rows, as functions of the configuration.
    pub(super) fn relation(&self, model: &Model) -> Relation {
        match self {
            Self::FrameConstraint(closure) => closure.relation(model),
            Self::NoSlip(no_slip) => no_slip.relation(model),
            Self::RollingDisc(disc) => disc.relation(model),
            Self::Coupling(coupling) => coupling.relation(model),
            Self::PolynomialCoupling(coupling) => coupling.relation(),
        }
    }

    /// The frames that it joins.
    pub(super) fn frames(&self) -> Vec<FrameId> {
        match self {
            Self::FrameConstraint(closure) => closure.frames().collect(),
            Self::NoSlip(no_slip) => vec![no_slip.frame],
            Self::RollingDisc(disc) => vec![disc.frame],
            Self::Coupling(_) | Self::PolynomialCoupling(_) => Vec::new(),
        }
    }

    /// Checks the numbers in its geometry.
    pub(super) fn check_numbers(&self) -> Result<(), ConstraintError> {
        match self {
            Self::FrameConstraint(closure) => {
                for number in closure.numbers() {
                    check_number("a number of an anchor's pose", number)?;
                }
            }
            Self::RollingDisc(disc) => {
                check_positive("a disc's radius", disc.radius, "m")?;
                let axle = disc.axle.iter().map(|x| x * x).sum::<f64>().sqrt();
                check_positive("the length of an axle", axle, "m")?;
                check_number("a plane's offset", disc.plane.offset())?;
            }
            Self::NoSlip(_) | Self::Coupling(_) | Self::PolynomialCoupling(_) => {}
        }
        Ok(())
    }
}

impl From<FrameConstraint> for Constraint {
    fn from(closure: FrameConstraint) -> Self {
        Self::FrameConstraint(closure)
    }
}

impl From<NoSlip> for Constraint {
    fn from(no_slip: NoSlip) -> Self {
        Self::NoSlip(no_slip)
    }
}

impl From<RollingDisc> for Constraint {
    fn from(disc: RollingDisc) -> Self {
        Self::RollingDisc(disc)
    }
}

impl From<Coupling> for Constraint {
    fn from(coupling: Coupling) -> Self {
        Self::Coupling(coupling)
    }
}

impl From<PolynomialCoupling> for Constraint {
    fn from(coupling: PolynomialCoupling) -> Self {
        Self::PolynomialCoupling(coupling)
    }
}
