//! Regressors: forces and energies as linear functions of the inertial parameters. Cost: O(n depth) for
//! forces, O(n) for energies.
//!
//! π lists ten numbers for each moving link: m, m c (3), and Ixx, Ixy, Iyy, Ixz, Iyz, Izz. The inertia is
//! about the link's origin, along the axes of the link that the joint moves. Links fixed to this link are
//! included. Then τ = Y(q,v,a) π, K = y_K(q,v) π, V = y_V(q) π. Parameter identification solves these
//! equations for π. Armature and springs are not inertial parameters and are left out. Source: Atkeson, An,
//! Hollerbach, *Estimation of inertial parameters of manipulator loads and links*, Int. J. Robotics Research
//! 5 (1986).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::algorithms::inverse_dynamics::accelerate_bodies;
use crate::kinematics::placement::spread;
use crate::kinematics::shifts::{in_world, pass_inward};
use crate::kinematics::world_frame::{compute_columns, compute_twists, shifted};
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::{Model, Workspace};

/// The length of π for one link.
pub const PARAMETERS_PER_LINK: usize = 10;

impl Model {
    /// The moving links, in the order of π and of the regressors' columns.
    pub fn moving_links(&self) -> impl Iterator<Item = &str> {
        link_bodies(self).map(|(_, body)| self.description.links[body.link].name.as_str())
    }
}

/// The bodies that have a link. A joint of several DoFs in series has one link: that of its last body.
pub(crate) fn link_bodies(model: &Model) -> impl Iterator<Item = (usize, &Body)> {
    let carries = |i: usize| model.bodies.get(i + 1).is_none_or(|next| next.link != model.bodies[i].link);
    model.bodies.iter().enumerate().filter(move |(i, _)| carries(*i))
}

/// π of the robot as described \[kg, kg·m, kg·m²\]: ten numbers for each of [`Model::moving_links`].
///
/// ```
/// use robot_dynamics::algorithms::inertial_parameters;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // m; m c; the moments and products about the link's origin: m l² about y and z.
/// assert_eq!(inertial_parameters(&model), [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn inertial_parameters(model: &Model) -> Vec<f64> {
    let mut parameters = Vec::new();
    for (_, body) in link_bodies(model) {
        // I_link = Rᵀ(I_body shifted to the link's origin)R; the shift is zero, as the joint's axes pass
        // through it.
        let turn = M3::<f64>::from_f64(body.body_from_link.rotation);
        let about_link = Sym3::constant(&body.inertia).rotated(&turn.transpose());
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = about_link.full().rows();
        let [hx, hy, hz] = turn.transpose_mul(V3::constant(&body.first_moment)).array();
        parameters.extend([body.mass, hx, hy, hz, xx, xy, yy, xz, yz, zz]);
    }
    parameters
}

/// Y(q,v,a) with Y π = inverse dynamics, nv × 10·links, row-major, without armature and springs.
///
/// ```
/// use robot_dynamics::algorithms::{inertial_parameters, joint_torque_regressor};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, mut regressor) = (&mut Workspace::<f64>::new(&model), [0.0; 10]);
/// joint_torque_regressor(&model, w, &[0.3], &[1.0], &[2.0], &mut regressor);
/// let tau: f64 = regressor.iter().zip(inertial_parameters(&model)).map(|(y, parameter)| y * parameter).sum();
/// assert!((tau - model.inverse_dynamics(&[0.3], &[1.0], &[2.0])?[0]).abs() < 1e-14);
/// assert_eq!(regressor[0], 0.0); // a mass at the hinge needs no torque
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn joint_torque_regressor<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    regressor: &mut [S],
) {
    workspace.check_inputs(model, q);
    let columns = PARAMETERS_PER_LINK * link_bodies(model).count();
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the regressor", regressor.len(), model.nv * columns);
    compute_columns(model, &mut workspace.tree, q);
    spread(model, v, &mut workspace.tree.dofs.v);
    spread(model, a, &mut workspace.tree.dofs.a);
    accelerate_bodies(model, &mut workspace.tree, q, model.gravity().map(|g| -g));
    regressor.fill(S::zero());
    for (link, (i, body)) in link_bodies(model).enumerate() {
        let turn = M3::<S>::from_f64(body.body_from_link.rotation);
        let motion = &workspace.tree.bodies.motion[i];
        let [w, alpha, origin] = [motion.angular, motion.alpha, motion.origin].map(|x| turn.transpose_mul(x));
        let world_from_link = workspace.tree.world.pose[i].rotation.times(&turn);
        let mut wrenches = wrenches(w, alpha, origin).map(|ForceVector { linear, angular }| {
            // The same wrench about the inertial frame's origin and along its axes.
            let linear = world_from_link * linear;
            let moment = workspace.tree.world.pose[i].translation.cross(linear);
            ForceVector { linear, angular: world_from_link * angular + moment }
        });
        let mut at = i;
        while at != WORLD {
            let carrier = &model.bodies[at];
            for index in carrier.dof..carrier.dof + carrier.motion.nv() {
                let dof = &model.dofs[index];
                let first = dof.coordinate * columns + PARAMETERS_PER_LINK * link;
                let row = &mut regressor[first..first + PARAMETERS_PER_LINK];
                for (entry, wrench) in row.iter_mut().zip(&wrenches) {
                    *entry += workspace.tree.world.column[index].dot(wrench).scale(dof.ratio);
                }
            }
            for wrench in &mut wrenches {
                pass_inward(carrier, &workspace.tree.world.levers, wrench);
            }
            at = carrier.parent;
        }
    }
}

