//! Products of three-vectors and matrices compared with nalgebra, for each scalar type.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{RandomRobotOptions, random_robot};
use robot_dynamics_number::algebra::{M3, Sym3, V3, padded};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, SplitMix64, View};

use crate::workspace::compiled_once::run_on_machine;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// Every product equals nalgebra's at random points without symmetry. Entries are below 1 and sums have at
/// most nine terms: 1e-15 is four rounding errors.
fn products_are_nalgebras<S: Scalar>(value: fn(S) -> f64) {
    let mut random = SplitMix64::new(42);
    for _ in 0..100 {
        let mut vector = || Vector3::from_fn(|_, _| random.uniform(-0.5, 0.5));
        let (a, b) = (vector(), vector());
        let (m, n) =
            (Matrix3::from_columns(&[vector(), vector(), a]), Matrix3::from_columns(&[b, vector(), a]));
        let s = (m + m.transpose()) * 0.5;
        let ours = |v: Vector3<f64>| V3::<S>::from_f64(v.into());
        let full = |m: &Matrix3<f64>| M3::<S>::constant(&m.data.0.map(padded));
        let symmetric = Sym3::from_columns(&full(&s));
        let near = |found: V3<S>, expected: Vector3<f64>| {
            assert!(
                (Vector3::from(found.array().map(value)) - expected).amax() < 1e-15,
                "{found:?} {expected}"
            );
        };
        let near_matrix = |found: M3<S>, expected: Matrix3<f64>| {
            (0..3).for_each(|j| near(found.column(j), expected.column(j).into()));
            let rows = found.rows().map(|row| row.map(value));
            assert!((Matrix3::from(rows).transpose() - expected).amax() < 1e-15);
        };
        let k = S::from_f64(0.3);
        assert!((value(ours(a).dot(ours(b))) - a.dot(&b)).abs() < 1e-15);
        near(ours(a) + ours(b), a + b);
        near(ours(a) - ours(b), a - b);
        near(-ours(a), -a);
        near(ours(a) * k, a * 0.3);
        near(ours(a).cross(ours(b)), a.cross(&b));
        near(ours(a).cross_z(k), a.cross(&Vector3::new(0.0, 0.0, 0.3)));
        near(ours(a).add_scaled(k, ours(b)), a + b * 0.3);
        near(full(&m) * ours(a), m * a);
        near(full(&m).transpose_mul(ours(a)), m.transpose() * a);
        near(M3::skew(ours(a)) * ours(b), a.cross(&b));
        near(symmetric * ours(a), s * a);
        near_matrix(M3::spin_gradient(ours(a), ours(b)), {
            let [w, alpha] = [a, b].map(|x| x.cross_matrix());
            alpha + w * w
        });
        near_matrix(full(&m).times(&full(&n)), m * n);
        near_matrix(full(&m).times_transpose(&full(&n)), m * n.transpose());
        near_matrix(full(&m).minus_outer(ours(a), ours(b)), m - a * b.transpose());
        near_matrix(
            full(&m).minus_scaled_outer(ours(a), ours(b), k, ours(b) * k),
            m - a * b.transpose() * 0.3,
        );
        near_matrix(symmetric.minus_square(ours(a), k, ours(a) * k).full(), s - a * a.transpose() * 0.3);
        near_matrix(symmetric.plus_multiple_of_identity(k).full(), s + Matrix3::identity() * 0.3);
        near(ours(a).cross_sum(ours(b), ours(b), ours(a)), a.cross(&b) + b.cross(&a));
        near(ours(a).sub_scaled(k, ours(b)), a - b * 0.3);
        near(full(&m).times_plus(ours(a), ours(b)), m * a + b);
        near_matrix(full(&m).transpose(), m.transpose());
        near_matrix(full(&m) + full(&n), m + n);
        near_matrix(full(&m) - full(&n), m - n);
        near_matrix(symmetric.rotated(&full(&n)).full(), n * s * n.transpose());
        near_matrix((symmetric + symmetric).full(), s + s);
    }
}

#[test]
fn plain_products_are_nalgebras() {
    products_are_nalgebras::<f64>(|x| x);
}

struct Products;

impl Kernel<TreeStorage, f64> for Products {
    #[inline(always)]
    fn run<N: View<f64>, H: Hardware>(self, _: &mut TreeMemory<N>) {
        products_are_nalgebras::<N>(View::value);
    }
}

#[test]
fn products_in_vector_registers_are_nalgebras() {
    let model = Model::new(random_robot(1, &RandomRobotOptions::default())).unwrap();
    run_on_machine(&mut Workspace::<f64>::new(&model).tree, &mut Some(Products));
}
