//! The impulses of contacts in one step, and their memory.

mod account;
mod begun;
mod found;
pub(crate) mod lift;
mod relative;
mod remembered;
mod results;

use nalgebra::Vector3;

use self::begun::Begun;
pub(crate) use self::found::DEEP;
use self::found::Near;
use self::relative::directions;
use self::remembered::Carried;
pub(crate) use self::remembered::Remembered;
use super::cone_problem::{MOST_ROWS, Set};
use super::interrupt::Interrupt;
use super::placement::{Placement, Twist};
use super::touch::TouchingPoint;
use super::{ConeProblem, ContactSet};
use crate::Model;
use crate::clone_in_place::clone_in_place;
use crate::factor::paths::Paths;

/// What starts below the ground or beyond a stop comes back with this time constant, as does what is left away from it by rounding \[s\].
pub(crate) const RETURN_TIME: f64 = 0.1;

/// The part of its way beyond that is left after a step of h.
pub(crate) fn returns(h: f64) -> f64 {
    (-h / RETURN_TIME).exp()
}

/// A point that each coordinate moves by less than this along the normal, as one under a hinge, does not move: what is left of its row is rounding \[m/rad or 1\].
pub(super) const STUCK: f64 = 1e-9;

/// Approach slower than this does not bounce, and is no impact \[m/s or rad/s\].
pub(crate) const QUIET: f64 = 1e-2;

/// A row of the problem that a joint or a tendon gives: its coordinates, rising, with their factors, the velocity that it is to have, and the bounds of its
/// multiplier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointRow<'a> {
    pub(crate) terms: &'a [(usize, f64)],
    pub(crate) speed: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

/// A step's length, and the inertia that impulses meet there: M̂, packed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImpulsiveStep<'a> {
    pub(crate) h: f64,
    pub(crate) paths: &'a Paths,
    pub(crate) matrix: &'a [f64],
}

clone_in_place! {
    /// Contacts of one robot with its grounds and of its links with each other, step after step.
    #[derive(Debug)]
    pub(crate) struct ContactImpulses {
        set: ContactSet,
        problem: ConeProblem,
        /// The problem of positions.
        lifts: ConeProblem,
        /// λ of the zeros that contacts between links leave.
        carrier: Vec<usize>,
        /// λ with what tendons on their stops join, in lifting.
        joined: Vec<usize>,
        /// Where the step starts, and a place further on.
        start: Placement,
        placement: Placement,
        active: Vec<Active>,
        /// The velocity of each body where the step starts, and the wrench on it.
        velocities: Vec<Twist>,
        wrenches: Vec<Twist>,
        /// The contacts of the last step where this one starts, in the same order.
        begun: Vec<Begun>,
        /// The contacts of the last step with a face of a height field that they are no longer above.
        gone: Vec<Carried>,
        /// Whether each contact of the last step was found again; the pairs of the present contacts, rising.
        seen: Vec<bool>,
        touching_pairs: Vec<usize>,
        /// How deep the deepest point is, as last looked at \[m\].
        depth: f64,
        memory: Remembered,
        /// The contacts of the last step on components that do not move meanwhile.
        parked: Vec<Carried>,
        /// The pairs of trees that are near each other where components are to move apart.
        near: Vec<Near>,
    }
}

/// A contact of this step.
#[derive(Clone, Copy, Debug)]
struct Active {
    point: TouchingPoint,
    /// One of the trees that it moves.
    tree: usize,
    /// Its first row, and how many.
    row: usize,
    rows: usize,
    /// Factors of its rows, and what was added to its normal speed.
    scale: [f64; MOST_ROWS],
    bias: f64,
    /// Which of those that touched in the last step it is.
    known: Option<usize>,
    /// Its velocity where the step starts, as [`ContactImpulses::velocity`].
    before: [f64; MOST_ROWS],
}

impl Active {
    fn new(point: TouchingPoint, tree: usize, known: Option<usize>) -> Self {
        let (scale, before) = ([1.0; MOST_ROWS], [0.0; MOST_ROWS]);
        Self { point, tree, row: 0, rows: 1, scale, bias: 0.0, known, before }
    }
}

impl ContactImpulses {
    pub(crate) fn new(model: &Model, mut set: ContactSet) -> Self {
        set.robot.check(model, "the contact set");
        set.look_only((0..set.shapes.len()).map(|_| true));
        let most = set.count().min(64);
        Self {
            problem: ConeProblem::new(model.nv).with_islands(),
            lifts: ConeProblem::new(model.nv).with_islands(),
            carrier: Vec::with_capacity(model.nv),
            joined: Vec::with_capacity(model.nv),
            start: Placement::new(model),
            placement: Placement::new(model),
            active: Vec::with_capacity(most),
            velocities: Vec::with_capacity(model.bodies.len()),
            wrenches: vec![Twist::default(); model.bodies.len()],
            begun: Vec::with_capacity(most),
            gone: Vec::with_capacity(most),
            seen: Vec::with_capacity(most),
            touching_pairs: Vec::with_capacity(most),
            depth: 0.0,
            memory: Remembered::new(most, set.links.len()),
            parked: Vec::with_capacity(most),
            near: Vec::with_capacity(most),
            set,
        }
    }

