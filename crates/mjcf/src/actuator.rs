//! Reads `<actuator>`: affine gain and bias or a muscle, on joints, tendons and sites.
//!
//! In MJCF all kinds of actuators set the same numbers. The defaults of a class set them first, whatever
//! their kind.

mod servo;
mod settings;

use std::collections::HashMap;

use robot_dynamics_description::{
    Activation, ActuatorDescription, Affine, Limits, Muscle, RobotDescription, Transmission,
};

use self::servo::{Input, Law};
use self::settings::Settings;

use crate::assembly::ElementTable;
use crate::body::Body;
use crate::classes::{ACTUATORS, MAIN};
use crate::element::Element;
use crate::joint::JointType;
use crate::names::Names;
use crate::option::DisabledForces;
use crate::reader::Reader;
use crate::tree::Id;

/// The actuators of the file and those that are in the robot.
#[derive(Default)]
pub(crate) struct Actuators {
    /// The file's element of each control.
    pub(crate) nodes: Vec<Id>,
    /// The index in the file of each control of the robot. A motor without an input has none in the file.
    pub(crate) read: Vec<Option<usize>>,
    /// Servos with a damping ratio: index in the robot, and the ratio of the critical damping.
    pub(crate) damping_ratios: Vec<(usize, f64)>,
    /// Actuators whose gain is the damping of one with a damping ratio: that one's index and their own.
    pub(crate) velocity_inputs: Vec<(usize, usize)>,
    /// Muscles whose peak force is this number by the acceleration that a unit force causes.
    pub(crate) muscle_scales: Vec<(usize, f64)>,
}

impl Actuators {
    /// Adds the actuators of a controller with the controls from `control`, from this index of the robot.
    fn add(&mut self, control: usize, first: usize, law: &Law) {
        if law.gains.is_empty() {
            self.read.push(None);
        }
        for (k, (input, _)) in law.gains.iter().enumerate() {
            self.read.push(Some(control + k));
            if law.damping_ratio.is_some() && *input == Input::Velocity {
                self.velocity_inputs.push((first, first + k));
            }
        }
        self.damping_ratios.extend(law.damping_ratio.map(|ratio| (first, ratio)));
    }
}

/// The message for a kind of actuator that is not supported.
fn unsupported(what: &str, word: &str) -> String {
    format!("{what}={word:?}: an actuator of this kind is not in the model")
}

