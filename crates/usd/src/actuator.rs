//! Actuators of MuJoCo's and Newton's schemas.

use std::collections::{HashMap, HashSet};

use robot_dynamics_description::{ActuatorDescription, Affine, Transmission};

use crate::assembly::Assembly;
use crate::findings::Findings;
use crate::names::unique_names;
use crate::prim::Prim;

impl Assembly<'_> {
    /// Adds the actuators, and returns the joints on which they act.
    pub(crate) fn add_actuators(&mut self, findings: &mut Findings) -> HashSet<usize> {
        let scene = self.geometry.scene;
        let is_actuator =
            |at: &usize| matches!(scene.prims[*at].type_name.as_str(), "MjcActuator" | "NewtonActuator");
        let prims: Vec<usize> = (0..scene.prims.len()).filter(is_actuator).collect();
        let names = unique_names(scene, &prims, &mut HashSet::new());
        let joint_of: HashMap<usize, usize> =
            self.joints.iter().enumerate().map(|(index, joint)| (joint.prim, index)).collect();
        let mut driven = HashSet::new();
        for (at, name) in prims.into_iter().zip(names) {
            let prim = &scene.prims[at];
            let is_newton = prim.type_name == "NewtonActuator";
            let targets = prim.targets(if is_newton { "newton:targets" } else { "mjc:target" });
            let joint = targets.first().and_then(|target| joint_of.get(&scene.find(target)?));
            let Some(&joint) = joint else {
                use_all(prim);
                findings.leave_out(&prim.path, "an actuator that acts on no joint is not in the model");
                continue;
            };
            let [made] = &self.made[joint][..] else {
                use_all(prim);
                let message = "an actuator on a joint without one degree of freedom is not in the model";
                findings.leave_out(&prim.path, message);
                continue;
            };
            let read = if is_newton { newton(prim, name, made) } else { mujoco(prim, name, made) };
            match read {
                Ok(actuator) => {
                    driven.insert(joint);
                    self.robot.actuators.push(actuator);
                }
                Err(message) => {
                    use_all(prim);
                    findings.leave_out(&prim.path, format!("the actuator is not in the model: {message}"));
                }
            }
        }
        driven
    }
}

fn use_all(prim: &Prim) {
    for property in prim.properties.values() {
        property.is_used.set(true);
    }
}

/// A range that is in effect if `limited` says so, or by default if it is stated.
fn range(prim: &Prim, name: &str, limited: &str) -> Option<[f64; 2]> {
    let [min, max] = ["min", "max"].map(|end| prim.number(&format!("mjc:{name}:{end}")));
    let is_stated = min.is_some() || max.is_some();
    let range = [min.unwrap_or_default(), max.unwrap_or_default()];
    let is_used = match prim.word(&format!("mjc:{limited}")) {
        Some("true") => true,
        Some("false") => false,
        _ => is_stated && range[0] < range[1],
    };
    (is_used && range.iter().all(|x| x.is_finite())).then_some(range)
}

/// An actuator of MuJoCo with affine gain and bias, in SI.
fn mujoco(prim: &Prim, name: String, joint: &str) -> Result<ActuatorDescription, String> {
    let kind =
        |name: &str, default: &'static str| prim.word(&format!("mjc:{name}")).unwrap_or(default).to_owned();
    let parameters = |name: &str, default: f64| -> [f64; 3] {
        let numbers = prim.numbers(&format!("mjc:{name}")).unwrap_or_default();
        let at = |index: usize| numbers.get(index).copied().filter(|x| x.is_finite());
        [at(0).unwrap_or(default), at(1).unwrap_or_default(), at(2).unwrap_or_default()]
    };
    let affine = |[constant, length, velocity]: [f64; 3]| Affine { constant, length, velocity };
    let dynamics = kind("dynType", "none");
    if dynamics != "none" {
        return Err(format!("its dynType {dynamics:?} is not read"));
    }
    parameters("dynPrm", 1.0);
    let gains = parameters("gainPrm", 1.0);
    let gain = match kind("gainType", "fixed").as_str() {
        "fixed" => Affine::constant(gains[0]),
        "affine" => affine(gains),
        other => return Err(format!("its gainType {other:?} is not read")),
    };
    let biases = parameters("biasPrm", 0.0);
    let mut bias = match kind("biasType", "none").as_str() {
        "none" => Affine::default(),
        "affine" => affine(biases),
        other => return Err(format!("its biasType {other:?} is not read")),
    };
    if bias.velocity > 0.0 && gain.length == 0.0 && gain.constant == -bias.length {
        return Err("its damping is stated by a damping ratio, which is not read; give kv".to_owned());
    }
    // −0 becomes 0, as for an actuator without damping.
    bias.velocity += 0.0;
    let gear = prim.numbers("mjc:gear").and_then(|gear| gear.first()).copied().unwrap_or(1.0);
    let mut actuator = ActuatorDescription::new(name, Transmission::joint(joint, gear));
    (actuator.gain, actuator.bias) = (gain, bias);
    actuator.control_range = range(prim, "ctrlRange", "ctrlLimited").unwrap_or(actuator.control_range);
    actuator.force_range = range(prim, "forceRange", "forceLimited").unwrap_or(actuator.force_range);
    Ok(actuator)
}

/// Newton's controller with proportional and derivative gains, in SI units and rad.
fn newton(prim: &Prim, name: String, joint: &str) -> Result<ActuatorDescription, String> {
    if !prim.has("NewtonPDControlAPI") {
        return Err("only NewtonPDControlAPI is read as its control law".to_owned());
    }
    let known = ["NewtonPDControlAPI", "NewtonMaxEffortClampingAPI", "NewtonActuatorControlBaseAPI"];
    let other =
        prim.schemas.iter().find(|schema| schema.starts_with("Newton") && !known.contains(&schema.as_str()));
    if let Some(other) = other.filter(|other| *other != "NewtonActuatorClampingBaseAPI") {
        return Err(format!("{other} is not read"));
    }
    let number = |name: &str| prim.number(name).filter(|x| x.is_finite());
    let mut actuator = ActuatorDescription::new(name, Transmission::joint(joint, 1.0));
    actuator =
        actuator.servo(number("newton:kp").unwrap_or_default(), number("newton:kd").unwrap_or_default());
    if let Some(limit) = number("newton:maxEffort") {
        actuator.force_range = [-limit.abs(), limit.abs()];
    }
    Ok(actuator)
}
