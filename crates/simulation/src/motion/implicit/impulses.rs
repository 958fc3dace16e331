//! The impulses of friction, stops and equalities in one step.

mod ball_stops;
mod component_problems;
mod equality_rows;
mod landing;

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;

use super::bounded_problem::BoundedProblem;
use super::joints::{Joints, Stop};
use super::linearization::SolvedRow;
use super::measured::Measured;
use crate::contact::{Components, Interrupt, Mark, QUIET, RETURN_TIME};
use crate::motion::simulate::Losses;

pub(super) use self::landing::land_on_stops;

/// A joint that was on its stop remains on it within this distance, because corrections of other joints move
/// it slightly \[rad or m\].
const ON: f64 = 1e-6;

/// A joint within this distance is on the stop \[rad or m\].
const ROUNDING: f64 = 1e-12;

/// Relative softening of the row of a tendon. It would depend on the rows of its joints if all of them are at
/// stops, and the solution would not be unique.
const SOFTER: f64 = 1e-10;

clone_in_place! {
    /// The multipliers of a step, and their memory. There is one for each coordinate with friction or at a
    /// stop, and one for each tendon at a stop.
    ///
    /// The friction and the stop of a coordinate share one multiplier. Friction alone bounds it by −hf ≤ λ ≤
    /// hf; at a stop there is no bound on that side.
    #[derive(Debug)]
    pub(super) struct Impulses {
        /// The rows of E, as indices into `terms`.
        rows: Vec<usize>,
        /// The coordinates of every row with their factors.
        terms: Vec<Vec<(usize, f64)>>,
        /// The number of rows of joints and tendons; the rows of equalities follow.
        own: usize,
        /// The first row of paths or ball joints, whose factors depend on q.
        turning: usize,
        /// The rows of equalities that are enforced in this step.
        held: Vec<usize>,
        problem: BoundedProblem,
        /// The problem of one component, and its rows among those of the step.
        part: BoundedProblem,
        part_rows: Vec<usize>,
        /// The multipliers of the rows in the contact problem.
        beside: Vec<f64>,
        column: Vec<f64>,
        memory: ImpulseMemory,
        /// The stops of every row that the step meets.
        met: Vec<RowStops>,
        /// For each row, whether it was on a stop at the start of the step.
        pressed: Vec<bool>,
        /// For each row, the velocity of its return to a stop.
        back: Vec<f64>,
        /// A configuration before it is moved.
        before: Vec<f64>,
    }
}

/// The stops of a row that a step meets or starts on.
#[derive(Clone, Copy, Debug, Default)]
struct RowStops {
    at_lower: bool,
    at_upper: bool,
    was_on: bool,
    /// The distance from the stops that it starts on.
    way: f64,
}

clone_in_place! {
    /// The state that one step passes to the next.
    #[derive(Debug)]
    pub struct ImpulseMemory {
        /// Each row's force in the last step without impacts \[N·m or N\].
        carried: Vec<f64>,
        /// The generalized forces of all rows.
        forces: Vec<f64>,
        /// The sign of the stop that acted on each row in the last step, or 0.
        held: Vec<f64>,
        /// Each row's stop force in the last step, with impacts \[N·m or N\].
        stopped: Vec<f64>,
    }
}

impl ImpulseMemory {
    /// Each row's force in the last step without impacts.
    pub(super) fn carried(&self) -> &[f64] {
        &self.carried
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.carried.copy_from_slice(&other.carried);
        self.forces.copy_from_slice(&other.forces);
        self.held.copy_from_slice(&other.held);
        self.stopped.copy_from_slice(&other.stopped);
    }
}

impl Impulses {
    pub(super) fn new(model: &Model, joints: &Joints) -> Self {
        let most = joints.rows.len();
        Self {
            rows: Vec::with_capacity(most),
            terms: joints.rows.clone(),
            own: most,
            turning: joints.first_turning(),
            held: Vec::new(),
            problem: BoundedProblem::new(most),
            part: BoundedProblem::new(most),
            part_rows: Vec::with_capacity(most),
            beside: Vec::with_capacity(most),
            column: vec![0.0; model.nv],
            met: Vec::with_capacity(most),
            memory: ImpulseMemory {
                carried: vec![0.0; most],
                forces: vec![0.0; model.nv],
                held: vec![0.0; most],
                stopped: vec![0.0; most],
            },
            pressed: Vec::with_capacity(most),
            back: Vec::with_capacity(most),
            before: vec![0.0; model.nq],
        }
    }

