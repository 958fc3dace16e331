//! Reports the physics of a file that no reader has used.

use std::collections::BTreeMap;

use crate::findings::Findings;
use crate::prim::{Prim, Scene};
use crate::value::Value;

/// The namespaces of physics.
const NAMESPACES: [&str; 6] = ["physics:", "newton:", "mjc:", "drive:", "limit:", "urdf:"];

/// Prefixes of PhysX's properties that change the motion. Others are settings of its solver.
const PHYSX: [&str; 17] = [
    "physxJoint:jointFriction",
    "physxJointAxis:",
    "physxMimicJoint:",
    "physxTendon:",
    "physxRigidBody:linearDamping",
    "physxRigidBody:angularDamping",
    "physxRigidBody:lockedPosAxis",
    "physxRigidBody:lockedRotAxis",
    "physxRigidBody:maxLinearVelocity",
    "physxRigidBody:maxAngularVelocity",
    "physxCollision:restOffset",
    "physxForce:",
    "physxDrivePerformanceEnvelope:",
    "physxSurfaceVelocity:",
    "physxPhysicsDistanceJoint:",
    "physxVehicle",
    "physxDeformable",
];

/// The state at the start, which is that of the motion.
const STATE: &str = "state:";

/// Whether a property is one of physics.
pub(crate) fn is_physics(name: &str) -> bool {
    NAMESPACES.iter().chain(&PHYSX).any(|prefix| name.starts_with(prefix))
}

/// Properties that do not affect the motion, or whose effect the reader has in another way.
const HARMLESS: [&str; 16] = [
    "physics:axis",
    "physics:startsAsleep",
    "physics:collisionEnabled",
    "physics:localPos0",
    "physics:localPos1",
    "physics:simulationOwner",
    "newton:maxSolverIterations",
    "newton:maxHullVertices",
    "newton:limitStiffness",
    "newton:limitDamping",
    "newton:contactFrictionGain",
    "mjc:group",
    "mjc:inheritRange",
    "mjc:actLimited",
    "mjc:actEarly",
    "physics:approximation",
];

/// The prefixes of settings of an engine.
const SETTINGS: [&str; 5] = ["mjc:option:", "mjc:flag:", "mjc:compiler:", "newton:kamino:", "newton:xpbd:"];

/// Types of prims whose physics is not read, with a word for each.
const UNREAD_TYPES: [(&str, &str); 6] = [
    ("MjcTendon", "a tendon"),
    ("MjcKeyframe", "a keyframe"),
    ("PhysicsCollisionGroup", "a collision group"),
    ("PointInstancer", "a point instancer"),
    ("PhysxPhysicsGearJoint", "a gear between joints"),
    ("PhysxPhysicsRackAndPinionJoint", "a rack with a pinion between joints"),
];

/// Adds one finding for each kind of property, with the number of its prims.
pub(crate) fn report_unread(scene: &Scene, findings: &mut Findings) {
    let mut counts: BTreeMap<String, (usize, &Prim)> = BTreeMap::new();
    let mut settings: BTreeMap<&str, (usize, &Prim)> = BTreeMap::new();
    for prim in &scene.prims {
        if let Some((_, what)) = UNREAD_TYPES.iter().find(|(name, _)| *name == prim.type_name) {
            let is_harmless = prim.type_name == "MjcKeyframe";
            if is_harmless {
                findings.ignore(&prim.path, format!("{what} is not in the model"));
            } else {
                findings.leave_out(&prim.path, format!("{what} is not in the model"));
            }
            continue;
        }
        for (name, property) in &prim.properties {
            if property.is_used.get() {
                continue;
            }
            let is_physics = is_physics(name);
            let is_setting = (name.starts_with("physx") && !is_physics)
                || name.starts_with(STATE)
                || SETTINGS.iter().any(|prefix| name.starts_with(prefix))
                || HARMLESS.contains(&name.as_str());
            if is_setting {
                if let Some(prefix) = name.split(':').next() {
                    settings.entry(prefix).or_insert((0, prim)).0 += 1;
                }
            } else if is_physics && !is_neutral(name, &property.value) {
                counts.entry(name.clone()).or_insert((0, prim)).0 += 1;
            }
        }
    }
    for (name, (count, first)) in counts {
        let message = match count {
            1 => format!("{name} is not in the model"),
            _ => format!("{name} is not in the model, here and at {} other prims", count - 1),
        };
        findings.leave_out(&first.path, message);
    }
    for (prefix, (count, first)) in settings {
        findings.ignore(&first.path, format!("settings of one engine: {count} properties `{prefix}:…`"));
    }
}

/// Whether a value is without effect: zero, an unset number, or false.
fn is_neutral(name: &str, value: &Value) -> bool {
    match value {
        Value::Numbers(numbers) => {
            let is_range_off = name.starts_with("mjc:sol");
            is_range_off || numbers.iter().all(|number| *number == 0.0 || number.is_infinite())
        }
        Value::Words(words) => words.iter().all(|word| word.is_empty() || word == "auto" || word == "none"),
        Value::Targets(targets) => targets.is_empty(),
        Value::Other => false,
    }
}
