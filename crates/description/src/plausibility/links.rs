//! Statistics of each link: mass, centre of mass, moments, and extent.

use core::f64::consts::PI;
use std::collections::HashMap;

use crate::{JointKind, MassProperties, RobotDescription, ShapeRole};

/// The statistics of a robot's links.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RobotStatistics {
    /// Σ m \[kg\].
    pub mass: f64,
    /// The longest path of joint offsets from the root, with the shapes at its end \[m\].
    pub size: f64,
    /// The statistics of every link with mass.
    pub links: Vec<LinkStatistics>,
}

/// The statistics of one link; `None` if the file gives too little.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LinkStatistics {
    /// The link's name.
    pub link: String,
    /// m \[kg\].
    pub mass: f64,
    /// |c| in the link's frame \[m\].
    pub center_distance: f64,
    /// L: the largest distance of its joint in its parent, its children's joints and its shapes in its own
    /// frame \[m\]. 0 if all coincide and there are no shapes.
    pub extent: f64,
    /// √(I₃/m), I₃ the largest principal moment about the centre of mass \[m\].
    pub gyration: f64,
    /// Density of the solid ellipsoid with this mass and these moments \[kg/m³\]; `None` for a point, a rod
    /// or a sheet.
    pub ellipsoid_density: Option<f64>,
    /// m over the volume of the collision shapes, or else of the visual ones \[kg/m³\]. `None` without
    /// shapes, or with meshes among them.
    pub shape_density: Option<f64>,
    /// Whether a joint moves it relative to its parent; sensors and covers are fixed to theirs.
    pub is_moved: bool,
}

impl LinkStatistics {
    /// √(I₃/m)/L; `None` for a point mass and for a link without extent.
    pub fn gyration_over_extent(&self) -> Option<f64> {
        (self.gyration > 0.0 && self.extent > 0.0).then(|| self.gyration / self.extent)
    }

    /// m/L³ \[kg/m³\]; `None` for a link without extent.
    pub fn mass_over_cubed_extent(&self) -> Option<f64> {
        (self.extent > 0.0).then(|| self.mass / self.extent.powi(3))
    }
}

/// The distance that a link extends from its frame's origin \[m\].
#[derive(Clone, Copy, Default)]
struct LinkExtent {
    joints: f64,
    shapes: f64,
}

impl RobotStatistics {
    /// Computes the statistics. The description may be invalid.
    pub fn new(description: &RobotDescription) -> Self {
        let index: HashMap<&str, usize> =
            description.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
        let mut extents = vec![LinkExtent::default(); description.links.len()];
        let mut children = vec![Vec::new(); description.links.len()];
        let mut is_child = vec![false; description.links.len()];
        let mut is_moved = vec![false; description.links.len()];
        for joint in &description.joints {
            let offset = norm(joint.parent_from_joint.translation);
            if let Some(&child) = index.get(joint.child.as_str()) {
                is_moved[child] = joint.kind != JointKind::Fixed;
            }
            let ends = (index.get(joint.parent.as_str()), index.get(joint.child.as_str()));
            for &end in [ends.0, ends.1].into_iter().flatten() {
                extents[end].joints = extents[end].joints.max(offset);
            }
            if let (Some(&parent), Some(&child)) = ends {
                children[parent].push((child, offset));
                is_child[child] = true;
            }
        }
        let mut drawn: Vec<[Volume; 2]> = vec![Default::default(); description.links.len()];
        for shape in &description.shapes {
            let Some(&link) = index.get(shape.link.as_str()) else { continue };
            if let Some(radius) = shape.shape.bounding_radius() {
                let far = norm(shape.link_from_shape.translation) + radius;
                extents[link].shapes = extents[link].shapes.max(far);
            }
            drawn[link][usize::from(shape.role == ShapeRole::Visual)].add(shape.shape.volume());
        }
        let size = longest_path(&children, &is_child, &extents);
        let links: Vec<LinkStatistics> = description
            .links
            .iter()
            .zip(extents.iter().zip(&drawn).zip(&is_moved))
            .filter_map(|(link, ((extent, drawn), &is_moved))| {
                let properties = link.mass_properties.as_ref().filter(|body| body.mass() > 0.0)?;
                let volume = drawn.iter().find(|volume| volume.count > 0).and_then(Volume::known);
                Some(LinkStatistics {
                    link: link.name.clone(),
                    mass: properties.mass(),
                    center_distance: properties.center_of_mass().norm(),
                    extent: extent.joints.max(extent.shapes),
                    gyration: (properties.principal().moments[2].max(0.0) / properties.mass()).sqrt(),
                    ellipsoid_density: ellipsoid_density(properties),
                    shape_density: volume.map(|volume| properties.mass() / volume),
                    is_moved,
                })
            })
            .collect();
        let mass = links.iter().map(|link| link.mass).sum();
        Self { mass, size, links }
    }
}

/// Shapes of one role on one link.
#[derive(Clone, Copy, Default)]
struct Volume {
    count: usize,
    sum: f64,
    has_mesh: bool,
}

impl Volume {
    fn add(&mut self, volume: Option<f64>) {
        self.count += 1;
        self.sum += volume.unwrap_or_default();
        self.has_mesh |= volume.is_none();
    }

    fn known(&self) -> Option<f64> {
        (!self.has_mesh && self.sum > 0.0).then_some(self.sum)
    }
}

/// The longest path from a root along the joints' offsets, including the shapes of the last link.
fn longest_path(children: &[Vec<(usize, f64)>], is_child: &[bool], extents: &[LinkExtent]) -> f64 {
    let mut pending: Vec<(usize, f64)> =
        (0..children.len()).filter(|&link| !is_child[link]).map(|root| (root, 0.0)).collect();
    let mut seen = vec![false; children.len()];
    let mut longest = 0.0_f64;
    while let Some((link, path)) = pending.pop() {
        if core::mem::replace(&mut seen[link], true) {
            continue;
        }
        longest = longest.max(path + extents[link].shapes);
        pending.extend(children[link].iter().map(|&(child, offset)| (child, path + offset)));
    }
    longest
}

/// The density of the solid ellipsoid with this mass and these moments, of semi-axes with
/// a² = 5 (I₂ + I₃ − I₁)/(2 m). `None` for a body without volume: a point, a rod, a sheet.
fn ellipsoid_density(properties: &MassProperties) -> Option<f64> {
    let [a, b, c] = properties.principal().moments.into();
    let axes = [b + c - a, a + c - b, a + b - c].map(|x| 2.5 * x / properties.mass());
    // A body thinner than a thousandth of its length counts as a sheet or a rod.
    let longest = axes.iter().fold(0.0_f64, |most, &x| most.max(x));
    if axes.iter().any(|&x| x <= 1e-6 * longest) {
        return None;
    }
    let volume = 4.0 / 3.0 * PI * axes.iter().map(|x| x.sqrt()).product::<f64>();
    Some(properties.mass() / volume)
}

/// |x|.
fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}
