//! The library's algorithms over any number: the tracing one, and floats to compare with.

use dynamics::{Integrator, Method};
use multibody::{FrameId, FramePose, InstructionSet, Model, StepForces, StepStagesWorkspace, Workspace};
use number::Scalar;

use crate::{Function, FunctionError, Outcome};

impl Function {
    /// Its results, each by rows, from its arguments, by the library's calls over any number.
    ///
    /// # Errors
    /// [`FunctionError::NoSuchFrame`]; [`FunctionError::NoSlopes`] of derivatives and pullbacks that are made from a graph.
    ///
    /// ```
    /// use functions::Function;
    /// use multibody::{Model, pendulum};
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

/// The function of arguments that [`Function::compute`] computes.
#[allow(clippy::type_complexity)] // numbers in, numbers out
pub(crate) fn call<S: Scalar>(
    function: &Function,
    model: &Model,
) -> Result<impl Fn(&[Vec<S>]) -> Vec<Vec<S>>, FunctionError> {
    if function.slopes_of().is_some() {
        return Err(FunctionError::NoSlopes { function: function.to_string() });
    }
    let frame = function.frame().map(|name| model.frame_named(name)).transpose()?;
    Ok(move |arguments: &[Vec<S>]| {
        let mut results = zeros(function, model);
        let mut arguments: Vec<&[S]> = arguments.iter().map(Vec::as_slice).collect();
        arguments.resize(4, &[]);
        let memory = &mut Memory::new(function, model, InstructionSet::Portable);
        compute(function, model, frame, memory, &arguments, &mut results);
        results
    })
}

fn zeros<S: Scalar>(function: &Function, model: &Model) -> Vec<Vec<S>> {
    let zeros = |outcome: Outcome| vec![S::zero(); outcome.rows * outcome.columns];
    function.results(model).into_iter().map(zeros).collect()
}

/// Memory of a function's calls, over the best registers of this machine: to measure them.
///
/// ```
/// use functions::{Function, FunctionMemory};
/// use multibody::{Model, pendulum};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut memory = FunctionMemory::<f64>::new(&Function::MassMatrix, &model)?;
/// assert_eq!(memory.compute(&[&[0.3]]), [[0.5]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FunctionMemory<'a, S: Scalar> {
    function: &'a Function,
    model: &'a Model,
    frame: Option<FrameId>,
    memory: Memory<S>,
    results: Vec<Vec<S>>,
}

impl<'a, S: Scalar> FunctionMemory<'a, S> {
    /// For this function of this robot.
    ///
    /// # Errors
    /// As [`Function::compute`].
    pub fn new(function: &'a Function, model: &'a Model) -> Result<Self, FunctionError> {
        if function.slopes_of().is_some() {
            return Err(FunctionError::NoSlopes { function: function.to_string() });
        }
        let frame = function.frame().map(|name| model.frame_named(name)).transpose()?;
        let memory = Memory::new(function, model, InstructionSet::best());
        Ok(Self { function, model, frame, memory, results: zeros(function, model) })
    }

    /// The results.
    ///
    /// # Panics
    /// If an argument has another length than [`Function::arguments`] says.
    pub fn compute(&mut self, arguments: &[&[S]]) -> &[Vec<S>] {
        let mut four: [&[S]; 4] = [&[]; 4];
        four[..arguments.len()].copy_from_slice(arguments);
        let Self { function, model, frame, memory, results } = self;
        compute(function, model, *frame, memory, &four, results);
        results
    }
}

/// Scratch of the library's calls.
struct Memory<S: Scalar> {
    tree: Workspace<S>,
    step: Option<StepStagesWorkspace<S>>,
}

impl<S: Scalar> Memory<S> {
    fn new(function: &Function, model: &Model, limit: InstructionSet) -> Self {
        let step = function.integrator().map(|_| StepStagesWorkspace::limited(model, limit));
        Self { tree: Workspace::limited(model, limit), step }
    }
}

