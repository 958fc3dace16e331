//! Steps that stay stable however stiff the joints are: damping and springs implicit, dry friction that sticks, stops that
//! hold.
//!
//! **Smooth part.** With y = (Θ, v), q = q₀ ⊕ Θ, and A the slope of its rate by the joints' damping D and stiffness K alone, a
//! two-stage Rosenbrock step of order 2 whatever A leaves out, L-stable in what A has (γ = 1 − 1/√2):
//! (1 − γhA)k₁ = f(y₀), (1 − γhA)k₂ = f(y₀ + hk₁) − 2k₁, y₁ = y₀ + h(3k₁ + k₂)/2. **(Verwer, Spee, Blom & Hundsdorfer 1999)**
//! Each stage solves M̂x = …, M̂ = M + γhD + γ²h²K with the M of its own configuration, on the tree's factor. (That A differs
//! from stage to stage by O(h) leaves the order; one M for both would turn a stiff joint's force into noise at its neighbours.)
//!
//! **Friction and stops.** Impulses λ at the step's end, M̂ with ½h in place of γh: v⁺ = v₁ + M̂⁻¹Eᵀλ minimises the convex
//! ½(v⁺ − v₁)ᵀM̂(v⁺ − v₁) + hΣfᵢ|v⁺ᵢ| with v⁺ᵢ ≥ 0 away from each stop that the step would pass. The answer is unique: a joint
//! sticks where |λᵢ| < hfᵢ suffices, with v⁺ᵢ = 0 and not a creeping speed. The forces of the step before act in the smooth part
//! already, and λ is what is missing: so sliding and resting keep the order. The positions take half of it,
//! q⁺ = q₁ ⊕ ½hM̂⁻¹Eᵀλ, as under a constant force; what then is still beyond a stop is put on it.

mod bounded;
mod impulses;
mod joints;
mod stiff_factor;

use dynamics::{DynamicsError, EnergyLedger, IntegratorError, check_finite};

use self::impulses::Impulses;
use self::joints::Joints;
use self::stiff_factor::StiffFactor;
use crate::model::length::check_length;
use crate::motion::integrate::check_step;
use crate::motion::simulate::{Losses, Stepper, travel};
use crate::space::displacement_rate::displacement_rate;
use crate::{
    Actuation, ActuationWorkspace, Model, SingularMass, StepForces, StepWorkspace, Workspace, bias, integrate,
};

/// γ = 1 − 1/√2: L-stable, with the smaller error of the two such values.
const GAMMA: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

/// Steps with stiff joints, dry friction and stops; a [`Stepper`] for [`Simulation`](crate::Simulation). It remembers the
/// last step's friction and the forces of stops, from which the next step starts.
///
/// | what | how it acts |
/// | --- | --- |
/// | damping, springs of joints | implicit, order 2, stable for any h |
/// | friction | sticks truly; sliding of order 2 between its turns |
/// | position limits | inelastic stops, unless taken out by [`without_stops`](Self::without_stops) |
/// | τ, gravity, C v | as in an explicit step of order 2 |
///
/// Damping and friction act where [`StepForces::dissipation`] says so. What each takes out: [`Run::losses`](crate::Run::losses).
///
/// ```
/// use multibody::{Implicit, Limits, Model, PassiveForces, Simulation, ZeroTorque, pendulum};
/// use std::ops::ControlFlow;
/// let mut robot = pendulum(2.0, 0.5);
/// // Damping that no explicit step of 1 ms survives (its own time is I/d = 0.17 ms), friction, and a stop.
/// robot.joints[0].passive = PassiveForces::default().with_damping(1000.0).with_friction(0.5);
/// robot.joints[0].limits = Limits::new(-0.2, 0.004);
/// let model = Model::new(robot)?;
/// let simulation = Simulation::new(&model, Implicit::new(&model), 1e-3);
/// let run = simulation.run(&[0.0], &[0.0], 2000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
/// assert_eq!((run.q[0], run.v[0]), (0.004, 0.0)); // it sank onto its stop and rests there
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Implicit {
    joints: Joints,
    factor: StiffFactor,
    impulses: Impulses,
    has_stops: bool,
    losses: Losses,
    /// Of the last step.
    last: Losses,
    drive: Option<Drive>,
    memory: Memory,
}

/// What drives the robot beside τ.
#[derive(Clone, Debug)]
struct Drive {
    actuation: Actuation,
    workspace: ActuationWorkspace,
    controls: Vec<f64>,
}

/// Vectors of nv entries.
#[derive(Clone, Debug)]
struct Memory {
    q_rate: [Vec<f64>; 2],
    acceleration: [Vec<f64>; 2],
    force: Vec<f64>,
    stage_v: Vec<f64>,
    stage_q: Vec<f64>,
    displacement: Vec<f64>,
    /// Forces of the drive.
    driven: Vec<f64>,
}

