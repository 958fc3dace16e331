//! The discrete linear system of one step of any stepper, by differences.

use crate::model::length::check_length;
use crate::{Model, StepForces, StepWorkspace, Stepper, difference, integrate, mass_matrix};

/// By how much a coordinate or a velocity is moved to either side \[rad, m, rad/s, m/s\]. Half its square times the third derivative is
/// the error of a smooth step, 1e-10; the steps' own, about 1e-11 of the speeds, is divided by it.
const MOVE: f64 = 1e-5;

/// A and B of one step of any [`Stepper`], by central differences: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ, through contact, stops and dry friction.
///
/// The layout is that of [`linearize_step`](crate::linearize_step), which is exact, and faster, where the step is a row of explicit stages.
/// Here each column costs two steps, 6nv in all, each by a copy of `stepper` as it is given: its memory of the contacts of the step before is
/// where all of them start. So a stepper with contacts should have taken a step to (q, v): then what is in touch stays in touch when it is
/// moved off by 10 µm. Coordinates and velocities are moved by 1e-5 to either side, forces by so much that the velocities are
/// moved about as far.
///
/// Where a contact is neither firm nor free, as one that is about to slip, a step has no derivative; then the result is the mean of
/// both sides.
///
/// ```
/// use multibody::{Implicit, Limits, Model, StepForces, StepWorkspace, linearize_by_differences, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].limits = Limits::new(-0.2, 0.0); // it lies on its stop
/// let model = Model::new(robot)?;
/// let (implicit, mut workspace, h) = (Implicit::new(&model), StepWorkspace::new(&model), 1e-3);
/// let (mut a, mut b) = ([0.0; 4], [0.0; 2]);
/// let push = [2.0 * 9.81 * 0.5 + 3.0]; // against it, with 3 N·m more than its weight takes
/// let forces = StepForces::new(&push, true);
/// let mut held = implicit.clone();
/// # use multibody::Stepper;
/// held.step(&model, &mut workspace, &forces, h, &mut [0.0], &mut [0.0])?;
/// linearize_by_differences(&model, &held, &mut workspace, &forces, h, &[0.0], &[0.0], &mut a, &mut b)?;
/// assert!(b.iter().all(|b| b.abs() < 1e-9)); // whatever the motor gives, the stop takes it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The stepper's own: a step nearby could not be taken.
///
/// # Panics
/// If a slice has the wrong length.
#[allow(clippy::too_many_arguments)] // those of `linearize_step`
#[track_caller]
pub fn linearize_by_differences<S: Stepper + Clone>(
    model: &Model,
    stepper: &S,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    q: &[f64],
    v: &[f64],
    by_state: &mut [f64],
    by_force: &mut [f64],
) -> Result<(), S::Error> {
    let (nq, nv) = (model.nq(), model.nv());
    check_length("q", q.len(), nq);
    check_length("v", v.len(), nv);
    check_length("tau", forces.tau.len(), nv);
    check_length("A", by_state.len(), 4 * nv * nv);
    check_length("B", by_force.len(), 2 * nv * nv);
    let mut mass = vec![0.0; nv * nv];
    mass_matrix(model, workspace.dynamics(), q, &mut mass);
    let (mut q0, mut v0, mut tau) = (vec![0.0; nq], vec![0.0; nv], vec![0.0; nv]);
    let mut way = vec![0.0; nv];
    // Where the step leads from there, moved by `by` in the given column.
    let mut stepped = |column: usize, by: f64| -> Result<(Vec<f64>, Vec<f64>), S::Error> {
        let (part, k) = (column / nv, column % nv);
        way.fill(0.0);
        way[k] = if part == 0 { by } else { 0.0 };
        integrate(model, q, &way, &mut q0);
        v0.copy_from_slice(v);
        v0[k] += if part == 1 { by } else { 0.0 };
        tau.copy_from_slice(forces.tau);
        tau[k] += if part == 2 { by } else { 0.0 };
        let forces = StepForces::new(&tau, forces.dissipation);
        stepper.clone().step(model, workspace, &forces, h, &mut q0, &mut v0)?;
        Ok((q0.clone(), v0.clone()))
    };
    let mut moved = vec![0.0; nv];
    for column in 0..3 * nv {
        let k = column % nv;
        // The force that gives coordinate k that velocity in the step, were it alone.
        let inertia = mass[k * nv + k];
        let by = if column < 2 * nv || inertia <= 0.0 { MOVE } else { MOVE * inertia / h };
        let ((q_before, v_before), (q_after, v_after)) = (stepped(column, -by)?, stepped(column, by)?);
        difference(model, &q_before, &q_after, &mut moved);
        for i in 0..nv {
            for (row, change) in [(i, moved[i]), (nv + i, v_after[i] - v_before[i])] {
                let slope = change / (2.0 * by);
                match column.checked_sub(2 * nv) {
                    Some(column) => by_force[row * nv + column] = slope,
                    None => by_state[row * 2 * nv + column] = slope,
                }
            }
        }
    }
    Ok(())
}
