//! The parts of a robot file besides links and joints: actuators, tendons, springs, equalities, poses,
//! shapes.

use std::fmt::Write;

use robot_dynamics::description::{
    Equality, FluidForm, RobotDescription, SensorObject, Shape, ShapeRole, TendonPathElement, TendonSurface,
    Transmission,
};
use robot_dynamics::model::Model;
use robot_dynamics::text::one_line;

use crate::table::{Table, count, short};

/// One text for each kind of feature in the file.
pub(super) fn parts(model: &Model) -> Vec<String> {
    let robot = model.description();
    let parts = [
        actuators(robot),
        tendons(robot),
        springs(robot),
        fluid(robot),
        equalities(robot),
        sensors(robot),
        poses(robot),
        groups(robot),
        shapes(robot),
    ];
    parts.into_iter().filter(|part| !part.is_empty()).collect()
}

fn actuators(robot: &RobotDescription) -> String {
    if robot.actuators.is_empty() {
        return String::new();
    }
    let head = ["actuator", "on", ">gear", ">gain", ">k", ">d", ">min control", ">max", ">min force", ">max"];
    let mut table = Table::new(&head);
    for actuator in &robot.actuators {
        let (on, gear) = match &actuator.transmission {
            Transmission::Joint { joint, gear } => (joint.clone(), numbers(gear)),
            Transmission::JointInParent { joint, gear, .. } => {
                (format!("{joint} in its parent"), numbers(gear))
            }
            Transmission::Tendon { tendon, gear } => (format!("tendon {tendon}"), short(*gear)),
            Transmission::Frame { frame, gear } => (format!("frame {frame}"), numbers(gear)),
            Transmission::RelativeFrame { frame, reference, gear } => {
                (format!("frame {frame} in {reference}"), numbers(gear))
            }
            Transmission::Contacts { link } => (format!("contacts of {link}"), String::new()),
            Transmission::SliderCrank { crank, slider, gear, .. } => {
                (format!("slider {slider} of crank {crank}"), short(*gear))
            }
        };
        let (gain, bias) = (actuator.gain, actuator.bias);
        let of_state = if actuator.muscle.is_some() {
            ["muscle".to_owned(), String::new(), String::new()]
        } else {
            [gain.constant, 0.0 - bias.length, 0.0 - bias.velocity].map(short)
        };
        let ranges = actuator.control_range.into_iter().chain(actuator.force_range).map(short);
        table.row([actuator.name.clone(), on, gear].into_iter().chain(of_state).chain(ranges));
    }
    format!("Actuators, f = gain·u − k ℓ − d ℓ̇ (- for unlimited):\n{}", table.text())
}

/// The numbers up to the last nonzero one.
fn numbers(gear: &[f64]) -> String {
    let used = gear.iter().rposition(|gear| *gear != 0.0).map_or(1, |last| last + 1);
    gear[..used].iter().map(|gear| short(*gear)).collect::<Vec<_>>().join(" ")
}

