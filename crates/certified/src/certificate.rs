//! Certificates: a robot's constants and a proven claim as JSON, for a checker that shares no code with this
//! library (`checker/check_certificate.py`).

use core::fmt;
use std::error::Error;

use robot_dynamics_core::joint::PrimitiveJoint;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_number::{Classified, ErrorKind};
use serde_json::{Value, json};

use crate::definite::{Definiteness, turns_once};
use crate::digits::{EnclosedQuantity, EnclosedState};
use crate::motion::PolynomialMotion;
use crate::torque::TorqueBounds;
use crate::uncertainty::Uncertainty;
use crate::{Farthest, Interval};

/// A proven claim about a robot, as JSON. Its numbers are doubles in decimal, which give the same bits when
/// they are read.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate(Value);

/// The robot or the result has no certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoCertificate {
    /// The checker reads joints of one degree of freedom only.
    Quaternions,
    /// The checker does not read rotors that turn with several joints.
    Rotors,
    /// The claim is not proven.
    Unproven,
}

impl fmt::Display for NoCertificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Quaternions => {
                "certificates cover joints of one degree of freedom; lock floating and ball joints"
            }
            Self::Rotors => "certificates do not cover the armature of tendons over several joints",
            Self::Unproven => "the claim is not proven, so it has no certificate",
        })
    }
}

impl Error for NoCertificate {}

impl Classified for NoCertificate {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Quaternions | Self::Rotors => ErrorKind::Unsupported,
            Self::Unproven => ErrorKind::NotConverged,
        }
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.0)
    }
}

