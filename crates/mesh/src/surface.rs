//! The surface that the triangles of a mesh form: its orientation, and whether it is closed.

use std::collections::{HashMap, HashSet};

use crate::Triangles;

/// The number of edges where a surface is open; 0 for a closed one. Points at the same place are one point.
/// Each inner edge of an oriented surface belongs to two triangles, which pass it in opposite directions.
///
/// # Errors
/// A message if a triangle occurs twice, or if triangles pass an edge in the same direction.
///
/// ```
/// use nalgebra::Vector3;
/// use robot_dynamics_mesh::{Triangles, open_edges};
/// let points = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let closed = Triangles { points, faces: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]] };
/// assert_eq!(open_edges(&closed), Ok(0));
/// let open = Triangles { faces: closed.faces[1..].to_vec(), ..closed.clone() };
/// assert_eq!(open_edges(&open), Ok(3));
/// let twice = Triangles { faces: closed.faces.repeat(2), ..closed };
/// assert_eq!(open_edges(&twice).unwrap_err(), "triangle [0, 2, 1] occurs twice");
/// ```
pub fn open_edges(mesh: &Triangles) -> Result<usize, String> {
    let mut first_at_place = HashMap::new();
    let same: Vec<usize> = (mesh.points.iter().enumerate())
        // Adding 0 turns -0 into 0.
        .map(|(k, point)| *first_at_place.entry(point.map(|x| (x + 0.0).to_bits())).or_insert(k))
        .collect();
    let mut seen = HashSet::new();
    let mut balance: HashMap<[usize; 2], [usize; 2]> = HashMap::new();
    for face in &mesh.faces {
        let [a, b, c] = face.map(|corner| same[corner]);
        if a == b || b == c || c == a {
            continue;
        }
        let smallest_first = [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
        if !seen.insert(smallest_first) {
            return Err(format!("triangle {face:?} occurs twice"));
        }
        for [from, to] in [[a, b], [b, c], [c, a]] {
            balance.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    let inconsistent = balance
        .iter()
        .filter(|(_, [ahead, back])| ahead != back && ahead.max(back) > &1)
        .map(|(edge, _)| edge);
    if let Some([a, b]) = inconsistent.min() {
        let message = "pass the edge in the same direction; turn the triangles so that all are \
                       counter-clockwise from outside";
        return Err(format!("triangles between the points {a} and {b} {message}"));
    }
    Ok(balance.values().filter(|[ahead, back]| ahead != back).count())
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// Two tetrahedra that share an edge: four triangles meet there, two in each direction.
    #[test]
    fn bodies_that_touch_at_an_edge_are_closed() {
        let points = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]];
        let tetrahedron = |[a, b, c, d]: [usize; 4]| [[a, c, b], [a, d, c], [a, b, d], [b, c, d]];
        let mesh = Triangles {
            points: points.map(|point| Vector3::from(point).cast()).to_vec(),
            faces: [tetrahedron([0, 2, 3, 1]), tetrahedron([0, 4, 5, 1])].concat(),
        };
        assert_eq!(open_edges(&mesh), Ok(0));
        // The same with points of its own for each triangle.
        let soup = Triangles {
            points: mesh.faces.iter().flatten().map(|&corner| mesh.points[corner]).collect(),
            faces: (0..mesh.faces.len()).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        assert_eq!(open_edges(&soup), Ok(0));
    }

    #[test]
    fn a_turned_triangle_is_found_and_a_flat_one_ignored() {
        let points = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        let faces = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3], [1, 1, 2]];
        let mut mesh = Triangles { points, faces };
        assert_eq!(open_edges(&mesh), Ok(0));
        mesh.faces[3].swap(0, 1);
        let message = open_edges(&mesh).unwrap_err();
        assert!(message.contains("points 1 and 2"), "{message}");
    }
}
