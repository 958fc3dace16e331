//! The terms of the equation of motion, by exact derivatives of the energies.

use robot_dynamics_core::{Joint, Model};
use robot_dynamics_description::check_length;
use robot_dynamics_number::{Dual, Scalar};

use super::{kinetic_energy, mass_matrix, potential_energy};

/// The number of directions of differentiation per evaluation; it does not affect the result.
const CHUNK: usize = 8;

/// q̇ = N(q) v: equal to v except for quaternion joints, where ẋ = R u and q̇ = ½ q ⊗ (w, 0).
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// // At q = 1 a rotation about z with ω changes the quaternion's z at the rate ω/2.
/// let rate = lagrange::position_rate(&model, &robot_dynamics::model::neutral(&model), &[1.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
/// assert_eq!(rate, [1.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn position_rate<S: Scalar>(model: &Model, q: &[S], v: &[S]) -> Vec<S> {
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), model.nv());
    let mut rate = vec![S::zero(); model.nq()];
    for joint in model.joints() {
        let (i, j) = (joint.q_index, joint.v_index);
        match free_part(joint) {
            None => rate[i..i + joint.nq].copy_from_slice(&v[j..j + joint.nv]),
            Some(FreePart::Turn) => quaternion_rate(&q[i..i + 4], &v[j..j + 3], &mut rate[i..i + 4]),
            Some(FreePart::Motion) => {
                let velocity = turned(&q[i + 3..i + 7], [v[j], v[j + 1], v[j + 2]]);
                rate[i..i + 3].copy_from_slice(&velocity);
                quaternion_rate(&q[i + 3..i + 7], &v[j + 3..j + 6], &mut rate[i + 3..i + 7]);
            }
        }
    }
    rate
}

enum FreePart {
    Turn,
    Motion,
}

/// The joints whose v is not a derivative of coordinates: those with more entries in q than in v.
fn free_part(joint: &Joint) -> Option<FreePart> {
    match (joint.nq, joint.nv) {
        (4, 3) => Some(FreePart::Turn),
        (7, 6) => Some(FreePart::Motion),
        _ => None,
    }
}

fn cross<S: Scalar>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// ½ (u, c) ⊗ (w, 0) = ½ (c w + u × w, −u·w) with u = (x y z).
fn quaternion_rate<S: Scalar>(xyzw: &[S], w: &[S], rate: &mut [S]) {
    let (u, c) = ([xyzw[0], xyzw[1], xyzw[2]], xyzw[3]);
    let across = cross(u, [w[0], w[1], w[2]]);
    for k in 0..3 {
        rate[k] = (c * w[k] + across[k]).scale(0.5);
    }
    rate[3] = (u[0] * w[0] + u[1] * w[1] + u[2] * w[2]).scale(-0.5);
}

/// R(q) a.
fn turned<S: Scalar>(xyzw: &[S], a: [S; 3]) -> [S; 3] {
    let (u, c) = ([xyzw[0], xyzw[1], xyzw[2]], xyzw[3]);
    let two = S::from_f64(2.0) / xyzw.iter().fold(S::zero(), |sum, &x| sum + x * x);
    let (once, twice) = (cross(u, a), cross(u, cross(u, a)));
    core::array::from_fn(|k| a[k] + (once[k] * c + twice[k]) * two)
}

/// q with derivatives along the motions of v's coordinates `start`, `start` + 1, ...: the argument of Xᵢ.
fn along_coordinates<S: Scalar>(model: &Model, q: &[S], start: usize) -> Vec<Dual<S, CHUNK>> {
    let mut moving: Vec<Dual<S, CHUNK>> = q.iter().map(|&x| Dual::constant(x)).collect();
    for k in 0..CHUNK.min(model.nv() - start) {
        let mut unit = vec![S::zero(); model.nv()];
        unit[start + k] = S::one();
        for (moving, rate) in moving.iter_mut().zip(position_rate(model, q, &unit)) {
            moving.gradient[k] = rate;
        }
    }
    moving
}

/// g(q) = X(V): the force that holds the robot at rest against gravity and its springs; ∂V/∂q if q̇ = v.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (slope, recursive) = (lagrange::gravity(&model, &q), model.gravity_forces(&q)?);
/// assert!(slope.iter().zip(&recursive).all(|(slope, recursive)| (slope - recursive).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if q has the wrong length.
#[track_caller]
pub fn gravity<S: Scalar>(model: &Model, q: &[S]) -> Vec<S> {
    let gradients = (0..model.nv())
        .step_by(CHUNK)
        .flat_map(|start| potential_energy(model, &along_coordinates(model, q, start)).gradient);
    gradients.take(model.nv()).collect()
}

