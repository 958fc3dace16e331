//! External torques from the momentum, without accelerations.

use std::borrow::Borrow;

use robot_dynamics_core::configuration::configuration_rate::configuration_rate;
use robot_dynamics_core::{Model, Workspace, bias, check_configuration, check_vector, dissipation, momentum};
use robot_dynamics_number::{Dual, InvalidInput, check_positive, check_result};
use robot_dynamics_simulation::ControllerError;

/// The momentum observer: an estimate r of the external torque τ_ext, such as that of a collision, from
/// (q, v) and the motors' torque. It needs no acceleration.
///
/// > ṙ = K (τ_ext − r),  τ_ext = ṗ − β − τ,  p = M v,  β = Ṁ v − C v − g
///
/// r is τ_ext through a filter of first order with the time constant 1/K. From one sample to the next, after
/// the time h,
///
/// > r ← e^(−K h) r + (1 − e^(−K h)) ((p − p₋)/h − ½ (β + β₋) − τ),
///
/// where τ was held in between. This is exact for a constant τ_ext, but for the trapezoidal rule of β, and
/// stable for any K h. The part of a wrench f at a frame is Jᵀf. [`OperationalSpace::consistent_inverse`]
/// returns it: f = J̄ᵀr. Forces that the robot's rows do not contain belong to τ_ext: friction of the joints
/// (unless [`with_dissipation`](Self::with_dissipation) is called), contacts, closed loops, and errors of the
/// masses.
///
/// Source: De Luca, Mattone, *Sensorless robot collision detection and hybrid force/motion control*, ICRA
/// (2005).
///
/// ```
/// use robot_dynamics::control::MomentumObserver;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut observer = MomentumObserver::new(&model, &[50.0])?.with_thresholds(&[1.0])?;
/// // The rod hangs still although no motor works: something holds it with g, up to e^(−50 t).
/// let weight = model.gravity_forces(&[0.3])?[0];
/// for _ in 0..200 {
///     observer.update(&[0.3], &[0.0], &[0.0], 1e-3)?;
/// }
/// assert!((observer.external_torque()[0] - weight * (1.0 - f64::exp(-50.0 * 0.199))).abs() < 1e-12);
/// assert_eq!(observer.collision(), Some(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// [`OperationalSpace::consistent_inverse`]: crate::OperationalSpace::consistent_inverse
#[derive(Clone, Debug)]
pub struct MomentumObserver<M> {
    model: M,
    workspace: Workspace,
    gains: Vec<f64>,
    thresholds: Vec<f64>,
    with_dissipation: bool,
    /// r.
    residual: Vec<f64>,
    /// p and β at the last sample, if there was one.
    has_sample: bool,
    momentum: Vec<f64>,
    drift: Vec<f64>,
    /// p and β at this sample.
    new_momentum: Vec<f64>,
    new_drift: Vec<f64>,
    friction: Vec<f64>,
    along: AlongMotion,
}

/// Memory for p and Ṁ v: q with its rate, v as a constant, and p with its rate at constant v.
#[derive(Clone, Debug)]
struct AlongMotion {
    workspace: Workspace<Dual<f64, 1>>,
    configuration_rate: Vec<f64>,
    q: Vec<Dual<f64, 1>>,
    v: Vec<Dual<f64, 1>>,
    momentum: Vec<Dual<f64, 1>>,
}

impl AlongMotion {
    fn new(model: &Model) -> Self {
        let zeros = |count| vec![Dual::constant(0.0); count];
        Self {
            workspace: Workspace::new(model),
            configuration_rate: vec![0.0; model.nq()],
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            momentum: zeros(model.nv()),
        }
    }

    /// p and Ṁ v of each coordinate.
    fn momentum(&mut self, model: &Model, q: &[f64], v: &[f64]) -> impl Iterator<Item = (f64, f64)> {
        configuration_rate(model, q, v, &mut self.configuration_rate);
        for ((dual, q), rate) in self.q.iter_mut().zip(q).zip(&self.configuration_rate) {
            *dual = Dual { value: *q, gradient: [*rate] };
        }
        self.v.iter_mut().zip(v).for_each(|(dual, v)| *dual = Dual::constant(*v));
        momentum(model, &mut self.workspace, &self.q, &self.v, &mut self.momentum);
        self.momentum.iter().map(|dual| (dual.value, dual.gradient[0]))
    }
}