/// The function's results, four arguments given, those that it has not empty.
fn compute<S: Scalar>(
    function: &Function,
    model: &Model,
    frame: Option<FrameId>,
    memory: &mut Memory<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let Memory { tree: w, step } = memory;
    let (x, y, z, l) = (arguments[0], arguments[1], arguments[2], arguments[3]);
    let (first, others) = results.split_at_mut(1);
    let one = &mut first[0][..];
    match function {
        Function::InverseDynamics => multibody::inverse_dynamics(model, w, x, y, z, one),
        Function::ForwardDynamics => multibody::forward_dynamics(model, w, x, y, z, one),
        Function::MassMatrix => multibody::mass_matrix(model, w, x, one),
        Function::MassMatrixRelated => {
            let (nv, mut mass) = (model.nv(), vec![S::zero(); model.nv() * model.nv()]);
            multibody::mass_matrix(model, w, x, &mut mass);
            let entries = multibody::mass_matrix_related_entries(model);
            entries.iter().zip(one).for_each(|(&(i, j), entry)| *entry = mass[i * nv + j]);
        }
        Function::MassMatrixFactor => multibody::mass_matrix_factor(model, w, x, one),
        Function::InverseMassMatrix => multibody::inverse_mass_matrix(model, w, x, one),
        Function::Bias => multibody::bias(model, w, x, y, one),
        Function::Gravity => multibody::gravity(model, w, x, one),
        Function::VelocityProduct => multibody::velocity_product(model, w, x, y, one),
        Function::CoriolisMatrix => multibody::coriolis_matrix(model, w, x, y, one),
        Function::Dissipation => multibody::dissipation(model, x, one),
        Function::KineticEnergy => one[0] = multibody::kinetic_energy(model, w, x, y),
        Function::PotentialEnergy => one[0] = multibody::potential_energy(model, w, x),
        Function::Momentum => multibody::momentum(model, w, x, y, one),
        Function::CenterOfMass => one.copy_from_slice(&multibody::center_of_mass(model, w, x)),
        Function::CenterOfMassJacobian => multibody::center_of_mass_jacobian(model, w, x, one),
        Function::InverseDynamicsDerivatives => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::inverse_dynamics_derivatives(model, w, x, y, z, one, two);
            multibody::mass_matrix(model, w, x, three);
        }
        Function::ForwardDynamicsDerivatives => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::forward_dynamics_derivatives(model, w, x, y, z, one, two, three);
        }
        Function::InverseDynamicsPullback => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::inverse_dynamics_pullback(model, w, x, y, z, l, one, two, three);
        }
        Function::ForwardDynamicsPullback => {
            let [two, three, four] = others else { unreachable!("four results") };
            multibody::forward_dynamics_pullback(model, w, x, y, z, l, one, two, three, four);
        }
        Function::JointTorqueRegressor => multibody::joint_torque_regressor(model, w, x, y, z, one),
        Function::SemiImplicitEulerStep | Function::Rk4Step => {
            let w = step.as_mut().expect("a step has its own");
            let Some(Method::Explicit(stages)) = function.integrator().map(Integrator::method) else {
                unreachable!("the rows that steps are generated of have explicit stages")
            };
            let forces = StepForces::new(z, true);
            multibody::step_stages(model, stages, w, &forces, l[0], (x, y), (one, &mut others[0]));
        }
        Function::FramePoses => {
            let unknown = FramePose { rotation: [[S::zero(); 3]; 3], translation: [S::zero(); 3] };
            let mut poses = vec![unknown; model.frames().len()];
            multibody::frame_poses(model, w, x, &mut poses);
            for (to, FramePose { rotation, translation }) in one.chunks_exact_mut(12).zip(&poses) {
                to[..9].copy_from_slice(rotation.as_flattened());
                to[9..].copy_from_slice(translation);
            }
        }
        Function::FramePose(_) => {
            let FramePose { rotation, translation } = multibody::frame_pose(model, w, x, found(frame));
            one.copy_from_slice(rotation.as_flattened());
            others[0].copy_from_slice(&translation);
        }
        Function::FrameJacobianWorldAligned(_) => {
            multibody::frame_jacobian_world_aligned(model, w, x, found(frame), one);
        }
        Function::FrameJacobianInFrame(_) => {
            multibody::frame_jacobian_in_frame(model, w, x, found(frame), one);
        }
        Function::FrameJacobianInWorld(_) => {
            multibody::frame_jacobian_in_world(model, w, x, found(frame), one);
        }
        Function::Derivatives(_) | Function::Pullback(_) => unreachable!("made of another's trace"),
    }
}

fn found(frame: Option<FrameId>) -> FrameId {
    frame.expect("a function of a frame has one")
}
