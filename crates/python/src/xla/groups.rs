//! The robots of the states of a call. One robot serves all states, unless the program computes a robot's
//! parameters. Then neighbouring states with the same parameters share a robot.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, TryLockError};

use rayon::prelude::*;
use robot_dynamics::derivatives::with_parameters;
use robot_dynamics::model::Model;

use crate::number::Number;
use crate::robot::Robot;
use crate::single_state::is_finite;
use crate::threads;

/// How many robots with computed parameters are kept: a program makes many calls with one robot.
const KEPT: usize = 8;

/// A robot with computed parameters: the fingerprint of the robot whose geometry it has, and the bits of the
/// parameters.
type KeyedRobot = (u64, Vec<u64>, Arc<Robot>);

static MADE: Mutex<VecDeque<KeyedRobot>> = Mutex::new(VecDeque::new());

/// Neighbouring states with the same parameters, if any.
struct Group {
    parameters: Option<Vec<f64>>,
    states: Range<usize>,
}

/// The slices that some states read and write, one for each table.
pub(super) type StateTables<'a, T> = (Vec<&'a [T]>, Vec<&'a mut [T]>);

/// The groups of all states; `parameters` are one row for all, or a row each.
fn groups_of<T: Number>(parameters: Option<&[T]>, count: usize, states: usize) -> Vec<Group> {
    let Some(parameters) = parameters else { return vec![Group { parameters: None, states: 0..states }] };
    let doubles = |row: &[T]| Some(row.iter().map(|x| x.double()).collect());
    if parameters.len() == count {
        return vec![Group { parameters: doubles(parameters), states: 0..states }];
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut last: &[T] = &[];
    for (state, row) in parameters.chunks_exact(count).enumerate() {
        let is_same = row.iter().zip(last).all(|(x, y)| x.double().to_bits() == y.double().to_bits());
        match groups.last_mut() {
            Some(group) if is_same => group.states.end = state + 1,
            _ => groups.push(Group { parameters: doubles(row), states: state..state + 1 }),
        }
        last = row;
    }
    groups
}

/// The robot with these parameters.
fn made(robot: &Robot, parameters: &[f64]) -> Result<Robot, String> {
    let description = with_parameters(&robot.model, parameters).map_err(|error| error.to_string())?;
    let model = Model::new(description).map_err(|error| error.to_string())?;
    Ok(Robot::of(model, robot.report.clone()))
}

/// The same, from the kept robots if it is one of them.
fn kept(robot: &Robot, parameters: &[f64]) -> Result<Arc<Robot>, String> {
    let of = robot.model.fingerprint();
    let bits: Vec<u64> = parameters.iter().map(|x| x.to_bits()).collect();
    // Not `lock`: a fork may have left it locked for ever. Without the lock, a new robot is made.
    let open = || match MADE.try_lock() {
        Ok(all) => Some(all),
        Err(TryLockError::Poisoned(all)) => Some(all.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    };
    if let Some(mut all) = open()
        && let Some(k) = all.iter().position(|(own, values, _)| *own == of && *values == bits)
        && let Some(found) = all.remove(k)
    {
        let robot = Arc::clone(&found.2);
        all.push_front(found);
        return Ok(robot);
    }
    let robot = Arc::new(made(robot, parameters)?);
    if let Some(mut all) = open() {
        all.push_front((of, bits, Arc::clone(&robot)));
        all.truncate(KEPT);
    }
    Ok(robot)
}

/// Does the work of each group with its robot: `threads` on one, or one on each of several. Parameters that
/// are not finite give results of NaN.
///
/// `work` gets the robot, the tables of its states, the number of states, and the number of threads.
pub(super) fn by_groups<'a, T: Number>(
    robot: &Robot,
    parameters: Option<&[T]>,
    states: usize,
    (read, mut written): StateTables<'a, T>,
    threads: usize,
    work: impl Fn(&Robot, StateTables<'a, T>, usize, usize) -> Result<(), String> + Sync,
) -> Result<(), String> {
    let count = robot_dynamics::derivatives::parameter_count(&robot.model);
    let mut groups = groups_of(parameters, count, states);
    if groups.len() <= 1 {
        return match groups.pop().and_then(|group| group.parameters) {
            None => work(robot, (read, written), states, threads),
            Some(parameters) if !is_finite(&parameters) => {
                fill_with_nan(written);
                Ok(())
            }
            Some(parameters) => work(&*kept(robot, &parameters)?, (read, written), states, threads),
        };
    }
    let widths: Vec<usize> = written.iter().map(|table| table.len() / states).collect();
    let parts: Vec<(Group, StateTables<'a, T>)> = groups
        .into_iter()
        .map(|group| {
            let of = |table: &&'a [T]| {
                let width = table.len() / states;
                &table[group.states.start * width..group.states.end * width]
            };
            let rows = written
                .iter_mut()
                .zip(&widths)
                .map(|(table, width)| table.split_off_mut(..group.states.len() * width).unwrap_or_default());
            let tables = (read.iter().map(of).collect(), rows.collect());
            (group, tables)
        })
        .collect();
    let run = |(group, tables): (Group, StateTables<'a, T>)| {
        let own = match &group.parameters {
            Some(parameters) if !is_finite(parameters) => {
                fill_with_nan(tables.1);
                return Ok(());
            }
            Some(parameters) => &made(robot, parameters)
                .map_err(|error| format!("parameters of state {}: {error}", group.states.start))?,
            None => robot,
        };
        work(own, tables, group.states.len(), 1)
    };
    if threads == 1 {
        return parts.into_iter().try_for_each(run);
    }
    let pool = threads::pool(threads).map_err(|error| error.to_string())?;
    pool.install(|| parts.into_par_iter().try_for_each(run))
}

/// Marks all results as invalid.
pub(super) fn fill_with_nan<T: Number>(written: Vec<&mut [T]>) {
    for table in written {
        table.fill(T::of(f64::NAN));
    }
}
