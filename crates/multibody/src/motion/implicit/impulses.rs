//! The impulses of friction, stops and equalities in one step.

mod apart;
mod held;
mod landing;
mod turning;

pub(super) use self::landing::land_on_stops;
use super::bounded::BoundedProblem;
use super::joints::{Joints, Stop};
use crate::Model;
use crate::clone_in_place::clone_in_place;
use crate::contact::{Components, Interrupt, Mark, QUIET, RETURN_TIME};
use crate::motion::simulate::Losses;

/// What a stop held still lies on it when it is no further away than this, as moving others moves it a little \[rad or m\].
const ON: f64 = 1e-6;

/// Nearer than this is on a stop \[rad or m\].
const ROUNDING: f64 = 1e-12;

/// How much softer the row of a tendon is taken than it is: beside the stops of all its joints it says nothing new, and the problem would have no one
/// answer.
const SOFTER: f64 = 1e-10;

clone_in_place! {
    /// Multipliers of a step, one for each coordinate with friction or on a stop and each tendon on one, and their memory.
    ///
    /// A coordinate's friction and stop are one multiplier: −hf ≤ λ ≤ hf for friction alone, and no bound on the side of the stop.
    #[derive(Debug)]
    pub(super) struct Impulses {
        /// E's rows, among those of `terms`.
        rows: Vec<usize>,
        /// Of every row its coordinates with their factors.
        terms: Vec<Vec<(usize, f64)>>,
        /// How many rows are those of joints and tendons: those of equalities follow.
        own: usize,
        /// From this row on those of joints turn with them.
        turning: usize,
        /// The equalities' rows that hold in this step.
        held: Vec<usize>,
        problem: BoundedProblem,
        /// That of one component, and its rows among those of the step.
        part: BoundedProblem,
        part_rows: Vec<usize>,
        /// Multipliers of the rows beside contacts.
        beside: Vec<f64>,
        column: Vec<f64>,
        memory: Remembered,
        /// Of every row its stops that the step meets.
        met: Vec<Met>,
        /// For each row, whether it was on a stop when the step began.
        pressed: Vec<bool>,
        /// For each row, the velocity with which it goes back to a stop.
        back: Vec<f64>,
        /// A configuration before it is moved.
        before: Vec<f64>,
    }
}

/// Stops of a row that a step meets or began on.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    at_lower: bool,
    at_upper: bool,
    was_on: bool,
    /// How far it is from those that it began on.
    way: f64,
}

clone_in_place! {
    /// What goes on from step to step.
    #[derive(Debug)]
    pub(super) struct Remembered {
        /// Each row's force in the last step, but for impacts \[N·m or N\].
        carried: Vec<f64>,
        /// Together, of each coordinate.
        forces: Vec<f64>,
        /// Each row's stop that held it in the last step, by its sign; else 0.
        held: Vec<f64>,
        /// Each row's force of its stop in the last step, impacts among it \[N·m or N\].
        stopped: Vec<f64>,
    }
}

impl Remembered {
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
            memory: Remembered {
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

    /// Ends solutions where they are where this flag is set.
    pub(super) fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
        self.part.interrupt = interrupt.clone();
    }

    /// Friction and stops of the step before, which act in the smooth part.
    pub(super) fn forces(&self) -> &[f64] {
        &self.memory.forces
    }

    /// Each row's force of its stop in the last step.
    pub(super) fn stop_forces(&self) -> &[f64] {
        &self.memory.stopped
    }

    /// What goes on from step to step.
    pub(super) fn memory(&mut self) -> &mut Remembered {
        &mut self.memory
    }

    /// The coordinates of each row with their factors.
    pub(super) fn terms(&self) -> &[Vec<(usize, f64)>] {
        &self.terms
    }

    /// Whether some do.
    pub(super) fn acts(&self) -> bool {
        self.memory.carried.iter().any(|force| *force != 0.0)
    }

