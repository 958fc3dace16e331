//! Functions and rollouts on arrays of the device.

use robot_dynamics_generate::Function;

use crate::backend::{Backend, Command};
use crate::machine::Machine;
use crate::step_tables::{StepTables, wrong};
use crate::{Batches, DeviceArray, DeviceError, DeviceFloat};

/// The largest number of steps in one submission.
const STEPS_PER_SUBMISSION: usize = 64;

impl<T: DeviceFloat> Batches<T> {
    /// Computes a compiled function on arrays of its device. Nothing is copied to or from the host.
    ///
    /// Tables are in the order of [`Function::reads`] and [`Function::writes`]. Invalid states are not
    /// detected: their results are not finite, or have no meaning where an angle is beyond the range of the
    /// sine.
    ///
    /// ```
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// use robot_dynamics_gpu::{Device, Function};
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let mut pendulums = device.compile::<f32>(&model, &[Function::Gravity])?;
    /// let (q, mut g) = (device.array(&[0.0_f32; 1000])?, device.array(&[0.0_f32; 1000])?);
    /// pendulums.compute_arrays(&Function::Gravity, &[&q], &mut [&mut g])?;
    /// let mut found = [0.0; 1000];
    /// g.read(&mut found)?;
    /// assert!(found.iter().all(|g| (g + 9.81).abs() < 1e-5)); // −m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::NotCompiled`]; [`DeviceError::Tables`] if the number or the length of tables is wrong,
    /// or an array is on another device; [`DeviceError::Failed`].
    pub fn compute_arrays(
        &mut self,
        function: &Function,
        inputs: &[&DeviceArray<T>],
        outputs: &mut [&mut DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        let outputs: Vec<&DeviceArray<T>> = outputs.iter().map(|output| &**output).collect();
        self.engine_mut().compute_arrays(function, inputs, &outputs)
    }

    /// Takes steps of states in arrays of the device, in place. Nothing is copied to or from the host.
    ///
    /// `states` are the tables that the step writes under a name `x_next` and reads under the name `x`, in
    /// the order of [`Function::writes`]: q and v. `held` are the other tables that it reads: τ and h.
    ///
    /// ```
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// use robot_dynamics_gpu::{Device, Function};
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let step = Function::Rk4Step;
    /// let mut pendulums = device.compile::<f32>(&model, &[step.clone()])?;
    /// let (mut q, mut v) = (device.array(&[0.0_f32; 8])?, device.array(&[0.0_f32; 8])?);
    /// let (tau, h) = (device.array(&[0.0_f32; 8])?, device.array(&[1e-3_f32; 8])?);
    /// pendulums.rollout_arrays(&step, 200, &mut [&mut q, &mut v], &[&tau, &h])?;
    /// let (mut angle, mut rate) = ([0.0; 8], [0.0; 8]);
    /// q.read(&mut angle)?;
    /// v.read(&mut rate)?;
    /// // Energy is conserved: ½ l v² = g sin q.
    /// assert!((0.25 * rate[7] * rate[7] - 9.81 * angle[7].sin()).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`compute_arrays`](Self::compute_arrays). The states are invalid after [`DeviceError::Failed`].
    pub fn rollout_arrays(
        &mut self,
        function: &Function,
        steps: usize,
        states: &mut [&mut DeviceArray<T>],
        held: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        let states: Vec<&DeviceArray<T>> = states.iter().map(|state| &**state).collect();
        self.engine_mut().rollout_arrays(function, steps, &states, held)
    }
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    /// See [`Batches::compute_arrays`].
    pub(crate) fn run_arrays(
        &self,
        function: &Function,
        inputs: &[&DeviceArray<T>],
        outputs: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        let at = self.find(function)?;
        let (reads, writes) = (self.function(at).reads.len(), self.function(at).writes.len());
        if (inputs.len(), outputs.len()) != (reads, writes) {
            let cause = format!(
                "it reads {reads} tables and writes {writes}, got {} and {}",
                inputs.len(),
                outputs.len()
            );
            return Err(wrong(function, cause));
        }
        let arrays: Vec<&DeviceArray<T>> = inputs.iter().chain(outputs).copied().collect();
        let states = self.check_arrays(at, &arrays)?;
        if states == 0 {
            return Ok(());
        }
        let launch = self.bind_tables(at, &self.buffers(function, &arrays)?, states);
        self.backend.submit(&[Command::Run(&launch)])
    }

    /// See [`Batches::rollout_arrays`].
    pub(crate) fn roll_out_arrays(
        &mut self,
        function: &Function,
        steps: usize,
        given: &[&DeviceArray<T>],
        held: &[&DeviceArray<T>],
    ) -> Result<(), DeviceError> {
        let at = self.find(function)?;
        let compiled = self.function(at);
        let plan = StepTables::of(function, &compiled.reads, &compiled.writes)?;
        let counts = (plan.states.len(), plan.held.len());
        if (given.len(), held.len()) != counts || !plan.outputs.is_empty() {
            let cause = format!("a rollout has {} tables of states and {} others", counts.0, counts.1);
            return Err(wrong(function, cause));
        }
        let mut arrays = vec![given[0]; plan.reads + counts.0];
        for (k, (read, written)) in plan.states.iter().enumerate() {
            (arrays[*read], arrays[plan.reads + written]) = (given[k], given[k]);
        }
        plan.held.iter().zip(held).for_each(|(read, array)| arrays[*read] = array);
        let states = self.check_arrays(at, &arrays)?;
        if states == 0 || steps == 0 {
            return Ok(());
        }
        let buffers = self.buffers(function, &arrays)?;
        let own: Vec<&B::Buffer> = plan.states.iter().map(|(read, _)| buffers[*read]).collect();
        self.reserve(&given.iter().map(|array| array.len()).collect::<Vec<_>>())?;
        let launches = [false, true].map(|is_odd| {
            let mut tables = buffers.clone();
            for (k, (read, written)) in plan.states.iter().enumerate() {
                let pair = [own[k], self.buffer(k)];
                tables[*read] = pair[usize::from(is_odd)];
                tables[plan.reads + written] = pair[usize::from(!is_odd)];
            }
            self.bind_tables(at, &tables, states)
        });
        for first in (0..steps).step_by(STEPS_PER_SUBMISSION) {
            let steps = first..steps.min(first + STEPS_PER_SUBMISSION);
            let commands: Vec<_> = steps.map(|step| Command::Run(&launches[step % 2])).collect();
            self.backend.submit(&commands)?;
        }
        if steps.is_multiple_of(2) {
            return Ok(());
        }
        let copies: Vec<_> = (own.iter().zip(given).enumerate())
            .map(|(k, (to, array))| {
                let bytes = array.len() * size_of::<T>();
                Command::Copy { from: self.buffer(k), from_at: 0, to: *to, to_at: 0, bytes }
            })
            .collect();
        self.backend.submit(&copies)
    }

    /// The number of states in these arrays, in the order of the tables.
    fn check_arrays(&self, at: usize, arrays: &[&DeviceArray<T>]) -> Result<usize, DeviceError> {
        let compiled = self.function(at);
        let tables = || compiled.reads.iter().chain(&compiled.writes);
        let states = arrays[0].len() / compiled.reads[0].width().max(1);
        for (table, array) in tables().zip(arrays) {
            let expected = states * table.width();
            if array.len() != expected {
                let (name, width, found) = (table.name, table.width(), array.len());
                let cause =
                    format!("{name} has {found} numbers, expected {expected} ({states} states of {width})");
                return Err(wrong(&compiled.function, cause));
            }
        }
        let widest = tables().map(robot_dynamics_generate::Table::width).max().unwrap_or(1);
        let most = self.states_at_once(&compiled.function, widest)?;
        if states > most {
            let cause = format!("{states} states, but the device computes at most {most} at once");
            return Err(wrong(&compiled.function, cause));
        }
        Ok(states)
    }

    fn buffers<'a>(
        &self,
        function: &Function,
        arrays: &[&'a DeviceArray<T>],
    ) -> Result<Vec<&'a B::Buffer>, DeviceError> {
        let buffer = |array: &&'a DeviceArray<T>| {
            let cause = || format!("an array is on {}, not on {}", array.device(), self.backend.name());
            array.buffer_of(&self.backend).ok_or_else(|| wrong(function, cause()))
        };
        arrays.iter().map(buffer).collect()
    }

    fn bind_tables(&self, at: usize, buffers: &[&B::Buffer], states: usize) -> B::Launch {
        let compiled = self.function(at);
        let widths =
            compiled.reads.iter().chain(&compiled.writes).map(|table| table.width() * size_of::<T>());
        let tables: Vec<_> = buffers.iter().copied().zip(widths).collect();
        self.backend.bind(&compiled.kernel, &tables, states)
    }
}
