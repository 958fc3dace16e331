//! The library's algorithms over any number: over the tracing number, and over floats to compare with.

use robot_dynamics_core::{FrameId, InstructionSet, Model, Workspace};
use robot_dynamics_integrators::{Integrator, StepScheme};
use robot_dynamics_number::Scalar;
use robot_dynamics_simulation::{ContactStep, ContactStepInputs, StepForces, StepStagesWorkspace};

use crate::{Function, FunctionError, FunctionResult};
use robot_dynamics_description::Pose;

impl Function {
    /// Computes the function's results, each by rows, by the library's calls over any number.
    ///
    /// # Errors
    /// [`FunctionError::Input`]; [`FunctionError::NotDifferentiable`] for derivatives and pullbacks
    /// through a graph.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(Function::MassMatrix.compute::<f64>(&model, &[vec![0.3]])?, [[0.5]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn compute<S: Scalar>(
        &self,
        model: &Model,
        arguments: &[Vec<S>],
    ) -> Result<Vec<Vec<S>>, FunctionError> {
        Ok(call::<S>(self, model)?(arguments))
    }
}

/// The closure that [`Function::compute`] calls.
#[allow(clippy::type_complexity)] // numbers in, numbers out
pub(crate) fn call<S: Scalar>(
    function: &Function,
    model: &Model,
) -> Result<impl Fn(&[Vec<S>]) -> Vec<Vec<S>>, FunctionError> {
    if function.derivative_of().is_some() {
        return Err(FunctionError::NotDifferentiable { function: function.to_string() });
    }
    let frame = function.frame().map(|name| model.frame_named(name)).transpose()?;
    let contact = contact_step(function, model)?;
    Ok(move |arguments: &[Vec<S>]| {
        let mut results = zeros(function, model);
        let mut arguments: Vec<&[S]> = arguments.iter().map(Vec::as_slice).collect();
        arguments.resize(MOST_ARGUMENTS, &[]);
        let memory = &mut CallWorkspaces::new(function, model, contact.clone(), InstructionSet::Portable);
        compute(function, model, frame, memory, &arguments, &mut results);
        results
    })
}

/// The largest number of arguments.
const MOST_ARGUMENTS: usize = 6;

/// The step with contact of which a function computes a stage.
fn contact_step(function: &Function, model: &Model) -> Result<Option<ContactStep>, FunctionError> {
    let sweeps = match function {
        Function::ContactStep { sweeps } => usize::from(*sweeps),
        _ => 1,
    };
    Ok(function.is_of_contact().then(|| ContactStep::new(model, sweeps)).transpose()?)
}

fn zeros<S: Scalar>(function: &Function, model: &Model) -> Vec<Vec<S>> {
    let zeros = |outcome: FunctionResult| vec![S::zero(); outcome.rows * outcome.columns];
    function.results(model).into_iter().map(zeros).collect()
}

/// Memory for repeated calls of a function, over the best registers of this machine, to measure them.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_functions::{Function, FunctionMemory};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut memory = FunctionMemory::<f64>::new(&Function::MassMatrix, &model)?;
/// assert_eq!(memory.compute(&[&[0.3]]), [[0.5]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FunctionMemory<'a, S: Scalar> {
    function: &'a Function,
    model: &'a Model,
    frame: Option<FrameId>,
    memory: CallWorkspaces<S>,
    results: Vec<Vec<S>>,
}

impl<'a, S: Scalar> FunctionMemory<'a, S> {
    /// Allocates memory for this function of this robot.
    ///
    /// # Errors
    /// As [`Function::compute`].
    pub fn new(function: &'a Function, model: &'a Model) -> Result<Self, FunctionError> {
        if function.derivative_of().is_some() {
            return Err(FunctionError::NotDifferentiable { function: function.to_string() });
        }
        let frame = function.frame().map(|name| model.frame_named(name)).transpose()?;
        let contact = contact_step(function, model)?;
        let memory = CallWorkspaces::new(function, model, contact, InstructionSet::best());
        Ok(Self { function, model, frame, memory, results: zeros(function, model) })
    }

    /// Computes the results.
    ///
    /// # Panics
    /// If an argument has the wrong length; see [`Function::arguments`].
    pub fn compute(&mut self, arguments: &[&[S]]) -> &[Vec<S>] {
        let mut all: [&[S]; MOST_ARGUMENTS] = [&[]; MOST_ARGUMENTS];
        all[..arguments.len()].copy_from_slice(arguments);
        let Self { function, model, frame, memory, results } = self;
        compute(function, model, *frame, memory, &all, results);
        results
    }
}

/// The workspaces of the library's calls.
struct CallWorkspaces<S: Scalar> {
    tree: Workspace<S>,
    step: Option<StepStagesWorkspace<S>>,
    contact: Option<ContactStep>,
}

