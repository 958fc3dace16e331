//! Reads `<actuator>`: affine gain and bias, on joints, fixed tendons and sites.
//!
//! In MJCF all kinds of actuators set the same numbers. The defaults of a class set them first, whatever
//! their kind.

use core::f64::consts::PI;
use std::collections::HashMap;

use robot_dynamics_description::{
    Activation, ActuatorDescription, Affine, Limits, RobotDescription, Transmission,
};

use crate::assembly::ElementTable;
use crate::classes::{ACTUATORS, MAIN};
use crate::element::Element;
use crate::joint::JointType;
use crate::names::Names;
use crate::option::DisabledForces;
use crate::reader::Reader;
use crate::tree::Id;

/// The numbers of an actuator in MJCF.
#[derive(Clone, Debug)]
struct Settings {
    gain_kind: String,
    gain: [f64; 10],
    bias_kind: String,
    bias: [f64; 10],
    dynamics: String,
    dynamics_numbers: [f64; 10],
    inherit_range: f64,
    /// Set for a damper, whose control is not negative.
    control_is_limited: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let mut first = [0.0; 10];
        first[0] = 1.0;
        Self {
            gain_kind: "fixed".into(),
            gain: first,
            bias_kind: "none".into(),
            bias: [0.0; 10],
            dynamics: "none".into(),
            dynamics_numbers: first,
            inherit_range: 0.0,
            control_is_limited: false,
        }
    }
}

/// The actuators of the file and those that are in the robot.
#[derive(Default)]
pub(crate) struct Actuators {
    /// The number of actuators in the file.
    pub(crate) count: usize,
    /// The file's elements.
    pub(crate) nodes: Vec<Id>,
    /// The indices in the file of those that are in the robot.
    pub(crate) read: Vec<usize>,
    /// Servos with a damping ratio: index in the robot, and the ratio of the critical damping.
    pub(crate) damping_ratios: Vec<(usize, f64)>,
}

