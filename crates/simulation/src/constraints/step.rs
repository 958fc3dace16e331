//! A time step on the constraint: a step of an explicit or a variational row, and the correction of its
//! drift.
//!
//! Explicit rows integrate a of `forward` and break φ = 0 by the order of the row. The correction moves q
//! onto φ = 0 and v onto A v = 0 (`project`); it changes the energy. Variational rows hold both by their own
//! equations (`variational`). Cost: that of the row's stages, each with the factor of `row_factor`.

use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{Stage, StepScheme, check_computed};
use robot_dynamics_number::{check_finite, check_number, check_positive};

use super::variational::variational_step;
use super::{
    ConstraintDrift, ConstraintError, ConstraintOptions, ConstraintSet, constrained_forward_dynamics,
    project_position, project_velocity,
};
use crate::motion::integrate::explicit::{StageSystem, explicit_step};
use crate::motion::integrate::net_force;
use crate::motion::integrate::stage_memory::StageMemory;
use crate::{StepForces, StepWorkspace, constraint_drift};

/// The correction of the drift after each step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriftCorrection {
    /// No correction; with [`Baumgarte`](super::Baumgarte) in the options, the acceleration corrects the
    /// drift.
    None,
    /// v ← P v.
    Velocity,
    /// q onto φ = 0 to this tolerance \[m or rad\], then v ← P v.
    Position {
        /// The largest |φ| allowed.
        tolerance: f64,
    },
}

impl Default for DriftCorrection {
    /// Corrects the position to 1e-10.
    fn default() -> Self {
        Self::Position { tolerance: 1e-10 }
    }
}

/// The constraints of a step, and how the step satisfies them.
#[derive(Clone, Copy, Debug)]
pub struct StepConstraints<'a> {
    /// The constraints.
    pub set: &'a ConstraintSet,
    /// The method of the step, and the treatment of dependent rows.
    pub options: &'a ConstraintOptions,
    /// The correction of the drift after an explicit step.
    pub correction: DriftCorrection,
}

/// The result of a constrained step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedStepReport {
    /// φ and A v at the end of the step before the correction: the drift of this step. A variational method
    /// changes the momentum along Aᵀ at the end; this is A v before that.
    pub drift: ConstraintDrift,
    /// φ and A v after the correction.
    pub corrected: ConstraintDrift,
    /// The kinetic energy that v ← P v took out \[J\]; 0 for a variational method, where it is not a
    /// correction.
    pub energy_removed: f64,
    /// The rank of A at the start of the step.
    pub rank: usize,
}

/// Takes one step of the constrained motion on the manifold, with constant τ, by the method of
/// `options.integrator`.
///
/// | row | order | the constraint | energy |
/// | --- | --- | --- | --- |
/// | Euler's rows | 1 | broken by O(h²) in a step, then corrected | drifts |
/// | `rk4` | 4 | broken by O(h⁵) in a step, then corrected | drifts |
/// | `variational-midpoint` | 2 | φ = 0 and A v = 0 at the end of every step, to rounding | stays within O(h²) |
/// | `variational-yoshida4` | 4 | the same | stays within O(h⁴) |
///
/// The explicit methods have the same stages as for a tree, with the acceleration of
/// [`constrained_forward_dynamics`]. In continuous time, the constraint stays satisfied. P v and n = (1−P) v
/// are orthogonal in M, so the velocity projection changes K by exactly −½ nᵀM n, O(h¹⁰) for `rk4`.
///
/// The variational methods satisfy φ = 0 by multipliers in the discrete action and end with A v = 0 (RATTLE),
/// whatever the correction. They need a start on the constraint. **(HLW §VII.1.4)** Rows without φ (no slip,
/// rolling) follow the discrete Lagrange–d'Alembert principle, with A v = 0 at the middle and at the end. The
/// step is then reversible and satisfies them, but it is not symplectic, and energy is conserved only to the
/// method's order.
///
/// On an error, q and v are unchanged. The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintOptions, ConstraintSet, DriftCorrection};
/// use robot_dynamics::constraints::{StepConstraints, constrained_step};
/// use robot_dynamics::model::Workspace;
/// use robot_dynamics::simulation::StepForces;
/// # use robot_dynamics::description::{Base, FrameDescription, LinkDescription, Pose};
/// # use robot_dynamics::description::RobotDescription;
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // A ball on the end of a 1 m thread that is no link but a constraint: a joint at the world's origin.
/// # let mut robot = model.description().clone();
/// # robot.frames.push(FrameDescription::new("end", "ball", Pose::from_translation([0.0, 0.0, 1.0])));
/// # let model = Model::new(robot)?;
/// let thread = FrameConstraint::point_contact(model.frame_named("end")?, [0.0; 3]);
/// let (set, w) = (ConstraintSet::new(&model, [("thread", thread.into())])?, &mut Workspace::new(&model));
/// let options = ConstraintOptions { integrator: robot_dynamics::simulation::Integrator::VariationalMidpoint, ..Default::default() };
/// let (mut q, mut v) = ([0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0, -1.0, 0.0]);
/// let forces = StepForces::new(&[0.0; 6], false);
/// let law = StepConstraints { set: &set, options: &options, correction: DriftCorrection::None };
/// for _ in 0..100 {
///     constrained_step(&model, w, law, &forces, 0.01, &mut q, &mut v)?;
/// }
/// assert!((q[0].hypot(q[1]).hypot(q[2]) - 1.0).abs() < 1e-11); // as long as ever, to rounding
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The errors of [`constrained_forward_dynamics`] at any stage, and those of [`project_position`].
/// [`ConstraintError::Input`] if `h` is not positive and finite.
/// [`ConstraintError::StepNotConverged`] if a variational step is too long or starts far off the
/// constraint. [`ConstraintError::StabilizedVariationalStep`].
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn constrained_step(
    model: &Model,
    workspace: &mut Workspace,
    law: StepConstraints<'_>,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstraintError> {
    check_step(model, law, forces, h, q, v)?;
    match law.options.integrator.scheme() {
        StepScheme::Explicit(stages) => explicit_row(model, workspace, law, stages, forces, h, (q, v)),
        StepScheme::Variational(fractions) => {
            let workspace = &mut StepWorkspace::new(model);
            variational_row(model, workspace, law, forces, (h, fractions), q, v)
        }
    }
}

