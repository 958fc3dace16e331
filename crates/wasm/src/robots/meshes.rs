//! Meshes of a robot's shapes, whose contact shapes are their convex hulls.

use core::f64::consts::PI;

use nalgebra::Vector3;
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// Number of directions that select the extreme points of a large mesh, since a hull of thousands of corners
/// takes seconds.
const DIRECTIONS: usize = 256;

/// The mesh size above which points are selected.
fn outermost(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    if points.len() <= 2 * DIRECTIONS {
        return points;
    }
    let farthest = |d: Vector3<f64>| points.iter().max_by(|a, b| a.dot(&d).total_cmp(&b.dot(&d))).copied();
    on_sphere(DIRECTIONS).filter_map(farthest).collect()
}

/// Points spread evenly over the sphere: a spiral with the golden angle.
fn on_sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sine, cosine) = (golden * k as f64).sin_cos();
        Vector3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
    })
}

#[wasm_bindgen]
impl Robot {
    /// Sets the points of a shape's mesh, three numbers each, in the shape's frame \[m\]. Their convex hull
    /// is the contact shape after the next [`set_ground`](Self::set_ground). A large mesh keeps only a few
    /// hundred extreme points.
    #[wasm_bindgen(js_name = giveMesh)]
    pub fn give_mesh(&mut self, shape: usize, points: &[f64]) {
        let points: Vec<Vector3<f64>> = points.chunks_exact(3).map(Vector3::from_column_slice).collect();
        if points.iter().flatten().all(|x| x.is_finite()) {
            let corners = robot_dynamics_mesh::corners(&outermost(points));
            self.meshes.insert(shape, corners.into_iter().map(Into::into).collect());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of ten thousand points keeps its size except for the caps between 256 directions: 1 − cos of
    /// half their distance.
    #[test]
    fn many_points_keep_their_outline() {
        let kept = outermost(on_sphere(10_000).collect());
        assert_eq!(kept.len(), DIRECTIONS);
        for direction in
            [Vector3::z(), -Vector3::z(), Vector3::new(0.6, 0.0, -0.8), Vector3::new(0.0, -1.0, 0.0)]
        {
            let reach = kept.iter().map(|point| point.dot(&direction)).fold(0.0, f64::max);
            assert!(reach > 0.98 && reach < 1.0 + 1e-12, "{reach}");
        }
    }
}
