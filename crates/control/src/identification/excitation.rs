//! Motions that excite the base parameters, within limits.
//!
//! A motion is a finite Fourier series for each joint. The coefficients maximize the information of
//! equidistant states of one period: the determinant of WᵀW, or the condition number of W. Logarithmic
//! barriers keep the positions, velocities, accelerations and torques of these states inside their limits. A
//! BFGS method minimizes for falling weights of the barrier. Derivatives are exact: dual numbers
//! differentiate the regressor and the torques by q, v and a of one coordinate, and the chain rule gives the
//! rest.
//!
//! Between the states a motion may exceed a limit a little. So all limits hold with a margin, and a grid
//! eight times as fine decides. If a limit is exceeded there, the search goes on with a greater margin.
//!
//! Cost: `samples` · nv regressors over dual numbers for each step.
//!
//! Source: Swevers, Ganseman, Tükel, De Schutter, Van Brussel, *Optimal robot excitation and identification*,
//! IEEE T-RA 13 (1997).

mod barrier;
mod fourier_series;
mod information;
mod objective;
mod options;
mod quasi_newton;

pub use fourier_series::FourierSeries;
pub use options::{ExcitationCriterion, ExcitationLimits, ExcitationOptions};

use core::ops::ControlFlow;

use nalgebra::DVector;
use robot_dynamics_core::Model;
use robot_dynamics_number::{InvalidInput, SplitMix64, check_result};

use super::{BaseParameters, IdentificationError};
use information::condition;
use objective::{Information, Intervals};
use quasi_newton::minimize;

/// The falling weights of the barrier.
const WEIGHTS: [f64; 4] = [1.0, 0.1, 0.01, 0.001];

/// The first margin of the limits.
const MARGIN: f64 = 0.02;

/// How much finer the grid is that decides.
const FINER: usize = 8;

/// The number of random series of which the search starts from the best.
const STARTS: usize = 20;

/// An exciting motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Excitation {
    /// The motion.
    pub series: FourierSeries,
    /// The condition number of W at the samples, with columns of unit length.
    pub condition: f64,
    /// That of the random series from which the search started.
    pub start_condition: f64,
    /// ln det(WᵀW)/(2n) of the n base parameters: the mean of −ln of their standard deviations, up to a
    /// constant of the units.
    pub log_information: f64,
    /// The largest part of a limit that the motion uses, on the fine grid: at most 1. Distances count from
    /// the middle of the limits.
    pub usage: f64,
    /// The number of steps.
    pub steps: usize,
}

/// Designs a motion within limits that determines the base parameters well. Equal seeds give equal motions.
///
/// ```
/// use robot_dynamics::control::identification::{ExcitationLimits, ExcitationOptions, design_excitation};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let limits = ExcitationLimits {
///     position: vec![[-1.0, 1.0]],
///     velocity: vec![2.0],
///     acceleration: vec![8.0],
///     torque: vec![20.0],
/// };
/// let found = design_excitation(&model, &limits, &ExcitationOptions::new(5.0, 3))?;
/// let (mut q, mut v, mut a) = ([0.0], [0.0], [0.0]);
/// for i in 0..=100 {
///     found.series.evaluate(0.05 * f64::from(i), &mut q, &mut v, &mut a);
///     assert!(q[0].abs() <= 1.0 && v[0].abs() <= 2.0 && a[0].abs() <= 8.0);
/// }
/// assert!(v[0].abs() < 1e-12 && a[0].abs() < 1e-12); // it ends at rest
/// assert!(found.condition < 10.0 && found.usage <= 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentificationError`] if an option or a limit is invalid, a joint has several degrees of freedom, or the
/// torque limits do not allow to hold the middle of the position limits.
pub fn design_excitation(
    model: &Model,
    limits: &ExcitationLimits,
    options: &ExcitationOptions,
) -> Result<Excitation, IdentificationError> {
    design_excitation_observed(model, limits, options, |_, _| ControlFlow::Continue(()))
}

