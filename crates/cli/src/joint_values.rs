//! Values by joint name, as in `--pose joint1=0.5,joint4=-1.2`.

use std::str::FromStr;

use robot_dynamics::description::Coordinate;
use robot_dynamics::model::{Joint, Model};

use crate::failure::Failure;
use crate::output::print_line;

/// Names with their numbers: `elbow=0.5,base=0,0,1,0,0,0,1,wrist=-1`. A number without a name belongs to the
/// name before it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointValues(Vec<(String, Vec<f64>)>);

impl FromStr for JointValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut values: Vec<(String, Vec<f64>)> = Vec::new();
        for item in text.split(',').map(str::trim) {
            let number = if let Some((name, number)) = item.rsplit_once('=') {
                values.push((name.trim().to_owned(), Vec::new()));
                number.trim()
            } else {
                item
            };
            let Some((name, numbers)) = values.last_mut().filter(|(name, _)| !name.is_empty()) else {
                return Err("expected JOINT=NUMBER, several separated by commas".into());
            };
            match number.parse::<f64>() {
                Ok(x) if x.is_finite() => numbers.push(x),
                Ok(_) => return Err(format!("{name}: {number} is not a finite number")),
                Err(_) => return Err(format!("{name}: {number:?} is not a number")),
            }
        }
        Ok(Self(values))
    }
}

/// Values by joint name, or the name of a pose.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NameOrValues {
    Name(String),
    Values(JointValues),
}

impl FromStr for NameOrValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let is_name = !text.contains('=') && text.parse::<f64>().is_err() && !text.trim().is_empty();
        if is_name { Ok(Self::Name(text.trim().to_owned())) } else { text.parse().map(Self::Values) }
    }
}

impl NameOrValues {
    /// Whether it sets this joint. A named pose sets all joints.
    pub(crate) fn names(&self, joint: &str) -> bool {
        match self {
            Self::Name(_) => true,
            Self::Values(values) => values.0.iter().any(|(name, _)| name == joint),
        }
    }
}

impl JointValues {
    /// The names with their numbers.
    pub(crate) fn lists(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.0.iter().map(|(name, numbers)| (name.as_str(), &numbers[..]))
    }

    /// The values, if each name has one number.
    pub(crate) fn single(&self) -> Result<Vec<(&str, f64)>, String> {
        let mut values = Vec::new();
        for (name, numbers) in &self.0 {
            let [number] = numbers[..] else {
                return Err(format!("{name} takes one number, not {}", numbers.len()));
            };
            values.push((name.as_str(), number));
        }
        Ok(values)
    }
}

/// The kind of a joint's numbers.
#[derive(Clone, Copy)]
pub(crate) enum JointNumbers {
    /// Entries of q.
    Configuration,
    /// Entries of v.
    Velocity,
}

/// Writes the given values into `x`, which is q or v, and leaves the other entries.
pub(crate) fn set(
    model: &Model,
    option: &str,
    given: &[JointValues],
    numbers: JointNumbers,
    x: &mut [f64],
) -> Result<(), Failure> {
    let mut seen: Vec<&str> = Vec::new();
    for (name, values) in given.iter().flat_map(|values| &values.0) {
        let joint = find(model, option, name)?;
        if seen.contains(&name.as_str()) {
            return Err(Failure::new(format!("{option}: joint `{name}` is given twice")));
        }
        seen.push(name);
        let (start, count, what) = match numbers {
            JointNumbers::Configuration => (joint.q_index, joint.nq, configuration_of(joint)),
            JointNumbers::Velocity => (joint.v_index, joint.nv, velocity_of(joint)),
        };
        if values.len() != count {
            let found = values.len();
            return Err(Failure::new(format!(
                "{option}: joint `{name}` ({}) takes {count} number{}{what}, found {found}",
                joint.kind,
                if count == 1 { "" } else { "s" },
            )));
        }
        x[start..start + count].copy_from_slice(values);
        if matches!(numbers, JointNumbers::Configuration) && joint.nq > joint.nv {
            normalize(option, name, &mut x[start + count - 4..start + count])?;
        }
    }
    Ok(())
}

