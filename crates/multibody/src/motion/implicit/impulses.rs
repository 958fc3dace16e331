//! The impulses of friction and stops in one step.

use dynamics::DynamicsError;

use super::bounded::BoundedProblem;
use super::joints::{Joints, Stop};
use super::stiff_factor::StiffFactor;
use crate::Model;
use crate::motion::simulate::Losses;

/// Part of a diagonal entry that is added to it, so that friction and a stop at one joint share its impulse in one way.
const SOFTNESS: f64 = 1e-12;
/// A robot that starts beyond a stop is brought back with this time constant \[s\].
const RETURN_TIME: f64 = 0.1;

/// Which force a row is of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cause {
    Friction,
    Stop,
}

/// A row of E: one coordinate, with a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    cause: Cause,
    coordinate: usize,
    sign: f64,
}

/// Rows and multipliers of a step, and their memory.
#[derive(Clone, Debug)]
pub(super) struct Impulses {
    rows: Vec<Row>,
    problem: BoundedProblem,
    column: Vec<f64>,
    /// A configuration before it is moved.
    before: Vec<f64>,
}

impl Impulses {
    pub(super) fn new(model: &Model) -> Self {
        let most = 3 * model.nv;
        Self {
            rows: Vec::with_capacity(most),
            problem: BoundedProblem::new(most),
            column: vec![0.0; model.nv],
            before: vec![0.0; model.nq],
        }
    }

    /// M̂⁻¹Eᵀλ to `change`, from the state before the step and the one that the smooth part leads to; false where nothing acts.
    #[allow(clippy::too_many_arguments)] // two states and the step
    pub(super) fn solve(
        &mut self,
        factor: &StiffFactor,
        joints: &Joints,
        stops: &[Stop],
        h: f64,
        (q0, _): (&[f64], &[f64]),
        (q1, v1): (&[f64], &[f64]),
        change: &mut [f64],
    ) -> Result<bool, DynamicsError> {
        self.rows.clear();
        for (coordinate, friction) in joints.friction.iter().enumerate() {
            if *friction > 0.0 {
                self.rows.push(Row { cause: Cause::Friction, coordinate, sign: 1.0 });
            }
        }
        for stop in stops {
            // Beyond it after the step, or at it and pressed on.
            let is_met = stop.gap(q1) < 0.0 || (stop.gap(q0) <= 0.0 && stop.sign * v1[stop.v] < 0.0);
            if is_met {
                self.rows.push(Row { cause: Cause::Stop, coordinate: stop.v, sign: stop.sign });
            }
        }
        change.fill(0.0);
        if self.rows.is_empty() {
            return Ok(false);
        }
        self.fill(factor);
        for (i, row) in self.rows.iter().enumerate() {
            let problem = &mut self.problem;
            problem.gradient[i] = row.sign * v1[row.coordinate];
            (problem.lower[i], problem.upper[i]) = match row.cause {
                Cause::Friction => {
                    let most = h * joints.friction[row.coordinate];
                    (-most, most)
                }
                Cause::Stop => (0.0, f64::INFINITY),
            };
        }
        self.apply(factor, change)?;
        Ok(true)
    }

