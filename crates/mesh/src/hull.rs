//! The convex hull of points.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// A face of the hull, or a removed face.
struct Face {
    /// Its corners, counter-clockwise from outside.
    corners: [usize; 3],
    /// Twice its area.
    area: f64,
    /// The points in front of it that are not in the list of another face.
    outside: Vec<usize>,
    /// Whether it has been removed because it is inside the hull.
    is_removed: bool,
}

/// The triangles of the convex hull of points; `None` if they lie in a plane.
///
/// Quickhull (Barber, Dobkin and Huhdanpaa 1996): each face has a list of points in front of it. The farthest
/// of them replaces all faces that are visible from it by a fan to their horizon. Visibility is decided by an
/// exact predicate (Shewchuk 1997), so that the hull stays closed for nearly coplanar points. Points closer
/// to a face than 1e-12 of the extent count as on the face, so volumes have about that relative accuracy.
///
/// ```
/// use nalgebra::Vector3;
/// let corner = |k: u8| Vector3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
/// let cube: Vec<Vector3<f64>> = (0..8).map(corner).collect();
/// assert_eq!(robot_dynamics_mesh::hull(&cube).map(|faces| faces.len()), Some(12));
/// ```
pub fn hull(points: &[Vector3<f64>]) -> Option<Vec<[Vector3<f64>; 3]>> {
    let extent = points.iter().fold(0.0_f64, |most, point| most.max((point - points[0]).amax()));
    let mut hull =
        Hull { points, tolerance: 1e-12 * extent, faces: Vec::new(), face_of_edge: HashMap::new() };
    for corners in first_four(points, hull.tolerance)? {
        hull.add(corners);
    }
    hull.assign(0..points.len(), 0);
    let mut at = 0;
    while at < hull.faces.len() {
        match hull.farthest_outside(at) {
            Some(point) => hull.extend_to(point, at),
            None => at += 1,
        }
    }
    let outermost = hull.faces.iter().filter(|face| !face.is_removed);
    Some(outermost.map(|face| face.corners.map(|corner| points[corner])).collect())
}

/// A hull under construction.
struct Hull<'a> {
    points: &'a [Vector3<f64>],
    /// Points with at most this height above a face count as on it.
    tolerance: f64,
    faces: Vec<Face>,
    /// The face of each directed edge.
    face_of_edge: HashMap<(usize, usize), usize>,
}

impl Hull<'_> {
    /// Adds a face.
    fn add(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let area = (b - a).cross(&(c - a)).norm();
        for edge in edges(corners) {
            self.face_of_edge.insert(edge, self.faces.len());
        }
        self.faces.push(Face { corners, area, outside: Vec::new(), is_removed: false });
    }

    /// The height of a point above a face. The sign is exact, and the value has the accuracy of the area.
    fn height(&self, face: &Face, point: usize) -> f64 {
        let [a, b, c] = face.corners;
        let volume = orient3d(self.coord(a), self.coord(b), self.coord(c), self.coord(point));
        if face.area > 0.0 { -volume / face.area } else { 0.0 }
    }

    fn coord(&self, point: usize) -> Coord3D<f64> {
        let at = &self.points[point];
        Coord3D { x: at.x, y: at.y, z: at.z }
    }

    /// Adds each point to the list of the first face, from `first` on, that it is in front of.
    fn assign(&mut self, points: impl IntoIterator<Item = usize>, first: usize) {
        for point in points {
            let in_front = |face: &Face| self.height(face, point) > self.tolerance;
            if let Some(at) = (first..self.faces.len()).find(|&at| in_front(&self.faces[at])) {
                self.faces[at].outside.push(point);
            }
        }
    }

    /// The farthest point in the list of a face; `None` if the list is empty.
    fn farthest_outside(&self, at: usize) -> Option<usize> {
        let face = &self.faces[at];
        let heights = face.outside.iter().map(|&point| (self.height(face, point), point));
        heights.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
    }

    /// Extends the hull to a point in front of this face.
    fn extend_to(&mut self, point: usize, at: usize) {
        let (mut visible, mut horizon, mut next) = (vec![at], Vec::new(), 0);
        self.faces[at].is_removed = true;
        while next < visible.len() {
            for (from, to) in edges(self.faces[visible[next]].corners) {
                let beyond = self.face_of_edge[&(to, from)];
                if self.faces[beyond].is_removed {
                    continue;
                }
                if self.height(&self.faces[beyond], point) > 0.0 {
                    self.faces[beyond].is_removed = true;
                    visible.push(beyond);
                } else {
                    horizon.push((from, to));
                }
            }
            next += 1;
        }
        let first = self.faces.len();
        for (from, to) in horizon {
            self.add([from, to, point]);
        }
        for face in visible {
            let orphans = std::mem::take(&mut self.faces[face].outside);
            self.assign(orphans, first);
        }
    }
}

