//! MuJoCo's law: constraints that yield, each by as much as its numbers say, in one convex problem with one answer.
//!
//! min over v̇ of ½v̇ᵀMv̇ − (τ − Cv − g)ᵀv̇ + Σ ψ(A v̇ − a), with the constraints' reference accelerations a and
//! ψ(c) = ½R|p|², p = Π(−c/R) their forces (`impedance`, `cone_problem`). A contact's rows are scaled so that one R serves all of them:
//! with impratio ι, cone μ' = μ₁/√ι, R' = μ'²R, normal row times μ', side rows times their μ. **(Todorov 2014; MuJoCo,
//! "Computation")**
//!
//! A v̇ is what MuJoCo multiplies: without Ȧ v (but for connections and welds), and with the acceleration of a free joint along the world's axes,
//! u̇ + ω × u in the body's.

mod active_set;
mod books;
mod connection;
mod impedance;
mod point;
mod rows;
mod weights;

use dynamics::DynamicsError;
use nalgebra::Vector3;

pub use self::active_set::ActiveSet;
use self::impedance::Response;
pub use self::point::SoftContact;
pub(super) use self::point::mixed;
use self::rows::{JointRows, Side};
use self::weights::InverseWeights;
use super::cone_problem::{MOST_ROWS, Set};
use super::field::PlacedField;
use super::ground::axes;
use super::interrupt::Interrupt;
use super::pair::Pair;
use super::placement::Placement;
use super::touch::{Against, TouchingPoint};
use super::{ConeProblem, ContactError, ContactSet, rows_of};
use crate::clone_in_place::clone_in_place;
use crate::factor::sparse::coordinate_carriers;
use crate::model::identity::Identity;
use crate::model::length::check_length;
use crate::model::softness::Softness;
use crate::space::conventions::add_transport;
use crate::{FrameId, Model, Workspace, bias, mass_matrix};

/// Least friction of a contact that has some.
const LEAST_FRICTION: f64 = 1e-5;

clone_in_place! {
    /// A robot's constraints under MuJoCo's law, which lets each of them give way: limits of positions and of tendons' lengths, dry friction of both,
    /// equalities of joints and connected points, and contacts. For comparison with MuJoCo, and for robots tuned with it; what it gives up is that friction creeps and contacts
    /// sink, each by what `solref` and `solimp` say. The rigid law is that of [`Implicit`](crate::Implicit).
    ///
    /// ```
    /// use multibody::{Limits, Model, SoftConstraints, Workspace, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut soft = SoftConstraints::new(&model, 1e-3)?;
    /// let (mut workspace, mut a) = (Workspace::new(&model), [0.0]);
    /// soft.forward(&model, &mut workspace, &[0.301], &[0.0], &[0.0], &[], &mut a)?; // a milliradian beyond its limit
    /// assert!(a[0] < 0.0 && soft.forces()[0] < 0.0); // it comes back
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug)]
    pub struct SoftConstraints {
        robot: Identity,
        time_step: f64,
        impratio: f64,
        /// Whether the joints' damping and friction act.
        dissipates: bool,
        /// Whether Newton's method starts from the last state's acceleration.
        is_warm: bool,
        weights: InverseWeights,
        joints: JointRows,
        ground: Option<ContactSet>,
        /// The frames of the ground's links, and of the links of all shapes.
        links: Vec<FrameId>,
        shapes: Vec<Option<FrameId>>,
        placement: Placement,
        problem: ConeProblem,
        mass: Vec<f64>,
        /// λ of M's zeros, and of a matrix without any.
        carriers: [Vec<usize>; 2],
        transport: Vec<f64>,
        speeds: Vec<f64>,
        forces: Vec<f64>,
        contacts: Vec<SoftContact>,
        /// One entry for each contact that was found: the shape, and what it touches.
        found: Vec<(usize, Against)>,
        /// The first row of each contact.
        starts: Vec<usize>,
        active: ActiveSet,
        /// The limits and contacts that are to act, where they are given and not found.
        fixed: Option<ActiveSet>,
        /// B and K d r of each block's rows.
        asked: Vec<Asked>,
    }
}

