//! Invalid arguments: the error that names them, and the checks that find them.

use std::error::Error;
use std::fmt;

use crate::{Classified, ErrorKind};

/// An argument with an invalid value.
///
/// ```
/// use robot_dynamics_number::{InputProblem, check_finite};
/// let error = check_finite("v", &[0.0, f64::INFINITY]).expect_err("an infinite velocity");
/// assert_eq!(error.quantity, "v");
/// assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(1), .. }));
/// assert_eq!(error.to_string(), "v[1] is inf; every number must be finite");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "ConfigurationError")]
#[doc(alias = "AdaptiveOptionsError")]
pub struct InvalidInput {
    /// The argument: `q`, `v`, `the step`, `the stiffness`, ...
    pub quantity: String,
    /// The problem with its value.
    pub problem: InputProblem,
}

/// The problem with the value of an argument.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InputProblem {
    /// Too many or too few numbers.
    WrongLength {
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        expected: usize,
        /// The object that determines the length, for example ``robot `arm` ``.
        owner: String,
        /// A hint after the message, or an empty text.
        hint: &'static str,
    },
    /// A number is NaN or infinite.
    #[doc(alias = "NonFinite")]
    NotFinite {
        /// The index of the entry; `None` if the argument is a single number.
        index: Option<usize>,
        /// The joint of an entry of q, or the coordinate of an entry of v, a or τ.
        coordinate: Option<String>,
        /// Its value.
        value: f64,
    },
    /// A number is out of its range.
    OutOfRange {
        /// Its value.
        value: f64,
        /// Its unit, or an empty text.
        unit: &'static str,
        /// The requirement, for example `positive and finite`.
        requirement: String,
    },
    /// A quaternion in q does not have unit length.
    NotAUnitQuaternion {
        /// The index of the first of its four numbers.
        first: usize,
        /// Its joint.
        joint: String,
        /// Its length.
        norm: f64,
    },
    /// A matrix is not a rotation.
    NotARotation {
        /// The larger of max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// A result is not finite although all arguments are.
    Overflow {
        /// The value computed.
        value: f64,
    },
    /// The argument does not meet a requirement of its function.
    #[doc(alias = "ContactError")]
    Unmet {
        /// The end of the message after the argument: `must be a unit vector`.
        requirement: String,
    },
    /// A name that does not exist; the argument is the sort of the named object, for example `pose`.
    UnknownName {
        /// The given name.
        name: String,
        /// The object that has the names, for example ``robot `arm` ``.
        owner: String,
        /// The end of the message, which lists the existing names.
        known: String,
    },
}

impl InvalidInput {
    /// The error of an argument with this problem.
    pub fn new(quantity: impl Into<String>, problem: InputProblem) -> Self {
        Self { quantity: quantity.into(), problem }
    }

    /// The error of a number out of its range. `requirement` completes "it must be …"; `unit` may be empty.
    ///
    /// ```
    /// use robot_dynamics_number::InvalidInput;
    /// let error = InvalidInput::out_of_range("the restitution", 2.0, "", "between 0 and 1");
    /// assert_eq!(error.to_string(), "the restitution must be between 0 and 1, got 2");
    /// ```
    pub fn out_of_range(
        quantity: impl Into<String>,
        value: f64,
        unit: &'static str,
        requirement: impl Into<String>,
    ) -> Self {
        Self::new(quantity, InputProblem::OutOfRange { value, unit, requirement: requirement.into() })
    }

    /// The error of an argument that does not meet a requirement. `requirement` follows its name in the
    /// message.
    ///
    /// ```
    /// use robot_dynamics_number::InvalidInput;
    /// let error = InvalidInput::unmet("a ground's normal", "must have a direction");
    /// assert_eq!(error.to_string(), "a ground's normal must have a direction");
    /// ```
    pub fn unmet(quantity: impl Into<String>, requirement: impl Into<String>) -> Self {
        Self::new(quantity, InputProblem::Unmet { requirement: requirement.into() })
    }

