//! Functions in stages: a step with contact, whose sweeps are a loop that calls one expression.

use robot_dynamics::model::Model;
use robot_dynamics_expression::{Arithmetic, Graph, Plan, Sine};
use robot_dynamics_functions::TracedFunction;

use crate::layout::Layout;
use crate::program::{Case, Program, Stage, outcomes, random_arguments, uncertainty};
use crate::{Function, GenerateError};

/// The program of a step with contact, in stages.
pub(crate) fn contact_step(
    sweeps: u16,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Result<Program, GenerateError> {
    let function = Function::ContactStep { sweeps };
    let stage = |function: Function, repeats: usize| {
        let program = Program::new(&function, model, arithmetic, 1)?;
        let layout = Layout::straight(&program.graph, &program.plan);
        Ok::<_, GenerateError>(Stage { program, layout, repeats })
    };
    let stages = vec![
        stage(Function::ContactProblem, 1)?,
        stage(Function::ContactSweep, sweeps.into())?,
        stage(Function::ContactEnd, 1)?,
    ];
    let trace = |function: Function| function.trace(model, arithmetic);
    let traced =
        [trace(Function::ContactProblem)?, trace(Function::ContactSweep)?, trace(Function::ContactEnd)?];
    let (mut cases, mut tolerance) = (Vec::new(), 0.0_f64);
    for inputs in random_arguments(&function, model, arithmetic, states) {
        let results = evaluate(&traced, arithmetic, sweeps, &inputs);
        if arithmetic.sine == Sine::Platform {
            let own = evaluate(&traced, arithmetic.with_sine(Sine::Own), sweeps, &inputs);
            tolerance = tolerance.max(uncertainty(arithmetic, &results, &own));
        }
        cases.push(Case { arguments: inputs, results });
    }
    let graph = Graph::new(arithmetic.precision);
    Ok(Program {
        symbol: function.symbol(),
        arguments: function.arguments(model),
        outcomes: outcomes(&function, model),
        plan: Plan::new(&graph, &[]),
        graph,
        results: Vec::new(),
        cases,
        entries: Vec::new(),
        tolerance,
        stages,
        function,
    })
}

/// The values of a step in one state, stage by stage.
fn evaluate(
    [first, sweep, last]: &[TracedFunction; 3],
    arithmetic: Arithmetic,
    sweeps: u16,
    inputs: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let [q, _, _, h, _, impulses] = inputs else { unreachable!("six arguments") };
    let mut begun = first.evaluate_in(arithmetic, inputs).into_iter();
    let (problem, velocity) = (begun.next().expect("a problem"), begun.next().expect("a velocity"));
    let mut passed = vec![velocity, impulses.clone()];
    for _ in 0..sweeps {
        passed.insert(0, problem.clone());
        passed = sweep.evaluate_in(arithmetic, &passed);
    }
    let impulses = passed.pop().expect("multipliers");
    let velocity = passed.pop().expect("a velocity");
    let mut results = last.evaluate_in(arithmetic, &[problem, velocity, q.clone(), h.clone()]);
    results.push(impulses);
    results
}
