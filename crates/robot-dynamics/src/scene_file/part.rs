//! The parts of a scene: robots and objects.

use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{LoadOptions, Resource, Srdf, excerpt};

use super::attributes::Attributes;
use super::fault::SceneFault;
use super::reader::{ReadFile, Reader, is_scene, read};
use super::source::Source;
use crate::description::{Finding, LoadReport, MassProperties, Mount, Object, Severity, Shape};
use crate::load::Content;
use crate::mesh_object::{MeshMass, MeshSolid, of_triangles};
use crate::nalgebra::Matrix3;
use crate::plausibility::WrittenAngles;

/// The elements of a scene.
const PARTS: &str = "robot, ground, table, wall, box, sphere, cylinder, capsule, ellipsoid, mesh";

impl Reader<'_, '_> {
    pub(super) fn read_part(&mut self, node: Node<'_, '_>) {
        let mut attributes = Attributes::of(node, &self.lines);
        if let Some(child) = node.children().find(Node::is_element) {
            attributes.refuse(format!("the element <{}> is unknown here", excerpt(child.tag_name().name())));
        }
        let (line, place) = (attributes.line, attributes.place.clone());
        // The names of each part are compared with those of all parts before it.
        let parts = self.scene.description().links.len();
        if !self.charge(line, &place, Resource::Elements, 1)
            || !self.charge(line, &place, Resource::Steps, parts)
        {
            return;
        }
        let before = self.faults.len();
        let name = node.tag_name().name();
        let object = match name {
            "robot" => {
                let robot = self.robot(&mut attributes);
                self.faults.extend(attributes.finish());
                if let Some((robot, mount)) = robot
                    && self.faults.len() == before
                {
                    self.add_robot(line, &place, robot, &mount);
                }
                return;
            }
            "ground" => {
                let name = attributes.text("name").unwrap_or("ground").to_owned();
                Some(Object { name, ..Object::ground() })
            }
            "mesh" => self.mesh(&mut attributes),
            _ => solid(&mut attributes, name),
        };
        let Some(object) = object else {
            if self.faults.len() == before {
                self.faults.extend(attributes.finish());
            }
            return;
        };
        let mount = attributes.mount();
        let mut object = object.with_surface(attributes.surface());
        object.color = attributes.numbers("color");
        self.faults.extend(attributes.finish());
        if self.faults.len() == before
            && let Err(error) = self.scene.add_object(&object, mount)
        {
            self.faults.push(SceneFault::new(line, &place, error.to_string()));
        }
    }

    /// Reads the file of a robot.
    fn robot(&mut self, attributes: &mut Attributes<'_>) -> Option<(ReadFile, Mount)> {
        let mount = attributes.mount().with_prefix(attributes.text("prefix").unwrap_or_default());
        let floating_base = attributes.flag("floating_base");
        let file = attributes.required("file", "arm.urdf")?;
        let read = self.source.find(file).and_then(|source| Ok((source.content()?, source)));
        let (content, source) = match read {
            Ok(read) => read,
            Err(reason) => {
                attributes.refuse(reason);
                return None;
            }
        };
        if !self.charge(attributes.line, &attributes.place, Resource::Characters, content.len()) {
            return None;
        }
        let srdf = match attributes.text("srdf").map(|file| self.source.find(file)) {
            Some(Err(reason)) => {
                attributes.refuse(reason);
                return None;
            }
            found => found.and_then(Result::ok),
        };
        let srdf = srdf.and_then(|source| Some(Srdf::File(source.path()?.to_owned())));
        let options = LoadOptions { floating_base, srdf, ..self.shared.options.clone() };
        match self.read_file(&content, &source, &options) {
            Ok(read) => Some((read, mount)),
            Err(messages) => {
                for message in messages {
                    attributes.refuse(message);
                }
                None
            }
        }
    }

    /// Reads a robot's file of any format, or a scene.
    fn read_file(
        &mut self,
        content: &Content,
        source: &Source<'_>,
        options: &LoadOptions,
    ) -> Result<ReadFile, Vec<String>> {
        let Some(text) = content.text().filter(|text| is_scene(text)) else {
            return (self.shared.read_robot)(content, source, options);
        };
        if options.floating_base {
            return Err(vec!["a scene has no floating base".to_owned()]);
        }
        let scene = read(text, source, self.shared);
        scene.map_err(|refused| refused.errors().iter().map(ToString::to_string).collect())
    }

    fn add_robot(&mut self, line: usize, place: &str, robot: ReadFile, mount: &Mount) {
        let ReadFile { description, report, angles } = robot;
        let size = description.links.len() + description.shapes.len() + description.joints.len();
        if !self.charge(line, place, Resource::Elements, size) {
            return;
        }
        let notes = self.scene.notes().len();
        if let Err(error) = self.scene.add(&description, mount) {
            self.faults.push(SceneFault::new(line, place, error.to_string()));
            return;
        }
        let added = self.scene.notes()[notes..].to_vec();
        for note in added {
            self.warn(line, place, note);
        }
        self.add_report(line, place, &report);
        let prefix = mount.prefix();
        self.angles.extend(angles.into_iter().map(|written| {
            let place = written.place.replacen('"', &format!("\"{prefix}"), 1);
            WrittenAngles::new(place, written.angles)
        }));
    }

    /// Adds the findings of a robot's file at the line of its element.
    fn add_report(&mut self, line: usize, place: &str, report: &LoadReport) {
        for finding in &report.findings {
            if finding.severity() == Severity::Error {
                continue;
            }
            let message = format!("line {}: {}: {}", finding.line(), finding.place(), finding.message());
            self.report.add(Finding::new(line, place, finding.disposition(), message));
        }
        self.report.counts.not_dynamics += report.counts.not_dynamics;
        self.report.add_files(report.files.iter().map(AsRef::as_ref));
    }

