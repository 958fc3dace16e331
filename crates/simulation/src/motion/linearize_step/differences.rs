//! The discrete linear system of one step of any stepper, by finite differences.

use robot_dynamics_core::{Model, difference, integrate, mass_matrix};
use robot_dynamics_description::check_length;

use super::LinearizedStep;
use crate::motion::RobotState;
use crate::{StepError, StepForces, StepWorkspace, Stepper};

/// The increment of a coordinate or a velocity to either side \[rad, m, rad/s, m/s\]. The error of a smooth
/// step is half its square times the third derivative, 1e-10. The error of the steps themselves, about 1e-11
/// of the speeds, is divided by it.
const MOVE: f64 = 1e-5;

/// The ratio of successive increments. At the third and last, 1.6e-7, the error of the steps themselves is
/// 1e-4 of the speeds.
const SHORTER: f64 = 1.0 / 8.0;

/// The derivatives of both sides agree if they differ by less than this fraction; smaller differences are the
/// steps' own error.
const AGREE: f64 = 1e-4;

/// Next to a discontinuity, the difference quotient across it increases eightfold with each smaller
/// increment, and the other one is constant.
const GROWS: f64 = 4.0;
const STAYS: f64 = 0.1;

/// A and B of one step of any [`Stepper`], by central differences: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ. They
/// include contact, stops and dry friction.
///
/// The layout is that of [`linearize_step`](crate::linearize_step), which is exact and faster for explicit
/// rows. Here each column costs two steps, 6nv + 1 in total. Each step uses a copy of the given `stepper`, so
/// all of them start with its stored contacts of the step before. A stepper with contacts should therefore
/// have taken a step to (q, v): its contacts then persist under a perturbation of 10 µm. Coordinates and
/// velocities are perturbed by 1e-5 to either side, forces by an amount that changes the velocities about as
/// much.
///
/// A stepper may have an active set ([`Stepper::active_set`]). The limits and contacts that act in the step
/// from (q, v) then act in all of these steps. A step with MuJoCo's soft constraints is discontinuous where a
/// constraint starts or stops to act at a nonzero velocity. The derivative is that of the step on the side of
/// the state.
///
/// If the difference quotients of both sides differ, the column is computed again with 1/8 and 1/64 of the
/// increment, which distinguishes three cases:
///
/// | step near the state | result |
/// | --- | --- |
/// | has a kink, such as a contact that is about to slip | the mean of both sides |
/// | is discontinuous on one side, such as a contact that opens or closes at a nonzero velocity | the derivative of the other side: that of the step with its current contacts |
/// | is discontinuous on both sides | [`StepError::Discontinuous`] |
///
/// ```
/// use robot_dynamics::derivatives::{LinearizedStep, RobotState, linearize_by_differences};
/// use robot_dynamics::description::{Limits, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{ImplicitIntegrator, StepForces, StepWorkspace};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].limits = Limits::new(-0.2, 0.0); // the robot is at its stop
/// let model = Model::new(robot)?;
/// let (implicit, mut workspace, h) = (ImplicitIntegrator::new(&model), StepWorkspace::new(&model), 1e-3);
/// let (mut a, mut b) = ([0.0; 4], [0.0; 2]);
/// let push = [2.0 * 9.81 * 0.5 + 3.0]; // towards the stop, 3 N·m more than its weight requires
/// let forces = StepForces::new(&push, true);
/// let mut held = implicit.clone();
/// # use robot_dynamics::simulation::Stepper;
/// held.step(&model, &mut workspace, &forces, h, &mut [0.0], &mut [0.0])?;
/// let state = RobotState { q: &[0.0], v: &[0.0] };
/// let derivatives = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// linearize_by_differences(&model, &held, &mut workspace, &forces, h, state, derivatives)?;
/// assert!(b.iter().all(|b| b.abs() < 1e-9)); // the stop compensates any motor torque
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StepError`] if a step nearby fails; [`StepError::Discontinuous`].
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn linearize_by_differences<S: Stepper + Clone>(
    model: &Model,
    stepper: &S,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    RobotState { q, v }: RobotState<'_>,
    LinearizedStep { by_state, by_force }: LinearizedStep<'_>,
) -> Result<(), StepError> {
    let (nq, nv) = (model.nq(), model.nv());
    check_length("q", q.len(), nq);
    check_length("v", v.len(), nv);
    check_length("tau", forces.tau.len(), nv);
    check_length("A", by_state.len(), 4 * nv * nv);
    check_length("B", by_force.len(), 2 * nv * nv);
    let mut mass = vec![0.0; nv * nv];
    mass_matrix(model, workspace.dynamics(), q, &mut mass);
    let mut steps = PerturbedSteps::new(model, workspace, forces, h, (q, v));
    let (mut unmoved, mut stepper) = (stepper.clone(), stepper.clone());
    let middle = steps.take(&mut unmoved, 0, 0.0)?;
    // The constraints that act in this step also act in the perturbed steps.
    stepper.fix_active_set(unmoved.active_set());
    for column in 0..3 * nv {
        let k = column % nv;
        // The force that changes the velocity of coordinate k by that amount in the step, if no other
        // coordinate moves.
        let inertia = mass[k * nv + k];
        let unit = if column < 2 * nv || inertia <= 0.0 { 1.0 } else { inertia / h };
        let Some(derivatives) = column_of(|by| steps.quotients(&stepper, &middle, column, (by, unit)))?
        else {
            let quantity = ["q", "v", "tau"][column / nv];
            let coordinate = model.coordinate_names().get(k).cloned().unwrap_or_default();
            return Err(StepError::Discontinuous { quantity, coordinate });
        };
        for (row, slope) in derivatives.iter().enumerate() {
            match column.checked_sub(2 * nv) {
                Some(column) => by_force[row * nv + column] = slope / unit,
                None => by_state[row * 2 * nv + column] = *slope,
            }
        }
    }
    Ok(())
}

/// Steps from states near (q, v), and under forces near those given.
struct PerturbedSteps<'a> {
    model: &'a Model,
    workspace: &'a mut StepWorkspace,
    forces: &'a StepForces<'a>,
    h: f64,
    from: (&'a [f64], &'a [f64]),
    /// The displacement, and the perturbed state and forces.
    way: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
}

impl<'a> PerturbedSteps<'a> {
    fn new(
        model: &'a Model,
        workspace: &'a mut StepWorkspace,
        forces: &'a StepForces<'a>,
        h: f64,
        (q, v): (&'a [f64], &'a [f64]),
    ) -> Self {
        let zeros = || vec![0.0; model.nv()];
        let own = vec![0.0; model.nq()];
        Self { model, workspace, forces, h, from: (q, v), way: zeros(), q: own, v: zeros(), tau: zeros() }
    }

    /// The end (q₁, v₁) of a step with the entry `column` of (δq, δv, δτ) at `by`.
    fn take<S: Stepper>(
        &mut self,
        stepper: &mut S,
        column: usize,
        by: f64,
    ) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let Self { model, workspace, forces, h, from, way, q, v, tau } = self;
        let (part, k) = (column / model.nv(), column % model.nv());
        way.fill(0.0);
        way[k] = if part == 0 { by } else { 0.0 };
        integrate(model, from.0, way, q);
        v.copy_from_slice(from.1);
        v[k] += if part == 1 { by } else { 0.0 };
        tau.copy_from_slice(forces.tau);
        tau[k] += if part == 2 { by } else { 0.0 };
        let forces = StepForces::new(tau, forces.dissipation);
        stepper.step(model, workspace, &forces, *h, q, v)?;
        Ok((q.clone(), v.clone()))
    }

    /// The change (δq, δv) from one state to another, divided by `by`.
    fn slope(&self, from: &(Vec<f64>, Vec<f64>), to: &(Vec<f64>, Vec<f64>), by: f64) -> Vec<f64> {
        let nv = self.model.nv();
        let mut slope = vec![0.0; 2 * nv];
        difference(self.model, &from.0, &to.0, &mut slope[..nv]);
        (0..nv).for_each(|i| slope[nv + i] = to.1[i] - from.1[i]);
        for entry in &mut slope {
            *entry /= by;
        }
        slope
    }

    /// The difference quotients of a column, with an increment of `by` times the column's unit. `middle` is
    /// the end of the unperturbed step. Each step starts with a copy of the stepper.
    fn quotients<S: Stepper + Clone>(
        &mut self,
        stepper: &S,
        middle: &(Vec<f64>, Vec<f64>),
        column: usize,
        (by, unit): (f64, f64),
    ) -> Result<DifferenceQuotients, StepError> {
        let before = self.take(&mut stepper.clone(), column, -by * unit)?;
        let after = self.take(&mut stepper.clone(), column, by * unit)?;
        Ok(DifferenceQuotients {
            before: self.slope(&before, middle, by),
            after: self.slope(middle, &after, by),
            mean: self.slope(&before, &after, 2.0 * by),
        })
    }
}

/// The difference quotients of a column at one increment.
struct DifferenceQuotients {
    before: Vec<f64>,
    after: Vec<f64>,
    mean: Vec<f64>,
}

impl DifferenceQuotients {
    /// The largest difference of both sides, and the largest derivative.
    fn apart(&self) -> (f64, f64) {
        (farthest(&self.before, &self.after), self.mean.iter().fold(0.0, |most, slope| slope.abs().max(most)))
    }
}

/// The derivative of a column from the difference quotients at each increment; `None` if the step is
/// discontinuous on both sides.
fn column_of(
    mut at: impl FnMut(f64) -> Result<DifferenceQuotients, StepError>,
) -> Result<Option<Vec<f64>>, StepError> {
    let far = at(MOVE)?;
    let (far_apart, size) = far.apart();
    if far_apart <= AGREE * size.max(1.0) {
        return Ok(Some(far.mean));
    }
    let (middle, near) = (at(SHORTER * MOVE)?, at(SHORTER * SHORTER * MOVE)?);
    let (middle_apart, size) = middle.apart();
    let (near_apart, _) = near.apart();
    if near_apart > GROWS * middle_apart {
        // There is a discontinuity within the smallest increment; the difference quotient of the other side
        // is constant.
        let sides = [(near.before, &middle.before), (near.after, &middle.after)];
        let [before, after] = sides.map(|(slope, outer)| (farthest(&slope, outer), slope));
        let (moved, slope) = if before.0 < after.0 { before } else { after };
        return Ok((moved < STAYS * near_apart).then_some(slope));
    }
    let is_kink = |inner: f64, outer: f64| (outer / GROWS..=outer * GROWS).contains(&inner);
    let bends = (0.5 * SHORTER..2.0 * SHORTER).contains(&(middle_apart / far_apart));
    Ok(Some(if bends || is_kink(middle_apart, far_apart) && is_kink(near_apart, middle_apart) {
        // The largest increment has the least rounding.
        far.mean
    } else if middle_apart <= AGREE * size.max(1.0) {
        middle.mean
    } else {
        near.mean
    }))
}

/// The largest difference of two entries.
fn farthest(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).fold(0.0, |most, (x, y)| (x - y).abs().max(most))
}
