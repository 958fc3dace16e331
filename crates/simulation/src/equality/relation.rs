//! An equality with its rows.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;

use super::direction::ConstrainedDirection;
use super::position::CoupledPosition;
use super::site::Site;

/// An equality with its rows.
#[derive(Clone, Debug)]
pub(crate) enum Relation {
    /// Between two sites a and b.
    Sites([Site; 2], Vec<ConstrainedDirection>),
    /// y = p(x) of two positions.
    Polynomial { position: CoupledPosition, leader: CoupledPosition, polynomial: [f64; 5] },
    /// Σ cᵢvᵢ = 0; φ = Σ cᵢqᵢ − offset of these entries of q, if they are plain numbers.
    Sum { terms: Vec<(usize, f64)>, positions: Option<Vec<(usize, f64)>>, offset: f64 },
}

/// p, p′ and ½p″ of a polynomial at x, by Horner's rule.
pub(super) fn polynomial_at(polynomial: &[f64; 5], x: f64) -> [f64; 3] {
    let [mut p, mut slope, mut half_curvature] = [0.0; 3];
    for c in polynomial.iter().rev() {
        half_curvature = half_curvature * x + slope;
        slope = slope * x + p;
        p = p * x + c;
    }
    [p, slope, half_curvature]
}

impl Relation {
    /// Whether its rows depend on the placement of the bodies.
    pub(super) fn needs_placement(&self) -> bool {
        match self {
            Self::Sites(..) => true,
            Self::Polynomial { position, leader, .. } => {
                position.needs_placement() || leader.needs_placement()
            }
            Self::Sum { .. } => false,
        }
    }

    /// The body that carries both sites, or [`WORLD`].
    pub(super) fn common_body(&self, model: &Model) -> usize {
        match self {
            Self::Sites([a, b], _) => model.common_ancestor([a.body, b.body]),
            Self::Polynomial { .. } | Self::Sum { .. } => WORLD,
        }
    }

    /// The coordinates of its rows, given the common body.
    pub(super) fn coordinates(&self, model: &Model, common: usize) -> BTreeSet<usize> {
        match self {
            Self::Sites([a, b], _) => {
                let mut all = model.coordinates_between(common, a.body);
                all.extend(model.coordinates_between(common, b.body));
                all
            }
            Self::Polynomial { position, leader, .. } => {
                let mut all = position.coordinates(model);
                all.extend(leader.coordinates(model));
                all
            }
            Self::Sum { terms, .. } => terms.iter().map(|(k, _)| *k).collect(),
        }
    }

    /// Whether each row is in rad, of rows between sites; of others, which have one row, false.
    pub(super) fn turns(&self) -> Vec<bool> {
        match self {
            Self::Sites(_, directions) => directions.iter().map(ConstrainedDirection::is_turn).collect(),
            Self::Polynomial { .. } | Self::Sum { .. } => vec![false],
        }
    }
}
