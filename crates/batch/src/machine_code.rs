//! Batches computed by machine code.

#[cfg(feature = "native")]
pub(super) use self::compute::{kernel, natively};

/// Without machine code the recursions compute everything.
#[cfg(not(feature = "native"))]
pub(super) use self::absent::{Number, natively};
#[cfg(feature = "native")]
pub(super) use robot_dynamics_core::model::native::Number;

#[cfg(feature = "native")]
mod compute {
    use robot_dynamics_core::Model;
    use robot_dynamics_core::model::native::NativeTask;
    use robot_dynamics_native::{Kernel, best_instructions};
    use robot_dynamics_number::Float;

    use super::Number;
    use crate::bad_states::BadStateSet;
    use crate::distribution::for_each_part;
    use crate::tables::InputTables;
    use crate::workspace::BlockMemory;
    use crate::{BadStates, BatchWorkspace};

    /// The number of states per call of machine code; their rows stay in the cache until they are checked.
    const STATES: usize = 128;

    /// The most parts of this size that a thread takes at once.
    const PARTS_PER_CHUNK: usize = 2;

    /// The number of parallel sums of 0·x.
    const SUMS: usize = 8;

    /// The machine code of a function for batches, unless the workspace is limited to older instructions.
    pub(crate) fn kernel<'a, T: Float + Number>(
        model: &'a Model,
        workspace: &BatchWorkspace<T>,
        task: impl Into<NativeTask>,
    ) -> Option<&'a Kernel<T>> {
        let code = model.native.code().filter(|_| workspace.instruction_set() == best_instructions())?;
        code.rows(model, task)
    }

    /// Computes the function of each state, or returns the result tables if there is no machine code. If an
    /// angle is outside the range of the code's sine, `again` computes that state by the recursion and
    /// returns whether the result is valid.
    pub(crate) fn natively<'a, T: Float + Number, const A: usize, const K: usize>(
        model: &Model,
        workspace: &BatchWorkspace<T>,
        task: impl Into<NativeTask>,
        tables: &InputTables<'_, T, A>,
        results: [&'a mut [T]; K],
        again: &(impl Fn(&mut BlockMemory, [&[T]; A], [&mut [T]; K]) -> bool + Sync),
    ) -> Result<Result<(), BadStates>, [&'a mut [T]; K]> {
        let Some(kernel) = kernel(model, workspace, task) else { return Err(results) };
        let batch = tables.count(model);
        let count = tables.names.iter().filter(|name| !name.is_empty()).count();
        let used = results.iter().filter(|rows| !rows.is_empty()).count();
        let bad = BadStateSet::default();
        let parts = (STATES, PARTS_PER_CHUNK);
        for_each_part(workspace, batch, parts, results, &|memory, first, states, mut results| {
            if memory.native.len() < kernel.scratch_len() {
                memory.native.resize(kernel.scratch_len(), T::zero());
            }
            let arguments = tables.rows(first, states);
            let mut far = Vec::new();
            let mut is_finite = kernel.call_rows(
                states,
                &arguments[..count],
                &mut results[..used],
                &mut memory.native,
                |state| {
                    far.push(state);
                },
            );
            for state in far {
                let of_state = results.each_mut().map(|rows| row(rows, state, states));
                is_finite &= again(&mut memory.block, tables.rows(first + state, 1), of_state);
            }
            if is_finite && arguments.iter().all(|rows| are_finite(rows)) {
                return;
            }
            for state in 0..states {
                let results = results.each_mut().map(|rows| row(rows, state, states));
                let arguments = tables.rows(first + state, 1);
                if !arguments.iter().all(|row| are_finite(row)) || !results.iter().all(|row| are_finite(row))
                {
                    for row in results {
                        row.fill(T::from_f64(f64::NAN));
                    }
                    bad.add(1, first + state);
                }
            }
        });
        Ok(bad.into_result(batch))
    }

    /// The row of one state in the rows of several states.
    fn row<T>(rows: &mut [T], state: usize, states: usize) -> &mut [T] {
        let width = rows.len() / states;
        &mut rows[state * width..(state + 1) * width]
    }

    /// Whether all numbers are finite.
    fn are_finite<T: Float>(numbers: &[T]) -> bool {
        let mut sums = [T::zero(); SUMS];
        let (eights, rest) = numbers.as_chunks::<SUMS>();
        for eight in eights {
            for (sum, &x) in sums.iter_mut().zip(eight) {
                *sum += x * T::zero();
            }
        }
        for (sum, &x) in sums.iter_mut().zip(rest) {
            *sum += x * T::zero();
        }
        sums.into_iter().all(|sum| sum == T::zero())
    }
}

#[cfg(not(feature = "native"))]
mod absent {
    use robot_dynamics_core::Model;
    use robot_dynamics_core::model::native::NativeTask;
    use robot_dynamics_number::Float;

    use crate::tables::InputTables;
    use crate::workspace::BlockMemory;
    use crate::{BadStates, BatchWorkspace};

    pub(crate) trait Number {}
    impl Number for f64 {}
    impl Number for f32 {}

    pub(crate) fn natively<'a, T: Float, const A: usize, const K: usize>(
        _: &Model,
        _: &BatchWorkspace<T>,
        _: impl Into<NativeTask>,
        _: &InputTables<'_, T, A>,
        results: [&'a mut [T]; K],
        _: &impl Fn(&mut BlockMemory, [&[T]; A], [&mut [T]; K]) -> bool,
    ) -> Result<Result<(), BadStates>, [&'a mut [T]; K]> {
        Err(results)
    }
}