    /// Whether the step from q₀ to q₁ meets this stop.
    pub(super) fn meets(&self, stop: &Stop, q0: &[f64], q1: &[f64]) -> bool {
        stop.gap(q1) < 0.0 && !is_on(stop, &self.memory.held, q0)
    }

    /// Whether this stop held its row in the step that was accounted for, and has it there at such a gap.
    pub(super) fn holds(&self, stop: &Stop, gap: f64) -> bool {
        self.memory.held[stop.row] == stop.sign && gap <= ON
    }

    /// Chooses the rows of a step of h from q₀ that leads to q₁, with their bounds.
    ///
    /// What a stop held before and moving others moved away from it goes back as what starts beyond a stop does.
    pub(super) fn choose(
        &mut self,
        joints: &Joints,
        stops: &[Stop],
        h: f64,
        (q0, q1): (&[f64], &[f64]),
        components: &Components,
    ) {
        for (terms, stopped) in self.terms.iter().zip(&mut self.memory.stopped) {
            if components.is_active(components.tree_of_row(terms)) {
                *stopped = 0.0;
            }
        }
        self.met.clear();
        self.met.resize(self.memory.carried.len(), Met::default());
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

    /// Adds the rows of the equalities that hold.
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

    /// Sets velocities to what they are but for rounding, of joints that stick and of those on a stop: 0; where they were at rest before
    /// the step, they have not moved.
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

    /// Marks the components of which a joint or a tendon runs into a stop in this step from v₀: what others press with then is of the impact, too.
    pub(super) fn mark_hits(&self, v0: &[f64], components: &mut Components) {
        for (i, &row) in self.rows.iter().enumerate() {
            // What lay on its stop glides along it, where the stop turns as a ball joint's.
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

    /// Whether a row's stop may push.
    fn is_on_stop(&self, i: usize) -> bool {
        self.rows[i] < self.own
            && (self.problem.lower[i].is_infinite() || self.problem.upper[i].is_infinite())
    }

    /// Adds the step's losses to those of each component, at its first tree: −λ times the mean of the velocities before and after; what friction can give of λ is
    /// friction's, the rest the stop's. A loss below zero is of a velocity that overshot. The forces are kept for the next step, those of an impact
    /// in the component, on a stop or elsewhere, are not.
    pub(super) fn account(
        &mut self,
        joints: &Joints,
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
            losses.stops -= (whole - friction) * mean;
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

    /// Whether the tree of a row moves.
    pub(super) fn is_active(&self, row: usize, components: &Components) -> bool {
        components.is_active(self.tree_of(row, components))
    }

    /// Goes back to what was remembered where a step began, of the trees that move.
    pub(super) fn take_back_active(&mut self, begun: &Remembered, components: &Components) {
        let Remembered { carried, forces, held, stopped } = &mut self.memory;
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

impl super::Implicit {
    /// Adds the generalized forces of position limits in the last step, and the force of each tendon's limits along its length: means over the step, over the last
    /// part of one that was divided \[N·m or N\]. The stops of ball joints' angles are not among them.
    pub(crate) fn add_limit_forces(&self, coordinates: &mut [f64], tendons: &mut [f64]) {
        let forces = self.impulses.stop_forces();
        coordinates.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        for (row, number) in self.joints.tendon_rows() {
            tendons[number] += forces[row];
        }
    }
}

/// Whether a joint at q lies on its stop.
fn is_on(stop: &Stop, held: &[f64], q: &[f64]) -> bool {
    is_on_at(stop, held, stop.gap(q))
}

/// The same of a joint that is so far from it.
fn is_on_at(stop: &Stop, held: &[f64], gap: f64) -> bool {
    gap <= 0.0 || (held[stop.row] == stop.sign && gap <= ON)
}

/// The velocity, or another vector's part, along a row.
pub(super) fn along(terms: &[(usize, f64)], x: &[f64]) -> f64 {
    terms.iter().map(|(k, factor)| factor * x[*k]).sum()
}
