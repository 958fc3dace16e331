//! Enclosures of free motions from sets of states, by Lohner's method.
//!
//! A set of states is x̂ + A r, with a point x̂, a matrix A and a box r. A step of length h has a box B that
//! the motion does not leave, by Picard's iteration \[X\] + \[0, h\] f(B) ⊆ B. The Taylor series of the
//! motion from x̂ and its derivative over the set give the next set, and the series over B the remainder.
//! Steps are halved until the remainder adds little to the set. A is made orthogonal in each step, so that
//! boxes are not widened by rotation.
//!
//! Sources: Lohner, *Enclosing the solutions of ordinary initial and boundary value problems*, in: Computer
//! Arithmetic, Teubner 1987. Nedialkov, Jackson, Corliss, *Validated solutions of initial value problems for
//! ordinary differential equations*, Applied Mathematics and Computation 105 (1999).

use nalgebra::DMatrix;
use robot_dynamics_core::{Model, Workspace, forward_dynamics};
use robot_dynamics_number::{Dual, Scalar};

use crate::linear::LinearSystem;
use crate::search::middle;
use crate::series::{Series, TERMS};
use crate::{EnclosureError, Interval};

/// The enclosure of a motion at one time.
#[derive(Clone, Debug)]
pub struct FlowState {
    /// The time \[s\].
    pub time: f64,
    /// The configurations, at this time.
    pub q: Vec<Interval>,
    /// The velocities, at this time.
    pub v: Vec<Interval>,
}

/// A computed motion.
#[derive(Clone, Debug)]
pub struct FlowEnclosure {
    /// The states after each step, from the start.
    pub states: Vec<FlowState>,
    /// Whether the end was reached. Otherwise the set grew too wide for a step.
    pub is_complete: bool,
}

/// Encloses every motion q̈ = M⁻¹(τ − C v − g) from a box of states, with constant torques, over equal steps.
/// Damping, friction, limits and contact do not act. Robots of few joints have narrow enclosures. The
/// intervals of long recursions are wide, and end those of others soon.
///
/// The states at the end of each step are enclosed. Steps are divided if necessary. If a set grows too wide
/// for the next step, the enclosure ends there.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{Interval, enclose_motion};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let motion = enclose_motion(&model, &[Interval::around(0.3, 1e-6)], &[0.0.into()], &[0.0], 0.01, 50)?;
/// let end = motion.states.last().unwrap();
/// assert!(motion.is_complete && end.q[0].width() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EnclosureError`] if the robot has joints with quaternions, or an interval is unbounded.
///
/// # Panics
/// If an argument has the wrong length, or the step is not positive.
pub fn enclose_motion(
    model: &Model,
    q: &[Interval],
    v: &[Interval],
    tau: &[f64],
    step: f64,
    steps: usize,
) -> Result<FlowEnclosure, EnclosureError> {
    if !model.is_vector_space() || model.has_mimic() {
        return Err(EnclosureError::Quaternions);
    }
    let n = model.nv();
    assert!(q.len() == n && v.len() == n && tau.len() == n, "q, v and tau need {n} entries each");
    assert!(step > 0.0, "the step {step} is not positive");
    if q.iter().chain(v).any(|x| !x.is_bounded()) {
        return Err(EnclosureError::Unbounded);
    }
    let mut set = StateSet::of_box(&[q, v].concat());
    let flow = Flow { model, tau };
    let state = |k: usize, hull: &[Interval]| FlowState {
        time: step * k as f64,
        q: hull[..n].to_vec(),
        v: hull[n..].to_vec(),
    };
    let mut states = vec![state(0, &set.hull())];
    // The number of halvings of the step.
    let mut level = 0;
    for k in 1..=steps {
        // The part of the step that is done, in units of 2^−MOST_HALVINGS.
        let mut done = 0_u32;
        while done < 1 << MOST_HALVINGS {
            let unit = 1 << (MOST_HALVINGS - level);
            if let Some(next) = flow.advance(&set, step / f64::from(1_u32 << level)) {
                set = next;
                done += unit;
                // A longer step, if it ends where one of that length does.
                if level > 0 && done.is_multiple_of(2 * unit) {
                    level -= 1;
                }
            } else if level < MOST_HALVINGS {
                level += 1;
            } else {
                return Ok(FlowEnclosure { states, is_complete: false });
            }
        }
        states.push(state(k, &set.hull()));
    }
    Ok(FlowEnclosure { states, is_complete: true })
}

