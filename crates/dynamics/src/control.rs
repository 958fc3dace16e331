//! Holding a pose: PD control with gravity compensation and torque limits.

use nalgebra::SVector;
use robot_dynamics_integrators::{IntegratorError, check_computed};
use robot_dynamics_number::check_finite;

use crate::{Dynamics, rk4_step};

/// The torque limits of the `Reach` arm, joint 1 and joint 2 \[N·m\].
pub const REACH_TORQUE_LIMITS: SVector<f64, 2> = SVector::<f64, 2>::new(20.0, 12.0);

/// τ = g(q\*) + Kp (q\*−q) − Kd q̇ with diagonal gains, each joint cut off at its limit. **(MLS §4.5; MR
/// §11.4)**
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdHold<const N: usize> {
    /// q\* \[rad or m\].
    pub target: SVector<f64, N>,
    /// The diagonal of Kp \[N·m/rad or N/m\].
    pub stiffness: SVector<f64, N>,
    /// The diagonal of Kd \[N·m·s/rad or N·s/m\].
    pub damping: SVector<f64, N>,
    /// The largest |τ| of each joint \[N·m or N\]; infinity for no limit.
    pub limits: SVector<f64, N>,
}

impl<const N: usize> PdHold<N> {
    /// τ before the limits.
    pub fn demand<D: Dynamics<N> + ?Sized>(
        &self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
    ) -> SVector<f64, N> {
        system.gravity(&self.target) + self.stiffness.component_mul(&(self.target - q))
            - self.damping.component_mul(qd)
    }

    /// τ with every joint cut off at ± its limit.
    ///
    /// # Panics
    /// If a limit is negative or NaN.
    pub fn torque<D: Dynamics<N> + ?Sized>(
        &self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
    ) -> SVector<f64, N> {
        let demand = self.demand(system, q, qd);
        SVector::from_fn(|i, _| {
            let limit = self.limits[i];
            assert!(limit >= 0.0, "the torque limit of joint {i} must not be negative, got {limit}");
            demand[i].clamp(-limit, limit)
        })
    }

    /// The joints whose limit is below |g(q\*)|; with any of them the pose cannot be held.
    pub fn overloaded_joints<D: Dynamics<N> + ?Sized>(&self, system: &D) -> Vec<usize> {
        let weight = system.gravity(&self.target);
        (0..N).filter(|&i| weight[i].abs() > self.limits[i]).collect()
    }

    /// ζᵢ = Kdᵢ / (2 √(Kpᵢ Mᵢᵢ)) at q: joint i as an oscillator with the other joints at rest.
    ///
    /// Below 1 it oscillates, at 1 it is critically damped. Kp and Kd are constant, but Mᵢᵢ depends on the
    /// pose.
    pub fn damping_ratio<D: Dynamics<N> + ?Sized>(&self, system: &D, q: &SVector<f64, N>) -> SVector<f64, N> {
        let mass = system.mass(q);
        SVector::from_fn(|i, _| self.damping[i] / (2.0 * (self.stiffness[i] * mass[(i, i)]).sqrt()))
    }
}

/// Step, duration and settling band of a closed-loop run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldRun {
    /// The control period and integrator step \[s\]; τ is held over it.
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
    /// A joint is settled if |q\*−q| is at most this \[rad or m\].
    pub band: f64,
}

/// The result of a closed-loop run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HoldReport<const N: usize> {
    /// q at the end.
    pub q: SVector<f64, N>,
    /// q̇ at the end.
    pub qd: SVector<f64, N>,
    /// The largest |τ| applied, per joint \[N·m or N\].
    pub peak_torque: SVector<f64, N>,
    /// The largest |τ| before the limits, per joint.
    pub peak_demand: SVector<f64, N>,
    /// The largest overshoot beyond the target, per joint, relative to the side of the start \[rad or m\].
    pub overshoot: SVector<f64, N>,
    /// The time after which every joint stays within the band \[s\]; `None` if the run ends outside it.
    pub settling_time: Option<f64>,
}

/// Runs the controller from (q, q̇) with τ held over each Runge–Kutta step and reports peaks and settling.
///
/// ```
/// use dynamics::{HoldRun, PdHold, REACH_TORQUE_LIMITS, Reach2R, hold};
/// use nalgebra::{Vector2, vector};
/// let arm = Reach2R::worked_example();
/// let control = PdHold {
///     target: vector![1.6, 0.4],
///     stiffness: vector![60.0, 30.0],
///     damping: vector![20.0, 6.0],
///     limits: REACH_TORQUE_LIMITS,
/// };
/// let run = HoldRun { step: 1e-3, steps: 4000, band: 0.01 };
/// let report = hold(&arm, &control, &vector![1.4, 0.2], &Vector2::zeros(), &run)?;
/// assert!(report.settling_time.is_some());
/// assert!(report.peak_torque[0] <= 20.0 && report.peak_torque[1] <= 12.0);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// [`IntegratorError::NotFinite`] if the target, a gain, the start, the step or the band is not finite, or if
/// [`rk4_step`] fails.
///
/// # Panics
/// If the step is not positive, or a limit is negative or NaN.
pub fn hold<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    control: &PdHold<N>,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    run: &HoldRun,
) -> Result<HoldReport<N>, IntegratorError> {
    for (quantity, values) in [
        ("q*", control.target.as_slice()),
        ("Kp", control.stiffness.as_slice()),
        ("Kd", control.damping.as_slice()),
        ("q", q.as_slice()),
        ("qd", qd.as_slice()),
        ("the step", &[run.step]),
        ("the band", &[run.band]),
    ] {
        check_finite(quantity, values)?;
    }
    let side = (control.target - q).map(f64::signum);
    let mut report = HoldReport {
        q: *q,
        qd: *qd,
        peak_torque: SVector::zeros(),
        peak_demand: SVector::zeros(),
        overshoot: SVector::zeros(),
        settling_time: None,
    };
    for i in 0..=run.steps {
        let past = report.q - control.target;
        report.overshoot = report.overshoot.sup(&past.component_mul(&side));
        if past.amax() > run.band {
            report.settling_time = None;
        } else if report.settling_time.is_none() {
            report.settling_time = Some(i as f64 * run.step);
        }
        if i == run.steps {
            break;
        }
        // Before the limits, which would hide an infinity.
        let demand = control.demand(system, &report.q, &report.qd);
        check_computed("u", demand.as_slice())?;
        let torque = control.torque(system, &report.q, &report.qd);
        report.peak_torque = report.peak_torque.sup(&torque.abs());
        report.peak_demand = report.peak_demand.sup(&demand.abs());
        (report.q, report.qd) = rk4_step(system, &report.q, &report.qd, &torque, run.step)?;
    }
    Ok(report)
}
