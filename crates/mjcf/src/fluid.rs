//! Reads the fluid, and the shapes on which it acts: `density`, `viscosity` and `wind` of `<option>`,
//! `fluidshape` and `fluidcoef` of geoms.

use robot_dynamics_description::{
    Disposition, FluidEllipsoid, FluidForm, FluidShape, Medium, RobotDescription,
};

use crate::body::Body;
use crate::element::Element;
use crate::geom::{Geom, GeomType};
use crate::mass::Mass;
use crate::option::DisabledForces;
use crate::orientation::pose;
use crate::principal_axes::principal_axes;
use crate::reader::Reader;

/// MuJoCo applies no fluid to a lighter body \[kg\].
const LEAST_MASS: f64 = 1e-15;

impl Reader<'_> {
    /// Adds the fluid shapes of all bodies with mass: the ellipsoids of their geoms, or else the inertia box
    /// of the body. Ellipsoids are kept even without a fluid.
    pub(crate) fn fluid(
        &mut self,
        bodies: &[Body],
        masses: &[Mass],
        links: &[String],
        disabled: DisabledForces,
        robot: &mut RobotDescription,
    ) {
        if disabled.springs && disabled.dampers && robot.medium.acts() {
            robot.medium = Medium::default();
            let message = "no forces of the fluid: the flags spring and damper are both disabled";
            self.push(1, "option".into(), Disposition::Read, message.into());
        }
        for ((body, mass), link) in bodies.iter().zip(masses).zip(links) {
            let Some(properties) = mass.properties.filter(|own| own.mass() >= LEAST_MASS) else { continue };
            if body.geoms.iter().any(|geom| geom.fluid.is_some()) {
                for geom in &body.geoms {
                    robot.fluid_shapes.extend(self.fluid_ellipsoid(geom, link));
                }
            } else if robot.medium.acts() {
                let axes = match mass.frame {
                    Some(frame) => frame.rotation.to_rotation_matrix(),
                    None => principal_axes(&properties.inertia_about_center_of_mass()),
                };
                robot.fluid_shapes.extend(FluidShape::inertia_box_along(link, &properties, &axes));
            }
        }
    }

    /// The ellipsoid of a geom, if it has one.
    fn fluid_ellipsoid(&mut self, geom: &Geom, link: &str) -> Option<FluidShape> {
        let coefficients = geom.fluid?;
        let [a, b, c] = geom.size;
        let (size, place) = match (geom.form, &geom.mesh) {
            (GeomType::Plane | GeomType::HeightField | GeomType::SignedDistance, _) => {
                let message = "fluidshape=\"ellipsoid\" of a plane, height field or signed distance field";
                self.report_ignored_physics(&geom.element, format!("{message} is not in the model"));
                return None;
            }
            (GeomType::Mesh, mesh) => {
                let extent = self.usable_mesh(geom, mesh.as_deref()?)?;
                (extent.half_size, geom.body_from_geom * geom.scale.place(extent.mesh_from_box))
            }
            (_, Some(mesh)) => self.fit_primitive(geom, mesh)?,
            (_, None) => ([a, b, c], geom.body_from_geom),
        };
        let [a, b, c] = size.map(|size| size * geom.scale.length);
        let half_axes = match geom.form {
            GeomType::Sphere => [a; 3],
            GeomType::Capsule => [a, a, a + b],
            GeomType::Cylinder => [a, a, b],
            _ => [a, b, c],
        };
        let form = FluidForm::Ellipsoid(FluidEllipsoid::new(half_axes).with_coefficients(coefficients));
        Some(FluidShape { link: link.to_owned(), link_from_shape: pose(&place), form })
    }

    /// The coefficients of a geom's ellipsoid, if it has one: `fluidcoef`.
    pub(crate) fn fluid_coefficients(&mut self, element: &Element) -> Option<[f64; 5]> {
        let coefficients = self.overlay(element, "fluidcoef", [0.5, 0.25, 1.5, 1.0, 1.0]);
        let is_ellipsoid = self.word(element, "fluidshape", &["none", "ellipsoid"]) == Some("ellipsoid");
        is_ellipsoid.then_some(coefficients)
    }
}