impl Implicit {
    /// For this robot, its position limits as stops.
    pub fn new(model: &Model) -> Self {
        let zeros = || vec![0.0; model.nv()];
        Self {
            joints: Joints::new(model),
            factor: StiffFactor::new(model),
            impulses: Impulses::new(model),
            has_stops: true,
            losses: Losses::default(),
            last: Losses::default(),
            drive: None,
            memory: Memory {
                q_rate: [zeros(), zeros()],
                acceleration: [zeros(), zeros()],
                force: zeros(),
                stage_v: zeros(),
                stage_q: vec![0.0; model.nq()],
                displacement: zeros(),
                driven: zeros(),
            },
        }
    }

    /// Position limits are not enforced.
    pub fn without_stops(self) -> Self {
        Self { has_stops: false, ..self }
    }

    /// With tendons, carried weight and actuators at these controls ([`Actuation`]), their stiffness and damping implicit.
    ///
    /// ```
    /// use multibody::{Actuation, ActuatorDescription, Implicit, Model, Simulation, Transmission, ZeroTorque, pendulum};
    /// use std::ops::ControlFlow;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(1e6, 1e5);
    /// robot.actuators.push(servo);
    /// let model = Model::new(robot)?;
    /// let implicit = Implicit::new(&model).with_actuation(&Actuation::new(&model)?, &[0.4]);
    /// let run = Simulation::new(&model, implicit, 1e-2)
    ///     .run(&[0.0], &[0.0], 200, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    /// assert!((run.q[0] - 0.4).abs() < 1e-5); // no explicit step of 10 ms survives these gains
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If there is not one control for each actuator.
    #[track_caller]
    pub fn with_actuation(mut self, actuation: &Actuation, controls: &[f64]) -> Self {
        check_length("the controls", controls.len(), actuation.control_count());
        self.joints.add_gains(actuation);
        let workspace = actuation.workspace();
        self.drive = Some(Drive { actuation: actuation.clone(), workspace, controls: controls.to_vec() });
        self
    }

    /// The smooth part: leaves Θ in `memory.displacement` and v₁ in `memory.stage_v`.
    fn smooth(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), DynamicsError> {
        let Self { joints, factor, impulses, drive, memory, .. } = self;
        let carried = impulses.carried();
        let Memory {
            q_rate: [q1, q2],
            acceleration: [a1, a2],
            force,
            stage_v,
            stage_q,
            displacement,
            driven,
        } = memory;
        let mut drive_at = |q: &[f64], v: &[f64], driven: &mut [f64]| {
            if let Some(Drive { actuation, workspace, controls }) = drive {
                actuation.forces(model, workspace, controls, q, v, driven);
            }
        };
        let (nv, g) = (v.len(), GAMMA * h);
        factor.factor(model, workspace, q, joints, g)?;
        // M̂ k₁ᵥ = τ − Cv − g − Dv − γhKv; k₁Θ = v + γh k₁ᵥ.
        bias(model, workspace, q, v, force);
        drive_at(q, v, driven);
        for k in 0..nv {
            let applied = tau[k] + driven[k] + carried[k] - force[k] - joints.damping[k] * v[k];
            a1[k] = applied - g * joints.slopes(k).0 * v[k];
        }
        factor.solve(a1);
        for k in 0..nv {
            q1[k] = v[k] + g * a1[k];
            displacement[k] = h * q1[k];
            stage_v[k] = v[k] + h * a1[k];
        }
        // There: M̂ k₂ᵥ = M v̇ − 2M k₁ᵥ − γhK(Θ̇ − 2k₁Θ); k₂Θ = Θ̇ − 2k₁Θ + γh k₂ᵥ.
        integrate(model, q, displacement, stage_q);
        displacement_rate(model, displacement, stage_v, q2);
        factor.factor(model, workspace, stage_q, joints, g)?;
        bias(model, workspace, stage_q, stage_v, force);
        drive_at(stage_q, stage_v, driven);
        factor.multiply_mass(a1, a2);
        for k in 0..nv {
            q2[k] -= 2.0 * q1[k];
            let applied = tau[k] + driven[k] + carried[k] - force[k] - joints.damping[k] * stage_v[k];
            a2[k] = applied - 2.0 * a2[k] - g * joints.slopes(k).0 * q2[k];
        }
        factor.solve(a2);
        for k in 0..nv {
            q2[k] += g * a2[k];
            displacement[k] = 0.5 * h * (3.0 * q1[k] + q2[k]);
            stage_v[k] = v[k] + 0.5 * h * (3.0 * a1[k] + a2[k]);
        }
        Ok(())
    }
}

impl Stepper for Implicit {
    type Error = IntegratorError;

