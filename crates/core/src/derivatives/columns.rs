//! Per-DoF terms of the derivatives: an outward sweep and an inward sweep.

use robot_dynamics_number::algebra::V3;
use robot_dynamics_number::{Scalar, View};

use crate::Model;
use crate::algorithms::coriolis::Branch;
use crate::kinematics::shifts::{pass_flow, pass_inertia, pass_inward, pass_outward};
use crate::kinematics::world_frame::{
    add_composite, force_cross, inertia_in_world, momentum_of, motion_cross,
};
use crate::kinematics::wrench::{FrameWrench, on_body};
use crate::model::WORLD;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::MassFlux;
use crate::spatial::motion::MotionVector;
use crate::workspace::derivatives::DerivativeBuffers;
use crate::workspace::motion_derivatives::MotionDerivatives;
use crate::workspace::tree::{BodyBuffers, DofBuffers, Inertias, TreeMemory, WorldFrameBuffers};

/// The outward sweep: velocities V, accelerations A, each DoF's [`MotionDerivatives`], and each body's
/// inertia, 2B and force. Reads the placements and DoFs in the inertial frame, `tree.dofs.v` and
/// `tree.dofs.a`.
#[inline(always)]
pub(super) fn sweep_out<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, ground: [f64; 3]) {
    let world_rate = MotionVector { linear: V3::from_f64(ground), angular: V3::zero() };
    let n = model.bodies.len();
    let TreeMemory {
        dofs: DofBuffers { v, a, .. },
        world: WorldFrameBuffers { column, pose: world, levers, twist, twist_rate, flow, .. },
        bodies: BodyBuffers { force, .. },
        inertias: Inertias { composite, .. },
        derivatives,
        ..
    } = tree;
    let (bodies, world) = (&model.bodies[..n], &world[..n]);
    let (twists, rates) = (&mut twist[..n], &mut twist_rate[..n]);
    let (flows, forces, inertias) = (&mut flow[..n], &mut force[..n], &mut composite[..n]);
    for i in 0..n {
        let body = &bodies[i];
        let (mut parent_twist, mut parent_rate) = if body.parent == WORLD {
            (MotionVector::zero(), world_rate)
        } else {
            (twists[body.parent], rates[body.parent])
        };
        if body.shifts_reference_point {
            pass_outward(body, levers, &mut parent_twist);
            pass_outward(body, levers, &mut parent_rate);
            derivatives.paths.seat(body.dof).0.lever = levers[body.point].array();
        }
        let dofs = body.dof..body.dof + body.motion.nv();
        let mut twist = parent_twist;
        for dof in dofs.clone() {
            twist.add_scaled(v[dof], &column[dof]);
        }
        let mut rate = parent_rate;
        let alone = dofs.len() == 1;
        for dof in dofs {
            let s = column[dof];
            let psi = motion_cross(&parent_twist, &s);
            let mut psi_prime = motion_cross(&parent_rate, &s);
            psi_prime.add(&motion_cross(&parent_twist, &psi));
            // Ṡ = V × S is ψ if the body has no other DoF, because S × S = 0.
            let turned = if alone { psi } else { motion_cross(&twist, &s) };
            let mut velocity_term = psi;
            velocity_term.add(&turned);
            derivatives.motion[dof] = MotionDerivatives { psi, psi_prime, velocity_term };
            let (block, lane) = derivatives.paths.seat(dof);
            block.write_column(lane, &s);
            rate.add_scaled(v[dof], &turned);
            rate.add_scaled(a[dof], &s);
        }
        let inertia = inertia_in_world(body, &world[i]);
        let mut force = momentum_of(&inertia, &rate);
        force.add(&force_cross(&twist, &momentum_of(&inertia, &twist)));
        // B is linear in V: twice V gives 2B.
        let doubled =
            MotionVector { linear: twist.linear + twist.linear, angular: twist.angular + twist.angular };
        flows[i] = MassFlux::of(&inertia, &doubled);
        forces[i] = force;
        inertias[i] = inertia;
        twists[i] = twist;
        rates[i] = rate;
    }
}

/// Subtracts external wrenches, which move with their frames, from the bodies' forces.
#[inline(always)]
pub(super) fn subtract_carried<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    wrenches: &[FrameWrench<S>],
) {
    for wrench in wrenches {
        let Some((body, force)) = on_body(model, wrench) else { continue };
        let ForceVector { linear, angular } = tree.world.pose[body].force_in_parent(&force);
        tree.bodies.force[body].linear -= linear;
        tree.bodies.force[body].angular -= angular;
    }
}

