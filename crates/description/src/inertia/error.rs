//! Errors of mass properties.

use core::fmt;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};

/// The reason why mass properties are invalid: the error of the constructors of
/// [`MassProperties`](crate::MassProperties) and [`RotationalInertia`](crate::RotationalInertia).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertiaError {
    /// A number is not finite, a mass, a density or a length is not positive, or a composite body has no
    /// parts.
    Input(Box<InvalidInput>),
    /// The inertia matrix is not symmetric.
    NotSymmetric {
        /// Row of the worse of the two entries.
        row: usize,
        /// Its column.
        column: usize,
        /// The entry at (row, column) \[kg·m²\].
        upper: f64,
        /// The entry at (column, row) \[kg·m²\].
        lower: f64,
    },
    /// A principal moment is negative.
    NegativeMoment {
        /// The principal moments, ascending \[kg·m²\].
        moments: [f64; 3],
    },
    /// The largest principal moment exceeds the sum of the other two.
    TriangleInequality {
        /// The principal moments, ascending \[kg·m²\].
        moments: [f64; 3],
    },
    /// A principal moment is zero: the body is a line or a point, and its spin about that axis is
    /// undetermined.
    SingularMoment {
        /// The principal moments, ascending \[kg·m²\].
        moments: [f64; 3],
    },
}

impl Classified for InertiaError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            _ => ErrorKind::Description,
        }
    }
}

impl fmt::Display for InertiaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::NotSymmetric { row, column, upper, lower } => write!(
                f,
                "the inertia is not symmetric: entry ({row}, {column}) is {upper}, entry ({column}, {row}) is {lower}"
            ),
            Self::NegativeMoment { moments } => {
                let [a, b, c] = moments.map(six_digits);
                write!(f, "a principal moment is negative: {a}, {b}, {c} kg·m²; no mass distribution has it")
            }
            Self::TriangleInequality { moments } => {
                let [a, b, c] = moments.map(six_digits);
                let excess = six_digits(moments[2] - moments[0] - moments[1]);
                write!(
                    f,
                    "the principal moments {a}, {b}, {c} kg·m² break the triangle inequality: the largest exceeds \
                     the sum of the others by {excess}; check the units and whether the inertia is about the centre \
                     of mass"
                )
            }
            Self::SingularMoment { moments } => {
                let [a, b, c] = moments.map(six_digits);
                write!(
                    f,
                    "the principal moments are {a}, {b}, {c} kg·m²: about the first axis the body has no inertia, \
                     so a torque about it determines no motion; give the body some width"
                )
            }
        }
    }
}

impl core::error::Error for InertiaError {}

impl From<InvalidInput> for InertiaError {
    fn from(error: InvalidInput) -> Self {
        Self::Input(Box::new(error))
    }
}

/// Formats a number with at most six digits, and with a power of ten if it is very large or small, for
/// messages.
///
/// ```
/// assert_eq!(robot_dynamics_description::six_digits(-2.4e-35), "-2.4e-35");
/// assert_eq!(robot_dynamics_description::six_digits(1.0 / 3.0), "0.333333");
/// ```
pub fn six_digits(x: f64) -> String {
    // The exponent form rounds to six digits. The rest moves its point: a parser of floats and its tables
    // would be 10 kB of a page.
    let rounded = format!("{x:.5e}");
    let Some((mantissa, exponent)) = rounded.split_once('e') else { return rounded };
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    let digits = mantissa.trim_start_matches('-').replace('.', "");
    let sign = if mantissa.starts_with('-') { "-" } else { "" };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    match usize::try_from(exponent) {
        _ if digits == "0" => format!("{sign}0"),
        Ok(after @ 0..=6) if after + 1 >= digits.len() => format!("{sign}{digits:0<0$}", after + 1),
        Ok(after @ 0..=6) => format!("{sign}{}.{}", &digits[..=after], &digits[after + 1..]),
        Err(_) if exponent >= -4 => {
            let width = digits.len() + exponent.unsigned_abs() as usize - 1;
            format!("{sign}0.{digits:0>width$}")
        }
        _ => format!("{mantissa}e{exponent}"),
    }
}

/// Rejects a list with a NaN or an infinity.
pub(super) fn finite(quantity: &'static str, values: &[f64]) -> Result<(), InvalidInput> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(not_finite(quantity, index)),
        None => Ok(()),
    }
}

/// Rejects a number that is not finite and positive.
pub(super) fn positive(quantity: &'static str, value: f64) -> Result<(), InvalidInput> {
    finite(quantity, &[value])?;
    if value > 0.0 { Ok(()) } else { Err(not_positive(quantity, value)) }
}

// These functions are not inlined, so that the code of their texts occurs once in a program.

#[cold]
#[inline(never)]
fn not_finite(quantity: &'static str, index: usize) -> InvalidInput {
    InvalidInput::unmet(format!("{quantity}[{index}]"), "is not finite")
}

#[cold]
#[inline(never)]
fn not_positive(quantity: &'static str, value: f64) -> InvalidInput {
    InvalidInput::unmet(format!("the {quantity}"), format!("is {value}; it must be positive"))
}

/// The error of a negative mass.
#[cold]
#[inline(never)]
pub(super) fn negative_mass(mass: f64) -> InvalidInput {
    InvalidInput::unmet("the mass", format!("is {mass} kg; a body's mass is zero or positive"))
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::six_digits;

    /// The text is the shortest one of the number rounded to six digits, as Rust prints it.
    #[test]
    fn six_digits_are_those_of_the_rounded_number() {
        let by_parsing = |x: f64| {
            let rounded: f64 = format!("{x:.5e}").parse().expect("a number");
            if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) {
                format!("{rounded}")
            } else {
                format!("{rounded:e}")
            }
        };
        let mut random = SplitMix64::new(7);
        let check = |x: f64| assert_eq!(six_digits(x), by_parsing(x), "{x:e}");
        for x in
            [0.0, -0.0, 1.0, -10.0, 1e-4, 9.999_999e-5, 9_999_999.0, 1e7, 123_456.0, f64::INFINITY, f64::NAN]
        {
            check(x);
        }
        for exponent in -12..12 {
            for _ in 0..200 {
                let x = random.uniform(-10.0, 10.0);
                check(x * 10_f64.powi(exponent));
                check((x * 10.0).round() * 10_f64.powi(exponent));
            }
        }
    }
}
