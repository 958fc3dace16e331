//! The handles of random calls: valid, null, freed, of another kind, and random ones.

use robot_dynamics_c::Status;
use robot_dynamics_c::batch::*;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::identification::*;
use robot_dynamics_c::load::rd_model_free;
use robot_dynamics_c::model::ModelHandle;
use robot_dynamics_c::optimal::mpc::*;
use robot_dynamics_c::optimal::*;
use robot_dynamics_c::simulation::snapshots::*;
use robot_dynamics_c::simulation::*;
use robot_dynamics_c::workspace::*;

use crate::memory::*;

impl Fuzz {
    /// A handle of a kind, usually of an object of this call's robot.
    fn handle(&mut self, kind: usize) -> u64 {
        match self.below(40) {
            0 => 0,
            1 if !self.freed.is_empty() => {
                let k = self.below(self.freed.len());
                self.freed[k]
            }
            2 => {
                let other = 1 + self.below(KINDS - 1);
                self.pick(other, false).unwrap_or(1)
            }
            3 => self.bits(),
            4 => (kind as u64) << 56 | self.bits() >> 8,
            5 => self.pick(kind, false).unwrap_or(0) ^ 1 << self.below(64),
            6 => self.pick(kind, false).unwrap_or(0),
            _ => self.pick(kind, true).unwrap_or(0),
        }
    }

    fn pick(&mut self, kind: usize, own: bool) -> Option<u64> {
        let robot = self.robot;
        let fits = move |entry: &&(u64, usize)| !own || entry.1 == robot;
        let count = self.live[kind].iter().filter(fits).count();
        let k = self.below(count);
        self.live[kind].iter().filter(fits).nth(k).map(|entry| entry.0)
    }

    /// Keeps a new object, and frees an old one if there are many.
    pub(crate) fn keep(&mut self, kind: usize, status: Status, id: u64) -> Status {
        if status == Status::Ok {
            assert_eq!(id >> 56, kind as u64, "the handle has its kind");
            if kind == MODEL {
                // A model from a text is of no robot of this program.
                self.freed.push(id);
                return rd_model_free(ModelHandle { id });
            }
            self.live[kind].push((id, self.robot));
            if self.live[kind].len() > MOST {
                // The models and workspaces of the robots stay.
                let first = if kind == WORKSPACE { 4 } else { 0 };
                let (old, _) = self.live[kind].remove(first);
                free(kind, old);
                self.freed.push(old);
                let many = self.freed.len().saturating_sub(64);
                self.freed.drain(..many);
            }
        }
        status
    }

    /// Frees an object, or a handle that names none.
    pub(crate) fn free_any(&mut self) -> Status {
        let kind = 2 + self.below(KINDS - 2);
        let last = self.live[kind].len();
        let first = if kind == WORKSPACE { 4 } else { 0 };
        if last > first && self.chance(30) {
            let k = first + self.below(last - first);
            let (id, _) = self.live[kind].remove(k);
            assert_eq!(free(kind, id), Status::Ok, "{}", crate::common::message());
            self.freed.push(id);
            return Status::Ok;
        }
        let k = self.below(self.freed.len());
        let id = self.freed.get(k).copied().unwrap_or(0);
        free(kind, id)
    }

    pub(crate) fn free_all(&mut self) {
        for kind in BATCH..KINDS {
            for (id, _) in std::mem::take(&mut self.live[kind]) {
                assert_eq!(free(kind, id), Status::Ok, "{}", crate::common::message());
            }
        }
        for (id, _) in self.live[WORKSPACE].drain(..).skip(4) {
            assert_eq!(free(WORKSPACE, id), Status::Ok, "{}", crate::common::message());
        }
    }

    pub(crate) fn model(&mut self) -> ModelHandle {
        ModelHandle { id: self.handle(MODEL) }
    }
    pub(crate) fn workspace(&mut self) -> WorkspaceHandle {
        WorkspaceHandle { id: self.handle(WORKSPACE) }
    }
    pub(crate) fn batch(&mut self) -> BatchHandle {
        BatchHandle { id: self.handle(BATCH) }
    }
    pub(crate) fn constraints(&mut self) -> ConstraintsHandle {
        ConstraintsHandle { id: self.handle(CONSTRAINTS) }
    }
    pub(crate) fn simulation(&mut self) -> SimulationHandle {
        SimulationHandle { id: self.handle(SIMULATION) }
    }
    pub(crate) fn snapshot(&mut self) -> SnapshotHandle {
        SnapshotHandle { id: self.handle(SNAPSHOT) }
    }
    pub(crate) fn torque(&mut self) -> ComputedTorqueHandle {
        ComputedTorqueHandle { id: self.handle(TORQUE) }
    }
    pub(crate) fn task(&mut self) -> TaskControlHandle {
        TaskControlHandle { id: self.handle(TASK) }
    }
    pub(crate) fn observer(&mut self) -> MomentumObserverHandle {
        MomentumObserverHandle { id: self.handle(OBSERVER) }
    }
    pub(crate) fn record(&mut self) -> MotionRecordHandle {
        MotionRecordHandle { id: self.handle(RECORD) }
    }
    pub(crate) fn problem(&mut self) -> ProblemHandle {
        ProblemHandle { id: self.handle(PROBLEM) }
    }
    pub(crate) fn mpc(&mut self) -> MpcHandle {
        MpcHandle { id: self.handle(MPC) }
    }
}

/// Frees an object of a kind.
fn free(kind: usize, id: u64) -> Status {
    match kind {
        WORKSPACE => rd_workspace_free(WorkspaceHandle { id }),
        BATCH => rd_batch_free(BatchHandle { id }),
        CONSTRAINTS => rd_constraints_free(ConstraintsHandle { id }),
        SIMULATION => rd_simulation_free(SimulationHandle { id }),
        SNAPSHOT => rd_snapshot_free(SnapshotHandle { id }),
        TORQUE => rd_computed_torque_free(ComputedTorqueHandle { id }),
        TASK => rd_task_control_free(TaskControlHandle { id }),
        OBSERVER => rd_momentum_observer_free(MomentumObserverHandle { id }),
        RECORD => rd_motion_record_free(MotionRecordHandle { id }),
        PROBLEM => rd_problem_free(ProblemHandle { id }),
        MPC => rd_mpc_free(MpcHandle { id }),
        _ => rd_model_free(ModelHandle { id: 0 }),
    }
}
