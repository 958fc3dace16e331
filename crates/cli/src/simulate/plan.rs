//! The choices for a run.

use robot_dynamics::constraints::ConstraintSet;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::steps_in;

use super::arguments::Arguments;
use super::drive::{self, ActuatorControls};
use super::ground::Floor;
use super::setup::Setup;
use super::start::Start;
use super::{loops, method};
use crate::failure::Failure;
use crate::joint_values::{JointNumbers, set};
use crate::table::short;

/// Largest number of steps, which only a mistyped step exceeds.
const MAX_STEPS: f64 = 1e9;

/// The choices for a run, from the arguments and the robot.
pub(crate) struct RunPlan {
    pub steps: usize,
    pub setup: Setup,
    pub loops: Option<ConstraintSet>,
    pub start: Start,
    pub floor: Option<Floor>,
    pub drive: Option<ActuatorControls>,
    /// Whether a controller holds the robot at the goal.
    pub is_held: bool,
    pub goal: Vec<f64>,
}

impl RunPlan {
    pub(crate) fn choose(arguments: &Arguments, model: &Model) -> Result<Self, Failure> {
        if model.nv() == 0 {
            return Err(Failure::new(format!(
                "{}: the robot has no degree of freedom to simulate (--floating-base adds six)",
                arguments.robot.shown()
            )));
        }
        method::check(arguments)?;
        let steps = steps(arguments)?;
        let is_held = arguments.hold || !arguments.goal.is_empty();
        let setup = Setup::choose(arguments, model, is_held)?;
        let loops = loops::choose(arguments, model, &setup)?;
        let mut start = Start::choose(model, &arguments.pose, &arguments.velocity, !is_held)?;
        if let Some(loops) = &loops {
            loops::close(model, loops, &mut start, !is_held && arguments.pose.is_empty())?;
        }
        let floor = Floor::choose(arguments, model, &setup, &mut start)?;
        let drive = drive::choose(arguments, model, &setup, &start)?;
        let mut goal = start.q.clone();
        set(model, "--goal", &arguments.goal, JointNumbers::Configuration, &mut goal)?;
        Ok(Self { steps, setup, loops, start, floor, drive, is_held, goal })
    }
}

/// The whole number of steps that is nearest to the duration, at least one.
fn steps(arguments: &Arguments) -> Result<usize, Failure> {
    let steps = arguments.duration / arguments.dt;
    if steps > MAX_STEPS {
        let [duration, step, steps] = [arguments.duration, arguments.dt, steps].map(short);
        return Err(Failure::new(format!(
            "{duration} s in steps of {step} s are {steps} steps, at most {MAX_STEPS:e} are allowed; take a longer \
             --dt or a shorter --duration"
        )));
    }
    let nearest = steps_in(arguments.duration, arguments.dt);
    nearest.map(|steps| steps.max(1)).map_err(|error| Failure::new(error.to_string()))
}
