//! Upper bounds of support functions, stored on a grid of directions.
//!
//! The support function of a set X is h(m) = sup { m · x : x ∈ X }. It is sublinear: h(α a + β b) ≤ α h(a) +
//! β h(b) for α, β ≥ 0. Bounds at the vertices of a grid therefore give bounds in every direction, whose
//! overestimate falls with the square of the grid's step. Source: Schneider, *Convex Bodies: The
//! Brunn–Minkowski Theory*, 2nd ed., Cambridge 2014, §1.7.

use robot_dynamics_number::Scalar;

use crate::Interval;

pub(crate) type Vector = [Interval; 3];

pub(crate) fn dot(a: Vector, b: Vector) -> Interval {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Upper bounds of a support function on the six faces of a cube, each with a square grid.
#[derive(Clone, Debug)]
pub(crate) struct Support {
    /// Cells along an edge of a face; even, so that the axes are vertices.
    cells: usize,
    /// By face, row and column.
    bounds: Vec<f64>,
    /// h(m) ≤ this times |m₁| + |m₂| + |m₃|.
    largest: f64,
}

/// The vertices of the grid, in the order of the bounds. Their coordinates are exact if `cells` is a power of
/// two.
pub(crate) fn vertices(cells: usize) -> Vec<[f64; 3]> {
    let step = |k: usize| 2.0 * k as f64 / cells as f64 - 1.0;
    let mut vertices = Vec::new();
    for face in 0..6 {
        for i in 0..=cells {
            for j in 0..=cells {
                vertices.push(on_face(face, step(i), step(j)));
            }
        }
    }
    vertices
}

/// The point (u, v) of a face: faces 2k and 2k + 1 have coordinate k equal to 1 and −1.
fn on_face(face: usize, u: f64, v: f64) -> [f64; 3] {
    let mut point = [0.0; 3];
    point[face / 2] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    point[(face / 2 + 1) % 3] = u;
    point[(face / 2 + 2) % 3] = v;
    point
}

impl Support {
    /// From the bounds at [`vertices`].
    pub(crate) fn new(cells: usize, bounds: Vec<f64>) -> Self {
        let side = cells + 1;
        let center = |face: usize| bounds[(face * side + cells / 2) * side + cells / 2];
        let largest = (0..6).map(center).fold(0.0, f64::max);
        Self { cells, bounds, largest }
    }

    /// An upper bound of h(m) for all m of a small box.
    pub(crate) fn bound(&self, m: Vector) -> f64 {
        let near = m.map(Interval::middle);
        let axis = (0..3).max_by(|a, b| near[*a].abs().total_cmp(&near[*b].abs())).unwrap_or(0);
        let size = near[axis].abs();
        if size == 0.0 {
            return self.remainder(m);
        }
        let face = 2 * axis + usize::from(near[axis] < 0.0);
        let place = |x: f64| {
            let along = (x / size + 1.0) * 0.5 * self.cells as f64;
            let cell = index(along).min(self.cells - 1);
            (cell, (along - cell as f64).clamp(0.0, 1.0))
        };
        let (i, right) = place(near[(axis + 1) % 3]);
        let (j, up) = place(near[(axis + 2) % 3]);
        // The weights of a triangle's corners. They are rounded; the remainder of m counts separately.
        let corners = if right + up <= 1.0 {
            [(i, j, 1.0 - right - up), (i + 1, j, right), (i, j + 1, up)]
        } else {
            [(i + 1, j + 1, right + up - 1.0), (i + 1, j, 1.0 - up), (i, j + 1, 1.0 - right)]
        };
        let step = |k: usize| 2.0 * k as f64 / self.cells as f64 - 1.0;
        let (mut sum, mut rest) = (Interval::from(0.0), m);
        for (i, j, weight) in corners {
            let weight = Interval::from((weight * size).max(0.0));
            let side = self.cells + 1;
            sum += weight * Interval::from(self.bounds[(face * side + i) * side + j]);
            for (rest, x) in rest.iter_mut().zip(on_face(face, step(i), step(j))) {
                *rest -= weight * Interval::from(x);
            }
        }
        (sum + Interval::from(self.remainder(rest))).upper()
    }

    /// A bound for a small vector.
    fn remainder(&self, m: Vector) -> f64 {
        let size = m.iter().fold(Interval::from(0.0), |sum, x| sum + Interval::from(x.magnitude()));
        (size * Interval::from(self.largest)).upper()
    }
}

/// A number that is not negative, rounded down.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
fn index(x: f64) -> usize {
    x as usize
}

/// Angles that divide a range into steps of at most `step`, with sine and cosine, and an upper bound of
/// 1/cos(half a step).
pub(crate) struct Arc {
    pub(crate) angles: Vec<f64>,
    sines: Vec<(Interval, Interval)>,
    growth: f64,
}

impl Arc {
    pub(crate) fn new(range: Interval, step: f64) -> Self {
        let steps = (range.width() / step).ceil().max(1.0);
        let at =
            |k: usize| (range.lower() + range.width() * k as f64 / steps).clamp(range.lower(), range.upper());
        let mut angles: Vec<f64> = (0..index(steps)).map(at).collect();
        angles.push(range.upper());
        let width = |pair: &[f64]| (Interval::from(pair[1]) - Interval::from(pair[0])).upper();
        let widest = angles.windows(2).map(width).fold(0.0, f64::max);
        let half = Interval::from(widest) * Interval::from(0.5);
        let growth = (Interval::from(1.0) / half.sin_cos().1).upper();
        let sines = angles.iter().map(|angle| Interval::from(*angle).sin_cos()).collect();
        Self { angles, sines, growth }
    }

    /// An upper bound of h(Rᵀm) for rotations R about z by every angle of the arc, and the angle with the
    /// largest value. `slope` times the angle is added.
    ///
    /// Between two angles the direction is α a + β b + (1 − α − β) m_z e_z, with α, β ≥ 0 and α + β at most
    /// `growth`.
    pub(crate) fn largest(&self, h: &Support, m: Vector, slope: Interval) -> (f64, f64) {
        let value = |k: usize| {
            let (sine, cosine) = self.sines[k];
            let turned = [m[0] * cosine + m[1] * sine, m[1] * cosine - m[0] * sine, m[2]];
            Interval::from(h.bound(turned))
        };
        let shift = |k: usize| slope * Interval::from(self.angles[k]);
        let growth = Interval::new(1.0, self.growth);
        let rest =
            (growth - Interval::from(1.0)) * Interval::from(m[2].magnitude()) * Interval::from(h.largest);
        let (mut largest, mut angle, mut best) = (f64::NEG_INFINITY, self.angles[0], f64::NEG_INFINITY);
        let mut last = value(0);
        for k in 0..self.angles.len() {
            let next = if k == 0 { last } else { value(k) };
            let sum = (next + shift(k)).upper();
            if sum > best {
                (best, angle) = (sum, self.angles[k]);
            }
            let ends = Interval::new(last.upper().max(next.upper()), last.upper().max(next.upper()));
            let shifts = shift(k).hull(shift(k.saturating_sub(1)));
            largest = largest.max((growth * ends + rest + shifts).upper());
            last = next;
        }
        (largest, angle)
    }
}
