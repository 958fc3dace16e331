//! Finds bodies on slides whose constraints MuJoCo weighs by their mass alone (`body_simple`).

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::body::Body;
use crate::joint::{Joint, JointType};
use crate::mass::Mass;

/// MuJoCo's tolerances for positions and axes, and for moments.
const SAME_PLACE: f64 = 1e-14;
const SAME_MOMENT: f64 = 1e-12;

/// Whether MuJoCo weighs the constraints of each body by its mass alone. The parent of such a body is the
/// world or a body that is fixed to it, and it has no children. It moves on slides along its own axes, and
/// its principal frame is its own.
pub(crate) fn bodies_weighed_by_mass(bodies: &[Body], masses: &[Mass]) -> Vec<bool> {
    let mut has_children = vec![false; bodies.len()];
    for body in bodies.iter().skip(1) {
        has_children[body.parent] = true;
    }
    let is_weighed = |(index, body): (usize, &Body)| {
        let parent = &bodies[body.parent];
        let is_near_world = body.parent == 0 || (parent.parent == 0 && parent.joints.is_empty());
        let slides = !body.joints.is_empty() && body.joints.iter().all(slides_along_an_axis);
        index > 0
            && slides
            && is_near_world
            && !has_children[index]
            && has_inertia_in_its_frame(&masses[index])
    };
    bodies.iter().enumerate().map(is_weighed).collect()
}

fn slides_along_an_axis(joint: &Joint) -> bool {
    let parts = joint.axis.iter().filter(|part| part.abs() > SAME_PLACE).count();
    joint.motion == JointType::Slide && joint.anchor == Vector3::zeros() && parts == 1
}

/// Whether the principal frame is that of the body. MuJoCo sorts the moments that it computes, the largest
/// first.
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
