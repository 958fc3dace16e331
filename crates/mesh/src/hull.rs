//! The convex hull of points: what a mesh of points alone, or one of convex inertia, bounds.

use std::collections::HashSet;

use nalgebra::Vector3;

/// A face by its three corners, counter-clockwise as seen from outside.
type Face = [usize; 3];

/// The triangles around all points; `None` where they lie in a plane.
///
/// The hull grows point by point: a point outside replaces the faces that it sees by a fan from it to their rim. Points within
/// 1e-12 of the points' extent of a face count as on it, so volumes are right to about that.
///
/// ```
/// use nalgebra::Vector3;
/// let corner = |k: u8| Vector3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
/// let cube: Vec<Vector3<f64>> = (0..8).map(corner).collect();
/// assert_eq!(robot_mesh::hull(&cube).map(|faces| faces.len()), Some(12));
/// ```
pub fn hull(points: &[Vector3<f64>]) -> Option<Vec<[Vector3<f64>; 3]>> {
    let extent = points.iter().fold(0.0_f64, |most, point| most.max((point - points[0]).amax()));
    let on_face = 1e-12 * extent;
    let mut faces = first_four(points, on_face)?;
    // The farthest first: what is inside then is mostly found inside at once.
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        (points[b] - middle).norm_squared().total_cmp(&(points[a] - middle).norm_squared())
    });
    let mut rim = HashSet::new();
    for point in order {
        let sees = |face: &Face| height(points, face, points[point]) > on_face;
        if !faces.iter().any(sees) {
            continue;
        }
        rim.clear();
        faces.retain(|face| {
            let seen = sees(face);
            if seen {
                for (from, to) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
                    // Between two seen faces an edge comes in both directions, and is no rim.
                    if !rim.remove(&(to, from)) {
                        rim.insert((from, to));
                    }
                }
            }
            !seen
        });
        faces.extend(rim.iter().map(|&(from, to)| [from, to, point]));
    }
    Some(faces.into_iter().map(|face| face.map(|corner| points[corner])).collect())
}

/// The corners of the hull, each once; all points where they lie in a plane.
///
/// ```
/// use nalgebra::Vector3;
/// let corner = |k: u8| Vector3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
/// let mut cube: Vec<Vector3<f64>> = (0..8).map(corner).collect();
/// cube.push(Vector3::repeat(0.5));
/// assert_eq!(robot_mesh::corners(&cube).len(), 8);
/// ```
pub fn corners(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let all = hull(points).map_or_else(|| points.to_vec(), |faces| faces.into_iter().flatten().collect());
    let mut seen = HashSet::new();
    all.into_iter().filter(|point| seen.insert([point.x, point.y, point.z].map(f64::to_bits))).collect()
}

/// How far a point is in front of a face.
fn height(points: &[Vector3<f64>], face: &Face, point: Vector3<f64>) -> f64 {
    let [a, b, c] = face.map(|corner| points[corner]);
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    if length > 0.0 { normal.dot(&(point - a)) / length } else { 0.0 }
}

/// A tetrahedron of four points far apart.
fn first_four(points: &[Vector3<f64>], on_face: f64) -> Option<Vec<Face>> {
    let farthest = |distance: &dyn Fn(Vector3<f64>) -> f64| {
        let all = points.iter().enumerate().map(|(at, &point)| (distance(point), at));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|&(distance, _)| distance > on_face).map(|(_, at)| at)
    };
    let origin = *points.first()?;
    let a = farthest(&|point| (point - origin).norm())?;
    let b = farthest(&|point| (point - points[a]).norm())?;
    let along = (points[b] - points[a]).normalize();
    let c = farthest(&|point| (point - points[a]).cross(&along).norm())?;
    let normal = (points[b] - points[a]).cross(&(points[c] - points[a])).normalize();
    let d = farthest(&|point| normal.dot(&(point - points[a])).abs())?;
    let [b, c] = if normal.dot(&(points[d] - points[a])) > 0.0 { [c, b] } else { [b, c] };
    Some(vec![[a, b, c], [a, c, d], [c, b, d], [b, a, d]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::{MassProperties, SplitMix64};

    #[test]
    fn of_a_box_with_points_inside_and_on_it() {
        let mut points: Vec<Vector3<f64>> = Vec::new();
        for k in 0..27 {
            points.push(Vector3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)));
        }
        let body = MassProperties::solid_mesh(1.0, &hull(&points).expect("a hull")).expect("a body");
        assert!((body.mass() - 8.0).abs() < 1e-13, "{body:?}");
        assert!((body.inertia_about_center_of_mass()[(0, 0)] - 8.0 / 12.0 * 8.0).abs() < 1e-13);
    }

    /// Of random points: none is outside, and the hull is closed, so that its area vectors add up to nothing.
    #[test]
    fn holds_all_points_and_is_closed() {
        let mut random = SplitMix64::new(7);
        let points: Vec<Vector3<f64>> =
            (0..500).map(|_| Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0))).collect();
        let faces = hull(&points).expect("a hull");
        let mut total = Vector3::zeros();
        for [a, b, c] in &faces {
            let normal = (b - a).cross(&(c - a));
            total += normal;
            assert!(points.iter().all(|point| normal.dot(&(point - a)) <= 1e-12 * normal.norm()));
        }
        assert!(total.amax() < 1e-12, "{total}");
    }

    #[test]
    fn points_in_a_plane_have_none() {
        let flat: Vec<Vector3<f64>> =
            (0..9).map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3), 0.0)).collect();
        assert!(hull(&flat).is_none());
        assert!(hull(&[]).is_none());
        assert!(hull(&[Vector3::zeros(); 5]).is_none());
    }
}
