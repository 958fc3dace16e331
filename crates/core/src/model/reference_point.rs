//! Reference points of placements, which move with the robot.
//!
//! Moments of inertia about a point at a distance d contain m d². If the reference point stays behind on a
//! long slide, this term cancels the significant digits of the bodies' own inertia. So the reference points
//! of placements move with slides.
//!
//! If all joints between a body and the root only slide, the body does not rotate. The velocity u is the same
//! at every point, ω = 0, and only the linear part of a force acts on the body. Any reference point will do.
//!
//! Each body that can rotate, and whose parent only slides (or is the world), is the root of its own tree.
//! Its root joint transmits only u and the linear force, which are the same at every point. So the root's
//! origin is the reference point of the whole tree, and nothing is shifted between points.
//!
//! Within such a tree, a body that can slide far has its own reference point: its origin. This point is at
//! the lever d from the parent's point. Quantities that pass the joint are shifted: outward u + ω × d, inward
//! n + d × f and h + m d, and the parallel-axis theorem. Robots without such a slide have no moving point
//! within a tree.
//!
//! Point 0 belongs to the sliding bodies: the origin of the first of them.

use robot_dynamics_description::Limits;

use crate::joint::{Chart, PrimitiveJoint};
use crate::model::body::{Body, WORLD};

/// The reference points of a model.
#[derive(Clone, Copy, Debug)]
pub struct ReferencePoints {
    pub count: usize,
    /// The point of the largest mass, and that of its tree's root.
    pub main: usize,
    pub main_tree: usize,
    /// Whether there is more than one point.
    pub several: bool,
    /// Whether some point moves within a tree that rotates.
    pub carried: bool,
}

/// The point of bodies that only slide.
const SLIDING: usize = 0;

/// The length of a slide within a tree above which its body gets its own point \[m\]. For a body of 0.1 m at
/// the end of a shorter slide, the moment of inertia has a relative rounding error of 1e-12.
const LONG: f64 = 10.0;

/// Whether a joint can slide its body far.
pub(crate) fn travels_far(motion: PrimitiveJoint, limits: &Limits) -> bool {
    let range = limits.upper - limits.lower;
    // A joint with a quaternion has no limits on its translations.
    motion.chart() == Chart::Placement || range * motion.reach(0).0 > LONG
}

/// Sets [`Body::point`], [`Body::tree`], [`Body::is_point`] and [`Body::shifts_reference_point`].
pub(crate) fn choose_points(bodies: &mut [Body], travels: &[bool]) -> ReferencePoints {
    let mut mass = vec![0.0];
    let mut has_sliding = false;
    for (i, &travels) in travels.iter().enumerate() {
        let (parent, motion) = (bodies[i].parent, bodies[i].motion);
        let carrier = if parent == WORLD { SLIDING } else { bodies[parent].point };
        bodies[i].shifts_reference_point = carrier != SLIDING && travels;
        let (point, is_point) = if carrier != SLIDING && !travels {
            (carrier, false)
        } else if carrier == SLIDING && !motion.turns() {
            (SLIDING, !has_sliding)
        } else {
            mass.push(0.0);
            (mass.len() - 1, true)
        };
        has_sliding |= point == SLIDING;
        mass[point] += bodies[i].mass;
        (bodies[i].point, bodies[i].is_point) = (point, is_point);
        bodies[i].tree = if carrier == SLIDING { point } else { bodies[parent].tree };
    }
    let main = (0..mass.len()).rev().max_by(|&i, &j| mass[i].total_cmp(&mass[j])).unwrap_or(SLIDING);
    let main_tree = bodies.iter().find(|body| body.point == main).map_or(SLIDING, |body| body.tree);
    ReferencePoints {
        count: mass.len(),
        main,
        main_tree,
        several: mass.len() - 1 + usize::from(has_sliding) > 1,
        carried: bodies.iter().any(|body| body.shifts_reference_point),
    }
}

/// Whether only slides lie between the root and a body.
#[inline(always)]
pub(crate) fn only_slides(body: &Body) -> bool {
    body.point == SLIDING
}
