//! Steps that stay stable however stiff the joints are: damping and springs implicit, dry friction that sticks, stops that
//! hold.
//!
//! **Smooth part.** Of order 2, from one M, that of the middle qₘ = q₀ ⊕ ½hv₀, and the forces there; so it is the leapfrog where these do not depend on v.
//! With q = q₀ ⊕ Θ, D and K the joints' damping and stiffness, and M v̇ = f(v) − K(Θ − ½hv₀), Θ̇ = v + ½\[Θ,v\] + …, f(v) = τ − Cv − g − Dv at qₘ, a two-stage
//! Rosenbrock step whatever A leaves out, L-stable in what A has, D and K (γ = 1 − 1/√2):
//! (1 − γhA)k₁ = F(y₀), (1 − γhA)k₂ = F(y₀ + hk₁) − 2k₁, y₁ = y₀ + h(3k₁ + k₂)/2. **(Verwer, Spee, Blom & Hundsdorfer 1999)**
//! Each stage solves M̂x = …, M̂ = M + γhD + γ²h²K, on the tree's factor, which serves both. (With a stage at either end M would not be the one that
//! a stiff joint's forces are balanced by, and the difference of the two be noise at its neighbours.)
//!
//! **Friction and stops.** Impulses λ at the step's end, M̂ with ½h in place of γh: v⁺ = v₁ + M̂⁻¹Eᵀλ minimises the convex
//! ½(v⁺ − v₁)ᵀM̂(v⁺ − v₁) + hΣfᵢ|v⁺ᵢ| with v⁺ᵢ ≥ 0 away from each stop that the step would pass. The answer is unique: a joint
//! sticks where |λᵢ| < hfᵢ suffices, with v⁺ᵢ = 0 and not a creeping speed. The forces of the step before act in the smooth part
//! already, and λ is what is missing: so sliding and resting keep the order. The positions take half of it,
//! q⁺ = q₁ ⊕ ½hM̂⁻¹Eᵀλ, as under a constant force; what then is still beyond a stop is put on it.

mod advance;
mod bounded;
mod contacts;
mod divided;
mod equalities;
mod impulses;
mod interruption;
mod joints;
mod kept;
mod momentum;
mod parts;
mod pivots;
mod positions;
mod smooth;
mod stiff_factor;

use dynamics::{EnergyLedger, IntegratorError};
use nalgebra::Vector3;

use self::equalities::Equalities;
use self::impulses::Impulses;
use self::joints::Joints;
use self::kept::Kept;
use self::momentum::FreeTranslations;
use self::stiff_factor::StiffFactor;
use crate::clone_in_place::clone_in_place;
use crate::contact::{Components, ContactImpulses, Interrupt};
use crate::factor::paths::usual_entries;
use crate::model::length::check_length;
use crate::motion::drive::{Drive, record};
use crate::motion::integrate::check_step;
use crate::motion::simulate::{Losses, Stepper};
use crate::space::joint_sum::JointSum;
use crate::{Actuation, ContactLaws, Model, SingularMass, StepForces, StepWorkspace, Workspace};

clone_in_place! {
    /// Steps with stiff joints, dry friction and stops; a [`Stepper`], by which a [`Simulation`](crate::simulator::Simulation) takes the steps of
    /// [`Method::Implicit`](crate::simulator::Method::Implicit), with all else that the description states. It remembers the
    /// last step's friction and the forces of stops, from which the next step starts.
    ///
    /// | what | how it acts |
    /// | --- | --- |
    /// | damping, springs of joints | implicit, order 2, stable for any h |
    /// | friction of joints and tendons | sticks truly; sliding of order 2 between its turns |
    /// | limits of positions, of ball joints' angles, and of tendons' lengths | inelastic stops, unless [`Effect::Limits`](crate::simulator::Effect::Limits) is switched off |
    /// | closed loops, coupled joints | held by multipliers, where there are some |
    /// | the ground | rigid contact with Coulomb's friction, where there is one |
    /// | τ, gravity, C v | as in an explicit step of order 2 |
    ///
    /// Damping and friction act where [`StepForces::dissipation`] says so. What each takes out: [`Run::losses`](crate::Run::losses).
    ///
    /// ```
    /// use multibody::{Limits, Model, PassiveForces, pendulum};
    /// use multibody::simulator::{Method, RunOptions, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// // Damping that no explicit step of 1 ms survives (its own time is I/d = 0.17 ms), friction, and a stop.
    /// robot.joints[0].passive = PassiveForces::default().with_damping(1000.0).with_friction(0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.004);
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).build()?;
    /// let run = simulation.run(2000, RunOptions::new())?;
    /// assert_eq!((run.q[0], run.v[0]), (0.004, 0.0)); // it sank onto its stop and rests there
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug)]
    pub struct Implicit {
        joints: Joints,
        factor: StiffFactor,
        impulses: Impulses,
        has_stops: bool,
        losses: Losses,
        /// Of the last step.
        last: Losses,
        /// The same of each tree, those of a component at one of its trees.
        last_of: Vec<Losses>,
        /// What joins trees, and which of them move.
        components: Components,
        drive: Option<Drive>,
        contacts: Option<ContactImpulses>,
        equalities: Option<Equalities>,
        translations: FreeTranslations,
        memory: Memory,
        kept: Kept,
        interrupt: Interrupt,
        /// Where the step began, if it can be interrupted.
        begun: Option<Kept>,
        /// Where it began with its sums of impulses at zero, if there are several trees.
        start: Kept,
        /// Steps whose budget of parts was spent, and the most energy that their books miss \[J\].
        unsettled: (usize, f64),
        /// \[m/s²\]
        gravity: f64,
        /// The least pivot of each tree in the step, in parts of M's diagonal.
        pivots: Vec<f64>,
        /// Whether the energy balance of each component does not close, at its first tree.
        is_off: Vec<bool>,
        /// Losses of one pass, as [`last_of`](Self::last_of).
        lost: Vec<Losses>,
        /// q where a step ends, v where it begins and ends, of a motion of one component alone.
        alone: [Vec<f64>; 3],
    }
}

