//! Inverse dynamics with unilateral frictional contacts: τ + Σ Jᵀp + Aᵀλ = M a + C v + g, |p_t| ≤ μ p_n.
//!
//! The result has the least |τ|² + ρ(|p|² + |λ|²). The unknown is the multiplier y of the equation. It
//! minimizes ½yᵀWy + (M a + C v + g)ᵀy + Σ ψ(Jy), by the Newton method of `contact::cone_problem`. Cost: a
//! factor of a matrix of size nv for each Newton step.
//!
//! A motion that the supports cannot cause is not an error: the residual says how much is missing.

use nalgebra::{DVector, Matrix3, Vector3};
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Workspace, frame_jacobian, frame_pose, inverse_dynamics,
};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::{InvalidInput, check_finite, check_positive};

use super::{ConstraintError, ConstraintSet};
use crate::contact::{ConeProblem, Set, axes};

/// A contact point that supports a robot, with Coulomb's friction: its force satisfies |p_t| ≤ μ p_n.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "Support")]
pub struct ContactSupport {
    /// The frame that the point is fixed to.
    pub frame: FrameId,
    /// The point in that frame \[m\].
    pub point: [f64; 3],
    /// The direction in which the support can push the robot, in world axes, of any length.
    pub normal: [f64; 3],
    /// μ, 0 or more.
    pub friction: f64,
}

impl ContactSupport {
    /// A support at a point of a frame, with its normal and μ.
    pub const fn new(frame: FrameId, point: [f64; 3], normal: [f64; 3], friction: f64) -> Self {
        Self { frame, point, normal, friction }
    }
}

/// The supports of a robot, and the choice of their forces where the motion does not determine them.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
#[doc(alias = "Supports")]
pub struct SupportProblem<'a> {
    /// The support points.
    pub points: &'a [ContactSupport],
    /// Closed loops and other constraints with forces of either sign.
    pub constraints: Option<&'a ConstraintSet>,
    /// ρ in |τ|² + ρ|λ|² \[m²\]: a large value gives small forces, a small value small torques.
    pub force_weight: f64,
}

impl<'a> SupportProblem<'a> {
    /// The default ρ \[m²\].
    pub const DEFAULT_FORCE_WEIGHT: f64 = 1e-3;

    /// These points alone, with the default ρ of 1e-3 m².
    pub const fn new(points: &'a [ContactSupport]) -> Self {
        Self { points, constraints: None, force_weight: Self::DEFAULT_FORCE_WEIGHT }
    }

    /// Adds closed loops.
    pub const fn with_constraints(self, constraints: &'a ConstraintSet) -> Self {
        Self { constraints: Some(constraints), ..self }
    }

    /// Sets ρ \[m²\].
    pub const fn with_force_weight(self, force_weight: f64) -> Self {
        Self { force_weight, ..self }
    }
}

/// The torques and forces of a motion on supports.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SupportedTorque {
    /// τ, nv: zero on coordinates without a motor \[N·m or N\].
    pub tau: DVector<f64>,
    /// The force on the robot at each support, in world axes \[N\].
    pub forces: Vec<[f64; 3]>,
    /// λ of the constraints.
    pub multipliers: DVector<f64>,
    /// M a + C v + g − τ − Aᵀλ, nv. It exceeds rounding if the supports cannot cause this motion, for example
    /// if they would have to pull the robot down. It is then the smallest that forces in the cones allow.
    pub missing: DVector<f64>,
}