impl<S: Scalar> CallWorkspaces<S> {
    fn new(function: &Function, model: &Model, contact: Option<ContactStep>, limit: InstructionSet) -> Self {
        let step = function.integrator().map(|_| StepStagesWorkspace::limited(model, limit));
        Self { tree: Workspace::limited(model, limit), step, contact }
    }
}

/// Computes the function's results. `arguments` has [`MOST_ARGUMENTS`] entries; those that the function lacks
/// are empty.
fn compute<S: Scalar>(
    function: &Function,
    model: &Model,
    frame: Option<FrameId>,
    memory: &mut CallWorkspaces<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let CallWorkspaces { tree: w, step, contact } = memory;
    let (x, y, z) = (arguments[0], arguments[1], arguments[2]);
    let one = &mut results[0][..];
    match function {
        Function::InverseDynamics => robot_dynamics_core::inverse_dynamics(model, w, x, y, z, one),
        Function::ForwardDynamics => robot_dynamics_core::forward_dynamics(model, w, x, y, z, one),
        Function::MassMatrix => robot_dynamics_core::mass_matrix(model, w, x, one),
        Function::MassMatrixRelated => related_mass_matrix(model, w, x, one),
        Function::MassMatrixFactor => robot_dynamics_core::mass_matrix_factor(model, w, x, one),
        Function::InverseMassMatrix => robot_dynamics_core::inverse_mass_matrix(model, w, x, one),
        Function::Bias => robot_dynamics_core::bias(model, w, x, y, one),
        Function::Gravity => robot_dynamics_core::gravity(model, w, x, one),
        Function::VelocityProduct => robot_dynamics_core::velocity_product(model, w, x, y, one),
        Function::CoriolisMatrix => robot_dynamics_core::coriolis_matrix(model, w, x, y, one),
        Function::Dissipation => robot_dynamics_core::dissipation(model, x, one),
        Function::KineticEnergy => one[0] = robot_dynamics_core::kinetic_energy(model, w, x, y),
        Function::PotentialEnergy => one[0] = robot_dynamics_core::potential_energy(model, w, x),
        Function::Momentum => robot_dynamics_core::momentum(model, w, x, y, one),
        Function::CenterOfMass => one.copy_from_slice(&robot_dynamics_core::center_of_mass(model, w, x)),
        Function::CenterOfMassJacobian => robot_dynamics_core::center_of_mass_jacobian(model, w, x, one),
        Function::InverseDynamicsDerivatives => inverse_derivatives(model, w, [x, y, z], results),
        Function::ForwardDynamicsDerivatives => forward_derivatives(model, w, [x, y, z], results),
        Function::InverseDynamicsPullback => inverse_pullback(model, w, arguments, results),
        Function::ForwardDynamicsPullback => forward_pullback(model, w, arguments, results),
        Function::JointTorqueRegressor => robot_dynamics_core::joint_torque_regressor(model, w, x, y, z, one),
        Function::SemiImplicitEulerStep | Function::Rk4Step => {
            let workspace = step.as_mut().expect("a step has a workspace");
            explicit_step(function, model, workspace, arguments, results);
        }
        Function::ContactStep { .. }
        | Function::ContactProblem
        | Function::ContactStart
        | Function::ContactSweep
        | Function::ContactFixedPoint
        | Function::ContactEnd => {
            let contact = contact.as_ref().expect("a function of contact has a step");
            contact_stage(function, contact, model, w, arguments, results);
        }
        Function::FramePoses => frame_poses(model, w, x, one),
        Function::FramePose(_) => {
            let Pose { rotation, translation } =
                robot_dynamics_core::frame_pose(model, w, x, required(frame));
            one.copy_from_slice(rotation.as_flattened());
            results[1].copy_from_slice(&translation);
        }
        Function::FrameJacobian(reference_frame, _) => {
            robot_dynamics_core::frame_jacobian(model, w, x, required(frame), *reference_frame, one);
        }
        Function::Derivatives(_) | Function::Pullback(_) => {
            unreachable!("derived from the trace of another function")
        }
    }
}

/// The entries of M without structural zeros.
fn related_mass_matrix<S: Scalar>(model: &Model, w: &mut Workspace<S>, q: &[S], entries: &mut [S]) {
    let (nv, mut mass) = (model.nv(), vec![S::zero(); model.nv() * model.nv()]);
    robot_dynamics_core::mass_matrix(model, w, q, &mut mass);
    let places = robot_dynamics_core::mass_matrix_related_entries(model);
    places.iter().zip(entries).for_each(|(&(i, j), entry)| *entry = mass[i * nv + j]);
}

