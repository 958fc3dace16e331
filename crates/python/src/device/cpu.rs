//! The same functions on this processor: machine code of the graph that the device's code is written from.
//! Where there is no encoder for the processor, the graph is interpreted, state by state.

use core::ops::Add;

use pyo3::prelude::*;
use rayon::prelude::*;
use robot_dynamics::model::Model;
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, interpret};
use robot_dynamics_functions::TracedFunction;
use robot_dynamics_generate::{Function, FunctionError, StageExpression, StagedFunction, Table};
use robot_dynamics_native::{Float, Kernel, Width, best_instructions};

use super::functions_of;
use crate::call::FEW_STATES;
use crate::errors::{Class, exception};
use crate::ffi::ArrayNumber;
use crate::ffi::device::slice_tables;
use crate::robot::Robot;
use crate::threads;

/// States that one thread computes at once: a multiple of the lanes of every register.
const STATES_PER_PIECE: usize = 256;

/// A number that is computed with on this processor.
trait CpuNumber: Float + ArrayNumber + Default + Add<Output = Self> {}

impl<T: Float + ArrayNumber + Default + Add<Output = T>> CpuNumber for T {}

/// A function of one robot for this processor.
struct CpuFunction<T> {
    function: Function,
    /// The count of numbers of each table, for one state.
    reads: Vec<usize>,
    writes: Vec<usize>,
    body: FunctionBody<T>,
}

/// One expression, or several in stages.
enum FunctionBody<T> {
    One(Box<Expression<T>>),
    Staged(StagedFunction, Vec<Expression<T>>),
}

/// An expression with its machine code.
struct Expression<T> {
    graph: Graph,
    plan: Plan,
    results: Vec<Vec<Operand>>,
    reads: Vec<usize>,
    writes: Vec<usize>,
    arithmetic: Arithmetic,
    /// `None` if the processor has no encoder, or the system refuses machine code.
    kernel: Option<Kernel<T>>,
}

/// The tables of some states.
struct Piece<'a, T> {
    states: usize,
    inputs: Vec<&'a [T]>,
    outputs: Vec<&'a mut [T]>,
}

impl<T: CpuNumber> CpuFunction<T> {
    fn new(model: &Model, function: Function) -> PyResult<Self> {
        let arithmetic = Arithmetic::new(T::PRECISION);
        let reads: Vec<usize> = function.reads(model).iter().map(Table::width).collect();
        let writes = function.writes(model).iter().map(Table::width).collect();
        // A step with contact is fastest as one expression, and its pullback has stages only.
        let staged = if matches!(function, Function::ContactStep { .. }) {
            None
        } else {
            StagedFunction::new(&function, model, arithmetic).transpose().map_err(exception)?
        };
        let body = if let Some(staged) = staged {
            let expression = |one: StageExpression<'_>| {
                Expression::new(one.graph, one.plan, one.results, one.reads(), arithmetic)
            };
            let all = staged.expressions().map(expression).collect();
            FunctionBody::Staged(staged, all)
        } else {
            let TracedFunction { graph, plan, results, .. } =
                &function.trace(model, arithmetic).map_err(exception)?;
            FunctionBody::One(Box::new(Expression::new(graph, plan, results, reads.clone(), arithmetic)))
        };
        Ok(Self { function, reads, writes, body })
    }

    /// The memory of a thread.
    fn scratch(&self) -> Vec<T> {
        let length = match &self.body {
            FunctionBody::One(expression) => expression.scratch_len(),
            FunctionBody::Staged(_, all) => all.iter().map(Expression::scratch_len).max().unwrap_or(0),
        };
        vec![T::nearest(0.0); length]
    }

    /// Computes states on these threads. `inputs` and `outputs` are the tables of all of them.
    fn compute(
        &self,
        states: usize,
        inputs: &[&[T]],
        outputs: Vec<&mut [T]>,
        threads: usize,
    ) -> Result<(), String> {
        let mut rest = outputs;
        let piece = |first: usize| {
            let states = STATES_PER_PIECE.min(states - first);
            let inputs = (inputs.iter().zip(&self.reads))
                .map(|(table, width)| &table[first * width..(first + states) * width])
                .collect();
            let outputs = (rest.iter_mut().zip(&self.writes))
                .map(|(table, width)| table.split_off_mut(..states * width).unwrap_or_default())
                .collect();
            Piece { states, inputs, outputs }
        };
        let pieces: Vec<_> = (0..states).step_by(STATES_PER_PIECE).map(piece).collect();
        if threads == 1 || pieces.len() == 1 {
            let mut scratch = self.scratch();
            for piece in pieces {
                self.compute_piece(piece, &mut scratch);
            }
            return Ok(());
        }
        threads::pool(threads).map_err(|error| error.to_string())?.install(|| {
            pieces
                .into_par_iter()
                .for_each_init(|| self.scratch(), |scratch, piece| self.compute_piece(piece, scratch));
        });
        Ok(())
    }

    fn compute_piece(&self, piece: Piece<'_, T>, scratch: &mut [T]) {
        let Piece { states, inputs, mut outputs } = piece;
        match &self.body {
            FunctionBody::One(expression) => expression.compute(states, &inputs, &mut outputs, scratch),
            FunctionBody::Staged(staged, all) => {
                staged.compute(states, &inputs, &mut outputs, |stage, inputs, outputs| {
                    all[stage].compute(states, inputs, outputs, scratch);
                });
            }
        }
    }
}

