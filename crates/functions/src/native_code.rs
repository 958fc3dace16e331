//! Machine code of a model's functions.

use robot_dynamics_core::{
    InstructionSet, Model, NativeFunction, NativeTrace, Workspace, centroidal_momentum_matrix,
    gravity_derivative, inverse_pivots, kinetic_energy, potential_energy,
};
use robot_dynamics_expression::{Arithmetic, Traced};
use robot_dynamics_number::Scalar;

use crate::{Function, FunctionError};

/// This model with its functions in machine code, compiled at the first call of each. The functions are those
/// of [`NativeFunction`], for one state and for batches, in `f64` and `f32`. Results differ from those of the
/// recursions by rounding.
///
/// [`Model::with_native`] and the environment variable `ROBOT_DYNAMICS_NATIVE=0` switch it off;
/// [`Model::native`] lists the compiled functions.
///
/// ```
/// use robot_dynamics::algorithms::inverse_dynamics;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// use robot_dynamics_functions::with_native_code;
/// let model = with_native_code(Model::new(pendulum(2.0, 0.5))?);
/// let mut tau = [0.0];
/// inverse_dynamics(&model, &mut Workspace::new(&model), &[0.3], &[1.0], &[2.0], &mut tau);
/// assert!((tau[0] - (2.0 * 0.25 * 2.0 - 2.0 * 9.81 * 0.5 * 0.3_f64.cos())).abs() < 1e-14);
/// println!("{}", model.native());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn with_native_code(model: Model) -> Model {
    model.with_tracer(trace)
}

/// The expression of one of these functions.
fn trace(
    model: &Model,
    function: NativeFunction,
    frame: Option<&str>,
    arithmetic: Arithmetic,
) -> Result<NativeTrace, String> {
    match function {
        NativeFunction::Energies => Ok(trace_energies(model, arithmetic)),
        NativeFunction::InversePivots => trace_inverse_pivots(model, arithmetic),
        NativeFunction::CentroidalMomentumMatrix => {
            let model = model.with_right_angles();
            Ok(trace_matrix(arithmetic, &model, 6, centroidal_momentum_matrix))
        }
        NativeFunction::GravityDerivative => {
            let model = Function::Gravity.traced_model(model);
            Ok(trace_matrix(arithmetic, &model, model.nv(), gravity_derivative))
        }
        _ => trace_named(model, function.name(), frame, arithmetic),
    }
}

/// The expression of kinetic and potential energy.
fn trace_energies(model: &Model, arithmetic: Arithmetic) -> NativeTrace {
    let model = model.with_right_angles();
    trace_call(arithmetic, vec![model.nq(), model.nv()], |arguments| {
        let (w, q, v) = (&mut memory(&model), &arguments[0], &arguments[1]);
        vec![vec![kinetic_energy(&model, w, q, v), potential_energy(&model, w, q)]]
    })
}

/// The expression of the inverse pivots of M.
fn trace_inverse_pivots(model: &Model, arithmetic: Arithmetic) -> Result<NativeTrace, String> {
    let model = Function::ForwardDynamics.traced_model(model);
    let traced = trace_call(arithmetic, vec![model.nq()], |arguments| {
        inverse_pivots(&model, &arguments[0]).into_iter().collect()
    });
    let has_pivots = !traced.results.is_empty();
    has_pivots.then_some(traced).ok_or("the joints do not form a tree, so M has no pivots of joints".into())
}

/// The expression of the [`Function`] with this name. A conservative step is the step of the same name on a
/// robot without dissipation. Pullbacks of inverse and forward dynamics are those through the graph, with
/// half the operations of the recursions.
fn trace_named(
    model: &Model,
    name: &str,
    frame: Option<&str>,
    arithmetic: Arithmetic,
) -> Result<NativeTrace, String> {
    let conservative = name.strip_prefix("conservative_");
    let name = conservative.unwrap_or(name);
    let name = frame.map_or_else(|| name.to_owned(), |frame| format!("{name}:{frame}"));
    let function: Function = name.parse().map_err(|error: FunctionError| error.to_string())?;
    let without_dissipation = conservative.map(|_| model.without_dissipation());
    let model = without_dissipation.as_ref().unwrap_or(model);
    let lengths = function.arguments(model).iter().map(|argument| argument.length).collect();
    let through_graph = match function {
        Function::InverseDynamicsPullback => Some(Function::InverseDynamics),
        Function::ForwardDynamicsPullback => Some(Function::ForwardDynamics),
        _ => None,
    };
    let traced_function =
        through_graph.map_or_else(|| function.clone(), |of| Function::Pullback(Box::new(of)));
    let traced = traced_function.expression(model, arithmetic).map_err(|error| error.to_string())?;
    let mut results = traced.results;
    match function {
        // The derivative with respect to a is M, a function of its own.
        Function::InverseDynamicsDerivatives => results.truncate(2),
        // The acceleration comes first.
        Function::ForwardDynamicsPullback => results.splice(..0, traced.primal).for_each(drop),
        _ => {}
    }
    if matches!(function, Function::FramePose(_)) {
        // One row for each state: R, then p.
        results = vec![results.concat()];
    }
    Ok(NativeTrace { graph: traced.graph, results, lengths })
}

/// The expression of the results of a call.
fn trace_call(
    arithmetic: Arithmetic,
    lengths: Vec<usize>,
    compute: impl Fn(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> NativeTrace {
    let (graph, results) = robot_dynamics_expression::trace(arithmetic, &lengths, compute);
    NativeTrace { graph, results, lengths }
}

/// The expression of a matrix with this number of rows and nv columns that depends on q.
fn trace_matrix(
    arithmetic: Arithmetic,
    model: &Model,
    rows: usize,
    compute: fn(&Model, &mut Workspace<Traced>, &[Traced], &mut [Traced]),
) -> NativeTrace {
    trace_call(arithmetic, vec![model.nq()], |arguments| {
        let mut matrix = vec![Traced::zero(); rows * model.nv()];
        compute(model, &mut memory(model), &arguments[0], &mut matrix);
        vec![matrix]
    })
}

fn memory(model: &Model) -> Workspace<Traced> {
    Workspace::limited(model, InstructionSet::Portable)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::pendulum;

    use super::*;

    #[test]
    fn every_function_has_an_expression() {
        let model = Model::new(pendulum(2.0, 0.5)).unwrap();
        for function in NativeFunction::ALL {
            let frame = NativeFunction::OF_FRAMES.contains(&function).then_some("tip");
            let traced = trace(&model, function, frame, Arithmetic::default());
            assert!(traced.is_ok_and(|traced| !traced.results.is_empty()), "{}", function.name());
        }
    }
}
