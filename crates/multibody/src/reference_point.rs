//! From where placements are measured: points that move along with the robot.
//!
//! Moments of inertia about a point at a distance d contain m d²: seen from where a long slide started, they keep
//! nothing of the bodies' own. So placements are measured from points that a slide takes along.
//!
//! Bodies that the root only slides do not turn: u is the same at every point, ω = 0, and of a force only its linear
//! part acts on them. For them any point will do. Each body that they (or the world) carry and that can turn is a
//! tree of its own: what passes through its root joint is u and the linear force, the same at every point. So its
//! root's origin is the point for the whole tree, and nothing is ever shifted from point to point.
//!
//! Point 0 is that of the sliding bodies, the origin of the first of them.

use dynamics::Scalar;

use crate::algebra::V3;
use crate::model::{Body, Motion, WORLD};
use crate::{Model, Workspace};

/// What the model knows of its reference points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReferencePoints {
    pub count: usize,
    /// The point of most of the mass.
    pub main: usize,
    /// Whether bodies are measured from different points.
    pub several: bool,
}

/// The point of bodies that only slide.
const SLIDING: usize = 0;

/// Sets [`Body::point`] and [`Body::is_point`].
pub(crate) fn choose_points(bodies: &mut [Body]) -> ReferencePoints {
    let mut mass = vec![0.0];
    let mut has_sliding = false;
    for i in 0..bodies.len() {
        let (parent, motion) = (bodies[i].parent, bodies[i].motion);
        let carrier = if parent == WORLD { SLIDING } else { bodies[parent].point };
        let (point, is_point) = if carrier != SLIDING {
            (carrier, false)
        } else if motion == Motion::Prismatic {
            (SLIDING, !has_sliding)
        } else {
            mass.push(0.0);
            (mass.len() - 1, true)
        };
        has_sliding |= point == SLIDING;
        mass[point] += bodies[i].mass;
        (bodies[i].point, bodies[i].is_point) = (point, is_point);
    }
    let main = (0..mass.len()).rev().max_by(|&i, &j| mass[i].total_cmp(&mass[j])).unwrap_or(SLIDING);
    let trees = mass.len() - 1;
    ReferencePoints { count: mass.len(), main, several: trees + usize::from(has_sliding) > 1 }
}

/// Where a body's reference point is, seen from the main one, after
/// [`place_screws`](crate::screws::place_screws).
#[inline(always)]
pub(crate) fn from_main<S: Scalar>(model: &Model, workspace: &Workspace<S>, body: usize) -> V3<S> {
    workspace.points[model.bodies[body].point] - workspace.points[model.points.main]
}

/// Whether the root only slides a body.
#[inline(always)]
pub(crate) fn only_slides(body: &Body) -> bool {
    body.point == SLIDING
}
