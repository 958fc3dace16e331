//! Kinetic and potential energy.
//!
//! K = ½ vᵀM v and V = −Σ m g·c + Σ ½ stiffness (q − rest)² are sums over the bodies and springs. Cost: O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{Sym3, V3};

use crate::kinematics::placement::{move_bodies, place_all_in_world, place_bodies, places_in_world};
use crate::model::native::NativeFunction;
use crate::spatial::motion::MotionVector;
use crate::workspace::native::{computed_natively, native_number};
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// K = ½ vᵀM v = Σ ½ m |v_c|² + ½ ωᵀI_c ω \[J\], computed body by body without M. Its derivatives are
/// [`kinetic_energy_gradient`](crate::kinetic_energy_gradient), ∂K/∂q, and [`momentum`](crate::momentum),
/// ∂K/∂v = M v.
///
/// ```
/// use robot_dynamics::algorithms::kinetic_energy;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let energy = kinetic_energy(&model, &mut Workspace::new(&model), &[0.3], &[3.0]);
/// assert!((energy - 0.5 * 2.0 * (0.5_f64 * 3.0).powi(2)).abs() < 1e-14); // ½ m (l v)²
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn kinetic_energy<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], v: &[S]) -> S {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    if let Some(energy) =
        native_number(model, &mut workspace.tree.native, NativeFunction::KineticEnergy, &[q, v])
    {
        return energy;
    }
    place_bodies(model, &mut workspace.tree, q);
    move_bodies(model, &mut workspace.tree, v);
    kinetic_of(model, &workspace.tree)
}

/// K after [`move_bodies`].
#[inline(always)]
fn kinetic_of<N: Scalar>(model: &Model, tree: &TreeMemory<N>) -> N {
    let mut twice = N::zero();
    for (body, &MotionVector { linear: u, angular: w }) in model.bodies.iter().zip(&tree.bodies.velocity) {
        let h = V3::constant(&body.first_moment);
        // About the origin: m|u|² + 2 u·(ω × h) + ωᵀIω.
        twice += u.dot(u).scale(body.mass)
            + u.dot(w.cross(h)).scale(2.0)
            + w.dot(Sym3::constant(&body.inertia) * w);
    }
    for (rate, dof) in tree.dofs.v.iter().zip(&model.dofs) {
        twice += (*rate * *rate).scale(dof.passive.armature);
    }
    for rotor in &model.rotors {
        twice += rotor.twice_energy(&tree.dofs.v);
    }
    twice.scale(0.5)
}

/// V = −Σ m g·c + Σ ½ stiffness (q − rest)² \[J\]. V is zero with every centre of mass at the world's origin
/// and all springs at rest. Links fixed to the world are left out: they would only add a constant. The
/// derivatives are [`gravity`](crate::gravity), ∂V/∂q, and [`gravity_derivative`](crate::gravity_derivative),
/// ∂²V/∂q².
///
/// ```
/// use robot_dynamics::algorithms::potential_energy;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let energy = potential_energy(&model, &mut Workspace::new(&model), &[0.3]);
/// assert!((energy + 2.0 * 9.81 * 0.5 * 0.3_f64.sin()).abs() < 1e-14); // m g z, z = −l sin q
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn potential_energy<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S]) -> S {
    workspace.check_inputs(model, q);
    if let Some(energy) =
        native_number(model, &mut workspace.tree.native, NativeFunction::PotentialEnergy, &[q])
    {
        return energy;
    }
    place_all_in_world(model, &mut workspace.tree, q);
    potential_of(model, &workspace.tree)
}

/// V from the bodies' placements in the world.
#[inline(always)]
fn potential_of<N: Scalar>(model: &Model, tree: &TreeMemory<N>) -> N {
    let gravity = V3::from_f64(model.gravity());
    let mut energy = N::zero();
    for (body, world) in model.bodies.iter().zip(&tree.world.pose) {
        let first_moment = world.rotation * V3::constant(&body.first_moment);
        energy -= gravity.dot(first_moment.add_scaled(N::from_f64(body.mass), world.translation));
    }
    for dof in model.dofs.iter().filter(|dof| dof.passive.stiffness != 0.0) {
        let stretch = tree.angles.angle[dof.body] - N::from_f64(dof.passive.rest);
        energy += (stretch * stretch).scale(0.5 * dof.passive.stiffness);
    }
    energy
}

/// K and V together, for the energy account of a run, which needs them at every step.
#[track_caller]
pub fn energies(model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) -> (f64, f64) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    let mut both = [0.0; 2];
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::Energies, &[q, v], &mut [&mut both]) {
        return both.into();
    }
    let tree = &mut workspace.tree;
    place_bodies(model, tree, q);
    move_bodies(model, tree, v);
    places_in_world(model, tree);
    (kinetic_of(model, tree), potential_of(model, tree))
}
