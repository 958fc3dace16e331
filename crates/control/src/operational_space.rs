//! Operational-space dynamics, and controllers that track a motion.
//!
//! Λ ẍ + μ + p = F at a frame, with Λ = (J M⁻¹Jᵀ)⁻¹, J̄ = M⁻¹JᵀΛ and τ = JᵀF. M⁻¹Jᵀ comes from the sparse
//! factor of M, O(n depth²) and O(n depth) for each of at most six columns.
//!
//! Λ does not exist at a singular pose. Controllers damp it there, and return an error if a row cannot be
//! moved at any pose.
//!
//! Source: Khatib, *A unified approach for motion and force control of robot manipulators*, IEEE J. Robotics
//! and Automation 3 (1987).

mod actuated_part;
mod computed_torque;
mod effort_limits;
mod frame_law;
mod impedance;
mod mobility;
mod target;
mod task;
mod torque;

pub use computed_torque::{ComputedTorque, Reference};
pub use effort_limits::EffortScales;
pub use impedance::{ImpedanceControl, ImpedanceGains};
pub use target::{PoseReference, TaskDeviation, TaskReference, TaskTarget};
pub use task::{TaskControl, TaskGains};

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Workspace, bias, check_configuration, check_rank, check_vector,
    frame_bias_acceleration, frame_jacobian,
};
use robot_dynamics_description::check_length;
use robot_dynamics_number::check_result;
use robot_dynamics_simulation::motion::integrate::MassFactor;
use robot_dynamics_simulation::motion::simulate::singular_mass;
use robot_dynamics_simulation::{ControllerError, SpatialAxis};

use self::actuated_part::ActuatedPart;
use self::mobility::{MOST_ROWS, Mobility};

/// A row is singular if its mobility independent of the others is below this fraction of its own; Λ would
/// have less than four digits.
const LEAST_MOBILITY: f64 = 1e-12;

/// The dynamics of a frame: Λ ẍ + μ + p = F, where x are the chosen directions of its world-aligned velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationalSpace {
    /// Λ = (J M⁻¹Jᵀ)⁻¹, K×K: the inertia that a force at the frame accelerates \[kg, kg·m, kg·m²\].
    pub inertia: DMatrix<f64>,
    /// J, K×nv: the chosen rows of the world-aligned frame Jacobian.
    pub jacobian: DMatrix<f64>,
    /// J̄ = M⁻¹JᵀΛ, nv×K: J J̄ = 1, and J̄ᵀτ is the force at the frame that is equivalent to τ.
    pub consistent_inverse: DMatrix<f64>,
    /// J̇ v, K.
    pub bias_acceleration: DVector<f64>,
    /// μ + p = J̄ᵀ(C v + g) − Λ J̇ v, K: the force that keeps ẍ = 0.
    pub bias_force: DVector<f64>,
}

/// Scratch for [`operational_space_into`] on one model.
#[derive(Clone, Debug)]
pub struct OperationalSpaceWorkspace {
    dynamics: Workspace,
    scratch: Scratch,
}

/// The memory for the quantities of an operational space.
#[derive(Clone, Debug)]
struct Scratch {
    /// All six rows of J, row-major.
    jacobian: Vec<f64>,
    /// C v + g.
    force: Vec<f64>,
    mass: MassFactor,
    /// Present if only motors act, and they do not drive every coordinate.
    part: Option<ActuatedPart>,
    /// The diagonal of J M⁻¹Jᵀ.
    mobility: [f64; MOST_ROWS],
    /// Present if Λ is damped near a singular pose.
    damping: Option<Damping>,
}

/// The damping of Λ near a singular pose.
#[derive(Clone, Debug)]
struct Damping {
    /// The fraction of the typical mobility below which a row is damped.
    fraction: f64,
    /// The typical mobility of each row \[1/kg, 1/(kg·m²)\].
    typical: [f64; MOST_ROWS],
    /// Whether Λ was damped in the last call.
    is_active: bool,
}

impl Scratch {
    fn new(model: &Model) -> Self {
        let nv = model.nv();
        Self {
            jacobian: vec![0.0; 6 * nv],
            force: vec![0.0; nv],
            mass: MassFactor::new(model),
            part: None,
            mobility: [0.0; MOST_ROWS],
            damping: None,
        }
    }
}