/// ∂τ/∂q, ∂τ/∂v and ∂τ/∂a = M.
fn inverse_derivatives<S: Scalar>(
    model: &Model,
    w: &mut Workspace<S>,
    [q, v, a]: [&[S]; 3],
    results: &mut [Vec<S>],
) {
    let [by_position, by_velocity, mass] = results else { unreachable!("three results") };
    let out = robot_dynamics_core::InverseDynamicsDerivativesMut { by_position, by_velocity };
    robot_dynamics_core::inverse_dynamics_derivatives(model, w, q, v, a, out);
    robot_dynamics_core::mass_matrix(model, w, q, mass);
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂τ.
fn forward_derivatives<S: Scalar>(
    model: &Model,
    w: &mut Workspace<S>,
    [q, v, tau]: [&[S]; 3],
    results: &mut [Vec<S>],
) {
    let [by_position, by_velocity, by_force] = results else { unreachable!("three results") };
    let out = robot_dynamics_core::ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force };
    robot_dynamics_core::forward_dynamics_derivatives(model, w, q, v, tau, out);
}

/// The products of the weights λ with the derivatives of τ.
fn inverse_pullback<S: Scalar>(
    model: &Model,
    w: &mut Workspace<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let [q, v, a, cotangent, ..] = *arguments else { unreachable!("four arguments") };
    let [by_position, by_velocity, by_acceleration] = results else { unreachable!("three results") };
    let parameters = &mut [];
    let out =
        robot_dynamics_core::InversePullbackMut { by_position, by_velocity, by_acceleration, parameters };
    robot_dynamics_core::inverse_dynamics_pullback(model, w, q, v, a, cotangent, out);
}

/// The acceleration, and the products of the weights λ with its derivatives.
fn forward_pullback<S: Scalar>(
    model: &Model,
    w: &mut Workspace<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let [q, v, tau, cotangent, ..] = *arguments else { unreachable!("four arguments") };
    let [acceleration, by_position, by_velocity, by_force] = results else { unreachable!("four results") };
    let parameters = &mut [];
    let out = robot_dynamics_core::ForwardPullbackMut {
        acceleration,
        by_position,
        by_velocity,
        by_force,
        parameters,
    };
    robot_dynamics_core::forward_dynamics_pullback(model, w, q, v, tau, cotangent, out);
}

/// The state after one explicit step.
fn explicit_step<S: Scalar>(
    function: &Function,
    model: &Model,
    workspace: &mut StepStagesWorkspace<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let Some(StepScheme::Explicit(stages)) = function.integrator().map(Integrator::scheme) else {
        unreachable!("generated steps have explicit stages")
    };
    let [q, v, tau, h, ..] = *arguments else { unreachable!("four arguments") };
    let [q_next, v_next] = results else { unreachable!("two results") };
    let forces = StepForces::new(tau, true);
    let (from, to) = ((q, v), (&mut q_next[..], &mut v_next[..]));
    robot_dynamics_simulation::step_stages(model, stages, workspace, &forces, h[0], from, to);
}

/// A step with contact, or a stage of one.
fn contact_stage<S: Scalar>(
    function: &Function,
    step: &ContactStep,
    model: &Model,
    w: &mut Workspace<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let [x, y, z, s, t, u, ..] = *arguments else { unreachable!("six arguments") };
    let (first, rest) = results.split_first_mut().expect("a function has results");
    match function {
        Function::ContactStep { .. } => {
            let inputs = ContactStepInputs::new([x, y, z], s[0], t[0], u);
            let [velocity, impulses] = rest else { unreachable!("three results") };
            step.step(model, w, &inputs, first, velocity, impulses);
        }
        Function::ContactProblem => {
            let inputs = ContactStepInputs::new([x, y, z], s[0], t[0], u);
            step.prepare(model, w, &inputs, first, &mut rest[0]);
        }
        Function::ContactStart => {
            first.copy_from_slice(y);
            step.start(x, z, first);
        }
        Function::ContactSweep | Function::ContactFixedPoint => {
            first.copy_from_slice(y);
            rest[0].copy_from_slice(z);
            if *function == Function::ContactFixedPoint {
                step.start(x, z, first);
            }
            step.sweep(x, first, &mut rest[0]);
        }
        _ => step.finish(model, x, (z, s[0]), y, first, &mut rest[0]),
    }
}

/// The rotation matrix and the origin of each frame, 12 numbers a frame.
fn frame_poses<S: Scalar>(model: &Model, w: &mut Workspace<S>, q: &[S], numbers: &mut [S]) {
    let unknown = Pose { rotation: [[S::zero(); 3]; 3], translation: [S::zero(); 3] };
    let mut poses = vec![unknown; model.frames().len()];
    robot_dynamics_core::frame_poses(model, w, q, &mut poses);
    for (to, Pose { rotation, translation }) in numbers.chunks_exact_mut(12).zip(&poses) {
        to[..9].copy_from_slice(rotation.as_flattened());
        to[9..].copy_from_slice(translation);
    }
}

fn required(frame: Option<FrameId>) -> FrameId {
    frame.expect("a function of a frame has one")
}
