//! The rows of all equalities of a robot, at its last configuration.

use std::sync::Arc;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{Model, Workspace};

use super::direction::DirectionalRow;
use super::relation::Relation;
use crate::placement::{BodyMotion, Placement};

/// A row at the last configuration.
#[derive(Clone, Debug)]
pub(crate) struct EqualityRow {
    /// Its coordinates, in increasing order, with their factors.
    pub(crate) terms: Vec<(usize, f64)>,
    /// φ, if the row has one.
    pub(crate) error: Option<f64>,
    /// Rows of one relation and unit have the same number; a short row among them is rounding.
    pub(crate) group: usize,
}

clone_in_place! {
    /// All rows of a robot's equalities.
    #[derive(Debug)]
    pub(crate) struct EqualityRows {
        pub(super) placement: Placement,
        pub(super) relations: Arc<[RelationRows]>,
        rows: Vec<EqualityRow>,
        /// Derivatives of a length by all coordinates.
        derivatives: Vec<f64>,
    }
}

/// A relation, and the place of its rows.
#[derive(Debug)]
pub(super) struct RelationRows {
    pub(super) relation: Relation,
    /// The index of its first row.
    pub(super) first: usize,
    /// The body that carries both sites, or the world.
    pub(super) common: usize,
}

impl EqualityRows {
    pub(crate) fn new(model: &Model, relations: impl IntoIterator<Item = Relation>) -> Self {
        let (mut all, mut rows) = (Vec::new(), Vec::new());
        for relation in relations {
            let (first, common) = (rows.len(), relation.common_body(model));
            let terms: Vec<(usize, f64)> =
                relation.coordinates(model, common).into_iter().map(|k| (k, 0.0)).collect();
            for is_turn in relation.turns() {
                let group = 2 * all.len() + usize::from(is_turn);
                rows.push(EqualityRow { terms: terms.clone(), error: None, group });
            }
            all.push(RelationRows { relation, first, common });
        }
        let derivatives = vec![0.0; model.nv];
        Self { placement: Placement::new(model), relations: all.into(), rows, derivatives }
    }

    /// The rows at the last configuration.
    pub(crate) fn rows(&self) -> &[EqualityRow] {
        &self.rows
    }

    /// Computes all rows at q.
    pub(crate) fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        let Self { placement, relations, rows, derivatives } = self;
        if relations.iter().any(|placed| placed.relation.needs_placement()) {
            placement.set(model, workspace, q);
        }
        for RelationRows { relation, first, common } in relations.iter() {
            match relation {
                Relation::Sites(sites, directions) => {
                    let places = [&sites[0], &sites[1]].map(|site| site.place(placement));
                    for (row, direction) in rows[*first..].iter_mut().zip(directions) {
                        let directional: DirectionalRow = direction.row(&places);
                        row.begin(directional.error);
                        for (site, sign) in [(&sites[1], 1.0), (&sites[0], -1.0)] {
                            let (ends, point) = ([site.body, *common], directional.point);
                            placement.each_motion_on(model, ends, point, |dof, velocity, spin| {
                                let moved = directional.along.dot(&velocity) + directional.about.dot(&spin);
                                row.add(dof.coordinate, sign * dof.ratio * moved);
                            });
                        }
                    }
                }
                Relation::Polynomial(relation) => {
                    let row = &mut rows[*first];
                    row.begin(None);
                    let error = relation.place(model, (&*placement, q), derivatives, |k, c| row.add(k, c));
                    row.error = Some(error);
                }
                Relation::Sum { terms, positions, offset } => {
                    let sum = |positions: &Vec<(usize, f64)>| {
                        positions.iter().map(|(at, c)| c * q[*at]).sum::<f64>() - *offset
                    };
                    let row = &mut rows[*first];
                    row.begin(positions.as_ref().map(sum));
                    for &(k, c) in terms {
                        row.add(k, c);
                    }
                }
            }
        }
    }

    /// Ȧv of each row, at the configuration of the last [`place`](Self::place), which is q.
    pub(crate) fn bias(&self, model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut bias = vec![0.0; self.rows.len()];
        let mut motions: Option<Vec<BodyMotion>> = None;
        for RelationRows { relation, first, .. } in self.relations.iter() {
            match relation {
                Relation::Sites(sites, directions) => {
                    let motions = motions.get_or_insert_with(|| self.placement.motions(model, v));
                    let places = [&sites[0], &sites[1]].map(|site| site.place(&self.placement));
                    let moving = [&sites[0], &sites[1]].map(|site| site.motion(&self.placement, motions));
                    for (bias, direction) in bias[*first..].iter_mut().zip(directions) {
                        *bias = direction.acceleration(&places, &moving);
                    }
                }
                Relation::Polynomial(relation) => {
                    let motions: &[BodyMotion] = if relation.needs_placement() {
                        motions.get_or_insert_with(|| self.placement.motions(model, v))
                    } else {
                        &[]
                    };
                    bias[*first] = relation.bias(model, &self.placement, (q, v), motions);
                }
                Relation::Sum { .. } => {}
            }
        }
        bias
    }

    /// Adds Aᵀλ to the forces.
    pub(crate) fn add_forces(&self, multipliers: &[f64], forces: &mut [f64]) {
        for (row, multiplier) in
            self.rows.iter().zip(multipliers).filter(|(_, multiplier)| **multiplier != 0.0)
        {
            row.terms.iter().for_each(|&(k, factor)| forces[k] += factor * multiplier);
        }
    }
}

impl EqualityRow {
    /// Starts the row with zeros.
    fn begin(&mut self, error: Option<f64>) {
        self.error = error;
        self.terms.iter_mut().for_each(|(_, factor)| *factor = 0.0);
    }

    /// Adds to the factor of a coordinate. A coordinate that is not among the terms moves both sides alike.
    fn add(&mut self, coordinate: usize, factor: f64) {
        if let Ok(at) = self.terms.binary_search_by_key(&coordinate, |(k, _)| *k) {
            self.terms[at].1 += factor;
        }
    }
}