impl<T: CpuNumber> Expression<T> {
    fn new(
        graph: &Graph,
        plan: &Plan,
        results: &[Vec<Operand>],
        reads: Vec<usize>,
        arithmetic: Arithmetic,
    ) -> Self {
        let is_off = std::env::var_os("ROBOT_DYNAMICS_NATIVE").is_some_and(|value| value == "0");
        let compile =
            || Kernel::compile(graph, results, &reads, arithmetic, best_instructions(), Width::Lanes).ok();
        let kernel = if is_off { None } else { compile() };
        let writes = results.iter().map(Vec::len).collect();
        let (graph, plan, results) = (graph.clone(), plan.clone(), results.to_vec());
        Self { graph, plan, results, reads, writes, arithmetic, kernel }
    }

    fn scratch_len(&self) -> usize {
        self.kernel.as_ref().map_or(0, Kernel::scratch_len)
    }

    /// Computes states on tables by rows.
    fn compute(&self, states: usize, inputs: &[&[T]], outputs: &mut [&mut [T]], scratch: &mut [T]) {
        let Some(kernel) = &self.kernel else { return self.interpret(states, inputs, outputs) };
        let mut out_of_range = Vec::new();
        kernel.call_rows(states, inputs, outputs, scratch, |row| out_of_range.push(row));
        for row in out_of_range {
            for (output, width) in outputs.iter_mut().zip(&self.writes) {
                output[row * width..(row + 1) * width].fill(T::nearest(f64::NAN));
            }
        }
    }

    /// Interprets the graph for each state.
    fn interpret(&self, states: usize, inputs: &[&[T]], outputs: &mut [&mut [T]]) {
        let Self { graph, plan, results, .. } = self;
        for state in 0..states {
            let of = |(table, width): (&&[T], &usize)| {
                table[state * width..(state + 1) * width].iter().map(|x| x.double()).collect()
            };
            let arguments: Vec<Vec<f64>> = inputs.iter().zip(&self.reads).map(of).collect();
            let (values, _) = interpret(graph, plan, results, self.arithmetic, &arguments);
            for ((output, width), values) in outputs.iter_mut().zip(&self.writes).zip(&values) {
                for (number, value) in output[state * width..].iter_mut().zip(values) {
                    *number = T::nearest(*value);
                }
            }
        }
    }
}

enum Compiled {
    F32(Vec<CpuFunction<f32>>),
    F64(Vec<CpuFunction<f64>>),
}

/// Functions of a robot on this processor, with the arguments and results of those of a device.
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct CpuFunctions {
    compiled: Compiled,
}