/// What the rows of one constraint ask for.
#[derive(Clone, Copy, Debug)]
struct Asked {
    row: usize,
    rows: usize,
    damping: f64,
    /// B of the rows after the first.
    side_damping: f64,
    /// Of the first row.
    spring: f64,
    /// Ȧ v of its only row, where that counts.
    drift: Option<f64>,
    of: Of,
}

/// What a row belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Friction,
    /// A limit of a ball joint's angle, or an equality.
    Stop,
    /// A limit of this coordinate, with the sign of its force times the joint's ratio.
    Limit(usize, f64),
    /// The same of the tendon of this number.
    TendonLimit(usize, f64),
    Contact,
}

impl Asked {
    /// Of one row.
    fn new(of: Of, row: usize, damping: f64, spring: f64) -> Self {
        Self { row, rows: 1, damping, side_damping: damping, spring, drift: None, of }
    }
}

/// Where the robot is, in steps of h.
struct State<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    q: &'a [f64],
    v: &'a [f64],
    h: f64,
    dissipates: bool,
}

impl SoftConstraints {
    /// For steps of h \[s\]: no time constant is shorter than 2h.
    ///
    /// # Errors
    /// [`DynamicsError::SingularMass`]: M has no inverse in the reference pose.
    pub fn new(model: &Model, h: f64) -> Result<Self, DynamicsError> {
        let n = model.nv;
        let weights = InverseWeights::new(model)?;
        let dense = (0..n).map(|k| k.checked_sub(1).unwrap_or(crate::factor::sparse::NONE)).collect();
        Ok(Self {
            robot: model.identity.clone(),
            time_step: h,
            impratio: 1.0,
            dissipates: true,
            is_warm: false,
            joints: JointRows::new(model, &weights),
            weights,
            ground: None,
            links: Vec::new(),
            shapes: Vec::new(),
            placement: Placement::new(model),
            problem: ConeProblem::new(n),
            mass: vec![0.0; n * n],
            carriers: [coordinate_carriers(model), dense],
            transport: vec![0.0; n],
            speeds: Vec::new(),
            forces: vec![0.0; n],
            contacts: Vec::new(),
            found: Vec::new(),
            starts: Vec::new(),
            active: ActiveSet::default(),
            fixed: None,
            asked: Vec::new(),
        })
    }

    /// With MuJoCo's `impratio`: how much stiffer friction is than the normal force; 1 without this.
    pub fn with_impratio(self, impratio: f64) -> Self {
        Self { impratio: impratio.max(f64::MIN_POSITIVE), ..self }
    }

    /// With contacts with the ground, and with those between links that the set has. A ground that states no surface takes that of each shape, as
    /// under the rigid law of [`Implicit`](crate::Implicit); a friction that the ground states stands for both.
    ///
    /// ```
    /// use multibody::{ContactError, ContactSet, Ground, Model, SoftConstraints, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let bouncy = ContactSet::new(&model, &[Ground::level(-1.0).with_restitution(0.9)])?;
    /// let law = SoftConstraints::new(&model, 1e-3)?.with_ground(&model, bouncy);
    /// assert_eq!(law.err(), Some(ContactError::RestitutionUnderSoftLaw { restitution: 0.9 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ContactError::RestitutionUnderSoftLaw`]: a ground, a height field or the links bounce. This law has no restitution.
    ///
    /// # Panics
    /// If the set is another robot's.
    #[track_caller]
    pub fn with_ground(self, model: &Model, ground: ContactSet) -> Result<Self, ContactError> {
        ground.robot.check(model, "the contact set");
        if let Some(restitution) = ground.restitutions().find(|restitution| *restitution != 0.0) {
            return Err(ContactError::RestitutionUnderSoftLaw { restitution });
        }
        let links = ground.links().iter().filter_map(|link| model.frame(link)).collect();
        let shapes = ground.shapes.iter().map(|shape| model.frame(&shape.link)).collect();
        Ok(Self { ground: Some(ground), links, shapes, ..self })
    }