impl<M: Borrow<Model>> MomentumObserver<M> {
    /// An observer with the gains K \[1/s\], nv entries. The model is an `Arc<Model>`, a `Model`, or a
    /// reference.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if the length is wrong, or a gain is not positive and finite.
    pub fn new(robot: M, gains: &[f64]) -> Result<Self, ControllerError> {
        let model: &Model = robot.borrow();
        check_vector(model, "the gains of the observer", gains)?;
        for gain in gains {
            check_positive("a gain of the observer", *gain, "1/s")?;
        }
        let (nv, workspace, along) = (model.nv(), Workspace::new(model), AlongMotion::new(model));
        let zeros = || vec![0.0; nv];
        Ok(Self {
            model: robot,
            workspace,
            gains: gains.to_vec(),
            thresholds: vec![f64::INFINITY; nv],
            with_dissipation: false,
            residual: zeros(),
            has_sample: false,
            momentum: zeros(),
            drift: zeros(),
            new_momentum: zeros(),
            new_drift: zeros(),
            friction: zeros(),
            along,
        })
    }

    /// Counts the damping and friction of the model's joints as known.
    #[must_use]
    pub fn with_dissipation(mut self) -> Self {
        self.with_dissipation = true;
        self
    }

    /// Sets the |r| above which a coordinate counts as in collision; nv entries \[N·m or N\], infinite
    /// without one.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if the length is wrong, or a threshold is negative or NaN.
    pub fn with_thresholds(mut self, thresholds: &[f64]) -> Result<Self, ControllerError> {
        if thresholds.len() != self.gains.len() {
            check_vector(self.model.borrow(), "the thresholds", thresholds)?;
        }
        if let Some(bad) = thresholds.iter().find(|threshold| threshold.is_nan() || **threshold < 0.0) {
            return Err(InvalidInput::out_of_range("a threshold", *bad, "", "zero or positive").into());
        }
        self.thresholds.copy_from_slice(thresholds);
        Ok(self)
    }

    /// Takes the state of this sample, the motors' torque τ since the last sample, and the time h \[s\] since
    /// then. Returns r. The first sample only stores the state. It does not allocate.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if an argument is invalid, or a result overflows. The observer then keeps
    /// its state.
    pub fn update(&mut self, q: &[f64], v: &[f64], tau: &[f64], h: f64) -> Result<&[f64], ControllerError> {
        let model: &Model = self.model.borrow();
        check_configuration(model, q)?;
        check_vector(model, "v", v)?;
        check_vector(model, "tau", tau)?;
        check_positive("the time since the last sample", h, "s")?;
        let nv = model.nv();
        bias(model, &mut self.workspace, q, v, &mut self.new_drift);
        for (k, (momentum, change)) in self.along.momentum(model, q, v).enumerate() {
            self.new_momentum[k] = momentum;
            self.new_drift[k] = change - self.new_drift[k];
        }
        if self.with_dissipation {
            dissipation(model, v, &mut self.friction);
            self.new_drift.iter_mut().zip(&self.friction).for_each(|(drift, friction)| *drift -= friction);
        }
        check_result("the momentum", &self.new_momentum)?;
        check_result("the rate of the momentum", &self.new_drift)?;
        if self.has_sample {
            for k in 0..nv {
                let known = 0.5 * (self.drift[k] + self.new_drift[k]) + tau[k];
                let external = (self.new_momentum[k] - self.momentum[k]) / h - known;
                let share = -(-self.gains[k] * h).exp_m1();
                self.residual[k] += share * (external - self.residual[k]);
            }
        }
        core::mem::swap(&mut self.momentum, &mut self.new_momentum);
        core::mem::swap(&mut self.drift, &mut self.new_drift);
        self.has_sample = true;
        Ok(&self.residual)
    }

    /// r, nv entries \[N·m or N\].
    pub fn external_torque(&self) -> &[f64] {
        &self.residual
    }

    /// The coordinate with the largest |r| relative to its threshold, if it is above it.
    pub fn collision(&self) -> Option<usize> {
        let ratio = |k: usize| self.residual[k].abs() / self.thresholds[k];
        (0..self.residual.len()).filter(|&k| ratio(k) > 1.0).max_by(|&i, &j| ratio(i).total_cmp(&ratio(j)))
    }

    /// Sets r = 0 and forgets the last sample.
    pub fn reset(&mut self) {
        self.residual.fill(0.0);
        self.has_sample = false;
    }
}
