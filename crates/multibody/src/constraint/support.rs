//! Inverse dynamics of a robot that stands: what it stands on pushes, and never pulls.

use nalgebra::{DVector, Matrix3, Vector3};

use super::error::{check_entries, check_number};
use super::{ConstrainedMotionError, ConstraintSet};
use crate::contact::{ConeProblem, Set, axes};
use crate::factor::sparse;
use crate::model::length::check_length;
use crate::{FrameId, Model, Workspace, frame_jacobian_world_aligned, frame_pose, inverse_dynamics};

/// A point on which a robot stands, with Coulomb's friction: the force there lies in |p_t| ≤ μ p_n.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Support {
    /// Which moves with the point.
    pub frame: FrameId,
    /// Where, in that frame \[m\].
    pub point: [f64; 3],
    /// Which way the robot may be pushed, along the world's axes; of any length.
    pub normal: [f64; 3],
    /// μ, 0 or more.
    pub friction: f64,
}

impl Support {
    /// At a point of a frame, pushed along a normal, with μ.
    pub const fn new(frame: FrameId, point: [f64; 3], normal: [f64; 3], friction: f64) -> Self {
        Self { frame, point, normal, friction }
    }
}

/// All that carries a robot, and how its forces are chosen where the motion leaves them open.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Supports<'a> {
    /// The points that it stands on.
    pub points: &'a [Support],
    /// Closed loops and what else holds it, pulling as well as pushing.
    pub constraints: Option<&'a ConstraintSet>,
    /// ρ in |τ|² + ρ|λ|² \[m²\]: large for small forces, small for small torques.
    pub force_weight: f64,
}

impl<'a> Supports<'a> {
    /// These points alone, with ρ = 1e-3 m².
    pub const fn new(points: &'a [Support]) -> Self {
        Self { points, constraints: None, force_weight: 1e-3 }
    }

    /// With closed loops.
    pub const fn with_constraints(self, constraints: &'a ConstraintSet) -> Self {
        Self { constraints: Some(constraints), ..self }
    }

    /// With this ρ \[m²\].
    pub const fn with_force_weight(self, force_weight: f64) -> Self {
        Self { force_weight, ..self }
    }
}

/// Torques and forces of a motion on supports.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SupportedTorque {
    /// τ, nv: zero where there is no motor \[N·m or N\].
    pub tau: DVector<f64>,
    /// The force on the robot at each support, along the world's axes \[N\].
    pub forces: Vec<[f64; 3]>,
    /// λ of the constraints.
    pub multipliers: DVector<f64>,
    /// M a + C v + g − τ − Aᵀλ, nv: more than rounding where the supports cannot carry this motion, as when the robot would have to be
    /// pulled down. What is left is then as small as forces in the cones can make it.
    pub missing: DVector<f64>,
}

/// τ, and forces in their cones of friction, with τ + Σ Jᵀp + Aᵀλ = M a + C v + g and τ = 0 on coordinates without a motor.
///
/// Of all such forces those with the least |τ|² + ρ(|p|² + |λ|²), which are unique. `actuated` has nv entries. The supports should rest
/// under this motion; it is not checked, as the torque is that of the tree in any case. Beside
/// [`constrained_inverse_dynamics`](crate::constrained_inverse_dynamics), whose contacts may pull, this is what a legged robot's
/// controller needs.
///
/// With the multiplier y of the equation as the unknown, the problem is min over y of ½yᵀWy + (M a + C v + g)ᵀy + Σ ψ(Jy), W = 1
/// on motors and 0 elsewhere: Newton's method on it, with the proximal method for the zeros of W.
///
/// ```
/// use multibody::{Support, Supports, Workspace, neutral, supported_inverse_dynamics};
/// # use multibody::*;
/// # let mut robot = RobotDescription::new("table");
/// # robot.base = Base::Floating;
/// # let top = dynamics::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.1, 0.1, 0.1))?;
/// # robot.links.push(LinkDescription::new("top", top));
/// # let model = Model::new(robot)?;
/// # let top = model.frame_named("top")?;
/// // A table of 1 kg on four feet, and its acceleration.
/// let foot = |x, y| Support::new(top, [x, y, -0.5], [0.0, 0.0, 1.0], 0.8);
/// let feet = [foot(0.4, 0.4), foot(-0.4, 0.4), foot(-0.4, -0.4), foot(0.4, -0.4)];
/// let (w, q, rest) = (&mut Workspace::new(&model), neutral(&model), [0.0; 6]);
/// let stands = supported_inverse_dynamics(&model, w, &Supports::new(&feet), &q, &rest, &rest, &[false; 6])?;
/// assert!(stands.forces.iter().all(|force| (force[2] - 9.81 / 4.0).abs() < 1e-9));
/// // It cannot fall faster than things fall: nothing holds it down.
/// let down = [0.0, 0.0, -2.0 * 9.81, 0.0, 0.0, 0.0];
/// let falls = supported_inverse_dynamics(&model, w, &Supports::new(&feet), &q, &rest, &down, &[false; 6])?;
/// assert!((falls.missing[2] + 9.81).abs() < 1e-9 && falls.forces.iter().all(|force| force[2].abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstrainedMotionError`]: q, v, a, a support's numbers, a row or a result are not finite, or a number is out of its range.
///
/// # Panics
/// If a slice has the wrong length, or a frame or the constraints are another robot's.
#[track_caller]
pub fn supported_inverse_dynamics(
    model: &Model,
    workspace: &mut Workspace,
    supports: &Supports<'_>,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    actuated: &[bool],
) -> Result<SupportedTorque, ConstrainedMotionError> {
    workspace.admit(model, q);
    let nv = model.nv();
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), nv);
    check_length("a", a.len(), nv);
    check_length("the list of actuated coordinates", actuated.len(), nv);
    for (quantity, values) in [("q", q), ("v", v), ("a", a)] {
        check_entries(quantity, values)?;
    }
    check_supports(supports)?;
    let mut force = DVector::zeros(nv);
    inverse_dynamics(model, workspace, q, v, a, force.as_mut_slice());
    check_entries("M a + C v + g", force.as_slice())?;

    let mut problem = ConeProblem::new(nv);
    let bases: Vec<_> =
        supports.points.iter().map(|support| axes(Vector3::from(support.normal).normalize())).collect();
    for (support, basis) in supports.points.iter().zip(&bases) {
        add_support(&mut problem, model, workspace, q, support, basis);
    }
    if let Some(set) = supports.constraints {
        let rows = set.rows(model, workspace, q, v);
        rows.check(set)?;
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
    check_entries("the forces", p)?;
    check_entries("the torque", tau.as_slice())?;
    Ok(SupportedTorque { tau, forces, multipliers: DVector::from_row_slice(loops), missing })
}

