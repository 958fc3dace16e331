//! The quantities of the library's table, for one state.

pub mod functions;

use std::ffi::{CString, c_char};
use std::ptr::null;
use std::sync::LazyLock;

use robot_dynamics::algorithms::MotionError;
use robot_dynamics::quantity::{Input, Inputs, Quantity};
use robot_dynamics_number::are_finite;

use crate::Status;
use crate::arrays::{Arrays, c_text, options, result, text};
use crate::calls::{call, query};
use crate::failure::{Failure, check_result};
use crate::handle::exclusive;
use crate::workspace::{RobotWorkspace, WorkspaceHandle};

/// A quantity of the table. Matrices are row-major.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityC {
    /// M(q), nv × nv.
    MassMatrix = 0,
    /// C(q, v) v + g(q), nv.
    Bias,
    /// g(q), nv.
    Gravity,
    /// C(q, v), nv × nv.
    CoriolisMatrix,
    /// C(q, v) v, nv.
    VelocityProduct,
    /// tau(q, v, a), nv.
    InverseDynamics,
    /// a(q, v, tau), nv.
    ForwardDynamics,
    /// The inverse of M(q), nv × nv.
    InverseMassMatrix,
    /// L and D of M(q) = LᵀDL, nv × nv.
    MassMatrixFactor,
    /// K(q, v).
    KineticEnergy,
    /// V(q).
    PotentialEnergy,
    /// M(q) v, nv.
    Momentum,
    /// The centre of mass in the world, 3.
    CenterOfMass,
    /// Its Jacobian, 3 × nv.
    CenterOfMassJacobian,
    /// The centroidal momentum matrix, 6 × nv.
    CentroidalMomentumMatrix,
    /// Poses of frames, 12 for each: the rotation by rows, then the translation. One state: of all frames.
    /// A batch: of the given frames.
    FramePoses,
    /// A frame's Jacobian, its origin and the world's axes, 6 × nv.
    FrameJacobianLocalWorldAligned,
    /// A frame's Jacobian, its origin and its own axes, 6 × nv.
    FrameJacobianLocal,
    /// A frame's Jacobian, the world's origin and axes, 6 × nv.
    FrameJacobianWorld,
    /// ∂tau/∂q and ∂tau/∂v, nv × nv each.
    InverseDynamicsDerivatives,
    /// ∂a/∂q, ∂a/∂v and ∂a/∂tau, nv × nv each.
    ForwardDynamicsDerivatives,
    /// ∂g/∂q, nv × nv.
    GravityDerivative,
}

/// The inputs of a quantity. Those that it does not read may be null. For a batch each array has the rows of
/// all states, one after another.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct InputsC {
    /// The configuration, nq numbers.
    pub q: *const f64,
    /// The length of `q`.
    pub q_len: usize,
    /// The velocity, nv numbers.
    pub v: *const f64,
    /// The length of `v`.
    pub v_len: usize,
    /// The acceleration, nv numbers.
    pub a: *const f64,
    /// The length of `a`.
    pub a_len: usize,
    /// The generalized force, nv numbers.
    pub tau: *const f64,
    /// The length of `tau`.
    pub tau_len: usize,
    /// The numbers of frames.
    pub frames: *const u32,
    /// The length of `frames`.
    pub frames_len: usize,
}

/// The arrays of the results of a quantity. Unused ones may be null.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ResultsC {
    /// The first result.
    pub first: *mut f64,
    /// Its length.
    pub first_len: usize,
    /// The second result.
    pub second: *mut f64,
    /// Its length.
    pub second_len: usize,
    /// The third result.
    pub third: *mut f64,
    /// Its length.
    pub third_len: usize,
}

impl Default for InputsC {
    fn default() -> Self {
        // SAFETY: a null pointer and a length of 0 are valid values of every field.
        unsafe { std::mem::zeroed() }
    }
}

impl Default for ResultsC {
    fn default() -> Self {
        // SAFETY: as for the inputs.
        unsafe { std::mem::zeroed() }
    }
}

/// The quantity of this number.
pub(crate) fn quantity_of(number: u32) -> Result<Quantity, Failure> {
    Quantity::ALL.get(number as usize).copied().ok_or_else(|| {
        let count = Quantity::ALL.len();
        Failure::invalid(format!("there is no quantity {number}; there are {count}, from 0"))
    })
}

/// The number of entries of the results of a quantity, for one state of a model and this many frames.
pub(crate) fn result_lengths(quantity: Quantity, robot: &RobotWorkspace, frames: usize) -> [usize; 3] {
    let mut lengths = [0; 3];
    for (length, result) in lengths.iter_mut().zip(quantity.results()) {
        *length = result.shape.len(&robot.model, frames);
    }
    lengths
}

/// Computes a quantity of the table for one state. Does not allocate.
///
/// The lengths of unused arrays must be 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_compute(
    workspace: WorkspaceHandle,
    quantity: u32,
    inputs: *const InputsC,
    results: *const ResultsC,
) -> Status {
    call(|| {
        let (inputs, results) = (options("the inputs", inputs)?, options("the results", results)?);
        compute(workspace, quantity_of(quantity)?, &inputs, &results)
    })
}

