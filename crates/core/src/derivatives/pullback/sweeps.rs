//! The sweeps of the pullbacks: outward for the velocities and the motion of λ, inward for the cotangents.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use super::parameters::{add_inertial, add_passive};
use crate::Model;
use crate::kinematics::shifts::{pass_inward, pass_outward};
use crate::kinematics::world_frame::{force_cross, inertia_in_world, momentum_of, motion_cross};
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::{BodyBuffers, DofBuffers, TreeMemory, WorldFrameBuffers};

/// The world's acceleration: −gravity.
#[inline(always)]
fn ground<S: Scalar>(model: &Model) -> MotionVector<S> {
    MotionVector { linear: V3::from_f64(model.gravity().map(|g| -g)), angular: V3::zero() }
}

/// The outward sweep: V, A and L of each body, from `dofs.{v, a}` and λ in `dofs.tau`. Call after
/// [`compute_columns`](crate::kinematics::world_frame::compute_columns).
#[inline(always)]
pub(super) fn sweep_out<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        dofs: DofBuffers { v, a, tau },
        world: WorldFrameBuffers { column, levers, twist, twist_rate, .. },
        pullback,
        ..
    } = tree;
    let bodies = &model.bodies[..n];
    let (twists, rates, shadows) = (&mut twist[..n], &mut twist_rate[..n], &mut pullback.shadow[..n]);
    let ground = ground(model);
    for i in 0..n {
        let body = &bodies[i];
        let (mut twist, mut rate, mut shadow) = if body.parent == WORLD {
            (MotionVector::zero(), ground, MotionVector::zero())
        } else {
            (twists[body.parent], rates[body.parent], shadows[body.parent])
        };
        pass_outward(body, levers, &mut twist);
        pass_outward(body, levers, &mut rate);
        pass_outward(body, levers, &mut shadow);
        // V × Σ S v = Σ Ṡ v.
        let mut joint = MotionVector::zero();
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &column[dof];
            joint.add_scaled(v[dof], s);
            rate.add_scaled(a[dof], s);
            shadow.add_scaled(tau[dof], s);
        }
        twist.add(&joint);
        rate.add(&motion_cross(&twist, &joint));
        (twists[i], rates[i], shadows[i]) = (twist, rate, shadow);
    }
}

/// Each body's F, P and D, from V, A and L.
#[inline(always)]
pub(super) fn weigh_bodies<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        world: WorldFrameBuffers { pose: world, twist, twist_rate, .. },
        bodies: BodyBuffers { force, .. },
        pullback,
        ..
    } = tree;
    let (bodies, world) = (&model.bodies[..n], &world[..n]);
    let (twists, rates, shadows) = (&twist[..n], &twist_rate[..n], &pullback.shadow[..n]);
    let (forces, momenta) = (&mut force[..n], &mut pullback.momentum[..n]);
    let drifts = &mut pullback.drift[..n];
    for i in 0..n {
        let inertia = inertia_in_world(&bodies[i], &world[i]);
        let (twist, shadow) = (&twists[i], &shadows[i]);
        let own = momentum_of(&inertia, twist);
        let mut force = momentum_of(&inertia, &rates[i]);
        force.add(&force_cross(twist, &own));
        let momentum = momentum_of(&inertia, shadow);
        let mut drift = force_cross(twist, &momentum);
        subtract(&mut drift, &momentum_of(&inertia, &motion_cross(twist, shadow)));
        subtract(&mut drift, &force_cross(shadow, &own));
        (forces[i], momenta[i], drifts[i]) = (force, momentum, drift);
    }
}

/// x ← x − y.
#[inline(always)]
fn subtract<S: Scalar>(x: &mut ForceVector<S>, y: &ForceVector<S>) {
    x.linear -= y.linear;
    x.angular -= y.angular;
}

/// The outputs: the cotangents of q, v and a, over the coordinates.
pub(super) struct Results<'a, N> {
    pub by_position: &'a mut [N],
    pub by_velocity: &'a mut [N],
    /// Empty if not requested.
    pub by_acceleration: &'a mut [N],
    /// The cotangents are added; empty if not requested.
    pub parameters: &'a mut [N],
}

