//! The cotangents of a description's parameters: inertial parameters, passive forces of the joints, gravity.
//!
//! λᵀτ = Σ L·F is linear in the inertial parameters. Let the link have the angular velocity ω, the angular
//! acceleration α and the classical acceleration a_o of its origin, less gravity. Let L have the linear part
//! l at that origin and the angular part ℓ. Then
//!
//! L·F = m l·a_o + h·(l × α + ω × (ω × l) + a_o × ℓ) + ℓ·I α + (ℓ × ω)·I ω.
//!
//! This is the row λᵀY of the [`joint_torque_regressor`](crate::joint_torque_regressor), with ten numbers per
//! link in its order.

use robot_dynamics_description::{JointKind, check_length};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use crate::algorithms::regressor::link_bodies;
use crate::joint::Chart;
use crate::kinematics::world_frame::shifted;
use crate::model::Dof;
use crate::workspace::tree::{Angles, DofBuffers, TreeMemory, WorldFrameBuffers};
use crate::{Joint, Model, PARAMETERS_PER_LINK};

/// The number of passive parameters of one joint: armature, damping, friction, stiffness, rest, as in
/// [`PassiveForces`](robot_dynamics_description::PassiveForces).
pub const PASSIVE_PARAMETERS_PER_JOINT: usize = 5;

/// The indices of a joint's five numbers.
const ARMATURE: usize = 0;
pub(super) const DAMPING: usize = 1;
pub(super) const FRICTION: usize = 2;
const STIFFNESS: usize = 3;
const REST: usize = 4;

impl Model {
    /// The joints whose passive forces are parameters: all but the fixed ones, in the order of
    /// [`Model::joints`].
    ///
    /// ```
    /// let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// assert_eq!(model.moving_joints().map(|joint| joint.name.as_str()).collect::<Vec<_>>(), ["hinge"]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn moving_joints(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| joint.kind != JointKind::Fixed)
    }
}

/// The number of parameters of a robot: ten for each of [`Model::moving_links`], five for each of
/// [`Model::moving_joints`], three of gravity. See [`ParameterCotangents`].
///
/// ```
/// use robot_dynamics::derivatives::parameter_count;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// assert_eq!(parameter_count(&model), 10 + 5 + 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parameter_count(model: &Model) -> usize {
    first_passive(model) + PASSIVE_PARAMETERS_PER_JOINT * model.moving_joints().count() + 3
}

/// The index of the joints' first number.
fn first_passive(model: &Model) -> usize {
    PARAMETERS_PER_LINK * link_bodies(model).count()
}

/// Each degree of freedom, with the index of its joint's first number. Joints are in order, and fixed ones
/// have no numbers.
#[inline(always)]
pub(super) fn with_passive_places(model: &Model) -> impl Iterator<Item = (usize, &Dof)> {
    let (mut place, mut last) = (first_passive(model), model.dofs.first().map(|dof| dof.joint));
    model.dofs.iter().map(move |dof| {
        if last != Some(dof.joint) {
            (place, last) = (place + PASSIVE_PARAMETERS_PER_JOINT, Some(dof.joint));
        }
        (place, dof)
    })
}

/// Rejects parameters of the wrong length, unless they are empty.
#[track_caller]
pub fn check_parameters<S>(model: &Model, parameters: &[S]) {
    if !parameters.is_empty() {
        check_length("the parameters", parameters.len(), parameter_count(model));
    }
}

/// The layout of a pullback's `parameters`.
///
/// ```
/// use robot_dynamics::algorithms::inertial_parameters;
/// use robot_dynamics::derivatives::{InversePullbackInputs, InversePullbackMut, ParameterCotangents};
/// use robot_dynamics::derivatives::{inverse_dynamics_pullback_with_parameters, parameter_count};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, mut numbers) = (&mut Workspace::<f64>::new(&model), vec![0.0; parameter_count(&model)]);
/// let (x, y, z) = (&mut [0.0], &mut [0.0], &mut [0.0]);
/// let (by_position, by_velocity, by_acceleration) = (x, y, z);
/// let outputs = InversePullbackMut { by_position, by_velocity, by_acceleration, parameters: &mut numbers };
/// let inputs =
///     InversePullbackInputs { q: &[0.3], v: &[1.0], a: &[2.0], wrenches: &[], cotangent: &[1.0] };
/// inverse_dynamics_pullback_with_parameters(&model, w, inputs, outputs);
/// // τ is linear in the inertial parameters.
/// let by = ParameterCotangents::of(&model, &numbers);
/// let tau: f64 = by.inertial.iter().zip(inertial_parameters(&model)).map(|(by, x)| by * x).sum();
/// assert!((tau - model.inverse_dynamics(&[0.3], &[1.0], &[2.0])?[0]).abs() < 1e-14);
/// assert_eq!(by.passive[0], 2.0); // τ gains armature · a
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParameterCotangents<'a, S = f64> {
    /// Ten for each of [`Model::moving_links`], in the order of [`inertial_parameters`](crate::inertial_parameters).
    pub inertial: &'a [S],
    /// Five for each of [`Model::moving_joints`]: armature, damping, friction, stiffness, rest. A joint of
    /// several degrees of freedom has one set for all of them; the numbers of a floating base are 0.
    pub passive: &'a [S],
    /// Three, for [`Model::gravity`].
    pub gravity: &'a [S],
}