/// [`design_excitation`] with an observer, which gets the number of steps and the objective after each step.
/// If it breaks, the result is the motion so far, within the limits.
///
/// ```
/// use std::ops::ControlFlow;
/// use robot_dynamics::control::identification::{ExcitationLimits, ExcitationOptions, design_excitation_observed};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut limits = ExcitationLimits::of(&model);
/// (limits.position[0], limits.velocity[0]) = ([-1.0, 1.0], 2.0);
/// let stop = |steps: usize, _: f64| if steps < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
/// let found = design_excitation_observed(&model, &limits, &ExcitationOptions::new(5.0, 3), stop)?;
/// assert!(found.steps == 3 && found.usage <= 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As of [`design_excitation`].
pub fn design_excitation_observed(
    model: &Model,
    limits: &ExcitationLimits,
    options: &ExcitationOptions,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Excitation, IdentificationError> {
    options.check(model)?;
    limits.check(model)?;
    let columns = 10 * model.moving_links().count() + options.terms.len();
    let states = 10 + 2 * columns / model.nv().max(1);
    let base = BaseParameters::of_with_terms(model, &options.terms, states, 1)?;
    let (equations, unknowns) = (options.samples * model.nv(), base.len());
    if equations < unknowns || unknowns == 0 {
        let coordinates = model.nv();
        return Err(IdentificationError::TooFewData { equations, unknowns, coordinates });
    }
    let exact = Intervals::new(limits, 0.0);
    let mut margin = MARGIN;
    let mut objective = Information::new(model, &base, options, Intervals::new(limits, margin));
    let mut x = start(&mut objective, options.seed)?;
    let start_condition = condition(&objective.rows(&x));
    let criteria = match options.criterion {
        ExcitationCriterion::Determinant => vec![ExcitationCriterion::Determinant],
        ExcitationCriterion::Condition => {
            vec![ExcitationCriterion::Determinant, ExcitationCriterion::Condition]
        }
    };
    let mut steps = 0;
    let mut count = |value: f64| {
        steps += 1;
        observe(steps, value)
    };
    let mut state = ControlFlow::Continue(());
    let mut usage;
    let mut weights = &WEIGHTS[..];
    loop {
        for criterion in &criteria {
            objective.criterion = *criterion;
            for weight in weights {
                objective.weight = *weight;
                if state.is_continue() {
                    state = minimize(&mut objective, &mut x, options.steps, &mut count);
                }
            }
        }
        objective.sample(FINER * options.samples);
        usage = objective.usage(&x, &exact);
        objective.sample(options.samples);
        if usage <= 1.0 {
            break;
        }
        margin += usage - 1.0 + 0.5 * MARGIN;
        weights = &WEIGHTS[WEIGHTS.len() - 1..];
        objective.intervals = Intervals::new(limits, margin);
        shrink(&mut objective, &mut x, 0.99)?;
    }
    let rows = objective.rows(&x);
    let (condition, determinant) = (condition(&rows), ExcitationCriterion::Determinant);
    let log_information =
        information::information(&rows, determinant).map_or(f64::NEG_INFINITY, |(value, _)| -value);
    check_result("the series", x.iter())?;
    let series = objective.basis().series(x.as_slice());
    Ok(Excitation { series, condition, start_condition, log_information, usage, steps })
}

/// The best of some random series that use half of the limits.
fn start(objective: &mut Information<'_>, seed: u64) -> Result<DVector<f64>, IdentificationError> {
    let random = &mut SplitMix64::new(seed);
    let middles: Vec<f64> = objective.intervals.motion[0].iter().map(|own| own.middle()).collect();
    let block = objective.basis().len();
    let (mut best, mut least) = (DVector::zeros(0), f64::INFINITY);
    for _start in 0..STARTS {
        let mut x = DVector::from_fn(block * middles.len(), |_, _| random.uniform(-1.0, 1.0));
        for (own, middle) in x.as_mut_slice().chunks_exact_mut(block).zip(&middles) {
            own[0] = *middle;
        }
        shrink(objective, &mut x, 0.5)?;
        let rows = objective.rows(&x);
        let own = information::information(&rows, ExcitationCriterion::Determinant);
        let value = own.map_or(f64::MAX, |(value, _)| value);
        if value < least {
            (best, least) = (x, value);
        }
    }
    Ok(best)
}

/// Scales the motion towards the middle of the limits until it uses at most this part of them.
fn shrink(
    objective: &mut Information<'_>,
    x: &mut DVector<f64>,
    part: f64,
) -> Result<(), IdentificationError> {
    let (intervals, block) = (objective.intervals.clone(), objective.basis().len());
    let middles: Vec<f64> = intervals.motion[0].iter().map(|own| own.middle()).collect();
    let scaled = |x: &DVector<f64>, factor: f64| {
        let mut next = x * factor;
        for (own, middle) in next.as_mut_slice().chunks_exact_mut(block).zip(&middles) {
            own[0] += middle * (1.0 - factor);
        }
        next
    };
    let held = objective.usage(&scaled(x, 0.0), &intervals);
    if held >= 1.0 {
        let requirement = "must allow to hold the middle of the position limits";
        return Err(InvalidInput::unmet("the torque limits", requirement).into());
    }
    // Gravity alone may use more than the part.
    let part = part.max(0.5 * (held + 1.0));
    let mut factor = 1.0;
    while objective.usage(&scaled(x, factor), &intervals) > part {
        factor *= 0.9;
    }
    *x = scaled(x, factor);
    Ok(())
}