impl OperationalSpaceWorkspace {
    /// Allocates the memory for this model; nothing else allocates.
    pub fn new(model: &Model) -> Self {
        Self { dynamics: Workspace::new(model), scratch: Scratch::new(model) }
    }

    /// The same for a robot that is driven by its motors only: J̃, Λ̃ and μ̃, where the unactuated
    /// coordinates move according to the dynamics.
    fn of_actuated(model: &Model) -> Self {
        let mut workspace = Self::new(model);
        workspace.scratch.part = ActuatedPart::new(model);
        workspace
    }
}

/// Λ, J̄ and μ + p of a frame, for the rows chosen of x, y, z, rx, ry, rz along the world's axes.
///
/// F = Λ ẍ + μ + p with τ = JᵀF. Torques (1 − JᵀJ̄ᵀ) τ₀ do not accelerate the frame. This function allocates;
/// [`operational_space_into`] does not, and suits control loops.
///
/// ```
/// use robot_dynamics::constraints::SpatialAxis;
/// use robot_dynamics::control::operational_space;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // Horizontal rod: the tip accelerates along z, and its effective mass is the mass there.
/// let (w, tip) = (&mut Workspace::new(&model), model.frame_named("tip")?);
/// let space = operational_space(&model, w, &[0.0], &[0.0], tip, &[SpatialAxis::Z])?;
/// assert!((space.inertia[(0, 0)] - 2.0).abs() < 1e-14);
/// assert!((space.bias_force[0] - 2.0 * 9.81).abs() < 1e-13); // the force that holds the weight
/// assert!(((&space.jacobian * &space.consistent_inverse)[(0, 0)] - 1.0).abs() < 1e-15); // J J̄ = 1
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ControllerError`] if q is an invalid configuration, v is not finite, M or J M⁻¹Jᵀ is singular, or
/// a result overflows.
///
/// # Panics
/// Panics if no row or more than six are chosen, or the frame belongs to another model.
#[track_caller]
pub fn operational_space(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    v: &[f64],
    frame: FrameId,
    rows: &[SpatialAxis],
) -> Result<OperationalSpace, ControllerError> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    let mut space = OperationalSpace::zeros(model, rows.len());
    let inputs = OperationalSpaceInputs { q, v, frame, rows };
    compute(model, workspace, &mut Scratch::new(model), inputs, &mut space)?;
    Ok(space)
}

/// The inputs of [`operational_space_into`].
#[derive(Clone, Copy, Debug)]
pub struct OperationalSpaceInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// The frame whose origin moves.
    pub frame: FrameId,
    /// The directions of the task, one to six, along the world's axes.
    pub rows: &'a [SpatialAxis],
}

/// [`operational_space`] into existing memory, without allocation. On an error the contents of `space` are
/// unspecified.
///
/// ```
/// use robot_dynamics::constraints::SpatialAxis;
/// use robot_dynamics::control::{OperationalSpace, OperationalSpaceWorkspace};
/// use robot_dynamics::control::{OperationalSpaceInputs, operational_space_into};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (tip, rows) = (model.frame_named("tip")?, [SpatialAxis::Z]);
/// let mut workspace = OperationalSpaceWorkspace::new(&model); // allocated once before the loop
/// let mut space = OperationalSpace::zeros(&model, rows.len());
/// let inputs = OperationalSpaceInputs { q: &[0.3], v: &[0.0], frame: tip, rows: &rows };
/// operational_space_into(&model, &mut workspace, inputs, &mut space)?;
/// assert!((space.inertia[(0, 0)] - 2.0 / 0.3_f64.cos().powi(2)).abs() < 1e-14); // only part of its motion is along z
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`operational_space`].
///
/// # Panics
/// As [`operational_space`], and if `space` has another number of rows or coordinates.
#[track_caller]
pub fn operational_space_into(
    model: &Model,
    workspace: &mut OperationalSpaceWorkspace,
    inputs: OperationalSpaceInputs<'_>,
    space: &mut OperationalSpace,
) -> Result<(), ControllerError> {
    let OperationalSpaceWorkspace { dynamics, scratch } = workspace;
    compute(model, dynamics, scratch, inputs, space)
}

