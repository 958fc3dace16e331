//! Optimal control: problems as plain data, their solutions, and model predictive control.

pub mod mpc;
pub mod solution;

use std::ffi::c_char;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::control::optimal::{
    ActuationMatrix, CenterOfMassResidual, ControlBounds, ControlResidual, Cost, Fddp,
    FramePlacementResidual, FrameTranslationResidual, FrameVelocityResidual, LeastSquares, Problem,
    SimulationStep, SmoothStep, StateResidual, StateSpace, Weights,
};
use robot_dynamics::model::{FrameId, Model};
use robot_dynamics::simulation::Integrator;

use crate::Status;
use crate::arrays::{Arrays, result, text};
use crate::calls::call;
use crate::constraints::pose_of;
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel, frame_of};
use crate::simulation::{RobotSimulation, SimulationHandle};

/// An optimal control problem. The state x is (q, v), the controls u are torques or controls of actuators.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProblemHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

/// The kinds of cost terms, ½ Σ weight · residual².
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostKindC {
    /// x ⊖ target; the target is (q, v), with 2 nv weights.
    State = 0,
    /// u − target, with a weight for each control.
    Control = 1,
    /// The position of a frame relative to 3 numbers, with 3 weights.
    FramePosition = 2,
    /// The pose of a frame relative to 12 numbers, with 6 weights: linear, then angular.
    FramePose = 3,
    /// The velocity of a frame's origin along the world's axes, relative to 6 numbers, with 6 weights.
    FrameVelocity = 4,
    /// The position of the centre of mass relative to 3 numbers, with 3 weights.
    CenterOfMass = 5,
}

/// The cost of some nodes; the last state is node N.
struct Term {
    nodes: Range<usize>,
    squares: LeastSquares,
}

/// Parts of it are not for several threads at once, so a lock surrounds them.
pub(crate) struct OptimalProblem(Mutex<Parts>);

pub(crate) struct Parts {
    model: Arc<Model>,
    frames: Vec<FrameId>,
    problem: Problem,
    terms: Vec<Term>,
    /// The last solution.
    solver: Option<Fddp>,
}

object!(OptimalProblem, 11, "the problem");

impl OptimalProblem {
    fn parts(&mut self) -> &mut Parts {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Parts {
    /// The cost at a node, as the terms that act there.
    fn cost_at(&self, node: usize) -> Cost {
        let mut cost = Cost::new();
        for term in self.terms.iter().filter(|term| term.nodes.contains(&node)) {
            cost.add_term(term.squares.clone());
        }
        cost
    }

    /// The ranges of nodes with equal costs, before the last state.
    fn phases(&self) -> Vec<Range<usize>> {
        let last = self.problem.nodes();
        let ends = self.terms.iter().flat_map(|term| [term.nodes.start, term.nodes.end]);
        let mut cuts: Vec<usize> = ends.chain([0, last]).map(|cut| cut.min(last)).collect();
        cuts.sort_unstable();
        cuts.dedup();
        cuts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }

    /// The problem with its costs.
    fn assembled(&self) -> Result<Problem, Failure> {
        let mut problem = self.problem.clone();
        for nodes in self.phases() {
            problem.set_running_cost(nodes.clone(), self.cost_at(nodes.start))?;
        }
        problem.set_terminal_cost(self.cost_at(self.problem.nodes()))?;
        Ok(problem)
    }
}

/// The most nodes of a problem.
const MOST_NODES: usize = 1 << 20;

/// Refuses numbers of nodes that memory does not have.
fn check_nodes(nodes: usize) -> Result<(), Failure> {
    if nodes <= MOST_NODES {
        return Ok(());
    }
    Err(Failure::invalid(format!("there are {nodes} nodes; there must be at most {MOST_NODES}")))
}

fn store(model: &Arc<Model>, frames: &[FrameId], problem: Problem) -> Result<u64, Failure> {
    let (model, frames) = (Arc::clone(model), frames.to_vec());
    let parts = Parts { model, frames, problem, terms: Vec::new(), solver: None };
    insert(OptimalProblem(Mutex::new(parts)))
}

/// Makes a problem of N nodes from steps without contact, by an integrator such as `rk4`. The controls are
/// the torques of the driven coordinates. `state` is x₀ = (q, v), nq + nv numbers. N is at most 2²⁰. Free it
/// with `rd_problem_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_new(
    model: ModelHandle,
    integrator: *const c_char,
    dt: f64,
    dissipation: i32,
    nodes: usize,
    state: *const f64,
    state_len: usize,
    problem: *mut ProblemHandle,
) -> Status {
    call(|| {
        let out = result("the result `problem`", problem)?;
        let robot = shared::<RobotModel>(model.id)?;
        let integrator: Integrator = text("the integrator", integrator)?.parse()?;
        let state = Arrays::default().any("the state", state, state_len)?;
        check_nodes(nodes)?;
        let step = SmoothStep::new(Arc::clone(&robot.model), integrator, dt)?
            .with_actuation(ActuationMatrix::actuated(&robot.model))?
            .with_dissipation(dissipation != 0);
        out.id = store(&robot.model, &robot.frames, Problem::new(step, state, nodes)?)?;
        Ok(())
    })
}

/// Makes a problem of N nodes from the steps of a simulation, with contact, stops and friction. The controls
/// are the torques of the driven coordinates, or the controls of the actuators if `actuators` is not 0.
/// `state` is x₀ = (q, v). N is at most 2²⁰.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_from_simulation(
    simulation: SimulationHandle,
    actuators: i32,
    nodes: usize,
    state: *const f64,
    state_len: usize,
    problem: *mut ProblemHandle,
) -> Status {
    call(|| {
        let out = result("the result `problem`", problem)?;
        let own = shared::<RobotSimulation>(simulation.id)?;
        let (simulation, frames) = own.parts();
        let state = Arrays::default().any("the state", state, state_len)?;
        check_nodes(nodes)?;
        let step = SimulationStep::new(simulation);
        let step = if actuators != 0 {
            step.with_actuators()?
        } else {
            step.with_actuation(ActuationMatrix::actuated(simulation.model()))?
        };
        out.id = store(simulation.shared_model(), frames, Problem::new(step, state, nodes)?)?;
        Ok(())
    })
}

