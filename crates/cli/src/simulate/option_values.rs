//! Values of options: the ground, a coefficient of friction, a tolerance.

use std::str::FromStr;

use robot_dynamics::contact::Ground;
use robot_dynamics::simulation::AdaptiveOptions;

/// The value of `--ground`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroundOption {
    pub(super) z: f64,
    /// Slope angle \[rad\].
    pub(super) slope: f64,
    /// Whether the planes and height fields of the robot's file are meant instead.
    pub(super) of_file: bool,
}

impl FromStr for GroundOption {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let mut ground = Self { z: 0.0, slope: 0.0, of_file: text.trim() == "file" };
        if ground.of_file {
            return Ok(ground);
        }
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=') else {
                return Err(format!("expected z=NUMBER, slope=NUMBER or file, not `{part}`"));
            };
            let number = value.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| format!("`{value}` is not a finite number"))?;
            match key.trim() {
                "z" => ground.z = number,
                "slope" => ground.slope = number,
                other => return Err(format!("unknown parameter `{other}`; known: z [m] and slope [rad]")),
            }
        }
        Ground::slope(ground.slope).map_err(|error| error.to_string())?;
        Ok(ground)
    }
}

/// A coefficient of friction.
pub(crate) fn friction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("the number must be finite, 0 or more".into()),
        Err(_) => Err("not a number".into()),
    }
}

/// Parses a tolerance in the range that adaptive steps support.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    let range = AdaptiveOptions::TOLERANCE_RANGE;
    match text.parse::<f64>() {
        Ok(x) if range.contains(&x) => Ok(x),
        Ok(_) => Err(format!("the tolerance must be between {:e} and {:e}", range.start(), range.end())),
        Err(_) => Err("not a number".into()),
    }
}
