//! The centre of mass of the moving bodies. Cost: O(n).
//!
//! c = Σ m c_i / Σ m over the moving bodies; [`Model::mass`] is the denominator. Links fixed to the world do
//! not count, unless the moving bodies have no mass: then c is the centre of mass of all links. The result is
//! NaN for a robot without mass.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Workspace;
use crate::kinematics::shifts::{from_main, main_in_world};
use crate::kinematics::world_frame::{
    composites_in_world, compute_column_rates, compute_columns, compute_twist_rates, compute_twists,
    force_cross, inertia_in_world, momentum_of,
};
use crate::model::Model;
use crate::model::native::NativeFunction;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::SpatialInertia;
use crate::workspace::native::{NativeScratch, computed_natively};
use crate::workspace::tree::TreeMemory;

impl Model {
    /// The mass of the moving bodies \[kg\]: [`Model::total_mass`] without the links fixed to the world.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("ceiling", &robot_dynamics::description::MassProperties::point(7.0, [0.0; 3].into())?)?;
    /// let model = Model::new(robot)?;
    /// assert_eq!((model.total_mass(), model.moving_mass()), (9.0, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn moving_mass(&self) -> f64 {
        // An empty sum is −0.
        self.bodies.iter().map(|body| body.mass).sum::<f64>() + 0.0
    }
}

/// The centre of mass of the moving bodies in the world frame \[m\]. If they have no mass, it is that of all
/// links.
///
/// ```
/// use robot_dynamics::algorithms::center_of_mass;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let c = center_of_mass(&model, &mut Workspace::new(&model), &[0.3]);
/// assert!((c[0] - 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// assert!((c[2] + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S]) -> [S; 3] {
    workspace.check_inputs(model, q);
    let (native, mut center_of_mass) = (&mut workspace.tree.native, [S::zero(); 3]);
    if computed_by_mass(model, native, NativeFunction::CenterOfMass, q, &mut center_of_mass) {
        return center_of_mass;
    }
    if model.moving_mass() == 0.0 {
        let mass = model.mass();
        return model.fixed_first_moment.map(|moment| S::from_f64(moment / mass));
    }
    compute_columns(model, &mut workspace.tree, q);
    (main_in_world(model, &workspace.tree) + center(model, &workspace.tree)).array()
}

/// Computes a quantity that is divided by the mass by machine code; returns whether it did. A robot without
/// mass keeps the recursion, which gives numbers that are not finite.
#[inline]
pub(crate) fn computed_by_mass<S: Scalar>(
    model: &Model,
    native: &mut NativeScratch<S>,
    function: NativeFunction,
    q: &[S],
    result: &mut [S],
) -> bool {
    model.total_mass() > 0.0 && computed_natively(model, native, function, &[q], &mut [result])
}

/// The centre of mass relative to the main reference point.
#[inline(always)]
pub fn center<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> V3<S> {
    let mut first_moment = V3::zero();
    for (body, place) in model.bodies.iter().zip(&tree.world.pose) {
        let turned = place.rotation * V3::constant(&body.first_moment);
        first_moment += turned.add_scaled(S::from_f64(body.mass), place.translation);
    }
    if model.points.several {
        for (i, body) in model.bodies.iter().enumerate() {
            first_moment += from_main(model, tree, i) * S::from_f64(body.mass);
        }
    }
    first_moment * S::from_f64(1.0 / model.mass())
}

/// ċ: the velocity of the centre of mass, along the world's axes \[m/s\].
///
/// ```
/// use robot_dynamics::algorithms::center_of_mass_velocity;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // Horizontal, and falling at 3 rad/s: l v downwards.
/// let velocity = center_of_mass_velocity(&model, &mut Workspace::new(&model), &[0.0], &[3.0]);
/// assert_eq!(velocity, [0.0, 0.0, -0.5 * 3.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass_velocity<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
) -> [S; 3] {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    compute_columns(model, &mut workspace.tree, q);
    compute_twists(model, &mut workspace.tree, v);
    let momentum = whole_momentum(model, &workspace.tree).linear;
    (momentum * S::from_f64(1.0 / model.mass())).array()
}

