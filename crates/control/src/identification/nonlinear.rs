//! Parameters on which torques depend nonlinearly: Stribeck velocities and the direction of gravity.
//!
//! minimize over θ: F(θ) = min over x of ½ |W(θ) x − τ(θ)|² + γ Σ D(x ‖ x₀)
//!
//! For each θ the inner problem is the convex one of [`identify_consistent`]. The outer problem is solved by
//! a Gauss–Newton method with Levenberg–Marquardt damping (variable projection). With the residual r = W x −
//! τ, its derivative J = ∂r/∂θ at constant x, and the inner Hessian H,
//!
//! ∇F = Jᵀr, ∇²F ≈ Jᵀ(1 − W H⁻¹Wᵀ) J.
//!
//! The gradient is exact, because x is a minimum. The Hessian leaves out second derivatives of W times r, as
//! Gauss–Newton methods do.
//!
//! Source: Golub, Pereyra, *Separable nonlinear least squares: the variable projection method and its
//! applications*, Inverse Problems 19 (2003); Kaufman (1975) for the approximate Hessian.

use nalgebra::{DMatrix, DVector, Vector3};
use robot_dynamics_core::{FrameWrench, Model};
use robot_dynamics_number::{InvalidInput, check_finite};

use super::consistent::{ConsistentEstimate, solve};
use super::{ConsistentOptions, IdentificationError, JointTerm, JointTermKind, MotionRecord};

/// Steps with a smaller relative decrease of F end the search.
const LEAST_DECREASE: f64 = 1e-9;

/// The largest change of ln of a Stribeck velocity, and of the angles of gravity \[rad\], in one step.
const LARGEST_STEP: f64 = 0.5;

/// A measured state, with the external wrenches at it.
#[derive(Clone, Copy, Debug)]
pub struct MotionSample<'s> {
    /// q.
    pub q: &'s [f64],
    /// v.
    pub v: &'s [f64],
    /// a.
    pub a: &'s [f64],
    /// The measured torques \[N·m or N\].
    pub tau: &'s [f64],
    /// The measured external wrenches.
    pub wrenches: &'s [FrameWrench],
}

/// How nonlinear parameters are identified.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NonlinearOptions {
    /// The options of the inner problem.
    pub consistent: ConsistentOptions,
    /// The joint terms. The velocities of Stribeck terms are the start of the search.
    pub terms: Vec<JointTerm>,
    /// The standard deviation of each torque; empty if all are 1.
    pub noise: Vec<f64>,
    /// Whether τ includes the joints' damping and friction.
    pub with_dissipation: bool,
    /// Whether the direction of gravity is identified.
    pub gravity_direction: bool,
    /// The most steps of the outer search; 30 by default.
    pub steps: usize,
}

impl NonlinearOptions {
    /// The options with those of the inner problem, and joint terms. Torques include damping and friction.
    pub fn new(consistent: ConsistentOptions, terms: &[JointTerm]) -> Self {
        Self {
            consistent,
            terms: terms.to_vec(),
            noise: Vec::new(),
            with_dissipation: true,
            gravity_direction: false,
            steps: 30,
        }
    }

    /// Sets the standard deviation of each torque \[N·m or N\].
    #[must_use]
    pub fn with_noise(mut self, noise: &[f64]) -> Self {
        self.noise = noise.to_vec();
        self
    }

    /// Sets whether the direction of gravity is identified.
    #[must_use]
    pub fn with_gravity_direction(mut self, identified: bool) -> Self {
        self.gravity_direction = identified;
        self
    }
}

/// Estimated linear and nonlinear parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NonlinearEstimate {
    /// The linear parameters, for the nonlinear ones below.
    pub linear: ConsistentEstimate,
    /// The joint terms, with the identified Stribeck velocities.
    pub terms: Vec<JointTerm>,
    /// The acceleration of gravity in the world \[m/s²\].
    pub gravity: [f64; 3],
    /// The standard deviations of ln of the Stribeck velocities, in the order of their terms, and then of the
    /// two angles of gravity \[rad\].
    pub standard_deviations: Vec<f64>,
    /// The number of outer steps.
    pub steps: usize,
}

