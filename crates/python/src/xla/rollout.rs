//! Rollouts, their pullbacks and their tangents.

use rayon::prelude::*;
use robot_dynamics::batch::{self, Rollout, RolloutError, Torques};
use robot_dynamics::derivatives::{
    LinearizeStepWorkspace, LinearizedStep, MotionCotangents, RobotState, StepPullbackWorkspace,
    linearize_step, step_pullback,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};

use super::calls::{NOT_FLOATS, length, parameters_of, robot_of};
use super::groups::{StateTables, by_groups, fill_with_nan};

use crate::ffi::Kind;
use crate::ffi::xla::XlaCall;
use crate::number::Number;
use crate::robot::Robot;
use crate::rollout::threads_for;
use crate::threads;

/// The parts that all calls about rollouts have in common.
struct RolloutCall {
    robot: &'static Robot,
    how: Rollout,
    /// `none`, `held` or `each`.
    torques: String,
    states: usize,
    threads: usize,
}

impl RolloutCall {
    fn of(call: &XlaCall<'_>) -> Result<Self, String> {
        let whole = |name| call.whole(name).map(|x| usize::try_from(x).unwrap_or(usize::MAX));
        let integrator =
            Integrator::from_name(call.text("integrator")?).map_err(|error| error.to_string())?;
        let how = Rollout::new(integrator, call.number("dt")?, whole("steps")?)
            .with_dissipation(call.truth("dissipation")?)
            .with_stride(whole("stride")?);
        let dims = call.arguments().first().map_or(&[][..], |array| array.dims);
        let states = dims[..dims.len().saturating_sub(1)].iter().copied().map(length).product::<usize>();
        let threads = threads_for(states * how.steps);
        Ok(Self { robot: robot_of(call)?, how, torques: call.text("torques")?.to_owned(), states, threads })
    }

    fn has_torques(&self) -> bool {
        self.torques != "none"
    }

    fn torques<'a, T>(&self, tau: &'a [T]) -> Torques<'a, T> {
        match &*self.torques {
            "none" => Torques::Zero,
            "held" => Torques::Held(tau),
            _ => Torques::EachStep(tau),
        }
    }

    /// Does the work of the states of each robot, with its tables, the number of states and the number of
    /// threads.
    fn run<'a, T: Number>(
        &self,
        mut call: XlaCall<'a>,
        work: impl Fn(&Self, &Robot, StateTables<'a, T>, usize, usize) -> Result<(), String> + Sync,
    ) -> Result<(), String> {
        let has_parameters = call.has_parameters();
        let (mut read, written) = call.take::<T>().ok_or(NOT_FLOATS)?;
        let parameters = parameters_of(self.robot, has_parameters, self.states, &mut read)?;
        if self.states == 0 {
            return Ok(());
        }
        let work = |robot: &Robot, tables: StateTables<'a, T>, states, threads| {
            work(self, robot, tables, states, threads)
        };
        by_groups(self.robot, parameters, self.states, (read, written), self.threads, work)
    }
}

/// The errors of a rollout, except those of bad states, whose rows are NaN.
fn error_of(outcome: Result<(), RolloutError>) -> Result<(), String> {
    match outcome {
        Ok(()) | Err(RolloutError::BadStates(_)) => Ok(()),
        Err(error) => Err(format!("rollout: {error}")),
    }
}

/// The next entry of a list; an error of the caller if none is left.
fn next<T>(list: &mut impl Iterator<Item = T>) -> Result<T, String> {
    list.next().ok_or_else(|| "the call has too few arrays".to_owned())
}

macro_rules! over_floats {
    ($call:ident, $function:ident) => {
        match $call.arguments().first().map(|array| array.kind) {
            Some(Kind::F32) => $function::<f32>($call),
            _ => $function::<f64>($call),
        }
    };
}

/// A rollout. It reads q, v, and the torques and the parameters if there are any. It writes q and v at the
/// end and along the trajectory.
pub(crate) fn rollout(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_over)
}