clone_in_place! {
    /// Vectors of nv entries.
    #[derive(Debug)]
    struct Memory {
        q_rate: [Vec<f64>; 2],
        acceleration: [Vec<f64>; 2],
        force: Vec<f64>,
        stage_v: Vec<f64>,
        stage_q: Vec<f64>,
        displacement: Vec<f64>,
        /// Forces of the drive, and those that go on from the step before.
        driven: Vec<f64>,
        carried: Vec<f64>,
        /// The forces of the smooth part at both stages, but for C v and gravity.
        applied: Vec<f64>,
        /// M̂, packed.
        matrix: Vec<f64>,
        /// A configuration before it is moved, and before all that is moved back.
        before: Vec<f64>,
        uncorrected: Vec<f64>,
    }
}

impl Implicit {
    /// For this robot, the position limits of its joints and the limits of its tendons' lengths as stops.
    pub fn new(model: &Model) -> Self {
        let zeros = || vec![0.0; model.nv()];
        let joints = Joints::new(model);
        let mut impulses = Impulses::new(model, &joints);
        let impulses_kept = impulses.memory().clone();
        let factor = StiffFactor::new(model);
        let mut components = Components::new(factor.paths().carrier());
        let tendons = model.description().tendons.iter().map(|tendon| {
            let terms = tendon.terms.iter().map(|(joint, factor)| (joint.as_str(), *factor));
            JointSum::new(model, 0.0, terms).row()
        });
        let tendons: Vec<_> = tendons.collect();
        components.unite(tendons.iter().map(Vec::as_slice));
        // One, where nothing moves.
        let trees = components.count().max(1);
        let kept = Kept::new(model, trees, impulses_kept);
        Self {
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
            has_stops: true,
            losses: Losses::default(),
            last: Losses::default(),
            drive: None,
            contacts: None,
            equalities: None,
            translations: FreeTranslations::new(model),
            memory: Memory {
                q_rate: [zeros(), zeros()],
                acceleration: [zeros(), zeros()],
                force: zeros(),
                stage_v: zeros(),
                stage_q: vec![0.0; model.nq()],
                displacement: zeros(),
                driven: zeros(),
                carried: zeros(),
                applied: zeros(),
                matrix: Vec::with_capacity(usual_entries(model.nv())),
                before: vec![0.0; model.nq()],
                uncorrected: vec![0.0; model.nq()],
            },
        }
    }

    /// Position limits are not enforced.
    pub(crate) fn without_stops(self) -> Self {
        Self { has_stops: false, ..self }
    }

    /// With tendons, carried weight and actuators at these controls ([`Actuation`]), their stiffness and damping implicit.
    ///
    /// # Panics
    /// If there is not one control for each actuator.
    #[track_caller]
    pub(crate) fn with_actuation(mut self, actuation: &Actuation, controls: &[f64]) -> Self {
        self.joints.add_gains(actuation);
        self.factor.couple(self.joints.couplings());
        self.components.unite(self.joints.couplings().iter().map(|coupling| &coupling.row[..]));
        self.resize_trees();
        let actuation = actuation.clone().without_tendon_friction();
        self.drive = Some(Drive::new(self.memory.force.len(), &actuation, controls));
        self
    }

    /// Holds these controls from now on, if there are actuators.
    #[track_caller]
    pub(crate) fn set_controls(&mut self, controls: &[f64]) {
        if let Some(drive) = &mut self.drive {
            drive.set_controls(controls);
        }
    }
}

impl Stepper for Implicit {
    type Error = IntegratorError;

    fn order(&self) -> u32 {
        2
    }

    /// A start must be on the equalities, where there are some.
    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        _: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), IntegratorError> {
        match &mut self.equalities {
            Some(equalities) => equalities.check(model, workspace, q, v),
            None => Ok(()),
        }
    }

    /// Damping moves what has no inertia, so that M need not have an inverse; M̂ is looked at where it is factored.
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
    ) -> Result<(), IntegratorError> {
        check_step(h)?;
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        self.joints.choose(forces.dissipation);
        self.step_or_go_back(model, workspace, forces, h, (q, v))
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.drive.as_mut().map_or(0.0, |drive| drive.stored_energy(q))
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

    fn explicit_gains(&self, _: &Model, _: bool, _: &mut [f64], _: &mut [f64]) {}

    fn actuator_forces(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().forces)
    }

    fn actuator_torques(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().torques)
    }

    /// The step's losses as the scheme has them ([`Losses`]); its own error is the books' imbalance, of order 2 where no stop is
    /// met.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        ledger: &mut EnergyLedger,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) {
        let books = (&mut self.last, &mut self.losses);
        record(model, workspace, ledger, [from, to], (forces, h), &mut self.drive, books);
        if let Some(drive) = &mut self.drive {
            drive.note_step();
        }
    }
}
