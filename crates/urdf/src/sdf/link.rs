//! Reads `<link>` and `<inertial>`.

use nalgebra::Matrix3;
use robot_dynamics_description::{MassProperties, Pose, ShapeRole};
use robot_dynamics_xml::roxmltree::Node;

use super::parts::{Attachment, Frame, FrameKind, Parts, Scope, SdfLink, SdfShape, Target};
use crate::UrdfError;
use crate::element::Element;
use crate::inertial::Inertial;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// Water, the default of shapes \[kg/m³\].
const DENSITY: f64 = 1000.0;

/// Elements of a link that do not affect the motion.
const LINK_NOTES: [&str; 12] = [
    "sensor",
    "projector",
    "audio_sink",
    "audio_source",
    "battery",
    "light",
    "particle_emitter",
    "plugin",
    "enable_wind",
    "must_be_base_link",
    "self_collide",
    "link_state",
];

impl Parts<'_> {
    /// Reads a link and returns its index.
    pub(super) fn link<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        scope: &Scope,
    ) -> usize {
        let known = ["pose", "inertial", "collision", "visual", "gravity", "kinematic", "velocity_decay"];
        reader.list_unread(element, &["name"], &[&known[..], &LINK_NOTES].concat(), UnknownPart::Harmless);
        let name = reader.own_name(element);
        let full = format!("{}{name}", scope.prefix);
        let written = reader.pose(element);
        let relative_to = written.relative_to.map_or(Target::Id(scope.model), |name| scope.target(name));
        let index = self.links.len();
        let attached_to = if scope.is_static { Attachment::World } else { Attachment::Link(index) };
        let at = self.place(element);
        let frame = Frame { at: at.clone(), relative_to, pose: written.pose, placement: None, attached_to };
        let frame = self.add_frame(reader, element, FrameKind::Link, &full, frame);
        let has_gravity = reader.child_flag(element, "gravity").unwrap_or(true);
        if !has_gravity {
            reader.report_read(element, "without gravity: its weight is compensated");
        }
        if reader.child_flag(element, "kinematic") == Some(true) {
            let (line, place) = (element.line, element.place.clone());
            reader.report_ignored_physics(line, place, "kinematic: taken as a link that forces move");
        }
        if let Some(decay) = reader.child(element, "velocity_decay") {
            for name in ["linear", "angular"] {
                if let Some(value) = reader.child_number(&decay, name).filter(|value| *value != 0.0) {
                    let (line, place) = (decay.line, decay.place.clone());
                    reader.report_ignored_physics(
                        line,
                        place,
                        format!("{name} = {value} is not in the model"),
                    );
                }
            }
        }
        let self_collides = reader.child_flag(element, "self_collide").unwrap_or(scope.self_collides);
        let mut shapes = Vec::new();
        let mut collisions = Vec::new();
        for node in element.node.children().filter(Node::is_element) {
            let role = match node.tag_name().name() {
                "collision" if reader.is_own(node) => ShapeRole::Collision,
                "visual" if reader.is_own(node) => ShapeRole::Visual,
                tag if LINK_NOTES.contains(&tag) && tag != "self_collide" => {
                    let (line, place) = (reader.line(node), format!("{}/{tag}", element.place));
                    reader.report_ignored(line, place, "a part for the Gazebo simulator");
                    continue;
                }
                _ => continue,
            };
            let part = Element {
                node,
                line: reader.line(node),
                place: format!("{}/{}", element.place, node.tag_name().name()),
            };
            if let Some(shape) = self.shape(reader, &part, role, scope) {
                if role == ShapeRole::Collision {
                    collisions.push((part, shapes.len()));
                }
                shapes.push(shape);
            }
        }
        let mass_properties = mass_properties_of(reader, element, &shapes, &collisions);
        let is_static = scope.is_static;
        self.links.push(SdfLink {
            name: full,
            at,
            frame,
            mass_properties,
            has_gravity,
            is_static,
            self_collides,
            shapes,
        });
        index
    }
}

