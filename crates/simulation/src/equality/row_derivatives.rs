//! The derivatives of all rows by q and v: of A a + Ȧv, of A v, and of the forces Aᵀλ.
//!
//! Cost: O(depth) for each row, and O(depth²) for the forces of each relation. Columns of ∂/∂q are rates
//! along q ⊕ δ eⱼ, as those of inverse dynamics.

use robot_dynamics_core::Model;

use super::relation::Relation;
use super::rows::{EqualityRows, RelationRows};
use super::site_derivatives::MovingSites;
pub(crate) use super::site_derivatives::RowWeights;
use crate::placement::BodyMotion;

/// The rows at a state and an acceleration.
pub(crate) struct MovingRows<'a> {
    model: &'a Model,
    rows: &'a EqualityRows,
    state: [&'a [f64]; 3],
    /// The motion of each body; empty if no relation needs it.
    motions: Vec<BodyMotion>,
}

impl EqualityRows {
    /// The rows at the configuration of the last [`place`](Self::place), which is q, in a motion.
    pub(crate) fn moving<'a>(
        &'a self,
        model: &'a Model,
        q: &'a [f64],
        v: &'a [f64],
        a: &'a [f64],
    ) -> MovingRows<'a> {
        let needs_motions = self.relations.iter().any(|placed| placed.relation.needs_placement());
        let motions =
            if needs_motions { self.placement.accelerated_motions(model, v, Some(a)) } else { Vec::new() };
        MovingRows { model, rows: self, state: [q, v, a], motions }
    }
}

impl MovingRows<'_> {
    /// Calls `visit` with rows, coordinates and the derivatives by q and v of w₁ (A a + Ȧv) + w₂ A v. An
    /// entry may come in several parts.
    pub(crate) fn each_entry(&self, weights: RowWeights, mut visit: impl FnMut(usize, usize, [f64; 2])) {
        let [q, v, a] = self.state;
        let placement = &self.rows.placement;
        for RelationRows { relation, first, common } in self.rows.relations.iter() {
            match relation {
                Relation::Sites(sites, directions) => {
                    let sites = MovingSites::new(self.model, sites, *common, (placement, &self.motions));
                    for (k, direction) in directions.iter().enumerate() {
                        sites.each_entry(direction, weights, |at, entry| visit(first + k, at, entry));
                    }
                }
                Relation::Polynomial(relation) => {
                    let motion = (placement, self.motions.as_slice());
                    relation.each_derivative(self.model, motion, [q, v, a], weights, |at, entry| {
                        visit(*first, at, entry);
                    });
                }
                Relation::Sum { terms, .. } => {
                    for &(at, factor) in terms {
                        visit(*first, at, [0.0, weights.rate * factor]);
                    }
                }
            }
        }
    }

    /// Adds wᵀ∂(A v)/∂q. With the velocity u in place of v, this is wᵀ∂(A u)/∂q = uᵀ∂(Aᵀw)/∂q.
    pub(crate) fn add_rate_gradient(&self, weights: &[f64], by_position: &mut [f64]) {
        self.each_entry(RowWeights { acceleration: 0.0, rate: 1.0 }, |row, at, [entry, _]| {
            by_position[at] += weights[row] * entry;
        });
    }

    /// Calls `add` with the entries (i, j) of ∂(Aᵀλ)/∂q. An entry may come in several parts.
    pub(crate) fn force_derivative(&self, multipliers: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        let placement = &self.rows.placement;
        for RelationRows { relation, first, common } in self.rows.relations.iter() {
            let multipliers = &multipliers[*first..];
            match relation {
                Relation::Sites(sites, directions) => {
                    let sites = MovingSites::new(self.model, sites, *common, (placement, &self.motions));
                    sites.force_derivative(directions, multipliers, &mut add);
                }
                Relation::Polynomial(relation) => {
                    relation.force_derivative(
                        self.model,
                        (placement, self.motions.as_slice()),
                        self.state[0],
                        |i, j, entry| add(i, j, multipliers[0] * entry),
                    );
                }
                Relation::Sum { .. } => {}
            }
        }
    }
}
