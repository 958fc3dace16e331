//! The momentum observer of external torques.

use std::sync::Arc;

use robot_dynamics::control::MomentumObserver;
use robot_dynamics::model::Model;

use crate::Status;
use crate::arrays::{Arrays, result};
use crate::calls::call;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};

/// An observer of the external torques, from measured states and motor torques.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MomentumObserverHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct Observer {
    observer: MomentumObserver<Arc<Model>>,
    nq: usize,
    nv: usize,
}

object!(Observer, 9, "the observer");

/// Makes an observer with nv gains \[1/s\]. `dissipation`: not 0 counts damping and friction as known. Free
/// it with `rd_momentum_observer_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_momentum_observer_new(
    model: ModelHandle,
    gains: *const f64,
    gains_len: usize,
    dissipation: i32,
    observer: *mut MomentumObserverHandle,
) -> Status {
    call(|| {
        let out = result("the result `observer`", observer)?;
        let robot = shared::<RobotModel>(model.id)?;
        let gains = Arrays::default().any("the gains", gains, gains_len)?;
        let mut observer = MomentumObserver::new(Arc::clone(&robot.model), gains)?;
        if dissipation != 0 {
            observer = observer.with_dissipation();
        }
        out.id = insert(Observer { observer, nq: robot.model.nq(), nv: robot.model.nv() })?;
        Ok(())
    })
}

/// Frees an observer. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_momentum_observer_free(observer: MomentumObserverHandle) -> Status {
    call(|| remove::<Observer>(observer.id))
}

/// Enters a sample, h seconds after the last one, and copies the estimated external torques, nv numbers. Does
/// not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_momentum_observer_update(
    observer: MomentumObserverHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *const f64,
    tau_len: usize,
    h: f64,
    external: *mut f64,
    external_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<Observer>(observer.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, own.nq)?;
        let v = arrays.input("v", v, nv, own.nv)?;
        let tau = arrays.input("tau", tau, tau_len, own.nv)?;
        let external = arrays.output("the external torques", external, external_len, own.nv)?;
        external.copy_from_slice(own.observer.update(q, v, tau, h)?);
        Ok(())
    })
}

/// Forgets all samples.
#[unsafe(no_mangle)]
pub extern "C" fn rd_momentum_observer_reset(observer: MomentumObserverHandle) -> Status {
    call(|| {
        exclusive::<Observer>(observer.id)?.observer.reset();
        Ok(())
    })
}
