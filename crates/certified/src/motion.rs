//! Motions that are polynomials in time, evaluated over any number.

use core::fmt;
use std::error::Error;

use robot_dynamics_number::{Classified, ErrorKind, Scalar};

/// The coefficients of one coordinate in one piece: c₀ + c₁ s + … + c₅ s⁵, with s = 0 at its start.
pub type Polynomial = [f64; 6];

/// A motion q(t) of piecewise polynomials. Each piece has its own time s, from 0 to its duration.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialMotion {
    pieces: Vec<Piece>,
}

/// A piece of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its duration \[s\].
    pub duration: f64,
    /// A polynomial for each coordinate.
    pub coordinates: Vec<Polynomial>,
}

/// The points of a motion are invalid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InvalidMotion {
    /// There are fewer than two points.
    TooFewPoints,
    /// This point has another number of coordinates than the first.
    Lengths {
        /// Its index.
        point: usize,
    },
    /// A number of this point is not finite.
    NotFinite {
        /// Its index.
        point: usize,
    },
    /// The time of this point is not after that of the point before it.
    Times {
        /// Its index.
        point: usize,
    },
}

impl fmt::Display for InvalidMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewPoints => f.write_str("a motion needs two points or more"),
            Self::Lengths { point } => {
                write!(f, "point {point} of the motion has another number of coordinates than the first")
            }
            Self::NotFinite { point } => {
                write!(f, "point {point} of the motion has a number that is not finite")
            }
            Self::Times { point } => {
                write!(f, "the time of point {point} of the motion is not after that of the point before it")
            }
        }
    }
}

impl Error for InvalidMotion {}

impl Classified for InvalidMotion {
    fn kind(&self) -> ErrorKind {
        ErrorKind::InvalidInput
    }
}

impl PolynomialMotion {
    /// The motion from rest at `start` to rest at `end`, with zero acceleration at both:
    /// q = q₀ + (q₁ − q₀)(10 x³ − 15 x⁴ + 6 x⁵), x = t/duration. Coefficients are rounded to doubles.
    ///
    /// ```
    /// use robot_dynamics_certified::PolynomialMotion;
    /// let motion = PolynomialMotion::rest_to_rest(&[0.0], &[1.0], 2.0)?;
    /// let [q, v, _] = motion.state(0, 1.0);
    /// assert_eq!((q, v), (vec![0.5], vec![0.9375])); // half the way, at 15/8 of the mean velocity
    /// # Ok::<(), robot_dynamics_certified::InvalidMotion>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidMotion`] if the lengths differ, a number is not finite, or the duration is not positive.
    pub fn rest_to_rest(start: &[f64], end: &[f64], duration: f64) -> Result<Self, InvalidMotion> {
        check(&[0.0, duration], &[start.to_vec(), end.to_vec()])?;
        let polynomial = |(start, end): (&f64, &f64)| {
            let change = end - start;
            let cubed = duration * duration * duration;
            [
                *start,
                0.0,
                0.0,
                10.0 * change / cubed,
                -15.0 * change / (cubed * duration),
                6.0 * change / (cubed * duration * duration),
            ]
        };
        let coordinates = start.iter().zip(end).map(polynomial).collect();
        Ok(Self { pieces: vec![Piece { duration, coordinates }] })
    }

