//! Snapshots of simulations.

use robot_dynamics::simulation::Snapshot;

use crate::Status;
use crate::arrays::result;
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};

use super::{RobotSimulation, SimulationHandle};

/// The complete changing state of a simulation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SnapshotHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct SimulationSnapshot(Snapshot);

object!(SimulationSnapshot, 6, "the snapshot");

/// Copies the complete changing state. Free the snapshot with `rd_snapshot_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_snapshot(
    simulation: SimulationHandle,
    snapshot: *mut SnapshotHandle,
) -> Status {
    call(|| {
        let snapshot = result("the result `snapshot`", snapshot)?;
        let own = shared::<RobotSimulation>(simulation.id)?;
        snapshot.id = insert(SimulationSnapshot(own.simulation.snapshot()))?;
        Ok(())
    })
}

/// Restores a snapshot of this simulation, bit for bit.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_restore(simulation: SimulationHandle, snapshot: SnapshotHandle) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        let snapshot = shared::<SimulationSnapshot>(snapshot.id)?;
        if !own.simulation.fits(&snapshot.0) {
            return Err(Failure::new(Status::InvalidHandle, "the snapshot belongs to another simulation"));
        }
        own.simulation.restore(&snapshot.0);
        Ok(())
    })
}

/// Frees a snapshot. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_snapshot_free(snapshot: SnapshotHandle) -> Status {
    call(|| remove::<SimulationSnapshot>(snapshot.id))
}
