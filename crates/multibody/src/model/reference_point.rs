//! From where placements are measured: points that move along with the robot.
//!
//! Moments of inertia about a point at a distance d contain m d²: seen from where a long slide started, they keep
//! nothing of the bodies' own. So placements are measured from points that a slide takes along.
//!
//! Bodies that the root only slides do not turn: u is the same at every point, ω = 0, and of a force only its linear
//! part acts on them. For them any point will do. Each body that they (or the world) carry and that can turn is a
//! tree of its own: what passes through its root joint is u and the linear force, the same at every point. So its
//! root's origin is the point for the whole tree, and nothing is shifted from point to point.
//!
//! Within a tree, behind a joint that turns, a body that may slide far has a point of its own, too: its origin. It is
//! carried at the lever d from the parent's point, and what passes its joint is shifted: outward u + ω × d, inward
//! n + d × f, h + m d, the parallel-axis theorem. Robots without such a slide have no carried point.
//!
//! Point 0 is that of the sliding bodies, the origin of the first of them.

use crate::Limits;
use crate::joint::{Chart, Motion};
use crate::model::{Body, WORLD};

/// What the model knows of its reference points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReferencePoints {
    pub count: usize,
    /// The point of most of the mass, and that of its tree's root.
    pub main: usize,
    pub main_tree: usize,
    /// Whether bodies are measured from different points.
    pub several: bool,
    /// Whether some point is carried by a tree that turns.
    pub carried: bool,
}

/// The point of bodies that only slide.
const SLIDING: usize = 0;

/// A slide within a tree that gets a point of its own \[m\]. To a body of 0.1 m at the end of a shorter one, rounding
/// leaves 1e-12 of its moment of inertia.
const LONG: f64 = 10.0;

/// Whether a joint may slide its body far.
pub(crate) fn travels_far(motion: Motion, limits: &Limits) -> bool {
    let range = limits.upper - limits.lower;
    // A joint with a quaternion has no limits of its slides.
    motion.chart() == Chart::Placement || range * motion.reach(0).0 > LONG
}

/// Sets [`Body::point`], [`Body::tree`], [`Body::is_point`] and [`Body::is_carried`].
pub(crate) fn choose_points(bodies: &mut [Body], travels: &[bool]) -> ReferencePoints {
    let mut mass = vec![0.0];
    let mut has_sliding = false;
    for (i, &travels) in travels.iter().enumerate() {
        let (parent, motion) = (bodies[i].parent, bodies[i].motion);
        let carrier = if parent == WORLD { SLIDING } else { bodies[parent].point };
        bodies[i].is_carried = carrier != SLIDING && travels;
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
        carried: bodies.iter().any(|body| body.is_carried),
    }
}

/// Whether the root only slides a body.
#[inline(always)]
pub(crate) fn only_slides(body: &Body) -> bool {
    body.point == SLIDING
}
