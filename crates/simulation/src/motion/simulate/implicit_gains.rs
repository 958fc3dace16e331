//! Control laws whose gains act at the end of the control period.

use std::borrow::Borrow;

use robot_dynamics_core::{Model, Workspace, bias, check_vector, inverse_dynamics};
use robot_dynamics_description::check_length;
use robot_dynamics_number::{InvalidInput, check_positive};

use super::control_error::singular_mass;
use super::{Controller, ControllerError, check_controller_input, check_torque};
use crate::motion::integrate::MassFactor;

/// The gains K = −∂τ/∂q and D = −∂τ/∂v of a control law, applied at the end of the period h in which its
/// torque is held:
///
/// > τ = τ₀ − K h (v + h a) − D h a,  (M + h D + h² K) a = τ₀ − C v − g − h K v
///
/// τ₀ is the torque of the law at (q, v). A robot that is held by τ for h then moves as under the linearly
/// implicit Euler method, which is stable for any K and D. With explicit gains the limit is about h <
/// 2/√(K/M) for K, and h < 2 M/D for D. An external force does not enter the prediction of a. The cost is
/// that of M and of its factor.
///
/// Source: Tan, Liu, Turk, *Stable proportional-derivative controllers*, IEEE Computer Graphics and
/// Applications 31 (2011).
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// use robot_dynamics::simulation::ImplicitGains;
/// let model = Model::new(pendulum(2.0, 0.5))?; // the moment of inertia is 0.5 kg m²
/// let (q, v, h) = ([0.2], [0.3], 0.01);
/// let (k, d) = (1e6, 10.0);
/// let mut gains = ImplicitGains::new(&model, &[k], &[d], h)?;
/// let mut tau = [-k * q[0] - d * v[0]]; // the law at the present state
/// gains.apply(&model, &mut Workspace::new(&model), &q, &v, &mut tau)?;
/// // −K q − D v at the end of the period, with the velocity that the torque itself leads to:
/// let a = model.forward_dynamics(&q, &v, &tau)?[0];
/// let end = v[0] + h * a;
/// assert!((tau[0] - (-k * (q[0] + h * end) - d * end)).abs() < 1e-9 * k);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ImplicitGains {
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    period: f64,
    mass: MassFactor,
    acceleration: Vec<f64>,
    force: Vec<f64>,
}

impl ImplicitGains {
    /// The diagonals of K \[N·m/rad or N/m\] and D, nv entries each, which are not negative, and the period
    /// h \[s\]. Entries of coordinates without a motor ([`Model::actuated_dofs`]) are ignored.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if a length is wrong, a gain is negative or not finite, or h is not
    /// positive.
    pub fn new(
        model: &Model,
        stiffness: &[f64],
        damping: &[f64],
        period: f64,
    ) -> Result<Self, ControllerError> {
        check_positive("the control period", period, "s")?;
        let nv = model.nv();
        let mut gains = Self {
            stiffness: vec![0.0; nv],
            damping: vec![0.0; nv],
            period,
            mass: MassFactor::new(model),
            acceleration: vec![0.0; nv],
            force: vec![0.0; nv],
        };
        gains.set(model, stiffness, damping)?;
        Ok(gains)
    }

    /// Replaces K and D, for gains that vary in time.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn set(&mut self, model: &Model, stiffness: &[f64], damping: &[f64]) -> Result<(), ControllerError> {
        let driven = model.actuated_dofs();
        for (name, given, own) in
            [("the stiffness", stiffness, &mut self.stiffness), ("the damping", damping, &mut self.damping)]
        {
            check_vector(model, name, given)?;
            if let Some(bad) = given.iter().find(|gain| **gain < 0.0) {
                return Err(InvalidInput::out_of_range(name, *bad, "", "zero or positive").into());
            }
            let own = own.iter_mut().zip(given).zip(driven);
            own.for_each(|((own, given), driven)| *own = if *driven { *given } else { 0.0 });
        }
        Ok(())
    }

    /// τ ← the torque with implicit gains, from τ₀ of the law at (q, v). Coordinates with K = D = 0 keep
    /// theirs. It does not allocate.
    ///
    /// # Errors
    /// [`ControllerError`] if M is singular, or τ is not finite.
    ///
    /// # Panics
    /// Panics if a slice has the wrong length.
    #[track_caller]
    pub fn apply(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        let Self { stiffness, damping, period: h, mass, acceleration, force } = self;
        check_length("tau", tau.len(), model.nv());
        check_torque(tau)?;
        bias(model, workspace, q, v, force);
        for k in 0..tau.len() {
            acceleration[k] = tau[k] - force[k] - *h * stiffness[k] * v[k];
        }
        let added = |k: usize| *h * (damping[k] + *h * stiffness[k]);
        if mass.factor_sum(model, workspace, q, added).is_err() {
            return Err(singular_mass(model, q));
        }
        mass.solve(acceleration);
        // τ = M a + C v + g; the sum in the definition would cancel large numbers for stiff gains.
        inverse_dynamics(model, workspace, q, v, acceleration, force);
        for k in (0..tau.len()).filter(|&k| stiffness[k] > 0.0 || damping[k] > 0.0) {
            tau[k] = force[k];
        }
        Ok(check_torque(tau)?)
    }
}

