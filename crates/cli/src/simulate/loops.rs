//! Equalities of the robot's file: closed loops and coupled joints, held by each step.

use std::fmt::Write;

use multibody::simulator::{Effect, Method};
use multibody::{
    ConstraintOptions, ConstraintSet, Model, Workspace, constrained_forward_dynamics, project_position,
    project_velocity,
};

use super::Arguments;
use super::setup::Setup;
use super::start::Start;
use crate::failure::{Context, Failure};

/// |φ| of a start \[m or rad\].
const TOLERANCE: f64 = 1e-10;
/// Accelerations of an equilibrium \[rad/s² or m/s²\], and how far a start is turned away from it \[rad or m\].
const STILL: f64 = 1e-6;
const AWAY: f64 = 0.3;

/// The active equalities, where the method holds them exactly; MuJoCo's law lets them yield.
pub(crate) fn choose(
    arguments: &Arguments,
    model: &Model,
    setup: &Setup,
) -> Result<Option<ConstraintSet>, Failure> {
    if !setup.acts(Effect::Equalities) || setup.method() == Method::Mujoco {
        return Ok(None);
    }
    ConstraintSet::from_equalities(model).map(Some).context(arguments.robot.shown())
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