/// Returns τ, and forces in their friction cones, with τ + Σ Jᵀp + Aᵀλ = M a + C v + g. τ = 0 on coordinates
/// without a motor.
///
/// The result has the least |τ|² + ρ(|p|² + |λ|²), which makes it unique. `actuated` has nv entries. The
/// supports should be at rest in this motion. This is not checked, as the torque is that of the tree in any
/// case. Unlike in [`constrained_inverse_dynamics`](crate::constrained_inverse_dynamics), contacts cannot
/// pull, as a controller of a legged robot needs.
///
/// The unknown is the multiplier y of the equation: min over y of ½yᵀWy + (M a + C v + g)ᵀy + Σ ψ(Jy). W is 1
/// on motors and 0 elsewhere. The problem is solved by Newton's method, with the proximal method for the
/// zeros of W.
///
/// ```
/// use robot_dynamics::constraints::{ContactSupport, SupportProblem, supported_inverse_dynamics};
/// use robot_dynamics::model::{Workspace, neutral};
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("table");
/// # robot.base = Base::Floating;
/// # let top = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.1, 0.1, 0.1))?;
/// # robot.links.push(LinkDescription::new("top", top));
/// # let model = Model::new(robot)?;
/// # let top = model.frame_named("top")?;
/// // A table of 1 kg on four feet, and its acceleration.
/// let foot = |x, y| ContactSupport::new(top, [x, y, -0.5], [0.0, 0.0, 1.0], 0.8);
/// let feet = [foot(0.4, 0.4), foot(-0.4, 0.4), foot(-0.4, -0.4), foot(0.4, -0.4)];
/// let (w, q, rest) = (&mut Workspace::new(&model), neutral(&model), [0.0; 6]);
/// let stands = supported_inverse_dynamics(&model, w, &SupportProblem::new(&feet), &q, &rest, &rest, &[false; 6])?;
/// assert!(stands.forces.iter().all(|force| (force[2] - 9.81 / 4.0).abs() < 1e-9));
/// // It cannot fall faster than things fall: nothing holds it down.
/// let down = [0.0, 0.0, -2.0 * 9.81, 0.0, 0.0, 0.0];
/// let falls = supported_inverse_dynamics(&model, w, &SupportProblem::new(&feet), &q, &rest, &down, &[false; 6])?;
/// assert!((falls.missing[2] + 9.81).abs() < 1e-9 && falls.forces.iter().all(|force| force[2].abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`]: q, v, a, a number of a support, a row or a result is not finite, or a number
/// is out of its range.
///
/// # Panics
/// If a slice has the wrong length, or a frame or the constraints belong to another robot.
#[track_caller]
pub fn supported_inverse_dynamics(
    model: &Model,
    workspace: &mut Workspace,
    supports: &SupportProblem<'_>,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    actuated: &[bool],
) -> Result<SupportedTorque, ConstraintError> {
    workspace.check_inputs(model, q);
    let nv = model.nv();
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), nv);
    check_length("a", a.len(), nv);
    check_length("the list of actuated coordinates", actuated.len(), nv);
    for (quantity, values) in [("q", q), ("v", v), ("a", a)] {
        check_finite(quantity, values)?;
    }
    check_supports(supports)?;
    let mut force = DVector::zeros(nv);
    inverse_dynamics(model, workspace, q, v, a, force.as_mut_slice());
    check_computed("M a + C v + g", force.as_slice())?;

    let mut problem = ConeProblem::new(nv);
    let bases: Vec<_> =
        supports.points.iter().map(|support| axes(Vector3::from(support.normal).normalize())).collect();
    for (support, basis) in supports.points.iter().zip(&bases) {
        add_support(&mut problem, model, workspace, q, support, basis);
    }
    if let Some(set) = supports.constraints {
        let rows = set.rows(model, workspace, q, v);
        rows.check(set.row_names())?;
        for row in rows.matrix.row_iter() {
            problem.push(Set::Interval(f64::NEG_INFINITY, f64::INFINITY), 1, 0..nv);
            problem.last().1.iter_mut().zip(row.iter()).for_each(|(entry, x)| *entry = *x);
        }
    }
    problem.soften_all(supports.force_weight);
    let missing = solve(&mut problem, &force, actuated, supports.force_weight);
    let p = &problem.multiplier;
    let (points, loops) = p.split_at(3 * supports.points.len());
    let forces: Vec<[f64; 3]> = points
        .chunks_exact(3)
        .zip(&bases)
        .map(|(p, [n, s, t])| (n * p[0] + s * p[1] + t * p[2]).into())
        .collect();
    let mut carried = vec![0.0; nv];
    problem.add_forces(p, &mut carried);
    let tau = DVector::from_fn(nv, |k, _| if actuated[k] { force[k] - carried[k] } else { 0.0 });
    check_computed("the forces", p)?;
    check_computed("the torque", tau.as_slice())?;
    Ok(SupportedTorque { tau, forces, multipliers: DVector::from_row_slice(loops), missing })
}

