//! Triangulates the polygons of a mesh file like MuJoCo's reader of OBJ files.
//!
//! The triangulation matters if the corners are not in one plane, and for MuJoCo's `legacy` inertia, which
//! counts all pyramids over triangles as positive.

use nalgebra::{Vector2, Vector3};

/// The largest number of comparisons of corners for the polygons of one file. The number grows with the
/// square of the number of corners of a polygon.
const COMPARISON_LIMIT: usize = 1_000_000_000;

/// Divides the polygons of one file into triangles.
#[derive(Default)]
pub(crate) struct Triangulation {
    /// The number of comparisons so far.
    comparisons: usize,
}

impl Triangulation {
    /// Adds the triangles of a polygon. A quadrilateral is split along its shorter diagonal, larger polygons
    /// by ear clipping.
    ///
    /// # Errors
    /// A message if the polygons have too many corners.
    pub(crate) fn add_triangles(
        &mut self,
        polygon: &[usize],
        points: &[Vector3<f64>],
        faces: &mut Vec<[usize; 3]>,
    ) -> Result<(), String> {
        match *polygon {
            [a, b, c] => faces.push([a, b, c]),
            [a, b, c, d] => {
                let (ac, bd) =
                    ((points[c] - points[a]).norm_squared(), (points[d] - points[b]).norm_squared());
                faces.extend(if ac < bd { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
            _ => {
                clip_ears(polygon, points, faces, &mut self.comparisons);
                if self.comparisons > COMPARISON_LIMIT {
                    return Err(format!(
                        "a polygon of {} corners needs more than {COMPARISON_LIMIT} comparisons; divide it into \
                         triangles",
                        polygon.len()
                    ));
                }
            }
        }
        Ok(())
    }
}

/// The triangle at a corner: the corners before and after it, and the first corner that was not compared with
/// the triangle, or that lies in it.
#[derive(Clone, Copy)]
struct Ear {
    ends: [usize; 2],
    at: usize,
}

/// Ear clipping: removes convex corners whose triangle contains no other corner, in a projection along the
/// normal. The comparisons of a triangle continue where they ended, so their number is quadratic.
fn clip_ears(
    polygon: &[usize],
    points: &[Vector3<f64>],
    faces: &mut Vec<[usize; 3]>,
    comparisons: &mut usize,
) {
    let next = |k: usize| polygon[(k + 1) % polygon.len()];
    let normal: Vector3<f64> = (0..polygon.len()).map(|k| points[polygon[k]].cross(&points[next(k)])).sum();
    // Projects along the axis that is closest to the normal. The order of the other two axes keeps the
    // orientation.
    let axis = normal.iamax();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = if normal[axis] >= 0.0 { (u, v) } else { (v, u) };
    let flat: Vec<Vector2<f64>> =
        polygon.iter().map(|&corner| Vector2::new(points[corner][u], points[corner][v])).collect();
    // The places of the corners that are left.
    let mut rest: Vec<usize> = (0..polygon.len()).collect();
    let mut is_left = vec![true; polygon.len()];
    let mut ears: Vec<Option<Ear>> = vec![None; polygon.len()];
    let mut at = 0;
    let mut tried = 0;
    while rest.len() > 3 && tried < rest.len() && *comparisons <= COMPARISON_LIMIT {
        let count = rest.len();
        let [a, b, c] = [0, 1, 2].map(|k| rest[(at + k) % count]);
        let [pa, pb, pc] = [a, b, c].map(|place| flat[place]);
        let corners = [a, b, c].map(|place| polygon[place]);
        let inside = |place: usize| {
            is_left[place]
                && !corners.contains(&polygon[place])
                && [(pa, pb), (pb, pc), (pc, pa)]
                    .iter()
                    .all(|(from, to)| (to - from).perp(&(flat[place] - from)) >= 0.0)
        };
        let is_convex = (pb - pa).perp(&(pc - pb)) > 0.0;
        let begin = ears[b].filter(|ear| ear.ends == [a, c]).map_or(0, |ear| ear.at);
        let end = if is_convex {
            (begin..polygon.len()).find(|&place| inside(place)).unwrap_or(polygon.len())
        } else {
            begin
        };
        ears[b] = Some(Ear { ends: [a, c], at: end });
        *comparisons = comparisons.saturating_add(1 + end - begin);
        if is_convex && end == polygon.len() {
            faces.push(corners);
            is_left[b] = false;
            rest.remove((at + 1) % count);
            at %= rest.len();
            tried = 0;
        } else {
            at = (at + 1) % count;
            tried += 1;
        }
    }
    // The rest has no ears, because it is degenerate or self-intersecting: a fan.
    for k in 1..rest.len().saturating_sub(1) {
        faces.push([rest[0], rest[k], rest[k + 1]].map(|place| polygon[place]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(points: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let points: Vec<Vector3<f64>> = points.iter().map(|&x| Vector3::from(x)).collect();
        let polygon: Vec<usize> = (0..points.len()).collect();
        let mut faces = Vec::new();
        Triangulation::default().add_triangles(&polygon, &points, &mut faces).unwrap();
        faces
    }

    fn area(points: &[[f64; 3]], faces: &[[usize; 3]]) -> f64 {
        let one = |face: &[usize; 3]| {
            let [a, b, c] = face.map(|corner| Vector3::from(points[corner]));
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        faces.iter().map(one).sum()
    }

    #[test]
    fn a_quadrilateral_by_its_shorter_diagonal() {
        let wide = [[0.0, 0.0, 0.0], [1.0, -0.2, 0.0], [3.0, 0.0, 0.0], [1.0, 0.2, 0.0]];
        assert_eq!(triangulate(&wide), [[0, 1, 3], [1, 2, 3]]);
    }

    /// An L-shaped polygon: a fan from its first corner would leave it.
    #[test]
    fn a_polygon_that_is_not_convex_keeps_its_area() {
        for swap in [false, true] {
            let mut l = [[2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0]]
                .map(|[x, y]| if swap { [y, 0.0, x] } else { [x, y, 0.0] });
            for _ in 0..6 {
                let faces = triangulate(&l);
                assert_eq!(faces.len(), 4);
                assert!((area(&l, &faces) - 3.0).abs() < 1e-15, "{faces:?}");
                l.rotate_left(1);
            }
        }
    }

    #[test]
    fn a_polygon_without_area_is_still_divided() {
        let line: Vec<[f64; 3]> = (0..6).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        assert_eq!(triangulate(&line).len(), 4);
    }

    /// A spiral of 8,000 corners, which has few ears at a time, and a comb.
    #[test]
    fn polygons_of_many_corners_keep_their_area_in_quadratic_time() {
        let count = 4000;
        let arm = |k: usize, width: f64| {
            let angle = 0.01 * k as f64;
            let radius = 1.0 + 0.1 * angle + width;
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let spiral: Vec<[f64; 3]> =
            (0..count).map(|k| arm(k, 0.3)).chain((0..count).rev().map(|k| arm(k, 0.0))).collect();
        let comb: Vec<[f64; 3]> =
            (0..count).flat_map(|k| [[k as f64, 0.0, 0.0], [k as f64 + 0.5, 1.0, 0.0]]).collect();
        for points in [spiral, comb.into_iter().chain([[1e4, 2.0, 0.0], [0.0, 2.0, 0.0]]).collect()] {
            let faces = triangulate(&points);
            assert_eq!(faces.len(), points.len() - 2);
            let next = |k: usize| points[(k + 1) % points.len()];
            let signed: f64 =
                (0..points.len()).map(|k| points[k][0] * next(k)[1] - points[k][1] * next(k)[0]).sum();
            let found = area(&points, &faces);
            assert!((found - 0.5 * signed.abs()).abs() < 1e-9 * found, "{found} {signed}");
        }
    }
}
