//! The impulses of contacts in one step, and their memory.

mod begun;
pub(crate) mod lift;
mod relative;
mod remembered;
mod results;

use nalgebra::Vector3;

use self::begun::Begun;
use self::relative::directions;
pub(crate) use self::remembered::Remembered;
use self::remembered::{Carried, Total};
use super::cone_problem::{MOST_ROWS, Set};
use super::interrupt::Interrupt;
use super::placement::{Placement, Twist};
use super::touch::{Against, TouchingPoint};
use super::{ConeProblem, ContactSet};
use crate::clone_in_place::clone_in_place;
use crate::factor::paths::Paths;
use crate::{Model, Workspace};

/// What starts below the ground or beyond a stop comes back with this time constant, as does what is left away from it by rounding \[s\].
pub(crate) const RETURN_TIME: f64 = 0.1;

/// The part of its way beyond that is left after a step of h.
pub(crate) fn returns(h: f64) -> f64 {
    (-h / RETURN_TIME).exp()
}

/// What touches down more slowly than this is no impact for which the step is divided \[m/s\].
const SLOW: f64 = 0.05;

/// A point that each coordinate moves by less than this along the normal, as one under a hinge, does not move: what is left of its row is rounding \[m/rad or 1\].
pub(super) const STUCK: f64 = 1e-9;

/// Points of one pair nearer to each other than this are one \[m\].
const SAME: f64 = 1e-9;

/// Approach slower than this does not bounce, and is no impact \[m/s or rad/s\].
pub(crate) const QUIET: f64 = 1e-2;

/// Energy that contacts took out of a step, by cause \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactLosses {
    pub(crate) friction: f64,
    pub(crate) impacts: f64,
}

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
        /// How deep the deepest of the contacts that the last step found was where that began \[m\].
        start_depth: f64,
        memory: Remembered,
    }
}

/// A contact of this step.
#[derive(Clone, Copy, Debug)]
struct Active {
    point: TouchingPoint,
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
    fn new(point: TouchingPoint, known: Option<usize>) -> Self {
        let (scale, before) = ([1.0; MOST_ROWS], [0.0; MOST_ROWS]);
        Self { point, row: 0, rows: 1, scale, bias: 0.0, known, before }
    }
}

impl ContactImpulses {
    pub(crate) fn new(model: &Model, set: ContactSet) -> Self {
        set.robot.check(model, "the contact set");
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
            start_depth: 0.0,
            memory: Remembered::new(most, set.links.len()),
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
        !self.memory.was_impact && !self.memory.carried.is_empty()
    }

    /// Whether something was hit in the last step, here or on a joint's stop.
    pub(crate) fn was_impact(&self) -> bool {
        self.memory.was_impact
    }

    /// Finds the contacts of the step of h that leads to q₁; whether one of them is an impact, and not in the first of so many parts of it.
    pub(crate) fn find(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        (h, parts): (f64, f64),
        q1: &[f64],
    ) -> bool {
        let Self { set, problem, start, placement, active, gone, seen, begun, start_depth, memory, .. } =
            self;
        *start_depth = begun.iter().fold(0.0, |depth: f64, begun| depth.max(-begun.gap));
        let carried = &memory.carried;
        seen.clear();
        seen.resize(carried.len(), false);
        placement.set(model, workspace, q1);
        active.clear();
        gone.clear();
        problem.clear();
        let mut is_new = false;
        set.find_near(model, placement, 0.0);
        set.look_around(placement, 0.0, |point| {
            let known = carried.binary_search_by_key(&point.number, |carried| carried.number).ok();
            if let Some(known) = known {
                seen[known] = true;
            } else {
                let before = set.point(start, point.number).gap;
                let way = before - point.gap;
                *start_depth = start_depth.max(-before);
                is_new |= way > SLOW * h && before * parts > way;
            }
            active.push(Active::new(point, known));
        });
        // What touched stays, be it a rounding away: gaps near 0 are not decisive for what is looked at, either.
        for (index, (carried, _)) in carried.iter().zip(seen).enumerate().filter(|(_, (_, seen))| !**seen) {
            let point = set.point(placement, carried.number);
            let same = active.iter_mut().find(|other| is_same(&other.point, &point));
            if let Some(same) = same {
                // The point has another number now.
                if same.known.is_none() {
                    same.known = Some(index);
                } else {
                    gone.push(*carried);
                }
            } else if point.gap.is_finite() {
                active.push(Active::new(point, Some(index)));
            } else if !matches!(point.against, Against::Ground(_)) {
                gone.push(*carried);
            }
        }
        is_new
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
            let Carried { force, shift, .. } = self.memory.carried[known];
            if self.acts() {
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

    /// The step's losses, −p times the mean of the velocities before and after. The forces are kept for the next step, which they go on in
    /// unless something was hit here or, `are_joints_hit`, elsewhere.
    pub(crate) fn account(&mut self, h: f64, are_joints_hit: bool) -> ContactLosses {
        let mut losses = ContactLosses::default();
        let meets = |active: &Active| active.known.is_none() && -active.before[0] > QUIET;
        self.memory.was_impact = are_joints_hit || self.active.iter().any(meets);
        let mut carried = core::mem::take(&mut self.memory.carried);
        carried.clear();
        self.list_touching_pairs();
        let summed = self.memory.totals.len();
        for active in &self.active {
            let before = &active.before;
            let mut force = [0.0; MOST_ROWS];
            for r in (0..active.rows).filter(|r| active.scale[*r] > 0.0) {
                let p = self.problem.multiplier[active.row + r];
                let bias = if r == 0 { active.bias } else { 0.0 };
                let after = (self.problem.c[active.row + r] - bias) / active.scale[r];
                force[r] = p * active.scale[r] / h;
                let lost = -force[r] * h * 0.5 * (before[r] + after);
                if r == 0 {
                    losses.impacts += lost;
                } else {
                    losses.friction += lost;
                }
            }
            if force[0] > 0.0 {
                let (world, moment) = in_world(&active.point, &force);
                if let (Against::Ground(_) | Against::Field(_), Some(link)) =
                    (active.point.against, self.set.shapes[active.point.shape].on_ground)
                {
                    (0..3).for_each(|k| self.memory.impulses[link][k] += h * world[k]);
                }
                let shift = self.problem.shift_of(active.row);
                let seen = self.seen_on_face(&active.point);
                let (number, point) = (active.point.number, active.point);
                let total = Total { number, impulse: h * world, angular: h * moment, point, seen };
                self.memory.add_impulse(summed, &total);
                carried.push(Carried { number: active.point.number, force, shift, seen });
            }
        }
        self.memory.totals.sort_unstable_by_key(|total| total.number);
        carried.sort_unstable_by_key(|carried| carried.number);
        self.memory.carried = carried;
        losses
    }
}

/// Whether they are one point of one pair.
fn is_same(one: &TouchingPoint, other: &TouchingPoint) -> bool {
    one.against == other.against
        && matches!(one.against, Against::Pair(_))
        && (one.at - other.at).norm_squared() < SAME * SAME
}

/// Force and moment along the world's axes.
fn in_world(point: &TouchingPoint, force: &[f64; MOST_ROWS]) -> (Vector3<f64>, Vector3<f64>) {
    let [n, s, t] = &point.axes;
    let at = |k: usize| n * force[k] + s * force[k + 1] + t * force[k + 2];
    (at(0), at(3))
}
