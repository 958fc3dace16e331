//! The middle of a variational step: its state, and the terms of the equation there.

use robot_dynamics_core::configuration::manifold::{
    CoordinateRange, coordinate_ranges, quaternion_at, vector_at,
};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::model::Body;
use robot_dynamics_core::{Model, gravity};
use robot_dynamics_number::algebra::V3;

use super::forces::StepForces;
use super::momentum::momentum_and_kinetic_gradient;
use super::retraction::HalfTurn;
use super::workspace::StepWorkspace;

/// The point in a body's frame that a floating joint moves along a straight line.
pub(super) fn center(body: &Body) -> V3<f64> {
    if body.mass > 0.0 { V3::constant(&body.first_moment) * (1.0 / body.mass) } else { V3::zero() }
}

/// Computes `q`, the middle of the step from `q_start` at velocity `v`; `None` if a rotation is too large.
pub(crate) fn place_middle(model: &Model, workspace: &mut StepWorkspace, h: f64) -> Option<()> {
    let StepWorkspace { q, q_start, v, .. } = workspace;
    for (body, CoordinateRange { chart, q: i, v: k }) in model.bodies.iter().zip(coordinate_ranges(model)) {
        match chart {
            Chart::Line => q[i] = q_start[i] + 0.5 * h * v[k],
            Chart::Rotation => {
                let turn = HalfTurn::new(vector_at(v, k), h)?;
                let middle = quaternion_at(q_start, i).times(turn.quaternion());
                q[i..i + 4].copy_from_slice(&middle.to_xyzw());
            }
            Chart::Placement => {
                let (u, w) = (vector_at(v, k), vector_at(v, k + 3));
                let turn = HalfTurn::new(w, h)?;
                let start = quaternion_at(q_start, i + 3);
                let middle = start.times(turn.quaternion());
                // x_m = x₀ + R₀c + ½h R_m(u + ω×c) − R_m c.
                let c = center(body);
                let moved = V3::new(middle.rotate(((u + w.cross(c)) * (0.5 * h) - c).array()));
                let position = vector_at(q_start, i) + V3::new(start.rotate(c.array())) + moved;
                q[i..i + 3].copy_from_slice(&position.array());
                q[i + 3..i + 7].copy_from_slice(&middle.to_xyzw());
            }
        }
    }
    Some(())
}

/// p and F at the middle, and the residual of the equation for v.
pub(crate) fn evaluate_middle(model: &Model, workspace: &mut StepWorkspace, forces: &StepForces<'_>, h: f64) {
    let StepWorkspace { dynamics, q, v, p_start, momentum, slope, gravity: g, held, residual, force, .. } =
        workspace;
    momentum_and_kinetic_gradient(model, dynamics, q, v, momentum, slope);
    gravity(model, dynamics, q, g);
    if forces.dissipation {
        damping(model, v, force);
    } else {
        force.fill(0.0);
    }
    for k in 0..model.nv {
        force[k] = slope[k] - g[k] + held[k] - force[k];
    }
    for (body, CoordinateRange { chart, v: k, .. }) in model.bodies.iter().zip(coordinate_ranges(model)) {
        match chart {
            Chart::Line => residual[k] = p_start[k] + 0.5 * h * force[k] - momentum[k],
            Chart::Rotation => {
                let turn = HalfTurn::new(vector_at(v, k), h).expect("place_middle refused longer turns");
                let wanted = turn.middle_momentum(vector_at(p_start, k), vector_at(force, k), h);
                residual[k..k + 3].copy_from_slice(&(wanted - vector_at(momentum, k)).array());
            }
            Chart::Placement => {
                let turn = HalfTurn::new(vector_at(v, k + 3), h).expect("place_middle refused longer turns");
                let c = center(body);
                let moment = moment_about_center(c, v, momentum, force, k);
                let linear = turn.carry(vector_at(p_start, k)) + vector_at(force, k) * (0.5 * h);
                let start = about_center(c, p_start, k);
                let angular = turn.middle_momentum(start, moment, h) - about_center(c, momentum, k);
                let linear = linear - vector_at(momentum, k);
                residual[k..k + 3].copy_from_slice(&linear.array());
                residual[k + 3..k + 6].copy_from_slice(&(angular + c.cross(linear)).array());
            }
        }
    }
}

/// The angular part of a momentum or force of a floating joint, about c: n − c × f.
pub(super) fn about_center(c: V3<f64>, x: &[f64], k: usize) -> V3<f64> {
    vector_at(x, k + 3) - c.cross(vector_at(x, k))
}

/// The moment on a floating joint about c, at constant velocity of c in world axes rather than body axes:
/// N − c × F + P × u_c. **(MLS §4.2.4)**
pub(super) fn moment_about_center(
    c: V3<f64>,
    v: &[f64],
    momentum: &[f64],
    force: &[f64],
    k: usize,
) -> V3<f64> {
    let velocity = vector_at(v, k) + vector_at(v, k + 3).cross(c);
    about_center(c, force, k) + vector_at(momentum, k).cross(velocity)
}

/// The dissipation that is linear in v.
pub(super) fn damping(model: &Model, v: &[f64], force: &mut [f64]) {
    force.fill(0.0);
    for dof in &model.dofs {
        force[dof.coordinate] += dof.passive.damping * dof.ratio * dof.ratio * v[dof.coordinate];
    }
}