impl<'a, S> ParameterCotangents<'a, S> {
    /// Splits the numbers into these groups.
    ///
    /// # Panics
    /// If there are not [`parameter_count`] of them.
    #[track_caller]
    pub fn of(model: &Model, numbers: &'a [S]) -> Self {
        check_length("the parameters", numbers.len(), parameter_count(model));
        let (inertial, rest) = numbers.split_at(first_passive(model));
        let (passive, gravity) = rest.split_at(rest.len() - 3);
        Self { inertial, passive, gravity }
    }
}

/// Adds λᵀY. Call after the outward sweep.
#[inline(always)]
pub(super) fn add_inertial<S: Scalar>(model: &Model, tree: &TreeMemory<S>, parameters: &mut [S]) {
    let n = model.bodies.len();
    let TreeMemory { world: WorldFrameBuffers { pose: world, twist, twist_rate, .. }, pullback, .. } = tree;
    let (bodies, world, shadows) = (&model.bodies[..n], &world[..n], &pullback.shadow[..n]);
    let (twists, rates) = (&twist[..n], &twist_rate[..n]);
    let mut first = 0;
    for i in 0..n {
        let body = &bodies[i];
        // For joints of several DoFs in series, the last body has the link.
        if i + 1 < n && bodies[i + 1].link == body.link {
            continue;
        }
        let place = &world[i];
        let twist = shifted(&twists[i], place.translation);
        let rate = shifted(&rates[i], place.translation);
        let shadow = shifted(&shadows[i], place.translation);
        let origin = rate.linear + twist.angular.cross(twist.linear);
        let link_from_world = place.rotation.times(&M3::from_f64(body.body_from_link.rotation)).transpose();
        let (w, alpha) = (link_from_world * twist.angular, link_from_world * rate.angular);
        let (l, turning) = (link_from_world * shadow.linear, link_from_world * shadow.angular);
        let origin = link_from_world * origin;
        let mass = l.dot(origin);
        let [hx, hy, hz] = (l.cross_sum(alpha, w, w.cross(l)) + origin.cross(turning)).array();
        let ([lx, ly, lz], [ax, ay, az]) = (turning.array(), alpha.array());
        let ([cx, cy, cz], [wx, wy, wz]) = (turning.cross(w).array(), w.array());
        // I_ij, i ≠ j, sets two entries of the symmetric matrix.
        let row = [
            mass,
            hx,
            hy,
            hz,
            lx * ax + cx * wx,
            lx * ay + ly * ax + cx * wy + cy * wx,
            ly * ay + cy * wy,
            lx * az + lz * ax + cx * wz + cz * wx,
            ly * az + lz * ay + cy * wz + cz * wy,
            lz * az + cz * wz,
        ];
        let to = &mut parameters[first..first + PARAMETERS_PER_LINK];
        for k in 0..PARAMETERS_PER_LINK {
            to[k] += row[k];
        }
        first += PARAMETERS_PER_LINK;
    }
}

/// Adds the cotangents of armature and springs: τ gains armature · a + stiffness (q − rest) of each DoF.
#[inline(always)]
pub(super) fn add_passive<S: Scalar>(model: &Model, tree: &TreeMemory<S>, parameters: &mut [S]) {
    let TreeMemory { dofs: DofBuffers { a, tau, .. }, angles: Angles { angle, .. }, .. } = tree;
    for (k, (first, dof)) in with_passive_places(model).enumerate() {
        let to = &mut parameters[first..first + PASSIVE_PARAMETERS_PER_JOINT];
        to[ARMATURE] += tau[k] * a[k];
        // A joint with a quaternion has no spring.
        if model.bodies[dof.body].motion.chart() == Chart::Line {
            let stretch = angle[dof.body] - S::from_f64(dof.passive.rest);
            to[STIFFNESS] += tau[k] * stretch;
            to[REST] -= tau[k].scale(dof.passive.stiffness);
        }
    }
}
