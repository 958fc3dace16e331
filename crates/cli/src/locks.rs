//! Locked joints, as in `--lock finger,wrist=0.3`.

use std::fmt;
use std::str::FromStr;

use robot_dynamics::description::{ModelError, RobotDescription};
use robot_dynamics::{Classified, ErrorKind};

use crate::failure::Failure;
use crate::joint_values::normalize;

/// Joints to lock, with optional positions: `finger,wrist=0.3,ball=0,0,0,1`. Numbers after `NAME=` belong to
/// that name; any other item is a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Locks(Vec<(String, Option<Vec<f64>>)>);

impl FromStr for Locks {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut locks: Vec<(String, Option<Vec<f64>>)> = Vec::new();
        for item in text.split(',').map(str::trim) {
            if let Some((name, number)) = item.rsplit_once('=') {
                let (name, number) = (name.trim().to_owned(), number.trim());
                match number.parse::<f64>() {
                    Ok(x) if x.is_finite() => locks.push((name, Some(vec![x]))),
                    Ok(_) => return Err(format!("{name}: {number} is not a finite number")),
                    Err(_) => return Err(format!("{name}: {number:?} is not a number")),
                }
                continue;
            }
            match (item.parse::<f64>(), locks.last_mut()) {
                (Ok(x), Some((_, Some(numbers)))) if x.is_finite() => numbers.push(x),
                _ => locks.push((item.to_owned(), None)),
            }
        }
        if locks.iter().any(|(name, _)| name.is_empty()) {
            return Err("expected JOINT or JOINT=NUMBER, several separated by commas".into());
        }
        Ok(Self(locks))
    }
}

impl fmt::Display for Locks {
    /// In the form of the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, (name, position)) in self.0.iter().enumerate() {
            let comma = if k == 0 { "" } else { "," };
            write!(f, "{comma}{name}")?;
            for (k, x) in position.iter().flatten().enumerate() {
                write!(f, "{}{x}", if k == 0 { "=" } else { "," })?;
            }
        }
        Ok(())
    }
}

/// Makes the named joints fixed.
pub(crate) fn apply(robot: &mut RobotDescription, given: &[Locks]) -> Result<(), Failure> {
    let mut seen: Vec<&str> = Vec::new();
    for (name, position) in given.iter().flat_map(|locks| &locks.0) {
        if seen.contains(&name.as_str()) {
            return Err(Failure::new(format!("--lock: joint `{name}` is given twice")));
        }
        seen.push(name);
        let mut q = match position {
            Some(q) => q.clone(),
            None => robot.resting_position(name).map_err(|error| refused(robot, name, &error))?,
        };
        let joint = robot.joints.iter().find(|joint| &joint.name == name);
        let (nq, nv) = joint.map_or((0, 0), |joint| (joint.kind.nq(), joint.kind.nv()));
        if joint.is_some_and(|joint| joint.mimic.is_none()) && nv == 0 {
            return Err(Failure::new(format!("--lock: joint `{name}` is already fixed")));
        }
        if nq > nv && q.len() == nq {
            normalize("--lock", name, &mut q[nq - 4..])?;
        }
        robot.lock_joint(name, &q).map_err(|error| refused(robot, name, &error))?;
    }
    Ok(())
}

/// The error for a joint that cannot be locked, with the names of joints that can.
fn refused(robot: &RobotDescription, name: &str, error: &ModelError) -> Failure {
    if error.kind() != ErrorKind::UnknownName {
        return Failure::new(format!("--lock: {error}"));
    }
    if name == robot_dynamics::description::FLOATING_BASE {
        return Failure::new("--lock: without --floating-base the base is fixed; omit that option");
    }
    let free = robot.joints.iter().filter(|joint| joint.kind.nv() > 0 && joint.mimic.is_none());
    let free: Vec<&str> = free.map(|joint| joint.name.as_str()).collect();
    let most = 12;
    let more = if free.len() > most { ", …; `dynamics inspect` lists all" } else { "" };
    let known = free[..free.len().min(most)].join(", ");
    Failure::new(format!("--lock: the robot has no joint `{name}`; its moving joints are {known}{more}"))
}

/// The message about joints locked by `--lock-massless`.
pub(crate) fn message(locked: &[String]) -> String {
    let names = locked.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match locked.len() {
        0 => "no joint is massless; none is locked".into(),
        1 => format!("joint {names} moves no inertia and is locked"),
        _ => format!("joints {names} move no inertia and are locked"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_and_without_positions() {
        let locks: Locks = "a, b=0.5,ball = 0,0,-1e0,1 ,c".parse().unwrap();
        let expected =
            [("a", None), ("b", Some(vec![0.5])), ("ball", Some(vec![0.0, 0.0, -1.0, 1.0])), ("c", None)];
        assert_eq!(locks.0, expected.map(|(name, numbers)| (name.to_owned(), numbers)));
        // A name may look like a number.
        assert_eq!("7".parse::<Locks>().unwrap().0, [("7".to_owned(), None)]);
    }

    #[test]
    fn malformed_locks_are_refused() {
        for (text, message) in [
            ("", "expected JOINT or JOINT=NUMBER, several separated by commas"),
            ("a,,b", "expected JOINT or JOINT=NUMBER, several separated by commas"),
            ("=1", "expected JOINT or JOINT=NUMBER, several separated by commas"),
            ("a=", "a: \"\" is not a number"),
            ("a=inf", "a: inf is not a finite number"),
        ] {
            assert_eq!(text.parse::<Locks>().unwrap_err(), message, "{text:?}");
        }
    }
}