fn rollout_over<T: Number>(call: XlaCall<'_>) -> Result<(), String> {
    RolloutCall::of(&call)?.run(call, |rollout, robot, (read, written), _, threads| {
        let (mut read, mut written) = (read.into_iter(), written.into_iter());
        let (q0, v0) = (next(&mut read)?, next(&mut read)?);
        let tau = if rollout.has_torques() { next(&mut read)? } else { &[] };
        let (q, v) = (next(&mut written)?, next(&mut written)?);
        let trajectory = match rollout.how.stride {
            0 => (&mut [][..], &mut [][..]),
            _ => (next(&mut written)?, next(&mut written)?),
        };
        q.copy_from_slice(q0);
        v.copy_from_slice(v0);
        let mut memory = T::batches(robot).take(&robot.model, threads).map_err(|error| error.to_string())?;
        let (workspace, torques) = (&mut memory.workspace, rollout.torques(tau));
        let states = batch::RolloutStates { q, v, q_trajectory: trajectory.0, v_trajectory: trajectory.1 };
        let outcome = batch::rollout(&robot.model, workspace, &rollout.how, torques, states, None);
        T::batches(robot).give(memory);
        error_of(outcome)
    })
}

/// Its pullback. It reads q, v and the torques, the cotangents of the end and of the trajectory, and the
/// parameters. It writes the cotangents of the start, of the torques and of the parameters; all by
/// displacements.
pub(crate) fn rollout_pullback(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_pullback_over)
}

fn rollout_pullback_over<T: Number>(call: XlaCall<'_>) -> Result<(), String> {
    RolloutCall::of(&call)?.run(call, |rollout, robot, (read, written), _, threads| {
        let (mut read, mut written) = (read.into_iter(), written.into_iter());
        let (q, v) = (next(&mut read)?, next(&mut read)?);
        let tau = if rollout.has_torques() { next(&mut read)? } else { &[] };
        let (given_q, given_v) = (next(&mut read)?, next(&mut read)?);
        let trajectory = match rollout.how.stride {
            0 => (&[][..], &[][..]),
            _ => (next(&mut read)?, next(&mut read)?),
        };
        let (by_q, by_v) = (next(&mut written)?, next(&mut written)?);
        let by_tau = if rollout.has_torques() { next(&mut written)? } else { &mut [] };
        let by_parameters = written.next().unwrap_or_default();
        by_q.copy_from_slice(given_q);
        by_v.copy_from_slice(given_v);
        let mut memory = T::batches(robot).take(&robot.model, threads).map_err(|error| error.to_string())?;
        let inputs = batch::RolloutPullbackInputs {
            spacing: 0,
            torques: rollout.torques(tau),
            q,
            v,
            trajectory: batch::TrajectoryCotangents { by_position: trajectory.0, by_velocity: trajectory.1 },
        };
        let cotangents = batch::MotionCotangents {
            by_position: by_q,
            by_velocity: by_v,
            by_force: by_tau,
            parameters: by_parameters,
        };
        let outcome = batch::rollout_pullback(
            &robot.model,
            &mut memory.workspace,
            &rollout.how,
            &inputs,
            cotangents,
            None,
        );
        T::batches(robot).give(memory);
        error_of(outcome)
    })
}

/// Its tangent. It reads q, v and the torques, with the changes of each by displacements. It writes the
/// changes of the end and of the trajectory. Each step computes (δq, δv) ← A (δq, δv) + B δτ + P δp, in
/// float64. The parameters are p; δp has a row per state and is the last of the changes.
pub(crate) fn rollout_tangent(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_tangent_over)
}

fn rollout_tangent_over<T: Number>(call: XlaCall<'_>) -> Result<(), String> {
    RolloutCall::of(&call)?.run(call, |rollout, robot, (read, written), states, threads| {
        // The rows of each state.
        let mut rows: Vec<StateTables<'_, T>> = (0..states).map(|_| (Vec::new(), Vec::new())).collect();
        for table in read {
            for (row, part) in rows.iter_mut().zip(table.chunks_exact((table.len() / states).max(1))) {
                row.0.push(part);
            }
        }
        for table in written {
            for (row, part) in rows.iter_mut().zip(table.chunks_exact_mut((table.len() / states).max(1))) {
                row.1.push(part);
            }
        }
        let run = |(read, mut written): StateTables<'_, T>| {
            if tangent_of_one(robot, rollout, &read, &mut written).is_err() {
                fill_with_nan(written);
            }
        };
        if threads == 1 {
            rows.into_iter().for_each(run);
        } else {
            let pool = threads::pool(threads).map_err(|error| error.to_string())?;
            pool.install(|| rows.into_par_iter().for_each(run));
        }
        Ok(())
    })
}

