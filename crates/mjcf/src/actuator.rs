//! `<actuator>`: gain and bias that are affine, on joints, fixed tendons and sites.
//!
//! All kinds of actuators are one to the format: each is a way to fill the same numbers, and the defaults of a class fill them
//! before it, whatever their kind.

use core::f64::consts::PI;
use std::collections::HashMap;

use multibody::{Activation, ActuatorDescription, Affine, Limits, RobotDescription, Transmission};

use crate::assemble::Places;
use crate::classes::{ACTUATORS, MAIN};
use crate::joint::Motion;
use crate::names::Names;
use crate::option::Disabled;
use crate::reader::{Element, Reader};
use crate::tree::Id;

/// An actuator's numbers as the format keeps them.
#[derive(Clone, Debug)]
struct Settings {
    gain_kind: String,
    gain: [f64; 10],
    bias_kind: String,
    bias: [f64; 10],
    dynamics: String,
    dynamics_numbers: [f64; 10],
    inherit_range: f64,
    /// Set by a damper, whose control is never negative.
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

/// What came of the actuators.
#[derive(Default)]
pub(crate) struct Actuators {
    /// How many the file has.
    pub(crate) count: usize,
    /// The file's elements.
    pub(crate) nodes: Vec<Id>,
    /// Which of them are in the robot.
    pub(crate) read: Vec<usize>,
    /// Servos whose damping is a ratio of the critical one: which of the robot's, and the ratio.
    pub(crate) damping_ratios: Vec<(usize, f64)>,
}

impl Reader<'_> {
    /// All actuators that are read, in the file's order.
    pub(crate) fn actuators(
        &mut self,
        places: &Places,
        disabled: Disabled,
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
            let Some(transmission) = self.transmission(&element, places, &tendons) else { continue };
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("actuator_{index}"), str::to_owned);
            let own = names.free(&name);
            if written.is_some() && own != name {
                self.misplaced(
                    &element,
                    format!("there is an actuator {name:?} already; give each its own name"),
                );
            }
            let mut actuator = ActuatorDescription::new(own, transmission);
            let Some(activation) = self.force(&element, &settings, &mut actuator) else { continue };
            actuator.activation = activation;
            self.motor(&element, &actuator.transmission, disabled, &joints, &tendons, robot);
            let target = self.target_limits(&element, places, robot, &tendons);
            self.ranges(&element, &settings, target, &mut actuator);
            // A servo whose velocity gain is positive names a ratio of critical damping.
            if settings.gain_kind == "fixed"
                && settings.gain[0] == -settings.bias[1]
                && settings.bias[2] > 0.0
            {
                actuators.damping_ratios.push((robot.actuators.len(), settings.bias[2]));
                actuator.bias.velocity = 0.0;
            }
            self.read(&element, "force of control, length and velocity");
            actuators.read.push(index);
            robot.actuators.push(actuator);
        }
        actuators
    }

    /// The numbers after the defaults of its class and its own; `None` for a kind that is not read.
    fn settings(&mut self, element: &Element) -> Option<Settings> {
        let mut settings = Settings::default();
        let nodes: Vec<Id> = element.defaults.iter().copied().chain([element.node]).collect();
        for node in nodes {
            let one = self.plain(node);
            let name = self.tree.nodes[node].name.as_str();
            if !self.set(&one, name, &mut settings) && node == element.node {
                return None; // told by the account of what is not read
            }
        }
        Some(settings)
    }

    /// What one element fills in; `false` for a kind that is not read.
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

    /// Gain, bias and how the control acts; `None`, with a warning, for a kind that is not read.
    fn force(
        &mut self,
        element: &Element,
        settings: &Settings,
        actuator: &mut ActuatorDescription,
    ) -> Option<Activation> {
        let affine = |[constant, length, velocity, ..]: [f64; 10]| Affine { constant, length, velocity };
        let unread =
            |what: &str, word: &str| format!("{what}={word:?}: an actuator of this kind is not in the model");
        actuator.gain = match settings.gain_kind.as_str() {
            "fixed" => Affine::constant(settings.gain[0]),
            "affine" => affine(settings.gain),
            other => {
                self.ignored_physics(element, unread("gaintype", other));
                return None;
            }
        };
        actuator.bias = match settings.bias_kind.as_str() {
            "none" => Affine::default(),
            "affine" => affine(settings.bias),
            other => {
                self.ignored_physics(element, unread("biastype", other));
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
                self.ignored_physics(element, unread("dyntype", other));
                None
            }
        }
    }

    fn transmission(
        &mut self,
        element: &Element,
        places: &Places,
        tendons: &HashMap<String, usize>,
    ) -> Option<Transmission> {
        let gear = self.overlay(element, "gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let to_joint =
            ["joint", "jointinparent"].into_iter().find_map(|word| Some((word, self.text(element, word)?)));
        if let Some((word, name)) = to_joint {
            let joint = self.joint_named(element, name, places)?;
            let along_world = joint.motion == Motion::Free && gear[..3].iter().any(|&x| x != 0.0);
            let in_parent = word == "jointinparent" && !matches!(joint.motion, Motion::Hinge | Motion::Slide);
            if along_world || in_parent {
                let message = "a force along other axes than the body's own, of a free or ball joint, is not in the model";
                self.ignored_physics(element, message);
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
                self.ignored_physics(
                    element,
                    format!("its tendon {name:?} is not in the model, and so the actuator is not"),
                );
            } else {
                self.unknown_name(element, "tendon", name);
            }
            return None;
        }
        if let Some(name) = self.text(element, "site") {
            if self.text(element, "refsite").is_some() {
                self.ignored_physics(element, "refsite: an actuator between two sites is not in the model");
                return None;
            }
            let Some(site) = places.site(name) else {
                self.unknown_name(element, "site", name);
                return None;
            };
            return Some(Transmission::Frame { frame: site.frame.clone(), gear });
        }
        if ["body", "cranksite"].iter().any(|word| self.text(element, word).is_some()) {
            self.ignored_physics(
                element,
                "an actuator of a body or of a slider and crank is not in the model",
            );
        } else {
            self.misplaced(element, "it acts on nothing: give it a joint, a tendon or a site");
        }
        None
    }

    /// The bounds of the joint or tendon that it acts on.
    fn target_limits(
        &self,
        element: &Element,
        places: &Places,
        robot: &RobotDescription,
        tendons: &HashMap<String, usize>,
    ) -> Option<Limits> {
        let joint = self.text(element, "joint").and_then(|name| places.joint(name)).map(|joint| joint.limits);
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
                    self.ignored_physics(element, message);
                }
                Some(limits) => {
                    let mean = 0.5 * (limits.upper + limits.lower);
                    let radius = 0.5 * (limits.upper - limits.lower) * settings.inherit_range;
                    control = Some([mean - radius, mean + radius]);
                }
                None => self.misplaced(element, "inheritrange: what it acts on has no range to take"),
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
