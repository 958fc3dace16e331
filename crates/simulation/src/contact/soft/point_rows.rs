//! Rows of points on bodies.

use nalgebra::Vector3;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{FrameId, Model};

use crate::contact::ConeProblem;
use crate::contact::cone_problem::Set;
use crate::placement::Placement;

/// The placement of all bodies, and the coordinates that move each, in increasing order.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    pub(super) placement: Placement,
    paths: Vec<Vec<usize>>,
}

impl Bodies {
    pub(super) fn new(model: &Model) -> Self {
        let path = |body| model.coordinates_between(WORLD, body).into_iter().collect();
        Self { placement: Placement::new(model), paths: (0..model.bodies.len()).map(path).collect() }
    }
}

/// A point of a body on which a constraint acts, and its sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    body: Option<usize>,
    sign: f64,
    point: Vector3<f64>,
}

impl Side {
    #[track_caller]
    pub(super) fn new(model: &Model, frame: FrameId, sign: f64, point: Vector3<f64>) -> Self {
        Self { body: model.frame_of(frame).body, sign, point }
    }
}

/// Adds rows with the velocities and angular velocities of the sides along these directions. Returns the
/// first row's index.
pub(super) fn push(
    problem: &mut ConeProblem,
    model: &Model,
    bodies: &Bodies,
    set: Set,
    sides: [Option<Side>; 2],
    directions: &[(Vector3<f64>, Vector3<f64>)],
) -> usize {
    // The coordinates of both sides, in increasing order, each once.
    let path =
        |side: Option<Side>| side.and_then(|side| side.body).map_or(&[][..], |body| &bodies.paths[body]);
    let [mut one, mut two] = sides.map(path);
    let support = core::iter::from_fn(|| {
        let next = match (one.first(), two.first()) {
            (Some(a), Some(b)) => a.min(b),
            (a, b) => a.or(b)?,
        };
        one = if one.first() == Some(next) { &one[1..] } else { one };
        two = if two.first() == Some(next) { &two[1..] } else { two };
        Some(*next)
    });
    let row = problem.push(set, directions.len(), support);
    let (support, entries) = problem.last();
    let count = support.len();
    for side in sides.into_iter().flatten() {
        let Some(body) = side.body else { continue };
        bodies.placement.each_motion(model, body, side.point, |dof, velocity, spin| {
            let Ok(column) = support.binary_search(&dof.coordinate) else { return };
            let factor = side.sign * dof.ratio;
            for (r, (along, about)) in directions.iter().enumerate() {
                entries[r * count + column] += factor * (along.dot(&velocity) + about.dot(&spin));
            }
        });
    }
    row
}