fn tangent_of_one<T: Number>(
    robot: &Robot,
    rollout: &RolloutCall,
    read: &[&[T]],
    written: &mut [&mut [T]],
) -> Result<(), String> {
    let (how, model, nv) = (&rollout.how, &robot.model, robot.model.nv());
    let tables: Vec<Vec<f64>> = read.iter().map(|x| x.iter().map(|x| x.double()).collect()).collect();
    let mut tables = tables.into_iter();
    let (mut q, mut v) = (next(&mut tables)?, next(&mut tables)?);
    let tau = if rollout.has_torques() { next(&mut tables)? } else { Vec::new() };
    let (by_q, by_v) = (next(&mut tables)?, next(&mut tables)?);
    let by_tau = if rollout.has_torques() { next(&mut tables)? } else { Vec::new() };
    let by_parameters = tables.next();
    // (δq, δv, δτ)
    let mut change = [&by_q[..], &by_v, &vec![0.0; nv]].concat();
    let mut next = vec![0.0; 2 * nv];
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let (mut derivatives, mut mover) = (LinearizeStepWorkspace::new(model), StepWorkspace::new(model));
    let mut along_parameters = by_parameters.map(|change| ParameterDirection::new(model, change));
    let mut force = vec![0.0; nv];
    let mut sample = 0;
    for k in 0..how.steps {
        let rows = match &*rollout.torques {
            "none" => None,
            "held" => Some(0..nv),
            _ => Some(k * nv..(k + 1) * nv),
        };
        if let Some(rows) = rows {
            force.copy_from_slice(&tau[rows.clone()]);
            change[2 * nv..].copy_from_slice(&by_tau[rows]);
        }
        let forces = StepForces::new(&force, how.dissipation);
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        linearize_step(
            model,
            how.integrator,
            &mut derivatives,
            &forces,
            how.step,
            RobotState { q: &q, v: &v },
            out,
        )
        .map_err(|error| error.to_string())?;
        for (i, next) in next.iter_mut().enumerate() {
            let of_state = a[2 * nv * i..2 * nv * (i + 1)].iter().zip(&change[..2 * nv]);
            let of_force = b[nv * i..nv * (i + 1)].iter().zip(&change[2 * nv..]);
            *next = of_state.chain(of_force).map(|(slope, change)| slope * change).sum();
        }
        if let Some(along) = &mut along_parameters {
            along.add(model, how, &forces, &q, &v, &mut next)?;
        }
        step(model, how.integrator, &mut mover, &forces, how.step, &mut q, &mut v)
            .map_err(|error| error.to_string())?;
        change[..2 * nv].copy_from_slice(&next);
        if how.stride != 0 && (k + 1).is_multiple_of(how.stride) {
            for (table, part) in written[2..].iter_mut().zip(next.chunks_exact(nv.max(1))) {
                for (number, change) in table[sample * nv..].iter_mut().zip(part) {
                    *number = T::of(*change);
                }
            }
            sample += 1;
        }
    }
    for (table, part) in written.iter_mut().zip(change[..2 * nv].chunks_exact(nv.max(1))) {
        for (number, change) in table.iter_mut().zip(part) {
            *number = T::of(*change);
        }
    }
    Ok(())
}

/// P δp of one step, row by row of P by the step's pullback.
struct ParameterDirection {
    change: Vec<f64>,
    workspace: StepPullbackWorkspace,
    row: Vec<f64>,
    /// The cotangent, and the cotangents of q, v and τ that the pullback gives.
    cotangent: Vec<f64>,
    by_force: Vec<f64>,
}

impl ParameterDirection {
    fn new(model: &Model, change: Vec<f64>) -> Self {
        let nv = model.nv();
        Self {
            row: vec![0.0; change.len()],
            change,
            workspace: StepPullbackWorkspace::new(model),
            cotangent: vec![0.0; 2 * nv],
            by_force: vec![0.0; nv],
        }
    }

    /// Adds P δp of a step from q and v.
    fn add(
        &mut self,
        model: &Model,
        how: &Rollout,
        forces: &StepForces<'_>,
        q: &[f64],
        v: &[f64],
        moved: &mut [f64],
    ) -> Result<(), String> {
        let Self { change, workspace, row, cotangent, by_force } = self;
        for (i, moved) in moved.iter_mut().enumerate() {
            cotangent.fill(0.0);
            cotangent[i] = 1.0;
            row.fill(0.0);
            let (by_q, by_v) = cotangent.split_at_mut(model.nv());
            let cotangents =
                MotionCotangents { by_position: by_q, by_velocity: by_v, by_force, parameters: row };
            step_pullback(
                model,
                how.integrator,
                workspace,
                forces,
                how.step,
                RobotState { q, v },
                cotangents,
            )
            .map_err(|error| error.to_string())?;
            *moved += row.iter().zip(&*change).map(|(slope, change)| slope * change).sum::<f64>();
        }
        Ok(())
    }
}