/// Identifies Stribeck velocities and the direction of gravity together with consistent parameters.
///
/// Stribeck friction is F sign v + ΔF sign v exp(−(v/v_s)²) + b v: the terms `Friction`, `Stribeck` and
/// `Damping`. The base of a robot that is mounted at an unknown tilt has an unknown direction of gravity; its
/// magnitude is taken from the model.
///
/// ```
/// use robot_dynamics::control::identification::{
///     ConsistentOptions, JointTerm, JointTermKind, MotionSample, NonlinearOptions, identify_nonlinear,
/// };
/// use robot_dynamics::description::{MassProperties, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// let body = MassProperties::new(2.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity() * 0.01)?;
/// robot.links[1].mass_properties = Some(body);
/// let model = Model::new(robot)?;
/// let friction = |v: f64| v.signum() * (0.5 + 0.8 * (-(v / 0.2).powi(2)).exp());
/// let states: Vec<[f64; 4]> = (0..200)
///     .map(|i| {
///         let t = 0.05 * f64::from(i);
///         let (q, v, a) = (t.sin(), t.cos(), -t.sin());
///         let rigid = model.inverse_dynamics(&[q], &[v], &[a]).expect("a state")[0];
///         [q, v, a, rigid + friction(v)] // in practice: measured
///     })
///     .collect();
/// let samples: Vec<MotionSample<'_>> = states
///     .iter()
///     .map(|[q, v, a, tau]| {
///         let [q, v, a, tau] = [q, v, a, tau].map(std::slice::from_ref);
///         MotionSample { q, v, a, tau, wrenches: &[] }
///     })
///     .collect();
/// let kinds = [JointTermKind::Friction, JointTermKind::Stribeck { velocity: 0.1 }];
/// let consistent = kinds
///     .iter()
///     .fold(ConsistentOptions::new(1e-6), |options, kind| options.with_joint_nominal(*kind, 0.5));
/// let options = NonlinearOptions::new(consistent, &JointTerm::of_all(&model, &kinds)).with_noise(&[0.01]);
/// let found = identify_nonlinear(&model, &samples, &options)?;
/// let JointTermKind::Stribeck { velocity } = found.terms[1].kind else { panic!("a Stribeck term") };
/// assert!((velocity - 0.2).abs() < 1e-4 && (found.linear.parameters[11] - 0.8).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentificationError`] if a sample or an option is invalid, nothing is nonlinear, or the inner problem
/// does not converge.
pub fn identify_nonlinear(
    model: &Model,
    samples: &[MotionSample<'_>],
    options: &NonlinearOptions,
) -> Result<NonlinearEstimate, IdentificationError> {
    let search = Search { model, samples, options };
    let mut theta = search.start()?;
    let mut current = search.at(&theta)?;
    let (mut damping, mut steps) = (1e-3, 0);
    while steps < options.steps {
        let scaled = &current.hessian + DMatrix::from_diagonal(&current.hessian.diagonal()) * damping;
        let Some(factor) = scaled.cholesky() else {
            let requirement = "must all affect the torques";
            return Err(InvalidInput::unmet("the nonlinear parameters", requirement).into());
        };
        let mut step = -factor.solve(&current.gradient);
        step *= (LARGEST_STEP / step.amax()).min(1.0);
        steps += 1;
        let next = &theta + &step;
        let Ok(after) = search.at(&next) else {
            damping *= 10.0;
            continue;
        };
        let decrease = current.value - after.value;
        if decrease > 0.0 {
            (theta, damping) = (next, damping * 0.2);
            let is_small = decrease <= LEAST_DECREASE * current.value;
            current = after;
            if is_small {
                break;
            }
        } else if step.amax() < 1e-7 || damping > 1e12 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    let inverse = current.hessian.clone().try_inverse();
    let variance = current.estimate.residual.powi(2);
    let deviation = |k: usize| inverse.as_ref().map_or(f64::INFINITY, |own| (own[(k, k)] * variance).sqrt());
    Ok(NonlinearEstimate {
        standard_deviations: (0..theta.len()).map(deviation).collect(),
        terms: search.terms(&theta),
        gravity: search.gravity(&theta).into(),
        linear: current.estimate,
        steps,
    })
}

/// The outer problem.
struct Search<'a> {
    model: &'a Model,
    samples: &'a [MotionSample<'a>],
    options: &'a NonlinearOptions,
}

/// F at θ with its derivatives, and the solution of the inner problem.
struct Point {
    estimate: ConsistentEstimate,
    value: f64,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl Search<'_> {
    /// ln of the Stribeck velocities, then two angles.
    fn start(&self) -> Result<DVector<f64>, IdentificationError> {
        let mut theta: Vec<f64> = self.velocities().map(f64::ln).collect();
        if self.options.gravity_direction {
            theta.extend([0.0; 2]);
        }
        if theta.is_empty() {
            let requirement = "must include a Stribeck term or the direction of gravity";
            return Err(InvalidInput::unmet("the nonlinear parameters", requirement).into());
        }
        check_finite("ln of the Stribeck velocities", &theta)?;
        Ok(DVector::from_vec(theta))
    }