    /// W = EM̂⁻¹Eᵀ.
    fn fill(&mut self, factor: &StiffFactor) {
        let (rows, problem) = (&self.rows, &mut self.problem);
        let n = rows.len();
        problem.begin(n);
        for (i, row) in rows.iter().enumerate() {
            self.column.fill(0.0);
            self.column[row.coordinate] = row.sign;
            factor.solve(&mut self.column);
            for (j, other) in rows.iter().enumerate() {
                problem.matrix[j * n + i] = other.sign * self.column[other.coordinate];
            }
        }
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (problem.matrix[i * n + j] + problem.matrix[j * n + i]);
                (problem.matrix[i * n + j], problem.matrix[j * n + i]) = (mean, mean);
            }
            problem.matrix[i * n + i] *= 1.0 + SOFTNESS;
        }
    }

    /// Solves, and M̂⁻¹Eᵀλ to `change`.
    fn apply(&mut self, factor: &StiffFactor, change: &mut [f64]) -> Result<(), DynamicsError> {
        // Numbers that are none have no minimum.
        if !self.problem.solve() {
            let pivot = self.problem.matrix.first().copied().unwrap_or(f64::NAN);
            return Err(DynamicsError::SingularMass { coordinate: self.rows[0].coordinate, pivot });
        }
        change.fill(0.0);
        for (row, multiplier) in self.rows.iter().zip(&self.problem.x) {
            change[row.coordinate] += row.sign * multiplier;
        }
        factor.solve(change);
        Ok(())
    }

    /// Sets velocities to the zero that they are but for rounding, of joints that stick and of those on a stop; where they
    /// were at rest before the step, they have not moved.
    pub(super) fn rest(&self, v0: &[f64], v1: &mut [f64], displacement: &mut [f64]) {
        let problem = &self.problem;
        for (i, row) in self.rows.iter().enumerate() {
            let rests = match row.cause {
                Cause::Friction => problem.x[i] > problem.lower[i] && problem.x[i] < problem.upper[i],
                Cause::Stop => problem.x[i] > 0.0,
            };
            if rests {
                v1[row.coordinate] = 0.0;
                if v0[row.coordinate] == 0.0 {
                    displacement[row.coordinate] = 0.0;
                }
            }
        }
    }

    /// −λ times the mean of the velocities before and after.
    pub(super) fn losses(&self, v0: &[f64], v1: &[f64]) -> Losses {
        let mut losses = Losses::default();
        for (row, multiplier) in self.rows.iter().zip(&self.problem.x) {
            let lost = -multiplier * row.sign * 0.5 * (v0[row.coordinate] + v1[row.coordinate]);
            match row.cause {
                Cause::Friction => losses.friction += lost,
                Cause::Stop => losses.stops += lost,
            }
        }
        Losses { friction: losses.friction.max(0.0), stops: losses.stops.max(0.0), ..losses }
    }

    /// Moves `q1` back to the stops that it is beyond, along M̂⁻¹Eᵀ; a start beyond them comes back over some time.
    #[allow(clippy::too_many_arguments)] // two configurations and the step
    pub(super) fn put_on_stops(
        &mut self,
        factor: &StiffFactor,
        stops: &[Stop],
        h: f64,
        q0: &[f64],
        q1: &mut [f64],
        change: &mut [f64],
        mut go: impl FnMut(&[f64], &[f64], &mut [f64]),
    ) -> Result<(), DynamicsError> {
        let kept = (-h / RETURN_TIME).exp();
        let beyond = |stop: &Stop, q: &[f64]| stop.gap(q) - stop.gap(q0).min(0.0) * kept;
        self.rows.clear();
        self.before.copy_from_slice(q1);
        // Moving one joint may push another beyond its stop: then that joins in.
        loop {
            let known = self.rows.len();
            for stop in stops {
                let row = Row { cause: Cause::Stop, coordinate: stop.v, sign: stop.sign };
                if beyond(stop, q1) < 0.0 && !self.rows.contains(&row) {
                    self.rows.push(row);
                }
            }
            if self.rows.len() == known {
                break;
            }
            self.fill(factor);
            for (i, row) in self.rows.iter().enumerate() {
                let own = |stop: &&Stop| stop.v == row.coordinate && stop.sign == row.sign;
                let gap = stops.iter().find(own).map_or(0.0, |stop| beyond(stop, &self.before));
                self.problem.gradient[i] = gap;
                self.problem.upper[i] = f64::INFINITY;
            }
            self.apply(factor, change)?;
            go(change, &self.before, q1);
        }
        for stop in stops {
            // To the last digit.
            let gap = stop.gap(q1);
            if gap < 0.0 && gap > -1e-9 && stop.gap(q0) >= 0.0 {
                q1[stop.q] = stop.bound;
            }
        }
        Ok(())
    }
}