    /// Ends solutions without a result where this flag is set.
    pub(crate) fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
        self.lifts.interrupt = interrupt.clone();
    }

    /// What goes on from step to step.
    pub(crate) fn memory(&mut self) -> &mut Remembered {
        &mut self.memory
    }

    /// Whether forces of the last step go on.
    pub(crate) fn acts(&self) -> bool {
        self.memory.carried.iter().any(|carried| carried.acts)
    }

    /// Whether some contact was found.
    pub(crate) fn touches(&self) -> bool {
        !self.active.is_empty() || !self.gone.is_empty()
    }

    /// The impulses that [`solve`](Self::solve) found, on the coordinates.
    pub(crate) fn coordinate_impulses(&mut self, to: &mut [f64]) {
        self.problem.find_impulses(to);
    }

    /// The velocity's change to `change`, and the joint rows' multipliers to theirs: from v₀ at the start and v₁ to which the
    /// smooth part leads. False where numbers are none.
    pub(crate) fn solve<'a>(
        &mut self,
        model: &Model,
        ImpulsiveStep { h, paths, matrix }: ImpulsiveStep<'_>,
        (v0, v1): (&[f64], &[f64]),
        joints: impl Iterator<Item = JointRow<'a>>,
        multipliers: &mut [f64],
        change: &mut [f64],
    ) -> bool {
        self.problem.clear();
        for index in 0..self.active.len() {
            self.add_contact(model, index, h, v0);
        }
        let (problem, mut joint_rows) = (&mut self.problem, 0);
        let contacts = problem.start.len();
        for row in joints {
            let index = problem.push_row(Set::Interval(row.lower, row.upper), 1.0, row.terms);
            problem.start[index] = -row.speed;
            joint_rows += 1;
        }
        // What acted in the smooth part already.
        problem.count_multipliers();
        self.count_what_acted(model, h);
        let problem = &mut self.problem;
        problem.add_speeds(v1);
        let is_solved = if problem.find_islands(paths.carrier()) {
            problem.take_packed((paths, matrix), paths.carrier());
            problem.solve_islands()
        } else {
            self.couple(paths.carrier());
            self.problem.couple_from(contacts, &mut self.carrier);
            self.problem.take_packed((paths, matrix), &self.carrier);
            self.problem.solve_rigid()
        };
        if !is_solved {
            return false;
        }
        let problem = &mut self.problem;
        let violation = problem.violation(self.active.iter().map(|active| active.row));
        self.memory.laws.enter(&violation, problem.is_coulomb);
        multipliers[..joint_rows].copy_from_slice(&problem.multiplier[contacts..]);
        change.copy_from_slice(&problem.x);
        true
    }

    /// The rows of one contact.
    fn add_contact(&mut self, model: &Model, index: usize, h: f64, v0: &[f64]) {
        let point = self.active[index].point;
        let (surface, friction, restitution) = self.set.surface(&point);
        let (rows, scale) = directions(surface, friction);
        let set = if rows == 1 { Set::Interval(0.0, f64::INFINITY) } else { Set::Cone(friction) };
        let row = self.problem.push(set, rows, self.set.coordinates(&point).iter().copied());
        let (support, entries) = self.problem.last();
        let count = support.len();
        let axes = &point.axes;
        // They come from the contact to the root, and mostly each is the coordinate before the last one.
        let mut next = count;
        self.set.each_relative_motion(model, &self.placement, &point, |dof, velocity, spin| {
            next = next.wrapping_sub(1);
            if support.get(next) != Some(&dof.coordinate) {
                let Ok(found) = support.binary_search(&dof.coordinate) else { return };
                next = found;
            }
            for (r, along) in axes.iter().enumerate().take(rows) {
                entries[r * count + next] += dof.ratio * along.dot(&velocity);
            }
            for (r, about) in (3..rows).zip(axes) {
                entries[r * count + next] += dof.ratio * scale[r] * about.dot(&spin);
            }
        });
        // No force is known there, and without one there is no friction.
        if entries[..count].iter().all(|entry| entry.abs() < STUCK) {
            entries.fill(0.0);
        }
        let mut bias = point.gap.max(0.0) / RETURN_TIME;
        let before = if let Some(known) = self.active[index].known {
            let Carried { force, shift, acts, .. } = self.memory.carried[known];
            if acts {
                for r in (0..rows).filter(|r| scale[*r] > 0.0) {
                    self.problem.multiplier[row + r] = h * force[r] / scale[r];
                }
            }
            self.problem.begin_with_shift(shift);
            self.begun[known].velocity
        } else {
            let before = self.velocity(model, &self.start, point.number, v0);
            if -before[0] > QUIET {
                bias += restitution * before[0];
            }
            before
        };
        self.problem.start[row] = bias;
        let active = &mut self.active[index];
        (active.row, active.rows, active.scale) = (row, rows, scale);
        (active.bias, active.before) = (bias, before);
    }
}

/// Force and moment along the world's axes.
fn in_world(point: &TouchingPoint, force: &[f64; MOST_ROWS]) -> (Vector3<f64>, Vector3<f64>) {
    let [n, s, t] = &point.axes;
    let at = |k: usize| n * force[k] + s * force[k + 1] + t * force[k + 2];
    (at(0), at(3))
}
