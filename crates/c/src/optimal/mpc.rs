//! Model predictive control.

use std::sync::{Mutex, PoisonError};

use robot_dynamics::control::optimal::{Mpc, MpcOptions};

use crate::Status;
use crate::arrays::{Arrays, options, result};
use crate::calls::call;
use crate::handle::{exclusive, insert, object, remove};

use super::solution::{SolverOptionsC, time};
use super::{OptimalProblem, ProblemHandle};

/// A controller that solves a problem again at each period.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MpcHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

/// Parts of it are not for several threads at once, so a lock surrounds them.
pub(crate) struct Predictive(Mutex<Mpc>);

object!(Predictive, 12, "the predictive controller");

impl Predictive {
    fn mpc(&mut self) -> &mut Mpc {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The times of the periods, without the first \[s\].
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct MpcTimesC {
    /// The number of periods.
    pub periods: usize,
    /// The median.
    pub median: f64,
    /// The time that 99.9 % do not exceed.
    pub percentile_99_9: f64,
    /// The longest.
    pub longest: f64,
    /// The periods that took longer than the budget.
    pub over_budget: usize,
}

/// Makes a controller of a problem, with its present costs and bounds. One period is one node. `options` may
/// be null. `iterations` is the most of each period, 0 for the default, 2. `time_budget` is that of a period
/// \[s\], 0 for none. Free it with `rd_mpc_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_mpc_new(
    problem: ProblemHandle,
    options: *const SolverOptionsC,
    iterations: usize,
    time_budget: f64,
    mpc: *mut MpcHandle,
) -> Status {
    call(|| {
        let out = result("the result `mpc`", mpc)?;
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let mut chosen = MpcOptions::default();
        chosen.solver = self::options("the options", options)?.options()?;
        if iterations > 0 {
            chosen.iterations = iterations;
        }
        chosen.time_budget = time(time_budget)?;
        out.id = insert(Predictive(Mutex::new(Mpc::new(own.parts().assembled()?, chosen)?)))?;
        Ok(())
    })
}

/// Frees a controller. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_mpc_free(mpc: MpcHandle) -> Status {
    call(|| remove::<Predictive>(mpc.id))
}

/// The controls of the next period, from the measured state (q, v). Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_mpc_step(
    mpc: MpcHandle,
    state: *const f64,
    state_len: usize,
    control: *mut f64,
    control_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<Predictive>(mpc.id)?;
        let mpc = own.mpc();
        let mut arrays = Arrays::default();
        let state = arrays.any("the state", state, state_len)?;
        let expected = mpc.fddp().problem().controls(0);
        let control = arrays.output("the controls", control, control_len, expected)?;
        control.copy_from_slice(mpc.step(state)?);
        Ok(())
    })
}

/// Takes the present costs of a problem, for example with another target. The problem must be the one from
/// which the controller was made, or have as many nodes and controls.
#[unsafe(no_mangle)]
pub extern "C" fn rd_mpc_set_costs(mpc: MpcHandle, problem: ProblemHandle) -> Status {
    call(|| {
        let mut own = exclusive::<Predictive>(mpc.id)?;
        let mut problem = exclusive::<OptimalProblem>(problem.id)?;
        let parts = problem.parts();
        let terminal = parts.cost_at(parts.problem.nodes());
        // All costs are tried on a copy first, so that a refused one changes nothing.
        let mut copy = own.mpc().fddp().problem().clone();
        for nodes in parts.phases() {
            copy.set_running_cost(nodes.clone(), parts.cost_at(nodes.start))?;
        }
        copy.set_terminal_cost(terminal.clone())?;
        for nodes in parts.phases() {
            own.mpc().fddp_mut().set_running_cost(nodes.clone(), &parts.cost_at(nodes.start))?;
        }
        Ok(own.mpc().fddp_mut().set_terminal_cost(&terminal)?)
    })
}

/// The times of the periods so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_mpc_times(mpc: MpcHandle, times: *mut MpcTimesC) -> Status {
    call(|| {
        let mut own = exclusive::<Predictive>(mpc.id)?;
        let found = own.mpc().times();
        *result("the result `times`", times)? = MpcTimesC {
            periods: found.periods,
            median: found.median.as_secs_f64(),
            percentile_99_9: found.percentile_99_9.as_secs_f64(),
            longest: found.longest.as_secs_f64(),
            over_budget: found.over_budget,
        };
        Ok(())
    })
}