/// Returns an error if a number of a support is invalid.
fn check_supports(supports: &SupportProblem<'_>) -> Result<(), InvalidInput> {
    for (index, ContactSupport { point, normal, friction, .. }) in supports.points.iter().enumerate() {
        let length = Vector3::from(*normal).norm();
        let (part, problem) = if point.iter().any(|x| !x.is_finite()) {
            ("point", "is not finite")
        } else if !(length > 0.0 && length.is_finite()) {
            ("normal", "has no direction")
        } else if !(*friction >= 0.0 && friction.is_finite()) {
            ("friction", "must be finite and not negative")
        } else {
            continue;
        };
        return Err(InvalidInput::unmet(format!("support {index}: its {part}"), problem));
    }
    check_positive("the weight of the forces", supports.force_weight, "m²")
}

/// Adds the rows of a support: the velocity of its point along the normal and tangential to it.
fn add_support(
    problem: &mut ConeProblem,
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    support: &ContactSupport,
    basis: &[Vector3<f64>; 3],
) {
    let nv = model.nv();
    let mut jacobian = vec![0.0; 6 * nv];
    frame_jacobian(model, workspace, q, support.frame, ReferenceFrame::LocalWorldAligned, &mut jacobian);
    let [x, y, z] = frame_pose(model, workspace, q, support.frame).rotation;
    let lever = Matrix3::from_rows(&[x.into(), y.into(), z.into()]) * Vector3::from(support.point);
    problem.push(Set::Cone(support.friction), 3, 0..nv);
    let (_, entries) = problem.last();
    for k in 0..nv {
        let along = |row: usize| Vector3::from_fn(|i, _| jacobian[(row + i) * nv + k]);
        let velocity = along(0) + along(3).cross(&lever);
        for (row, axis) in basis.iter().enumerate() {
            entries[row * nv + k] = axis.dot(&velocity);
        }
    }
}

/// The most rounds of the proximal method; a feasible motion takes two or three.
const MOST_ROUNDS: usize = 50;

/// Solves for p into `problem.multiplier`. Returns the residual force.
///
/// W is ε on coordinates without a motor, and f is f − εy of the round before. When y has converged, Jᵀp = f
/// holds there. If no p in the cones satisfies this, y grows without bound, and p converges to the least
/// residual. **(Rockafellar 1976)**
fn solve(problem: &mut ConeProblem, force: &DVector<f64>, actuated: &[bool], weight: f64) -> DVector<f64> {
    let nv = force.len();
    // ε is a small fraction of the curvature from the supports, squares of levers of about a metre over ρ,
    // and exceeds rounding.
    let mut epsilon = 1e-6 / weight;
    let least = 1e-12 / weight;
    let dof_parent: Vec<usize> = (0..nv).map(|k| k.checked_sub(1).unwrap_or(sparse::NONE)).collect();
    let mut matrix = vec![0.0; nv * nv];
    let scale = force.amax().max(f64::MIN_POSITIVE);
    let (mut missing, mut before) = (force.clone(), f64::INFINITY);
    for round in 0..MOST_ROUNDS {
        for k in 0..nv {
            matrix[k * nv + k] = if actuated[k] { 1.0 } else { epsilon };
            problem.force[k] = force[k] - if actuated[k] { 0.0 } else { epsilon * problem.x[k] };
        }
        problem.multiplier.fill(0.0);
        problem.set_matrix(&matrix, &dof_parent);
        if !problem.solve_soft(round > 0) {
            break;
        }
        let mut carried = vec![0.0; nv];
        problem.add_forces(&problem.multiplier, &mut carried);
        for k in (0..nv).filter(|k| !actuated[*k]) {
            missing[k] = force[k] - carried[k];
        }
        (0..nv).filter(|k| actuated[*k]).for_each(|k| missing[k] = 0.0);
        let left = missing.amax();
        // Converged, or as near as possible.
        if left <= 1e-12 * scale || left >= before * (1.0 - 1e-9) {
            break;
        }
        // If forces are on the borders of their cones, y converges slowly: decrease ε.
        (before, epsilon) = (left, (0.1 * epsilon).max(least));
    }
    missing
}
