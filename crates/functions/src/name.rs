//! The names of functions, and names in programs.

use core::fmt;
use core::str::FromStr;

use crate::function::DerivativeKind;
use crate::{Function, FunctionError};

/// A name as an identifier of any language: letters, digits and underscores.
///
/// ```
/// assert_eq!(robot_dynamics_functions::identifier("left foot"), "left_foot");
/// assert_eq!(robot_dynamics_functions::identifier("2R"), "robot_2r");
/// ```
pub fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let text: String = name.chars().map(plain).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) || text.is_empty() {
        format!("robot_{text}")
    } else {
        text
    }
}

impl fmt::Display for Function {
    /// The library's name, followed by a colon and the frame's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.stem())?;
        self.frame().map_or(Ok(()), |frame| write!(f, ":{frame}"))
    }
}

impl FromStr for Function {
    type Err = FunctionError;

    fn from_str(text: &str) -> Result<Self, FunctionError> {
        let unknown = || FunctionError::Unknown { name: text.into() };
        let (stem, frame) = text.split_once(':').map_or((text, None), |(stem, frame)| (stem, Some(frame)));
        let with_sweeps = |stem: &str| {
            let sweeps = stem.strip_prefix("contact_step_")?.strip_suffix("_sweeps")?.parse().ok()?;
            Some(Self::ContactStep { sweeps })
        };
        let named = |stem: &str| match frame {
            None if stem.starts_with("contact_step_") => with_sweeps(stem),
            None => Self::PLAIN.into_iter().chain(Self::OF_CONTACT).find(|plain| plain.plain_stem() == stem),
            Some(frame) => Self::of_frame(frame).into_iter().find(|of_frame| of_frame.plain_stem() == stem),
        };
        if let Some(function) = named(stem) {
            return Ok(function);
        }
        let of_another = |kind: DerivativeKind| Some((named(stem.strip_suffix(kind.suffix())?)?, kind));
        match DerivativeKind::ALL.into_iter().find_map(of_another) {
            None => Err(unknown()),
            Some((function, _)) if !function.is_differentiable() => {
                Err(FunctionError::NotDifferentiable { function: text.into() })
            }
            Some((function, DerivativeKind::Derivatives)) => Ok(function.derivatives()),
            Some((function, DerivativeKind::Pullback)) => Ok(function.pullback()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each name is that of its function, and a step with contact may state its sweeps.
    #[test]
    fn names_of_contact_are_read_back() {
        let mut functions = Function::OF_CONTACT.to_vec();
        functions
            .extend([Function::ContactStep { sweeps: 3 }, Function::ContactStep { sweeps: 3 }.pullback()]);
        for function in functions {
            assert_eq!(function.to_string().parse::<Function>().unwrap(), function);
        }
        assert_eq!(Function::ContactStep { sweeps: 3 }.to_string(), "contact_step_3_sweeps");
        for wrong in ["contact_step_x_sweeps", "contact_step_-1_sweeps", "contact_step_sweeps"] {
            assert!(wrong.parse::<Function>().is_err(), "{wrong}");
        }
    }
}