/// The number of quantities in the table.
#[unsafe(no_mangle)]
pub extern "C" fn rd_quantity_count() -> u32 {
    Quantity::ALL.len() as u32
}

/// The number of the quantity with this name, such as `mass_matrix`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_quantity_named(name: *const c_char, quantity: *mut u32) -> Status {
    call(|| {
        let name = text("the name of the quantity", name)?;
        let found = Quantity::ALL.iter().position(|quantity| quantity.name() == name);
        let missing = || Failure::new(Status::UnknownName, format!("there is no quantity `{name}`"));
        *result("the result `quantity`", quantity)? = found.ok_or_else(missing)? as u32;
        Ok(())
    })
}

/// The lengths of the three results of a quantity for one state, 0 for those that it does not have.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_quantity_lengths(
    workspace: WorkspaceHandle,
    quantity: u32,
    frame_count: usize,
    lengths: *mut usize,
    lengths_len: usize,
) -> Status {
    call(|| {
        let robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let lengths = Arrays::default().output("the result", lengths, lengths_len, 3)?;
        // An array of so many poses would not fit into memory.
        if frame_count > isize::MAX as usize / (12 * size_of::<f64>()) {
            return Err(Failure::invalid(format!("there are {frame_count} frames, more than memory has")));
        }
        lengths.copy_from_slice(&result_lengths(quantity_of(quantity)?, &robot, frame_count));
        Ok(())
    })
}

/// Computes one state. Each function of the interface has its own copy, in which the quantity is a constant.
#[inline(always)]
unsafe fn compute(
    workspace: WorkspaceHandle,
    quantity: Quantity,
    inputs: &InputsC,
    results: &ResultsC,
) -> Result<(), Failure> {
    let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
    let (nq, nv) = (robot.model.nq(), robot.model.nv());
    let mut arrays = Arrays::default();
    let q = arrays.input("q", inputs.q, inputs.q_len, nq)?;
    let reads = |input| if quantity.reads(input) { nv } else { 0 };
    let v = arrays.input("v", inputs.v, inputs.v_len, reads(Input::Velocity))?;
    let a = arrays.input("a", inputs.a, inputs.a_len, reads(Input::Acceleration))?;
    let tau = arrays.input("tau", inputs.tau, inputs.tau_len, reads(Input::Force))?;
    let frame = if quantity.reads(Input::Frame) {
        let frames = arrays.input("the frames", inputs.frames, inputs.frames_len, 1)?;
        Some(robot.frame(frames[0])?)
    } else {
        None
    };
    let lengths = result_lengths(quantity, &robot, robot.poses.len());
    let mut out = [
        arrays.output("the first result", results.first, results.first_len, lengths[0])?,
        arrays.output("the second result", results.second, results.second_len, lengths[1])?,
        arrays.output("the third result", results.third, results.third_len, lengths[2])?,
    ];
    robot.check_q(q)?;
    for (name, x) in [("v", v), ("a", a), ("tau", tau)] {
        if !x.is_empty() {
            robot.check_v(name, x)?;
        }
    }
    if quantity.inverts_mass() {
        robot.check_rank(q)?;
    }
    let inputs = Inputs { q, v, a, tau, frames: frame.as_slice() };
    let RobotWorkspace { model, memory, poses, .. } = &mut *robot;
    if quantity == Quantity::FramePoses {
        robot_dynamics::algorithms::frame_poses(model, memory, q, poses);
        for (numbers, pose) in out[0].chunks_exact_mut(12).zip(&*poses) {
            pose_numbers(pose, numbers);
        }
    } else {
        quantity.compute_into(model, memory, &inputs, out.each_mut().map(|out| &mut **out));
    }
    match out.iter().find(|out| !are_finite(out)) {
        None => Ok(()),
        // Only quantities about the centre of mass divide by the mass.
        Some(_) if model.mass() == 0.0 => Err(MotionError::NoMass { robot: model.name().to_owned() }.into()),
        Some(out) => check_result(quantity.name(), out),
    }
}

/// The twelve numbers of a pose: the rotation by rows, then the translation.
pub(crate) fn pose_numbers(pose: &robot_dynamics::description::Pose, numbers: &mut [f64]) {
    for (to, row) in numbers.chunks_exact_mut(3).zip(&pose.rotation) {
        to.copy_from_slice(row);
    }
    numbers[9..].copy_from_slice(&pose.translation);
}

/// The name of a quantity; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_quantity_name(quantity: u32) -> *const c_char {
    static NAMES: LazyLock<Vec<CString>> =
        LazyLock::new(|| Quantity::ALL.iter().map(|quantity| c_text(quantity.name())).collect());
    query(null(), || {
        quantity_of(quantity)?;
        Ok(NAMES[quantity as usize].as_ptr())
    })
}