/// x̂ + A r.
struct StateSet {
    center: Vec<f64>,
    /// By rows.
    matrix: Vec<f64>,
    rest: Vec<Interval>,
}

impl StateSet {
    fn of_box(states: &[Interval]) -> Self {
        let n = states.len();
        let center = middle(states);
        let rest = states.iter().zip(&center).map(|(x, c)| *x - Interval::from(*c)).collect();
        let matrix = (0..n * n).map(|k| if k % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self { center, matrix, rest }
    }

    fn hull(&self) -> Vec<Interval> {
        let n = self.center.len();
        let row = |i: usize| {
            let start = Interval::from(self.center[i]);
            (0..n).fold(start, |sum, j| sum + Interval::from(self.matrix[i * n + j]) * self.rest[j])
        };
        (0..n).map(row).collect()
    }
}

struct Flow<'a> {
    model: &'a Model,
    tau: &'a [f64],
}

/// The largest number of times that a step is halved.
const MOST_HALVINGS: u32 = 10;

impl Flow<'_> {
    /// The set after a step; `None` if it has no enclosure, or a remainder that is too wide.
    fn advance(&self, set: &StateSet, step: f64) -> Option<StateSet> {
        let (n, h) = (set.center.len(), Interval::from(step));
        let hull = set.hull();
        let bound = self.stays_in(&hull, h)?;
        let last = TERMS - 1;
        let mut power = Interval::from(1.0);
        let powers: Vec<Interval> = (0..TERMS)
            .map(|_| {
                let own = power;
                power *= h;
                own
            })
            .collect();
        let sum = |series: &Series<Interval>| {
            (0..last).fold(Interval::from(0.0), |sum, k| sum + series.0[k] * powers[k])
        };
        let center: Vec<Interval> = set.center.iter().map(|x| Interval::from(*x)).collect();
        let from_center = self.series::<Interval>(&center);
        let series = self.series::<Interval>(&bound);
        let remainder: Vec<Interval> = series.iter().map(|x| x.0[last] * powers[last]).collect();
        // The remainders widen the set by a factor of at most e each second.
        let is_wide = |(rest, x): (&Interval, &Interval)| {
            let width = x.width() + 1e-10 * (1.0 + x.magnitude());
            let is_narrow = rest.width() <= width * step;
            !is_narrow
        };
        if remainder.iter().zip(&hull).any(is_wide) {
            return None;
        }
        let end: Vec<Interval> = (0..n).map(|i| sum(&from_center[i]) + remainder[i]).collect();
        let next: Vec<f64> = middle(&end);
        // The derivative of the series by the state, column by column.
        let mut slope = vec![Interval::from(0.0); n * n];
        for j in 0..n {
            let start: Vec<Dual<Interval, 1>> = (0..n)
                .map(|i| if i == j { Dual::variable(hull[i], 0) } else { Dual::constant(hull[i]) })
                .collect();
            for (i, series) in self.series(&start).iter().enumerate() {
                slope[i * n + j] =
                    (0..last).fold(Interval::from(0.0), |sum, k| sum + series.0[k].gradient[0] * powers[k]);
            }
        }
        let product = multiplied(&slope, &set.matrix, n);
        if product.iter().chain(&end).any(|x| !x.is_bounded()) {
            return None;
        }
        let orthogonal = orthogonal(&product, &set.rest, n);
        let columns: Vec<Interval> = orthogonal.iter().map(|x| Interval::from(*x)).collect();
        // r' = Q⁻¹ (S A) r + Q⁻¹ (end − next).
        let error: Vec<Interval> = end.iter().zip(&next).map(|(e, c)| *e - Interval::from(*c)).collect();
        let system = LinearSystem::new(&columns, n).ok()?;
        let mut rest = system.solve(&error).ok()?;
        for j in 0..n {
            let column: Vec<Interval> = (0..n).map(|i| product[i * n + j]).collect();
            for (rest, x) in rest.iter_mut().zip(system.solve(&column).ok()?) {
                *rest += x * set.rest[j];
            }
        }
        Some(StateSet { center: next, matrix: orthogonal, rest })
    }

    /// A box that no motion from `hull` leaves within the step.
    fn stays_in(&self, hull: &[Interval], step: Interval) -> Option<Vec<Interval>> {
        let time = Interval::new(0.0, step.upper());
        let reached = |guess: &[Interval]| -> Vec<Interval> {
            let rate = self.rate(guess);
            hull.iter().zip(rate).map(|(x, rate)| *x + time * rate).collect()
        };
        let mut guess = reached(hull);
        for _ in 0..12 {
            let wider: Vec<Interval> = guess
                .iter()
                .zip(hull)
                .map(|(x, hull)| {
                    let x = x.hull(*hull);
                    let margin = 0.2 * x.width() + 1e-14 * x.magnitude() + 1e-300;
                    x + Interval::new(-margin, margin)
                })
                .collect();
            let image = reached(&wider);
            if image.iter().any(|x| !x.is_bounded()) {
                return None;
            }
            if wider.iter().zip(&image).all(|(wider, image)| wider.encloses(*image)) {
                return Some(image);
            }
            guess = image;
        }
        None
    }

    /// (v, a) at a state.
    fn rate<S: Scalar>(&self, state: &[S]) -> Vec<S> {
        let n = self.tau.len();
        let (q, v) = state.split_at(n);
        let tau: Vec<S> = self.tau.iter().map(|x| S::from_f64(*x)).collect();
        let mut rate = [v, &vec![S::zero(); n]].concat();
        forward_dynamics(self.model, &mut Workspace::new(self.model), q, v, &tau, &mut rate[n..]);
        rate
    }

    /// The Taylor series of the motion from a state: (k + 1) x_{k+1} = f(x)_k.
    fn series<S: Scalar>(&self, state: &[S]) -> Vec<Series<S>> {
        let mut series: Vec<Series<S>> = state.iter().map(|x| Series::constant(*x)).collect();
        for k in 0..TERMS - 1 {
            let rate = self.rate(&series);
            for (x, rate) in series.iter_mut().zip(rate) {
                x.0[k + 1] = rate.0[k] / S::from_f64((k + 1) as f64);
            }
        }
        series
    }
}

/// The product of two matrices by rows, the second of numbers.
fn multiplied(a: &[Interval], b: &[f64], n: usize) -> Vec<Interval> {
    let entry = |i: usize, j: usize| {
        (0..n).fold(Interval::from(0.0), |sum, k| sum + a[i * n + k] * Interval::from(b[k * n + j]))
    };
    (0..n * n).map(|k| entry(k / n, k % n)).collect()
}

/// The orthogonal factor of the matrix in the middle, with its columns in the order of their lengths times
/// the widths of r, so that the longest edge of the set keeps its direction.
fn orthogonal(product: &[Interval], rest: &[Interval], n: usize) -> Vec<f64> {
    let length = |j: usize| {
        let square: f64 = (0..n).map(|i| product[i * n + j].middle().powi(2)).sum();
        square.sqrt() * (rest[j].width() + f64::MIN_POSITIVE)
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
    let sorted = DMatrix::from_fn(n, n, |i, j| product[i * n + order[j]].middle());
    let q = sorted.qr().q();
    (0..n * n).map(|k| q[(k / n, k % n)]).collect()
}