/// The inward sweep: sums inertia, 2B and force over each subtree. Writes the parts of the columns that do
/// not depend on the acceleration, and τ = SᵀF of each DoF to `tree.dofs.tau`.
#[inline(always)]
pub(super) fn sweep_in<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        world: WorldFrameBuffers { column, flow, levers, .. },
        dofs: DofBuffers { tau, .. },
        inertias: Inertias { pivot, composite, .. },
        bodies: BodyBuffers { force, .. },
        derivatives,
        ..
    } = tree;
    let (flows, forces, inertias) = (&mut flow[..n], &mut force[..n], &mut composite[..n]);
    for (i, body) in model.bodies[..n].iter().enumerate().rev() {
        let (mut composite, mut flow, mut force) = (inertias[i], flows[i], forces[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = column[dof];
            let branch = Branch::new(&composite, &flow, &s, &derivatives.motion[dof].velocity_term);
            let ([a, b, c], [d, e, f]) = (branch.inertial.linear.array(), branch.inertial.angular.array());
            let [g, h, i] = branch.turning.array();
            let (block, lane) = derivatives.paths.seat(dof);
            block.inertial[lane] = [a, b, c, d, e, f, g, h, i];
            block.write_above(lane, &branch.above);
            pivot[dof].column = branch.inertial;
            tau[dof] = s.dot(&force);
        }
        if body.parent != WORLD {
            pass_inertia(body, levers, &mut composite);
            pass_flow(body, levers, &mut flow);
            pass_inward(body, levers, &mut force);
            add_composite(&mut inertias[body.parent], &composite);
            forces[body.parent].add(&force);
            let parent = &mut flows[body.parent];
            parent.momentum += flow.momentum;
            parent.first_moment_rate = parent.first_moment_rate + flow.first_moment_rate;
        }
    }
}

/// Updates the forces and ψ′ to the accelerations in `tree.dofs.a`. Call after [`sweep_in`] at a = 0.
///
/// A changes by δA = Σ S a along the path to the root. The force of a body's subtree changes by I δA, with I
/// of the subtree, plus I S a of each DoF beyond the body.
#[inline(always)]
pub(super) fn accelerate<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        dofs: DofBuffers { a, .. },
        world: WorldFrameBuffers { column, twist_rate, levers, .. },
        inertias: Inertias { pivot, composite, .. },
        bodies: BodyBuffers { force, subtree_force: beyond, .. },
        derivatives,
        ..
    } = tree;
    let (rises, forces) = (&mut twist_rate[..n], &mut force[..n]);
    let (inertias, beyond) = (&composite[..n], &mut beyond[..n]);
    let bodies = &model.bodies[..n];
    for i in 0..n {
        let body = &bodies[i];
        // δA replaces A, which is not read again.
        let mut parent_twist = if body.parent == WORLD { MotionVector::zero() } else { rises[body.parent] };
        pass_outward(body, levers, &mut parent_twist);
        let mut rise = parent_twist;
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &column[dof];
            derivatives.motion[dof].psi_prime.add(&motion_cross(&parent_twist, s));
            rise.add_scaled(a[dof], s);
        }
        rises[i] = rise;
        forces[i].add(&momentum_of(&inertias[i], &rise));
        beyond[i] = ForceVector::zero();
    }
    for i in (0..n).rev() {
        let (body, mut own) = (&bodies[i], beyond[i]);
        forces[i].add(&own);
        if body.parent != WORLD {
            for dof in body.dof..body.dof + body.motion.nv() {
                own.add_scaled(a[dof], &pivot[dof].column);
            }
            pass_inward(body, levers, &mut own);
            beyond[body.parent].add(&own);
        }
    }
}

/// The terms that depend on the acceleration: the columns S ×\* F + I ψ′ + 2B ψ, and the motion derivatives.
#[inline(always)]
pub(super) fn bend<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        world: WorldFrameBuffers { column, flow, .. },
        bodies: BodyBuffers { force, .. },
        inertias: Inertias { composite, .. },
        derivatives,
        ..
    } = tree;
    let (flows, forces, inertias) = (&flow[..n], &force[..n], &composite[..n]);
    for (i, body) in model.bodies[..n].iter().enumerate() {
        let (composite, flow, force) = (inertias[i], flows[i], forces[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let DerivativeBuffers { motion, paths, .. } = &mut *derivatives;
            let (motion, (block, lane)) = (&motion[dof], paths.seat(dof));
            block.write_motion(lane, motion);
            let mut force_derivative = Branch::new(&composite, &flow, &motion.psi, &motion.psi_prime).above;
            force_derivative.add(&force_cross(&column[dof], &force));
            block.write_force_derivative(lane, &force_derivative);
        }
    }
}