/// The coordinates' names in parentheses, if there are several.
fn named(coordinates: &[Coordinate], frame: &str) -> String {
    if coordinates.len() < 2 {
        return String::new();
    }
    let names: Vec<&str> = coordinates.iter().map(|coordinate| coordinate.name).collect();
    format!(" ({}{frame})", names.join(","))
}

fn configuration_of(joint: &Joint) -> String {
    named(joint.kind.positions(), "")
}

fn velocity_of(joint: &Joint) -> String {
    named(joint.kind.velocities(), if joint.nq > joint.nv { " in the child's frame" } else { "" })
}

/// The joint of this name, if it has values to set.
fn find<'a>(model: &'a Model, option: &str, name: &str) -> Result<&'a Joint, Failure> {
    let Some(joint) = model.joint(name) else {
        let moving: Vec<&str> =
            model.joints().iter().filter(|joint| joint.nv > 0).map(|joint| joint.name.as_str()).collect();
        let most = 12;
        let more = if moving.len() > most { ", …; `dynamics inspect` lists all" } else { "" };
        let known = moving[..moving.len().min(most)].join(", ");
        let robot = model.name();
        return Err(Failure::new(format!(
            "{option}: robot `{robot}` has no joint `{name}`; its moving joints are {known}{more}"
        )));
    };
    if let Some(mimic) = &joint.mimic {
        let leader = &mimic.joint;
        return Err(Failure::new(format!(
            "{option}: joint `{name}` mimics joint `{leader}`; set `{leader}` instead"
        )));
    }
    if joint.nv == 0 {
        return Err(Failure::new(format!("{option}: joint `{name}` is fixed and has no coordinate")));
    }
    Ok(joint)
}

/// Tolerance of a quaternion's length, within which [`robot_dynamics::model::check_configuration`] accepts
/// it.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-6;

/// Normalises a quaternion x y z w. Typed digits are never exact, so a small deviation gives a note and one
/// above 0.1 an error.
pub(crate) fn normalize(option: &str, name: &str, quaternion: &mut [f64]) -> Result<(), Failure> {
    let norm = quaternion.iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
    if (norm - 1.0).abs() > 0.1 {
        return Err(Failure::new(format!(
            "{option}: joint `{name}`: the quaternion x,y,z,w has length {norm} instead of 1; \
             no rotation is 0,0,0,1"
        )));
    }
    if (norm - 1.0).abs() > UNIT_TOLERANCE {
        print_line(format_args!(
            "note: {option}: joint `{name}`: the quaternion x,y,z,w of length {norm} is normalised"
        ));
    }
    for x in quaternion {
        *x /= norm;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_without_a_name_belong_to_the_name_before() {
        let values: JointValues = "a=1, base=0,-2e1,3,b = 4".parse().unwrap();
        let expected = [("a", vec![1.0]), ("base", vec![0.0, -20.0, 3.0]), ("b", vec![4.0])];
        assert_eq!(values.0, expected.map(|(name, numbers)| (name.to_owned(), numbers)));
    }

    #[test]
    fn malformed_values_are_refused() {
        for (text, message) in [
            ("", "expected JOINT=NUMBER, several separated by commas"),
            ("1", "expected JOINT=NUMBER, several separated by commas"),
            ("=1", "expected JOINT=NUMBER, several separated by commas"),
            ("a=", "a: \"\" is not a number"),
            ("a=1,", "a: \"\" is not a number"),
            ("a=one", "a: \"one\" is not a number"),
            ("a=NaN", "a: NaN is not a finite number"),
            ("a=1,inf", "a: inf is not a finite number"),
        ] {
            assert_eq!(text.parse::<JointValues>().unwrap_err(), message, "{text:?}");
        }
    }
}
