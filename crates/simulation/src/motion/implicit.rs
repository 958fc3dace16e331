//! Steps that remain stable for stiff joints: implicit damping and springs, static and sliding dry friction,
//! and inelastic stops.
//!
//! **Smooth part.** The scheme has order 2 and evaluates M and the forces once, at the middle qₘ = q₀ ⊕ ½hv₀.
//! It reduces to the leapfrog method if the forces do not depend on v. With q = q₀ ⊕ Θ, and the joints'
//! damping D and stiffness K, the equations are
//!
//! ```text
//! M v̇ = f(v) − K(Θ − ½hv₀),  Θ̇ = v + ½[Θ,v] + …,  f(v) = τ − Cv − g − Dv at qₘ.
//! ```
//!
//! The step is a two-stage Rosenbrock step for any approximation A of the Jacobian. It is L-stable in the
//! terms that A contains, D and K (γ = 1 − 1/√2):
//!
//! ```text
//! (1 − γhA)k₁ = F(y₀),  (1 − γhA)k₂ = F(y₀ + hk₁) − 2k₁,  y₁ = y₀ + h(3k₁ + k₂)/2.
//! ```
//!
//! **(Verwer, Spee, Blom & Hundsdorfer 1999)** Each stage solves M̂x = …, M̂ = M + γhD + γ²h²K; one sparse
//! factor serves both stages. Stages at the ends of the step would use another M than the one that balances a
//! stiff joint's forces. The difference would disturb neighboring joints.
//!
//! **Friction and stops.** Impulses λ act at the step's end, and M̂ has ½h in place of γh. The velocity v⁺ =
//! v₁ + M̂⁻¹Eᵀλ minimizes the convex function ½(v⁺ − v₁)ᵀM̂(v⁺ − v₁) + hΣfᵢ|v⁺ᵢ|, with v⁺ᵢ ≥ 0 away from each
//! stop that the step would pass. The minimum is unique: a joint sticks with v⁺ᵢ = 0, without creep, if an
//! impulse |λᵢ| < hfᵢ is sufficient. The smooth part includes the forces of the last step, and λ is the
//! correction to them, so sliding and resting keep the order. Positions take half of the impulse, q⁺ = q₁ ⊕
//! ½hM̂⁻¹Eᵀλ, as under a constant force. Positions that remain beyond a stop are then moved to it.

mod actuators;
mod advance;
mod bounded_problem;
mod constraints;
mod contacts;
mod equalities;
mod impulses;
mod interruption;
mod joints;
mod linearization;
mod measured;
mod momentum;
mod parts;
mod path_stops;
mod pivots;
mod positions;
mod restoration;
mod rosenbrock;
mod snapshot;
mod step_division;
mod stiff_factor;
#[cfg(test)]
mod test_robot;

use nalgebra::Vector3;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::factorization::paths::usual_entries;
use robot_dynamics_core::{Model, SingularMass, Workspace};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::EnergyAccount;

use self::equalities::Equalities;
use self::impulses::Impulses;
use self::joints::Joints;
use self::linearization::StepRecord;
use self::momentum::FreeTranslations;
use self::path_stops::PathStops;
use self::snapshot::StepSnapshot;
use self::stiff_factor::StiffFactor;
use crate::contact::{Components, ContactImpulses, Interrupt};
use crate::equality::rows::EqualityRows;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::motion::linearize_step::results::{
    LinearizationMethod, LinearizedStep, LinearizedStepWithParameters,
};
use crate::motion::simulate::{Losses, StepError, Stepper};
use crate::motion::step_actuation::{StepActuation, record, stored_energy};
use crate::{ContactLaws, StateTransition, StepForces, StepWorkspace};

