//! The fastest motion on a grid, by reachability analysis.
//!
//! Source: Pham, Pham, *A new approach to time-optimal path parameterization based on reachability analysis*,
//! IEEE Transactions on Robotics 34 (2018).

use robot_dynamics_core::{Model, Workspace};

use super::constraints::{Linearization, PathPoint, Side};
use super::half_planes::HalfPlanes;
use super::sample::range_utilization;
use super::{MotionLimits, ParameterizationError, TreePath};

/// The dynamics on a grid, and the limits there.
pub(super) struct Problem<'a> {
    model: &'a Model,
    limits: &'a MotionLimits,
    grid: &'a [f64],
    points: Vec<PathPoint>,
    /// x at the start and the end.
    ends: [f64; 2],
    /// Whether limits hold at both ends of an interval.
    both_ends: bool,
}

/// A reference x̄ is at least this fraction of the largest one, so that its root has a finite slope.
const SMALLEST_REFERENCE: f64 = 1e-12;

impl<'a> Problem<'a> {
    /// Evaluates the dynamics on a grid; `Err` with the s at which a number is not finite.
    pub(super) fn new(
        model: &'a Model,
        path: &impl TreePath,
        limits: &'a MotionLimits,
        grid: &'a [f64],
    ) -> Result<Self, f64> {
        let workspace = &mut Workspace::new(model);
        let mut points = Vec::with_capacity(grid.len());
        for (i, &s) in grid.iter().enumerate() {
            let before = if i == 0 { 0.0 } else { s - grid[i - 1] };
            let after = grid.get(i + 1).map_or(0.0, |next| next - s);
            points.push(PathPoint::new(model, workspace, path.at(s), [before, after], limits).ok_or(s)?);
        }
        Ok(Self { model, limits, grid, points, ends: [0.0; 2], both_ends: true })
    }

    /// Sets ṡ at the start and the end \[1/s\].
    pub(super) fn with_end_speeds(mut self, start: f64, end: f64) -> Self {
        self.ends = [start * start, end * end];
        self
    }

    /// Sets whether limits hold at both ends of an interval, or at its start only.
    pub(super) fn with_both_ends(mut self, both_ends: bool) -> Self {
        self.both_ends = both_ends;
        self
    }

    pub(super) fn grid(&self) -> &[f64] {
        self.grid
    }

    /// Whether the limits have terms with √x.
    pub(super) fn has_roots(&self) -> bool {
        self.points.iter().any(|point| point.has_roots(self.limits))
    }

    /// x of a motion at constant speed that takes one second.
    pub(super) fn one_second(&self) -> Vec<f64> {
        let length = self.grid[self.grid.len() - 1] - self.grid[0];
        vec![length * length; self.grid.len()]
    }

    /// The limits at point i, for an interval that begins `ahead` before it.
    fn add_limits(
        &self,
        planes: &mut HalfPlanes,
        i: usize,
        (ahead, side): (f64, Side),
        reference: Option<&[f64]>,
    ) {
        let last = self.grid.len() - 1;
        let reference = reference.map(|x| match i {
            0 => self.ends[0],
            _ if i == last => self.ends[1],
            _ => x[i],
        });
        self.points[i].add_limits(planes, self.limits, Linearization { ahead, side, reference });
    }

    /// The half-planes of each interval, and those of the last point.
    fn planes(&self, reference: Option<&[f64]>) -> Vec<HalfPlanes> {
        let last = self.grid.len() - 1;
        let mut all = vec![HalfPlanes::default(); last + 1];
        for (i, planes) in all.iter_mut().enumerate() {
            let side = if i == last { Side::Before } else { Side::After };
            self.add_limits(planes, i, (0.0, side), reference);
            if i < last && self.both_ends {
                let delta = self.grid[i + 1] - self.grid[i];
                self.add_limits(planes, i + 1, (delta, Side::Before), reference);
            }
        }
        all
    }

    /// x of the fastest motion. Terms with √x are linearised at the reference; without one they are left out.
    pub(super) fn solve(&self, reference: Option<&[f64]>) -> Result<Vec<f64>, ParameterizationError> {
        let (grid, n) = (self.grid, self.grid.len() - 1);
        let delta = |i: usize| grid[i + 1] - grid[i];
        let reference: Option<Vec<f64>> = reference.map(|x| {
            let smallest = SMALLEST_REFERENCE * x.iter().fold(0.0, |a: f64, b| a.max(*b));
            x.iter().map(|x| x.max(smallest)).collect()
        });
        let planes = self.planes(reference.as_deref());
        let too_fast = |place, x: f64, largest: f64| ParameterizationError::EndSpeed {
            place,
            speed: x.sqrt(),
            largest: largest.sqrt(),
        };

        // Backward: the controllable sets.
        let (_, largest) = planes[n].speeds().unwrap_or((0.0, -1.0));
        if largest < 0.0 {
            return Err(self.overloaded(n));
        }
        if self.ends[1] > largest {
            return Err(too_fast("end", self.ends[1], largest));
        }
        let mut controllable = vec![(self.ends[1], self.ends[1]); n + 1];
        for i in (0..n).rev() {
            let mut planes = planes[i].clone();
            let (low, high) = controllable[i + 1];
            planes.add_between(2.0 * delta(i), 1.0, low, high);
            controllable[i] = planes.speeds().ok_or_else(|| self.overloaded(i))?;
            if controllable[i].1 == f64::INFINITY {
                return Err(ParameterizationError::Unbounded { s: grid[i] });
            }
        }

        // Forward: as fast as the controllable sets allow.
        let mut x = vec![self.ends[0]];
        let (low, high) = controllable[0];
        if !(low..=high).contains(&x[0]) {
            return Err(too_fast("start", x[0], high));
        }
        for i in 0..n {
            let (low, high) = controllable[i + 1];
            let mut planes = planes[i].clone();
            planes.add_between(2.0 * delta(i), 1.0, low, high);
            let (_, u) = planes.accelerations(x[i]);
            // Rounding must not leave the controllable set.
            x.push((x[i] + 2.0 * delta(i) * u).clamp(low, high));
        }
        Ok(x)
    }

    /// The coordinate that uses most of its torque at rest.
    fn overloaded(&self, i: usize) -> ParameterizationError {
        let tau = |k: usize| self.points[i].torque_at_rest(k);
        let range = |k: usize| (self.limits.torque_lower[k], self.limits.torque_upper[k]);
        let share = |k: usize| range_utilization(tau(k), range(k).0, range(k).1);
        let k = (0..self.model.nv()).max_by(|&i, &j| share(i).total_cmp(&share(j))).unwrap_or(0);
        let (lower, upper) = range(k);
        ParameterizationError::Overloaded {
            s: self.grid[i],
            coordinate: self.model.coordinate_names()[k].clone(),
            needed: tau(k),
            limit: if tau(k) - upper >= lower - tau(k) { upper } else { lower },
        }
    }
}
