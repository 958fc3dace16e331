//! The initial state of a run.

use std::fmt::Write;

use robot_dynamics::description::Limits;
use robot_dynamics::model::{Model, Workspace, neutral};

use crate::failure::Failure;
use crate::joint_values::{JointNumbers, JointValues, NameOrValues, set};

/// A state, and a text on its choice.
pub(crate) struct Start {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// The controls of a named pose; empty without one.
    pub controls: Vec<f64>,
    /// Text for the summary.
    pub chosen: String,
}

impl Start {
    /// The given values. By default q is the file's initial pose or neutral, if the limits allow it and a
    /// passive robot is not in equilibrium there. Otherwise it is the middle of the limits, or three quarters
    /// of their range.
    pub(crate) fn choose(
        model: &Model,
        pose: &[NameOrValues],
        velocity: &[JointValues],
        is_let_go: bool,
    ) -> Result<Self, Failure> {
        let mut v = vec![0.0; model.nv()];
        set(model, "--velocity", velocity, JointNumbers::Velocity, &mut v)?;
        let must_move = is_let_go && pose.is_empty() && v.iter().all(|&v| v == 0.0);
        let (mut q, mut chosen) = default_pose(model, must_move);
        let mut controls = Vec::new();
        let mut values = Vec::new();
        for pose in pose {
            match pose {
                NameOrValues::Values(pose) => values.push(pose.clone()),
                NameOrValues::Name(name) => {
                    let (named_q, named_v) =
                        model.named_pose(name).ok_or_else(|| no_such_pose(model, name))?;
                    q = named_q;
                    if velocity.is_empty() {
                        v = named_v;
                    }
                    let poses = &model.description().poses;
                    controls = poses
                        .iter()
                        .find(|own| own.name == *name)
                        .map_or(Vec::new(), |own| own.controls.clone());
                    chosen = format!("pose `{name}` of the file");
                }
            }
        }
        if !values.is_empty() {
            set(model, "--pose", &values, JointNumbers::Configuration, &mut q)?;
            chosen = format!("as given; other joints: {chosen}");
        }
        if !pose.is_empty()
            && let Some(joint) = first_outside(model, &q)
        {
            let _ = write!(chosen, "; outside the limits of `{joint}`");
        }
        let rest = if v.iter().all(|v| *v == 0.0) { ", at rest" } else { ", velocity as given" };
        Ok(Self { q, v, controls, chosen: chosen + rest })
    }
}

fn no_such_pose(model: &Model, name: &str) -> Failure {
    let names: Vec<&str> = model.description().poses.iter().map(|pose| pose.name.as_str()).collect();
    let known = if names.is_empty() {
        "its file has none; for joint values use JOINT=NUMBER, several separated by commas".into()
    } else {
        format!("its file has {}", names.join(", "))
    };
    Failure::new(format!("--pose: robot `{}` has no pose `{name}`: {known}", model.name()))
}

fn default_pose(model: &Model, must_move: bool) -> (Vec<f64>, String) {
    let zero = neutral(model);
    let outside = first_outside(model, &zero);
    let middle = at_fraction(model, 0.5);
    let own = Some(model.initial_configuration()).filter(|q| *q != zero);
    // With loops, only the file's own pose closes them, whatever its limits are.
    let is_closed = model.description().equalities.iter().any(|equality| equality.active);
    let own = own.filter(|q| is_closed || first_outside(model, q).is_none());
    let candidates = [
        (own, "initial pose of the file".to_owned()),
        (outside.is_none().then_some(zero), "zero".to_owned()),
        (
            Some(middle.clone()),
            match &outside {
                Some(joint) => {
                    format!("middle of the joint limits, since zero is outside those of `{joint}`")
                }
                None => "middle of the joint limits, since zero is an equilibrium".into(),
            },
        ),
        (
            Some(at_fraction(model, 0.75)),
            "three quarters of the joint ranges, since zero and the middle are equilibria or outside the limits".into(),
        ),
    ];
    let mut usable = candidates.into_iter().filter_map(|(q, why)| Some((q?, why)));
    let fallback = usable.next().unwrap_or((middle, String::new()));
    if !must_move || !is_equilibrium(model, &fallback.0) {
        return fallback;
    }
    usable.find(|(q, _)| !is_equilibrium(model, q)).unwrap_or_else(|| {
        (fallback.0, fallback.1 + ", an equilibrium, in which the robot stays (give --pose or --velocity)")
    })
}

/// The first joint whose limits exclude this q.
fn first_outside(model: &Model, q: &[f64]) -> Option<String> {
    let mut plain = model.joints().iter().filter(|joint| joint.nq == joint.nv);
    let outside = |joint: &&robot_dynamics::model::Joint| {
        let Limits { lower, upper, .. } = joint.limits;
        q[joint.q()].iter().any(|q| !(lower..=upper).contains(q))
    };
    plain.find(outside).map(|joint| joint.name.clone())
}

/// Each joint at this fraction of its range. A joint without limits has the range −1 to 1. A joint with one
/// limit has a range of length 2 from that limit.
fn at_fraction(model: &Model, fraction: f64) -> Vec<f64> {
    let mut q = neutral(model);
    for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
        let (lower, upper) = match (joint.limits.lower, joint.limits.upper) {
            (lower, upper) if lower.is_finite() && upper.is_finite() => (lower, upper),
            (lower, _) if lower.is_finite() => (lower, lower + 2.0),
            (_, upper) if upper.is_finite() => (upper - 2.0, upper),
            _ => (-1.0, 1.0),
        };
        q[joint.q()].fill(lower + fraction * (upper - lower));
    }
    q
}

/// Whether gravity and springs are in equilibrium: |g(q)| ≤ 1e-9 m |gravity|. Rounding leaves about 1e-16 of
/// the weight, and forces below the bound have no visible effect within seconds.
fn is_equilibrium(model: &Model, q: &[f64]) -> bool {
    let mut force = vec![0.0; model.nv()];
    robot_dynamics::algorithms::gravity(model, &mut Workspace::new(model), q, &mut force);
    let weight = model.mass() * model.gravity().iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
    force.iter().all(|g| g.abs() <= 1e-9 * weight)
}