/// The mass properties of a link: by default 1 kg with moments of 1 kg m².
fn mass_properties_of<'a>(
    reader: &mut Reader<'a>,
    link: &Element<'a>,
    shapes: &[SdfShape],
    collisions: &[(Element<'a>, usize)],
) -> Option<MassProperties> {
    let Some(element) = reader.child(link, "inertial") else {
        reader.report_default(link, "no <inertial>: 1 kg and moments of 1 kg·m², the default of SDF");
        return MassProperties::as_written(1.0, nalgebra::Vector3::zeros(), Matrix3::identity()).ok();
    };
    let known = ["pose", "mass", "inertia", "density", "auto_inertia_params"];
    reader.list_unread(&element, &["auto"], &known, UnknownPart::Physics);
    let written = reader.pose(&element);
    if written.relative_to.is_some_and(|name| Some(name) != link.text("name")) {
        reader.refuse_sdf(&element, "the pose of <inertial> is that in its link; delete relative_to");
    }
    let mass = reader.child_number(&element, "mass");
    if let Some(mass) = mass.filter(|mass| *mass < 0.0) {
        let (line, place) = (element.line, element.place.clone());
        let advice = "correct its sign";
        reader.refuse(UrdfError::Negative { line, place, attribute: "mass".into(), value: mass, advice });
        return None;
    }
    if element.text("auto").and_then(|text| reader.flag(&element, text)) == Some(true) {
        return automatic(reader, &element, mass, shapes, collisions);
    }
    if mass.is_none() {
        reader.report_default(&element, "no <mass>: 1 kg, the default of SDF");
    }
    let inertia = match reader.child(&element, "inertia") {
        None => {
            reader.report_default(&element, "no <inertia>: moments of 1 kg·m², the default of SDF");
            Matrix3::identity()
        }
        Some(entries) => {
            let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
            reader.list_unread(&entries, &[], &names, UnknownPart::Physics);
            let [xx, xy, xz, yy, yz, zz] = names.map(|name| reader.child_number(&entries, name));
            let [xx, yy, zz] = [xx, yy, zz].map(|moment| moment.unwrap_or(1.0));
            let [xy, xz, yz] = [xy, xz, yz].map(Option::unwrap_or_default);
            Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
        }
    };
    let inertial = Inertial { element, mass: mass.unwrap_or(1.0), inertia, pose: written.pose };
    reader.mass_properties(&inertial, 0.0)
}

/// The mass properties of the collision shapes, scaled to a mass if the link states one.
fn automatic<'a>(
    reader: &mut Reader<'a>,
    element: &Element<'a>,
    mass: Option<f64>,
    shapes: &[SdfShape],
    collisions: &[(Element<'a>, usize)],
) -> Option<MassProperties> {
    let density = reader.child_number(element, "density").unwrap_or(DENSITY);
    let mut whole: Option<MassProperties> = None;
    for (part, index) in collisions {
        let shape = &shapes[*index];
        let own = reader.child_number(part, "density").unwrap_or(density);
        let solid = shape.shape.solid(own);
        let Some(Ok(solid)) = solid else {
            let reason = "the inertia of this shape is not computed; give <mass> and <inertia> of the link";
            reader.refuse_sdf(part, reason);
            continue;
        };
        if shape.relative_to.is_some() {
            reader
                .refuse_sdf(part, "auto inertia needs poses of <collision> in the link; delete relative_to");
        }
        let Pose { rotation, translation } = shape.pose;
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| rotation[i][j]));
        let placed = solid.transformed(&rotation, &nalgebra::Vector3::from(translation));
        whole = Some(whole.map_or(placed, |whole| whole.combine(&placed)));
    }
    let Some(whole) = whole else {
        reader.report_default(element, "auto, without <collision>: 1 kg and moments of 1 kg·m²");
        return MassProperties::as_written(1.0, nalgebra::Vector3::zeros(), Matrix3::identity()).ok();
    };
    reader.report_read(element, format!("mass {} kg and inertia from the collision shapes", whole.mass()));
    let Some(mass) = mass else { return Some(whole) };
    let factor = mass / whole.mass();
    MassProperties::as_written(mass, whole.center_of_mass(), whole.inertia_about_center_of_mass() * factor)
        .ok()
}
