//! Reads collision shapes and visual shapes, with their materials.

use std::collections::HashMap;

use robot_dynamics_description::{LinkShape, Pose, ShapeRole, Surface};

use crate::findings::Findings;
use crate::geometry::Geometry;
use crate::mass::MassShape;
use crate::prim::Prim;
use crate::shape::{PlacedShape, SHAPES, read_shape};
use crate::value::count;

/// The bit of shapes that do not collide with other links of their robot.
const OWN_BIT: u32 = 2;

/// A shape of a node.
#[derive(Clone, Debug)]
pub(crate) struct UsdShape {
    pub(crate) prim: usize,
    pub(crate) node: usize,
    pub(crate) role: ShapeRole,
    pub(crate) placed: PlacedShape,
    pub(crate) surface: Surface,
    pub(crate) material_density: Option<f64>,
}

/// Reads all shapes in the order of the file.
pub(crate) fn read_shapes(geometry: &Geometry<'_>, findings: &mut Findings) -> Vec<UsdShape> {
    let mut shapes = Vec::new();
    let mut materials = HashMap::new();
    let self_collides = self_collides(geometry);
    for (at, prim) in geometry.scene.prims.iter().enumerate() {
        if is_in_material(geometry, at) || prim.has("NewtonSiteAPI") || prim.has("MjcSiteAPI") {
            continue;
        }
        let is_collider = prim.has("PhysicsCollisionAPI");
        let is_enabled = prim.flag("physics:collisionEnabled") != Some(false);
        if is_collider && !SHAPES.contains(&prim.type_name.as_str()) {
            let message = format!("a collision shape of type {:?} is not in the model", prim.type_name);
            findings.leave_out(&prim.path, message);
            continue;
        }
        let placed = match read_shape(geometry, at) {
            Ok(Some(placed)) => placed,
            Ok(None) => continue,
            Err(message) if is_collider => {
                findings.leave_out(&prim.path, format!("the collision shape is not in the model: {message}"));
                continue;
            }
            Err(message) => {
                findings.ignore(&prim.path, format!("invalid shape: {message}"));
                continue;
            }
        };
        let role = if is_collider { ShapeRole::Collision } else { ShapeRole::Visual };
        let material = if is_collider { material(geometry, at) } else { None };
        let mut surface = Surface::default();
        let mut material_density = None;
        if let Some(material) = material {
            let read =
                *materials.entry(material).or_insert_with(|| read_material(geometry, material, findings));
            (surface, material_density) = read;
        }
        if is_collider {
            read_contact(geometry, prim, &mut surface, findings);
            if !self_collides {
                (surface.contype, surface.conaffinity) = (OWN_BIT, !OWN_BIT);
            }
            if !is_enabled {
                (surface.contype, surface.conaffinity) = (0, 0);
            }
        }
        let node = geometry.node_of[at];
        shapes.push(UsdShape { prim: at, node, role, placed, surface, material_density });
    }
    shapes
}

impl UsdShape {
    pub(crate) fn to_link_shape(&self, link: &str, name: String) -> LinkShape {
        let pose: Pose = self.placed.pose;
        LinkShape::new(link, self.role, pose, self.placed.shape.clone())
            .with_name(name)
            .with_surface(self.surface)
    }

    pub(crate) fn for_mass(&self) -> Option<MassShape<'_>> {
        let is_solid = self.role == ShapeRole::Collision;
        is_solid.then_some(MassShape {
            prim: self.prim,
            shape: &self.placed,
            material_density: self.material_density,
        })
    }
}

/// Shaders of materials are no shapes.
fn is_in_material(geometry: &Geometry<'_>, at: usize) -> bool {
    geometry.scene.upward(at).any(|prim| geometry.scene.prims[prim].type_name == "Material")
}

/// Whether the shapes of one robot collide with each other.
fn self_collides(geometry: &Geometry<'_>) -> bool {
    let is_off = |prim: &Prim| {
        ["newton:selfCollisionEnabled", "physxArticulation:enabledSelfCollisions"]
            .iter()
            .any(|name| prim.flag(name) == Some(false))
    };
    !geometry.scene.prims.iter().filter(|prim| prim.has("PhysicsArticulationRootAPI")).any(is_off)
}

