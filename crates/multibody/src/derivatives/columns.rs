//! What each freedom changes: one sweep out, one in.

use dynamics::Scalar;

use super::scratch::Scratch;
use crate::algebra::V3;
use crate::coriolis::Branch;
use crate::dispatch::Route;
use crate::mass_matrix::force_in_parent;
use crate::model::WORLD;
use crate::screws::{add_composite, add_scaled, force_cross, inertia_in_world, momentum_of, motion_cross};
use crate::workspace::{Flow, Force, Screw};
use crate::wrench::{FrameWrench, on_body};
use crate::{Model, Workspace};

/// How the parent's motion carries a freedom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope<S: Scalar> {
    /// ψ = V_p × S.
    pub once: Screw<S>,
    /// ψ′ = A_p × S + V_p × ψ.
    pub twice: Screw<S>,
    /// Ṡ + ψ.
    pub swept: Screw<S>,
}

/// What a freedom moves: weights for [`PathBlock`](super::path::PathBlock)'s rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column<S> {
    /// I S, then the moment of 2Bᵀ S, which has no force.
    pub inertial: [S; 9],
    /// I (Ṡ + ψ) + 2B S, the moment before the force.
    pub above: [S; 6],
    /// S ×\* F + I ψ′ + 2B ψ, the moment before the force.
    pub bent: [S; 6],
}

impl<S: Scalar> Column<S> {
    pub(super) fn zero() -> Self {
        let zero = S::zero();
        Self { inertial: [zero; 9], above: [zero; 6], bent: [zero; 6] }
    }

    /// I S, the moment before the force.
    #[inline(always)]
    pub(super) fn inertial_turn_first(&self) -> [S; 6] {
        let [a, b, c, d, e, f, ..] = self.inertial;
        [d, e, f, a, b, c]
    }
}

/// The moment before the force.
#[inline(always)]
fn turn_first<S: Scalar>(force: &Force<S>) -> [S; 6] {
    let ([a, b, c], [d, e, f]) = (force.angular.array(), force.linear.array());
    [a, b, c, d, e, f]
}

/// Outward: velocities V, accelerations A, each freedom's [`Slope`]; each body's inertia, 2B and force.
/// Reads the placements and freedoms in the inertial frame, `workspace.v` and `workspace.a`.
#[inline(always)]
pub(super) fn sweep_out<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, ground: [f64; 3]) {
    let world_rate = Force { linear: V3::from_f64(ground), angular: V3::zero() };
    for (i, body) in model.bodies.iter().enumerate() {
        let (carrier, carrier_rate) = if body.parent == WORLD {
            (Force::zero(), world_rate)
        } else {
            (workspace.twist[body.parent], workspace.twist_rate[body.parent])
        };
        let freedoms = body.dof..body.dof + body.motion.nv();
        let mut twist = carrier;
        for dof in freedoms.clone() {
            add_scaled(&mut twist, workspace.v[dof], &workspace.column[dof]);
        }
        let mut rate = carrier_rate;
        let alone = freedoms.len() == 1;
        for dof in freedoms {
            let s = workspace.column[dof];
            let once = motion_cross(&carrier, &s);
            let mut twice = motion_cross(&carrier_rate, &s);
            twice.add(&motion_cross(&carrier, &once));
            // Ṡ = V × S is ψ where the body has no other freedom: S × S = 0.
            let turned = if alone { once } else { motion_cross(&twist, &s) };
            let mut swept = once;
            swept.add(&turned);
            workspace.derivatives.slope[dof] = Slope { once, twice, swept };
            add_scaled(&mut rate, workspace.v[dof], &turned);
            add_scaled(&mut rate, workspace.a[dof], &s);
        }
        let inertia = inertia_in_world(body, &workspace.world[i]);
        let mut force = momentum_of(&inertia, &rate);
        force.add(&force_cross(&twist, &momentum_of(&inertia, &twist)));
        // B is linear in V: twice V gives 2B.
        let doubled = Force { linear: twist.linear + twist.linear, angular: twist.angular + twist.angular };
        workspace.flow[i] = Flow::of(&inertia, &doubled);
        workspace.force[i] = force;
        workspace.composite[i] = inertia;
        workspace.twist[i] = twist;
        workspace.twist_rate[i] = rate;
    }
}