    /// v̇ at (q, v) under the forces τ of motors; the joints' own springs and damping are added to them, those of tendons are to be in τ, but for
    /// their dry friction ([`Actuation::without_tendon_friction`](crate::Actuation::without_tendon_friction)). `contacts` act beside those with
    /// the ground.
    ///
    /// Sizes: q nq, v, τ and `acceleration` nv.
    ///
    /// # Errors
    /// [`DynamicsError::SingularMass`]: M has no inverse here, or a number is none.
    ///
    /// # Panics
    /// If a slice has the wrong length, or a frame is another robot's.
    #[allow(clippy::too_many_arguments)]
    #[track_caller]
    pub fn forward(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        contacts: &[SoftContact],
        acceleration: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.robot.check(model, "the constraints");
        workspace.admit(model, q);
        for (what, slice) in [("v", v), ("the forces", tau), ("the accelerations", &*acceleration)] {
            check_length(what, slice.len(), model.nv);
        }
        mass_matrix(model, workspace, q, &mut self.mass);
        self.placement.set(model, workspace, q);
        self.problem.clear();
        // f = Cv + g + Dv − τ.
        bias(model, workspace, q, v, &mut self.problem.force);
        for (force, tau) in self.problem.force.iter_mut().zip(tau) {
            *force -= tau;
        }
        for dof in model.dofs.iter().filter(|_| self.dissipates) {
            let square = dof.ratio * dof.ratio;
            self.problem.force[dof.coordinate] += square * dof.passive.damping * v[dof.coordinate];
        }
        self.asked.clear();
        self.contacts.clear();
        self.contacts.extend(contacts);
        self.find_contacts(model);
        let is_tree =
            self.add_rows(State { model, workspace, q, v, h: self.time_step, dissipates: self.dissipates });
        // c₀ = A(ω × u) − a = A(ω × u) + B A v + K d r.
        self.transport.fill(0.0);
        add_transport(model, v, 1.0, &mut self.transport);
        self.problem.find_products(&self.transport, &mut self.speeds);
        self.problem.start.copy_from_slice(&self.speeds);
        self.problem.find_products(v, &mut self.speeds);
        for asked in &self.asked {
            let start = &mut self.problem.start[asked.row..asked.row + asked.rows];
            start[0] = asked.drift.unwrap_or(start[0]) + asked.spring;
            for (k, (start, speed)) in start.iter_mut().zip(&self.speeds[asked.row..]).enumerate() {
                *start += if k == 0 { asked.damping } else { asked.side_damping } * speed;
            }
        }
        self.problem.take(&self.mass, &self.carriers[usize::from(!is_tree)]);
        if !self.problem.solve_soft(self.is_warm) {
            // A mass matrix without an inverse leaves no number in v̇; nor does a state that has grown without bound.
            let overflows = |numbers: &[f64]| numbers.iter().any(|number| !number.is_finite());
            let index = self.problem.x.iter().position(|x| !x.is_finite()).unwrap_or(0);
            if overflows(&self.problem.force) || overflows(&self.problem.start) || overflows(&self.mass) {
                return Err(DynamicsError::NonFinite { quantity: "the acceleration", index });
            }
            return Err(DynamicsError::SingularMass { coordinate: index, pivot: f64::NAN });
        }
        acceleration.copy_from_slice(&self.problem.x);
        self.forces.fill(0.0);
        let Self { problem, forces, .. } = self;
        problem.add_found_forces(forces);
        Ok(())
    }

    /// The constraints' forces at the last state, nv entries \[N·m or N\].
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// The contacts of the last state: those given, then those with the ground, each with its force on `link` along the world's axes
    /// \[N\].
    ///
    /// ```
    /// use multibody::{Model, SoftConstraints, SoftContact, Workspace, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let (mut workspace, mut a) = (Workspace::new(&model), [0.0]);
    /// let mut soft = SoftConstraints::new(&model, 1e-3)?;
    /// let tip = SoftContact::new(model.frame("rod").unwrap(), [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], -1e-4);
    /// soft.forward(&model, &mut workspace, &[0.0], &[0.0], &[0.0], &[tip], &mut a)?;
    /// let (_, force) = soft.contacts().next().unwrap();
    /// assert!(force[2] > 0.8 * 2.0 * 9.81); // at this depth it carries nearly all of the weight
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts(&self) -> impl Iterator<Item = (&SoftContact, [f64; 3])> {
        self.contact_wrenches().map(|(contact, force, _)| (contact, force.into()))
    }

