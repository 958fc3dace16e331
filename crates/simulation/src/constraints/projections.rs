//! The projections that eliminate the constraint force from the equation of motion. **(PRM 10.18–10.19)**
//!
//! P_u = 1 − Aᵀ(A M⁻¹Aᵀ)⁻¹A M⁻¹ has P_u Aᵀ = 0, and P = P_uᵀ has A P = 0. Cost: O(K nv²). Both are dense
//! nv×nv matrices; steps use the factor of `row_factor` instead.

use nalgebra::DMatrix;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::check_computed;

use super::row_factor::{FactoredRows, factor_rows};
use super::{ConstraintError, ConstraintOptions, ConstraintSet};

/// P_u on forces and P on velocities, both nv×nv of rank nv − rank A.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TreeProjections {
    /// P_u = 1 − Aᵀ(AM⁻¹Aᵀ)⁻¹AM⁻¹: P_u Aᵀ = 0. **(PRM 10.18)**
    pub force: DMatrix<f64>,
    /// P = M⁻¹P_uM = P_uᵀ: A P = 0. **(PRM 10.19)**
    pub velocity: DMatrix<f64>,
    /// The rank of A.
    pub rank: usize,
}

/// Returns P and P_u at q. Every velocity splits into P v, which A allows, and (1−P) v; both are orthogonal
/// in M.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintOptions, ConstraintSet};
/// use robot_dynamics::constraints::constraint_projections;
/// use robot_dynamics::model::{Workspace, neutral};
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(ball, [0.0; 3]).into())])?;
/// let (w, options, q) = (&mut Workspace::new(&model), ConstraintOptions::default(), neutral(&model));
/// let p = constraint_projections(&model, w, &set, &options, &q)?;
/// assert_eq!(p.rank, 3);
/// assert!((&p.velocity * &p.velocity - &p.velocity).amax() < 1e-14); // twice is once
/// let rows = set.rows(&model, w, &q, &[0.0; 6]).matrix;
/// assert!((rows * &p.velocity).amax() < 1e-14); // A P = 0
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`] if M is singular, or q, an option, a row or a result is not finite.
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn constraint_projections(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
) -> Result<TreeProjections, ConstraintError> {
    let nv = model.nv();
    let FactoredRows { factor, .. } = factor_rows(model, workspace, (set, options), (q, &vec![0.0; nv]))?;
    // With A = T E the middle factor cancels: P_u = 1 − Eᵀ E M⁻¹.
    let force = DMatrix::identity(nv, nv) - factor.forces.tr_mul(&factor.responses);
    check_computed("the projection", force.as_slice())?;
    Ok(TreeProjections { velocity: force.transpose(), force, rank: factor.rank() })
}
