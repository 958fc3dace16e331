//! Reads `<joint>`.

use core::f64::consts::TAU;

use robot_dynamics_description::{Limits, PassiveForces};
use robot_dynamics_xml::excerpt;

use super::parts::{Attachment, Axis, Frame, FrameKind, JointType, Parts, Scope, SdfJoint, SdfMimic, Target};
use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The squares of shorter axes underflow in double precision.
const SHORTEST_AXIS: f64 = 1e-100;

impl Parts<'_> {
    pub(super) fn joint<'a>(&mut self, reader: &mut Reader<'a>, element: &Element<'a>, scope: &Scope) {
        let known = [
            "parent",
            "child",
            "pose",
            "axis",
            "axis2",
            "thread_pitch",
            "screw_thread_pitch",
            "physics",
            "sensor",
            "plugin",
            "gearbox_ratio",
            "gearbox_reference_body",
        ];
        reader.list_unread(element, &["name", "type"], &known, UnknownPart::Physics);
        let name = reader.own_name(element);
        let full = format!("{}{name}", scope.prefix);
        let (written_type, kind, axis_count) = type_of(reader, element);
        let advice = "write <parent>NAME</parent> and <child>NAME</child>";
        let [parent, child] =
            ["parent", "child"].map(|role| reader.required_child_text(element, role, advice));
        if child == "world" {
            reader.refuse_sdf(element, "the world cannot be the child; exchange <parent> and <child>");
        }
        let (parent, child) = (scope.target(parent), scope.target(child));
        let written = reader.pose(element);
        let relative_to = written.relative_to.map_or_else(|| child.clone(), |name| scope.target(name));
        let at = self.place(element);
        let attached_to = Attachment::Frame(child.clone());
        let frame = Frame { at: at.clone(), relative_to, pose: written.pose, placement: None, attached_to };
        let frame = self.add_frame(reader, element, FrameKind::Joint, &full, frame);
        let axes = self.axes(reader, element, scope, (written_type, kind, axis_count));
        for (name, message) in [
            ("physics", "settings of one physics engine"),
            ("sensor", "a sensor"),
            ("plugin", "a program for a simulator"),
        ] {
            if let Some(part) = reader.child(element, name) {
                reader.report_ignored(part.line, part.place, message);
            }
        }
        let pitch = if kind == JointType::Screw { pitch(reader, element) } else { 0.0 };
        reader.report_read(element, format!("{} joint", written_type.unwrap_or_default()));
        self.joints.push(SdfJoint {
            name: full,
            at,
            kind,
            frame,
            parent,
            child,
            axes,
            pitch,
            is_static: scope.is_static,
        });
    }

    /// Reads as many axes as a joint of this type has, and reports the others.
    fn axes<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        scope: &Scope,
        (written_type, kind, axis_count): (Option<&str>, JointType, usize),
    ) -> Vec<Axis> {
        let mut axes = Vec::new();
        for name in ["axis", "axis2"] {
            let Some(axis) = reader.child(element, name) else {
                if axes.len() < axis_count {
                    let (line, place) = (element.line, element.place.clone());
                    let advice = "give its direction by <xyz>";
                    let element = if name == "axis" { "axis" } else { "axis2" };
                    reader.refuse(UrdfError::MissingElement { line, place, element, advice });
                }
                continue;
            };
            if axes.len() == axis_count {
                let (line, place) = (axis.line, axis.place.clone());
                let message =
                    format!("a joint of the type {} has no <{name}>", written_type.unwrap_or_default());
                reader.report_ignored(line, place, message);
                continue;
            }
            let axis = self.axis(reader, &axis, scope, kind);
            axes.push(axis);
        }
        axes
    }

    fn axis<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        scope: &Scope,
        kind: JointType,
    ) -> Axis {
        let known = ["xyz", "dynamics", "limit", "mimic", "use_parent_model_frame", "initial_position"];
        reader.list_unread(element, &[], &known, UnknownPart::Physics);
        let mut axis = Axis {
            xyz: [0.0, 0.0, 1.0],
            expressed_in: None,
            limits: Limits::default(),
            passive: PassiveForces::default(),
            mimic: None,
        };
        // Up to version 1.4 an axis is in the frame of the model.
        let in_model = reader.child_flag(element, "use_parent_model_frame").unwrap_or(self.version <= (1, 4));
        if in_model && self.version < (1, 7) {
            axis.expressed_in = Some(Target::Id(scope.model));
        }
        if let Some((xyz, text)) = reader.child_text(element, "xyz") {
            reader.list_unread_attributes(&xyz, &["expressed_in"], UnknownPart::Physics);
            if let Some(name) = xyz.text("expressed_in").filter(|name| !name.trim().is_empty()) {
                axis.expressed_in = Some(scope.target(name.trim()));
            }
            axis.xyz = reader.text_numbers(&xyz, "xyz", text);
            if axis.xyz.iter().all(|c| c.abs() < SHORTEST_AXIS) {
                reader.refuse_sdf(&xyz, "the axis is zero; give a direction such as 0 0 1");
            }
        } else {
            reader.report_default(element, "no <xyz>: taken as 0 0 1");
        }
        if let Some(limit) = reader.child(element, "limit") {
            let known = ["lower", "upper", "effort", "velocity", "stiffness", "dissipation"];
            reader.list_unread(&limit, &[], &known, UnknownPart::Harmless);
            axis.limits = limits(reader, &limit, kind);
        }
        if let Some(dynamics) = reader.child(element, "dynamics") {
            let known = ["damping", "friction", "spring_reference", "spring_stiffness"];
            reader.list_unread(&dynamics, &[], &known, UnknownPart::Physics);
            let [damping, friction, rest, stiffness] =
                known.map(|name| reader.child_number(&dynamics, name).unwrap_or(0.0));
            for (name, value, effect) in [
                ("damping", damping, "which adds energy to the motion"),
                ("friction", friction, "which adds energy to the motion"),
                ("spring_stiffness", stiffness, "so that the spring pushes away from its rest position"),
            ] {
                reader.warn_if_negative(&dynamics, name, value, effect);
            }
            axis.passive = PassiveForces::default()
                .with_damping(damping)
                .with_friction(friction)
                .with_spring(stiffness, rest);
        }
        if let Some(mimic) = reader.child(element, "mimic") {
            let known = ["multiplier", "offset", "reference"];
            reader.list_unread(&mimic, &["joint", "axis"], &known, UnknownPart::Physics);
            let leader = reader.required_name(&mimic, "joint", "joint=\"NAME\", the joint to follow");
            let [ratio, offset, reference] = known.map(|name| reader.child_number(&mimic, name));
            let ratio = ratio.unwrap_or(1.0);
            axis.mimic = Some(SdfMimic {
                joint: format!("{}{leader}", scope.prefix),
                is_second_axis: mimic.text("axis") == Some("axis2"),
                ratio,
                offset: offset.unwrap_or(0.0) - ratio * reference.unwrap_or(0.0),
            });
        }
        if let Some(position) = reader.child(element, "initial_position") {
            reader.report_ignored(position.line, position.place, "the initial position is not used");
        }
        axis
    }
}

