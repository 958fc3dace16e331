//! Triangulates the polygons of a mesh file like MuJoCo's reader of OBJ files.
//!
//! The triangulation matters if the corners are not in one plane, and for MuJoCo's `legacy` inertia, which
//! counts all pyramids over triangles as positive.

use nalgebra::{Vector2, Vector3};

/// Adds the triangles of a polygon. A quadrilateral is split along its shorter diagonal, larger polygons by
/// ear clipping.
pub(crate) fn add_triangles(polygon: &[usize], points: &[Vector3<f64>], faces: &mut Vec<[usize; 3]>) {
    match *polygon {
        [a, b, c] => faces.push([a, b, c]),
        [a, b, c, d] => {
            let (ac, bd) = ((points[c] - points[a]).norm_squared(), (points[d] - points[b]).norm_squared());
            faces.extend(if ac < bd { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
        _ => clip_ears(polygon, points, faces),
    }
}

/// Ear clipping: removes convex corners whose triangle contains no other corner, in a projection along the
/// normal.
fn clip_ears(polygon: &[usize], points: &[Vector3<f64>], faces: &mut Vec<[usize; 3]>) {
    let mut rest = polygon.to_vec();
    let next = |k: usize| polygon[(k + 1) % polygon.len()];
    let normal: Vector3<f64> = (0..polygon.len()).map(|k| points[polygon[k]].cross(&points[next(k)])).sum();
    // Projects along the axis that is closest to the normal. The order of the other two axes keeps the
    // orientation.
    let axis = normal.iamax();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = if normal[axis] >= 0.0 { (u, v) } else { (v, u) };
    let flat = |corner: usize| Vector2::new(points[corner][u], points[corner][v]);
    let mut at = 0;
    let mut tried = 0;
    while rest.len() > 3 && tried < rest.len() {
        let count = rest.len();
        let [a, b, c] = [0, 1, 2].map(|k| rest[(at + k) % count]);
        let [pa, pb, pc] = [a, b, c].map(flat);
        let inside = |corner: usize| {
            let p = flat(corner);
            ![a, b, c].contains(&corner)
                && [(pa, pb), (pb, pc), (pc, pa)]
                    .iter()
                    .all(|(from, to)| (to - from).perp(&(p - from)) >= 0.0)
        };
        if (pb - pa).perp(&(pc - pb)) > 0.0 && !rest.iter().any(|&corner| inside(corner)) {
            faces.push([a, b, c]);
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
        faces.push([rest[0], rest[k], rest[k + 1]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(points: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let points: Vec<Vector3<f64>> = points.iter().map(|&x| Vector3::from(x)).collect();
        let polygon: Vec<usize> = (0..points.len()).collect();
        let mut faces = Vec::new();
        add_triangles(&polygon, &points, &mut faces);
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
}
