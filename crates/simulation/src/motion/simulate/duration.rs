//! Durations as numbers of steps.

use robot_dynamics_number::{InvalidInput, check_positive};

/// The most steps that a duration can take, which only a mistyped duration or step exceeds.
const MOST: f64 = 1e12;

/// The whole number of steps of length h that is nearest to a duration: round(T/h).
///
/// T and h are in s. The rest of T beyond whole steps is dropped or filled up, at most h/2.
///
/// # Errors
/// [`InvalidInput`] unless h is positive and finite, and T is not negative and takes at most 1e12 steps.
///
/// ```
/// use robot_dynamics::simulation::steps_in;
/// assert_eq!(steps_in(0.3, 0.1)?, 3); // 0.3/0.1 is rounded to 2.9999999999999996
/// assert_eq!(steps_in(0.2499, 0.01)?, 25);
/// assert!(steps_in(-0.1, 0.01).is_err() && steps_in(f64::NAN, 0.01).is_err());
/// # Ok::<(), robot_dynamics::InvalidInput>(())
/// ```
#[doc(alias = "steps_of")]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked before
pub fn steps_in(duration: f64, step: f64) -> Result<usize, InvalidInput> {
    check_positive("the step", step, "s")?;
    let steps = (duration / step).round();
    if duration >= 0.0 && steps <= MOST {
        Ok(steps as usize)
    } else {
        let requirement = format!("finite, not negative, and at most {MOST:e} steps of {step} s");
        Err(InvalidInput::out_of_range("the duration", duration, "s", requirement))
    }
}