impl Certificate {
    /// Enclosures of the quantities at states. Only M, the bias, the inverse and the forward dynamics are
    /// claimed.
    ///
    /// # Errors
    /// [`NoCertificate`] if the checker does not read such robots.
    pub fn of_digits(
        model: &Model,
        states: &[(EnclosedState<'_>, Vec<EnclosedQuantity>)],
    ) -> Result<Self, NoCertificate> {
        let claimed = ["mass_matrix", "bias", "inverse_dynamics", "forward_dynamics"];
        let of_state = |(state, quantities): &(EnclosedState<'_>, Vec<EnclosedQuantity>)| {
            let mut claims = serde_json::Map::new();
            for quantity in quantities.iter().filter(|quantity| claimed.contains(&quantity.name)) {
                claims.insert(quantity.name.to_owned(), intervals(&quantity.enclosure));
            }
            json!({ "q": state.q, "v": state.v, "a": state.a, "tau": state.tau, "enclosures": claims })
        };
        let states: Vec<Value> = states.iter().map(of_state).collect();
        Self::new(model, json!({ "kind": "digits", "states": states }))
    }

    /// M is positive definite in a box of configurations.
    ///
    /// # Errors
    /// [`NoCertificate`] if that is not proven, or if the checker does not read such robots.
    pub fn of_definiteness(
        model: &Model,
        q: &[Interval],
        found: &Definiteness,
    ) -> Result<Self, NoCertificate> {
        let divisions = match found {
            Definiteness::ByOwnInertias => Value::Null,
            Definiteness::ByDivision { tree, .. } => json!(tree.preorder()),
            _ => return Err(NoCertificate::Unproven),
        };
        let q = turns_once(model, q);
        Self::new(model, json!({ "kind": "mass_matrix", "q": intervals(&q), "divisions": divisions }))
    }

    /// A frame keeps n · p ≤ d in a box of configurations, for each pair of n and d. The checker uses a
    /// coarser grid, so d should exceed the bound by 1 % of the chain's length.
    ///
    /// # Errors
    /// [`NoCertificate`] if a bound exceeds its d, or if the checker does not read such robots.
    pub fn of_reach(
        model: &Model,
        q: &[Interval],
        frame: FrameId,
        claims: &[([f64; 3], f64, Farthest)],
    ) -> Result<Self, NoCertificate> {
        if claims.iter().any(|(_, most, found)| found.proven > *most) {
            return Err(NoCertificate::Unproven);
        }
        let half_spaces: Vec<Value> =
            claims.iter().map(|(n, most, _)| json!({ "direction": n, "at_most": most })).collect();
        // A revolute joint without limits has all rotations in this interval.
        let q: Vec<Interval> =
            q.iter().map(|x| if x.is_bounded() { *x } else { Interval::new(-3.2, 3.2) }).collect();
        let own = frame_json(model, frame);
        Self::new(
            model,
            json!({ "kind": "reach", "q": intervals(&q), "frame": own, "half_spaces": half_spaces }),
        )
    }

    /// The torques of a motion stay in bounds for all robots of a set. The stated bounds are 2 % of the range
    /// wider than those found, since the checker's differ in their overestimates.
    ///
    /// # Errors
    /// [`NoCertificate`] if the checker does not read such robots.
    pub fn of_torques(
        model: &Model,
        motion: &PolynomialMotion,
        robots: &Uncertainty,
        bounds: &TorqueBounds,
    ) -> Result<Self, NoCertificate> {
        let widened = |x: &Interval| {
            let margin = 0.02 * x.width() + 1e-9 * x.magnitude();
            *x + Interval::new(-margin, margin)
        };
        let torques: Vec<Interval> = bounds.proven.iter().map(widened).collect();
        let pieces: Vec<Value> = motion
            .pieces()
            .iter()
            .map(|piece| json!({ "duration": piece.duration, "coordinates": piece.coordinates }))
            .collect();
        let parts: Vec<Value> = bounds
            .parts
            .iter()
            .map(|part| json!([part.piece, part.time.lower(), part.time.upper()]))
            .collect();
        let mut factors = serde_json::Map::new();
        for (link, factor) in model.moving_links().zip(&robots.mass_factors) {
            factors.insert(link.to_owned(), interval(*factor));
        }
        let payload = robots.payload.as_ref().map(|payload| {
            json!({
                "frame": frame_json(model, payload.frame),
                "mass": interval(payload.mass),
                "center_of_mass": intervals(&payload.center_of_mass),
                "radius_of_gyration": payload.radius_of_gyration,
            })
        });
        let claim = json!({
            "kind": "torques",
            "motion": pieces,
            "mass_factors": factors,
            "friction_factor": interval(robots.friction_factor),
            "gravity": intervals(&robots.gravity),
            "payload": payload,
            "torques": intervals(&torques),
            "parts": parts,
        });
        Self::new(model, claim)
    }

    #[allow(clippy::needless_pass_by_value)] // the certificate holds the claim
    fn new(model: &Model, claim: Value) -> Result<Self, NoCertificate> {
        if !model.is_vector_space() {
            return Err(NoCertificate::Quaternions);
        }
        if !model.rotors.is_empty() {
            return Err(NoCertificate::Rotors);
        }
        let robot = robot_json(model);
        Ok(Self(json!({ "format": "robot-dynamics certificate 1", "robot": robot, "claim": claim })))
    }
}

fn interval(x: Interval) -> Value {
    json!([x.lower(), x.upper()])
}

fn intervals(x: &[Interval]) -> Value {
    x.iter().map(|x| interval(*x)).collect()
}

/// The constants of the compiled robot. The axis of each joint is the z axis of its body.
fn robot_json(model: &Model) -> Value {
    let body_json = |(i, body): (usize, &robot_dynamics_core::model::Body)| {
        let dof = &model.dofs[body.dof];
        let (kind, pitch) = match body.motion {
            PrimitiveJoint::Prismatic => ("prismatic", 0.0),
            PrimitiveJoint::Helical(pitch) => ("helical", pitch),
            _ => ("revolute", 0.0),
        };
        let carries_link = model.bodies.get(i + 1).is_none_or(|next| next.link != body.link);
        let rows = |columns: &[[f64; 4]; 3]| [0, 1, 2].map(|row| [0, 1, 2].map(|k| columns[k][row]));
        json!({
            "link": if carries_link { Some(&model.description().links[body.link].name) } else { None },
            "parent": if body.parent == WORLD { None } else { Some(body.parent) },
            "joint": kind,
            "pitch": pitch,
            "coordinate": dof.coordinate,
            "ratio": dof.ratio,
            "offset": dof.offset,
            "armature": dof.passive.armature,
            "damping": dof.passive.damping,
            "friction": dof.passive.friction,
            "stiffness": dof.passive.stiffness,
            "rest": dof.passive.rest,
            "rotation": rows(&body.rotation),
            "translation": &body.translation[..3],
            "mass": body.mass,
            "first_moment": &body.first_moment[..3],
            "inertia": rows(&body.inertia),
        })
    };
    let bodies: Vec<Value> = model.bodies.iter().enumerate().map(body_json).collect();
    json!({ "name": model.name(), "coordinates": model.nv(), "gravity": model.gravity(), "bodies": bodies })
}

fn frame_json(model: &Model, frame: FrameId) -> Value {
    let own = model.frame_of(frame);
    let pose = &own.body_from_frame;
    json!({ "name": own.name, "body": own.body, "rotation": pose.rotation, "translation": pose.translation })
}