    fn mesh(&mut self, attributes: &mut Attributes<'_>) -> Option<Object> {
        let name = attributes.required("name", "NAME")?;
        let file = attributes.required("file", "mug.stl")?;
        let scale = match attributes.text("scale").map_or(0, |text| text.split_ascii_whitespace().count()) {
            0 => [1.0; 3],
            1 => [attributes.number("scale")?; 3],
            _ => attributes.numbers("scale")?,
        };
        let solid = match attributes.text("solid") {
            None | Some("exact") => MeshSolid::Exact,
            Some("hull") => MeshSolid::Hull,
            Some(other) => {
                attributes.refuse(format!("solid={:?} must be exact or hull", excerpt(other)));
                return None;
            }
        };
        let (mass, density) = (attributes.number("mass"), attributes.number("density"));
        let center = attributes.numbers("center_of_mass").unwrap_or_default();
        let mass = match (mass, density, attributes.numbers::<6>("inertia")) {
            (None, None, None) => MeshMass::Fixed,
            (Some(mass), None, None) => MeshMass::Mass(mass),
            (None, Some(density), None) => MeshMass::Density(density),
            (Some(mass), None, Some([xx, yy, zz, xy, xz, yz])) => {
                let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
                match MassProperties::new(mass, center.into(), inertia) {
                    Ok(body) => MeshMass::Given(body),
                    Err(error) => {
                        attributes.refuse(error.to_string());
                        return None;
                    }
                }
            }
            _ => {
                attributes.refuse("give mass, density, or mass and inertia");
                return None;
            }
        };
        let source = self.source.find(file);
        let mesh = source.as_ref().map_err(Clone::clone).and_then(super::source::Source::mesh);
        let numbers = mesh.as_ref().map_or(0, |mesh| 3 * (mesh.points.len() + mesh.faces.len()));
        if !self.charge(attributes.line, &attributes.place, Resource::Numbers, numbers) {
            return None;
        }
        match of_triangles(name, file.as_ref(), mesh, scale, mass, solid) {
            Ok(mut object) => {
                if let (Shape::Mesh { file, .. }, Ok(Source::Disk { path, .. })) = (&mut object.shape, source)
                {
                    let path = path.canonicalize().unwrap_or(path);
                    self.report.add_files([path.as_path()]);
                    *file = Some(path);
                }
                Some(object)
            }
            Err(error) => {
                attributes.refuse(error.to_string());
                None
            }
        }
    }
}

/// A table, a wall, or an object of a primitive shape.
fn solid(attributes: &mut Attributes<'_>, kind: &str) -> Option<Object> {
    if !["table", "wall", "box", "sphere", "cylinder", "capsule", "ellipsoid"].contains(&kind) {
        attributes.refuse(format!("the element <{}> is unknown; a scene has {PARTS}", excerpt(kind)));
        return None;
    }
    let name = attributes.required("name", "NAME")?;
    let positive = |attributes: &mut Attributes<'_>, numbers: &[f64]| {
        let is_positive = numbers.iter().all(|x| *x > 0.0);
        // NaN follows an error.
        if !is_positive && !numbers.iter().any(|x| x.is_nan()) {
            attributes.refuse("its lengths must be positive");
        }
        is_positive
    };
    let shape = match kind {
        "table" => {
            let size = attributes.required_numbers("size", "1 0.6 0.4");
            return positive(attributes, &size).then(|| Object::table(name, size));
        }
        "wall" => {
            let from = attributes.required_numbers("from", "0 1");
            let to = attributes.required_numbers("to", "2 1");
            let [height] = attributes.required_numbers("height", "2.5");
            let thickness = attributes.number("thickness").unwrap_or(0.1);
            let length = f64::hypot(to[0] - from[0], to[1] - from[1]);
            return positive(attributes, &[length, height, thickness])
                .then(|| Object::wall(name, [from, to], height, thickness));
        }
        "box" => Shape::Box { size: attributes.required_numbers("size", "0.1 0.1 0.1") },
        "sphere" => {
            let [radius] = attributes.required_numbers("radius", "0.05");
            Shape::Sphere { radius }
        }
        "ellipsoid" => {
            Shape::Ellipsoid { half_axes: attributes.required_numbers("half_axes", "0.1 0.1 0.2") }
        }
        _ => {
            let [radius] = attributes.required_numbers("radius", "0.05");
            let [length] = attributes.required_numbers("length", "0.2");
            if kind == "cylinder" {
                Shape::Cylinder { radius, length }
            } else {
                Shape::Capsule { radius, length }
            }
        }
    };
    let volume = shape.volume().unwrap_or_default();
    let lengths: Vec<f64> = match &shape {
        Shape::Box { size: lengths } | Shape::Ellipsoid { half_axes: lengths } => lengths.to_vec(),
        Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } => vec![*radius, *length],
        _ => vec![volume],
    };
    if !positive(attributes, &lengths) {
        return None;
    }
    match (attributes.number("mass"), attributes.number("density")) {
        (None, None) => Some(Object::fixed(name, shape)),
        (Some(mass), None) => Some(Object::of_mass(name, shape, mass)),
        (None, Some(density)) => Some(Object::of_density(name, shape, density)),
        (Some(_), Some(_)) => {
            attributes.refuse("give mass or density, not both");
            None
        }
    }
}
