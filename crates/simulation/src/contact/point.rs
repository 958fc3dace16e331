//! A contact of the last step, as a result.

use nalgebra::Vector3;

use super::shape_point::{ContactPartner, ShapePoint};
use super::{ContactImpulses, ContactSet};

/// A contact point of a shape with a ground or another shape, with the force and moment there.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPoint<'a> {
    /// The link in contact.
    pub link: &'a str,
    /// Its shape; empty if the file gives no name.
    pub shape: &'a str,
    /// The other link; `None` for a ground or a height field.
    pub other_link: Option<&'a str>,
    /// The name of the other shape or the ground in the file; empty if it has none.
    pub other_shape: &'a str,
    /// The number of the ground, with height fields after the half-spaces; `None` for a link.
    pub ground: Option<usize>,
    /// The contact point in the world \[m\].
    pub point: [f64; 3],
    /// Unit vector that points into `link`, in the world.
    pub normal: [f64; 3],
    /// Distance of the two surfaces along the normal, negative where they overlap \[m\].
    pub gap: f64,
    /// The force on `link` at `point`, in world axes \[N\]; the opposite force acts on the other link.
    pub force: [f64; 3],
    /// The moment on `link` about `point`, in world axes: torsional and rolling friction \[N·m\].
    pub moment: [f64; 3],
}

impl ContactSet {
    pub(super) fn contact_point(
        &self,
        (shape, against): (usize, ContactPartner),
        (point, normal, gap): (Vector3<f64>, Vector3<f64>, f64),
        (force, moment): (Vector3<f64>, Vector3<f64>),
    ) -> ContactPoint<'_> {
        let (ground, other_link, other_shape) = match against {
            ContactPartner::Ground(ground) => (Some(ground), None, self.ground_names[ground].as_str()),
            ContactPartner::Field(field) => {
                (Some(self.grounds.len() + field), None, self.fields[field].name.as_str())
            }
            ContactPartner::Pair(pair) => {
                let other = &self.shapes[self.pairs[pair].shapes[1]];
                (None, Some(other.link.as_str()), other.name.as_str())
            }
        };
        ContactPoint {
            link: &self.shapes[shape].link,
            shape: &self.shapes[shape].name,
            other_link,
            other_shape,
            ground,
            point: point.into(),
            normal: normal.into(),
            gap,
            force: force.into(),
            moment: moment.into(),
        }
    }
}

impl ContactImpulses {
    /// The contacts at the end of the last step.
    pub(crate) fn contact_points(&self) -> impl Iterator<Item = ContactPoint<'_>> {
        self.points().map(|(point, wrench)| {
            let ShapePoint { shape, against, at, axes: [normal, ..], gap, .. } = point;
            self.set().contact_point((shape, against), (at, normal, gap), wrench)
        })
    }
}
