//! Machine code of a model's functions.

use expression::Arithmetic;
use multibody::{Model, NativeFunction, NativeTrace};

use crate::Function;

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

/// The expression of one of these functions.
fn trace(model: &Model, function: NativeFunction, arithmetic: Arithmetic) -> Result<NativeTrace, String> {
    let is_conservative = matches!(
        function,
        NativeFunction::ConservativeSemiImplicitEulerStep | NativeFunction::ConservativeRk4Step
    );
    let function = match function {
        NativeFunction::InverseDynamics => Function::InverseDynamics,
        NativeFunction::Bias => Function::Bias,
        NativeFunction::Gravity => Function::Gravity,
        NativeFunction::VelocityProduct => Function::VelocityProduct,
        NativeFunction::ForwardDynamics => Function::ForwardDynamics,
        NativeFunction::MassMatrix => Function::MassMatrix,
        NativeFunction::MassMatrixRelated => Function::MassMatrixRelated,
        NativeFunction::InverseMassMatrix => Function::InverseMassMatrix,
        NativeFunction::CoriolisMatrix => Function::CoriolisMatrix,
        NativeFunction::Momentum => Function::Momentum,
        NativeFunction::KineticEnergy => Function::KineticEnergy,
        NativeFunction::PotentialEnergy => Function::PotentialEnergy,
        NativeFunction::InverseDynamicsDerivatives => Function::InverseDynamicsDerivatives,
        NativeFunction::ForwardDynamicsDerivatives => Function::ForwardDynamicsDerivatives,
        NativeFunction::SemiImplicitEulerStep | NativeFunction::ConservativeSemiImplicitEulerStep => {
            Function::SemiImplicitEulerStep
        }
        NativeFunction::Rk4Step | NativeFunction::ConservativeRk4Step => Function::Rk4Step,
        _ => return Err("which has no expression".into()),
    };
    let conservative = is_conservative.then(|| model.without_dissipation());
    let model = conservative.as_ref().unwrap_or(model);
    let lengths = function.arguments(model).iter().map(|argument| argument.length).collect();
    let traced = function.trace(model, arithmetic).map_err(|error| error.to_string())?;
    let mut results = traced.results;
    if function == Function::InverseDynamicsDerivatives {
        // The derivative by a is M, a function of its own.
        results.truncate(2);
    }
    Ok(NativeTrace { graph: traced.graph, results, lengths })
}
