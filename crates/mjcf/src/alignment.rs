//! Aligns the frames of free bodies with their inertia: `alignfree`, or `align` of a free joint.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3};
use robot_dynamics_description::{MassProperties, PrincipalInertia};

use crate::body::Body;
use crate::joint::JointType;
use crate::mass::Mass;
use crate::reader::Reader;

impl Reader<'_> {
    /// Moves the frame of each free body without children to its centre of mass and principal axes, in
    /// MuJoCo's order.
    pub(crate) fn align_free_bodies(&mut self, bodies: &mut [Body], masses: &mut [Mass]) {
        let mut has_children = vec![false; bodies.len()];
        for body in bodies.iter().skip(1) {
            has_children[body.parent] = true;
        }
        for index in 1..bodies.len() {
            let body = &mut bodies[index];
            let [joint] = &body.joints[..] else { continue };
            let wanted = joint.align.unwrap_or(self.compiler(&body.element).align_free);
            if joint.motion != JointType::Free || has_children[index] || !wanted {
                continue;
            }
            let Some(properties) = masses[index].properties else { continue };
            let frame = masses[index].frame.unwrap_or_else(|| principal_frame(&properties));
            let back = frame.inverse();
            body.parent_from_body *= frame;
            body.geoms.iter_mut().for_each(|geom| geom.body_from_geom = back * geom.body_from_geom);
            body.sites.iter_mut().for_each(|site| site.body_from_site = back * site.body_from_site);
            let turn = back.rotation.to_rotation_matrix();
            masses[index].properties = Some(properties.transformed(&turn, &back.translation.vector));
            masses[index].frame = Some(Isometry3::identity());
            let element = body.element.clone();
            self.report_read(&element, "its frame is aligned with its inertia");
        }
    }
}

/// The frame at the centre of mass along the principal axes, the largest moment first.
fn principal_frame(body: &MassProperties) -> Isometry3<f64> {
    let PrincipalInertia { body_from_principal, .. } = body.principal();
    let axes = body_from_principal.matrix();
    let axes =
        Matrix3::from_columns(&[axes.column(2).into_owned(), -axes.column(1), axes.column(0).into_owned()]);
    let turn = Rotation3::from_matrix_unchecked(axes);
    Isometry3::from_parts(Translation3::from(body.center_of_mass()), turn.into())
}