/// C(q,v) v = Ṁv − X(K) + ad term: all forces at v̇ = 0 except gravity and springs.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (product, recursive) = (lagrange::velocity_product(&model, &q, &v), model.velocity_product(&q, &v)?);
/// assert!(product.iter().zip(&recursive).all(|(product, recursive)| (product - recursive).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn velocity_product<S: Scalar>(model: &Model, q: &[S], v: &[S]) -> Vec<S> {
    check_length("v", v.len(), model.nv());
    let nv = model.nv();
    // p = M v with its rate ṗ = Ṁ v along q̇ = N v.
    let path: Vec<Dual<S, 1>> = q
        .iter()
        .zip(position_rate(model, q, v))
        .map(|(&q, rate)| Dual { value: q, gradient: [rate] })
        .collect();
    let mass = mass_matrix(model, &path);
    let momentum: Vec<Dual<S, 1>> = (0..nv)
        .map(|i| (0..nv).fold(Dual::constant(S::zero()), |p, j| p + mass[i * nv + j] * Dual::constant(v[j])))
        .collect();
    let constant: Vec<Dual<S, CHUNK>> = v.iter().map(|&v| Dual::constant(v)).collect();
    let derivatives = (0..nv)
        .step_by(CHUNK)
        .flat_map(|start| kinetic_energy(model, &along_coordinates(model, q, start), &constant).gradient);
    let mut product: Vec<S> =
        momentum.iter().zip(derivatives).map(|(p, slope)| p.gradient[0] - slope).collect();
    for joint in model.joints() {
        add_ad_term(joint, v, &momentum, &mut product);
    }
    product
}

/// Rows of u: w × p_u. Rows of w: w × p_w + u × p_u. Armature is defined by its force armature·v̇, so its
/// part of p does not rotate with the body. This matters for a floating joint only, because w × w = 0.
fn add_ad_term<S: Scalar>(joint: &Joint, v: &[S], momentum: &[Dual<S, 1>], product: &mut [S]) {
    let velocity = |i: usize| -> [S; 3] { core::array::from_fn(|k| v[i + k]) };
    let of_bodies = |i: usize| momentum[i].value - v[i].scale(joint.passive.armature);
    let momentum = |i: usize| -> [S; 3] { core::array::from_fn(|k| of_bodies(i + k)) };
    let mut add = |i: usize, term: [S; 3]| (0..3).for_each(|k| product[i + k] += term[k]);
    let j = joint.v_index;
    match free_part(joint) {
        None => {}
        Some(FreePart::Turn) => add(j, cross(velocity(j), momentum(j))),
        Some(FreePart::Motion) => {
            let (u, w) = (velocity(j), velocity(j + 3));
            add(j, cross(w, momentum(j)));
            add(j + 3, cross(w, momentum(j + 3)));
            add(j + 3, cross(u, momentum(j)));
        }
    }
}

/// C(q,v) v + g(q).
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (bias, recursive) = (lagrange::bias(&model, &q, &v), model.bias(&q, &v)?);
/// assert!(bias.iter().zip(&recursive).all(|(bias, recursive)| (bias - recursive).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn bias<S: Scalar>(model: &Model, q: &[S], v: &[S]) -> Vec<S> {
    velocity_product(model, q, v).into_iter().zip(gravity(model, q)).map(|(c, g)| c + g).collect()
}

/// τ = M(q) a + C(q,v) v + g(q). **(PRM 10.7)**
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let tau = lagrange::inverse_dynamics(&model, &q, &v, &a);
/// let recursive = model.inverse_dynamics(&q, &v, &a)?; // an independent implementation
/// assert!(tau.iter().zip(&recursive).all(|(tau, recursive)| (tau - recursive).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn inverse_dynamics<S: Scalar>(model: &Model, q: &[S], v: &[S], a: &[S]) -> Vec<S> {
    check_length("a", a.len(), model.nv());
    let (nv, mass) = (model.nv(), mass_matrix(model, q));
    let bias = bias(model, q, v);
    (0..nv).map(|i| (0..nv).fold(bias[i], |tau, j| tau + mass[i * nv + j] * a[j])).collect()
}

/// a = M⁻¹(τ − C v − g), by Cholesky factorization; not finite if M is singular.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let a = lagrange::forward_dynamics(&model, &q, &v, &tau);
/// let recursive = model.forward_dynamics(&q, &v, &tau)?;
/// // κ(M) times rounding
/// assert!(a.iter().zip(&recursive).all(|(a, recursive)| (a - recursive).abs() < 1e-9 * (1.0 + a.abs())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn forward_dynamics<S: Scalar>(model: &Model, q: &[S], v: &[S], tau: &[S]) -> Vec<S> {
    check_length("tau", tau.len(), model.nv());
    let mut mass = mass_matrix(model, q);
    let mut a: Vec<S> = tau.iter().zip(bias(model, q, v)).map(|(&tau, bias)| tau - bias).collect();
    robot_dynamics_core::factorization::cholesky::factor(&mut mass, model.nv());
    robot_dynamics_core::factorization::cholesky::solve(&mass, model.nv(), &mut a);
    a
}
