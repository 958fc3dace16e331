//! The convex hull of points: what a mesh of points alone, or one of convex inertia, bounds.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// A face that the hull has or had.
struct Face {
    /// Its corners, counter-clockwise as seen from outside.
    corners: [usize; 3],
    /// Twice its area.
    area: f64,
    /// Points in front of it that are on no other face's list.
    outside: Vec<usize>,
    /// Whether a later point has seen it, so that it is inside now.
    buried: bool,
}

/// The triangles around all points; `None` where they lie in a plane.
///
/// Quickhull (Barber, Dobkin and Huhdanpaa 1996): each face has a list of points in front of it; the farthest of them replaces the
/// faces that it sees by a fan from it to their rim. Which faces it sees is decided exactly (Shewchuk 1997), so that the hull stays
/// closed whatever points nearly lie in a plane. Points within 1e-12 of the points' extent of a face count as on it, so volumes are
/// right to about that.
///
/// ```
/// use nalgebra::Vector3;
/// let corner = |k: u8| Vector3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
/// let cube: Vec<Vector3<f64>> = (0..8).map(corner).collect();
/// assert_eq!(robot_mesh::hull(&cube).map(|faces| faces.len()), Some(12));
/// ```
pub fn hull(points: &[Vector3<f64>]) -> Option<Vec<[Vector3<f64>; 3]>> {
    let extent = points.iter().fold(0.0_f64, |most, point| most.max((point - points[0]).amax()));
    let mut hull = Hull { points, on_face: 1e-12 * extent, faces: Vec::new(), left_of: HashMap::new() };
    for corners in first_four(points, hull.on_face)? {
        hull.add(corners);
    }
    hull.share(0..points.len(), 0);
    let mut at = 0;
    while at < hull.faces.len() {
        match hull.farthest_outside(at) {
            Some(point) => hull.reach(point, at),
            None => at += 1,
        }
    }
    let outermost = hull.faces.iter().filter(|face| !face.buried);
    Some(outermost.map(|face| face.corners.map(|corner| points[corner])).collect())
}

/// A hull while it grows.
struct Hull<'a> {
    points: &'a [Vector3<f64>],
    /// How far in front of a face a point may be and still count as on it.
    on_face: f64,
    faces: Vec<Face>,
    /// By an edge from corner to corner, the face that has it on its rim in this direction.
    left_of: HashMap<(usize, usize), usize>,
}

impl Hull<'_> {
    /// Adds a face.
    fn add(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let area = (b - a).cross(&(c - a)).norm();
        for edge in edges(corners) {
            self.left_of.insert(edge, self.faces.len());
        }
        self.faces.push(Face { corners, area, outside: Vec::new(), buried: false });
    }

    /// How far a point is in front of a face: of the right sign, and right to the digits of the area.
    fn height(&self, face: &Face, point: usize) -> f64 {
        let [a, b, c] = face.corners;
        let volume = orient3d(self.coord(a), self.coord(b), self.coord(c), self.coord(point));
        if face.area > 0.0 { -volume / face.area } else { 0.0 }
    }

    fn coord(&self, point: usize) -> Coord3D<f64> {
        let at = &self.points[point];
        Coord3D { x: at.x, y: at.y, z: at.z }
    }

    /// Puts each point on the list of the first face, from `first` on, that it is in front of.
    fn share(&mut self, points: impl IntoIterator<Item = usize>, first: usize) {
        for point in points {
            let in_front = |face: &Face| self.height(face, point) > self.on_face;
            if let Some(at) = (first..self.faces.len()).find(|&at| in_front(&self.faces[at])) {
                self.faces[at].outside.push(point);
            }
        }
    }

    /// The point of a face's list that is farthest from it; none where the face is buried.
    fn farthest_outside(&self, at: usize) -> Option<usize> {
        let face = &self.faces[at];
        let heights = face.outside.iter().map(|&point| (self.height(face, point), point));
        heights.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
    }

    /// Makes a point that is in front of this face a corner.
    fn reach(&mut self, point: usize, at: usize) {
        let (mut seen, mut rim, mut next) = (vec![at], Vec::new(), 0);
        self.faces[at].buried = true;
        while next < seen.len() {
            for (from, to) in edges(self.faces[seen[next]].corners) {
                let beyond = self.left_of[&(to, from)];
                if self.faces[beyond].buried {
                    continue;
                }
                if self.height(&self.faces[beyond], point) > 0.0 {
                    self.faces[beyond].buried = true;
                    seen.push(beyond);
                } else {
                    rim.push((from, to));
                }
            }
            next += 1;
        }
        let first = self.faces.len();
        for (from, to) in rim {
            self.add([from, to, point]);
        }
        for face in seen {
            let orphans = std::mem::take(&mut self.faces[face].outside);
            self.share(orphans, first);
        }
    }
}

/// The edges of a face, from corner to corner.
fn edges<T: Copy>([a, b, c]: [T; 3]) -> [(T, T); 3] {
    [(a, b), (b, c), (c, a)]
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

/// A tetrahedron of four points far apart.
fn first_four(points: &[Vector3<f64>], on_face: f64) -> Option<[[usize; 3]; 4]> {
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
    Some([[a, b, c], [a, c, d], [c, b, d], [b, a, d]])
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

    #[test]
    fn of_random_points() {
        let mut random = SplitMix64::new(7);
        let points: Vec<Vector3<f64>> =
            (0..500).map(|_| Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0))).collect();
        assert!(holds_and_is_closed(&points) < 500);
    }

    /// A tube askew, its ends full of points, each point several times, as in mesh files. With numbers of ten digits the ends are
    /// flat to hardly more than rounding: a hull whose faces are compared by rounded heights grows and grows.
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

    /// The number of faces of a hull that has no point outside and all around whose edges two faces meet.
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
            // Of slivers the direction is known to their height alone.
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
