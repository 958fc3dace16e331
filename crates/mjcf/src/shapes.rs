//! Converts geoms to the shapes of links.

use std::collections::HashSet;
use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot_dynamics_description::{
    ContactPairDescription, Disposition, Elevation, LinkShape, Pose, RobotDescription, Shape, ShapeRole,
    Surface, SurfaceVelocity,
};
use robot_dynamics_xml::Resource;

use crate::body::Body;
use crate::classes::MAIN;
use crate::element::Element;
use crate::folder::Folder;
use crate::geom::{Geom, GeomType};
use crate::orientation::pose;
use crate::reader::Reader;
use crate::renaming::asset_name;

impl Reader<'_> {
    /// Adds all geoms as shapes, including those of the world. A geom in a `<pair>` collides whatever its
    /// bits are.
    pub(crate) fn shapes(
        &mut self,
        bodies: &[Body],
        links: &[String],
        pairs: &[(Element, ContactPairDescription)],
        robot: &mut RobotDescription,
    ) {
        let paired: HashSet<&str> =
            pairs.iter().flat_map(|(_, pair)| &pair.shapes).map(String::as_str).collect();
        let mut missing = Vec::new();
        for (body, link) in bodies.iter().zip(links) {
            for geom in &body.geoms {
                if let Some((shape, place)) = self.shape(geom) {
                    if let Some((name, None)) = shape.file() {
                        missing.push((geom.element.line, name.to_owned()));
                    }
                    let surface = self.surface(&geom.element);
                    let has_bit = surface.contype != 0 || surface.conaffinity != 0;
                    let looks = !has_bit && !paired.contains(geom.name.as_str());
                    let role = if looks { ShapeRole::Visual } else { ShapeRole::Collision };
                    let mut shape = LinkShape::new(link, role, place, shape)
                        .with_name(geom.name.clone())
                        .with_surface(surface);
                    shape.color = self.color(&geom.element);
                    shape.surface_velocity = self.surface_velocity(geom, &place);
                    robot.shapes.push(shape);
                }
            }
        }
        if let Some((line, name)) =
            missing.first().filter(|_| self.meshes.folder.as_ref().is_some_and(Folder::is_on_disk))
        {
            let message = format!("{} shapes with missing files; the first is {name:?}", missing.len());
            self.push(*line, "asset".into(), Disposition::Ignored { physics: false }, message);
        }
    }

    /// Shape and pose of a geom; `None`, with a note, if it is not kept.
    fn shape(&mut self, geom: &Geom) -> Option<(Shape, Pose)> {
        let size = geom.size.map(|size| size * geom.scale.length);
        let [a, b, c] = size;
        let shape = match (geom.form, &geom.mesh) {
            (GeomType::Mesh | GeomType::SignedDistance, None) => return None,
            (_, Some(mesh)) => return self.mesh_shape(geom, mesh),
            (GeomType::Sphere, None) => Shape::Sphere { radius: a },
            (GeomType::Capsule, None) => Shape::Capsule { radius: a, length: 2.0 * b },
            (GeomType::Cylinder, None) => Shape::Cylinder { radius: a, length: 2.0 * b },
            (GeomType::Ellipsoid, None) => Shape::Ellipsoid { half_axes: size },
            (GeomType::Box, None) => Shape::Box { size: [2.0 * a, 2.0 * b, 2.0 * c] },
            (GeomType::Plane, None) => Shape::Plane { half_size: [a, b] },
            (GeomType::HeightField, None) => self.height_field(geom)?,
        };
        Some((shape, pose(&geom.body_from_geom)))
    }

    /// The shape of a mesh in the axes of its file. A primitive that is fitted to a mesh is kept as the mesh.
    fn mesh_shape(&mut self, geom: &Geom, mesh: &str) -> Option<(Shape, Pose)> {
        let Some(element) = self.mesh_named(mesh) else {
            self.refuse_unknown_name(&geom.element, "mesh", mesh);
            return None;
        };
        let scale = self.numbers::<3>(&element, "scale").unwrap_or([1.0; 3]);
        let scale = scale.map(|factor| factor * geom.scale.length);
        let shift = self.numbers::<3>(&element, "refpos").unwrap_or_default();
        let [w, x, y, z] = self.numbers::<4>(&element, "refquat").unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0).unwrap_or_default().inverse();
        // MJCF maps x to S Rᵀ (x − p), a shape to R′ S x + p′. They agree if S commutes with the rotation.
        let shifted = Vector3::from(scale).component_mul(&(turn * -Vector3::from(shift)));
        if turn != UnitQuaternion::identity() && (scale[0] != scale[1] || scale[1] != scale[2]) {
            let message = "a mesh with refquat and a scale that is not uniform: its shape is not kept";
            self.push(element.line, element.place, Disposition::Ignored { physics: false }, message.into());
            return None;
        }
        let Some((name, path)) = self.mesh_file(&element) else {
            // The points are in the MJCF file.
            self.report.counts.not_dynamics += 1;
            return None;
        };
        let file = path.filter(|path| self.is_on_disk(path));
        let place = geom.body_from_geom * Isometry3::from_parts(Translation3::from(shifted), turn);
        Some((Shape::Mesh { name, file, scale }, pose(&place)))
    }

    /// Whether there is a file at this path on the disk that may be read.
    fn is_on_disk(&self, path: &Path) -> bool {
        self.meshes.folder.as_ref().is_some_and(|folder| folder.allows(path))
    }

    fn height_field(&mut self, geom: &Geom) -> Option<Shape> {
        let wanted = self.text(&geom.element, "hfield")?;
        let Some(&id) = self.height_fields.get(wanted) else {
            self.refuse_unknown_name(&geom.element, "hfield", wanted);
            return None;
        };
        let field = self.raw_element(id);
        let size = self.numbers::<4>(&field, "size")?;
        let elevation =
            if self.text(&field, "file").is_none() { self.elevation(&field, size[2]) } else { None };
        let name = self.text(&field, "file").unwrap_or(wanted).to_owned();
        let path = self.asset_path(&field, &name, |compiler| &compiler.asset_folder);
        let file = path.filter(|path| self.is_on_disk(path));
        Some(Shape::HeightField { name, file, size, elevation })
    }

    /// The heights of `elevation`, whose first row is that of the largest y; 0 without numbers.
    fn elevation(&mut self, field: &Element, highest: f64) -> Option<Elevation> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small whole numbers; saturating
        let [rows, columns] = ["nrow", "ncol"].map(|name| self.number(field, name).unwrap_or(0.0) as usize);
        let count = rows.checked_mul(columns).filter(|count| *count > 0)?;
        if !self.charge(field.node, Resource::Numbers, count) {
            return None;
        }
        let Some((text, node)) = self.text_at(field, "elevation") else {
            return Some(Elevation::stretched(rows, columns, &vec![0.0; count], highest));
        };
        let numbers = self.all_numbers(field, "elevation")?;
        if numbers.len() != count {
            self.refuse_count("elevation", text, node, format!("nrow times ncol, {count}"), numbers.len());
            return None;
        }
        let from_least_y: Vec<f64> = numbers.chunks_exact(columns).rev().flatten().copied().collect();
        Some(Elevation::stretched(rows, columns, &from_least_y, highest))
    }

    /// The motion of the surface of a geom, in the frame of its shape.
    fn surface_velocity(&mut self, geom: &Geom, place: &Pose) -> SurfaceVelocity {
        let [a, b, c, d, e, f] = self.overlay(&geom.element, "surfacevel", [0.0; 6]);
        let in_geom = SurfaceVelocity { linear: [a, b, c], angular: [d, e, f] };
        if geom.mesh.is_none() || in_geom.is_zero() {
            return in_geom;
        }
        // The frame of a mesh's file is not that of its geom.
        in_geom.in_frame(&place.inverse().compose(&pose(&geom.body_from_geom)))
    }

    /// The contact parameters of a geom, with the defaults of MJCF.
    fn surface(&mut self, element: &Element) -> Surface {
        let mut surface = Surface::default();
        surface.friction = self.overlay(element, "friction", surface.friction);
        surface.solref = self.overlay(element, "solref", surface.solref);
        surface.solimp = self.overlay(element, "solimp", surface.solimp);
        let mut whole = |name, default: f64| self.number(element, name).unwrap_or(default);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small whole numbers; saturating
        {
            surface.condim = whole("condim", 3.0) as u8;
            surface.contype = whole("contype", 1.0) as u32;
            surface.conaffinity = whole("conaffinity", 1.0) as u32;
            surface.priority = whole("priority", 0.0) as i32;
        }
        surface.solmix = whole("solmix", 1.0);
        surface.margin = whole("margin", 0.0);
        surface.gap = whole("gap", 0.0);
        surface
    }

    /// The colour of a geom, or that of its material.
    fn color(&mut self, element: &Element) -> Option<[f64; 4]> {
        if let Some(own) = self.numbers::<4>(element, "rgba") {
            return Some(own);
        }
        let name = self.text(element, "material")?;
        let id = *self.materials.get(name)?;
        let material = self.element(id, MAIN);
        self.numbers::<4>(&material, "rgba")
    }

    /// Collects all height fields by name, which defaults to that of their file.
    pub(crate) fn read_height_fields(&mut self) {
        let tree = self.tree;
        for id in tree.in_sections("asset").filter(|&id| tree.nodes[id].name == "hfield") {
            self.height_fields.entry(asset_name(&tree.nodes[id])).or_insert(id);
        }
    }

    /// Collects all materials by name.
    pub(crate) fn read_materials(&mut self) {
        for id in self
            .tree
            .in_sections("asset")
            .filter(|&id| self.tree.nodes[id].name == "material")
            .collect::<Vec<_>>()
        {
            if let Some(name) = self.tree.nodes[id].attribute("name") {
                self.materials.entry(name.to_owned()).or_insert(id);
            }
        }
    }
}
