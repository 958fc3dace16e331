//! Equalities of the robot's file: closed loops and coupled joints, held by each step.

use std::fmt::Write;
use std::ops::ControlFlow;

use dynamics::Integrator;
use multibody::{
    ConstrainedSimulation, ConstraintOptions, ConstraintSet, Controller, Event, Model, Moment, Workspace,
    ZeroTorque, constrained_forward_dynamics, project_position, project_velocity,
};

use super::Arguments;
use super::method::Method;
use super::run::Ran;
use super::start::Start;
use crate::failure::{Context, Failure};

/// |φ| of a start \[m or rad\].
const TOLERANCE: f64 = 1e-10;
/// Accelerations of an equilibrium \[rad/s² or m/s²\], and how far a start is turned away from it \[rad or m\].
const STILL: f64 = 1e-6;
const AWAY: f64 = 0.3;

/// The active equalities, where there are some and the method does not hold them by itself.
///
/// # Errors
/// A method was asked for that does not hold them.
pub(crate) fn choose(arguments: &Arguments, model: &Model) -> Result<Option<ConstraintSet>, Failure> {
    let set = ConstraintSet::from_equalities(model).context(arguments.robot.shown())?;
    // The law of MuJoCo's steps has them among its constraints.
    if set.is_empty() || arguments.integrator == Some(Method::Mujoco) {
        return Ok(None);
    }
    match arguments.method() {
        Method::Fixed(_) | Method::Implicit => Ok(Some(set)),
        method => {
            let names: Vec<&str> = set.constraints().map(|(name, _)| name).collect();
            Err(Failure::new(format!(
                "--integrator {method} does not hold the equalities of the file ({}); implicit, rk4, variational-midpoint and \
                 variational-yoshida4 do",
                names.join(", ")
            )))
        }
    }
}

/// Puts the start onto the equalities; one that was not asked for and would not move is turned a little first.
///
/// # Errors
/// They cannot be fulfilled from there.
pub(crate) fn close(
    model: &Model,
    set: &ConstraintSet,
    start: &mut Start,
    must_move: bool,
) -> Result<(), Failure> {
    let (workspace, options) = (&mut Workspace::new(model), ConstraintOptions::of_files());
    let before = start.q.clone();
    let rest = vec![0.0; model.nv()];
    if must_move && start.v == rest {
        project_position(model, workspace, set, &options, TOLERANCE, &mut start.q)
            .context("the equalities of the file at the start")?;
        let motion = constrained_forward_dynamics(model, workspace, set, &options, &start.q, &rest, &rest);
        let first = model.joints().iter().find(|joint| joint.nv == 1);
        if let (Ok(motion), Some(joint)) = (motion, first)
            && motion.acceleration.amax() < STILL
        {
            start.q[joint.q_index] += AWAY;
            let _ = write!(start.chosen, ", then `{}` by {AWAY}, as that is an equilibrium", joint.name);
        }
    }
    project_position(model, workspace, set, &options, TOLERANCE, &mut start.q)
        .context("the equalities of the file at the start")?;
    project_velocity(model, workspace, set, &options, &start.q, &mut start.v)
        .context("the equalities of the file at the start")?;
    let moved = before.iter().zip(&start.q).any(|(a, b)| (a - b).abs() > 1e-9);
    if moved {
        start.chosen += ", moved onto the equalities of the file";
    }
    Ok(())
}

/// By steps of `--step` that hold the equalities.
pub(crate) fn run(
    (arguments, integrator): (&Arguments, Integrator),
    (model, set): (&Model, &ConstraintSet),
    start: &Start,
    steps: usize,
    controller: Option<&mut dyn Controller>,
    observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    mut limits: Vec<Event<'_>>,
) -> Ran {
    let simulation = ConstrainedSimulation::new(model, set, arguments.step)
        .with_options(ConstraintOptions { integrator, ..ConstraintOptions::of_files() })
        .with_dissipation(arguments.has_damping())
        .with_samples_every(0);
    let mut none = ZeroTorque;
    let controller = controller.unwrap_or(&mut none);
    match simulation.run_with_events(&start.q, &start.v, steps, controller, &mut limits, observer) {
        Ok(run) => Ran { run: run.motion, adaptive: None, failure: None },
        Err(failure) => {
            Ran { run: failure.until.motion, adaptive: None, failure: Some(failure.error.to_string()) }
        }
    }
}
