//! Solving a problem, and its trajectory.

use std::time::Duration;

use robot_dynamics::control::optimal::{Fddp, FddpOptions, FddpReport, Termination};

use crate::Status;
use crate::arrays::{Arrays, options, result};
use crate::batch::check_threads;
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::exclusive;

use super::{OptimalProblem, ProblemHandle};

/// Options of the solver. A structure filled with zeros selects the defaults.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct SolverOptionsC {
    /// The largest number of iterations; 0 for the default, 100.
    pub max_iterations: usize,
    /// The threads that linearize the nodes; 0 or 1 for the calling thread alone; 1024 are the most.
    pub threads: usize,
    /// The time after which no iteration starts \[s\]; 0 for none.
    pub time_limit: f64,
    /// The largest derivative of the Lagrangian at a solution; 0 for the default, 1e-6.
    pub gradient_tolerance: f64,
}

/// The result of a solver.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct SolverReportC {
    /// Not 0 if the solver ended at a local minimum, to its tolerances or to rounding.
    pub is_solved: i32,
    /// The number of iterations.
    pub iterations: usize,
    /// The cost of the trajectory.
    pub cost: f64,
    /// The largest entry of a defect.
    pub defect: f64,
    /// The largest derivative of the Lagrangian by an unbounded control.
    pub gradient: f64,
}

impl From<&FddpReport> for SolverReportC {
    fn from(report: &FddpReport) -> Self {
        Self {
            is_solved: i32::from(report.is_solved()),
            iterations: report.iterations,
            cost: report.cost,
            defect: report.defect,
            gradient: report.gradient,
        }
    }
}

impl SolverOptionsC {
    pub(super) fn options(&self) -> Result<FddpOptions, Failure> {
        let mut options = FddpOptions::default();
        if self.max_iterations > 0 {
            options.max_iterations = self.max_iterations;
        }
        check_threads(self.threads)?;
        options.threads = self.threads.max(1);
        if self.gradient_tolerance != 0.0 {
            options.gradient_tolerance = self.gradient_tolerance;
        }
        options.time_limit = time(self.time_limit)?;
        Ok(options)
    }
}

/// A time in seconds; 0 for none.
pub(super) fn time(seconds: f64) -> Result<Option<Duration>, Failure> {
    if seconds == 0.0 {
        return Ok(None);
    }
    let invalid =
        |_| Failure::invalid(format!("the time limit is {seconds} s; it must be positive and finite"));
    Duration::try_from_secs_f64(seconds).map(Some).map_err(invalid)
}

/// Solves the problem by FDDP, from zero controls or from the last solution. `options` and `report` may be
/// null. If the solver ends elsewhere than at a minimum, the status is `RD_STATUS_NOT_CONVERGED`, and the
/// trajectory is the best that was found. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_solve(
    problem: ProblemHandle,
    options: *const SolverOptionsC,
    report: *mut SolverReportC,
) -> Status {
    call(|| {
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let parts = own.parts();
        let options = self::options("the options", options)?.options()?;
        let mut solver = Fddp::new(parts.assembled()?, options)?;
        if let Some(last) = &parts.solver {
            let nodes = parts.problem.nodes();
            let controls: Vec<&[f64]> = (0..nodes).map(|node| last.control(node)).collect();
            let states: Vec<&[f64]> = (0..=nodes).map(|node| last.state(node)).collect();
            solver.set_trajectory(&states, &controls)?;
        }
        let found = solver.solve()?;
        parts.solver = Some(solver);
        if !report.is_null() {
            *result("the report", report)? = SolverReportC::from(&found);
        }
        if found.is_solved() { Ok(()) } else { Err(unsolved(found.termination)) }
    })
}

fn unsolved(termination: Termination) -> Failure {
    Failure::new(Status::NotConverged, format!("the problem is not solved: {termination}"))
}

/// Copies a part of the trajectory.
unsafe fn copy(
    problem: ProblemHandle,
    node: usize,
    nodes_after: usize,
    (out, len): (*mut f64, usize),
    of: impl FnOnce(&Fddp, usize) -> &[f64],
) -> Status {
    call(|| {
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let parts = own.parts();
        let solver = parts.solver.as_ref();
        let solver =
            solver.ok_or_else(|| Failure::invalid("the problem has no solution yet: solve it first"))?;
        let nodes = parts.problem.nodes() + nodes_after;
        if node >= nodes {
            return Err(Failure::invalid(format!("there is no node {node}; there are {nodes}, from 0")));
        }
        let numbers = of(solver, node);
        Arrays::default().output("the result", out, len, numbers.len())?.copy_from_slice(numbers);
        Ok(())
    })
}

/// The state (q, v) of a node of the solution, nq + nv numbers; node N is the last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_state(
    problem: ProblemHandle,
    node: usize,
    state: *mut f64,
    state_len: usize,
) -> Status {
    copy(problem, node, 1, (state, state_len), Fddp::state)
}

/// The controls of a node of the solution.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_control(
    problem: ProblemHandle,
    node: usize,
    control: *mut f64,
    control_len: usize,
) -> Status {
    copy(problem, node, 0, (control, control_len), Fddp::control)
}

/// The gain K of u = u_k + K (x ⊖ x_k) at a node, controls × 2 nv, row-major.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_gain(
    problem: ProblemHandle,
    node: usize,
    gain: *mut f64,
    gain_len: usize,
) -> Status {
    copy(problem, node, 0, (gain, gain_len), Fddp::gain)
}