    /// The cubic spline through points at given times, at rest at both ends. Accelerations are continuous.
    ///
    /// The velocities at the points solve a tridiagonal system. Source: de Boor, *A Practical Guide to
    /// Splines*, Springer 2001, ch. IV.
    ///
    /// ```
    /// use robot_dynamics_certified::PolynomialMotion;
    /// let motion = PolynomialMotion::spline(&[0.0, 1.0, 2.0], &[vec![0.0], vec![0.5], vec![1.0]])?;
    /// assert_eq!(motion.pieces().len(), 2);
    /// assert!((motion.state(1, 0.0_f64)[1][0] - 0.75).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics_certified::InvalidMotion>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidMotion`] if there are fewer than two points, lengths differ, a number is not finite, or the
    /// times do not increase.
    pub fn spline(times: &[f64], points: &[Vec<f64>]) -> Result<Self, InvalidMotion> {
        check(times, points)?;
        let last = times.len() - 1;
        let steps: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
        let mut pieces: Vec<Piece> =
            steps.iter().map(|&duration| Piece { duration, coordinates: Vec::new() }).collect();
        for coordinate in 0..points[0].len() {
            let at = |k: usize| points[k][coordinate];
            let velocities = spline_velocities(&steps, &at);
            for k in 0..last {
                let (h, v, next) = (steps[k], velocities[k], velocities[k + 1]);
                let slope = (at(k + 1) - at(k)) / h;
                let square = (3.0 * slope - 2.0 * v - next) / h;
                let cube = (v + next - 2.0 * slope) / (h * h);
                pieces[k].coordinates.push([at(k), v, square, cube, 0.0, 0.0]);
            }
        }
        Ok(Self { pieces })
    }

    /// The pieces, in the order of time.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The time at which each piece starts \[s\].
    pub fn starts(&self) -> Vec<f64> {
        let mut end = 0.0;
        let of = |piece: &Piece| {
            let start = end;
            end += piece.duration;
            start
        };
        self.pieces.iter().map(of).collect()
    }

    /// The number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.pieces[0].coordinates.len()
    }

    /// q, v and a at time s of a piece, over any number.
    ///
    /// # Panics
    /// If the piece does not exist.
    pub fn state<S: Scalar>(&self, piece: usize, s: S) -> [Vec<S>; 3] {
        let mut state = [Vec::new(), Vec::new(), Vec::new()];
        for polynomial in &self.pieces[piece].coordinates {
            // Horner's scheme for the polynomial and its derivatives, whose coefficients are c·k and
            // c·k·(k − 1). These products are exact for the numbers' own type, so they are formed in it.
            let (mut q, mut v, mut a) = (S::zero(), S::zero(), S::zero());
            for (k, &c) in polynomial.iter().enumerate().rev() {
                let power = k as f64; // at most 5
                let c = S::from_f64(c);
                q = q * s + c;
                if k >= 1 {
                    v = v * s + c.scale(power);
                }
                if k >= 2 {
                    a = a * s + c.scale(power * (power - 1.0));
                }
            }
            for (to, x) in state.iter_mut().zip([q, v, a]) {
                to.push(x);
            }
        }
        state
    }
}

fn check(times: &[f64], points: &[Vec<f64>]) -> Result<(), InvalidMotion> {
    if points.len() < 2 || times.len() != points.len() {
        return Err(InvalidMotion::TooFewPoints);
    }
    for (point, (time, coordinates)) in times.iter().zip(points).enumerate() {
        if coordinates.len() != points[0].len() {
            return Err(InvalidMotion::Lengths { point });
        }
        if !time.is_finite() || coordinates.iter().any(|x| !x.is_finite()) {
            return Err(InvalidMotion::NotFinite { point });
        }
        if point > 0 && *time <= times[point - 1] {
            return Err(InvalidMotion::Times { point });
        }
    }
    Ok(())
}

/// The velocities at the points of a clamped cubic spline, by elimination in its tridiagonal system.
fn spline_velocities(steps: &[f64], at: &impl Fn(usize) -> f64) -> Vec<f64> {
    let last = steps.len();
    let mut velocities = vec![0.0; last + 1];
    let mut upper = vec![0.0; last + 1];
    for k in 1..last {
        let (before, after) = (steps[k - 1], steps[k]);
        let slopes = [(at(k) - at(k - 1)) / before, (at(k + 1) - at(k)) / after];
        // after·v₋ + 2 (before + after) v + before·v₊ = 3 (after·slope₋ + before·slope₊)
        let pivot = 2.0 * (before + after) - after * upper[k - 1];
        let right = 3.0 * (after * slopes[0] + before * slopes[1]);
        upper[k] = before / pivot;
        velocities[k] = (right - after * velocities[k - 1]) / pivot;
    }
    for k in (1..last).rev() {
        velocities[k] -= upper[k] * velocities[k + 1];
    }
    velocities
}
