//! The point of a triangle that is nearest to the origin.

use nalgebra::Vector3;

/// The barycentric coordinates of the point of a triangle nearest to the origin. The corners' products
/// determine in which of the seven regions of the triangle's plane the origin lies. **(Ericson, *Real-Time
/// Collision Detection*, 2005, § 5.1.5)**
pub(super) fn nearest([a, b, c]: &[Vector3<f64>; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|edge| -edge.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let [d3, d4] = [ab, ac].map(|edge| -edge.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let along_c = d1 * d4 - d3 * d2;
    if along_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let share = d1 / (d1 - d3);
        return [1.0 - share, share, 0.0];
    }
    let [d5, d6] = [ab, ac].map(|edge| -edge.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let along_b = d5 * d2 - d1 * d6;
    if along_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let share = d2 / (d2 - d6);
        return [1.0 - share, 0.0, share];
    }
    let along_a = d3 * d6 - d5 * d4;
    if along_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - share, share];
    }
    let sum = along_a + along_b + along_c;
    [along_a / sum, along_b / sum, along_c / sum]
}

/// The point with these barycentric coordinates.
pub(super) fn mixed([a, b, c]: &[Vector3<f64>; 3], [s, t, u]: [f64; 3]) -> Vector3<f64> {
    a * s + b * t + c * u
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// Compared with a search over a fine grid. No point of the triangle is nearer, by the condition of the
    /// minimum: x·(y − x) ≥ 0 for each corner y.
    #[test]
    fn no_point_of_a_triangle_is_nearer() {
        let mut random = SplitMix64::new(3);
        for case in 0..2000 {
            let mut corner = || Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0));
            let triangle = [corner(), corner(), corner()];
            let shares = nearest(&triangle);
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "case {case}: {shares:?}");
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "case {case}: {shares:?}");
            let x = mixed(&triangle, shares);
            for corner in &triangle {
                // Thin triangles lose digits.
                assert!(x.dot(&(corner - x)) > -1e-10, "case {case}: {x} of {triangle:?}");
            }
        }
    }
}
