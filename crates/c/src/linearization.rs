//! Derivatives of integration steps.

use std::ffi::c_char;

use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::simulation::{Integrator, StepForces};

use crate::Status;
use crate::arrays::{Arrays, text};
use crate::calls::call;
use crate::handle::exclusive;
use crate::workspace::{RobotWorkspace, WorkspaceHandle};

/// A = ∂(q₁, v₁)/∂(q₀, v₀), 2nv × 2nv, and B = ∂(q₁, v₁)/∂tau, 2nv × nv, row-major, of a step without contact
/// by an integrator such as `rk4` or `semi-implicit-euler`. `dissipation`: not 0 for damping and friction.
/// Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_linearize_step(
    workspace: WorkspaceHandle,
    integrator: *const c_char,
    dt: f64,
    dissipation: i32,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *const f64,
    tau_len: usize,
    by_state: *mut f64,
    by_state_len: usize,
    by_force: *mut f64,
    by_force_len: usize,
) -> Status {
    call(|| {
        let robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let integrator: Integrator = text("the integrator", integrator)?.parse()?;
        let (model, mut arrays) = (&*robot.model, Arrays::default());
        let n = model.nv();
        let q = arrays.input("q", q, nq, model.nq())?;
        let v = arrays.input("v", v, nv, n)?;
        let tau = arrays.input("tau", tau, tau_len, n)?;
        let by_state = arrays.output("the result `by_state`", by_state, by_state_len, 4 * n * n)?;
        let by_force = arrays.output("the result `by_force`", by_force, by_force_len, 2 * n * n)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        robot.check_v("tau", tau)?;
        let (state, forces) = (RobotState { q, v }, StepForces::new(tau, dissipation != 0));
        let mut memory = LinearizeStepWorkspace::new(model);
        let out = LinearizedStep { by_state, by_force };
        Ok(linearize_step(model, integrator, &mut memory, &forces, dt, state, out)?)
    })
}
