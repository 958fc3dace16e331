//! One constraint of any kind.

use robot_dynamics_core::{Model, Workspace};

use super::coupling::Coupling;
use super::frame_constraint::FrameConstraint;
use super::no_slip::NoSlip;
use super::polynomial_coupling::PolynomialCoupling;
use super::rolling::RollingDisc;
use super::rows::RowsAt;

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
    /// A polynomial relation between the positions of two joints.
    PolynomialCoupling(PolynomialCoupling),
}

impl Constraint {
    /// The number of rows.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::FrameConstraint(closure) => closure.rows.len(),
            Self::NoSlip(no_slip) => no_slip.rows.len(),
            Self::RollingDisc(disc) => disc.rows.len(),
            Self::Coupling(_) | Self::PolynomialCoupling(_) => 1,
        }
    }

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

    pub(super) fn write(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        rows: &mut RowsAt<'_>,
    ) {
        match self {
            Self::FrameConstraint(closure) => closure.write(model, workspace, q, v, rows),
            Self::NoSlip(no_slip) => no_slip.write(model, workspace, q, v, rows),
            Self::RollingDisc(disc) => disc.write(model, workspace, q, v, rows),
            Self::Coupling(coupling) => coupling.write(model, q, rows),
            Self::PolynomialCoupling(coupling) => coupling.write(model, q, v, rows),
        }
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