    /// The contacts of the last state, each with force and moment along the world's axes.
    pub(super) fn contact_wrenches(
        &self,
    ) -> impl Iterator<Item = (&SoftContact, Vector3<f64>, Vector3<f64>)> + Clone {
        self.contacts.iter().zip(&self.starts).map(|(contact, &row)| {
            let axes = axes(contact.normal.into());
            let (rows, scale, _) = self.scaled(contact);
            let along = |k: usize| axes[k % 3] * (self.problem.multiplier[row + k] * scale[k]);
            let force = (0..rows.min(3)).map(along).sum::<Vector3<f64>>();
            (contact, force, (3..rows).map(along).sum())
        })
    }

    /// Ends a solution without a result where this flag is set.
    pub(crate) fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
    }

    #[track_caller]
    pub(crate) fn check(&self, model: &Model) {
        self.robot.check(model, "the constraints");
    }

    /// How many rows a contact has, their factors, and μ'.
    fn scaled(&self, contact: &SoftContact) -> (usize, [f64; MOST_ROWS], f64) {
        let friction = contact.friction.map(|friction| friction.max(LEAST_FRICTION));
        let rows = rows_of(contact.condim);
        if rows == 1 {
            return (1, [1.0; MOST_ROWS], 1.0);
        }
        let cone = friction[0] / self.impratio.sqrt();
        let [a, b, c, d, e] = friction;
        (rows, [cone, a, b, c, d, e], cone)
    }

    /// All rows; whether each constraint moves with freedoms that carry one another.
    fn add_rows(&mut self, mut state: State<'_>) -> bool {
        let State { model, h, .. } = state;
        let active = Self::active_limits(&mut self.active, self.fixed.as_ref());
        let rows = (&mut self.problem, &mut self.asked);
        let mut is_tree = self.joints.add(&self.placement, &mut state, active, rows);
        self.starts.clear();
        for index in 0..self.contacts.len() {
            let contact = self.contacts[index];
            let (rows, scale, cone) = self.scaled(&contact);
            let violation = contact.distance - contact.margin;
            let response = Response::new(&contact.softness, h, violation);
            let set = if rows == 1 { Set::Interval(0.0, f64::INFINITY) } else { Set::Cone(cone) };
            let mut weight = self.weights.frames[contact.link.index];
            let point = contact.point.into();
            let mut sides = [Some(Side::new(model, contact.link, 1.0, point)), None];
            if let Some(other) = contact.other {
                sides[1] = Some(Side::new(model, other, -1.0, point));
                weight[0] += self.weights.frames[other.index][0];
                is_tree &= model.frame_of(other).body.is_none();
            }
            let axes = axes(contact.normal.into());
            let none = Vector3::zeros();
            let mut directions = [(none, none); MOST_ROWS];
            for (k, direction) in directions[..rows].iter_mut().enumerate() {
                let axis = axes[k % 3] * scale[k];
                *direction = if k < 3 { (axis, none) } else { (none, axis) };
            }
            let (placement, problem) = (&self.placement, &mut self.problem);
            let row = rows::push(problem, model, placement, set, sides, &directions[..rows]);
            problem.soften(cone * cone * response.softness(weight[0]));
            let spring = scale[0] * response.spring;
            let of_sides =
                |solref| Response::new(&Softness { solref, ..contact.softness }, h, violation).damping;
            let side_damping = contact.solreffriction.map_or(response.damping, of_sides);
            let asked = Asked::new(Of::Contact, row, response.damping, spring);
            self.asked.push(Asked { rows, side_damping, ..asked });
            self.starts.push(row);
        }
        is_tree
    }
}
