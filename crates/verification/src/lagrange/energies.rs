//! The two energies K(q,v) and V(q), and the mass matrix.

use robot_dynamics_core::{Joint, Model};
use robot_dynamics_description::{JointDescription, MassProperties, check_length};
use robot_dynamics_number::Scalar;

use super::kinematics::{LinkKinematics, joint_source, link_kinematics};
use crate::lagrange::algebra::{M3, V3};

/// A link's mass, center of mass and inertia, and the Jacobians of the latter two, in the world's axes.
struct MovingMass<S> {
    mass: f64,
    center: V3<S>,
    inertia: M3<S>,
    /// Columns of J_c and J_ω.
    linear: Vec<V3<S>>,
    angular: Vec<V3<S>>,
}

impl<S: Scalar> MovingMass<S> {
    fn new(link: &LinkKinematics<S>, properties: &MassProperties) -> Self {
        let center: [f64; 3] = properties.center_of_mass().into();
        let center = center.map(S::from_f64);
        let rotation = M3(link.rotation());
        let inertia = properties.inertia_about_center_of_mass();
        let inertia = M3::from_f64(core::array::from_fn(|i| core::array::from_fn(|j| inertia[(i, j)])));
        Self {
            mass: properties.mass(),
            center: V3(link.point(center)),
            inertia: rotation.times(&inertia).times(&rotation.transpose()),
            linear: link.point_jacobian(center).into_iter().map(V3).collect(),
            angular: link.angular_jacobian().into_iter().map(V3).collect(),
        }
    }
}

/// Every link with mass that some joint moves.
fn moving_masses<S: Scalar>(model: &Model, q: &[S]) -> Vec<MovingMass<S>> {
    let links = link_kinematics(model, q);
    let described = &model.description().links;
    let with_mass = described.iter().zip(&links).filter(|(_, link)| link.moving);
    with_mass.filter_map(|(d, link)| Some(MovingMass::new(link, d.mass_properties.as_ref()?))).collect()
}

/// The joints' descriptions with their entries in the model; a floating base has no description and no
/// passive force.
fn joints(model: &Model) -> impl Iterator<Item = (&JointDescription, &Joint)> {
    model.description().joints.iter().map(|d| (d, model.joint(&d.name).expect("in the model")))
}

/// For each tendon with armature, the armature and the row c of ∂ℓ/∂q over the coordinates.
fn rotors(model: &Model) -> impl Iterator<Item = (f64, Vec<f64>)> {
    let tendons = model.description().tendons.iter().filter(|tendon| tendon.passive.armature != 0.0);
    tendons.map(|tendon| {
        let mut row = vec![0.0; model.nv()];
        for (name, c) in &tendon.terms {
            let joint = model.description().joints.iter().find(|joint| joint.name == *name).expect("checked");
            // A locked joint does not move.
            if joint.kind.nv() == 1 {
                let place = joint_source(model, joint);
                row[place.v_index] += c * place.ratio;
            }
        }
        (tendon.passive.armature, row)
    })
}

/// M(q) = Σ (m J_cᵀJ_c + J_ωᵀ R 𝓘 Rᵀ J_ω) + armature, and for tendons armature·c cᵀ: nv×nv, row-major. **(PRM
/// 10.6)**
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let mass = lagrange::mass_matrix(&model, &q);
/// let recursive = model.mass_matrix(&q)?;
/// assert!((nalgebra::DMatrix::from_row_slice(model.nv(), model.nv(), &mass) - recursive).amax() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if q has the wrong length.
#[track_caller]
pub fn mass_matrix<S: Scalar>(model: &Model, q: &[S]) -> Vec<S> {
    let nv = model.nv();
    let mut mass = vec![S::zero(); nv * nv];
    for body in moving_masses(model, q) {
        for j in 0..nv {
            let (momentum, spin) =
                (body.linear[j].0.map(|x| x.scale(body.mass)), body.inertia * body.angular[j]);
            for i in 0..nv {
                mass[i * nv + j] += body.linear[i].dot(V3(momentum)) + body.angular[i].dot(spin);
            }
        }
    }
    for (joint, _) in joints(model) {
        let place = joint_source(model, joint);
        for k in 0..joint.kind.nv() {
            let reflected = joint.passive.armature * place.ratio * place.ratio;
            mass[(place.v_index + k) * (nv + 1)] += S::from_f64(reflected);
        }
    }
    for (armature, row) in rotors(model) {
        for i in 0..nv {
            for j in 0..nv {
                mass[i * nv + j] += S::from_f64(armature * row[i] * row[j]);
            }
        }
    }
    mass
}

/// K = Σ (½ m |J_c v|² + ½ (J_ω v)ᵀ R 𝓘 Rᵀ J_ω v) + Σ ½ armature v² \[J\], without M.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let energy = lagrange::kinetic_energy(&model, &q, &v);
/// assert!((energy / model.kinetic_energy(&q, &v)? - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn kinetic_energy<S: Scalar>(model: &Model, q: &[S], v: &[S]) -> S {
    check_length("v", v.len(), model.nv());
    let times_v = |jacobian: &[V3<S>]| {
        jacobian.iter().zip(v).fold(V3::zero(), |sum: V3<S>, (column, &v)| sum + *column * v)
    };
    let mut twice = S::zero();
    for body in moving_masses(model, q) {
        let (velocity, omega) = (times_v(&body.linear), times_v(&body.angular));
        twice += velocity.dot(velocity).scale(body.mass) + omega.dot(body.inertia * omega);
    }
    for (joint, _) in joints(model) {
        let place = joint_source(model, joint);
        for k in 0..joint.kind.nv() {
            let rate = v[place.v_index + k].scale(place.ratio);
            twice += (rate * rate).scale(joint.passive.armature);
        }
    }
    for (armature, row) in rotors(model) {
        let rate = row.iter().zip(v).fold(S::zero(), |sum, (&c, &v)| sum + v.scale(c));
        twice += (rate * rate).scale(armature);
    }
    twice.scale(0.5)
}

/// V = −Σ m g·c + Σ ½ stiffness (q − rest)² \[J\]. Links that no joint moves are excluded, because they only
/// add a constant to V.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let energy = lagrange::potential_energy(&model, &q);
/// assert!((energy - model.potential_energy(&q)?).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if q has the wrong length.
#[track_caller]
pub fn potential_energy<S: Scalar>(model: &Model, q: &[S]) -> S {
    let gravity = V3::from_f64(model.gravity());
    let mut energy = S::zero();
    for body in moving_masses(model, q) {
        energy -= gravity.dot(body.center).scale(body.mass);
    }
    for (joint, _) in joints(model).filter(|(joint, _)| joint.passive.stiffness != 0.0) {
        let place = joint_source(model, joint);
        for k in 0..joint.kind.nv() {
            let position = q[place.q_index + k].scale(place.ratio) + S::from_f64(place.offset);
            let stretch = position - S::from_f64(joint.passive.rest);
            energy += (stretch * stretch).scale(0.5 * joint.passive.stiffness);
        }
    }
    energy
}