/// The directed edges of a face.
fn edges<T: Copy>([a, b, c]: [T; 3]) -> [(T, T); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The distinct corners of the convex hull; the distinct points if they lie in a plane.
///
/// ```
/// use nalgebra::Vector3;
/// let corner = |k: u8| Vector3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
/// let mut cube: Vec<Vector3<f64>> = (0..8).map(corner).collect();
/// cube.push(Vector3::repeat(0.5));
/// assert_eq!(robot_dynamics_mesh::corners(&cube).len(), 8);
/// ```
pub fn corners(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let all = hull(points).map_or_else(|| points.to_vec(), |faces| faces.into_iter().flatten().collect());
    let mut seen = HashSet::new();
    all.into_iter().filter(|point| seen.insert([point.x, point.y, point.z].map(f64::to_bits))).collect()
}

/// The faces of a tetrahedron of four distant points; `None` if all points lie in a plane.
fn first_four(points: &[Vector3<f64>], tolerance: f64) -> Option<[[usize; 3]; 4]> {
    let farthest = |distance: &dyn Fn(Vector3<f64>) -> f64| {
        let all = points.iter().enumerate().map(|(at, &point)| (distance(point), at));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|&(distance, _)| distance > tolerance).map(|(_, at)| at)
    };
    let origin = *points.first()?;
    let a = farthest(&|point| (point - origin).norm())?;
    let b = farthest(&|point| (point - points[a]).norm())?;
    let along = (points[b] - points[a]).normalize();
    let c = farthest(&|point| (point - points[a]).cross(&along).norm())?;
    let normal = (points[b] - points[a]).cross(&(points[c] - points[a])).normalize();
    let d = farthest(&|point| normal.dot(&(point - points[a])).abs())?;
    let [b, c] = if normal.dot(&(points[d] - points[a])) > 0.0 { [c, b] } else { [b, c] };
    Some([[a, b, c], [a, c, d], [c, b, d], [b, a, d]])
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::MassProperties;
    use robot_dynamics_number::SplitMix64;

    use super::*;

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

    #[test]
    fn of_random_points() {
        let mut random = SplitMix64::new(7);
        let points: Vec<Vector3<f64>> =
            (0..500).map(|_| Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0))).collect();
        assert!(holds_and_is_closed(&points) < 500);
    }

    /// A rotated tube with many points on its ends, each several times, as in mesh files. With coordinates of
    /// ten digits the ends are flat nearly to rounding. An algorithm that compares rounded heights adds faces
    /// without end here.
    #[test]
    fn of_flat_ends_to_ten_digits() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, 1.1, -0.7);
        let mut points = Vec::new();
        for (end, ring, k) in
            (0..2).flat_map(|end| (1..20).flat_map(move |ring| (0..90).map(move |k| (end, ring, k))))
        {
            let (sine, cosine) = (f64::from(k) * std::f64::consts::TAU / 90.0).sin_cos();
            let radius = 0.01 * f64::from(ring);
            let point = turn * Vector3::new(radius * cosine, radius * sine, 0.3 * f64::from(end));
            points.extend([point.map(|x| (1e10 * x).round() / 1e10); 3]);
        }
        let faces = holds_and_is_closed(&points);
        assert!(faces < 2 * points.len() / 3, "{faces}");
    }

    /// Checks that no point is outside the hull and that every edge has two faces. Returns the number of
    /// faces.
    fn holds_and_is_closed(points: &[Vector3<f64>]) -> usize {
        let faces = hull(points).expect("a hull");
        let extent = points.iter().fold(0.0_f64, |most, point| most.max(point.amax()));
        let key = |point: &Vector3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
        let mut around = HashMap::new();
        for [a, b, c] in &faces {
            for (from, to) in edges([a, b, c].map(key)) {
                *around.entry((from, to)).or_insert(0) += 1;
            }
            let normal = (b - a).cross(&(c - a));
            // The normal of a sliver has an accuracy that depends on its height.
            let across =
                normal.norm() / [b - a, c - b, a - c].map(|edge| edge.norm()).into_iter().fold(0.0, f64::max);
            let bound = 1e-12 * extent + 1e-15 * extent * extent / across;
            assert!(points.iter().all(|point| normal.dot(&(point - a)) <= bound * normal.norm()));
        }
        assert!(around.iter().all(|(&(from, to), &count)| count == 1 && around.contains_key(&(to, from))));
        faces.len()
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
