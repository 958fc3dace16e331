//! Machine code of a model's functions.

use expression::{Arithmetic, Traced};
use multibody::{
    InstructionSet, Model, NativeFunction, NativeTrace, Workspace, centroidal_momentum_matrix,
    gravity_derivative, inverse_pivots, kinetic_energy, potential_energy,
};

use number::Scalar;

use crate::{Function, FunctionError};

/// This model with its functions in machine code, made when each is first called: for inverse and forward dynamics, M and the others of
/// [`NativeFunction`] for one state and for batches, in `f64` and `f32`. Results differ from those of the recursions by rounding.
///
/// [`Model::with_native`] and the environment variable `ROBOT_DYNAMICS_NATIVE=0` switch it off; [`Model::native`] says what is compiled.
///
/// ```
/// use functions::with_native_code;
/// use multibody::{Model, Workspace, inverse_dynamics, pendulum};
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

/// The expression of one of these functions: the one of the same name, for a conservative step on a robot without dissipation. The pullbacks
/// of inverse and forward dynamics are those through the graph, which have half the operations of the recursions.
fn trace(
    model: &Model,
    function: NativeFunction,
    frame: Option<&str>,
    arithmetic: Arithmetic,
) -> Result<NativeTrace, String> {
    match function {
        NativeFunction::Energies => {
            let model = model.with_right_angles();
            return Ok(trace_call(arithmetic, vec![model.nq(), model.nv()], |arguments| {
                let (w, q, v) = (&mut memory(&model), &arguments[0], &arguments[1]);
                vec![vec![kinetic_energy(&model, w, q, v), potential_energy(&model, w, q)]]
            }));
        }
        NativeFunction::InversePivots => {
            let model = Function::ForwardDynamics.traced_model(model);
            let traced = trace_call(arithmetic, vec![model.nq()], |arguments| {
                inverse_pivots(&model, &arguments[0]).into_iter().collect()
            });
            let has_pivots = !traced.results.is_empty();
            return has_pivots.then_some(traced).ok_or("it is no tree: M has no pivots of joints".into());
        }
        NativeFunction::CentroidalMomentumMatrix => {
            let model = model.with_right_angles();
            return Ok(trace_matrix(arithmetic, &model, 6, centroidal_momentum_matrix));
        }
        NativeFunction::GravityDerivative => {
            let model = Function::Gravity.traced_model(model);
            return Ok(trace_matrix(arithmetic, &model, model.nv(), gravity_derivative));
        }
        _ => {}
    }
    let name = function.name();
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
        // The derivative by a is M, a function of its own.
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

/// The expression of results that these calls give.
fn trace_call(
    arithmetic: Arithmetic,
    lengths: Vec<usize>,
    compute: impl Fn(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> NativeTrace {
    let (graph, results) = expression::trace(arithmetic, &lengths, compute);
    NativeTrace { graph, results, lengths }
}

/// The expression of a matrix of so many rows of nv numbers that depends on q.
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
    use multibody::pendulum;

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
