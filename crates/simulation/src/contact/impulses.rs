//! The impulses of contacts in one step, and their memory between steps.

mod account;
mod axes;
mod contact_state;
mod corrected_row;
mod frame_variation;
mod memory;
pub(crate) mod position_correction;
mod relative_motion;
mod results;
mod search;
mod step_start;
mod variation;

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::paths::Paths;

use self::axes::directions;
use self::contact_state::{ActiveContact, InitialContact, NearbyPair};
use self::memory::CarriedForce;
use super::cone_problem::{MOST_ROWS, Set};
use super::interrupt::Interrupt;
use super::shape_point::ShapePoint;
use super::{ConeProblem, ContactSet};
use crate::placement::{Placement, Twist};

pub(crate) use self::corrected_row::CorrectedRow;
pub use self::memory::ContactMemory;
pub use self::search::{DEEP, SLOW_TOUCHDOWN};
pub(crate) use self::variation::PushingRow;

/// The time constant with which a penetration or violated stop at the start of a step is corrected, and a
/// rounding gap closed \[s\].
pub const RETURN_TIME: f64 = 0.1;

/// The fraction of this distance that remains after a step of h.
pub fn returns(h: f64) -> f64 {
    (-h / RETURN_TIME).exp()
}

/// A point under a hinge is an example of one that no coordinate moves along the normal. If none moves it by
/// more than this, its row is rounding \[m/rad or 1\].
pub(super) const STUCK: f64 = 1e-9;

/// An approach slower than this does not bounce and is not an impact \[m/s or rad/s\].
pub const QUIET: f64 = 1e-2;

/// A row of the problem for a joint or a tendon. It has its coordinates in increasing order with their
/// factors, its target velocity, and the bounds of its multiplier.
#[derive(Clone, Copy, Debug)]
pub struct JointRow<'a> {
    pub terms: &'a [(usize, f64)],
    pub speed: f64,
    pub lower: f64,
    pub upper: f64,
}

/// A step's length, and the inertia for its impulses: M̂, packed.
#[derive(Clone, Copy, Debug)]
pub struct ImpulsiveStep<'a> {
    pub h: f64,
    pub paths: &'a Paths,
    pub matrix: &'a [f64],
}

clone_in_place! {
    /// The contacts of one robot with its grounds and of its links with each other, over the steps of a run.
    #[derive(Debug)]
    pub struct ContactImpulses {
        set: ContactSet,
        problem: ConeProblem,
        /// The problem of the position correction.
        lifts: ConeProblem,
        /// λ of M̂'s zeros that remain with contacts between links.
        dof_parent: Vec<usize>,
        /// λ with the coupling of tendons at their stops, for the position correction.
        joined: Vec<usize>,
        /// The placement at the start of the step, and a later one.
        start: Placement,
        placement: Placement,
        active: Vec<ActiveContact>,
        /// The velocity of each body at the start of the step, and the wrench on it.
        velocities: Vec<Twist>,
        wrenches: Vec<Twist>,
        /// The contacts of the last step at the start of this one, in the same order.
        begun: Vec<InitialContact>,
        /// The contacts of a step that is linearized, and the forces that acted in its smooth part.
        recorded: Vec<ActiveContact>,
        begun_forces: Vec<CarriedForce>,
        /// The origin of each row of the position correction.
        lifted: Vec<CorrectedRow>,
        /// The contacts of the last step with a face of a height field that have left the space above it.
        gone: Vec<CarriedForce>,
        /// Whether each contact of the last step was found again; the pairs of the present contacts, in
        /// increasing order.
        seen: Vec<bool>,
        touching_pairs: Vec<usize>,
        /// The deepest penetration at the last search \[m\].
        depth: f64,
        memory: ContactMemory,
        /// The contacts of the last step on components that are inactive.
        parked: Vec<CarriedForce>,
        /// The pairs of trees that are near each other while components move separately.
        near: Vec<NearbyPair>,
    }
}

impl ContactImpulses {
    pub fn new(model: &Model, mut set: ContactSet) -> Self {
        model.check_identity(&set.robot, "the contact set");
        set.set_active_shapes((0..set.shapes.len()).map(|_| true));
        let most = set.count().min(64);
        Self {
            problem: ConeProblem::new(model.nv).with_islands(),
            lifts: ConeProblem::new(model.nv).with_islands(),
            dof_parent: Vec::with_capacity(model.nv),
            joined: Vec::with_capacity(model.nv),
            start: Placement::new(model),
            placement: Placement::new(model),
            active: Vec::with_capacity(most),
            velocities: Vec::with_capacity(model.bodies.len()),
            wrenches: vec![Twist::default(); model.bodies.len()],
            begun: Vec::with_capacity(most),
            recorded: Vec::new(),
            begun_forces: Vec::new(),
            lifted: Vec::with_capacity(most),
            gone: Vec::with_capacity(most),
            seen: Vec::with_capacity(most),
            touching_pairs: Vec::with_capacity(most),
            depth: 0.0,
            memory: ContactMemory::new(most, set.links.len()),
            parked: Vec::with_capacity(most),
            near: Vec::with_capacity(most),
            set,
        }
    }

    /// Ends solutions early, without a result, if this flag is set.
    pub fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
        self.lifts.interrupt = interrupt.clone();
    }

    /// The memory between steps.
    pub fn memory(&mut self) -> &mut ContactMemory {
        &mut self.memory
    }

    /// Whether forces of the last step continue.
    pub fn acts(&self) -> bool {
        self.memory.carried.iter().any(|carried| carried.acts)
    }

    /// Whether there are contacts.
    pub fn touches(&self) -> bool {
        !self.active.is_empty() || !self.gone.is_empty()
    }

    /// Computes the generalized impulses of the last [`solve`](Self::solve).
    pub(crate) fn coordinate_impulses(&mut self, to: &mut [f64]) {
        self.problem.find_impulses(to);
    }

    /// Computes the change of the velocity into `change`, and the joint rows' multipliers: from v₀ at the
    /// start and v₁ after the smooth part. Returns false if a number is not finite.
    pub fn solve<'a>(
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
        // These multipliers acted in the smooth part already.
        problem.count_multipliers();
        self.count_what_acted(model, h);
        let problem = &mut self.problem;
        problem.add_speeds(v1);
        let is_solved = if problem.find_islands(paths.dof_parent()) {
            problem.set_packed_matrix((paths, matrix), paths.dof_parent());
            problem.solve_islands()
        } else {
            self.couple(paths.dof_parent());
            self.problem.couple_from(contacts, &mut self.dof_parent);
            self.problem.set_packed_matrix((paths, matrix), &self.dof_parent);
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
        // The coordinates come from the contact to the root. Usually each is the one before the last.
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
        // The force there is undetermined, so there is no friction either.
        if entries[..count].iter().all(|entry| entry.abs() < STUCK) {
            entries.fill(0.0);
        }
        let mut bias = point.gap.max(0.0) / RETURN_TIME;
        let before = if let Some(known) = self.active[index].known {
            let CarriedForce { force, shift, acts, .. } = self.memory.carried[known];
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
        let surface_motion = self.surface_motion(&point);
        for r in 1..rows {
            self.problem.start[row + r] = scale[r] * surface_motion[r];
        }
        let active = &mut self.active[index];
        (active.row, active.rows, active.scale) = (row, rows, scale);
        (active.bias, active.surface_motion, active.before) = (bias, surface_motion, before);
    }
}