    /// The error of a name that does not exist. `sort` is the sort of the named object.
    ///
    /// ```
    /// use robot_dynamics_number::InvalidInput;
    /// let error = InvalidInput::unknown_name("pose", "up", "robot `arm`", ["home", "rest"]);
    /// assert_eq!(error.to_string(), "robot `arm` has no pose `up`; it has home, rest");
    /// ```
    pub fn unknown_name<'n>(
        sort: impl Into<String>,
        name: impl Into<String>,
        owner: impl Into<String>,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        let (sort, names) = (sort.into(), names.into_iter().collect::<Vec<_>>());
        let listed = names[..names.len().min(LISTED)].join(", ");
        let known = match names.len() {
            0 => format!(", nor any other {sort}"),
            1..=LISTED => format!("; it has {listed}"),
            count => format!("; it has {listed} and {} more", count - LISTED),
        };
        Self::new(sort, InputProblem::UnknownName { name: name.into(), owner: owner.into(), known })
    }

    /// The same error of an argument with another name.
    #[must_use]
    pub fn of(self, quantity: impl Into<String>) -> Self {
        Self { quantity: quantity.into(), ..self }
    }
}

/// The number of existing names that a message lists.
const LISTED: usize = 12;

impl fmt::Display for InvalidInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = &self.quantity;
        match &self.problem {
            InputProblem::WrongLength { found, expected, owner, hint } => {
                write!(f, "{quantity} has {found} numbers, {owner} needs {expected}{hint}")
            }
            InputProblem::NotFinite { index: None, value, .. } => {
                write!(f, "{quantity} is {value}; it must be finite")
            }
            InputProblem::NotFinite { index: Some(index), coordinate, value } => {
                write!(f, "{quantity}[{index}]")?;
                if let Some(coordinate) = coordinate {
                    write!(f, " (coordinate `{coordinate}`)")?;
                }
                write!(f, " is {value}; every number must be finite")
            }
            InputProblem::OutOfRange { value, unit, requirement } => {
                let space = if unit.is_empty() { "" } else { " " };
                let is_plain = *value == 0.0 || !value.is_finite() || (1e-4..1e7).contains(&value.abs());
                let value = if is_plain { format!("{value}") } else { format!("{value:e}") };
                write!(f, "{quantity} must be {requirement}, got {value}{space}{unit}")
            }
            InputProblem::NotAUnitQuaternion { first, joint, norm } => write!(
                f,
                "{quantity}[{first}..{}] (joint `{joint}`) is a quaternion x y z w of length {norm}, not 1; \
                 normalise it, and check its order",
                first + 4
            ),
            InputProblem::NotARotation { defect } => write!(
                f,
                "{quantity}: the rotation matrix is not orthonormal with determinant 1 (off by {defect:e})"
            ),
            InputProblem::Overflow { value } => write!(
                f,
                "{quantity} is {value}: the numbers given are too large to compute it; check their units"
            ),
            InputProblem::Unmet { requirement } => write!(f, "{quantity} {requirement}"),
            InputProblem::UnknownName { name, owner, known } => {
                write!(f, "{owner} has no {quantity} `{name}`{known}")
            }
        }
    }
}

impl Error for InvalidInput {}

impl Classified for InvalidInput {
    fn kind(&self) -> ErrorKind {
        match self.problem {
            InputProblem::UnknownName { .. } => ErrorKind::UnknownName,
            _ => ErrorKind::InvalidInput,
        }
    }
}

/// Whether all numbers are finite. It has no branch for each number, so it is vectorized.
///
/// ```
/// use robot_dynamics_number::are_finite;
/// assert!(are_finite(&[0.0, -1e308, f64::MIN_POSITIVE]));
/// assert!(!are_finite(&[0.0, f64::NEG_INFINITY]) && !are_finite(&[f64::NAN]));
/// ```
pub fn are_finite(values: &[f64]) -> bool {
    // All bits of the exponent are set if a number is not finite. Its lowest bit, added, then sets the sign
    // bit.
    let overflow = |x: f64| (x.to_bits() & !(1 << 63)) + (1 << 52);
    let mut bits = [0_u64; 8];
    let chunks = values.chunks_exact(8);
    let rest = chunks.remainder().iter().fold(0, |bits, x| bits | overflow(*x));
    for chunk in chunks {
        for (bits, x) in bits.iter_mut().zip(chunk) {
            *bits |= overflow(*x);
        }
    }
    bits.iter().fold(rest, |all, bits| all | bits) >> 63 == 0
}

