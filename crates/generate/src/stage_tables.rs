//! The tables of a function in stages, for many states by rows, and the execution of its instructions.

use crate::program::{Call, Instruction, Place, ProgramResult, Stages};

/// A table by rows.
struct RowTable<T> {
    name: String,
    width: usize,
    numbers: Vec<T>,
}

/// The tables of a function in stages.
pub(crate) struct StageTables<T> {
    states: usize,
    tables: Vec<RowTable<T>>,
}

impl<T: Copy + Default> StageTables<T> {
    /// Tables with these inputs. Results and tables between stages are 0.
    pub(crate) fn new(
        states: usize,
        stages: &Stages,
        inputs: Vec<(&str, &[T])>,
        outcomes: &[ProgramResult],
    ) -> Self {
        let given = inputs.into_iter().map(|(name, numbers)| RowTable {
            name: name.into(),
            width: numbers.len() / states,
            numbers: numbers.to_vec(),
        });
        let results = outcomes.iter().map(|outcome| (outcome.name.as_str(), outcome.length()));
        let locals = stages.locals.iter().copied();
        let others = results.chain(locals).map(|(name, width)| RowTable {
            name: name.into(),
            width,
            numbers: vec![T::default(); states * width],
        });
        Self { states, tables: given.chain(others).collect() }
    }

    /// The numbers of a table.
    pub(crate) fn table(&self, name: &str) -> &[T] {
        &self.at(name).numbers
    }

    fn at(&self, name: &str) -> &RowTable<T> {
        self.tables.iter().find(|table| table.name == name).expect("a table of the function")
    }

    fn at_mut(&mut self, name: &str) -> &mut RowTable<T> {
        self.tables.iter_mut().find(|table| table.name == name).expect("a table of the function")
    }

    /// A part of each row of a table.
    fn part(&self, place: &Place, width: usize) -> Vec<T> {
        let table = self.at(place.table());
        let rows = table.numbers.chunks(table.width.max(1));
        rows.flat_map(|row| &row[place.offset()..][..width]).copied().collect()
    }

    /// Changes a part of each row of a table by numbers with this width.
    fn change(&mut self, place: &Place, width: usize, numbers: &[T], change: impl Fn(T, T) -> T) {
        let table = self.at_mut(place.table());
        let rows = table.numbers.chunks_mut(table.width.max(1));
        for (row, numbers) in rows.zip(numbers.chunks(width.max(1))) {
            let part = row[place.offset()..][..width].iter_mut();
            part.zip(numbers).for_each(|(x, &y)| *x = change(*x, y));
        }
    }

    /// Executes instructions. `call` computes a stage by its index, of tables by rows.
    pub(crate) fn execute(
        &mut self,
        stages: &Stages,
        body: &[Instruction],
        call: &mut impl FnMut(usize, &[&[T]], &mut [&mut [T]]),
        add: &impl Fn(T, T) -> T,
    ) {
        for instruction in body {
            match instruction {
                Instruction::Call(Call { stage, arguments, results }) => {
                    let program = &stages.stages[*stage].program;
                    let inputs: Vec<Vec<T>> = (arguments.iter().zip(&program.arguments))
                        .map(|(place, argument)| self.part(place, argument.length))
                        .collect();
                    let widths: Vec<usize> = program.outcomes.iter().map(ProgramResult::length).collect();
                    let mut found: Vec<Vec<T>> =
                        widths.iter().map(|width| vec![T::default(); self.states * width]).collect();
                    let inputs: Vec<&[T]> = inputs.iter().map(Vec::as_slice).collect();
                    let mut outputs: Vec<&mut [T]> = found.iter_mut().map(Vec::as_mut_slice).collect();
                    call(*stage, &inputs, &mut outputs);
                    for ((place, width), numbers) in results.iter().zip(widths).zip(&found) {
                        self.change(place, width, numbers, |_, y| y);
                    }
                }
                Instruction::Clear { place, count } => {
                    let zeros = vec![T::default(); self.states * count];
                    self.change(place, *count, &zeros, |_, y| y);
                }
                Instruction::Copy { from, to, count } => {
                    let numbers = self.part(from, *count);
                    self.change(to, *count, &numbers, |_, y| y);
                }
                Instruction::Add { from, to, count } => {
                    let numbers = self.part(from, *count);
                    self.change(to, *count, &numbers, add);
                }
                Instruction::Repeat { count, body } => {
                    (0..*count).for_each(|_| self.execute(stages, body, call, add));
                }
            }
        }
    }
}