/// J with ċ = J v, 3×nv, row-major, along the world's axes.
///
/// Column j is the momentum that DoF j gives to its subtree at unit velocity, divided by the moving mass.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::{center_of_mass_jacobian, center_of_mass_velocity};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (w, mut jacobian) = (&mut Workspace::new(&model), vec![0.0; 3 * model.nv()]);
/// center_of_mass_jacobian(&model, w, &q, &mut jacobian);
/// let from_jacobian = DMatrix::from_row_slice(3, model.nv(), &jacobian) * DVector::from_column_slice(&v);
/// let velocity = center_of_mass_velocity(&model, w, &q, &v);
/// assert!((0..3).all(|i| (velocity[i] - from_jacobian[i]).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass_jacobian<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    jacobian: &mut [S],
) {
    workspace.check_inputs(model, q);
    let nv = model.nv;
    check_length("the Jacobian of the centre of mass", jacobian.len(), 3 * nv);
    let native = &mut workspace.tree.native;
    if computed_by_mass(model, native, NativeFunction::CenterOfMassJacobian, q, jacobian) {
        return;
    }
    compute_columns(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    jacobian.fill(S::zero());
    let inverse_mass = 1.0 / model.mass();
    for (dof, s) in model.dofs.iter().zip(&workspace.tree.world.column) {
        let SpatialInertia { mass, first_moment, .. } = workspace.tree.inertias.composite[dof.body];
        let momentum = s.angular.cross(first_moment).add_scaled(mass, s.linear);
        for (row, entry) in momentum.array().into_iter().enumerate() {
            jacobian[row * nv + dof.coordinate] += entry.scale(dof.ratio * inverse_mass);
        }
    }
}

/// J̇ v: the acceleration of the centre of mass at a = 0, along the world's axes \[m/s²\].
///
/// ```
/// use robot_dynamics::algorithms::center_of_mass_bias_acceleration;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // The mass on its circle accelerates towards the hinge, l v².
/// let bias = center_of_mass_bias_acceleration(&model, &mut Workspace::<f64>::new(&model), &[0.0], &[3.0]);
/// assert!((bias[0] + 0.5 * 3.0 * 3.0).abs() < 1e-14 && bias[2].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass_bias_acceleration<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
) -> [S; 3] {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    compute_columns(model, &mut workspace.tree, q);
    compute_twists(model, &mut workspace.tree, v);
    compute_column_rates(model, &mut workspace.tree);
    compute_twist_rates(model, &mut workspace.tree, None);
    let rate = whole_momentum_rate(model, &workspace.tree).linear;
    (rate * S::from_f64(1.0 / model.mass())).array()
}

/// Σ I V about the main reference point, from the twists in the workspace.
#[inline(always)]
pub(crate) fn whole_momentum<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> ForceVector<S> {
    let mut sum = ForceVector::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &tree.world.pose[i]);
        add_about_main(model, tree, i, &mut sum, &momentum_of(&inertia, &tree.world.twist[i]));
    }
    sum
}

/// Adds a body's force or momentum.
#[inline(always)]
fn add_about_main<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    body: usize,
    sum: &mut ForceVector<S>,
    own: &ForceVector<S>,
) {
    sum.add(own);
    if model.points.several {
        sum.angular += from_main(model, tree, body).cross(own.linear);
    }
}

/// Σ I V̇ + V ×* I V about the main reference point: the rate of [`whole_momentum`].
#[inline(always)]
pub(crate) fn whole_momentum_rate<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> ForceVector<S> {
    let mut sum = ForceVector::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &tree.world.pose[i]);
        let mut own = momentum_of(&inertia, &tree.world.twist_rate[i]);
        own.add(&force_cross(&tree.world.twist[i], &momentum_of(&inertia, &tree.world.twist[i])));
        add_about_main(model, tree, i, &mut sum, &own);
    }
    sum
}