#[pymethods]
impl CpuFunctions {
    /// Compiles functions of a robot.
    #[new]
    #[pyo3(signature = (robot, functions, single))]
    fn new(robot: &Bound<'_, Robot>, functions: Vec<String>, single: bool) -> PyResult<Self> {
        let (functions, model) = (functions_of(&functions)?, &robot.get().model);
        let compiled = robot.py().detach(|| {
            PyResult::Ok(if single {
                Compiled::F32(
                    functions.into_iter().map(|x| CpuFunction::new(model, x)).collect::<Result<_, _>>()?,
                )
            } else {
                Compiled::F64(
                    functions.into_iter().map(|x| CpuFunction::new(model, x)).collect::<Result<_, _>>()?,
                )
            })
        })?;
        Ok(Self { compiled })
    }

    /// Computes a function on arrays of numpy, which are contiguous and of the compiled type.
    #[pyo3(signature = (name, inputs, outputs))]
    fn _compute(
        &self,
        py: Python<'_>,
        name: &str,
        inputs: Vec<Bound<'_, PyAny>>,
        outputs: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        match &self.compiled {
            Compiled::F32(functions) => run(py, functions, name, &inputs, &outputs),
            Compiled::F64(functions) => run(py, functions, name, &inputs, &outputs),
        }
    }
}

impl CpuFunctions {
    /// Computes a function in float32, with errors as texts.
    pub(super) fn compute_f32(
        &self,
        name: &str,
        inputs: &[&[f32]],
        outputs: Vec<&mut [f32]>,
    ) -> Result<(), String> {
        match &self.compiled {
            Compiled::F32(functions) => compute(functions, name, inputs, outputs),
            Compiled::F64(_) => Err("the functions were compiled for float64".into()),
        }
    }

    /// Computes a function in float64, with errors as texts.
    pub(super) fn compute_f64(
        &self,
        name: &str,
        inputs: &[&[f64]],
        outputs: Vec<&mut [f64]>,
    ) -> Result<(), String> {
        match &self.compiled {
            Compiled::F64(functions) => compute(functions, name, inputs, outputs),
            Compiled::F32(_) => Err("the functions were compiled for float32".into()),
        }
    }
}

fn run<T: CpuNumber>(
    py: Python<'_>,
    functions: &[CpuFunction<T>],
    name: &str,
    inputs: &[Bound<'_, PyAny>],
    outputs: &[Bound<'_, PyAny>],
) -> PyResult<()> {
    let Some((inputs, outputs)) = slice_tables::<T>(inputs, outputs) else {
        let cause = format!("{name}: a result overlaps an argument or another result");
        return Err(Class::Shape.error(py, cause));
    };
    let done = py.detach(|| compute(functions, name, &inputs, outputs));
    done.map_err(|cause| Class::Device.error(py, cause))
}

/// Computes a function of the states in these tables.
fn compute<T: CpuNumber>(
    functions: &[CpuFunction<T>],
    name: &str,
    inputs: &[&[T]],
    outputs: Vec<&mut [T]>,
) -> Result<(), String> {
    let function: Function = name.parse().map_err(|error: FunctionError| error.to_string())?;
    let compiled = functions.iter().find(|compiled| compiled.function == function);
    let compiled =
        compiled.ok_or_else(|| format!("`{name}` was not compiled: pass it to `Device.compile`"))?;
    let states = inputs.first().map_or(0, |table| table.len()) / compiled.reads[0].max(1);
    let is_of = |len: usize, width: &usize| len == states * width;
    let fits = inputs.len() == compiled.reads.len()
        && outputs.len() == compiled.writes.len()
        && inputs.iter().zip(&compiled.reads).all(|(table, width)| is_of(table.len(), width))
        && outputs.iter().zip(&compiled.writes).all(|(table, width)| is_of(table.len(), width));
    if !fits {
        return Err(format!("`{name}`: the arrays do not hold {states} states"));
    }
    let threads = if states <= FEW_STATES { 1 } else { threads::default_count() };
    compiled.compute(states, inputs, outputs, threads)
}
