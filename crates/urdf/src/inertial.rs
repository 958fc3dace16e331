//! `<inertial>`: a link's mass, centre of mass and inertia, as the file states them.

use multibody::Pose;
use nalgebra::Matrix3;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

/// What an `<inertial>` says; NaN where an error is listed.
pub(crate) struct Inertial<'a> {
    pub(crate) element: Element<'a>,
    /// \[kg\]
    pub(crate) mass: f64,
    /// About the centre of mass, in the axes of `pose` \[kg·m²\].
    pub(crate) inertia: Matrix3<f64>,
    /// The centre of mass, and the axes of the inertia, in the link's frame.
    pub(crate) pose: Pose,
}

impl<'a> Reader<'a> {
    /// What the link's `<inertial>` says; `None` for a link without one.
    pub(crate) fn inertial(&mut self, link: &Element<'a>) -> Option<Inertial<'a>> {
        let Some(element) = self.child(link, "inertial") else {
            self.defaulted(link, "no <inertial>: a link without mass");
            return None;
        };
        self.list_unread(&element, &[], &["origin", "mass", "inertia"], Unknown::IsPhysics);
        let pose = self.origin(&element);
        let (mass, inertia) = (self.mass(&element), self.inertia(&element));
        let (mass, inertia) = match (mass, inertia) {
            (None, None) => {
                self.as_written(
                    &element,
                    "neither <mass> nor <inertia>: a link without mass; delete it, or give both",
                );
                return None;
            }
            (Some(mass), None) => {
                let message = format!(
                    "no <inertia>: taken as a point mass of {mass} kg; give its moments, all zero if it is meant so"
                );
                self.as_written(&element, message);
                (mass, Matrix3::zeros())
            }
            (None, Some(inertia)) => {
                self.as_written(&element, "no <mass>: taken as 0 kg; give the mass, or delete the <inertia>");
                (0.0, inertia)
            }
            (Some(mass), Some(inertia)) => (mass, inertia),
        };
        Some(Inertial { element, mass, inertia, pose })
    }

    fn mass(&mut self, inertial: &Element<'a>) -> Option<f64> {
        let element = self.child(inertial, "mass")?;
        self.list_unread(&element, &["value"], &[], Unknown::IsPhysics);
        let mass = self.required_number(&element, "value");
        if mass < 0.0 {
            let Element { line, place, .. } = element;
            let advice = "a mass is zero or positive; correct its sign";
            self.refuse(UrdfError::Negative { line, place, attribute: "value".into(), value: mass, advice });
            return Some(f64::NAN);
        }
        Some(mass)
    }

    /// The symmetric matrix; products of inertia may be left out, moments may not.
    fn inertia(&mut self, inertial: &Element<'a>) -> Option<Matrix3<f64>> {
        let element = self.child(inertial, "inertia")?;
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        self.list_unread(&element, &names, &[], Unknown::IsPhysics);
        let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|name| self.required_number(&element, name));
        let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|name| {
            self.number(&element, name).unwrap_or_else(|| {
                self.defaulted(&element, format!("no {name}: taken as 0"));
                0.0
            })
        });
        Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
    }
}