    fn velocities(&self) -> impl Iterator<Item = f64> {
        self.options.terms.iter().filter_map(|term| match term.kind {
            JointTermKind::Stribeck { velocity } => Some(velocity),
            _ => None,
        })
    }

    /// The joint terms at θ.
    fn terms(&self, theta: &DVector<f64>) -> Vec<JointTerm> {
        let mut terms = self.options.terms.clone();
        let stribeck = terms.iter_mut().filter(|term| matches!(term.kind, JointTermKind::Stribeck { .. }));
        for (term, ln) in stribeck.zip(theta.iter()) {
            term.kind = JointTermKind::Stribeck { velocity: ln.exp() };
        }
        terms
    }

    /// Two directions across gravity.
    fn axes(&self) -> [Vector3<f64>; 2] {
        let gravity = Vector3::from(self.model.gravity());
        let across = gravity.cross(&Vector3::ith(gravity.iamin(), 1.0)).normalize();
        [across, gravity.cross(&across).normalize()]
    }

    /// Gravity at θ: turned by the vector of both angles.
    fn gravity(&self, theta: &DVector<f64>) -> Vector3<f64> {
        let gravity = Vector3::from(self.model.gravity());
        if !self.options.gravity_direction {
            return gravity;
        }
        let n = theta.len();
        let [first, second] = self.axes();
        nalgebra::Rotation3::new(first * theta[n - 2] + second * theta[n - 1]) * gravity
    }

    /// The model with another gravity.
    fn model_with(&self, gravity: Vector3<f64>) -> Result<Model, IdentificationError> {
        let mut description = self.model.description().clone();
        description.gravity = gravity.into();
        let invalid = |_| InvalidInput::unmet("the direction of gravity", "must be finite");
        Ok(Model::new(description).map_err(invalid)?)
    }

    /// The record of the samples for a model and terms.
    fn record<'m>(
        &self,
        model: &'m Model,
        terms: &[JointTerm],
    ) -> Result<MotionRecord<'m>, IdentificationError> {
        let mut record = MotionRecord::new(model, self.options.with_dissipation).with_terms(terms)?;
        if !self.options.noise.is_empty() {
            record = record.with_noise(&self.options.noise)?;
        }
        let mut wrenches = Vec::new();
        for sample in self.samples {
            wrenches.clear();
            for wrench in sample.wrenches {
                let frame = model.frame_named(&self.model.frame_of(wrench.frame).name)?;
                wrenches.push(FrameWrench { frame, ..*wrench });
            }
            record.push_with_wrenches(sample.q, sample.v, sample.a, sample.tau, &wrenches)?;
        }
        Ok(record)
    }

    /// F, its gradient and its approximate Hessian.
    fn at(&self, theta: &DVector<f64>) -> Result<Point, IdentificationError> {
        let (terms, gravity) = (self.terms(theta), self.gravity(theta));
        let model = self.model_with(gravity)?;
        let record = self.record(&model, &terms)?;
        let solution = solve(&record, &self.options.consistent)?;
        let x = DVector::from_column_slice(&solution.estimate.parameters);
        let residual_of =
            |record: &MotionRecord<'_>| record.stacked() * &x - DVector::from_column_slice(&record.torques);
        let left = residual_of(&record);
        let mut jacobian = DMatrix::zeros(left.len(), theta.len());
        for k in 0..theta.len() {
            // Central differences of the residual at constant x; it is smooth in θ.
            let side = |step: f64| -> Result<DVector<f64>, IdentificationError> {
                let mut moved = theta.clone();
                moved[k] += step;
                let model = self.model_with(self.gravity(&moved))?;
                Ok(residual_of(&self.record(&model, &self.terms(&moved))?))
            };
            jacobian.set_column(k, &((side(1e-5)? - side(-1e-5)?) / 2e-5));
        }
        let seen = record.stacked().tr_mul(&jacobian);
        let hidden = solution.project(&seen);
        Ok(Point {
            value: solution.value,
            gradient: jacobian.tr_mul(&left),
            hessian: jacobian.tr_mul(&jacobian) - hidden.tr_mul(&hidden),
            estimate: solution.estimate,
        })
    }
}
