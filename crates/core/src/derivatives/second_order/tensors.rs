//! Tensors of second derivatives, from tangents of the first derivatives.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::lanes::{LANES, Map, Point, SecondOrderWorkspace, Tangent, run_lanes};
use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::derivatives::forward_dynamics::ForwardDynamicsDerivativesKernel;
use crate::derivatives::inverse_dynamics::InverseDynamicsDerivativesKernel;

/// nv×nv×nv each: row-major, the component of f first.
pub(super) struct Tensors<'a> {
    pub position_position: &'a mut [f64],
    pub position_velocity: &'a mut [f64],
    pub velocity_velocity: &'a mut [f64],
    pub position_input: &'a mut [f64],
}

impl Tensors<'_> {
    #[track_caller]
    fn check(&self, nv: usize) {
        let tensors =
            [&self.position_position, &self.position_velocity, &self.velocity_velocity, &self.position_input];
        for tensor in tensors {
            check_length("the second derivatives", tensor.len(), nv * nv * nv);
        }
    }
}

/// Writes the four tensors.
#[track_caller]
pub(super) fn second_derivatives(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    point: &Point<'_>,
    tensors: Tensors<'_>,
) {
    point.check(model, workspace);
    let nv = model.nv;
    tensors.check(nv);
    let Tensors { position_position, position_velocity, velocity_velocity, position_input } = tensors;
    workspace.load(point);
    workspace.allocate_squares(model);
    position_position.fill(0.0);
    velocity_velocity.fill(0.0);
    for first in (0..nv).step_by(LANES) {
        let count = workspace.set_position_lanes(model, point.q, first);
        workspace.differentiate(model, point.map);
        let [by_position, by_velocity, by_input] = &workspace.matrices;
        for lane in 0..count {
            let j = first + lane;
            add_symmetric(nv, by_position, lane, j, position_position);
            for (tensor, matrix) in [(&mut *position_velocity, by_velocity), (&mut *position_input, by_input)]
            {
                for (i, row) in matrix[..nv * nv].chunks_exact(nv).enumerate() {
                    for (to, entry) in tensor[(i * nv + j) * nv..][..nv].iter_mut().zip(row) {
                        *to = entry.gradient[lane];
                    }
                }
            }
        }
    }
    for first in (0..nv).step_by(LANES) {
        let count = workspace.set_velocity_lanes(nv, first);
        workspace.differentiate(model, point.map);
        for lane in 0..count {
            add_symmetric(nv, &workspace.matrices[1], lane, first + lane, velocity_velocity);
        }
    }
}

/// Adds ½ D_j of entry (i, k) to the tensor's entries (i, j, k) and (i, k, j).
fn add_symmetric(nv: usize, matrix: &[Tangent], lane: usize, j: usize, tensor: &mut [f64]) {
    for i in 0..nv {
        for k in 0..nv {
            let half = 0.5 * matrix[i * nv + k].gradient[lane];
            tensor[(i * nv + j) * nv + k] += half;
            tensor[(i * nv + k) * nv + j] += half;
        }
    }
}

impl SecondOrderWorkspace {
    fn allocate_squares(&mut self, model: &Model) {
        let nv = model.nv;
        self.lanes.allocate_matrices(model);
        for matrix in &mut self.matrices {
            if matrix.len() < nv * nv {
                matrix.resize(nv * nv, Tangent::zero());
            }
        }
    }

    /// The first derivatives along the lanes: by q, by v and by the input.
    fn differentiate(&mut self, model: &Model, map: Map) {
        let square = model.nv * model.nv;
        let [by_position, by_velocity, by_input] = &mut self.matrices;
        let (by_position, by_velocity) = (&mut by_position[..square], &mut by_velocity[..square]);
        let by_input = &mut by_input[..square];
        let (q, v, wrenches) = (&self.q[..], &self.v[..], &self.wrenches[..]);
        let tree = &mut self.lanes.tree;
        match map {
            Map::Inverse => {
                let a = &self.input[..];
                run_lanes(
                    tree,
                    InverseDynamicsDerivativesKernel { model, q, v, a, wrenches, by_position, by_velocity },
                );
                run_lanes(tree, CompositeBodies { model, q, mass: by_input, entries: Entries::All });
            }
            Map::Forward => {
                let (tau, by_force) = (&self.input[..], by_input);
                run_lanes(
                    tree,
                    ForwardDynamicsDerivativesKernel {
                        model,
                        q,
                        v,
                        tau,
                        wrenches,
                        by_position,
                        by_velocity,
                        by_force,
                    },
                );
            }
        }
    }
}