/// Checks that all entries are finite.
///
/// ```
/// use robot_dynamics_number::check_finite;
/// assert!(check_finite("q", &[0.0, 1.0]).is_ok());
/// assert!(check_finite("q", &[0.0, f64::NAN]).is_err());
/// ```
///
/// # Errors
/// [`InputProblem::NotFinite`] with the first entry that is NaN or infinite.
pub fn check_finite(quantity: &str, values: &[f64]) -> Result<(), InvalidInput> {
    if are_finite(values) {
        return Ok(());
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => {
            let problem =
                InputProblem::NotFinite { index: Some(index), coordinate: None, value: values[index] };
            Err(InvalidInput::new(quantity, problem))
        }
        None => Ok(()),
    }
}

/// Checks that a single number is finite.
///
/// ```
/// use robot_dynamics_number::check_number;
/// let error = check_number("the damping", f64::NAN).expect_err("NaN");
/// assert_eq!(error.to_string(), "the damping is NaN; it must be finite");
/// ```
///
/// # Errors
/// [`InputProblem::NotFinite`].
pub fn check_number(quantity: &str, value: f64) -> Result<(), InvalidInput> {
    if value.is_finite() {
        return Ok(());
    }
    Err(InvalidInput::new(quantity, InputProblem::NotFinite { index: None, coordinate: None, value }))
}

/// Checks that a number is positive and finite. `unit` may be empty.
///
/// ```
/// use robot_dynamics_number::check_positive;
/// let error = check_positive("the step", 0.0, "s").expect_err("a step of 0 s");
/// assert_eq!(error.to_string(), "the step must be positive and finite, got 0 s");
/// ```
///
/// # Errors
/// [`InputProblem::OutOfRange`].
pub fn check_positive(quantity: &str, value: f64, unit: &'static str) -> Result<(), InvalidInput> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(InvalidInput::out_of_range(quantity, value, unit, "positive and finite"))
}

/// Checks that results of finite arguments are finite.
///
/// ```
/// use robot_dynamics_number::check_result;
/// assert!(check_result("C v", &[1e200 * 1e200]).is_err());
/// ```
///
/// # Errors
/// [`InputProblem::Overflow`].
pub fn check_result<'a>(
    quantity: &str,
    results: impl IntoIterator<Item = &'a f64>,
) -> Result<(), InvalidInput> {
    match results.into_iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(InvalidInput::new(quantity, InputProblem::Overflow { value })),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_found_at_each_place() {
        let odd =
            [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::from_bits(0x7ff0_0000_0000_0001)];
        for length in 0..40 {
            let mut values = vec![f64::MAX; length];
            values.iter_mut().step_by(3).for_each(|x| *x = -f64::from_bits(1));
            assert!(are_finite(&values));
            for index in 0..length {
                for x in odd {
                    let kept = std::mem::replace(&mut values[index], x);
                    assert!(!are_finite(&values), "{x} at {index} of {length}");
                    values[index] = kept;
                }
            }
        }
    }

    #[test]
    fn unknown_names_list_some_of_the_known_ones() {
        let many: Vec<String> = (0..LISTED + 3).map(|k| format!("j{k}")).collect();
        let text = |names: &[String]| {
            let names = names.iter().map(String::as_str);
            InvalidInput::unknown_name("joint", "elbow", "the robot", names).to_string()
        };
        assert_eq!(text(&[]), "the robot has no joint `elbow`, nor any other joint");
        let most = text(&many[..LISTED]);
        assert!(most.starts_with("the robot has no joint `elbow`; it has j0, j1,") && most.ends_with("j11"));
        assert_eq!(text(&many), format!("{most} and 3 more"));
    }
}
