//! Bodies on slides that MuJoCo's law weighs by their mass alone (`body_simple`).

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::body::Body;
use crate::joint::{Joint, Motion};
use crate::mass::Mass;

/// MuJoCo's rounding of places and axes, and of moments.
const SAME_PLACE: f64 = 1e-14;
const SAME_MOMENT: f64 = 1e-12;

/// Whether the law weighs each body by its mass alone. Such a body hangs in the world or on a body that is fixed there, and carries no other body.
/// It moves on slides along its own axes, and has its inertia in its own frame.
pub(crate) fn weighed_by_mass(bodies: &[Body], masses: &[Mass]) -> Vec<bool> {
    let mut carries = vec![false; bodies.len()];
    for body in bodies.iter().skip(1) {
        carries[body.parent] = true;
    }
    let is_weighed = |(index, body): (usize, &Body)| {
        let parent = &bodies[body.parent];
        let is_near_world = body.parent == 0 || (parent.parent == 0 && parent.joints.is_empty());
        let slides = !body.joints.is_empty() && body.joints.iter().all(slides_along_an_axis);
        index > 0 && slides && is_near_world && !carries[index] && has_inertia_in_its_frame(&masses[index])
    };
    bodies.iter().enumerate().map(is_weighed).collect()
}

fn slides_along_an_axis(joint: &Joint) -> bool {
    let parts = joint.axis.iter().filter(|part| part.abs() > SAME_PLACE).count();
    joint.motion == Motion::Slide && joint.anchor == Vector3::zeros() && parts == 1
}

/// MuJoCo sorts moments that it computes, the largest first, and turns the inertia's frame so.
fn has_inertia_in_its_frame(mass: &Mass) -> bool {
    let Some(properties) = mass.properties else { return false };
    if let Some(Isometry3 { rotation, translation }) = mass.frame {
        return rotation.angle() < SAME_PLACE && translation.vector.amax() < SAME_PLACE;
    }
    let inertia = properties.inertia_about_center_of_mass();
    let moments = inertia.diagonal();
    let across = (inertia - Matrix3::from_diagonal(&moments)).amax();
    let falls = moments[0] + SAME_MOMENT >= moments[1] && moments[1] + SAME_MOMENT >= moments[2];
    properties.center_of_mass().amax() < SAME_PLACE && across < SAME_MOMENT && falls
}
