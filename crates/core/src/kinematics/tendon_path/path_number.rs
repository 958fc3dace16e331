//! Closed formulas of lengths, over numbers with derivatives.

use core::f64::consts::TAU;

use robot_dynamics_number::Dual;

use crate::kinematics::body_placement::VectorNumber;

/// A number for formulas of lengths.
pub(super) trait PathNumber: VectorNumber {
    /// Its value without derivatives.
    fn number(self) -> f64;

    /// The angle whose sine and cosine have this ratio.
    fn angle(sine: Self, cosine: Self) -> Self;
}

impl PathNumber for f64 {
    fn number(self) -> f64 {
        self
    }

    fn angle(sine: Self, cosine: Self) -> Self {
        sine.atan2(cosine)
    }
}

impl<S: PathNumber, const N: usize> PathNumber for Dual<S, N> {
    fn number(self) -> f64 {
        self.value.number()
    }

    fn angle(sine: Self, cosine: Self) -> Self {
        let (s, c) = (sine.value, cosine.value);
        let square = s * s + c * c;
        let gradient = core::array::from_fn(|k| (c * sine.gradient[k] - s * cosine.gradient[k]) / square);
        Self { value: S::angle(s, c), gradient }
    }
}

pub(super) fn dot<S: PathNumber>(a: &[S; 3], b: &[S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<S: PathNumber>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| a[i] * b[j] - a[j] * b[i])
}

pub(super) fn norm<S: PathNumber>(a: &[S; 3]) -> S {
    let square = dot(a, a);
    // The derivatives are not defined for a vector of zeros.
    if square.number() == 0.0 { S::zero() } else { square.sqrt() }
}

/// The distance of two points.
pub(super) fn straight<S: PathNumber>([from, to]: &[[S; 3]; 2]) -> S {
    norm(&[0, 1, 2].map(|k| to[k] - from[k]))
}

/// The length of two tangents and an arc: √(|a|² − r²) + √(|b|² − r²) + r (θ − acos(r/|a|) − acos(r/|b|))
/// with the angle θ from a to b on the side of the path.
pub(super) fn around<S: PathNumber>([a, b]: &[[S; 3]; 2], radius: f64, arc: f64) -> S {
    let number = S::from_f64;
    let between = S::angle(norm(&cross(a, b)), dot(a, b));
    let mut length = number(0.0);
    let mut tangents = number(0.0);
    for end in [a, b] {
        let tangent = (dot(end, end) - number(radius * radius)).sqrt();
        length += tangent;
        tangents += S::angle(tangent, number(radius));
    }
    let shorter = radius * (between.number() - tangents.number());
    let longer = radius * (TAU - between.number() - tangents.number());
    let turned = if (shorter - arc).abs() <= (longer - arc).abs() { between } else { number(TAU) - between };
    length + (turned - tangents) * number(radius)
}
