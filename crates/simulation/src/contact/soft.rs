//! MuJoCo's law: soft constraints, each with its own parameters, as one convex problem with a unique
//! solution.
//!
//! min over v̇ of ½v̇ᵀMv̇ − (τ − Cv − g)ᵀv̇ + Σ ψ(A v̇ − a). Here a are the constraints' reference
//! accelerations, ψ(c) = ½R|p|², and p = Π(−c/R) their forces (`impedance`, `cone_problem`). A contact's rows
//! are scaled so that they share one R. With impratio ι, the cone is μ' = μ₁/√ι and R' = μ'²R; the normal row
//! is scaled by μ', and the tangential rows by their μ. **(Todorov 2014; MuJoCo, "Computation")**
//!
//! A v̇ is defined as in MuJoCo: without Ȧ v, except for connections and welds. The acceleration of a free
//! joint is along the world's axes, which is u̇ + ω × u in the body's.

mod active_set;
mod adhesion;
mod connection;
mod contact_rows;
mod contact_search;
mod forces;
mod impedance;
mod joint_rows;
mod point;
mod point_rows;
mod reference;
mod rows;
mod weights;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::conventions::add_transport;
use robot_dynamics_core::factorization::sparse::coordinate_parents;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::{FrameId, Model, Workspace, bias, mass_matrix};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::InvalidInput;

use self::adhesion::Adhesion;
use self::point_rows::Bodies;
use self::reference::{RowReference, StepState};
use self::rows::JointRows;
use self::weights::InverseWeights;
use super::field::PlacedField;
use super::interrupt::Interrupt;
use super::pair::ShapePair;
use super::shape_point::{ContactPartner, ShapePoint};
use super::{ConeProblem, ContactSet};

pub use self::active_set::ActiveSet;
pub use self::point::SoftContact;
pub(super) use self::point::mixed;

/// The least friction of a contact with friction.
const LEAST_FRICTION: f64 = 1e-5;

/// The inputs of [`SoftConstraints::forward`].
#[derive(Clone, Copy, Debug)]
pub struct SoftDynamicsInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// The forces of motors and tendons, nv numbers \[N·m, N\]. They include all forces of tendons except
    /// dry friction ([`Actuation::without_tendon_friction`](crate::Actuation::without_tendon_friction)).
    pub tau: &'a [f64],
    /// Contacts in addition to those with the ground.
    pub contacts: &'a [SoftContact],
}

clone_in_place! {
    /// A robot's constraints by MuJoCo's soft law. They are limits of positions and of tendons' lengths, dry
    /// friction of both, equalities of joints and connected points, and contacts. Use it to compare with
    /// MuJoCo, and for robots tuned with it. Friction creeps and contacts penetrate, by amounts that `solref`
    /// and `solimp` determine. [`ImplicitIntegrator`](crate::ImplicitIntegrator) has the rigid law.
    ///
    /// ```
    /// use robot_dynamics::contact::{SoftConstraints, SoftDynamicsInputs};
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut soft = SoftConstraints::new(&model, 1e-3)?;
    /// let (mut workspace, mut a) = (Workspace::new(&model), [0.0]);
    /// // A milliradian beyond its limit.
    /// let inputs = SoftDynamicsInputs { q: &[0.301], v: &[0.0], tau: &[0.0], contacts: &[] };
    /// soft.forward(&model, &mut workspace, inputs, &mut a)?;
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
        bodies: Bodies,
        problem: ConeProblem,
        mass: Vec<f64>,
        /// λ of M's zeros, and λ of a dense matrix.
        dof_parents: [Vec<usize>; 2],
        transport: Vec<f64>,
        speeds: Vec<f64>,
        forces: Vec<f64>,
        contacts: Vec<SoftContact>,
        /// One entry for each contact that was found: the shape, and its contact partner.
        found: Vec<(usize, ContactPartner)>,
        adhesion: Adhesion,
        /// The first row of each contact.
        starts: Vec<usize>,
        active: ActiveSet,
        /// The limits and contacts that act, if they are given instead of found.
        fixed: Option<ActiveSet>,
        /// B and K d r of each block's rows.
        asked: Vec<RowReference>,
        /// The speeds of the surfaces in addition to those of their bodies, by row.
        surface_speeds: Vec<(usize, f64)>,
    }
}

