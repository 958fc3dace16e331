//! Writes `<asset>` and `<geom>`.

use std::collections::HashMap;
use std::path::Path;

use robot_dynamics_description::{Elevation, LinkShape, Shape, ShapeRole, Surface};
use robot_dynamics_xml::{excerpt, is_name, way_from};

use super::MjcfWriter;
use crate::names::Names;

/// The extensions of mesh files that MuJoCo reads.
const MESHES: [&str; 3] = ["stl", "obj", "msh"];

impl<'r> MjcfWriter<'r> {
    /// Writes each file once, and groups the shapes by links.
    pub(super) fn write_assets(&mut self) {
        let robot = self.robot;
        let mut names = Names::default();
        let mut known: HashMap<(&Path, String), String> = HashMap::new();
        self.has_looks = robot.shapes.iter().any(|shape| shape.role == ShapeRole::Visual);
        let mut is_open = false;
        for shape in &robot.shapes {
            let place = format!("a shape of link {:?}", excerpt(&shape.link));
            let mut asset = None;
            if let Shape::HeightField { name, size, elevation: Some(elevation), .. } = &shape.shape {
                if !is_open {
                    self.xml.start("asset");
                    is_open = true;
                }
                let name = names.unique(if is_name(name) { name } else { "hfield" });
                self.xml.start("hfield").attribute("name", &name).numbers("size", size);
                let Elevation { rows, columns, heights, .. } = elevation;
                let from_largest_y: Vec<f64> =
                    heights.chunks_exact((*columns).max(1)).rev().flatten().copied().collect();
                let counts = [*rows, *columns].map(|count| count as f64);
                self.xml.numbers("nrow", &counts[..1]).numbers("ncol", &counts[1..]);
                self.xml.numbers("elevation", &from_largest_y).end();
                asset = Some(name);
            } else if let Some((name, file)) = shape.shape.file() {
                let Some(file) = file else {
                    self.add_note(&place, format!("omitted: its file {:?} was not found", excerpt(name)));
                    continue;
                };
                let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
                let is_mesh = matches!(shape.shape, Shape::Mesh { .. });
                if is_mesh && !ending.is_some_and(|ending| MESHES.contains(&ending.as_str())) {
                    self.add_note(&place, format!("omitted: MuJoCo cannot read {:?}", excerpt(name)));
                    continue;
                }
                let numbers: &[f64] = match &shape.shape {
                    Shape::Mesh { scale, .. } => scale,
                    Shape::HeightField { size, .. } => size,
                    _ => &[],
                };
                let found = known.entry((file, format!("{numbers:?}"))).or_insert_with(|| {
                    if !is_open {
                        self.xml.start("asset");
                        is_open = true;
                    }
                    let stem = file.file_stem().map_or("mesh".into(), |stem| stem.to_string_lossy());
                    let name = names.unique(if is_name(&stem) { &stem } else { "mesh" });
                    self.xml.start(if is_mesh { "mesh" } else { "hfield" }).attribute("name", &name);
                    let way = self
                        .folder
                        .map_or_else(|| file.display().to_string(), |folder| way_from(folder, file));
                    self.xml.attribute("file", &way);
                    if !is_mesh {
                        self.xml.numbers("size", numbers);
                    } else if numbers != [1.0; 3] {
                        self.xml.numbers("scale", numbers);
                    }
                    self.xml.end();
                    name
                });
                asset = Some(found.clone());
            }
            self.shapes.entry(&shape.link).or_default().push((shape, asset));
        }
        if is_open {
            self.xml.end();
        }
    }

    pub(super) fn write_shape(&mut self, shape: &'r LinkShape, asset: Option<&str>, is_fixed_to_world: bool) {
        let (word, size): (&str, Vec<f64>) = match &shape.shape {
            Shape::Box { size } => ("box", size.map(|edge| 0.5 * edge).to_vec()),
            Shape::Cylinder { radius, length } => ("cylinder", vec![*radius, 0.5 * length]),
            Shape::Capsule { radius, length } => ("capsule", vec![*radius, 0.5 * length]),
            Shape::Sphere { radius } => ("sphere", vec![*radius]),
            Shape::Ellipsoid { half_axes } => ("ellipsoid", half_axes.to_vec()),
            Shape::Plane { half_size: [x, y] } => ("plane", vec![*x, *y, 1.0]),
            Shape::HeightField { .. } => ("hfield", Vec::new()),
            Shape::Mesh { .. } => ("mesh", Vec::new()),
        };
        let place = format!("a shape of link {:?}", excerpt(&shape.link));
        if matches!(word, "plane" | "hfield") && !is_fixed_to_world {
            self.add_note(&place, format!("omitted: in MuJoCo a {word} cannot move"));
            return;
        }
        if size.first().is_some_and(|_| word != "plane" && size.iter().any(|&edge| edge <= 0.0)) {
            self.add_note(&place, "omitted: one of its sizes is zero, which MuJoCo refuses");
            return;
        }
        self.xml.start("geom");
        // The first shape of a name keeps the name.
        if is_name(&shape.name) && self.shape_names.reserve(&shape.name) {
            self.xml.attribute("name", &shape.name);
        }
        self.xml.attribute("type", word);
        if let Some(asset) = asset {
            self.xml.attribute(word, asset);
        }
        if !size.is_empty() {
            self.xml.numbers("size", &size);
        }
        self.write_placement(&shape.link_from_shape);
        if let Some(color) = &shape.color {
            self.xml.numbers("rgba", color);
        }
        self.write_surface(shape);
        if let Some(coefficients) = self.take_ellipsoid(shape) {
            self.write_coefficients(&coefficients);
        }
        self.xml.end();
    }

    fn write_surface(&mut self, shape: &LinkShape) {
        let (own, usual) = (&shape.surface, Surface::default());
        let looks = shape.role == ShapeRole::Visual;
        let (contype, conaffinity) = if looks { (0, 0) } else { (own.contype, own.conaffinity) };
        // As in published models: visual shapes in group 2, collision shapes in group 3, which viewers hide.
        if self.has_looks {
            self.xml.attribute("group", if looks { "2" } else { "3" });
        }
        self.xml.unless("contype", contype.into(), 1.0).unless("conaffinity", conaffinity.into(), 1.0);
        self.xml.unless("condim", own.condim.into(), usual.condim.into());
        self.xml.unless("priority", own.priority.into(), 0.0).unless("solmix", own.solmix, usual.solmix);
        for (name, numbers, usual) in [
            ("friction", &own.friction[..], &usual.friction[..]),
            ("solref", &own.solref, &usual.solref),
            ("solimp", &own.solimp, &usual.solimp),
        ] {
            if numbers != usual {
                self.xml.numbers(name, numbers);
            }
        }
        self.xml.unless("margin", own.margin, 0.0).unless("gap", own.gap, 0.0);
        if !shape.surface_velocity.is_zero() {
            self.xml.numbers("surfacevel", &shape.surface_velocity.to_array());
        }
    }
}
