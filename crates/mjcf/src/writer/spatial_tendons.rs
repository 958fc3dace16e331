//! Writes spatial tendons, with the geoms that they go around.

use std::collections::HashSet;

use robot_dynamics_description::{
    LinkShape, Pose, Shape, SpatialTendonDescription, TendonPathElement, TendonSurface,
};
use robot_dynamics_xml::{excerpt, is_name};

use super::{MjcfWriter, TendonGeom};
use crate::names::Names;

impl<'r> MjcfWriter<'r> {
    /// Plans the sites and geoms of the paths. A surface that is also a shape with a name uses that shape's
    /// geom.
    pub(super) fn plan_tendons(&mut self) {
        let robot = self.robot;
        let mut names = Names::default();
        for shape in &robot.shapes {
            names.reserve(&shape.name);
        }
        for tendon in &robot.spatial_tendons {
            let mut geoms = Vec::new();
            for element in &tendon.path {
                let (point, surface) = match element {
                    TendonPathElement::Point { frame } => (Some(frame), None),
                    TendonPathElement::Surface { side, .. } => (side.as_ref(), Some(element)),
                    TendonPathElement::Pulley { .. } => (None, None),
                };
                if let Some(point) = point
                    && self.link_index.contains_key(point.as_str())
                {
                    self.plan_link_site(point);
                }
                if let Some(TendonPathElement::Surface { link, link_from_surface, surface, radius, .. }) =
                    surface
                {
                    let shared = self.shape_of_surface(link, link_from_surface, *surface, *radius);
                    geoms.push(shared.unwrap_or_else(|| {
                        let name = names.unique(&format!("{}_surface", tendon.name));
                        self.tendon_geoms.entry(link).or_default().push(TendonGeom {
                            name: name.clone(),
                            surface: *surface,
                            radius: *radius,
                            link_from_surface: *link_from_surface,
                        });
                        name
                    }));
                }
            }
            self.tendon_geom_names.push(geoms);
        }
    }

    /// The name of the shape that is this surface. Only the first shape of a name keeps it.
    fn shape_of_surface(
        &self,
        link: &str,
        pose: &Pose,
        surface: TendonSurface,
        radius: f64,
    ) -> Option<String> {
        let is_surface = |shape: &LinkShape| match &shape.shape {
            Shape::Sphere { radius: own } => surface == TendonSurface::Sphere && *own == radius,
            Shape::Cylinder { radius: own, .. } => surface == TendonSurface::Cylinder && *own == radius,
            _ => false,
        };
        let mut seen = HashSet::new();
        let mut first = self.robot.shapes.iter().filter(|shape| seen.insert(shape.name.as_str()));
        let found = first.find(|shape| {
            is_name(&shape.name) && shape.link == link && shape.link_from_shape == *pose && is_surface(shape)
        });
        found.map(|shape| shape.name.clone())
    }

    /// Writes the geoms of a link that exist only for tendons. They neither touch anything nor have mass.
    pub(super) fn write_tendon_geoms(&mut self, link: &str) {
        for geom in self.tendon_geoms.remove(link).unwrap_or_default() {
            self.xml.start("geom").attribute("name", &geom.name);
            match geom.surface {
                TendonSurface::Sphere => self.xml.attribute("type", "sphere").numbers("size", &[geom.radius]),
                TendonSurface::Cylinder => {
                    self.xml.attribute("type", "cylinder").numbers("size", &[geom.radius, geom.radius])
                }
            };
            self.write_placement(&geom.link_from_surface);
            self.xml.numbers("contype", &[0.0]).numbers("conaffinity", &[0.0]).numbers("mass", &[0.0]);
            self.xml.end();
        }
    }

    pub(super) fn write_spatial_tendon(&mut self, tendon: &'r SpatialTendonDescription, geoms: Vec<String>) {
        let place = format!("tendon {:?}", excerpt(&tendon.name));
        self.xml.start("spatial").attribute("name", &tendon.name);
        self.write_tendon_forces(&tendon.passive, &tendon.higher_terms, tendon.dead_band);
        self.xml.unless("springyield", tendon.spring_yield, 0.0);
        self.write_range(&place, "range", [tendon.limits.lower, tendon.limits.upper]);
        self.write_tendon_softness(&tendon.softness);
        self.write_range(&place, "actuatorfrcrange", tendon.actuator_force_range);
        let mut geoms = geoms.into_iter();
        for element in &tendon.path {
            match element {
                TendonPathElement::Point { frame } => {
                    let site = self.site_at(frame);
                    self.xml.start("site").attribute("site", &site);
                }
                TendonPathElement::Surface { side, .. } => {
                    self.xml.start("geom").attribute("geom", &geoms.next().unwrap_or_default());
                    if let Some(side) = side {
                        let site = self.site_at(side);
                        self.xml.attribute("sidesite", &site);
                    }
                }
                TendonPathElement::Pulley { divisor } => {
                    self.xml.start("pulley").numbers("divisor", &[*divisor]);
                }
            }
            self.xml.end();
        }
        self.xml.end();
    }

    /// The site at a link or frame.
    fn site_at(&self, frame: &str) -> String {
        self.link_sites.get(frame).map_or(frame, String::as_str).to_owned()
    }
}
