//! The state a run starts from.

use std::fmt::Write;

use multibody::{Limits, Model, Workspace, neutral};

use crate::failure::Failure;
use crate::joint_values::{JointValues, NameOrValues, Numbers, set};

/// A state, and how it was chosen.
pub(crate) struct Start {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// The controls that go with a named pose; empty where there are none.
    pub controls: Vec<f64>,
    /// In words, for the summary.
    pub chosen: String,
}

impl Start {
    /// The given values; where none is given, the pose that the file places the bodies in, or neutral, if the limits allow it and it is no
    /// equilibrium of a robot that is let go, else the middle of the limits, else three quarters up the limits.
    pub(crate) fn choose(
        model: &Model,
        pose: &[NameOrValues],
        velocity: &[JointValues],
        is_let_go: bool,
    ) -> Result<Self, Failure> {
        let mut v = vec![0.0; model.nv()];
        set(model, "--velocity", velocity, Numbers::Velocity, &mut v)?;
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
            set(model, "--pose", &values, Numbers::Configuration, &mut q)?;
            chosen = format!("as given; joints not named: {chosen}");
        }
        if !pose.is_empty()
            && let Some(joint) = first_outside(model, &q)
        {
            let _ = write!(chosen, "; outside the limits of `{joint}`");
        }
        let rest = if v.iter().all(|v| *v == 0.0) { ", at rest" } else { ", moving as given" };
        Ok(Self { q, v, controls, chosen: chosen + rest })
    }
}

fn no_such_pose(model: &Model, name: &str) -> Failure {
    let names: Vec<&str> = model.description().poses.iter().map(|pose| pose.name.as_str()).collect();
    let known = if names.is_empty() {
        "its file names none; write JOINT=NUMBER, several separated by commas".into()
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
    // Where the file's loops are closed, whatever its limits say.
    let is_closed = model.description().equalities.iter().any(|equality| equality.active);
    let own = own.filter(|q| is_closed || first_outside(model, q).is_none());
    let candidates = [
        (own, "the pose of the file's bodies".to_owned()),
        (outside.is_none().then_some(zero), "all zeros".to_owned()),
        (
            Some(middle.clone()),
            match &outside {
                Some(joint) => {
                    format!("the middle of the joint limits, as all zeros is outside those of `{joint}`")
                }
                None => "the middle of the joint limits, as all zeros is an equilibrium".into(),
            },
        ),
        (
            Some(at_fraction(model, 0.75)),
            "three quarters up the joint limits, as zeros and the middle are no starts to fall from".into(),
        ),
    ];
    let mut usable = candidates.into_iter().filter_map(|(q, why)| Some((q?, why)));
    let fallback = usable.next().unwrap_or((middle, String::new()));
    if !must_move || !is_equilibrium(model, &fallback.0) {
        return fallback;
    }
    usable.find(|(q, _)| !is_equilibrium(model, q)).unwrap_or_else(|| {
        (
            fallback.0,
            fallback.1 + ", an equilibrium as far as tried: nothing will move (give --pose or --velocity)",
        )
    })
}

/// The first joint whose limits do not allow this q.
fn first_outside(model: &Model, q: &[f64]) -> Option<String> {
    let mut plain = model.joints().iter().filter(|joint| joint.nq == joint.nv);
    let outside = |joint: &&multibody::Joint| {
        let Limits { lower, upper, .. } = joint.limits;
        q[joint.q_index..joint.q_index + joint.nq].iter().any(|q| !(lower..=upper).contains(q))
    };
    plain.find(outside).map(|joint| joint.name.clone())
}

/// Each joint this far up its limits; one without both limits is taken to reach from −1 to 1, or that much
/// from the limit that it has.
fn at_fraction(model: &Model, fraction: f64) -> Vec<f64> {
    let mut q = neutral(model);
    for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
        let (lower, upper) = match (joint.limits.lower, joint.limits.upper) {
            (lower, upper) if lower.is_finite() && upper.is_finite() => (lower, upper),
            (lower, _) if lower.is_finite() => (lower, lower + 2.0),
            (_, upper) if upper.is_finite() => (upper - 2.0, upper),
            _ => (-1.0, 1.0),
        };
        q[joint.q_index..joint.q_index + joint.nq].fill(lower + fraction * (upper - lower));
    }
    q
}

/// Whether gravity and springs move nothing: |g(q)| ≤ 1e-9 m |gravity|, far above rounding (which leaves about
/// 1e-16 of it) and far below any force that shows in seconds.
fn is_equilibrium(model: &Model, q: &[f64]) -> bool {
    let mut force = vec![0.0; model.nv()];
    multibody::gravity(model, &mut Workspace::new(model), q, &mut force);
    let weight = model.mass() * model.gravity().iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
    force.iter().all(|g| g.abs() <= 1e-9 * weight)
}
