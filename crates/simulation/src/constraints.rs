//! Constraints on any tree: closed loops, contacts, rolling, coupled coordinates.
//!
//! A constraint consists of rows A(q) v = 0 with their bias Ȧv, so that A a + Ȧv is the rate of A v. If it
//! comes from a position, it also has an error φ(q), whose rate is A v on the constraint and off it. The
//! constraint force Aᵀλ does no work on an allowed velocity: M a + C v + g = τ + Aᵀλ, A a + Ȧv = 0 **(PRM
//! 10.16)**.
//!
//! | what holds | kind | rows | φ |
//! | --- | --- | --- | --- |
//! | two frames, or a frame and the world, are joined | [`FrameConstraint`] | 1 to 6 of x, y, z, rx, ry, rz | yes |
//! | a frame's own velocity components vanish: skate, blade, wheel | [`NoSlip`] | 1 to 6 | no |
//! | a disc rolls on a plane | [`RollingDisc`] | forward, side, normal | normal only |
//! | Σ cᵢ vᵢ = 0: gears, levers, locked joints | [`Coupling`] | 1 | for plain coordinates |
//! | y = p(x) between two joints | [`PolynomialCoupling`] | 1 | yes |

mod closure;
mod coupling;
mod drift;
mod error;
mod forward;
mod frame_motion;
mod implicit;
mod impulse;
mod inverse;
mod loop_closure;
mod no_slip;
mod options;
mod polynomial_coupling;
mod project;
mod projections;
mod rolling;
mod row_factor;
mod run;
mod set;
mod step;
mod support;
mod variational;

pub use closure::{Anchor, FrameConstraint, SpatialAxis};
pub use coupling::Coupling;
pub use drift::{ConstraintDrift, constraint_drift};
pub use error::{ConstraintError, NamedDependentRow};
pub use forward::{ConstrainedMotion, constrained_forward_dynamics};
pub use impulse::{ContactImpulse, contact_impulse};
pub use inverse::{ConstrainedTorque, constrained_inverse_dynamics};
pub use loop_closure::LoopClosure;
pub use no_slip::NoSlip;
pub use options::{Baumgarte, ConstraintOptions, RedundantRows};
pub use polynomial_coupling::PolynomialCoupling;
pub use project::{PositionProjection, project_position, project_velocity};
pub use projections::{TreeProjections, constraint_projections};
pub use rolling::{Plane, RollingDisc, RollingRow};
pub use run::{ConstrainedStepper, ConstraintRecord};
pub use set::{ConstraintRows, ConstraintSet};
pub use step::{ConstrainedStepReport, DriftCorrection, constrained_step};
pub use support::{ContactSupport, SupportProblem, SupportedTorque, supported_inverse_dynamics};

use robot_dynamics_core::{Model, Workspace};
use set::RowsAt;

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
    fn count(&self) -> usize {
        match self {
            Self::FrameConstraint(closure) => closure.rows.len(),
            Self::NoSlip(no_slip) => no_slip.rows.len(),
            Self::RollingDisc(disc) => disc.rows.len(),
            Self::Coupling(_) | Self::PolynomialCoupling(_) => 1,
        }
    }

    /// The names of its rows, which are appended to its own name.
    fn row_names(&self) -> Vec<&'static str> {
        match self {
            Self::FrameConstraint(closure) => closure.rows.iter().map(|row| row.name()).collect(),
            Self::NoSlip(no_slip) => no_slip.rows.iter().map(|row| row.name()).collect(),
            Self::RollingDisc(disc) => disc.rows.iter().map(|row| row.name()).collect(),
            Self::Coupling(_) => vec!["sum"],
            Self::PolynomialCoupling(_) => vec!["position"],
        }
    }

    fn write(&self, model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64], rows: &mut RowsAt<'_>) {
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
