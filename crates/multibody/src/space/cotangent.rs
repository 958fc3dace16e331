//! Cotangents of configurations: in the directions of v, and in the numbers of q.

use dynamics::Scalar;

use crate::Model;
use crate::joint::Chart;
use crate::model::length::check_length;
use crate::space::configuration::{Stretch, stretches, vector_at};
use crate::space::displacement_rate::store;
use crate::spatial::algebra::V3;
use crate::spatial::quaternion::rotation_of;

/// A gradient by displacements q ⊕ δ, nv numbers, as the gradient by the nq numbers of q.
///
/// q ⊕ δ moves the numbers by N(q) δ to first order: the plain ones by δ, the position of a floating joint by R u and a
/// quaternion by ½ q ⊗ (w, 0), δ = (u, w). A function of q has one gradient by δ, but a quaternion's four numbers may leave
/// the unit sphere, and what the function is there has to be said: here it depends on the **direction** of each quaternion
/// alone, f(q) = F(q/|q|), as every function of this library does. Its gradient is orthogonal to the quaternion and is
///
/// x̄ = R ū, q̄ = 2 q ⊗ (w̄, 0)/|q|².
///
/// Whoever writes functions of stored quaternions that do not divide by |q| has another gradient along q, and the same one
/// across it. [`cotangent_from_coordinates`] is the way back, for any extension.
///
/// ```
/// use multibody::{Base, Model, cotangent_to_coordinates, neutral, pendulum};
/// let mut thrown = pendulum(2.0, 0.5);
/// thrown.base = Base::Floating;
/// let model = Model::new(thrown)?;
/// let mut coordinates = vec![0.0; model.nq()];
/// cotangent_to_coordinates(&model, &neutral(&model), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], &mut coordinates);
/// assert_eq!(coordinates, [1.0, 2.0, 3.0, 8.0, 10.0, 12.0, 0.0, 7.0]); // ẇ = 0 at the identity
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn cotangent_to_coordinates<S: Scalar>(model: &Model, q: &[S], cotangent: &[S], coordinates: &mut [S]) {
    check_length("q", q.len(), model.nq);
    check_length("the cotangent", cotangent.len(), model.nv);
    check_length("the cotangent in coordinates", coordinates.len(), model.nq);
    // A follower writes its leader's number again.
    for Stretch { chart, q: i, v: k } in stretches(model) {
        match chart {
            Chart::Line => coordinates[i] = cotangent[k],
            Chart::Rotation => turn(&q[i..], vector_at(cotangent, k), &mut coordinates[i..]),
            Chart::Placement => {
                store(rotation_at(q, i) * vector_at(cotangent, k), &mut coordinates[i..]);
                turn(&q[i + 3..], vector_at(cotangent, k + 3), &mut coordinates[i + 3..]);
            }
        }
    }
}

/// A gradient by the nq numbers of q as the gradient by displacements q ⊕ δ, nv numbers: N(q)ᵀ times it.
///
/// It is right whatever the function is off the unit sphere, as N(q) δ is tangent to it; what the gradient has along a
/// quaternion is dropped. After [`cotangent_to_coordinates`] it gives back what was given.
///
/// ```
/// use multibody::{cotangent_from_coordinates, cotangent_to_coordinates};
/// # use multibody::*;
/// # let options = RandomRobotOptions { base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v: gradient, .. } = random_state(&model, &mut dynamics::SplitMix64::new(1));
/// let (mut coordinates, mut back) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
/// cotangent_to_coordinates(&model, &q, &gradient, &mut coordinates);
/// cotangent_from_coordinates(&model, &q, &coordinates, &mut back);
/// assert!(back.iter().zip(&gradient).all(|(back, x)| (back - x).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn cotangent_from_coordinates<S: Scalar>(model: &Model, q: &[S], coordinates: &[S], cotangent: &mut [S]) {
    check_length("q", q.len(), model.nq);
    check_length("the cotangent in coordinates", coordinates.len(), model.nq);
    check_length("the cotangent", cotangent.len(), model.nv);
    for Stretch { chart, q: i, v: k } in stretches(model) {
        match chart {
            Chart::Line => cotangent[k] = coordinates[i],
            Chart::Rotation => turn_back(&q[i..], &coordinates[i..], &mut cotangent[k..]),
            Chart::Placement => {
                store(rotation_at(q, i).transpose_mul(vector_at(coordinates, i)), &mut cotangent[k..]);
                turn_back(&q[i + 3..], &coordinates[i + 3..], &mut cotangent[k + 3..]);
            }
        }
    }
}

/// R of the floating joint whose numbers start at entry `i` of q.
fn rotation_at<S: Scalar>(q: &[S], i: usize) -> crate::spatial::algebra::M3<S> {
    rotation_of(&[q[i + 3], q[i + 4], q[i + 5], q[i + 6]])
}

/// 2 q ⊗ (w, 0)/|q|², q = (x y z w).
fn turn<S: Scalar>(q: &[S], w: V3<S>, to: &mut [S]) {
    let (vector, scalar) = (vector_at(q, 0), q[3]);
    let k = S::from_f64(2.0) / (vector.dot(vector) + scalar * scalar);
    store(vector.cross(w).add_scaled(scalar, w) * k, to);
    to[3] = -(vector.dot(w) * k);
}

/// The transpose of w ↦ ½ q ⊗ (w, 0).
fn turn_back<S: Scalar>(q: &[S], of: &[S], to: &mut [S]) {
    let (vector, scalar) = (vector_at(q, 0), q[3]);
    let x = vector_at(of, 0);
    store(x.cross(vector).add_scaled(scalar, x).sub_scaled(of[3], vector) * S::from_f64(0.5), to);
}
