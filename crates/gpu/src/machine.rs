//! One robot's functions on one device.

use core::marker::PhantomData;
use std::sync::Arc;

use robot_dynamics::batch::{BadStates, RolloutObserver, RolloutStates, Torques};
use robot_dynamics::derivatives::Rollout;
use robot_dynamics::model::Model;
use robot_dynamics_generate::{Function, Table};

use crate::backend::{Backend, Command};
use crate::compilation::{CompiledFunction, compile, in_parallel};
use crate::robot::{RobotConstants, mark_not_finite, marked_states};
use crate::{DeviceArray, DeviceError, DeviceFloat};

/// The interface of batches, for any device.
pub(crate) trait Engine<T>: Send + Sync {
    fn functions(&self) -> Vec<&Function>;

    fn compute(
        &mut self,
        function: &Function,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<(), DeviceError>;

    fn rollout(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        buffers: RolloutStates<'_, T>,
        progress: RolloutObserver<'_>,
    ) -> Result<(), DeviceError>;

    fn compute_arrays(
        &mut self,
        function: &Function,
        inputs: &[&DeviceArray<T>],
        outputs: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError>;

    fn rollout_arrays(
        &mut self,
        function: &Function,
        steps: usize,
        states: &[&DeviceArray<T>],
        held: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError>;

    #[cfg(feature = "cuda")]
    fn compute_on(&self, call: &crate::pointer_calls::Call<'_>) -> Result<(), DeviceError>;

    #[cfg(feature = "cuda")]
    fn rollout_on(&self, rollout: &crate::pointer_calls::DeviceRollout<'_>) -> Result<(), DeviceError>;
}

/// One robot's functions on one device: the implementation of [`Engine`].
pub(crate) struct Machine<B: Backend, T> {
    pub(crate) backend: Arc<B>,
    pub(crate) robot: RobotConstants,
    functions: Vec<CompiledFunction<B::Kernel>>,
    /// Buffers of earlier calls, with their sizes in bytes.
    memory: Vec<(usize, B::Buffer)>,
    of: PhantomData<fn(T) -> T>,
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    pub(crate) fn new(backend: Arc<B>, model: &Model, functions: &[Function]) -> Result<Self, DeviceError> {
        if !backend.has(T::PRECISION) {
            return Err(DeviceError::NoDoubles { device: backend.name().into() });
        }
        let compile = |function: &Function| compile(&*backend, model, T::PRECISION, function);
        let functions = in_parallel(functions, compile)?;
        Ok(Self {
            backend,
            robot: RobotConstants::new(model),
            functions,
            memory: Vec::new(),
            of: PhantomData,
        })
    }

    /// The index of a compiled function.
    pub(crate) fn find(&self, function: &Function) -> Result<usize, DeviceError> {
        let place = self.functions.iter().position(|compiled| compiled.function == *function);
        place.ok_or_else(|| {
            let names: Vec<String> = self.functions.iter().map(|there| there.function.to_string()).collect();
            DeviceError::NotCompiled { function: function.to_string(), compiled: names.join(", ") }
        })
    }

    pub(crate) fn function(&self, at: usize) -> &CompiledFunction<B::Kernel> {
        &self.functions[at]
    }

    /// The number of states that the device computes at once, in tables of at most `widest` numbers a state.
    pub(crate) fn states_at_once(&self, function: &Function, widest: usize) -> Result<usize, DeviceError> {
        let (bytes, most) = (widest * size_of::<T>(), self.backend.most_bytes());
        let states = (most / bytes.max(1)).min(self.backend.most_states());
        if states > 0 {
            return Ok(states);
        }
        let (device, function) = (self.backend.name().into(), function.to_string());
        Err(DeviceError::TooLarge { device, function, bytes, most })
    }

    /// Allocates buffers for tables with these counts of numbers, unless they are large enough.
    pub(crate) fn reserve(&mut self, numbers: &[usize]) -> Result<(), DeviceError> {
        for (at, numbers) in numbers.iter().enumerate() {
            let bytes = numbers * size_of::<T>();
            if self.memory.get(at).is_none_or(|(there, _)| *there < bytes) {
                let buffer = self.backend.allocate(bytes)?;
                self.memory.truncate(at);
                self.memory.push((bytes, buffer));
            }
        }
        Ok(())
    }

    /// The buffer of table `at`.
    pub(crate) fn buffer(&self, at: usize) -> &B::Buffer {
        &self.memory[at].1
    }

    /// Computes one chunk of states: copies arguments to the device, and results back.
    fn run(
        &self,
        compiled: &CompiledFunction<B::Kernel>,
        states: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<(), DeviceError> {
        for (at, rows) in inputs.iter().enumerate() {
            self.backend.write(self.buffer(at), bytemuck::cast_slice(rows))?;
        }
        let all = compiled.reads.iter().chain(&compiled.writes).enumerate();
        let tables: Vec<_> =
            all.map(|(at, table)| (self.buffer(at), table.width() * size_of::<T>())).collect();
        let launch = self.backend.bind(&compiled.kernel, &tables, states);
        self.backend.submit(&[Command::Run(&launch)])?;
        for (at, rows) in outputs.iter_mut().enumerate() {
            self.backend.read(self.buffer(inputs.len() + at), bytemuck::cast_slice_mut(rows))?;
        }
        Ok(())
    }
}

impl<B: Backend, T: DeviceFloat> Engine<T> for Machine<B, T> {
    fn functions(&self) -> Vec<&Function> {
        self.functions.iter().map(|compiled| &compiled.function).collect()
    }

    #[track_caller]
    fn compute(
        &mut self,
        function: &Function,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<(), DeviceError> {
        let at = self.find(function)?;
        let batch = count(self.function(at), inputs, outputs);
        if batch == 0 {
            return Ok(());
        }
        let CompiledFunction { reads, writes, .. } = self.function(at);
        let widths: Vec<usize> = reads.iter().chain(writes).map(Table::width).collect();
        let widest = widths.iter().copied().max().unwrap_or(1);
        let most = self.states_at_once(function, widest)?.min(batch);
        self.reserve(&widths.iter().map(|width| width * most).collect::<Vec<_>>())?;
        let mut bad = Vec::new();
        for first in (0..batch).step_by(most) {
            let states = most.min(batch - first);
            let (widths_in, widths_out) = widths.split_at(inputs.len());
            let inputs: Vec<&[T]> = (inputs.iter().zip(widths_in))
                .map(|(rows, width)| &rows[first * width..][..states * width])
                .collect();
            let mut outputs: Vec<&mut [T]> = (outputs.iter_mut().zip(widths_out))
                .map(|(rows, width)| &mut rows[first * width..][..states * width])
                .collect();
            let chunk = self.compute_chunk(at, states, &inputs, &mut outputs)?;
            bad.extend(chunk.iter().map(|state| first + state));
        }
        Ok(BadStates::unless_empty(bad, batch)?)
    }

    #[track_caller]
    fn rollout(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        buffers: RolloutStates<'_, T>,
        progress: RolloutObserver<'_>,
    ) -> Result<(), DeviceError> {
        self.roll_out(rollout, torques, buffers, progress)
    }

    fn compute_arrays(
        &mut self,
        function: &Function,
        inputs: &[&DeviceArray<T>],
        outputs: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        self.run_arrays(function, inputs, outputs)
    }

    fn rollout_arrays(
        &mut self,
        function: &Function,
        steps: usize,
        states: &[&DeviceArray<T>],
        held: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        self.roll_out_arrays(function, steps, states, held)
    }

    #[cfg(feature = "cuda")]
    fn compute_on(&self, call: &crate::pointer_calls::Call<'_>) -> Result<(), DeviceError> {
        self.run_call(call)
    }

    #[cfg(feature = "cuda")]
    fn rollout_on(&self, rollout: &crate::pointer_calls::DeviceRollout<'_>) -> Result<(), DeviceError> {
        self.run_rollout(rollout)
    }
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    /// Computes one chunk of states, sets the results of bad states to NaN, and returns these states.
    fn compute_chunk(
        &self,
        at: usize,
        states: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<Vec<usize>, DeviceError> {
        let compiled = self.function(at);
        self.run(compiled, states, inputs, outputs)?;
        let is_bad = self.bad_states(&compiled.reads, states, inputs, outputs);
        let bad: Vec<usize> = marked_states(&is_bad, 0).collect();
        for (rows, table) in outputs.iter_mut().zip(&compiled.writes) {
            let width = table.width();
            for state in &bad {
                rows[state * width..][..width].fill(T::NAN);
            }
        }
        Ok(bad)
    }

    /// For each state, whether a number, given or computed, is not finite, or the configuration is invalid.
    /// The CPU checks this, since a device may treat floats that are not finite differently.
    fn bad_states(&self, reads: &[Table], states: usize, inputs: &[&[T]], outputs: &[&mut [T]]) -> Vec<bool> {
        let mut is_bad = vec![false; states];
        for (table, rows) in reads.iter().zip(inputs) {
            mark_not_finite(rows, &mut is_bad);
            if table.name == "q" {
                self.robot.mark_invalid(rows, &mut is_bad);
            }
        }
        for rows in outputs {
            mark_not_finite(rows, &mut is_bad);
        }
        is_bad
    }
}

/// The number of states. Panics with both lengths if a table has the wrong one.
#[track_caller]
fn count<K, T>(compiled: &CompiledFunction<K>, inputs: &[&[T]], outputs: &[&mut [T]]) -> usize {
    let CompiledFunction { function, reads, writes, .. } = compiled;
    let (given, asked) = ((inputs.len(), outputs.len()), (reads.len(), writes.len()));
    assert!(
        given == asked,
        "{function} has {} tables of arguments and {} of results, got {} and {}",
        asked.0,
        asked.1,
        given.0,
        given.1
    );
    let (len, first) = (inputs[0].len(), &reads[0]);
    let width = first.width().max(1);
    assert!(len.is_multiple_of(width), "{} has {len} numbers, not a multiple of {width}", first.name);
    let batch = len / width;
    let lengths = inputs.iter().map(|rows| rows.len()).chain(outputs.iter().map(|rows| rows.len()));
    for (table, len) in reads.iter().chain(writes).zip(lengths) {
        check_table(table.name, len, batch, table.width());
    }
    batch
}

/// Panics with both lengths if a table has the wrong one.
#[track_caller]
pub(crate) fn check_table(name: &str, found: usize, batch: usize, width: usize) {
    let expected = batch * width;
    assert!(found == expected, "{name} has {found} numbers, expected {expected} ({batch} states of {width})");
}
