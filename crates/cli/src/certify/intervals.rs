//! Intervals as text and as options.

use std::str::FromStr;

use robot_dynamics::model::Model;
use robot_dynamics_certified::Interval;

use crate::failure::Failure;
use crate::joint_values::JointValues;

/// Two numbers, as in `0.9,1.1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range(pub Interval);

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [low, high] = numbers(text)?;
        if low > high {
            return Err(format!("{low} is above {high}"));
        }
        Ok(Self(Interval::new(low, high)))
    }
}

/// N finite numbers, separated by commas.
pub(super) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let found = parsed.ok().filter(|numbers| numbers.iter().all(|x| x.is_finite()));
    let found = found.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
    found.ok_or_else(|| format!("expected {N} numbers, separated by commas"))
}

/// The box of position limits, with other intervals for some joints.
pub(super) fn position_box(model: &Model, ranges: &[JointValues]) -> Result<Vec<Interval>, Failure> {
    let limits = model.coordinate_limits();
    let mut intervals = vec![Interval::ENTIRE; model.nq()];
    // Quaternions keep the whole line, which tasks refuse.
    for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
        for (q, v) in joint.q().zip(joint.v()) {
            intervals[q] = Interval::new(limits[v].lower, limits[v].upper);
        }
    }
    for range in ranges {
        for (name, values) in range.lists() {
            let joint = model.joint(name).filter(|joint| joint.nq == 1);
            let Some(joint) = joint else {
                return Err(Failure::new(format!(
                    "--range: robot `{}` has no moving joint `{name}` of one coordinate; `dynamics inspect` lists them",
                    model.name()
                )));
            };
            let &[low, high] = values else {
                return Err(Failure::new(format!("--range: {name} takes two numbers, not {}", values.len())));
            };
            if low > high {
                return Err(Failure::new(format!("--range: {name}: {low} is above {high}")));
            }
            intervals[joint.q_index] = Interval::new(low, high);
        }
    }
    Ok(intervals)
}

/// A lower bound as text: five significant digits, rounded down.
pub(super) fn down(x: f64) -> String {
    rounded(x, f64::floor)
}

/// An upper bound as text: five significant digits, rounded up.
pub(super) fn up(x: f64) -> String {
    rounded(x, f64::ceil)
}

fn rounded(x: f64, towards: fn(f64) -> f64) -> String {
    if !x.is_finite() || x == 0.0 {
        return if x == 0.0 { "0".into() } else { x.to_string() };
    }
    // The number of decimals for five digits, from those of 1e4 on.
    let decimals = (0_u8..12).find(|k| x.abs() * 10_f64.powi(i32::from(*k)) >= 1e4).unwrap_or(12);
    let scale = 10_f64.powi(i32::from(decimals));
    let text = format!("{:.*}", usize::from(decimals), towards(x * scale) / scale);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_outward() {
        assert_eq!((down(57.172_321).as_str(), up(57.172_321).as_str()), ("57.172", "57.173"));
        assert_eq!((down(-0.001_234_56).as_str(), up(-0.001_234_56).as_str()), ("-0.0012346", "-0.0012345"));
        assert_eq!((up(2.0).as_str(), down(123_456.7).as_str(), up(0.0).as_str()), ("2", "123456", "0"));
    }
}