/// Frees a problem. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_problem_free(problem: ProblemHandle) -> Status {
    call(|| remove::<OptimalProblem>(problem.id))
}

/// The number of controls of each node; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_problem_control_count(problem: ProblemHandle) -> usize {
    crate::calls::query(0, || Ok(exclusive::<OptimalProblem>(problem.id)?.parts().problem.controls(0)))
}

/// Adds a cost term of a kind of `rd_cost_kind` to the nodes from `first` to `end` − 1; node N is the last
/// state. `frame` counts only for frames. Costs of the controls end at node N − 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_add_cost(
    problem: ProblemHandle,
    kind: u32,
    first: usize,
    end: usize,
    frame: u32,
    target: *const f64,
    target_len: usize,
    weights: *const f64,
    weights_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let parts = own.parts();
        let mut arrays = Arrays::default();
        let target = arrays.any("the target", target, target_len)?;
        let weights = arrays.any("the weights", weights, weights_len)?;
        let nodes = parts.problem.nodes();
        let most = if kind == CostKindC::Control as u32 { nodes } else { nodes + 1 };
        if first >= end || end > most {
            return Err(Failure::invalid(format!(
                "the nodes {first} to {end} - 1 are not among those of the term, 0 to {most} - 1"
            )));
        }
        let squares = squares(parts, kind, frame, target, weights)?;
        parts.terms.push(Term { nodes: first..end, squares });
        Ok(())
    })
}

/// A cost term.
fn squares(
    parts: &Parts,
    kind: u32,
    frame: u32,
    target: &[f64],
    weights: &[f64],
) -> Result<LeastSquares, Failure> {
    let model = || Arc::clone(&parts.model);
    let frame = || frame_of(&parts.frames, &parts.model, frame);
    let weights = Weights::from(weights);
    Ok(match kind {
        0 => LeastSquares::new(StateResidual::new(&StateSpace::robot(model()), target)?, weights)?,
        1 => {
            let controls = parts.problem.controls(0);
            if target.len() != controls {
                let count = target.len();
                return Err(Failure::invalid(format!(
                    "the target has {count} numbers; there are {controls} controls"
                )));
            }
            LeastSquares::new(ControlResidual::new(target)?, weights)?
        }
        2 => LeastSquares::new(FrameTranslationResidual::new(model(), frame()?, fixed(target)?)?, weights)?,
        3 => {
            let pose = pose_of(&fixed::<12>(target)?);
            LeastSquares::new(FramePlacementResidual::new(model(), frame()?, pose)?, weights)?
        }
        4 => {
            let axes = ReferenceFrame::LocalWorldAligned;
            LeastSquares::new(FrameVelocityResidual::new(model(), frame()?, axes, fixed(target)?)?, weights)?
        }
        5 => LeastSquares::new(CenterOfMassResidual::new(model(), fixed(target)?)?, weights)?,
        _ => return Err(Failure::invalid(format!("there is no kind {kind} of costs; there are 0 to 5"))),
    })
}

fn fixed<const N: usize>(target: &[f64]) -> Result<[f64; N], Failure> {
    let wrong = |_| Failure::invalid(format!("the target has {} numbers; it needs {N}", target.len()));
    target.try_into().map_err(wrong)
}

/// Removes all cost terms, to add those of another target.
#[unsafe(no_mangle)]
pub extern "C" fn rd_problem_clear_costs(problem: ProblemHandle) -> Status {
    call(|| {
        exclusive::<OptimalProblem>(problem.id)?.parts().terms.clear();
        Ok(())
    })
}

/// Bounds the controls of the nodes from `first` to `end` − 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_set_control_bounds(
    problem: ProblemHandle,
    first: usize,
    end: usize,
    lower: *const f64,
    lower_len: usize,
    upper: *const f64,
    upper_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let mut arrays = Arrays::default();
        let lower = arrays.any("the lower bounds", lower, lower_len)?;
        let upper = arrays.any("the upper bounds", upper, upper_len)?;
        Ok(own.parts().problem.set_control_bounds(first..end, ControlBounds::new(lower, upper)?)?)
    })
}

/// Sets x₀ = (q, v).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_problem_set_initial_state(
    problem: ProblemHandle,
    state: *const f64,
    state_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<OptimalProblem>(problem.id)?;
        let state = Arrays::default().any("the state", state, state_len)?;
        Ok(own.parts().problem.set_initial_state(state)?)
    })
}
