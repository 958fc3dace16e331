//! Controllers, a momentum observer and the linear-quadratic regulator.

pub mod observer;
pub mod task;

use std::sync::Arc;

use nalgebra::DMatrix;
use robot_dynamics::control::{ComputedTorque, Reference, dlqr};
use robot_dynamics::model::{Model, neutral};

use crate::Status;
use crate::arrays::{Arrays, result};
use crate::calls::call;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};

/// Computed torque: inverse dynamics of a reference with feedback through M.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComputedTorqueHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct TorqueControl {
    law: ComputedTorque<Arc<Model>, fn(f64) -> Reference>,
    reference: Reference,
}

object!(TorqueControl, 7, "the controller");

/// Makes tau = M(a* + Kp (q* ⊖ q) + Kd (v* − v)) + C v + g, with nv gains each. The reference is the neutral
/// configuration at rest until `rd_computed_torque_set_reference`. `dissipation`: not 0 compensates damping
/// and friction of the joints. Free it with `rd_computed_torque_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_computed_torque_new(
    model: ModelHandle,
    stiffness: *const f64,
    stiffness_len: usize,
    damping: *const f64,
    damping_len: usize,
    dissipation: i32,
    controller: *mut ComputedTorqueHandle,
) -> Status {
    call(|| {
        let controller = result("the result `controller`", controller)?;
        let robot = shared::<RobotModel>(model.id)?;
        let mut arrays = Arrays::default();
        let kp = arrays.any("the stiffness", stiffness, stiffness_len)?;
        let kd = arrays.any("the damping", damping, damping_len)?;
        let (model, nv) = (Arc::clone(&robot.model), robot.model.nv());
        let reference = Reference { q: neutral(&model), v: vec![0.0; nv], a: vec![0.0; nv] };
        let unused: fn(f64) -> Reference = |_| Reference { q: Vec::new(), v: Vec::new(), a: Vec::new() };
        let mut law = ComputedTorque::owning(model, unused, kp, kd)?;
        if dissipation != 0 {
            law = law.with_dissipation();
        }
        controller.id = insert(TorqueControl { law, reference })?;
        Ok(())
    })
}

/// Frees a controller. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_computed_torque_free(controller: ComputedTorqueHandle) -> Status {
    call(|| remove::<TorqueControl>(controller.id))
}

/// Sets the reference: q* (nq numbers), v* and a* (nv each). Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_computed_torque_set_reference(
    controller: ComputedTorqueHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<TorqueControl>(controller.id)?;
        let Reference { q: own_q, v: own_v, a: own_a } = &mut own.reference;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, own_q.len())?;
        let v = arrays.input("v", v, nv, own_v.len())?;
        let a = arrays.input("a", a, a_len, own_a.len())?;
        own_q.copy_from_slice(q);
        own_v.copy_from_slice(v);
        own_a.copy_from_slice(a);
        Ok(())
    })
}

/// The torque at a state, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_computed_torque_torque(
    controller: ComputedTorqueHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *mut f64,
    tau_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<TorqueControl>(controller.id)?;
        let TorqueControl { law, reference } = &mut *own;
        let (n, mut arrays) = (reference.v.len(), Arrays::default());
        let q = arrays.input("q", q, nq, reference.q.len())?;
        let v = arrays.input("v", v, nv, n)?;
        let tau = arrays.output("tau", tau, tau_len, n)?;
        Ok(law.torque_toward(reference, 0.0, q, v, tau)?)
    })
}

/// The gain K, m × n, of u = −K x that minimizes Σ xᵀQ x + uᵀR u along x' = A x + B u. A and Q are n × n, B
/// is n × m, R is m × m, all row-major. `spectral_radius` may be null: the largest |λ| of A − B K. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_dlqr(
    states: usize,
    controls: usize,
    a: *const f64,
    b: *const f64,
    q: *const f64,
    r: *const f64,
    gain: *mut f64,
    gain_len: usize,
    spectral_radius: *mut f64,
) -> Status {
    call(|| {
        let (n, m, mut arrays) = (states, controls, Arrays::default());
        let (nn, nm, mm) = (n.saturating_mul(n), n.saturating_mul(m), m.saturating_mul(m));
        let a = DMatrix::from_row_slice(n, n, arrays.any("A", a, nn)?);
        let b = DMatrix::from_row_slice(n, m, arrays.any("B", b, nm)?);
        let q = DMatrix::from_row_slice(n, n, arrays.any("Q", q, nn)?);
        let r = DMatrix::from_row_slice(m, m, arrays.any("R", r, mm)?);
        let out = arrays.output("the gain", gain, gain_len, nm)?;
        let radius = arrays.optional_result("the spectral radius", spectral_radius)?;
        let found = dlqr(&a, &b, &q, &r)?;
        for (k, entry) in out.iter_mut().enumerate() {
            *entry = found.gain[(k / n, k % n)];
        }
        if let Some(radius) = radius {
            *radius = found.spectral_radius;
        }
        Ok(())
    })
}
