//! Functions and rollouts on memory of the caller, on the caller's stream. Nothing is copied, and no call
//! waits for the device.

use robot_dynamics_generate::{Function, Table};

use crate::backend::{Backend, CallerMemory};
use crate::machine::Machine;
use crate::pointer_calls::{Call, DeviceRollout, TableOrder};
use crate::step_tables::{StepTables, wrong};
use crate::{Batches, CallerStream, DeviceError, DeviceFloat, DevicePointer};

impl<T> Batches<T> {
    /// Computes a compiled function on memory of the caller. The kernel runs on the caller's stream: this
    /// call copies nothing and does not wait.
    ///
    /// Tables are in the order of [`Function::reads`] and [`Function::writes`]. Invalid states are not
    /// detected, because nobody looks at the numbers: results of numbers that are not finite, and of
    /// quaternions that are zero, are not finite. Those of an angle beyond the range of the sine (8192 rad in
    /// `f32`, 1e5 rad in `f64`) have no meaning.
    ///
    /// # Errors
    /// [`DeviceError::NotCompiled`]; [`DeviceError::Tables`] if the number or the length of tables is wrong,
    /// or if one that is written overlaps another; [`DeviceError::NoPointers`] on a device without CUDA;
    /// [`DeviceError::Failed`].
    pub fn compute_on(
        &self,
        stream: CallerStream,
        order: TableOrder,
        function: &Function,
        inputs: &[DevicePointer],
        outputs: &[DevicePointer],
    ) -> Result<(), DeviceError> {
        self.engine().compute_on(&Call { stream, order, function, inputs, outputs })
    }

    /// Simulates states in memory of the caller. All steps run on the caller's stream: this call copies
    /// nothing and does not wait.
    ///
    /// With two places the states alternate between them; with a place more than steps, all states are kept.
    /// The last states are in place `steps` mod n.
    ///
    /// # Errors
    /// As [`compute_on`](Self::compute_on).
    pub fn rollout_on(&self, rollout: &DeviceRollout<'_>) -> Result<(), DeviceError> {
        self.engine().rollout_on(rollout)
    }
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    pub(crate) fn run_call(&self, call: &Call<'_>) -> Result<(), DeviceError> {
        let at = self.find(call.function)?;
        let compiled = self.function(at);
        let tables = [call.inputs, call.outputs].concat();
        let shapes = (&compiled.reads[..], &compiled.writes[..]);
        let given = (call.inputs.len(), call.outputs.len());
        let states = check_tables::<T>(call.function, shapes, given, &tables)?;
        self.check_states(call.function, states)?;
        self.run_kernel(at, call.stream, call.order, &tables, states)
    }

    pub(crate) fn run_rollout(&self, rollout: &DeviceRollout<'_>) -> Result<(), DeviceError> {
        let at = self.find(rollout.function)?;
        let compiled = self.function(at);
        let plan = StepTables::of(rollout.function, &compiled.reads, &compiled.writes)?;
        let places = rollout.states.len();
        let count = plan.states.len();
        if places < 2 || rollout.states.iter().any(|place| place.len() != count) {
            let cause = format!("states need at least two places of {count} tables each");
            return Err(wrong(rollout.function, cause));
        }
        let numbers = rollout.states[0][0].numbers();
        let width = compiled.writes[plan.states[0].1].width();
        let states = numbers / width.max(1);
        self.check_states(rollout.function, states)?;
        for step in 0..rollout.steps {
            let (from, to) = (&rollout.states[step % places], &rollout.states[(step + 1) % places]);
            let tables = plan.tables::<T>(rollout, (from, to), step, states, &compiled.reads)?;
            if step < places {
                let shapes = (&compiled.reads[..], &compiled.writes[..]);
                let given = (compiled.reads.len(), compiled.writes.len());
                check_tables::<T>(rollout.function, shapes, given, &tables)?;
            }
            self.run_kernel(at, rollout.stream, rollout.order, &tables, states)?;
        }
        Ok(())
    }

    fn check_states(&self, function: &Function, states: usize) -> Result<(), DeviceError> {
        let most = self.backend.most_states();
        if states <= most {
            return Ok(());
        }
        Err(wrong(function, format!("{states} states, but a call computes at most {most}")))
    }

    fn run_kernel(
        &self,
        at: usize,
        stream: CallerStream,
        order: TableOrder,
        tables: &[DevicePointer],
        states: usize,
    ) -> Result<(), DeviceError> {
        if states == 0 {
            return Ok(());
        }
        let by_columns = order == TableOrder::Columns;
        let memory = CallerMemory { stream, tables, states, by_columns };
        self.backend.run_on(&self.function(at).kernel, &memory)
    }
}

impl StepTables {
    /// The tables of a step, read ones first.
    fn tables<T>(
        &self,
        rollout: &DeviceRollout<'_>,
        (from, to): (&[DevicePointer], &[DevicePointer]),
        step: usize,
        states: usize,
        reads: &[Table],
    ) -> Result<Vec<DevicePointer>, DeviceError> {
        if (rollout.held.len(), rollout.outputs.len()) != (self.held.len(), self.outputs.len()) {
            let (held, outputs) = (self.held.len(), self.outputs.len());
            let cause = format!(
                "a step reads {held} tables beside the states and writes {outputs}, got {} and {}",
                rollout.held.len(),
                rollout.outputs.len()
            );
            return Err(wrong(rollout.function, cause));
        }
        let mut tables = vec![from[0]; self.reads + self.states.len() + self.outputs.len()];
        for (k, (read, written)) in self.states.iter().enumerate() {
            tables[*read] = from[k];
            tables[self.reads + written] = to[k];
        }
        for (at, given) in self.held.iter().zip(rollout.held) {
            let own = states * reads[*at].width();
            let is_of_each_step = own > 0 && given.numbers() == own * rollout.steps;
            tables[*at] = if is_of_each_step { given.part(step, own, size_of::<T>()) } else { *given };
        }
        for (at, given) in self.outputs.iter().zip(rollout.outputs) {
            tables[self.reads + at] = *given;
        }
        Ok(tables)
    }
}