fn limits<'a>(reader: &mut Reader<'a>, element: &Element<'a>, kind: JointType) -> Limits {
    let [lower, upper] = ["lower", "upper"].map(|name| reader.child_bound(element, name));
    let (lower, upper) = match kind {
        JointType::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
        _ => (lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)),
    };
    if lower > upper {
        let message = format!(
            "the lower limit {lower} is above the upper limit {upper}: taken as written, so that no position satisfies \
             them; exchange or correct them"
        );
        reader.warn(element, message);
    }
    // A negative bound means that the joint is unlimited.
    let [effort, velocity] = ["effort", "velocity"].map(|name| {
        reader
            .child_bound(element, name)
            .filter(|bound| *bound >= 0.0 || bound.is_nan())
            .unwrap_or(f64::INFINITY)
    });
    for (name, bound, meaning) in [
        ("effort", effort, "so that the motor has no force"),
        ("velocity", velocity, "so that the joint cannot move"),
    ] {
        if bound == 0.0 {
            reader.warn(element, format!("{name} 0: taken as written, {meaning}; omit it for no bound"));
        }
    }
    Limits::new(lower, upper).with_effort(effort).with_velocity(velocity)
}

/// The advance of a screw \[m/rad\].
fn pitch<'a>(reader: &mut Reader<'a>, element: &Element<'a>) -> f64 {
    if let Some(pitch) = reader.child_number(element, "screw_thread_pitch") {
        return pitch / TAU;
    }
    match reader.child_number(element, "thread_pitch") {
        // rad/m, positive for a left-handed thread.
        Some(pitch) if pitch != 0.0 => -1.0 / pitch,
        Some(_) => {
            reader.refuse_sdf(
                element,
                "thread_pitch is 0; write <screw_thread_pitch>METRES PER TURN</screw_thread_pitch>",
            );
            0.0
        }
        None => {
            let (line, place) = (element.line, element.place.clone());
            let advice = "write <screw_thread_pitch>METRES PER TURN</screw_thread_pitch>";
            reader.refuse(UrdfError::MissingElement { line, place, element: "screw_thread_pitch", advice });
            0.0
        }
    }
}

/// The type of a joint as the file writes it, its kind, and the number of its axes.
fn type_of<'a>(reader: &mut Reader<'a>, element: &Element<'a>) -> (Option<&'a str>, JointType, usize) {
    let written_type = reader.required_text(element, "type", "type=\"revolute\" or another joint type");
    let (kind, axis_count) = match written_type.unwrap_or("fixed") {
        "fixed" => (JointType::Fixed, 0),
        "revolute" | "hinge" => (JointType::Revolute, 1),
        "continuous" => (JointType::Continuous, 1),
        "prismatic" | "slider" => (JointType::Prismatic, 1),
        "screw" => (JointType::Screw, 1),
        "ball" => (JointType::Ball, 0),
        "universal" | "revolute2" => (JointType::TwoAxes, 2),
        other => {
            let reason = match other {
                "gearbox" => "gearbox joints are not read; couple two joints by <mimic>".to_owned(),
                _ => format!(
                    "the type {:?} is unknown; use fixed, revolute, continuous, prismatic, screw, ball, \
                     universal or revolute2",
                    excerpt(other)
                ),
            };
            reader.refuse_sdf(element, reason);
            (JointType::Fixed, 0)
        }
    };
    (written_type, kind, axis_count)
}