fn compute(
    model: &Model,
    workspace: &mut Workspace,
    scratch: &mut Scratch,
    inputs: OperationalSpaceInputs<'_>,
    space: &mut OperationalSpace,
) -> Result<(), ControllerError> {
    let OperationalSpaceInputs { q, v, frame, rows } = inputs;
    let (nv, count) = (model.nv(), rows.len());
    assert!((1..=MOST_ROWS).contains(&count), "an operational space has one to six rows, not {count}");
    check_length("the operational space", space.inertia.nrows(), count);
    check_length("a row of the operational space's J", space.jacobian.ncols(), nv);
    check_configuration(model, q)?;
    check_vector(model, "v", v)?;
    let Scratch { jacobian: full, force, mass, part, mobility: own_mobility, damping } = scratch;
    frame_jacobian(model, workspace, q, frame, ReferenceFrame::LocalWorldAligned, full);
    let rate = frame_bias_acceleration(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned);
    bias(model, workspace, q, v, force);
    check_rank(model, workspace, q)?;
    if mass.factor(model, workspace, q).is_err() {
        return Err(singular_mass(model, q));
    }

    let OperationalSpace { inertia, jacobian, consistent_inverse, bias_acceleration, bias_force } = space;
    // M⁻¹Jᵀ, column by column, in the memory of J̄.
    for (k, row) in rows.iter().map(|row| *row as usize).enumerate() {
        bias_acceleration[k] = if row < 3 { rate.linear[row] } else { rate.angular[row - 3] };
        let mut response = consistent_inverse.column_mut(k);
        for (i, &entry) in full[row * nv..(row + 1) * nv].iter().enumerate() {
            jacobian[(k, i)] = entry;
            response[i] = entry;
        }
        mass.solve(response.as_mut_slice());
    }
    if let Some(part) = part {
        part.factor(model, workspace, q)?;
        part.reduce(force);
        for (k, row) in rows.iter().map(|row| *row as usize).enumerate() {
            let row = &mut full[row * nv..(row + 1) * nv];
            bias_acceleration[k] -= part.along_unactuated(row);
        }
        for (k, row) in rows.iter().map(|row| *row as usize).enumerate() {
            let row = &mut full[row * nv..(row + 1) * nv];
            part.reduce(row);
            jacobian.row_mut(k).iter_mut().zip(&*row).for_each(|(entry, x)| *entry = *x);
            part.clear_unactuated(consistent_inverse.column_mut(k).as_mut_slice());
        }
    }
    let mut mobility = Mobility::new(count, |i, j| jacobian.row(i).tr_dot(&consistent_inverse.column(j)));
    *own_mobility = mobility.diagonal();
    let factored = match damping {
        Some(own) => mobility.factor_damped(own.fraction, &own.typical).map(|damped| own.is_active = damped),
        None => mobility.factor(LEAST_MOBILITY),
    };
    if let Err((row, pivot)) = factored {
        return Err(ControllerError::SingularPose { row: rows[row].name(), pivot });
    }
    mobility.invert(inertia);
    for i in 0..nv {
        let mut row = consistent_inverse.row_mut(i);
        let mut response = [0.0; MOST_ROWS];
        response.iter_mut().zip(row.iter()).for_each(|(to, x)| *to = *x);
        for k in 0..count {
            row[k] = (0..count).map(|j| response[j] * inertia[(j, k)]).sum();
        }
    }
    for k in 0..count {
        let weight: f64 = consistent_inverse.column(k).iter().zip(force.iter()).map(|(j, f)| j * f).sum();
        let lost: f64 = (0..count).map(|j| inertia[(k, j)] * bias_acceleration[j]).sum();
        bias_force[k] = weight - lost;
    }
    check_result("Λ", inertia.as_slice())?;
    check_result("J̄", consistent_inverse.as_slice())?;
    Ok(check_result("μ + p", bias_force.as_slice())?)
}

impl OperationalSpace {
    /// Allocates zeros for this number of rows, to be filled by [`operational_space_into`].
    pub fn zeros(model: &Model, rows: usize) -> Self {
        let nv = model.nv();
        Self {
            inertia: DMatrix::zeros(rows, rows),
            jacobian: DMatrix::zeros(rows, nv),
            consistent_inverse: DMatrix::zeros(nv, rows),
            bias_acceleration: DVector::zeros(rows),
            bias_force: DVector::zeros(rows),
        }
    }
}
