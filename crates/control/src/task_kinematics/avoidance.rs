//! The law that keeps links apart.

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::{InvalidInput, check_number, check_positive};
use robot_dynamics_simulation::ContactSet;
use robot_dynamics_simulation::contact::LinkDistances;

use super::levels::Inequalities;

/// The law of distances between links: ḋ Δt ≥ −γ (d − d_min) for pairs nearer than the range.
///
/// Links that are nearer than d_min move apart by the same law, as far as half of what the bounds of the
/// joints allow.
///
/// Each pair of shapes has one row, at its nearest points. Between parallel faces these points jump, and
/// pairs that no motion can separate stay near. Such pairs may come nearer than d_min.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionAvoidance {
    /// d_min \[m\].
    pub least_distance: f64,
    /// The distance from which on pairs count \[m\].
    pub range: f64,
    /// γ, above 0 and at most 1.
    pub gain: f64,
}

impl CollisionAvoidance {
    /// The law with d_min, with the range d_min + 0.1 m and γ = 0.5.
    pub fn new(least_distance: f64) -> Self {
        Self { least_distance, range: least_distance + 0.1, gain: 0.5 }
    }

    /// Checks the numbers.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        check_number("the least distance", self.least_distance)?;
        check_positive("the range of the distances", self.range - self.least_distance, "m")?;
        let is_share = self.gain > 0.0 && self.gain <= 1.0;
        if is_share {
            Ok(())
        } else {
            Err(InvalidInput::out_of_range("the gain", self.gain, "", "above 0 and at most 1"))
        }
    }

    /// The least aᵀΔq of a pair within the bounds of Δq.
    pub(super) fn least_rate(&self, gap: f64, row: &[f64], (lower, upper): (&[f64], &[f64])) -> f64 {
        let wanted = -self.gain * (gap - self.least_distance);
        if wanted <= 0.0 {
            return wanted;
        }
        let most: f64 = row
            .iter()
            .zip(lower.iter().zip(upper))
            .filter(|(a, _)| **a != 0.0)
            .map(|(a, (lower, upper))| (a * lower).max(a * upper))
            .sum();
        wanted.min(0.5 * most)
    }
}

/// The law, and the shapes that it concerns.
#[derive(Clone, Debug)]
pub(super) struct Avoidance {
    law: CollisionAvoidance,
    distances: LinkDistances,
}

impl Avoidance {
    #[track_caller]
    pub(super) fn new(model: &Model, contacts: ContactSet, law: CollisionAvoidance) -> Self {
        Self { law, distances: LinkDistances::new(model, contacts) }
    }

    /// The number of pairs of shapes.
    pub(super) fn pair_count(&self) -> usize {
        self.distances.pair_count()
    }

    /// The names of the links of a row.
    pub(super) fn links(&self, row: usize) -> Option<[String; 2]> {
        let near = self.distances.near().get(row)?;
        Some(self.distances.links(near).map(str::to_owned))
    }

    /// Appends the rows of the near pairs at q, and returns the least distance.
    pub(super) fn write_rows(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        q: &[f64],
        bounds: (&[f64], &[f64]),
        inequalities: &mut Inequalities,
    ) -> Option<f64> {
        let Self { law, distances } = self;
        distances.place(model, workspace, q, law.range);
        let mut least: Option<f64> = None;
        for distance in distances.near() {
            let first = inequalities.rows.len();
            inequalities.rows.resize(first + model.nv(), 0.0);
            let row = &mut inequalities.rows[first..];
            distances.write_row(model, distance, row);
            inequalities.lower.push(law.least_rate(distance.gap, row, bounds));
            least = Some(least.map_or(distance.gap, |least| least.min(distance.gap)));
        }
        least
    }

    /// Whether all links are at least d_min apart at q.
    pub(super) fn is_clear(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) -> bool {
        let Self { law, distances } = self;
        distances.place(model, workspace, q, law.least_distance.max(0.0));
        distances.near().iter().all(|distance| distance.gap >= law.least_distance)
    }
}
