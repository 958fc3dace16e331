//! `<inertial>`: a link's mass, centre of mass and inertia.

use dynamics::{InertiaError, MassProperties};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::UrdfError;
use crate::element::Element;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::repair::nearest_inertia;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// The link's mass properties in the link's axes; `None` for a link without mass.
    ///
    /// The file gives 𝓘 about the centre of mass c in the axes of `<origin>`, turned by R from the link's:
    /// 𝓘_link = R 𝓘 Rᵀ. **(PRM 10.46)**
    pub(crate) fn mass_properties(
        &mut self,
        link: &Element<'a>,
        name: &str,
    ) -> Result<Option<MassProperties>, UrdfError> {
        let Some(inertial) = self.child(link, "inertial")? else {
            self.defaulted(link, "no <inertial>: a link without mass");
            return Ok(None);
        };
        self.list_unread(&inertial, &[], &["origin", "mass", "inertia"], Unknown::IsPhysics)?;
        let pose = self.origin(&inertial)?;
        let mass = self.mass(&inertial)?;
        let inertia = self.inertia(&inertial)?;
        if mass == 0.0 {
            if inertia.iter().all(|&entry| entry == 0.0) {
                self.read(&inertial, "mass 0 and inertia 0: a link without mass");
            } else if self.repairs() {
                self.repaired(
                    &inertial,
                    "the mass is 0 but the inertia is not: taken as a link without mass",
                );
            } else {
                return Err(UrdfError::InertiaWithoutMass { line: inertial.line, link: excerpt(name) });
            }
            return Ok(None);
        }
        let r = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
        let about_center = self.rigid_body(&inertial, name, mass, inertia)?;
        self.read(&inertial, format!("mass {mass} kg and inertia"));
        let origin = Vector3::from(pose.translation);
        Ok(Some(about_center.transformed(&Rotation3::from_matrix_unchecked(r), &origin)))
    }

    /// The body with its centre of mass at the origin, or why there is none.
    fn rigid_body(
        &mut self,
        element: &Element<'a>,
        name: &str,
        mass: f64,
        inertia: Matrix3<f64>,
    ) -> Result<MassProperties, UrdfError> {
        let body = |inertia| MassProperties::new(mass, Vector3::zeros(), inertia);
        let reason = match body(inertia) {
            Ok(body) => return Ok(body),
            Err(reason) => reason,
        };
        let is_moments =
            matches!(reason, InertiaError::TriangleInequality { .. } | InertiaError::NegativeMoment { .. });
        if is_moments
            && self.repairs()
            && let Ok(body) = body(nearest_inertia(&inertia))
        {
            self.repaired(element, format!("{reason}; the nearest inertia of a rigid body is taken"));
            return Ok(body);
        }
        let advice = if is_moments { "; correct it, or load with repair_inertia" } else { "" };
        Err(UrdfError::Inertia { line: element.line, link: excerpt(name), reason, advice })
    }

    fn repairs(&self) -> bool {
        self.options.repair_inertia && !self.options.strict
    }

    fn mass(&mut self, inertial: &Element<'a>) -> Result<f64, UrdfError> {
        let advice = "write <mass value=\"KILOGRAMS\"/>, or remove the <inertial>";
        let element = self.required_child(inertial, "mass", advice)?;
        self.list_unread(&element, &["value"], &[], Unknown::IsPhysics)?;
        element.required_number("value")
    }

    /// The symmetric matrix; products of inertia may be left out, moments may not.
    fn inertia(&mut self, inertial: &Element<'a>) -> Result<Matrix3<f64>, UrdfError> {
        let advice = "write <inertia ixx=… ixy=… ixz=… iyy=… iyz=… izz=…/>, all zero for a point mass";
        let element = self.required_child(inertial, "inertia", advice)?;
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        self.list_unread(&element, &names, &[], Unknown::IsPhysics)?;
        let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|name| element.required_number(name));
        let mut product = |name: &str| -> Result<f64, UrdfError> {
            let value = element.number(name)?;
            if value.is_none() {
                self.defaulted(&element, format!("no {name}: taken as 0"));
            }
            Ok(value.unwrap_or(0.0))
        };
        let (xy, xz, yz) = (product("ixy")?, product("ixz")?, product("iyz")?);
        let (xx, yy, zz) = (xx?, yy?, zz?);
        Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
    }
}