fn tendons(robot: &RobotDescription) -> String {
    let mut text = String::new();
    for tendon in &robot.tendons {
        let terms = tendon.terms.iter().map(|(joint, factor)| format!("{}·{joint}", short(*factor)));
        let terms: Vec<String> = terms.collect();
        let line = format!("{}: ℓ = {}", tendon.name, terms.join(" + "));
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    for tendon in &robot.spatial_tendons {
        let path = tendon.path.iter().map(|element| match element {
            TendonPathElement::Point { frame } => frame.clone(),
            TendonPathElement::Surface { link, surface: TendonSurface::Sphere, .. } => {
                format!("(around a sphere of {link})")
            }
            TendonPathElement::Surface { link, surface: TendonSurface::Cylinder, .. } => {
                format!("(around a cylinder of {link})")
            }
            TendonPathElement::Pulley { divisor } => format!("; 1/{} of", short(*divisor)),
        });
        let line = format!("{}: {}", tendon.name, path.collect::<Vec<_>>().join(" – "));
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    if text.is_empty() { text } else { format!("Tendons:\n{text}") }
}

/// Joints with springs that g does not contain.
fn springs(robot: &RobotDescription) -> String {
    let mut text = String::new();
    for joint in &robot.joints {
        if let Some(spring) = &joint.spring {
            let _ = writeln!(text, "  {}: {} N·m/rad", one_line(&joint.name), short(spring.stiffness));
        }
    }
    if text.is_empty() {
        text
    } else {
        format!("Springs of spherical and floating joints, not part of g:\n{text}")
    }
}

/// The fluid, and the number of shapes on which it acts.
fn fluid(robot: &RobotDescription) -> String {
    let medium = &robot.medium;
    if !medium.acts() {
        return String::new();
    }
    let is_box = |form: &FluidForm| matches!(form, FluidForm::InertiaBox { .. });
    let boxes = robot.fluid_shapes.iter().filter(|shape| is_box(&shape.form)).count();
    let ellipsoids = robot.fluid_shapes.len() - boxes;
    let [density, viscosity] = [medium.density, medium.viscosity].map(short);
    let mut text = format!("Fluid of {density} kg/m³ and {viscosity} Pa·s");
    if medium.wind != [0.0; 3] {
        let _ = write!(text, ", wind {} m/s", medium.wind.map(short).join(" "));
    }
    let boxes = if boxes == 1 { "1 inertia box".to_owned() } else { format!("{boxes} inertia boxes") };
    let _ = writeln!(text, ", on {boxes} and {} (not part of M, C and g)", count(ellipsoids, "ellipsoid"));
    text
}

fn equalities(robot: &RobotDescription) -> String {
    let mut text = String::new();
    for equality in &robot.equalities {
        let what = match &equality.kind {
            Equality::Joints { joint: own, leader: Some(leader), .. }
            | Equality::Tendons { tendon: own, leader: Some(leader), .. } => {
                format!("{} is a function of {}", own.0, leader.0)
            }
            Equality::Joints { joint: own, leader: None, .. }
            | Equality::Tendons { tendon: own, leader: None, .. } => format!("{} is fixed", own.0),
            Equality::Connect { a, b } => format!("a point of {} coincides with one of {}", a.0, b.0),
            Equality::Weld { a, b, .. } => format!("{a} and {b} are welded"),
        };
        let off = if equality.active { "" } else { " (inactive)" };
        let line = format!("{}: {what}{off}", equality.name);
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    if text.is_empty() { text } else { format!("Equalities (not part of M, C and g):\n{text}") }
}

fn sensors(robot: &RobotDescription) -> String {
    if robot.sensors.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&["sensor", "kind", "on", "relative to", ">numbers"]);
    for sensor in &robot.sensors {
        let reference = sensor.reference.as_ref().map_or_else(|| "-".to_owned(), object);
        let kind = sensor.kind;
        table.row([
            sensor.name.clone(),
            kind.name().to_owned(),
            object(&sensor.object),
            reference,
            kind.size().to_string(),
        ]);
    }
    format!("Sensors:\n{}", table.text())
}

fn object(object: &SensorObject) -> String {
    match object {
        SensorObject::Robot => "the robot".into(),
        SensorObject::Named(name) => name.clone(),
        SensorObject::CenterOfMass(link) => format!("centre of mass of {link}"),
        SensorObject::Shape(shape) => format!("shape {shape}"),
    }
}

fn poses(robot: &RobotDescription) -> String {
    let names: Vec<&str> = robot.poses.iter().map(|pose| pose.name.as_str()).collect();
    if names.is_empty() { String::new() } else { format!("Poses: {}\n", one_line(&names.join(", "))) }
}

/// The groups of an SRDF file, and those that are tools.
fn groups(robot: &RobotDescription) -> String {
    let mut text = String::new();
    for group in &robot.groups {
        let (links, joints) = (count(group.links.len(), "link"), count(group.joints.len(), "joint"));
        let tools = robot.end_effectors.iter().filter(|tool| tool.group == group.name);
        let tools = tools.map(|tool| format!("; end effector {} on {}", tool.name, tool.parent_link));
        let line = format!("{}: {links}, {joints}{}", group.name, tools.collect::<Vec<_>>().concat());
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    if text.is_empty() { text } else { format!("Groups:\n{text}") }
}

/// The number of shapes of each kind, and of mesh files that are missing.
fn shapes(robot: &RobotDescription) -> String {
    let mut text = String::new();
    for (role, of) in [(ShapeRole::Visual, "visual"), (ShapeRole::Collision, "collision")] {
        let mut forms: Vec<(&str, usize)> = Vec::new();
        for shape in robot.shapes.iter().filter(|shape| shape.role == role) {
            let form = match shape.shape {
                Shape::Box { .. } => "box",
                Shape::Cylinder { .. } => "cylinder",
                Shape::Sphere { .. } => "sphere",
                Shape::Capsule { .. } => "capsule",
                Shape::Ellipsoid { .. } => "ellipsoid",
                Shape::Plane { .. } => "plane",
                Shape::HeightField { .. } => "height field",
                Shape::Mesh { .. } => "mesh",
            };
            match forms.iter_mut().find(|(known, _)| *known == form) {
                Some((_, number)) => *number += 1,
                None => forms.push((form, 1)),
            }
        }
        let forms: Vec<String> = forms.into_iter().map(|(form, number)| several(number, form)).collect();
        if !forms.is_empty() {
            let _ = writeln!(text, "  {of}: {}", forms.join(", "));
        }
    }
    let files = robot.shapes.iter().filter_map(|shape| shape.shape.file());
    let (found, missing): (Vec<_>, Vec<_>) = files.partition(|(_, file)| file.is_some());
    if !found.is_empty() || !missing.is_empty() {
        let _ = writeln!(text, "  {} found, {} missing", count(found.len(), "file"), missing.len());
    }
    if text.is_empty() { text } else { format!("Shapes:\n{text}") }
}

fn several(number: usize, form: &str) -> String {
    match form {
        "box" | "mesh" if number != 1 => format!("{number} {form}es"),
        _ => count(number, form),
    }
}
