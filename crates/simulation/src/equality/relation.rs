//! An equality with its rows.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;

use super::direction::ConstrainedDirection;
use super::polynomial::PolynomialRelation;
use super::site::Site;

/// An equality with its rows.
#[derive(Clone, Debug)]
pub(crate) enum Relation {
    /// Between two sites a and b.
    Sites([Site; 2], Vec<ConstrainedDirection>),
    /// y = p(x) of two positions.
    Polynomial(PolynomialRelation),
    /// Σ cᵢvᵢ = 0; φ = Σ cᵢqᵢ − offset of these entries of q, if they are plain numbers.
    Sum { terms: Vec<(usize, f64)>, positions: Option<Vec<(usize, f64)>>, offset: f64 },
}

impl Relation {
    /// Whether its rows depend on the placement of the bodies.
    pub(super) fn needs_placement(&self) -> bool {
        match self {
            Self::Sites(..) => true,
            Self::Polynomial(relation) => relation.needs_placement(),
            Self::Sum { .. } => false,
        }
    }

    /// The body that carries both sites, or [`WORLD`].
    pub(super) fn common_body(&self, model: &Model) -> usize {
        match self {
            Self::Sites([a, b], _) => model.common_ancestor([a.body, b.body]),
            Self::Polynomial(_) | Self::Sum { .. } => WORLD,
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
            Self::Polynomial(relation) => relation.coordinates(model),
            Self::Sum { terms, .. } => terms.iter().map(|(k, _)| *k).collect(),
        }
    }

    /// Whether each row is in rad, of rows between sites; of others, which have one row, false.
    pub(super) fn turns(&self) -> Vec<bool> {
        match self {
            Self::Sites(_, directions) => directions.iter().map(ConstrainedDirection::is_turn).collect(),
            Self::Polynomial(_) | Self::Sum { .. } => vec![false],
        }
    }
}
