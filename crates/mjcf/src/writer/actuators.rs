//! Writes `<actuator>`.

use robot_dynamics_description::{Activation, ActuatorDescription, Affine, JointKind, Muscle, Transmission};
use robot_dynamics_xml::excerpt;

use super::MjcfWriter;
use super::controllers::Controller;

impl MjcfWriter<'_> {
    pub(super) fn write_actuators(&mut self) {
        let robot = self.robot;
        if robot.actuators.is_empty() {
            return;
        }
        let has_several_inputs = robot.actuators.iter().any(|own| own.adds_to.is_some());
        self.xml.start("actuator");
        for (index, actuator) in robot.actuators.iter().enumerate() {
            if actuator.adds_to.is_some() {
                continue; // written with the actuator that it adds to
            }
            let place = format!("actuator {:?}", excerpt(&actuator.name));
            let others = has_several_inputs.then(|| robot.actuators.iter().enumerate().skip(index));
            let adds = |own: &ActuatorDescription| own.adds_to.as_ref() == Some(&actuator.name);
            let inputs: Vec<_> = others.into_iter().flatten().filter(|(_, own)| adds(own)).collect();
            let controller = Controller::new(actuator, inputs.iter().map(|(_, input)| *input));
            if let Some(reason) = self.reason_against(actuator).or(controller.as_ref().err().copied()) {
                self.add_loss(&place, format!("omitted: {reason}"));
                continue;
            }
            match controller {
                Ok(Some(controller)) => self.write_controller(&place, actuator, &controller),
                _ => self.write_actuator(&place, actuator),
            }
            self.written_actuators.push(index);
            self.written_actuators.extend(inputs.iter().map(|(index, _)| index));
        }
        self.xml.end();
    }

    /// The reason for which MJCF cannot represent an actuator.
    fn reason_against(&self, actuator: &ActuatorDescription) -> Option<&'static str> {
        let ActuatorDescription { gain, bias, .. } = actuator;
        // In MJCF a positive velocity bias of a servo is a damping ratio.
        let is_servo = gain.length == 0.0 && gain.velocity == 0.0 && gain.constant == -bias.length;
        if is_servo && bias.velocity > 0.0 {
            return Some("MJCF reads the negative damping of a servo as a damping ratio");
        }
        match &actuator.transmission {
            Transmission::Joint { joint, gear } => {
                let kind = self.robot.joints.iter().find(|own| own.name == *joint).map(|own| own.kind);
                match kind {
                    Some(JointKind::Fixed) | None => Some("its joint is locked"),
                    Some(JointKind::Universal { .. } | JointKind::Planar { .. }) => {
                        Some("its joint becomes several joints in MJCF")
                    }
                    Some(JointKind::Floating) if gear[..3] != [0.0; 3] => {
                        Some("in MJCF forces on a free joint are along the axes of the world")
                    }
                    _ => None,
                }
            }
            Transmission::JointInParent { joint, .. } => {
                self.is_locked(joint).then_some("its joint is locked")
            }
            Transmission::Tendon { tendon, .. } => {
                let tendon = self.robot.tendons.iter().find(|own| own.name == *tendon);
                let moves =
                    tendon.is_some_and(|tendon| tendon.terms.iter().any(|(joint, _)| !self.is_locked(joint)));
                (!moves && tendon.is_some()).then_some("no joint of its tendon moves")
            }
            Transmission::Frame { .. }
            | Transmission::RelativeFrame { .. }
            | Transmission::Contacts { .. }
            | Transmission::SliderCrank { .. } => None,
        }
    }

    fn write_controller(&mut self, place: &str, actuator: &ActuatorDescription, controller: &Controller) {
        let Controller { element, inputs, ranges, numbers } = controller;
        self.xml.start(element).attribute("name", &actuator.name);
        self.write_target(actuator);
        self.xml.attribute("input", inputs);
        for (name, range) in ranges {
            self.write_range(place, name, *range);
        }
        for (name, numbers) in numbers {
            self.xml.numbers(name, numbers);
        }
        self.xml.end();
    }

    fn write_actuator(&mut self, place: &str, actuator: &ActuatorDescription) {
        self.xml.start("general").attribute("name", &actuator.name);
        self.write_target(actuator);
        self.write_range(place, "ctrlrange", actuator.control_range);
        self.write_range(place, "forcerange", actuator.force_range);
        match actuator.activation {
            Activation::None | Activation::RateLimit { .. } => {}
            Activation::Integrator => {
                self.xml.attribute("dyntype", "integrator");
            }
            Activation::Filter { time_constant } => {
                self.xml.attribute("dyntype", "filterexact").numbers("dynprm", &[time_constant]);
            }
            Activation::Muscle { rise, fall, width } => {
                self.xml.attribute("dyntype", "muscle").numbers("dynprm", &[rise, fall, width]);
            }
        }
        self.write_range(place, "actrange", actuator.activation_range);
        if let Some(muscle) = &actuator.muscle {
            self.write_muscle(muscle);
        } else {
            self.write_law("gain", &actuator.gain);
            self.write_law("bias", &actuator.bias);
        }
        self.xml.end();
    }

    /// Writes the transmission.
    fn write_target(&mut self, actuator: &ActuatorDescription) {
        match &actuator.transmission {
            Transmission::Joint { joint, gear } => {
                self.xml.attribute("joint", joint);
                self.write_gear(gear);
            }
            Transmission::Tendon { tendon, gear } => {
                self.xml.attribute("tendon", tendon).unless("gear", *gear, 1.0);
            }
            Transmission::Frame { frame, gear } => {
                self.write_site("site", frame);
                self.write_gear(gear);
            }
            Transmission::JointInParent { joint, gear, moment_in_child } => {
                self.xml.attribute(if *moment_in_child { "joint" } else { "jointinparent" }, joint);
                self.write_gear(gear);
            }
            Transmission::RelativeFrame { frame, reference, gear } => {
                self.write_site("site", frame);
                self.write_site("refsite", reference);
                self.write_gear(gear);
            }
            Transmission::Contacts { link } => {
                let body = self.body_name(link);
                self.xml.attribute("body", &body);
            }
            Transmission::SliderCrank { crank, slider, rod_length, gear } => {
                self.write_site("cranksite", crank);
                self.write_site("slidersite", slider);
                self.xml.numbers("cranklength", &[*rod_length]).unless("gear", *gear, 1.0);
            }
        }
    }

    fn write_site(&mut self, attribute: &str, frame: &str) {
        let site = self.link_sites.get(frame).map_or(frame, String::as_str).to_owned();
        self.xml.attribute(attribute, &site);
    }

    fn write_gear(&mut self, gear: &[f64; 6]) {
        if *gear != [1.0, 0.0, 0.0, 0.0, 0.0, 0.0] {
            self.xml.numbers("gear", gear);
        }
    }

    fn write_muscle(&mut self, muscle: &Muscle) {
        let [lower, upper] = muscle.range;
        let [shortest, longest] = muscle.active_range;
        let curves = [
            lower,
            upper,
            muscle.peak_force,
            // The scale, which only a negative peak force would need.
            0.0,
            shortest,
            longest,
            muscle.shortening_velocity,
            muscle.passive_force,
            muscle.lengthening_force,
        ];
        self.xml.numbers("lengthrange", &muscle.length_range);
        self.xml.attribute("gaintype", "muscle").numbers("gainprm", &curves);
        self.xml.attribute("biastype", "muscle").numbers("biasprm", &curves);
    }

    /// Writes gain or bias, whose defaults are 1 and 0.
    fn write_law(&mut self, what: &str, law: &Affine) {
        let Affine { constant, length, velocity } = *law;
        if length != 0.0 || velocity != 0.0 || (what == "bias" && constant != 0.0) {
            self.xml.attribute(&format!("{what}type"), "affine");
            self.xml.numbers(&format!("{what}prm"), &[constant, length, velocity]);
        } else if what == "gain" && constant != 1.0 {
            self.xml.numbers("gainprm", &[constant]);
        }
    }
}
