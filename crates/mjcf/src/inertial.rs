//! Reads `<inertial>`: the mass, centre of mass and inertia of a body, as written.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use robot_dynamics_description::MassProperties;

use crate::MjcfError;
use crate::element::Element;
use crate::reader::Reader;

/// The content of an `<inertial>`.
#[derive(Clone)]
pub(crate) struct Inertial {
    pub(crate) element: Element,
    /// \[kg\]
    pub(crate) mass: f64,
    /// About the centre of mass, in the axes of `body_from_inertial` \[kg·m²\].
    pub(crate) inertia: Matrix3<f64>,
    /// The centre of mass, and the axes of the inertia.
    pub(crate) body_from_inertial: Isometry3<f64>,
    /// Whether the inertia is a full matrix, which MuJoCo diagonalizes.
    pub(crate) is_full: bool,
}

impl Inertial {
    /// Mass properties in the axes of the body; `None` if a number is listed as an error.
    pub(crate) fn mass_properties(&self) -> Option<MassProperties> {
        let own = MassProperties::as_written(self.mass, Vector3::zeros(), self.inertia).ok()?;
        let Isometry3 { rotation, translation } = self.body_from_inertial;
        Some(own.transformed(&rotation.to_rotation_matrix(), &translation.vector))
    }
}

impl Reader<'_> {
    pub(crate) fn inertial(&mut self, element: Element) -> Inertial {
        self.required_text(&element, "pos", "X Y Z");
        let position = self.numbers::<3>(&element, "pos").unwrap_or_default();
        self.required_text(&element, "mass", "NUMBER");
        let mass = self.magnitude(&element, "mass").unwrap_or(f64::NAN);
        let diagonal = self.numbers::<3>(&element, "diaginertia");
        let full = self.numbers::<6>(&element, "fullinertia");
        let turn = self.turn(&element);
        let (line, place) = (element.line, element.place.clone());
        if full.is_some() && diagonal.is_some() {
            let (first, second) = ("diaginertia".into(), "fullinertia".into());
            self.errors.push(MjcfError::Both { line, place, first, second });
        } else if full.is_some() && turn.is_some() {
            let (first, second) = ("fullinertia".into(), "an orientation".into());
            self.errors.push(MjcfError::Both { line, place, first, second });
        }
        let inertia = match (full, diagonal) {
            (Some([xx, yy, zz, xy, xz, yz]), _) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            (None, Some(moments)) => Matrix3::from_diagonal(&Vector3::from(moments)),
            (None, None) => {
                if mass > 0.0 {
                    let message = format!(
                        "neither diaginertia nor fullinertia: taken as a point mass of {mass} kg; give the moments (zeros \
                         for a point mass)"
                    );
                    self.warn(&element, message);
                }
                Matrix3::zeros()
            }
        };
        let turn = turn.unwrap_or_else(UnitQuaternion::identity);
        let body_from_inertial = Isometry3::from_parts(Translation3::from(position), turn);
        Inertial { element, mass, inertia, body_from_inertial, is_full: full.is_some() }
    }
}
