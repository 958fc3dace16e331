//! Functions in stages on the processor.

use core::ops::Add;

use robot_dynamics::model::Model;
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan};

use crate::program::{Program, ProgramResult, Stages, outcomes};
use crate::stage_tables::StageTables;
use crate::stages::stages_of;
use crate::{Function, GenerateError};

/// A function that is computed in stages, such as the pullback of a step with contact: expressions, and the
/// order in which they are called.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_generate::{Arithmetic, Function, StagedFunction};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let pullback = Function::ContactStep { sweeps: 4 }.pullback();
/// let staged = StagedFunction::new(&pullback, &model, Arithmetic::default()).ok_or("one expression")??;
/// assert_eq!(staged.expressions().count(), 5);
/// assert!(StagedFunction::new(&Function::Gravity, &model, Arithmetic::default()).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StagedFunction {
    arguments: Vec<&'static str>,
    outcomes: Vec<ProgramResult>,
    stages: Stages,
}

/// The expression of a stage.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StageExpression<'a> {
    /// Its operations.
    pub graph: &'a Graph,
    /// The order of its operations.
    pub plan: &'a Plan,
    /// Its results, matrices by rows.
    pub results: &'a [Vec<Operand>],
    program: &'a Program,
}

impl StageExpression<'_> {
    /// The count of numbers of each argument.
    pub fn reads(&self) -> Vec<usize> {
        self.program.arguments.iter().map(|argument| argument.length).collect()
    }
}

impl StagedFunction {
    /// The stages of a function, or `None` if it is one expression.
    ///
    /// # Errors
    /// [`GenerateError`]: an unsupported robot.
    pub fn new(
        function: &Function,
        model: &Model,
        arithmetic: Arithmetic,
    ) -> Option<Result<Self, GenerateError>> {
        let stages = stages_of(function, model, arithmetic)?;
        let arguments = function.arguments(model).into_iter().map(|argument| argument.name).collect();
        Some(stages.map(|stages| Self { arguments, outcomes: outcomes(function, model), stages }))
    }

    /// The expressions of its stages.
    pub fn expressions(&self) -> impl Iterator<Item = StageExpression<'_>> {
        self.stages.stages.iter().map(|stage| {
            let Program { graph, plan, results, .. } = &stage.program;
            StageExpression { graph, plan, results, program: &stage.program }
        })
    }

    /// Computes states on tables by rows. `call` computes a stage, given by its index.
    ///
    /// # Panics
    /// If the number of tables is wrong.
    #[track_caller]
    pub fn compute<T: Copy + Default + Add<Output = T>>(
        &self,
        states: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        mut call: impl FnMut(usize, &[&[T]], &mut [&mut [T]]),
    ) {
        assert_eq!((inputs.len(), outputs.len()), (self.arguments.len(), self.outcomes.len()), "tables");
        if states == 0 {
            return;
        }
        let inputs = self.arguments.iter().copied().zip(inputs.iter().copied()).collect();
        let mut tables = StageTables::new(states, &self.stages, inputs, &self.outcomes);
        tables.execute(&self.stages, &self.stages.body, &mut call, &|x, y| x + y);
        for (output, outcome) in outputs.iter_mut().zip(&self.outcomes) {
            output.copy_from_slice(tables.table(&outcome.name));
        }
    }
}