/// [`constrained_step`] with memory for every method.
pub(super) fn step_in(
    model: &Model,
    workspace: &mut StepWorkspace,
    law: StepConstraints<'_>,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstraintError> {
    check_step(model, law, forces, h, q, v)?;
    match law.options.integrator.scheme() {
        StepScheme::Explicit(stages) => {
            let dynamics = &mut workspace.dynamics;
            explicit_row(model, dynamics, law, stages, forces, h, (q, v))
        }
        StepScheme::Variational(fractions) => {
            variational_row(model, workspace, law, forces, (h, fractions), q, v)
        }
    }
}

/// Returns an error for inputs that all methods, or this method, reject.
fn check_step(
    model: &Model,
    law: StepConstraints<'_>,
    forces: &StepForces<'_>,
    h: f64,
    q: &[f64],
    v: &[f64],
) -> Result<(), ConstraintError> {
    let StepConstraints { options, correction, .. } = law;
    check_positive("the step", h, "s")?;
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), model.nv());
    check_length("tau", forces.tau.len(), model.nv());
    for (quantity, values) in [("q", q), ("v", v), ("tau", forces.tau)] {
        check_finite(quantity, values)?;
    }
    options.check()?;
    if let DriftCorrection::Position { tolerance } = correction {
        check_number("the tolerance", tolerance)?;
    }
    if matches!(options.integrator.scheme(), StepScheme::Variational(_)) && options.stabilization.is_some() {
        return Err(ConstraintError::StabilizedVariationalStep);
    }
    Ok(())
}

/// A step of a variational method.
fn variational_row(
    model: &Model,
    workspace: &mut StepWorkspace,
    law: StepConstraints<'_>,
    forces: &StepForces<'_>,
    parts: (f64, &[f64]),
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstraintError> {
    let done = variational_step(model, workspace, (law.set, law.options), forces, parts, q, v)?;
    let corrected = constraint_drift(model, &mut workspace.dynamics, law.set, q, v);
    Ok(ConstrainedStepReport {
        drift: ConstraintDrift { position: corrected.position, velocity: done.velocity_before },
        corrected,
        energy_removed: 0.0,
        rank: done.rank,
    })
}

/// A constrained tree with constant forces.
struct ConstrainedTree<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    set: &'a ConstraintSet,
    options: &'a ConstraintOptions,
    forces: &'a StepForces<'a>,
    /// τ − b(v).
    force: Vec<f64>,
    /// The rank of A at the first stage.
    rank: Option<usize>,
}

impl StageSystem<f64> for ConstrainedTree<'_> {
    type Error = ConstraintError;

    fn move_along(&self, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
        integrate(self.model, q, displacement, moved);
    }

    fn accelerate(&mut self, q: &[f64], v: &[f64], acceleration: &mut [f64]) -> Result<(), Self::Error> {
        let Self { model, workspace, set, options, forces, force, rank } = self;
        net_force(model, forces, v, force);
        let motion = constrained_forward_dynamics(model, workspace, set, options, q, v, force)?;
        acceleration.copy_from_slice(motion.acceleration.as_slice());
        rank.get_or_insert(motion.rank);
        Ok(())
    }
}

/// A step with explicit stages, then the correction.
fn explicit_row(
    model: &Model,
    workspace: &mut Workspace,
    law: StepConstraints<'_>,
    stages: &[Stage],
    forces: &StepForces<'_>,
    h: f64,
    (q, v): (&mut [f64], &mut [f64]),
) -> Result<ConstrainedStepReport, ConstraintError> {
    let StepConstraints { set, options, correction } = law;
    let mut memory = vec![0.0; StageMemory::<f64>::size(model, stages.len())];
    let mut memory = StageMemory::new(model, stages.len(), &mut memory);
    let force = vec![0.0; model.nv()];
    let mut motion = ConstrainedTree { model, workspace, set, options, forces, force, rank: None };
    explicit_step(model, stages, &mut motion, h, &mut memory, (q, v))?;
    let ConstrainedTree { rank, workspace, .. } = motion;
    let StageMemory { q: q_end, v: v_end, .. } = memory;
    check_computed("v after the step", v_end)?;
    check_computed("q after the step", q_end)?;

    let drift = constraint_drift(model, workspace, set, q_end, v_end);
    if let DriftCorrection::Position { tolerance } = correction {
        project_position(model, workspace, set, options, tolerance, q_end)?;
    }
    let (mut corrected, mut energy_removed) = (drift, 0.0);
    if correction != DriftCorrection::None {
        energy_removed = project_velocity(model, workspace, set, options, q_end, v_end)?;
        corrected = constraint_drift(model, workspace, set, q_end, v_end);
    }
    q.copy_from_slice(q_end);
    v.copy_from_slice(v_end);
    Ok(ConstrainedStepReport { drift, corrected, energy_removed, rank: rank.unwrap_or(0) })
}