/// The force and moment for a unit of each of the ten parameters, about the link's origin and along its axes.
///
/// F = m a_o + B h, N = h × a_o + I α + ω × I ω with B = \[α\]× + \[ω\]×\[ω\]×.
#[inline(always)]
fn wrenches<S: Scalar>(w: V3<S>, alpha: V3<S>, origin: V3<S>) -> [ForceVector<S>; PARAMETERS_PER_LINK] {
    let zero = V3::zero();
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(V3::<S>::from_f64);
    let mass = ForceVector { linear: origin, angular: zero };
    let moment =
        |e: V3<S>| ForceVector { linear: alpha.cross(e) + w.cross(w.cross(e)), angular: e.cross(origin) };
    // A unit I_ij, i ≠ j, sets two entries of the symmetric matrix.
    let inertia = |a: V3<S>, b: V3<S>, twice: bool| {
        let times = |u: V3<S>| {
            let one = a * b.dot(u);
            if twice { one + b * a.dot(u) } else { one }
        };
        ForceVector { linear: zero, angular: times(alpha) + w.cross(times(w)) }
    };
    [
        mass,
        moment(x),
        moment(y),
        moment(z),
        inertia(x, x, false),
        inertia(x, y, true),
        inertia(y, y, false),
        inertia(x, z, true),
        inertia(y, z, true),
        inertia(z, z, false),
    ]
}

/// y_K(q,v) with y_K π = K, 10·links numbers, without armature.
///
/// ```
/// use robot_dynamics::algorithms::{inertial_parameters, kinetic_energy_regressor};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut regressor = [0.0; 10];
/// kinetic_energy_regressor(&model, &mut Workspace::<f64>::new(&model), &[0.3], &[3.0], &mut regressor);
/// assert!((regressor[6] - 0.5 * 3.0 * 3.0).abs() < 1e-14); // ½ v² for each kg·m² of Iyy
/// let energy: f64 = regressor.iter().zip(inertial_parameters(&model)).map(|(y, parameter)| y * parameter).sum();
/// assert!((energy - model.kinetic_energy(&[0.3], &[3.0])?).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn kinetic_energy_regressor<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    regressor: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    let columns = PARAMETERS_PER_LINK * link_bodies(model).count();
    check_length("the regressor", regressor.len(), columns);
    compute_columns(model, &mut workspace.tree, q);
    compute_twists(model, &mut workspace.tree, v);
    for ((i, body), row) in link_bodies(model).zip(regressor.chunks_exact_mut(PARAMETERS_PER_LINK)) {
        let place = &workspace.tree.world.pose[i];
        let twist = shifted(&workspace.tree.world.twist[i], place.translation);
        let into_link = |x: V3<S>| {
            M3::from_f64(body.body_from_link.rotation).transpose_mul(place.rotation.transpose_mul(x))
        };
        let (u, w) = (into_link(twist.linear), into_link(twist.angular));
        // K = ½ m|u|² + u·(ω × h) + ½ ωᵀI ω, and u·(ω × h) = (u × ω)·h.
        let [cx, cy, cz] = u.cross(w).array();
        let [wx, wy, wz] = w.array();
        let half = |x: S| x.scale(0.5);
        row.copy_from_slice(&[
            half(u.dot(u)),
            cx,
            cy,
            cz,
            half(wx * wx),
            wx * wy,
            half(wy * wy),
            wx * wz,
            wy * wz,
            half(wz * wz),
        ]);
    }
}

/// y_V(q) with y_V π = V, 10·links numbers, without springs.
///
/// ```
/// use robot_dynamics::algorithms::{inertial_parameters, potential_energy_regressor};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut regressor = [0.0; 10];
/// potential_energy_regressor(&model, &mut Workspace::<f64>::new(&model), &[0.3], &mut regressor);
/// assert!((regressor[1] + 9.81 * 0.3_f64.sin()).abs() < 1e-14); // −g sin q for each kg·m of hx
/// let energy: f64 = regressor.iter().zip(inertial_parameters(&model)).map(|(y, parameter)| y * parameter).sum();
/// assert!((energy - model.potential_energy(&[0.3])?).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn potential_energy_regressor<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    regressor: &mut [S],
) {
    workspace.check_inputs(model, q);
    let columns = PARAMETERS_PER_LINK * link_bodies(model).count();
    check_length("the regressor", regressor.len(), columns);
    compute_columns(model, &mut workspace.tree, q);
    let gravity = V3::from_f64(model.gravity());
    regressor.fill(S::zero());
    for ((i, body), row) in link_bodies(model).zip(regressor.chunks_exact_mut(PARAMETERS_PER_LINK)) {
        // V = −g·(m p + R h).
        let place = &workspace.tree.world.pose[i];
        let in_link =
            M3::from_f64(body.body_from_link.rotation).transpose_mul(place.rotation.transpose_mul(gravity));
        row[0] = -gravity.dot(place.translation + in_world(model, &workspace.tree, i));
        row[1..4].copy_from_slice(&(-in_link).array());
    }
}
