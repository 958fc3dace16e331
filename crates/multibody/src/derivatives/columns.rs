//! What each freedom changes: one sweep out, one in.

use dynamics::Scalar;
use number::View;

use crate::Model;
use crate::algorithms::coriolis::Branch;
use crate::algorithms::mass_matrix::force_in_parent;
use crate::model::WORLD;
use crate::scratch::derivatives::Scratch;
use crate::scratch::slope::Slope;
use crate::scratch::tree::{InBodies, Inertias, PerFreedom, Screws, TreeMemory};
use crate::spatial::algebra::V3;
use crate::spatial::screw::{Flow, Force};
use crate::stages::screws::{
    add_composite, add_scaled, force_cross, inertia_in_world, momentum_of, motion_cross,
};
use crate::stages::shifts::{pass_flow, pass_inertia, pass_inward, pass_outward};
use crate::stages::wrench::{FrameWrench, on_body};

/// Outward: velocities V, accelerations A, each freedom's [`Slope`]; each body's inertia, 2B and force.
/// Reads the placements and freedoms in the inertial frame, `tree.freedoms.v` and `tree.freedoms.a`.
#[inline(always)]
pub(super) fn sweep_out<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, ground: [f64; 3]) {
    let world_rate = Force { linear: V3::from_f64(ground), angular: V3::zero() };
    let n = model.bodies.len();
    let TreeMemory {
        freedoms: PerFreedom { v, a, .. },
        screws: Screws { column, world, levers, twist, twist_rate, flow, .. },
        bodies: InBodies { force, .. },
        inertias: Inertias { composite, .. },
        derivatives,
        ..
    } = tree;
    let (bodies, world) = (&model.bodies[..n], &world[..n]);
    let (twists, rates) = (&mut twist[..n], &mut twist_rate[..n]);
    let (flows, forces, inertias) = (&mut flow[..n], &mut force[..n], &mut composite[..n]);
    for i in 0..n {
        let body = &bodies[i];
        let (mut carrier, mut carrier_rate) = if body.parent == WORLD {
            (Force::zero(), world_rate)
        } else {
            (twists[body.parent], rates[body.parent])
        };
        if body.is_carried {
            pass_outward(body, levers, &mut carrier);
            pass_outward(body, levers, &mut carrier_rate);
            derivatives.paths.seat(body.dof).0.lever = levers[body.point].array();
        }
        let freedoms = body.dof..body.dof + body.motion.nv();
        let mut twist = carrier;
        for dof in freedoms.clone() {
            add_scaled(&mut twist, v[dof], &column[dof]);
        }
        let mut rate = carrier_rate;
        let alone = freedoms.len() == 1;
        for dof in freedoms {
            let s = column[dof];
            let once = motion_cross(&carrier, &s);
            let mut twice = motion_cross(&carrier_rate, &s);
            twice.add(&motion_cross(&carrier, &once));
            // Ṡ = V × S is ψ where the body has no other freedom: S × S = 0.
            let turned = if alone { once } else { motion_cross(&twist, &s) };
            let mut swept = once;
            swept.add(&turned);
            derivatives.slope[dof] = Slope { once, twice, swept };
            let (block, lane) = derivatives.paths.seat(dof);
            block.write_screw(lane, &s);
            add_scaled(&mut rate, v[dof], &turned);
            add_scaled(&mut rate, a[dof], &s);
        }
        let inertia = inertia_in_world(body, &world[i]);
        let mut force = momentum_of(&inertia, &rate);
        force.add(&force_cross(&twist, &momentum_of(&inertia, &twist)));
        // B is linear in V: twice V gives 2B.
        let doubled = Force { linear: twist.linear + twist.linear, angular: twist.angular + twist.angular };
        flows[i] = Flow::of(&inertia, &doubled);
        forces[i] = force;
        inertias[i] = inertia;
        twists[i] = twist;
        rates[i] = rate;
    }
}