    fn order(&self) -> u32 {
        2
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
        self.last = Losses::default();
        let dynamics = &mut workspace.dynamics;
        if self.advance(model, dynamics, forces.tau, h, (q, v), Whole::OrNothing)? {
            return Ok(());
        }
        for _ in 0..PARTS {
            self.advance(model, dynamics, forces.tau, h / f64::from(PARTS), (q, v), Whole::AsItIs)?;
        }
        Ok(())
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        match &mut self.drive {
            Some(drive) => drive.actuation.stored_energy(&mut drive.workspace, q),
            None => 0.0,
        }
    }

    fn losses(&self) -> Option<Losses> {
        Some(self.losses)
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
        let (kinetic, potential) = travel(model, workspace, from, to, h);
        let StepWorkspace { displacement: way, q: middle, .. } = workspace;
        let mut work: f64 = forces.tau.iter().zip(&*way).map(|(tau, way)| tau * way).sum();
        let mut stored = 0.0;
        if let Some(Drive { actuation, workspace, controls }) = &mut self.drive {
            // The impulse of forces that are linear in q and v, hf(q̄, Δq/h), times the mean velocity.
            let Memory { stage_v: mean, displacement: half, driven, .. } = &mut self.memory;
            for k in 0..way.len() {
                half[k] = 0.5 * way[k];
                mean[k] = 0.5 * (from.1[k] + to.1[k]);
                way[k] /= h;
            }
            integrate(model, from.0, half, middle);
            actuation.input(model, workspace, controls, (middle, way), driven);
            work += h * driven.iter().zip(&*mean).map(|(tau, v)| tau * v).sum::<f64>();
            self.last.damping += actuation.dissipated_over(h, way, mean);
            stored = actuation.stored_energy(workspace, to.0);
        }
        self.losses.add(&self.last);
        let dissipated = ledger.dissipated() + self.last.total();
        ledger.enter(kinetic, potential + stored, ledger.work() + work, dissipated);
    }
}

/// A step in which a joint meets a stop is taken again in so many parts: what acts before the impact and after it differs.
const PARTS: u32 = 16;

/// Whether a step that ends beyond a stop may be taken as it is.
#[derive(Clone, Copy, PartialEq)]
enum Whole {
    OrNothing,
    AsItIs,
}

impl Implicit {
    /// A step of h; or, where a stop is met in it and that is asked for, none: false then.
    fn advance(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
        whole: Whole,
    ) -> Result<bool, IntegratorError> {
        self.smooth(model, workspace, tau, h, (q, v))?;
        let Self { joints, factor, impulses, memory, .. } = self;
        let Memory { force: change, stage_v: v1, stage_q: q1, displacement, .. } = memory;
        let mut by_impulses = Losses::default();
        let may_act = joints.has_friction() || (self.has_stops && joints.has_stops()) || impulses.acts();
        if may_act {
            integrate(model, q, displacement, q1);
            let stops = if self.has_stops { &joints.stops[..] } else { &[] };
            let is_new = |stop: &joints::Stop| stop.gap(q) > 0.0 && stop.gap(q1) < 0.0;
            if whole == Whole::OrNothing && stops.iter().any(is_new) {
                return Ok(false);
            }
            // For impulses g = ½h: their positions are ½h of their velocities, so that damping takes from them what it books.
            factor.stiffen(joints, 0.5 * h)?;
            let met = impulses.solve(factor, joints, stops, h, (q, q1, v1), change)?;
            if met {
                for k in 0..v.len() {
                    v1[k] += change[k];
                    displacement[k] += 0.5 * h * change[k];
                }
                impulses.rest(v, v1, displacement);
                by_impulses = impulses.account(joints, h, v, v1);
            }
        }
        // ∫Dv·v dt as the impulse D∫v dt times the mean velocity: what the step's momentum lost of energy.
        let damping: f64 =
            (0..v.len()).map(|k| joints.damping[k] * displacement[k] * 0.5 * (v[k] + v1[k])).sum();
        // Where stiff damping overshot, friction has the wrong sign over the step: that is taken from damping.
        let overshot = by_impulses.friction.min(0.0) + by_impulses.stops.min(0.0);
        let damping = damping + overshot;
        self.last.damping += if joints.adds_energy { damping } else { damping.max(0.0) };
        self.last.friction += by_impulses.friction.max(0.0);
        self.last.stops += by_impulses.stops.max(0.0);
        check_finite("v after the step", v1)?;
        integrate(model, q, displacement, q1);
        if may_act && self.has_stops {
            impulses.put_on_stops(factor, &joints.stops, h, (q, q1), change, |way, from, to| {
                integrate(model, from, way, to);
            })?;
        }
        check_finite("q after the step", q1)?;
        q.copy_from_slice(q1);
        v.copy_from_slice(v1);
        Ok(true)
    }
}
