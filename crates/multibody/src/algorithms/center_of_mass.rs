//! The centre of mass of what moves.
//!
//! Links fixed to the world have no part in it: c = Σ m c_i / Σ m over the moving bodies, whose mass is [`Model::mass`]. If the
//! moving bodies have no mass, it is that of all links. A robot without mass has no centre of mass; the numbers are then NaN.

use dynamics::Scalar;

use crate::Workspace;
use crate::model::Model;
use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::scratch::native::{NativeScratch, computed_natively};
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::V3;
use crate::spatial::screw::{Composite, Force};
use crate::stages::screws::{
    accelerate_screws, composites_in_world, force_cross, inertia_in_world, momentum_of, move_screws,
    place_screws, turn_screws,
};
use crate::stages::shifts::{from_main, main_in_world};

impl Model {
    /// The mass of the bodies that move \[kg\]: [`Model::total_mass`] without the links fixed to the world.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("ceiling", &dynamics::MassProperties::point(7.0, [0.0; 3].into())?)?;
    /// let model = Model::new(robot)?;
    /// assert_eq!((model.total_mass(), model.moving_mass()), (9.0, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn moving_mass(&self) -> f64 {
        // A sum of nothing is −0.
        self.bodies.iter().map(|body| body.mass).sum::<f64>() + 0.0
    }
}

/// The centre of mass of the moving bodies, in the world frame \[m\]; of all links where those that move have no mass.
///
/// ```
/// use multibody::{Model, Workspace, center_of_mass, pendulum};
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
    workspace.admit(model, q);
    let (native, mut center_of_mass) = (&mut workspace.tree.native, [S::zero(); 3]);
    if computed_by_mass(model, native, NativeFunction::CenterOfMass, q, &mut center_of_mass) {
        return center_of_mass;
    }
    if model.moving_mass() == 0.0 {
        let mass = model.mass();
        return model.fixed_first_moment.map(|moment| S::from_f64(moment / mass));
    }
    place_screws(model, &mut workspace.tree, q);
    (main_in_world(model, &workspace.tree) + center(model, &workspace.tree)).array()
}

/// Whether machine code has computed what is divided by the mass. A robot without any keeps the recursion, whose numbers are not finite.
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

/// The centre of mass from the main reference point.
#[inline(always)]
pub(crate) fn center<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> V3<S> {
    let mut first_moment = V3::zero();
    for (body, place) in model.bodies.iter().zip(&tree.screws.world) {
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
/// use multibody::{Model, Workspace, center_of_mass_velocity, pendulum};
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
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    place_screws(model, &mut workspace.tree, q);
    move_screws(model, &mut workspace.tree, v);
    let momentum = whole_momentum(model, &workspace.tree).linear;
    (momentum * S::from_f64(1.0 / model.mass())).array()
}

/// J with ċ = J v, 3×nv, row-major, along the world's axes.
///
/// Column j is what freedom j gives to the mass beyond it, over the whole mass.
///
/// ```
/// use multibody::{Workspace, center_of_mass_jacobian, center_of_mass_velocity};
/// use nalgebra::{DMatrix, DVector};
/// # use multibody::*;
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut dynamics::SplitMix64::new(1));
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
    workspace.admit(model, q);
    let nv = model.nv;
    check_length("the Jacobian of the centre of mass", jacobian.len(), 3 * nv);
    let native = &mut workspace.tree.native;
    if computed_by_mass(model, native, NativeFunction::CenterOfMassJacobian, q, jacobian) {
        return;
    }
    place_screws(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    jacobian.fill(S::zero());
    let inverse_mass = 1.0 / model.mass();
    for (dof, s) in model.dofs.iter().zip(&workspace.tree.screws.column) {
        let Composite { mass, first_moment, .. } = workspace.tree.inertias.composite[dof.body];
        let momentum = s.angular.cross(first_moment).add_scaled(mass, s.linear);
        for (row, entry) in momentum.array().into_iter().enumerate() {
            jacobian[row * nv + dof.coordinate] += entry.scale(dof.ratio * inverse_mass);
        }
    }
}

/// J̇ v: the acceleration of the centre of mass at a = 0, along the world's axes \[m/s²\].
///
/// ```
/// use multibody::{Model, Workspace, center_of_mass_bias_acceleration, pendulum};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // On its circle a mass is accelerated towards the hinge, l v².
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
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    place_screws(model, &mut workspace.tree, q);
    move_screws(model, &mut workspace.tree, v);
    turn_screws(model, &mut workspace.tree);
    accelerate_screws(model, &mut workspace.tree, None);
    let rate = whole_momentum_rate(model, &workspace.tree).linear;
    (rate * S::from_f64(1.0 / model.mass())).array()
}

/// Σ I V about the main reference point, from the twists in the workspace.
#[inline(always)]
pub(crate) fn whole_momentum<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> Force<S> {
    let mut sum = Force::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &tree.screws.world[i]);
        add_about_main(model, tree, i, &mut sum, &momentum_of(&inertia, &tree.screws.twist[i]));
    }
    sum
}

/// Adds a body's force or momentum.
#[inline(always)]
fn add_about_main<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    body: usize,
    sum: &mut Force<S>,
    own: &Force<S>,
) {
    sum.add(own);
    if model.points.several {
        sum.angular += from_main(model, tree, body).cross(own.linear);
    }
}

/// Σ I V̇ + V ×* I V about the main reference point: the rate of [`whole_momentum`].
#[inline(always)]
pub(crate) fn whole_momentum_rate<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> Force<S> {
    let mut sum = Force::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &tree.screws.world[i]);
        let mut own = momentum_of(&inertia, &tree.screws.twist_rate[i]);
        own.add(&force_cross(&tree.screws.twist[i], &momentum_of(&inertia, &tree.screws.twist[i])));
        add_about_main(model, tree, i, &mut sum, &own);
    }
    sum
}