clone_in_place! {
    /// Steps with stiff joints, dry friction and stops. This [`Stepper`] takes the steps of a
    /// [`Simulation`](crate::simulator::Simulation) with
    /// [`Method::Implicit`](crate::simulator::Method::Implicit), and supports every effect of a description.
    /// It stores the forces of friction and stops of the last step, from which the next step starts.
    ///
    /// | effect | treatment |
    /// | --- | --- |
    /// | damping, springs of joints | implicit, order 2, stable for any h |
    /// | forces of a fluid | drag implicit, lift and added mass explicit, order 2 |
    /// | friction of joints and tendons | static friction without creep; sliding of order 2 between reversals |
    /// | limits of positions, of ball joints' angles, and of the lengths of tendons over joints and along paths | inelastic stops, unless [`Effect::Limits`](crate::simulator::Effect::Limits) is switched off |
    /// | closed loops, coupled joints | Lagrange multipliers |
    /// | the ground | rigid contact with Coulomb friction |
    /// | τ, gravity, C v | as in an explicit step of order 2 |
    ///
    /// [`StepForces::dissipation`] switches damping and friction. [`Run::losses`](crate::Run::losses) gives
    /// the energy that each dissipates.
    ///
    /// ```
    /// use robot_dynamics::description::{Limits, PassiveForces, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, RunOptions, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// // Damping for which explicit steps of 1 ms diverge (its time constant I/d is 0.17 ms), friction, and
    /// // a stop.
    /// robot.joints[0].passive = PassiveForces::default().with_damping(1000.0).with_friction(0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.004);
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).build()?;
    /// let run = simulation.run(2.0, RunOptions::new())?;
    /// assert_eq!((run.q[0], run.v[0]), (0.004, 0.0)); // at rest at the stop
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug)]
    #[doc(alias = "Implicit")]
    pub struct ImplicitIntegrator {
        joints: Joints,
        factor: StiffFactor,
        impulses: Impulses,
        losses: Losses,
        /// The losses of the last step.
        last: Losses,
        /// The losses of each tree in the last step; those of a component are stored at one of its trees.
        last_of: Vec<Losses>,
        /// The couplings between trees, and the trees that move.
        components: Components,
        drive: Option<StepActuation>,
        contacts: Option<ContactImpulses>,
        equalities: Option<Equalities>,
        /// The limits of spatial tendons.
        paths: PathStops,
        /// The number of tendons over joints.
        tendons_over_joints: usize,
        translations: FreeTranslations,
        memory: ImplicitMemory,
        record: StepRecord,
        kept: StepSnapshot,
        interrupt: Interrupt,
        /// The start of the step, if the step can be interrupted.
        begun: Option<StepSnapshot>,
        /// The start of the step with its sums of impulses at zero, if there are several trees.
        start: StepSnapshot,
        /// The number of steps that exceeded the budget of parts, and the largest error of their energy
        /// balance \[J\].
        unsettled: (usize, f64),
        /// The magnitude of gravity \[m/s²\].
        gravity: f64,
        /// The least pivot of each tree in the step, relative to M's diagonal.
        pivots: Vec<f64>,
        /// Whether the energy balance of each component fails, stored at its first tree.
        is_off: Vec<bool>,
        /// The losses of one pass, stored as [`last_of`](Self::last_of).
        lost: Vec<Losses>,
        /// q at the end of a step, and v at its start and end, of a motion of one component alone.
        alone: [Vec<f64>; 3],
    }
}

clone_in_place! {
    /// Vectors of nv entries.
    #[derive(Debug)]
    struct ImplicitMemory {
        q_rate: [Vec<f64>; 2],
        acceleration: [Vec<f64>; 2],
        force: Vec<f64>,
        stage_v: Vec<f64>,
        stage_q: Vec<f64>,
        displacement: Vec<f64>,
        /// The forces of actuation, and the friction and stop forces of the last step.
        driven: Vec<f64>,
        carried: Vec<f64>,
        /// The forces of the smooth part at both stages without C v and gravity.
        applied: Vec<f64>,
        /// The impulse of a fluid in one pass, and a product with its damping matrix.
        fluid: [Vec<f64>; 2],
        /// The packed matrix M̂.
        matrix: Vec<f64>,
        /// A configuration before one move, and before all corrections.
        before: Vec<f64>,
        uncorrected: Vec<f64>,
    }
}