/// The number of states. Refuses wrong numbers and lengths of tables, and written ones that overlap another.
fn check_tables<T>(
    function: &Function,
    (reads, writes): (&[Table], &[Table]),
    given: (usize, usize),
    tables: &[DevicePointer],
) -> Result<usize, DeviceError> {
    if given != (reads.len(), writes.len()) {
        let (reads, writes) = (reads.len(), writes.len());
        let cause = format!("it reads {reads} tables and writes {writes}, got {} and {}", given.0, given.1);
        return Err(wrong(function, cause));
    }
    let (first, width) = (&tables[0], reads[0].width().max(1));
    let states = first.numbers() / width;
    for (table, pointer) in reads.iter().chain(writes).zip(tables) {
        let (found, expected) = (pointer.numbers(), states * table.width());
        if found != expected {
            let cause = format!(
                "{} has {found} numbers, expected {expected} ({states} states of {})",
                table.name,
                table.width()
            );
            return Err(wrong(function, cause));
        }
        if found > 0 && !pointer.address().is_multiple_of(size_of::<T>() as u64) {
            return Err(wrong(function, format!("the address of {} is not aligned", table.name)));
        }
    }
    let range = |pointer: &DevicePointer| {
        pointer.address()..pointer.address() + (pointer.numbers() * size_of::<T>()) as u64
    };
    for (written, table) in writes.iter().enumerate() {
        let at = reads.len() + written;
        let own = range(&tables[at]);
        let overlaps = |other: &DevicePointer| {
            let other = range(other);
            own.start < other.end && other.start < own.end
        };
        if tables[..at].iter().any(overlaps) {
            let cause = format!("{} overlaps another table of the call", table.name);
            return Err(wrong(function, cause));
        }
    }
    Ok(states)
}

#[cfg(test)]
mod tests {
    use robot_dynamics::description::pendulum;
    use robot_dynamics::model::Model;

    use super::*;

    fn pointer(address: u64, numbers: usize) -> DevicePointer {
        DevicePointer::of_test(address, numbers)
    }

    /// The count of states, or the error's text, for the bias of a pendulum: q and v, then the result.
    fn checked(tables: &[DevicePointer], given: (usize, usize)) -> Result<usize, String> {
        let model = Model::new(pendulum(2.0, 0.5)).unwrap();
        let function = Function::Bias;
        let shapes = (function.reads(&model), function.writes(&model));
        check_tables::<f64>(&function, (&shapes.0, &shapes.1), given, tables)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn tables_hold_the_same_states_and_do_not_overlap() {
        let [q, v, bias] = [pointer(0, 4), pointer(32, 4), pointer(64, 4)];
        assert_eq!(checked(&[q, v, bias], (2, 1)), Ok(4));
        assert_eq!(checked(&[q, q, bias], (2, 1)), Ok(4), "tables that are read may be the same");
        let error = |tables: &[DevicePointer]| checked(tables, (2, 1)).unwrap_err();
        assert!(error(&[q, pointer(32, 3), bias]).contains("v has 3 numbers, expected 4"));
        assert!(error(&[q, v, pointer(56, 4)]).contains("bias overlaps another table"));
        assert!(error(&[q, v, q]).contains("bias overlaps another table"));
        assert!(error(&[q, v, pointer(68, 4)]).contains("the address of bias is not aligned"));
        assert!(checked(&[q, v], (2, 0)).unwrap_err().contains("writes 1, got 2 and 0"));
        let none = pointer(0, 0);
        assert_eq!(checked(&[none, none, none], (2, 1)), Ok(0), "an empty batch has no memory");
    }

    #[test]
    fn steps_pass_states_on_and_take_the_torques_of_their_own() {
        let model = Model::new(pendulum(2.0, 0.5)).unwrap();
        let function = Function::Rk4Step;
        let (reads, writes) = (function.reads(&model), function.writes(&model));
        let plan = StepTables::of(&function, &reads, &writes).unwrap();
        let places = [vec![pointer(0, 2), pointer(16, 2)], vec![pointer(32, 2), pointer(48, 2)]];
        let (each, h) = (pointer(640, 6), pointer(960, 2));
        let mut rollout = DeviceRollout {
            stream: CallerStream::DEFAULT,
            order: TableOrder::Rows,
            function: &function,
            steps: 3,
            states: &places,
            held: &[each, h],
            outputs: &[],
        };
        let tables = |rollout: &DeviceRollout<'_>, step: usize| {
            plan.tables::<f64>(rollout, (&places[0], &places[1]), step, 2, &reads)
        };
        let expected = [places[0][0], places[0][1], pointer(640 + 2 * 16, 2), h, places[1][0], places[1][1]];
        assert_eq!(tables(&rollout, 2).unwrap(), expected);
        let held = [pointer(640, 2), h];
        rollout.held = &held;
        assert_eq!(tables(&rollout, 2).unwrap()[2], held[0]);
        rollout.held = &held[..1];
        assert!(tables(&rollout, 0).unwrap_err().to_string().contains("reads 2 tables beside the states"));
        assert!(StepTables::of(&Function::Bias, &reads[..2], &[]).is_err());
    }
}