/// Takes external wrenches, which move with their frames, off the bodies' forces.
#[inline(always)]
pub(super) fn subtract_carried<S: Scalar, R: Route<S>>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    wrenches: &[FrameWrench<S>],
) {
    for wrench in wrenches {
        let Some((body, force)) = on_body::<S, R>(model, wrench) else { continue };
        let Force { linear, angular } = force_in_parent(&workspace.world[body], &force);
        workspace.force[body].linear -= linear;
        workspace.force[body].angular -= angular;
    }
}

/// Inward: sums inertia, 2B and force over all that hangs on each body; writes what does not depend on the
/// acceleration of the columns, and τ = SᵀF of each freedom to `workspace.tau`.
#[inline(always)]
pub(super) fn sweep_in<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let (composite, flow, force) = (workspace.composite[i], workspace.flow[i], workspace.force[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = workspace.column[dof];
            let Scratch { slope, columns, .. } = &mut workspace.derivatives;
            let branch = Branch::new(&composite, &flow, &s, &slope[dof].swept);
            let ([a, b, c], [d, e, f]) = (branch.inertial.linear.array(), branch.inertial.angular.array());
            let [g, h, i] = branch.turning.array();
            columns[dof].inertial = [a, b, c, d, e, f, g, h, i];
            columns[dof].above = turn_first(&branch.above);
            workspace.pivot[dof].column = branch.inertial;
            workspace.tau[dof] = s.dot(&force);
        }
        if body.parent != WORLD {
            add_composite(&mut workspace.composite[body.parent], &composite);
            workspace.force[body.parent].add(&force);
            let parent = &mut workspace.flow[body.parent];
            parent.momentum += flow.momentum;
            parent.stir = parent.stir + flow.stir;
        }
    }
}

/// After [`sweep_in`] at a = 0: the forces and ψ′ under the accelerations in `workspace.a`.
///
/// A changes by δA = Σ S a along the way to the root. All beyond a body changes its force by I δA, with the
/// inertia I of all of it, plus I S a of each freedom beyond.
#[inline(always)]
pub(super) fn accelerate<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    for (i, body) in model.bodies.iter().enumerate() {
        // δA stands where A stood, which nothing reads any more.
        let carrier = if body.parent == WORLD { Force::zero() } else { workspace.twist_rate[body.parent] };
        let mut rise = carrier;
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &workspace.column[dof];
            workspace.derivatives.slope[dof].twice.add(&motion_cross(&carrier, s));
            add_scaled(&mut rise, workspace.a[dof], s);
        }
        workspace.twist_rate[i] = rise;
        workspace.force[i].add(&momentum_of(&workspace.composite[i], &rise));
        workspace.beyond[i] = Force::zero();
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let beyond = workspace.beyond[i];
        workspace.force[i].add(&beyond);
        if body.parent != WORLD {
            let parent = &mut workspace.beyond[body.parent];
            parent.add(&beyond);
            for dof in body.dof..body.dof + body.motion.nv() {
                add_scaled(parent, workspace.a[dof], &workspace.pivot[dof].column);
            }
        }
    }
}

/// The columns S ×\* F + I ψ′ + 2B ψ; and the slopes to the paths.
#[inline(always)]
pub(super) fn bend<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    let Scratch { slope, paths, .. } = &mut workspace.derivatives;
    paths.write_slopes(slope);
    for (i, body) in model.bodies.iter().enumerate() {
        let (composite, flow, force) = (workspace.composite[i], workspace.flow[i], workspace.force[i]);
        for dof in body.dof..body.dof + body.motion.nv() {
            let Scratch { slope, columns, .. } = &mut workspace.derivatives;
            let slope = &slope[dof];
            let mut bent = Branch::new(&composite, &flow, &slope.once, &slope.twice).above;
            bent.add(&force_cross(&workspace.column[dof], &force));
            columns[dof].bent = turn_first(&bent);
        }
    }
}
