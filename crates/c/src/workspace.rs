//! Workspaces: the memory of the calls of one thread.

use std::sync::Arc;

use robot_dynamics::algorithms::check_rank;
use robot_dynamics::description::Pose;
use robot_dynamics::model::{FrameId, Model, Workspace, check_configuration, check_vector};

use crate::Status;
use crate::arrays::result;
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::{insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel, frame_of};

/// A model with the memory of its algorithms. It serves one call at a time: make one for each thread.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkspaceHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct RobotWorkspace {
    pub(crate) model: Arc<Model>,
    pub(crate) memory: Workspace,
    pub(crate) poses: Vec<Pose>,
    pub(crate) frames: Vec<FrameId>,
    /// Whether M may be singular in a configuration.
    checks_rank: bool,
}

object!(RobotWorkspace, 2, "the workspace");

impl RobotWorkspace {
    pub(crate) fn new(robot: &RobotModel) -> Self {
        let poses = vec![Pose::default(); robot.frames.len()];
        let memory = Workspace::new(&robot.model);
        let checks_rank = !robot.model.is_always_regular();
        Self { memory, poses, frames: robot.frames.clone(), checks_rank, model: Arc::clone(&robot.model) }
    }

    pub(crate) fn frame(&self, frame: u32) -> Result<FrameId, Failure> {
        frame_of(&self.frames, &self.model, frame)
    }

    /// Checks a configuration.
    pub(crate) fn check_q(&self, q: &[f64]) -> Result<(), Failure> {
        Ok(check_configuration(&self.model, q)?)
    }

    /// Checks a vector over the degrees of freedom.
    pub(crate) fn check_v(&self, name: &str, x: &[f64]) -> Result<(), Failure> {
        Ok(check_vector(&self.model, name, x)?)
    }

    /// Refuses a configuration with a singular M.
    pub(crate) fn check_rank(&mut self, q: &[f64]) -> Result<(), Failure> {
        if self.checks_rank {
            check_rank(&self.model, &mut self.memory, q)?;
        }
        Ok(())
    }
}

/// Makes a workspace of a model. Free it with `rd_workspace_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_workspace_new(model: ModelHandle, workspace: *mut WorkspaceHandle) -> Status {
    call(|| {
        let workspace = result("the result `workspace`", workspace)?;
        workspace.id = insert(RobotWorkspace::new(&*shared::<RobotModel>(model.id)?))?;
        Ok(())
    })
}

/// Frees a workspace. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_workspace_free(workspace: WorkspaceHandle) -> Status {
    call(|| remove::<RobotWorkspace>(workspace.id))
}