/// The inward sweep: sums F, P and D over each subtree and writes the cotangents of its DoFs. Reads the
/// results of the outward sweeps, λ in `dofs.tau` and the accelerations in `dofs.a`.
#[inline(always)]
pub(super) fn sweep_in<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, results: &mut Results<'_, S>) {
    if !results.parameters.is_empty() {
        add_inertial(model, tree, results.parameters);
        add_passive(model, tree, results.parameters);
    }
    let Results { by_position, by_velocity, by_acceleration, parameters } = results;
    for result in [&mut **by_position, &mut **by_velocity, &mut **by_acceleration] {
        result.fill(S::zero());
    }
    let n = model.bodies.len();
    let TreeMemory {
        dofs: DofBuffers { tau, .. },
        world: WorldFrameBuffers { column, levers, twist, twist_rate, .. },
        bodies: BodyBuffers { force, .. },
        pullback,
        ..
    } = tree;
    let bodies = &model.bodies[..n];
    let (twists, rates, shadows) = (&twist[..n], &twist_rate[..n], &pullback.shadow[..n]);
    let (forces, momenta) = (&mut force[..n], &mut pullback.momentum[..n]);
    let (drifts, ground) = (&mut pullback.drift[..n], ground(model));
    let mut up = V3::zero();
    for i in (0..n).rev() {
        let (body, mut force, mut momentum, mut drift) = (&bodies[i], forces[i], momenta[i], drifts[i]);
        let mut parent =
            ParentMotion { twist: MotionVector::zero(), rate: ground, shadow: MotionVector::zero() };
        if body.parent != WORLD {
            let p = body.parent;
            parent = ParentMotion { twist: twists[p], rate: rates[p], shadow: shadows[p] };
        }
        parent.pass_outward(body, levers);
        let position = parent.by_position(&force, &momentum, &drift);
        let mut velocity = drift;
        let mut both = twists[i];
        both.add(&parent.twist);
        subtract(&mut velocity, &force_cross(&both, &momentum));
        for index in body.dof..body.dof + body.motion.nv() {
            let (dof, s) = (&model.dofs[index], &column[index]);
            let mut along = [s.dot(&position), s.dot(&velocity), s.dot(&momentum)];
            if model.has_springs {
                along[0] += tau[index].scale(dof.passive.stiffness);
            }
            if model.has_armature {
                along[2] += tau[index].scale(dof.passive.armature);
            }
            let k = dof.coordinate;
            // A mimic joint moves by its ratio; any other DoF is its own coordinate.
            if model.needs_dense_factor {
                along = [along[0].scale(dof.ratio), along[1].scale(dof.ratio), along[2].scale(dof.ratio)];
            }
            by_position[k] += along[0];
            by_velocity[k] += along[1];
            if !by_acceleration.is_empty() {
                by_acceleration[k] += along[2];
            }
        }
        if body.parent == WORLD {
            up += momentum.linear;
        } else {
            pass_inward(body, levers, &mut force);
            pass_inward(body, levers, &mut momentum);
            pass_inward(body, levers, &mut drift);
            forces[body.parent].add(&force);
            momenta[body.parent].add(&momentum);
            drifts[body.parent].add(&drift);
        }
    }
    if !by_acceleration.is_empty() {
        for rotor in &model.rotors {
            rotor.add_force_to_coordinates(&model.dofs, tau, by_acceleration);
        }
    }
    if !parameters.is_empty() {
        add_gravity(up, parameters);
    }
}

/// Adds the cotangent of gravity, the last three parameters. F = I A, and A of the world is −gravity:
/// ∂(λᵀτ)/∂g = −Σ (I L)'s linear part, which is `up`.
#[inline(always)]
fn add_gravity<S: Scalar>(up: V3<S>, parameters: &mut [S]) {
    let first = parameters.len() - 3;
    let up = up.array();
    for k in 0..3 {
        parameters[first + k] -= up[k];
    }
}

/// V_p, A_p and L_p of the parent, at the body's own reference point.
struct ParentMotion<S: Scalar> {
    twist: MotionVector<S>,
    rate: MotionVector<S>,
    shadow: MotionVector<S>,
}

impl<S: Scalar> ParentMotion<S> {
    #[inline(always)]
    fn pass_outward(&mut self, body: &Body, levers: &[V3<S>]) {
        pass_outward(body, levers, &mut self.twist);
        pass_outward(body, levers, &mut self.rate);
        pass_outward(body, levers, &mut self.shadow);
    }

    /// V_p ×\* (V_p ×\* P − D) − A_p ×\* P − L_p ×\* F.
    #[inline(always)]
    fn by_position(
        &self,
        force: &ForceVector<S>,
        momentum: &ForceVector<S>,
        drift: &ForceVector<S>,
    ) -> ForceVector<S> {
        let mut inner = force_cross(&self.twist, momentum);
        subtract(&mut inner, drift);
        let mut sum = force_cross(&self.twist, &inner);
        subtract(&mut sum, &force_cross(&self.rate, momentum));
        subtract(&mut sum, &force_cross(&self.shadow, force));
        sum
    }
}