/// Refuses a support whose numbers say nothing.
fn check_supports(supports: &Supports<'_>) -> Result<(), ConstrainedMotionError> {
    for (index, Support { point, normal, friction, .. }) in supports.points.iter().enumerate() {
        let length = Vector3::from(*normal).norm();
        let problem = if point.iter().any(|x| !x.is_finite()) {
            "its point is not finite"
        } else if !(length > 0.0 && length.is_finite()) {
            "its normal has no direction"
        } else if !(*friction >= 0.0 && friction.is_finite()) {
            "its friction is no finite number from 0 on"
        } else {
            continue;
        };
        return Err(ConstrainedMotionError::BadSupport { index, problem });
    }
    let weight = supports.force_weight;
    check_number("the weight of the forces", weight)?;
    if weight <= 0.0 {
        return Err(ConstrainedMotionError::BadSupportWeight { weight });
    }
    Ok(())
}

/// The rows of a support: the velocity of its point along the normal and across it.
fn add_support(
    problem: &mut ConeProblem,
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    support: &Support,
    basis: &[Vector3<f64>; 3],
) {
    let nv = model.nv();
    let mut jacobian = vec![0.0; 6 * nv];
    frame_jacobian_world_aligned(model, workspace, q, support.frame, &mut jacobian);
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

/// Rounds of the proximal method: with what the supports can carry, two or three.
const MOST_ROUNDS: usize = 50;

/// Solves for p, to `problem.multiplier`; what is left of the force.
///
/// W is ε on coordinates without a motor, and f is f − εy of the round before: where y stays, Jᵀp = f holds there. Where no p in the cones
/// has it, y grows without end, and p comes to where the least is missing. **(Rockafellar 1976)**
fn solve(problem: &mut ConeProblem, force: &DVector<f64>, actuated: &[bool], weight: f64) -> DVector<f64> {
    let nv = force.len();
    // Of the curvature that the supports give, squares of levers of about a metre over ρ: little, and more than rounding.
    let mut epsilon = 1e-6 / weight;
    let least = 1e-12 / weight;
    let carrier: Vec<usize> = (0..nv).map(|k| k.checked_sub(1).unwrap_or(sparse::NONE)).collect();
    let mut matrix = vec![0.0; nv * nv];
    let scale = force.amax().max(f64::MIN_POSITIVE);
    let (mut missing, mut before) = (force.clone(), f64::INFINITY);
    for round in 0..MOST_ROUNDS {
        for k in 0..nv {
            matrix[k * nv + k] = if actuated[k] { 1.0 } else { epsilon };
            problem.force[k] = force[k] - if actuated[k] { 0.0 } else { epsilon * problem.x[k] };
        }
        problem.multiplier.fill(0.0);
        problem.take(&matrix, &carrier);
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
        // Done, or as near as can be.
        if left <= 1e-12 * scale || left >= before * (1.0 - 1e-9) {
            break;
        }
        // Where forces are on the borders of their cones y moves slowly: ever more freely, then.
        (before, epsilon) = (left, (0.1 * epsilon).max(least));
    }
    missing
}