impl Reader<'_> {
    /// Reads all actuators, in the order of the file.
    pub(crate) fn actuators(
        &mut self,
        (bodies, table): (&[Body], &ElementTable),
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
        let tendons: HashMap<String, usize> =
            robot.tendon_names().enumerate().map(|(index, tendon)| (tendon.to_owned(), index)).collect();
        let joints: HashMap<String, usize> =
            robot.joints.iter().enumerate().map(|(index, joint)| (joint.name.clone(), index)).collect();
        for (index, id) in all.into_iter().enumerate() {
            let element = self.element(id, MAIN);
            let Some(settings) = self.settings(&element) else {
                actuators.nodes.push(id);
                continue;
            };
            let control = actuators.nodes.len();
            actuators.nodes.extend(core::iter::repeat_n(id, settings.control_count()));
            if self.tree.nodes[id].name == "orientation" {
                continue; // reported by `list_unread`
            }
            let Some(transmission) = self.transmission(&element, table, &tendons, bodies) else { continue };
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
            if settings.is_controller() {
                let Some(law) = self.controller_law(&element, &settings) else { continue };
                self.motor(&element, &actuator.transmission, disabled, &joints, &tendons, robot);
                let target = self.target_limits(&element, table, robot, &tendons);
                self.ranges(&element, &settings, target, &mut actuator);
                actuators.add(control, robot.actuators.len(), &law);
                let first = robot.actuators.len();
                robot.actuators.extend(self.controller(&element, &settings, &law, &actuator));
                self.disable(&element, disabled, &mut robot.actuators[first..]);
                self.report_read(&element, "force of controls, length and velocity");
                continue;
            }
            let Some(activation) = self.activation(&element, &settings) else { continue };
            actuator.activation = activation;
            self.motor(&element, &actuator.transmission, disabled, &joints, &tendons, robot);
            let target = self.target_limits(&element, table, robot, &tendons);
            self.ranges(&element, &settings, target, &mut actuator);
            if !self.force(&element, &settings, target, &mut actuator) {
                continue;
            }
            let of_state = [actuator.gain, actuator.bias].map(|law| [law.length, law.velocity]);
            let depends = actuator.muscle.is_some() || of_state != [[0.0; 2]; 2];
            if depends && matches!(actuator.transmission, Transmission::Contacts { .. }) {
                let message = "an actuator of a body whose force depends on its velocity is not in the model";
                self.report_ignored_physics(&element, message);
                continue;
            }
            if actuator.muscle.is_some_and(|muscle| muscle.peak_force < 0.0) {
                actuators.muscle_scales.push((robot.actuators.len(), settings.gain[3]));
            }
            // In MJCF a positive velocity bias of a servo is a damping ratio.
            if settings.gain_kind == "fixed"
                && settings.gain[0] == -settings.bias[1]
                && settings.bias[2] > 0.0
            {
                actuators.damping_ratios.push((robot.actuators.len(), settings.bias[2]));
                actuator.bias.velocity = 0.0;
            }
            self.report_read(&element, "force of control, length and velocity");
            actuators.read.push(Some(control));
            self.disable(&element, disabled, core::slice::from_mut(&mut actuator));
            robot.actuators.push(actuator);
        }
        actuators
    }

    /// The dynamics of the activation; `None`, with a warning, for a kind that is not supported.
    fn activation(&mut self, element: &Element, settings: &Settings) -> Option<Activation> {
        let [first, second, third, ..] = settings.dynamics_numbers;
        match settings.dynamics.as_str() {
            "none" => Some(Activation::None),
            "integrator" => Some(Activation::Integrator),
            "filter" | "filterexact" if first > 0.0 => Some(Activation::Filter { time_constant: first }),
            "muscle" if first > 0.0 && second > 0.0 => {
                Some(Activation::Muscle { rise: first, fall: second, width: third.max(0.0) })
            }
            other => {
                self.report_ignored_physics(element, unsupported("dyntype", other));
                None
            }
        }
    }

    /// Sets gain and bias, or the muscle; `false`, with a warning, for a kind that is not supported.
    fn force(
        &mut self,
        element: &Element,
        settings: &Settings,
        target: Option<Limits>,
        actuator: &mut ActuatorDescription,
    ) -> bool {
        let affine = |[constant, length, velocity, ..]: [f64; 10]| Affine { constant, length, velocity };
        let is_muscle = [&settings.gain_kind, &settings.bias_kind].map(|kind| kind == "muscle");
        if is_muscle == [true; 2] && settings.gain[..9] == settings.bias[..9] {
            actuator.muscle = self.muscle(element, settings, target, &actuator.transmission);
            return actuator.muscle.is_some();
        }
        actuator.gain = match settings.gain_kind.as_str() {
            "fixed" => Affine::constant(settings.gain[0]),
            "affine" => affine(settings.gain),
            other => {
                self.report_ignored_physics(element, unsupported("gaintype", other));
                return false;
            }
        };
        actuator.bias = match settings.bias_kind.as_str() {
            "none" => Affine::default(),
            "affine" => affine(settings.bias),
            other => {
                self.report_ignored_physics(element, unsupported("biastype", other));
                return false;
            }
        };
        true
    }

    /// The curves of a muscle. MuJoCo finds a missing `lengthrange` by simulations that pull and push at the
    /// muscle until its joint or tendon is at a limit; here the limits themselves are taken.
    fn muscle(
        &mut self,
        element: &Element,
        settings: &Settings,
        target: Option<Limits>,
        transmission: &Transmission,
    ) -> Option<Muscle> {
        let written = self.numbers::<2>(element, "lengthrange").filter(|[lower, upper]| lower != upper);
        let length_range = written.or_else(|| {
            let gear = match transmission {
                Transmission::Joint { gear, .. } => gear[0],
                Transmission::Tendon { gear, .. } => *gear,
                _ => return None,
            };
            let limits = target.filter(|limits| limits.lower.is_finite() && limits.upper.is_finite())?;
            let [a, b] = [limits.lower * gear, limits.upper * gear];
            let message = format!(
                "lengthrange is missing: taken from the limits of its target, {} to {}",
                a.min(b),
                a.max(b)
            );
            self.warn(element, message);
            Some([a.min(b), a.max(b)])
        });
        let Some(length_range) = length_range else {
            let message = "the muscle has no lengthrange and its target no limits, so the actuator is omitted; \
                           write lengthrange, the shortest and the longest length";
            self.report_ignored_physics(element, message);
            return None;
        };
        let [lower, upper, force, _, shortest, longest, velocity, passive, lengthening, _] = settings.gain;
        let mut muscle = Muscle::new(force, length_range);
        muscle.range = [lower, upper];
        muscle.active_range = [shortest, longest];
        muscle.shortening_velocity = velocity;
        muscle.passive_force = passive;
        muscle.lengthening_force = lengthening;
        Some(muscle)
    }

    fn transmission(
        &mut self,
        element: &Element,
        table: &ElementTable,
        tendons: &HashMap<String, usize>,
        bodies: &[Body],
    ) -> Option<Transmission> {
        let gear = self.overlay(element, "gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        // The last target of a file in MuJoCo's order wins.
        if let Some(name) = self.text(element, "site") {
            let frame = self.frame_of_site(element, table, name)?;
            let Some(reference) = self.text(element, "refsite") else {
                return Some(Transmission::Frame { frame, gear });
            };
            let reference = self.frame_of_site(element, table, reference)?;
            return Some(Transmission::RelativeFrame { frame, reference, gear });
        }
        if let Some(crank) = self.text(element, "cranksite") {
            return self.slider_crank(element, table, crank, gear[0]);
        }
        if let Some(name) = self.text(element, "tendon") {
            if tendons.contains_key(name) {
                return Some(Transmission::Tendon { tendon: name.into(), gear: gear[0] });
            }
            self.refuse_unknown_name(element, "tendon", name);
            return None;
        }
        let to_joint =
            ["jointinparent", "joint"].into_iter().find_map(|word| Some((word, self.text(element, word)?)));
        if let Some((word, name)) = to_joint {
            let own = self.joint_named(element, name, table)?;
            let joint = own.name.clone();
            let in_parent = word == "jointinparent";
            let is_linear = gear[..3].iter().any(|&x| x != 0.0);
            return Some(match own.motion {
                JointType::Ball if in_parent => {
                    Transmission::JointInParent { joint, gear, moment_in_child: false }
                }
                JointType::Free if in_parent || is_linear => {
                    Transmission::JointInParent { joint, gear, moment_in_child: !in_parent }
                }
                _ => Transmission::Joint { joint, gear },
            });
        }
        if self.text(element, "body").is_some() {
            let body = self.body_named(element, "body", bodies)?;
            return Some(Transmission::Contacts { link: table.links[body].clone() });
        }
        self.refuse(element, "it has no target; give it a joint, a tendon, a site or a body");
        None
    }

    /// The frame of a site of the file.
    fn frame_of_site(&mut self, element: &Element, table: &ElementTable, name: &str) -> Option<String> {
        let frame = table.site(name).map(|site| site.frame.clone());
        if frame.is_none() {
            self.refuse_unknown_name(element, "site", name);
        }
        frame
    }

    fn slider_crank(
        &mut self,
        element: &Element,
        table: &ElementTable,
        crank: &str,
        gear: f64,
    ) -> Option<Transmission> {
        let crank = self.frame_of_site(element, table, crank)?;
        let Some(slider) = self.text(element, "slidersite") else {
            self.refuse(element, "slidersite is missing; give the site of the slider");
            return None;
        };
        let slider = self.frame_of_site(element, table, slider)?;
        let rod_length = self.number(element, "cranklength").unwrap_or(0.0);
        if !(rod_length > 0.0 && rod_length.is_finite()) {
            self.refuse(element, "cranklength, the length of the rod, must be positive");
            return None;
        }
        Some(Transmission::SliderCrank { crank, slider, rod_length, gear })
    }

    /// The limits of the joint or tendon that the actuator acts on.
    fn target_limits(
        &self,
        element: &Element,
        table: &ElementTable,
        robot: &RobotDescription,
        tendons: &HashMap<String, usize>,
    ) -> Option<Limits> {
        let words = ["jointinparent", "joint"];
        let joint = words.into_iter().find_map(|word| self.text(element, word));
        let joint = joint.and_then(|name| table.joint(name)).map(|joint| joint.limits);
        let tendon = self.text(element, "tendon").and_then(|name| tendons.get(name));
        joint.or_else(|| {
            let over_joints = robot.tendons.iter().map(|tendon| tendon.limits);
            let mut all = over_joints.chain(robot.spatial_tendons.iter().map(|tendon| tendon.limits));
            all.nth(*tendon?)
        })
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
        if let Some(most) = settings.saturation.filter(|_| settings.gain_kind == "dcmotor") {
            actuator.force_range = [-most, most];
        }
        let mut activation = self.limit(element, "actlimited", "actrange");
        let mut control = self.limit(element, "ctrllimited", "ctrlrange");
        if settings.gain_kind == "pid" && control.is_none() {
            control = self.numbers::<2>(element, "posrange").filter(|[lower, upper]| lower < upper);
        }
        if settings.control_is_limited && control.is_none() {
            control = self.bounds(element, "ctrlrange");
        }
        if settings.inherit_range > 0.0 {
            match target
                .filter(|limits| limits.lower < limits.upper && (limits.upper - limits.lower).is_finite())
            {
                Some(limits) => {
                    let mean = 0.5 * (limits.upper + limits.lower);
                    let radius = 0.5 * (limits.upper - limits.lower) * settings.inherit_range;
                    let inherited = Some([mean - radius, mean + radius]);
                    if settings.dynamics == "integrator" {
                        activation = inherited;
                    } else {
                        control = inherited;
                    }
                }
                None => self.refuse(element, "inheritrange: its joint or tendon has no range"),
            }
        }
        if let Some(range) = control {
            actuator.control_range = range;
        }
        if let Some(range) = activation.filter(|_| actuator.activation != Activation::None) {
            actuator.activation_range = range;
        }
    }
}