/// Takes external wrenches, which move with their frames, off the bodies' forces.
#[inline(always)]
pub(super) fn subtract_carried<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    wrenches: &[FrameWrench<S>],
) {
    for wrench in wrenches {
        let Some((body, force)) = on_body(model, wrench) else { continue };
        let Force { linear, angular } = force_in_parent(&tree.screws.world[body], &force);
        tree.bodies.force[body].linear -= linear;
        tree.bodies.force[body].angular -= angular;
    }
}

/// Inward: sums inertia, 2B and force over all that hangs on each body; writes what does not depend on the
/// acceleration of the columns, and τ = SᵀF of each freedom to `tree.freedoms.tau`.
#[inline(always)]
pub(super) fn sweep_in<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        screws: Screws { column, flow, levers, .. },
        freedoms: PerFreedom { tau, .. },
        inertias: Inertias { pivot, composite, .. },
        bodies: InBodies { force, .. },
        derivatives,
        ..
    } = tree;
    let (flows, forces, inertias) = (&mut flow[..n], &mut force[..n], &mut composite[..n]);
    for (i, body) in model.bodies[..n].iter().enumerate().rev() {
        let (mut composite, mut flow, mut force) = (inertias[i], flows[i], forces[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = column[dof];
            let branch = Branch::new(&composite, &flow, &s, &derivatives.slope[dof].swept);
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
            parent.stir = parent.stir + flow.stir;
        }
    }
}

/// After [`sweep_in`] at a = 0: the forces and ψ′ under the accelerations in `tree.freedoms.a`.
///
/// A changes by δA = Σ S a along the way to the root. All beyond a body changes its force by I δA, with the
/// inertia I of all of it, plus I S a of each freedom beyond.
#[inline(always)]
pub(super) fn accelerate<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        freedoms: PerFreedom { a, .. },
        screws: Screws { column, twist_rate, levers, .. },
        inertias: Inertias { pivot, composite, .. },
        bodies: InBodies { force, beyond, .. },
        derivatives,
        ..
    } = tree;
    let (rises, forces) = (&mut twist_rate[..n], &mut force[..n]);
    let (inertias, beyond) = (&composite[..n], &mut beyond[..n]);
    let bodies = &model.bodies[..n];
    for i in 0..n {
        let body = &bodies[i];
        // δA stands where A stood, which nothing reads any more.
        let mut carrier = if body.parent == WORLD { Force::zero() } else { rises[body.parent] };
        pass_outward(body, levers, &mut carrier);
        let mut rise = carrier;
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &column[dof];
            derivatives.slope[dof].twice.add(&motion_cross(&carrier, s));
            add_scaled(&mut rise, a[dof], s);
        }
        rises[i] = rise;
        forces[i].add(&momentum_of(&inertias[i], &rise));
        beyond[i] = Force::zero();
    }
    for i in (0..n).rev() {
        let (body, mut own) = (&bodies[i], beyond[i]);
        forces[i].add(&own);
        if body.parent != WORLD {
            for dof in body.dof..body.dof + body.motion.nv() {
                add_scaled(&mut own, a[dof], &pivot[dof].column);
            }
            pass_inward(body, levers, &mut own);
            beyond[body.parent].add(&own);
        }
    }
}

/// What depends on the acceleration: the columns S ×\* F + I ψ′ + 2B ψ, and the slopes.
#[inline(always)]
pub(super) fn bend<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        screws: Screws { column, flow, .. },
        bodies: InBodies { force, .. },
        inertias: Inertias { composite, .. },
        derivatives,
        ..
    } = tree;
    let (flows, forces, inertias) = (&flow[..n], &force[..n], &composite[..n]);
    for (i, body) in model.bodies[..n].iter().enumerate() {
        let (composite, flow, force) = (inertias[i], flows[i], forces[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let Scratch { slope, paths, .. } = &mut *derivatives;
            let (slope, (block, lane)) = (&slope[dof], paths.seat(dof));
            block.write_slope(lane, slope);
            let mut bent = Branch::new(&composite, &flow, &slope.once, &slope.twice).above;
            bent.add(&force_cross(&column[dof], &force));
            block.write_bent(lane, &bent);
        }
    }
}
