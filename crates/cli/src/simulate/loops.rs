//! Equalities of the robot's file: closed loops and coupled joints, satisfied at each step.

use std::fmt::Write;

use robot_dynamics::constraints::{
    ConstraintOptions, ConstraintSet, constrained_forward_dynamics, project_position, project_velocity,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Effect, Method};

use super::arguments::Arguments;
use super::setup::Setup;
use super::start::Start;
use crate::failure::{Context, Failure};

/// Tolerance of |φ| at the start \[m or rad\].
const TOLERANCE: f64 = 1e-10;
/// Largest acceleration of an equilibrium \[rad/s² or m/s²\], and the displacement of a start away from it
/// \[rad or m\].
const EQUILIBRIUM_ACCELERATION: f64 = 1e-6;
const DISPLACEMENT: f64 = 0.3;

/// The active equalities if the method satisfies them exactly. Method `mujoco` has soft equalities instead.
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

/// Projects the start onto the equalities. A default start in equilibrium is displaced first.
///
/// # Errors
///
/// The projection does not converge.
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
            && motion.acceleration.amax() < EQUILIBRIUM_ACCELERATION
        {
            start.q[joint.q_index] += DISPLACEMENT;
            let _ =
                write!(start.chosen, ", with `{}` displaced by {DISPLACEMENT} from equilibrium", joint.name);
        }
    }
    project_position(model, workspace, set, &options, TOLERANCE, &mut start.q)
        .context("the equalities of the file at the start")?;
    project_velocity(model, workspace, set, &options, &start.q, &mut start.v)
        .context("the equalities of the file at the start")?;
    let moved = before.iter().zip(&start.q).any(|(a, b)| (a - b).abs() > 1e-9);
    if moved {
        start.chosen += ", projected onto the equalities of the file";
    }
    Ok(())
}