impl SoftConstraints {
    /// The constraints for steps of h \[s\]: no time constant is shorter than 2h.
    ///
    /// # Errors
    /// [`IntegratorError::SingularMass`]: M is singular in the reference pose.
    pub fn new(model: &Model, h: f64) -> Result<Self, IntegratorError> {
        let n = model.nv;
        let weights = InverseWeights::new(model)?;
        let dense = (0..n)
            .map(|k| k.checked_sub(1).unwrap_or(robot_dynamics_core::factorization::sparse::NONE))
            .collect();
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
            bodies: Bodies::new(model),
            problem: ConeProblem::new(n),
            mass: vec![0.0; n * n],
            dof_parents: [coordinate_parents(model), dense],
            transport: vec![0.0; n],
            speeds: Vec::new(),
            forces: vec![0.0; n],
            contacts: Vec::new(),
            found: Vec::new(),
            adhesion: Adhesion::new(n),
            starts: Vec::new(),
            active: ActiveSet::default(),
            fixed: None,
            asked: Vec::new(),
            surface_speeds: Vec::new(),
        })
    }

    /// Sets MuJoCo's `impratio`: the stiffness of friction relative to the normal force; 1 by default.
    pub fn with_impratio(self, impratio: f64) -> Self {
        Self { impratio: impratio.max(f64::MIN_POSITIVE), ..self }
    }

    /// Adds contacts with the ground, and those between links in the set. A ground without a surface takes
    /// that of each shape, as under the rigid law of [`ImplicitIntegrator`](crate::ImplicitIntegrator). A friction given for the
    /// ground replaces that of both.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, Ground, SoftConstraints};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let bouncy = ContactSet::new(&model, &[Ground::level(-1.0).with_restitution(0.9)])?;
    /// let law = SoftConstraints::new(&model, 1e-3)?.with_ground(&model, bouncy);
    /// assert!(law.is_err_and(|error| error.to_string().contains("MuJoCo's law has no restitution")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`]: a ground, a height field or the links have restitution.
    /// This law has none.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn with_ground(self, model: &Model, ground: ContactSet) -> Result<Self, InvalidInput> {
        model.check_identity(&ground.robot, "the contact set");
        if let Some(restitution) = ground.restitutions().find(|restitution| *restitution != 0.0) {
            let requirement = "is invalid, because MuJoCo's law has no restitution: leave it out and let `solref` of \
                               the surfaces set how a contact bounces, or take the integrator `implicit`";
            return Err(InvalidInput::unmet(
                format!("a coefficient of restitution of {restitution}"),
                requirement,
            ));
        }
        let links = ground.links().iter().filter_map(|link| model.frame(link)).collect();
        let shapes = ground.shapes.iter().map(|shape| model.frame(&shape.link)).collect();
        Ok(Self { ground: Some(ground), links, shapes, ..self })
    }

    /// Computes v̇ at (q, v) under the forces τ of motors. The joints' own springs and damping are added.
    /// `acceleration` has nv numbers.
    ///
    /// # Errors
    /// [`IntegratorError::SingularMass`]: M is singular here, or a number is not finite.
    ///
    /// # Panics
    /// If a slice has the wrong length, or a frame belongs to another robot.
    #[track_caller]
    pub fn forward(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        inputs: SoftDynamicsInputs<'_>,
        acceleration: &mut [f64],
    ) -> Result<(), IntegratorError> {
        let SoftDynamicsInputs { q, v, tau, contacts } = inputs;
        model.check_identity(&self.robot, "the constraints");
        workspace.check_inputs(model, q);
        for (what, slice) in [("v", v), ("the forces", tau), ("the accelerations", &*acceleration)] {
            check_length(what, slice.len(), model.nv);
        }
        mass_matrix(model, workspace, q, &mut self.mass);
        self.bodies.placement.set(model, workspace, q);
        self.problem.clear();
        self.find_force(model, workspace, (q, v), tau);
        self.asked.clear();
        self.surface_speeds.clear();
        self.contacts.clear();
        self.contacts.extend(contacts);
        self.find_contacts(model);
        self.adhesion.compute(model, &self.bodies, &self.contacts);
        self.problem.force.iter_mut().zip(self.adhesion.forces()).for_each(|(sum, force)| *sum -= force);
        let is_tree = self.add_rows(StepState {
            model,
            workspace,
            q,
            v,
            h: self.time_step,
            dissipates: self.dissipates,
        });
        self.find_reference(model, v);
        self.problem.set_matrix(&self.mass, &self.dof_parents[usize::from(!is_tree)]);
        if !self.problem.solve_soft(self.is_warm) {
            return Err(self.failure());
        }
        acceleration.copy_from_slice(&self.problem.x);
        self.forces.fill(0.0);
        let Self { problem, forces, .. } = self;
        problem.add_found_forces(forces);
        Ok(())
    }

    /// Computes f = Cv + g + Dv − τ.
    fn find_force(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        (q, v): (&[f64], &[f64]),
        tau: &[f64],
    ) {
        bias(model, workspace, q, v, &mut self.problem.force);
        for (force, tau) in self.problem.force.iter_mut().zip(tau) {
            *force -= tau;
        }
        for dof in model.dofs.iter().filter(|_| self.dissipates) {
            let square = dof.ratio * dof.ratio;
            self.problem.force[dof.coordinate] += square * dof.passive.damping * v[dof.coordinate];
        }
    }

    /// Computes c₀ = A(ω × u) − a = A(ω × u) + B A v + K d r.
    fn find_reference(&mut self, model: &Model, v: &[f64]) {
        self.transport.fill(0.0);
        add_transport(model, v, 1.0, &mut self.transport);
        self.problem.find_products(&self.transport, &mut self.speeds);
        self.problem.start.copy_from_slice(&self.speeds);
        self.problem.find_products(v, &mut self.speeds);
        for &(row, speed) in &self.surface_speeds {
            self.speeds[row] += speed;
        }
        for asked in &self.asked {
            let start = &mut self.problem.start[asked.row..asked.row + asked.rows];
            start[0] = asked.drift.unwrap_or(start[0]) + asked.spring;
            for (k, (start, speed)) in start.iter_mut().zip(&self.speeds[asked.row..]).enumerate() {
                *start += if k == 0 { asked.damping } else { asked.side_damping } * speed;
            }
        }
    }

    /// The error of a solution that failed: a singular mass matrix, or a state that has diverged, gives a v̇
    /// that is not finite.
    fn failure(&self) -> IntegratorError {
        let overflows = |numbers: &[f64]| numbers.iter().any(|number| !number.is_finite());
        let index = self.problem.x.iter().position(|x| !x.is_finite()).unwrap_or(0);
        if overflows(&self.problem.force) || overflows(&self.problem.start) || overflows(&self.mass) {
            return IntegratorError::NotFinite { quantity: "the acceleration", index };
        }
        IntegratorError::SingularMass { coordinate: index, pivot: f64::NAN }
    }

    /// The constraints' forces in the last state, nv entries \[N·m or N\].
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// The contacts of the last state: the given ones, then those with the ground, each with its force on
    /// `link` in world axes \[N\].
    ///
    /// ```
    /// use robot_dynamics::contact::{SoftConstraints, SoftContact, SoftDynamicsInputs};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::{Model, Workspace};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let (mut workspace, mut a) = (Workspace::new(&model), [0.0]);
    /// let mut soft = SoftConstraints::new(&model, 1e-3)?;
    /// let tip = SoftContact::new(model.frame("rod").unwrap(), [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], -1e-4);
    /// let inputs = SoftDynamicsInputs { q: &[0.0], v: &[0.0], tau: &[0.0], contacts: &[tip] };
    /// soft.forward(&model, &mut workspace, inputs, &mut a)?;
    /// let (_, force) = soft.contacts().next().unwrap();
    /// assert!(force[2] > 0.8 * 2.0 * 9.81); // at this depth it carries nearly all of the weight
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts(&self) -> impl Iterator<Item = (&SoftContact, [f64; 3])> {
        self.contact_wrenches().map(|(contact, force, _)| (contact, force.into()))
    }

    /// Ends a solution early, without a result, if this flag is set.
    pub fn watch(&mut self, interrupt: &Interrupt) {
        self.problem.interrupt = interrupt.clone();
    }

    #[track_caller]
    pub fn check(&self, model: &Model) {
        model.check_identity(&self.robot, "the constraints");
    }
}