impl ImplicitIntegrator {
    /// Creates a stepper for this robot. The position limits of its joints and the length limits of its
    /// tendons are stops.
    pub fn new(model: &Model) -> Self {
        let zeros = || vec![0.0; model.nv()];
        let joints = Joints::new(model);
        let mut impulses = Impulses::new(model, &joints);
        let impulses_kept = impulses.memory().clone();
        let factor = StiffFactor::new(model);
        let mut components = Components::new(factor.paths().dof_parent());
        let tendons = model.description().tendons.iter();
        let tendons: Vec<_> = tendons.map(|tendon| JointSum::of_tendon(model, tendon).row()).collect();
        components.unite(tendons.iter().map(Vec::as_slice));
        components.unite(joints.path_rows().map(|(row, _)| &joints.rows[row][..]));
        // One entry even if nothing moves.
        let trees = components.count().max(1);
        let kept = StepSnapshot::new(model, trees, impulses_kept);
        let integrator = Self {
            paths: PathStops::new(model, &joints),
            tendons_over_joints: tendons.len(),
            factor,
            start: kept.clone(),
            kept,
            interrupt: Interrupt::default(),
            begun: None,
            unsettled: (0, 0.0),
            gravity: Vector3::from(model.description().gravity).norm(),
            pivots: vec![0.0; trees],
            is_off: vec![false; trees],
            lost: vec![Losses::default(); trees],
            last_of: vec![Losses::default(); trees],
            alone: [vec![0.0; model.nq], zeros(), zeros()],
            components,
            impulses,
            joints,
            losses: Losses::default(),
            last: Losses::default(),
            drive: None,
            contacts: None,
            equalities: None,
            translations: FreeTranslations::new(model),
            record: StepRecord::default(),
            memory: ImplicitMemory {
                q_rate: [zeros(), zeros()],
                acceleration: [zeros(), zeros()],
                force: zeros(),
                stage_v: zeros(),
                stage_q: vec![0.0; model.nq()],
                displacement: zeros(),
                driven: zeros(),
                carried: zeros(),
                applied: zeros(),
                fluid: [zeros(), zeros()],
                matrix: Vec::with_capacity(usual_entries(model.nv())),
                before: vec![0.0; model.nq()],
                uncorrected: vec![0.0; model.nq()],
            },
        };
        if integrator.paths.is_empty() {
            return integrator;
        }
        // The lengths of paths are not linear in q: positions return to their limits as to equalities.
        integrator.with_equalities(model, EqualityRows::new(model, []), Vec::new())
    }

    /// Disables position limits.
    pub(crate) fn without_stops(mut self) -> Self {
        self.joints.stops.clear();
        if !self.paths.is_empty() {
            self.paths.clear();
            self.equalities = None;
        }
        self
    }
}

impl Stepper for ImplicitIntegrator {
    fn order(&self) -> u32 {
        2
    }

    /// A start must satisfy the equalities.
    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        _: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), StepError> {
        match &mut self.equalities {
            Some(equalities) => Ok(equalities.check(model, workspace, q, v)?),
            None => Ok(()),
        }
    }

    /// Damping determines the motion of a body without inertia, so M may be singular; the factorization of M̂
    /// checks its rank.
    fn check_mass(&mut self, _: &Model, _: &mut Workspace, _: &[f64]) -> Result<(), SingularMass> {
        Ok(())
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        check_step(h)?;
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        self.joints.choose(forces.dissipation);
        Ok(self.step_or_go_back(model, workspace, forces, h, (q, v))?)
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        stored_energy(&mut self.drive, q)
    }

    fn losses(&self) -> Option<Losses> {
        Some(self.losses)
    }

    fn contact_laws(&self) -> Option<ContactLaws> {
        let (unsettled, imbalance) = self.unsettled;
        let laws = self.contacts.as_ref().map(ContactImpulses::laws);
        let laws = laws.or_else(|| (unsettled > 0).then(ContactLaws::default));
        laws.map(|laws| ContactLaws { unsettled, imbalance, ..laws })
    }

    fn contact_forces(&self) -> &[[f64; 3]] {
        self.contacts.as_ref().map_or(&[], ContactImpulses::link_forces)
    }

    fn linearize(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        step: LinearizedStep<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        let out = LinearizedStepWithParameters::of_step(step);
        self.linearize_analytically(model, workspace, forces, h, state, out)
    }

    fn linearize_with_parameters(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        self.linearize_analytically(model, workspace, forces, h, state, out)
    }

    fn control_count(&self) -> usize {
        self.drive.as_ref().map_or(0, |drive| drive.actuation().control_count())
    }

    fn explicit_gains(&self, _: &Model, _: bool, _: &mut [f64], _: &mut [f64]) {}

    fn actuator_forces(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().forces)
    }

    fn actuator_torques(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().torques)
    }

    /// Records the step's losses as the scheme computes them ([`Losses`]). The imbalance of the energy
    /// account is the scheme's own error, of order 2 in steps without impacts.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        let losses = (&mut self.last, &mut self.losses);
        record(model, workspace, energy_account, transition, &mut self.drive, losses);
        if let Some(drive) = &mut self.drive {
            drive.record_forces();
        }
    }
}