    /// Stops the solvers when this flag is set.
    pub(super) fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
        self.part.interrupt = interrupt.clone();
    }

    /// The forces of friction and stops of the last step, which act in the smooth part.
    pub(super) fn forces(&self) -> &[f64] {
        &self.memory.forces
    }

    /// Each row's stop force in the last step.
    pub(super) fn stop_forces(&self) -> &[f64] {
        &self.memory.stopped
    }

    /// The state that one step passes to the next.
    pub(super) fn memory(&mut self) -> &mut ImpulseMemory {
        &mut self.memory
    }

    /// The coordinates of each row with their factors.
    pub(super) fn terms(&self) -> &[Vec<(usize, f64)>] {
        &self.terms
    }

    /// Sets the factors of a row to these derivatives by all coordinates.
    pub(super) fn set_row(&mut self, row: usize, derivatives: &[f64]) {
        self.terms[row].iter_mut().for_each(|(k, factor)| *factor = derivatives[*k]);
    }

    /// A row's force in the last step without impacts \[N·m or N\].
    pub(super) fn carried(&self, row: usize) -> f64 {
        self.memory.carried[row]
    }

    /// Whether any of these forces is not zero.
    pub(super) fn acts(&self) -> bool {
        self.memory.carried.iter().any(|force| *force != 0.0)
    }

    /// Whether the step from q₀ to q₁ meets this stop.
    pub(super) fn meets(&self, stop: &Stop, q0: Measured<'_>, q1: Measured<'_>) -> bool {
        stop.gap(q1) < 0.0 && !is_on(stop, &self.memory.held, q0)
    }

    /// Whether this stop acted on its row in the last step, and the row is still on it at this gap.
    pub(super) fn holds(&self, stop: &Stop, gap: f64) -> bool {
        self.memory.held[stop.row] == stop.sign && gap <= ON
    }

    /// Selects the rows of a step of h from q₀ to q₁, with their bounds.
    ///
    /// A joint that was on a stop and was moved off by corrections of other joints returns as one that starts
    /// beyond a stop does.
    pub(super) fn choose(
        &mut self,
        joints: &Joints,
        stops: &[Stop],
        h: f64,
        (q0, q1): (Measured<'_>, Measured<'_>),
        components: &Components,
    ) {
        for (terms, stopped) in self.terms.iter().zip(&mut self.memory.stopped) {
            if components.is_active(components.tree_of_row(terms)) {
                *stopped = 0.0;
            }
        }
        self.met.clear();
        self.met.resize(self.memory.carried.len(), RowStops::default());
        for stop in stops {
            let (gap, met) = (stop.gap(q0), &mut self.met[stop.row]);
            let is_on = is_on_at(stop, &self.memory.held, gap);
            let is_met = is_on || stop.gap(q1) < 0.0;
            if !is_met {
                continue;
            }
            *if stop.sign > 0.0 { &mut met.at_lower } else { &mut met.at_upper } = true;
            met.was_on |= is_on;
            if is_on && gap > ROUNDING {
                met.way += stop.sign * gap;
            }
        }
        self.rows.clear();
        self.pressed.clear();
        self.back.clear();
        let problem = &mut self.problem;
        problem.begin_bounds();
        for (k, (met, &carried)) in self.met.iter().zip(&self.memory.carried).enumerate() {
            let most = joints.friction_along(k);
            if most <= 0.0 && carried == 0.0 && !met.at_lower && !met.at_upper {
                continue;
            }
            if !components.is_active(components.tree_of_row(&self.terms[k])) {
                continue;
            }
            self.rows.push(k);
            self.pressed.push(met.was_on);
            self.back.push(met.way / -RETURN_TIME);
            problem.lower.push(if met.at_upper { f64::NEG_INFINITY } else { h * (-most - carried) });
            problem.upper.push(if met.at_lower { f64::INFINITY } else { h * (most - carried) });
        }
        problem.x.resize(self.rows.len(), 0.0);
    }

    /// Adds the enforced rows of the equalities.
    pub(super) fn choose_held(&mut self) {
        let problem = &mut self.problem;
        for &k in &self.held {
            self.rows.push(k);
            self.pressed.push(false);
            self.back.push(0.0);
            problem.lower.push(f64::NEG_INFINITY);
            problem.upper.push(f64::INFINITY);
        }
        problem.x.resize(self.rows.len(), 0.0);
    }

    /// Removes rounding from the velocities of joints that stick or are on a stop: these are 0. If such a
    /// joint was at rest before the step, its displacement is 0.
    pub(super) fn rest(&self, v0: &[f64], v1: &mut [f64], displacement: &mut [f64]) {
        let problem = &self.problem;
        for (i, &row) in self.rows.iter().enumerate().filter(|(_, row)| **row < v0.len()) {
            if problem.x[i] > problem.lower[i] && problem.x[i] < problem.upper[i] {
                v1[row] = self.back[i];
                if v0[row] == 0.0 && v1[row] == 0.0 {
                    displacement[row] = 0.0;
                }
            }
        }
    }

    /// Marks the components in which a joint or a tendon hits a stop in this step from v₀. Forces of their
    /// other rows then belong to the impact, too.
    pub(super) fn mark_hits(&self, v0: &[f64], components: &mut Components) {
        for (i, &row) in self.rows.iter().enumerate() {
            // A joint on the stop of a ball joint slides along it, because the stop rotates with the joint;
            // that is not an impact.
            let is_new = |row: usize| self.memory.held[row] == 0.0;
            if self.is_on_stop(i)
                && is_new(row)
                && self.problem.x[i] != 0.0
                && along(&self.terms[row], v0).abs() > QUIET
            {
                components.set(Mark::Hit, components.tree_of_row(&self.terms[row]));
            }
        }
    }

    /// The rows of the last problem.
    pub(super) fn solved_rows(&self) -> impl Iterator<Item = SolvedRow> + '_ {
        let Self { rows, terms, problem, back, .. } = self;
        rows.iter().enumerate().map(|(i, &row)| SolvedRow {
            number: row,
            terms: terms[row].clone(),
            multiplier: problem.x[i],
            is_free: problem.x[i] > problem.lower[i] && problem.x[i] < problem.upper[i],
            returns: back[i] != 0.0,
            moves: self.moving(row).is_some(),
        })
    }

    /// Whether a row's stop can push.
    fn is_on_stop(&self, i: usize) -> bool {
        self.rows[i] < self.own
            && (self.problem.lower[i].is_infinite() || self.problem.upper[i].is_infinite())
    }

    /// Adds the step's losses to those of each component, at its first tree: −λ times the mean of the
    /// velocities before and after. The part of λ within the bounds of friction belongs to friction, the rest
    /// to the stop. A negative loss belongs to a velocity that overshot. The row of a path turns within the
    /// step. The force of the last step did the work f Δℓ along it, and `change_along` gives Δℓ. The forces
    /// are stored for the next step, except in components with an impact on a stop or elsewhere.
    pub(super) fn account(
        &mut self,
        (joints, change_along): (&Joints, impl Fn(usize) -> Option<f64>),
        h: f64,
        (v0, v1): (&[f64], &[f64]),
        components: &Components,
        losses: &mut [Losses],
    ) {
        for (terms, held) in self.terms.iter().zip(&mut self.memory.held) {
            if components.is_active(components.tree_of_row(terms)) {
                *held = 0.0;
            }
        }
        for (i, &row) in self.rows.iter().enumerate().filter(|(_, row)| **row < self.own) {
            let problem = &self.problem;
            let (whole, most) = (problem.x[i] + h * self.memory.carried[row], h * joints.friction_along(row));
            let is_on_stop = self.is_on_stop(i);
            if is_on_stop && problem.x[i] > problem.lower[i] && problem.x[i] < problem.upper[i] {
                self.memory.held[row] = if problem.upper[i].is_infinite() { 1.0 } else { -1.0 };
            }
            let friction = if is_on_stop { whole.max(-most).min(most) } else { whole };
            let tree = components.tree_of_row(&self.terms[row]);
            let (losses, is_impact) = (&mut losses[components.leader(tree)], components.has(Mark::Hit, tree));
            let mean = 0.5 * (along(&self.terms[row], v0) + along(&self.terms[row], v1));
            losses.friction -= friction * mean;
            losses.stops -= match change_along(row) {
                Some(change) => problem.x[i] * mean + self.memory.carried[row] * change,
                None => (whole - friction) * mean,
            };
            self.memory.stopped[row] = (whole - friction) / h;
            self.memory.carried[row] = if self.pressed[i] && !is_impact { whole } else { friction } / h;
        }
        self.memory.forces.fill(0.0);
        let fixed = self.terms[..self.turning].iter().zip(&self.memory.carried);
        for (terms, force) in fixed.filter(|(_, force)| **force != 0.0) {
            for (k, factor) in terms {
                self.memory.forces[*k] += factor * force;
            }
        }
    }

    /// The tree of a row.
    pub(super) fn tree_of(&self, row: usize, components: &Components) -> usize {
        components.tree_of_row(&self.terms[row])
    }

    /// Whether the tree of a row is active.
    pub(super) fn is_active(&self, row: usize, components: &Components) -> bool {
        components.is_active(self.tree_of(row, components))
    }

    /// Restores the stored state at the start of a step, for the active trees.
    pub(super) fn restore_active(&mut self, begun: &ImpulseMemory, components: &Components) {
        let ImpulseMemory { carried, forces, held, stopped } = &mut self.memory;
        for (row, terms) in self.terms[..self.own].iter().enumerate() {
            if components.is_active(components.tree_of_row(terms)) {
                carried[row] = begun.carried[row];
                held[row] = begun.held[row];
                stopped[row] = begun.stopped[row];
            }
        }
        for (k, force) in forces.iter_mut().enumerate().filter(|(k, _)| components.moves(*k)) {
            *force = begun.forces[k];
        }
    }
}

/// Whether a joint at q is on its stop.
fn is_on(stop: &Stop, held: &[f64], q: Measured<'_>) -> bool {
    is_on_at(stop, held, stop.gap(q))
}

/// Whether a joint at this distance is on its stop.
fn is_on_at(stop: &Stop, held: &[f64], gap: f64) -> bool {
    gap <= 0.0 || (held[stop.row] == stop.sign && gap <= ON)
}

/// The component of a velocity, or of another vector, along a row.
pub(super) fn along(terms: &[(usize, f64)], x: &[f64]) -> f64 {
    terms.iter().map(|(k, factor)| factor * x[*k]).sum()
}
