//! Reads `<inertial>`: the mass, centre of mass and inertia of a link, as written.

use nalgebra::Matrix3;
use robot_dynamics_description::Pose;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The content of an `<inertial>`; NaN where an error is listed.
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
    /// Reads the link's `<inertial>`; `None` for a link without one.
    pub(crate) fn inertial(&mut self, link: &Element<'a>) -> Option<Inertial<'a>> {
        let Some(element) = self.child(link, "inertial") else {
            self.report_default(link, "no <inertial>: the link has no mass");
            return None;
        };
        self.list_unread(&element, &[], &["origin", "mass", "inertia"], UnknownPart::Physics);
        let pose = self.origin(&element);
        let (mass, inertia) = (self.mass(&element), self.inertia(&element));
        let (mass, inertia) = match (mass, inertia) {
            (None, None) => {
                self.warn(
                    &element,
                    "neither <mass> nor <inertia>: the link has no mass; delete it, or give both",
                );
                return None;
            }
            (Some(mass), None) => {
                let message = format!(
                    "no <inertia>: taken as a point mass of {mass} kg; give the moments (zeros for a point mass)"
                );
                self.warn(&element, message);
                (mass, Matrix3::zeros())
            }
            (None, Some(inertia)) => {
                self.warn(&element, "no <mass>: taken as 0 kg; give the mass, or delete the <inertia>");
                (0.0, inertia)
            }
            (Some(mass), Some(inertia)) => (mass, inertia),
        };
        Some(Inertial { element, mass, inertia, pose })
    }

    fn mass(&mut self, inertial: &Element<'a>) -> Option<f64> {
        let element = self.child(inertial, "mass")?;
        self.list_unread(&element, &["value"], &[], UnknownPart::Physics);
        let mass = self.required_number(&element, "value");
        if mass < 0.0 {
            let Element { line, place, .. } = element;
            let advice = "correct its sign";
            self.refuse(UrdfError::Negative { line, place, attribute: "value".into(), value: mass, advice });
            return Some(f64::NAN);
        }
        Some(mass)
    }

    /// The inertia matrix. Products of inertia default to 0; moments are required.
    fn inertia(&mut self, inertial: &Element<'a>) -> Option<Matrix3<f64>> {
        let element = self.child(inertial, "inertia")?;
        let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        self.list_unread(&element, &names, &[], UnknownPart::Physics);
        let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|name| self.required_number(&element, name));
        let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|name| {
            self.number(&element, name).unwrap_or_else(|| {
                self.report_default(&element, format!("no {name}: taken as 0"));
                0.0
            })
        });
        Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
    }
}