/// The material of a shape: its own, or that of the nearest prim above.
fn material(geometry: &Geometry<'_>, at: usize) -> Option<usize> {
    geometry.scene.upward(at).find_map(|prim| {
        let prim = &geometry.scene.prims[prim];
        ["material:binding:physics", "material:binding"].iter().find_map(|name| {
            let target = geometry.scene.find(prim.targets(name).first()?)?;
            let is_physical =
                geometry.scene.prims[target].schemas.iter().any(|schema| schema.contains("MaterialAPI"));
            is_physical.then_some(target)
        })
    })
}

/// Friction and density of a material. The one coefficient of our contacts is the dynamic one.
fn read_material(geometry: &Geometry<'_>, at: usize, findings: &mut Findings) -> (Surface, Option<f64>) {
    let prim = &geometry.scene.prims[at];
    let mut surface = Surface::default();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite() && *value >= 0.0);
    let own = finite(prim.number("physics:staticFriction"));
    let dynamic = finite(prim.number("physics:dynamicFriction"));
    if let Some(friction) = dynamic.or(own) {
        surface.friction[0] = friction;
    }
    if let (Some(own), Some(dynamic)) = (own, dynamic)
        && own != dynamic
    {
        let message = format!("staticFriction {own} differs from dynamicFriction {dynamic}, which is used");
        findings.leave_out(&prim.path, message);
    }
    if let Some(friction) = finite(prim.first_number(&["newton:torsionalFriction", "mjc:torsionalfriction"]))
    {
        surface.friction[1] = friction * geometry.meters;
    }
    if let Some(friction) = finite(prim.first_number(&["newton:rollingFriction", "mjc:rollingfriction"])) {
        surface.friction[2] = friction * geometry.meters;
    }
    if prim.number("physics:restitution").is_some_and(|restitution| restitution != 0.0) {
        findings.leave_out(&prim.path, "restitution is not in the model");
    }
    // Stiffness and damping of the contact: MuJoCo's parameters have precedence.
    for name in ["newton:contactStiffness", "newton:contactDamping"] {
        prim.number(name);
    }
    let density = prim.number("physics:density").filter(|density| *density > 0.0 && *density < 1e30);
    (surface, density)
}

/// MuJoCo's and Newton's parameters of contacts.
fn read_contact(geometry: &Geometry<'_>, prim: &Prim, surface: &mut Surface, findings: &mut Findings) {
    if let Some(condim) = prim.number("mjc:condim") {
        match [1, 3, 4, 6].into_iter().find(|&known| f64::from(known) == condim) {
            Some(known) => surface.condim = known,
            None => {
                findings.refuse(&prim.path, format!("mjc:condim = {condim} is unknown; use 1, 3, 4 or 6"));
            }
        }
    }
    if let Some(priority) = prim.number("mjc:priority") {
        let sign = if priority < 0.0 { -1 } else { 1 };
        let size = count(priority.abs()).and_then(|size| i32::try_from(size).ok());
        surface.priority = size.map_or(0, |size| sign * size);
    }
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    if let Some(solmix) = finite(prim.number("mjc:solmix")) {
        surface.solmix = solmix;
    }
    if let Some(margin) = finite(prim.first_number(&["newton:contactMargin", "mjc:margin"])) {
        surface.margin = margin * geometry.meters;
    }
    if let Some(gap) = finite(prim.first_number(&["newton:contactGap", "mjc:gap"])) {
        surface.gap = gap * geometry.meters;
    }
    let are_finite = |numbers: &&[f64]| numbers.iter().all(|number| number.is_finite());
    if let Some(&[time, ratio]) = prim.numbers("mjc:solref").filter(are_finite) {
        surface.solref = [time, ratio];
    }
    if let Some(&[a, b, c, d, e]) = prim.numbers("mjc:solimp").filter(are_finite) {
        surface.solimp = [a, b, c, d, e];
    }
    // How an engine represents the shape.
    prim.value("physics:approximation");
}
