//! Contact points of boxes, cylinders and convex meshes with each other, by the crate parry: separating axes,
//! or GJK and EPA, then clipped faces.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::SharedShape;

use super::closest_points::ClosestPoints;
use super::contact_geometry::ContactGeometry;
use super::placed_shape::PlacedShape;

/// A shape in parry's form.
#[derive(Clone, Debug)]
pub(super) struct Convex {
    shape: SharedShape,
    /// `shape_from_own`: parry's cylinders stand along y.
    turn: Matrix3<f64>,
}

/// The reason why other pairs are left out.
pub(super) const KNOWN: &str =
    "ellipsoids, and meshes without a convex hull, are not known to touch other shapes";

impl Convex {
    /// `None` for shapes that parry does not support.
    pub(super) fn new(form: &ContactGeometry) -> Option<Self> {
        let vector = |v: &Vector3<f64>| Vector::new(v.x, v.y, v.z);
        let mut turn = Matrix3::identity();
        let shape = match form {
            ContactGeometry::Rounded { centers, radius } if form.is_line() => match &centers[..] {
                [one, two] => SharedShape::capsule(vector(one), vector(two), *radius),
                _ => SharedShape::ball(*radius),
            },
            ContactGeometry::Rounded { centers, .. } => {
                let half = centers[0].abs();
                if centers.len() == 8 && centers.iter().all(|corner| corner.abs() == half) {
                    SharedShape::cuboid(half.x, half.y, half.z)
                } else {
                    SharedShape::convex_hull(&centers.iter().map(vector).collect::<Vec<_>>())?
                }
            }
            ContactGeometry::Cylinder { radius, half } => {
                turn = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
                SharedShape::cylinder(*half, *radius)
            }
            ContactGeometry::Ellipsoid(_) => return None,
        };
        Some(Self { shape, turn })
    }

    /// Calls `visit` with the contact points or nearest points of two shapes, if these are within this
    /// distance \[m\].
    pub(super) fn meet(
        &self,
        other: &Self,
        placed: &[PlacedShape; 2],
        within: f64,
        mut visit: impl FnMut(ClosestPoints),
    ) {
        let [one, two] = [(self, &placed[0]), (other, &placed[1])];
        let turns = [one, two].map(|(own, placed)| placed.rotation * own.turn);
        let apart = turns[0].tr_mul(&(placed[1].center - placed[0].center));
        let between = Rotation3::from_matrix_unchecked(turns[0].tr_mul(&turns[1]));
        let [x, y, z, w] = UnitQuaternion::from_rotation_matrix(&between).coords.into();
        let pose = Pose::from_parts(Vector::new(apart.x, apart.y, apart.z), Rotation::from_xyzw(x, y, z, w));
        let mut manifold = ContactManifold::<(), ()>::default();
        let found = DefaultQueryDispatcher.contact_manifold_convex_convex(
            &pose,
            &*self.shape,
            &*other.shape,
            None,
            None,
            within,
            &mut manifold,
        );
        if found.is_err() {
            return;
        }
        let vector = |v: Vector| Vector3::new(v.x, v.y, v.z);
        let out = turns[0] * vector(manifold.local_n1);
        for point in &manifold.points {
            let a = placed[0].center + turns[0] * vector(point.local_p1);
            let b = placed[1].center + turns[1] * vector(point.local_p2);
            visit(ClosestPoints { gap: (b - a).dot(&out), at: (a + b) * 0.5, normal: -out });
        }
    }
}
