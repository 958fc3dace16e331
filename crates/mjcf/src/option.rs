//! Reads `<option>`: gravity, the fluid, time step and flags.

use robot_dynamics_description::{Disposition, Limits, RobotDescription, ShapeRole};
use robot_dynamics_xml::excerpt;

use crate::reader::Reader;
use crate::tree::Tree;

/// The forces, bounds and constraints that flags disable.
#[derive(Clone, Copy, Debug, Default)]
#[allow(clippy::struct_excessive_bools)] // one for each thing that can be switched off
pub(crate) struct DisabledForces {
    pub(crate) gravity: bool,
    pub(crate) springs: bool,
    pub(crate) dampers: bool,
    pub(crate) friction: bool,
    contacts: bool,
    equalities: bool,
    limits: bool,
    /// Whether the bounds of controls are without effect.
    pub(crate) control_bounds: bool,
    /// Whether no actuator exerts a force.
    actuators: bool,
    /// Bits of the groups whose actuators exert no force.
    actuator_groups: u32,
}

impl DisabledForces {
    /// Whether actuators of this group exert no force.
    pub(crate) fn has_actuator_group(self, group: f64) -> bool {
        self.actuators || (0..31).any(|k| group == f64::from(k) && self.actuator_groups & (1 << k) != 0)
    }

    /// Removes the constraints that are disabled: equalities, limits of joints and tendons, and contacts.
    /// Shapes then have no bits of contact. Without springs and dampers MuJoCo has no gravity compensation
    /// either. Without actuators no gravity compensation acts through actuators.
    pub(crate) fn remove_from(self, robot: &mut RobotDescription) {
        if self.springs && self.dampers {
            robot.links.iter_mut().for_each(|link| link.gravity_compensation = 0.0);
        }
        if self.actuators {
            let through_actuators =
                robot.joints.iter_mut().filter(|joint| joint.actuator_compensates_gravity);
            through_actuators.for_each(|joint| joint.actuator_force_range = [0.0; 2]);
        }
        if self.equalities {
            robot.equalities.clear();
        }
        if self.contacts {
            robot.contact_pairs.clear();
            for shape in &mut robot.shapes {
                shape.role = ShapeRole::Visual;
                (shape.surface.contype, shape.surface.conaffinity) = (0, 0);
            }
        }
        if self.limits {
            let joints = robot.joints.iter_mut().map(|joint| &mut joint.limits);
            let tendons = robot.tendons.iter_mut().map(|tendon| &mut tendon.limits);
            let paths = robot.spatial_tendons.iter_mut().map(|tendon| &mut tendon.limits);
            for limits in joints.chain(tendons).chain(paths) {
                let Limits { lower, upper, turn, .. } = Limits::default();
                (limits.lower, limits.upper, limits.turn) = (lower, upper, turn);
            }
        }
    }
}

impl Reader<'_> {
    /// Reads all `<option>` elements. The last value of an attribute counts.
    pub(crate) fn read_option(&mut self, robot: &mut RobotDescription) -> DisabledForces {
        let mut disabled = DisabledForces::default();
        // `passive` was removed from the format in favour of `spring` and `damper`.
        let [mut constraints, mut passive] = [false; 2];
        for node in self.tree.children(Tree::ROOT, "option").collect::<Vec<_>>() {
            let element = self.raw_element(node);
            if let Some(gravity) = self.numbers::<3>(&element, "gravity") {
                robot.gravity = gravity;
                self.report_read(&element, format!("gravity {gravity:?} m/s²"));
            }
            if let Some(step) = self.number(&element, "timestep") {
                robot.time_step = Some(step);
                self.report_read(&element, format!("time step {step} s"));
            }
            if let Some(impratio) = self.number(&element, "impratio") {
                robot.impratio = Some(impratio);
                self.report_read(&element, format!("impratio {impratio}"));
            }
            for (name, unit) in [("density", "kg/m³"), ("viscosity", "Pa·s")] {
                let Some(value) = self.magnitude(&element, name) else { continue };
                if name == "density" {
                    robot.medium.density = value;
                } else {
                    robot.medium.viscosity = value;
                }
                self.report_read(&element, format!("{name} of the fluid {value} {unit}"));
            }
            if let Some(wind) = self.numbers::<3>(&element, "wind") {
                robot.medium.wind = wind;
                self.report_read(&element, format!("velocity of the fluid {wind:?} m/s"));
            }
            if let Some(text) = self.text(&element, "actuatorgroupdisable") {
                let text = text.to_owned();
                for word in text.split_whitespace() {
                    match word.parse::<u32>() {
                        Ok(group) if group < 31 => disabled.actuator_groups |= 1 << group,
                        _ => self.refuse(&element, "actuatorgroupdisable: groups are integers from 0 to 30"),
                    }
                }
                self.report_read(&element, format!("actuators of the groups {text} are disabled"));
            }
            if let Some(integrator) = self.text(&element, "integrator") {
                let message =
                    format!("integrator {:?}: each simulation chooses its own", excerpt(integrator));
                self.report_read(&element, message);
            }
            for flags in self.tree.children(node, "flag").collect::<Vec<_>>() {
                let flags = self.raw_element(flags);
                let mut read = |name| {
                    let word = self.word(&flags, name, &["enable", "disable"]);
                    if word == Some("disable") {
                        self.report_read(&flags, format!("{name} is disabled"));
                    }
                    word.map(|word| word == "disable")
                };
                for (name, own) in [
                    ("gravity", &mut disabled.gravity),
                    ("spring", &mut disabled.springs),
                    ("damper", &mut disabled.dampers),
                    ("frictionloss", &mut disabled.friction),
                    ("contact", &mut disabled.contacts),
                    ("equality", &mut disabled.equalities),
                    ("limit", &mut disabled.limits),
                    ("constraint", &mut constraints),
                    ("passive", &mut passive),
                    ("clampctrl", &mut disabled.control_bounds),
                    ("actuation", &mut disabled.actuators),
                ] {
                    *own = read(name).unwrap_or(*own);
                }
            }
        }
        disabled.springs |= passive;
        disabled.dampers |= passive;
        if constraints {
            let DisabledForces { friction, contacts, equalities, limits, .. } = &mut disabled;
            for own in [friction, contacts, equalities, limits] {
                *own = true;
            }
        }
        if disabled.gravity {
            robot.gravity = [0.0; 3];
        }
        disabled
    }

    /// Reports the options of attached models, which are ignored. MuJoCo ignores them, too, unless `conflict`
    /// is `merge`.
    pub(crate) fn other_options(&mut self) {
        let tree = self.tree;
        let mut policy = None;
        for node in tree.children(Tree::ROOT, "compiler") {
            let element = self.raw_element(node);
            policy = self.word(&element, "conflict", &["warning", "merge", "error"]).or(policy);
        }
        let is_merged = policy == Some("merge");
        for node in tree.models.iter().skip(1).flat_map(|model| tree.children(model.root, "option")) {
            let element = self.raw_element(node);
            let physics = ["gravity", "density", "viscosity", "wind", "timestep"];
            let has_physics = physics.iter().any(|name| tree.nodes[node].attribute(name).is_some());
            if is_merged && (has_physics || !tree.nodes[node].children.is_empty()) {
                self.report_ignored_physics(
                    &element,
                    "conflict=\"merge\": options of an attached model are not merged",
                );
            } else {
                let message = "options of an attached model: those of the main file count";
                let disposition = Disposition::Ignored { physics: false };
                self.push(element.line, element.place, disposition, message.into());
            }
        }
    }
}
