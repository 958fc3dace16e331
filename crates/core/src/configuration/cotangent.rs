//! Conversion of gradients by q between displacements (nv numbers) and coordinates (nq numbers). Cost: O(n).
//!
//! x̄ = R ū for a floating joint's position, q̄ = 2 q ⊗ (w̄, 0)/|q|² for a quaternion. This is the gradient
//! of a function of the quaternion's direction, F(q/|q|). A function that depends on |q| has another
//! component along q.

use robot_dynamics_description::{check_length, rotation_of};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::configuration::displacement_rate::store;
use crate::configuration::manifold::{CoordinateRange, coordinate_ranges, vector_at};
use crate::joint::Chart;

/// Converts a gradient by displacements q ⊕ δ, nv numbers, to the gradient by the nq numbers of q.
///
/// To first order, q ⊕ δ with δ = (u, w) changes the numbers by N(q) δ. Plain coordinates change by δ, the
/// position of a floating joint by R u, and a quaternion by ½ q ⊗ (w, 0).
///
/// The gradient by a quaternion's four numbers also depends on the function off the unit sphere. Here the
/// function depends only on the **direction** of each quaternion, f(q) = F(q/|q|), as every function of this
/// library does. Its gradient is orthogonal to the quaternion:
///
/// x̄ = R ū, q̄ = 2 q ⊗ (w̄, 0)/|q|².
///
/// A function that does not divide by |q| has another component along q, and the same components orthogonal
/// to it. [`cotangent_from_coordinates`] is the inverse, for any extension off the sphere.
///
/// ```
/// use robot_dynamics::description::{Base, pendulum};
/// use robot_dynamics::model::{Model, cotangent_to_coordinates, neutral};
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
    // A mimic joint writes its leader's number again, with the same value.
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
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

/// Converts a gradient by the nq numbers of q to the gradient by displacements q ⊕ δ, nv numbers: N(q)ᵀ times
/// it.
///
/// The result does not depend on the function off the unit sphere. N(q) δ is tangent to the sphere, so the
/// component along a quaternion drops out. This function inverts [`cotangent_to_coordinates`].
///
/// ```
/// use robot_dynamics::model::{cotangent_from_coordinates, cotangent_to_coordinates};
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let options = RandomRobotOptions { base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v: gradient, .. } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
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
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
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

/// R of the floating joint whose position starts at entry `i` of q.
fn rotation_at<S: Scalar>(q: &[S], i: usize) -> robot_dynamics_number::algebra::M3<S> {
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