impl Reader<'_> {
    /// Reads all actuators, in the order of the file.
    pub(crate) fn actuators(
        &mut self,
        table: &ElementTable,
        disabled: DisabledForces,
        robot: &mut RobotDescription,
    ) -> Actuators {
        let mut actuators = Actuators::default();
        let mut names = Names::default();
        let all: Vec<Id> = self
            .tree
            .in_sections("actuator")
            .filter(|&id| ACTUATORS.contains(&self.tree.nodes[id].name.as_str()))
            .collect();
        actuators.count = all.len();
        actuators.nodes.clone_from(&all);
        let tendons: HashMap<String, usize> =
            robot.tendons.iter().enumerate().map(|(index, tendon)| (tendon.name.clone(), index)).collect();
        let joints: HashMap<String, usize> =
            robot.joints.iter().enumerate().map(|(index, joint)| (joint.name.clone(), index)).collect();
        for (index, id) in all.into_iter().enumerate() {
            let element = self.element(id, MAIN);
            let Some(settings) = self.settings(&element) else { continue };
            let Some(transmission) = self.transmission(&element, table, &tendons) else { continue };
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("actuator_{index}"), str::to_owned);
            let own = names.unique(&name);
            if written.is_some() && own != name {
                self.refuse(
                    &element,
                    format!("the actuator {name:?} already exists; give each its own name"),
                );
            }
            let mut actuator = ActuatorDescription::new(own, transmission);
            let Some(activation) = self.force(&element, &settings, &mut actuator) else { continue };
            actuator.activation = activation;
            self.motor(&element, &actuator.transmission, disabled, &joints, &tendons, robot);
            let target = self.target_limits(&element, table, robot, &tendons);
            self.ranges(&element, &settings, target, &mut actuator);
            // In MJCF a positive velocity bias of a servo is a damping ratio.
            if settings.gain_kind == "fixed"
                && settings.gain[0] == -settings.bias[1]
                && settings.bias[2] > 0.0
            {
                actuators.damping_ratios.push((robot.actuators.len(), settings.bias[2]));
                actuator.bias.velocity = 0.0;
            }
            self.report_read(&element, "force of control, length and velocity");
            actuators.read.push(index);
            robot.actuators.push(actuator);
        }
        actuators
    }

    /// The numbers of the actuator over the defaults of its class; `None` for a kind that is not supported.
    fn settings(&mut self, element: &Element) -> Option<Settings> {
        let mut settings = Settings::default();
        let nodes: Vec<Id> = element.defaults.iter().copied().chain([element.node]).collect();
        for node in nodes {
            let one = self.raw_element(node);
            let name = self.tree.nodes[node].name.as_str();
            if !self.set(&one, name, &mut settings) && node == element.node {
                return None; // reported by `list_unread`
            }
        }
        Some(settings)
    }

    /// Sets the numbers of one element; `false` for a kind that is not supported.
    fn set(&mut self, one: &Element, kind: &str, settings: &mut Settings) -> bool {
        match kind {
            "general" | "actuator" => {
                for (attribute, text) in [
                    ("gaintype", &mut settings.gain_kind),
                    ("biastype", &mut settings.bias_kind),
                    ("dyntype", &mut settings.dynamics),
                ] {
                    if let Some(word) = self.text(one, attribute) {
                        word.trim().clone_into(text);
                    }
                }
                settings.gain = self.overlay(one, "gainprm", settings.gain);
                settings.bias = self.overlay(one, "biasprm", settings.bias);
                settings.dynamics_numbers = self.overlay(one, "dynprm", settings.dynamics_numbers);
            }
            "motor" => {
                settings.gain[0] = 1.0;
                settings.kinds("fixed", "none", "none");
            }
            "position" | "intvelocity" => {
                let stiffness = self.number(one, "kp").unwrap_or(settings.gain[0]);
                (settings.gain[0], settings.bias[1]) = (stiffness, -stiffness);
                if let Some(damping) = self.magnitude(one, "kv") {
                    settings.bias[2] = -damping;
                }
                if let Some(ratio) = self.magnitude(one, "dampratio") {
                    settings.bias[2] = ratio;
                }
                if let Some(time) = self.magnitude(one, "timeconst") {
                    settings.dynamics_numbers[0] = time;
                    settings.dynamics = if time == 0.0 { "none" } else { "filterexact" }.into();
                }
                settings.inherit_range = self.number(one, "inheritrange").unwrap_or(settings.inherit_range);
                let dynamics =
                    if kind == "position" { settings.dynamics.clone() } else { "integrator".into() };
                settings.kinds("fixed", "affine", &dynamics);
            }
            "velocity" => {
                let damping = self.number(one, "kv").unwrap_or(settings.gain[0]);
                settings.bias = [0.0; 10];
                (settings.gain[0], settings.bias[2]) = (damping, -damping);
                settings.kinds("fixed", "affine", "none");
            }
            "damper" => {
                let inherited = if settings.gain_kind == "affine" { -settings.gain[2] } else { 0.0 };
                let damping = self.magnitude(one, "kv").unwrap_or(inherited);
                settings.gain = [0.0; 10];
                settings.gain[2] = -damping;
                settings.control_is_limited = true;
                settings.kinds("affine", "none", "none");
            }
            "cylinder" => {
                settings.dynamics_numbers[0] =
                    self.number(one, "timeconst").unwrap_or(settings.dynamics_numbers[0]);
                let [a, b, c] = self.numbers::<3>(one, "bias").unwrap_or([
                    settings.bias[0],
                    settings.bias[1],
                    settings.bias[2],
                ]);
                settings.bias[..3].copy_from_slice(&[a, b, c]);
                settings.gain[0] = self.number(one, "area").unwrap_or(settings.gain[0]);
                if let Some(diameter) = self.magnitude(one, "diameter") {
                    settings.gain[0] = PI / 4.0 * diameter * diameter;
                }
                settings.kinds("fixed", "affine", "filter");
            }
            _ => return false,
        }
        true
    }

    /// Sets gain and bias and returns the activation; `None`, with a warning, for a kind that is not
    /// supported.
    fn force(
        &mut self,
        element: &Element,
        settings: &Settings,
        actuator: &mut ActuatorDescription,
    ) -> Option<Activation> {
        let affine = |[constant, length, velocity, ..]: [f64; 10]| Affine { constant, length, velocity };
        let unsupported =
            |what: &str, word: &str| format!("{what}={word:?}: an actuator of this kind is not in the model");
        actuator.gain = match settings.gain_kind.as_str() {
            "fixed" => Affine::constant(settings.gain[0]),
            "affine" => affine(settings.gain),
            other => {
                self.report_ignored_physics(element, unsupported("gaintype", other));
                return None;
            }
        };
        actuator.bias = match settings.bias_kind.as_str() {
            "none" => Affine::default(),
            "affine" => affine(settings.bias),
            other => {
                self.report_ignored_physics(element, unsupported("biastype", other));
                return None;
            }
        };
        match settings.dynamics.as_str() {
            "none" => Some(Activation::None),
            "integrator" => Some(Activation::Integrator),
            "filter" | "filterexact" if settings.dynamics_numbers[0] > 0.0 => {
                Some(Activation::Filter { time_constant: settings.dynamics_numbers[0] })
            }
            other => {
                self.report_ignored_physics(element, unsupported("dyntype", other));
                None
            }
        }
    }

    fn transmission(
        &mut self,
        element: &Element,
        table: &ElementTable,
        tendons: &HashMap<String, usize>,
    ) -> Option<Transmission> {
        let gear = self.overlay(element, "gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let to_joint =
            ["joint", "jointinparent"].into_iter().find_map(|word| Some((word, self.text(element, word)?)));
        if let Some((word, name)) = to_joint {
            let joint = self.joint_named(element, name, table)?;
            let along_world = joint.motion == JointType::Free && gear[..3].iter().any(|&x| x != 0.0);
            let in_parent =
                word == "jointinparent" && !matches!(joint.motion, JointType::Hinge | JointType::Slide);
            if along_world || in_parent {
                let message = "a force of a free or ball joint that is not along the axes of the body is not in the model";
                self.report_ignored_physics(element, message);
                return None;
            }
            return Some(Transmission::Joint { joint: joint.name.clone(), gear });
        }
        if let Some(name) = self.text(element, "tendon") {
            if tendons.contains_key(name) {
                return Some(Transmission::Tendon { tendon: name.into(), gear: gear[0] });
            }
            let is_spatial =
                self.tree.in_sections("tendon").any(|id| self.tree.nodes[id].attribute("name") == Some(name));
            if is_spatial {
                self.report_ignored_physics(
                    element,
                    format!("its tendon {name:?} is not in the model, so the actuator is omitted"),
                );
            } else {
                self.refuse_unknown_name(element, "tendon", name);
            }
            return None;
        }
        if let Some(name) = self.text(element, "site") {
            if self.text(element, "refsite").is_some() {
                self.report_ignored_physics(
                    element,
                    "refsite: an actuator between two sites is not in the model",
                );
                return None;
            }
            let Some(site) = table.site(name) else {
                self.refuse_unknown_name(element, "site", name);
                return None;
            };
            return Some(Transmission::Frame { frame: site.frame.clone(), gear });
        }
        if ["body", "cranksite"].iter().any(|word| self.text(element, word).is_some()) {
            self.report_ignored_physics(
                element,
                "an actuator of a body or of a slider and crank is not in the model",
            );
        } else {
            self.refuse(element, "it has no target; give it a joint, a tendon or a site");
        }
        None
    }

    /// The limits of the joint or tendon that the actuator acts on.
    fn target_limits(
        &self,
        element: &Element,
        table: &ElementTable,
        robot: &RobotDescription,
        tendons: &HashMap<String, usize>,
    ) -> Option<Limits> {
        let joint = self.text(element, "joint").and_then(|name| table.joint(name)).map(|joint| joint.limits);
        let tendon = self.text(element, "tendon").and_then(|name| tendons.get(name));
        joint.or_else(|| tendon.map(|&index| robot.tendons[index].limits))
    }

    fn ranges(
        &mut self,
        element: &Element,
        settings: &Settings,
        target: Option<Limits>,
        actuator: &mut ActuatorDescription,
    ) {
        if let Some(range) = self.limit(element, "forcelimited", "forcerange") {
            actuator.force_range = range;
        }
        let mut control = self.limit(element, "ctrllimited", "ctrlrange");
        if settings.control_is_limited && control.is_none() {
            control = self.numbers::<2>(element, "ctrlrange");
        }
        if settings.inherit_range > 0.0 {
            match target.filter(|limits| limits.lower < limits.upper && limits.lower.is_finite()) {
                Some(limits) if settings.dynamics == "integrator" => {
                    let message = format!(
                        "inheritrange: the bounds {} to {} of its activation are not in the model",
                        limits.lower, limits.upper
                    );
                    self.report_ignored_physics(element, message);
                }
                Some(limits) => {
                    let mean = 0.5 * (limits.upper + limits.lower);
                    let radius = 0.5 * (limits.upper - limits.lower) * settings.inherit_range;
                    control = Some([mean - radius, mean + radius]);
                }
                None => self.refuse(element, "inheritrange: its joint or tendon has no range"),
            }
        }
        if let Some(range) = control {
            actuator.control_range = range;
        }
    }
}

impl Settings {
    fn kinds(&mut self, gain: &str, bias: &str, dynamics: &str) {
        gain.clone_into(&mut self.gain_kind);
        bias.clone_into(&mut self.bias_kind);
        dynamics.clone_into(&mut self.dynamics);
    }
}
