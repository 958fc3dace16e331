//! The velocity jump at an impact on a constraint: v⁺ = v⁻ + M⁻¹Aᵀι with A v⁺ = −e A v⁻. **(RBDA §11.7)**
//!
//! ι = −(1 + e) Λ⁻¹A v⁻ with Λ = A M⁻¹Aᵀ, by the factor of `row_factor`. Cost: O(K² nv + K nv depth). 0 ≤ e ≤
//! 1 loses energy, e = 1 conserves it. All rows take part at once; contacts that separate need the cone
//! problem.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_number;

use super::row_factor::{FactoredRows, MassFactor, RowFactor, factor_rows};
use super::{ConstraintError, ConstraintOptions, ConstraintSet};

/// The result of an impact.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactImpulse {
    /// v⁺, nv.
    pub velocity: DVector<f64>,
    /// The impulse of each row, K \[N·s, or N·m·s for a rotation\]; 0 in dependent rows.
    pub impulse: DVector<f64>,
    /// K⁻ − K⁺ \[J\]: never negative for 0 ≤ e ≤ 1.
    pub energy_lost: f64,
    /// The number of independent rows.
    pub rank: usize,
}

/// Returns v⁺ = v⁻ + M⁻¹Aᵀι with A v⁺ = −e A v⁻: ι = −(1+e) Λ⁻¹A v⁻, Λ = A M⁻¹Aᵀ. **(RBDA §11.7)**
///
/// e = 0 is a contact that holds, v⁺ = P v⁻; e = 1 conserves the kinetic energy.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, SpatialAxis, ConstraintOptions, ConstraintSet};
/// use robot_dynamics::constraints::contact_impulse;
/// use robot_dynamics::description::Pose;
/// use robot_dynamics::model::{Workspace, neutral};
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // A ball of 2 kg meets the floor at 3 m/s and half its speed comes back.
/// let floor = FrameConstraint::contact(ball, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let (set, options) = (ConstraintSet::new(&model, [("floor", floor.into())])?, ConstraintOptions::default());
/// let falling = [1.0, 0.0, -3.0, 0.0, 0.0, 0.0];
/// let w = &mut Workspace::new(&model);
/// let hit = contact_impulse(&model, w, &set, &options, &neutral(&model), &falling, 0.5)?;
/// assert!((hit.velocity[0] - 1.0).abs() < 1e-15 && (hit.velocity[2] - 1.5).abs() < 1e-15);
/// assert!((hit.energy_lost - 0.5 * 2.0 * (3.0 * 3.0 - 1.5 * 1.5)).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`] if M is singular, or an input, an option, a row or a result is not finite.
///
/// # Panics
/// If a slice has the wrong length, or the restitution e is outside \[0, 1\].
#[track_caller]
pub fn contact_impulse(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
    v: &[f64],
    restitution: f64,
) -> Result<ContactImpulse, ConstraintError> {
    Ok(SolvedImpact::new(model, workspace, (set, options), (q, v), restitution)?.impact)
}

/// An impact with the rows and the factors that gave it.
pub(super) struct SolvedImpact {
    pub impact: ContactImpulse,
    /// A.
    pub rows: DMatrix<f64>,
    pub mass: MassFactor,
    pub factor: RowFactor,
}

impl SolvedImpact {
    #[track_caller]
    pub(super) fn new(
        model: &Model,
        workspace: &mut Workspace,
        (set, options): (&ConstraintSet, &ConstraintOptions),
        (q, v): (&[f64], &[f64]),
        restitution: f64,
    ) -> Result<Self, ConstraintError> {
        check_number("the restitution", restitution)?;
        assert!((0.0..=1.0).contains(&restitution), "the restitution must lie in [0, 1], got {restitution}");
        let FactoredRows { rows, mass, factor } = factor_rows(model, workspace, (set, options), (q, v))?;
        let before = DVector::from_column_slice(v);
        let forbidden = &factor.forces * &before * (1.0 + restitution);
        let impulse = -factor.solve_triangle_transposed(&forbidden);
        let jump = factor.responses.tr_mul(&forbidden);
        // K⁻ − K⁺ = ½ (v⁻ − v⁺)ᵀM(v⁻ + v⁺), without the difference of two energies.
        let energy_lost = 0.5 * jump.dot(&(&mass.mass * (&before * 2.0 - &jump)));
        let velocity = if restitution == 0.0 { factor.project_velocity(&before) } else { before - jump };
        check_computed("v after the impact", velocity.as_slice())?;
        check_computed("the impulse", impulse.as_slice())?;
        check_number("the energy lost", energy_lost)?;
        let impact = ContactImpulse { velocity, impulse, energy_lost, rank: factor.rank() };
        Ok(Self { impact, rows: rows.matrix, mass, factor })
    }
}
