//! Limits of the lengths of spatial tendons.
//!
//! The length ℓ(q) of a path and its row ∂ℓ̇/∂v need the placement of the bodies. Lengths are measured at the
//! start and at the end of a step, and the rows are those at the end. The force that a limit exerted in the
//! last step acts along the row at the middle of the step, where its work is f Δℓ.

use std::sync::Arc;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_core::{Model, Workspace};

use super::impulses::Impulses;
use super::joints::Joints;
use super::measured::Measured;
use crate::placement::Placement;

clone_in_place! {
    /// The bounded paths of a robot.
    #[derive(Debug)]
    pub(super) struct PathStops {
        placement: Placement,
        /// Each path with its row among those of the joints.
        paths: Arc<[(TendonPath, usize)]>,
        /// Derivatives of a length by all coordinates.
        derivatives: Vec<f64>,
        /// ℓ of each path at the start and at the end of a step.
        start: Vec<f64>,
        end: Vec<f64>,
    }
}

impl PathStops {
    pub(super) fn new(model: &Model, joints: &Joints) -> Self {
        let mut all = TendonPath::all(model).into_iter().map(Some).collect::<Vec<_>>();
        let bounded = joints.path_rows().filter_map(|(row, path)| Some((all[path].take()?, row)));
        let paths: Arc<[_]> = bounded.collect();
        let lengths = vec![0.0; paths.len()];
        Self {
            placement: Placement::new(model),
            derivatives: vec![0.0; model.nv],
            start: lengths.clone(),
            end: lengths,
            paths,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Removes all paths.
    pub(super) fn clear(&mut self) {
        self.paths = Arc::new([]);
        self.start.clear();
        self.end.clear();
    }

    /// Measures the lengths at the start of a step.
    pub(super) fn measure_start(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        let Self { placement, paths, start, .. } = self;
        measure(model, workspace, (placement, paths), q, start);
    }

    /// Measures the lengths at the end of a step.
    pub(super) fn measure_end(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        let Self { placement, paths, end, .. } = self;
        measure(model, workspace, (placement, paths), q, end);
    }

    /// Measures the lengths at the end of a step, and evaluates the rows there.
    pub(super) fn turn(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        impulses: &mut Impulses,
    ) {
        self.measure_end(model, workspace, q);
        let Self { placement, paths, derivatives, .. } = self;
        for (path, row) in paths.iter() {
            path.length_and_row(model, placement, derivatives);
            impulses.set_row(*row, derivatives);
        }
    }

    /// Adds the forces of these limits in the last step, along their rows at q.
    pub(super) fn carry(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        impulses: &Impulses,
        forces: &mut [f64],
    ) {
        if self.paths.iter().all(|(_, row)| impulses.carried(*row) == 0.0) {
            return;
        }
        let Self { placement, paths, derivatives, .. } = self;
        placement.set(model, workspace, q);
        for (path, row) in paths.iter() {
            let force = impulses.carried(*row);
            if force != 0.0 {
                path.length_and_row(model, placement, derivatives);
                forces.iter_mut().zip(&*derivatives).for_each(|(sum, factor)| *sum += force * factor);
            }
        }
    }

    pub(super) fn at_start<'a>(&'a self, q: &'a [f64]) -> Measured<'a> {
        Measured { q, lengths: &self.start }
    }

    pub(super) fn at_end<'a>(&'a self, q: &'a [f64]) -> Measured<'a> {
        Measured { q, lengths: &self.end }
    }

    /// Δℓ of the path with this row, from the start to the end of the step.
    pub(super) fn change_along(&self, row: usize) -> Option<f64> {
        let number = self.paths.iter().position(|(_, own)| *own == row)?;
        Some(self.end[number] - self.start[number])
    }
}

fn measure(
    model: &Model,
    workspace: &mut Workspace,
    (placement, paths): (&mut Placement, &[(TendonPath, usize)]),
    q: &[f64],
    lengths: &mut [f64],
) {
    if !paths.is_empty() {
        placement.set(model, workspace, q);
        lengths.iter_mut().zip(paths).for_each(|(length, (path, _))| *length = path.length(placement));
    }
}