/// A control law with [`ImplicitGains`]: stable at any stiffness, whoever wrote it.
///
/// The law returns its torque at the present state, not clipped. The result is clipped at the joints' effort
/// limits, or at those of [`with_limits`](Self::with_limits). For the library's own PD law see
/// [`GravityCompensatedPd::with_implicit_gains`](super::GravityCompensatedPd::with_implicit_gains).
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Integrator, Method, RunOptions, SimulationBuilder, WithImplicitGains};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (k, d, h) = (1e7, 100.0, 1e-3); // explicit gains diverge with h > 0.4 ms
/// let law = |_t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| tau[0] = -k * (q[0] - 0.5) - d * v[0];
/// let mut law = WithImplicitGains::new(&model, law, &[k], &[d], h)?;
/// let mut simulation = SimulationBuilder::new(&model).method(Method::Fixed(Integrator::RungeKutta4)).dt(h).build()?;
/// let run = simulation.run_from(&[0.0], &[0.0], 1.0, RunOptions::new().controller(&mut law))?;
/// assert!((run.q[0] - 0.5).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WithImplicitGains<M, C> {
    model: M,
    law: C,
    gains: ImplicitGains,
    limits: Vec<f64>,
    workspace: Workspace,
}

impl<M: Borrow<Model>, C: Controller> WithImplicitGains<M, C> {
    /// A law with its gains K = −∂τ/∂q and D = −∂τ/∂v, and the period h \[s\] in which the torque is held.
    /// The model is an `Arc<Model>`, a `Model`, or a reference.
    ///
    /// # Errors
    /// As [`ImplicitGains::new`].
    pub fn new(
        robot: M,
        law: C,
        stiffness: &[f64],
        damping: &[f64],
        period: f64,
    ) -> Result<Self, ControllerError> {
        let model: &Model = robot.borrow();
        Ok(Self {
            law,
            gains: ImplicitGains::new(model, stiffness, damping, period)?,
            limits: model.coordinate_limits().iter().map(|limits| limits.effort).collect(),
            workspace: Workspace::new(model),
            model: robot,
        })
    }

    /// Replaces the joints' effort limits; nv entries \[N·m or N\], infinite without a limit.
    ///
    /// # Panics
    /// Panics if the length is wrong, or a limit is negative or NaN.
    #[must_use]
    #[track_caller]
    pub fn with_limits(mut self, limits: &[f64]) -> Self {
        set_limits(&mut self.limits, limits);
        self
    }
}

impl<M: Borrow<Model>, C: Controller> Controller for WithImplicitGains<M, C> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        let model: &Model = self.model.borrow();
        check_controller_input(model, t, q, v)?;
        self.law.torque(t, q, v, tau)?;
        self.gains.apply(model, &mut self.workspace, q, v, tau)?;
        tau.iter_mut().zip(&self.limits).for_each(|(tau, limit)| *tau = tau.clamp(-limit, *limit));
        Ok(())
    }
}

/// Replaces effort limits by given ones, none of which is negative.
#[track_caller]
pub fn set_limits(own: &mut [f64], limits: &[f64]) {
    check_length("the limits", limits.len(), own.len());
    assert!(limits.iter().all(|&limit| limit >= 0.0), "limits must not be negative, got {limits:?}");
    own.copy_from_slice(limits);
}
