//! The public interface to one robot's functions on many states.

use robot_dynamics::batch::{RolloutObserver, RolloutStates, Torques, UNOBSERVED};
use robot_dynamics::derivatives::Rollout;
use robot_dynamics_generate::Function;

use crate::DeviceError;
use crate::machine::Engine;

/// One robot's functions on one device, compiled by [`Device::compile`](crate::Device::compile).
///
/// Tables are those of [`robot_dynamics::batch`]: by rows, one state after the other, q \[batch\]\[nq\], v, a
/// and tau \[batch\]\[nv\], a matrix \[batch\]\[rows\]\[columns\]. If a number of a state or of its result is
/// not finite, [`DeviceError::BadStates`] names the state, and its results are NaN. The other states keep
/// theirs. The memory that a call needs on the device is reused by the next one.
pub struct Batches<T> {
    engine: Box<dyn Engine<T>>,
}

/// Methods with the name, the arguments and the result of a function.
macro_rules! methods {
    ($($(#[$doc:meta])* $name:ident: $function:ident($($argument:ident),*) -> $result:ident;)*) => {
        impl<T> Batches<T> {
            $(
                $(#[$doc])*
                ///
                /// # Errors
                /// [`DeviceError::BadStates`] names the states without a valid result;
                /// [`DeviceError::NotCompiled`]; [`DeviceError::Failed`] if the device has no memory left, or
                /// was lost.
                ///
                /// # Panics
                /// If a table has the wrong length.
                #[track_caller]
                pub fn $name(&mut self, $($argument: &[T],)* $result: &mut [T]) -> Result<(), DeviceError> {
                    self.compute(&Function::$function, &[$($argument),*], &mut [$result])
                }
            )*
        }
    };
}

methods! {
    /// τ = M(q) a + C(q,v) v + g(q) of each state; see [`robot_dynamics::batch::inverse_dynamics`].
    inverse_dynamics: InverseDynamics(q, v, a) -> tau;
    /// a = M⁻¹(τ − C v − g) of each state; see [`robot_dynamics::batch::forward_dynamics`].
    forward_dynamics: ForwardDynamics(q, v, tau) -> acceleration;
    /// M(q) of each state, both triangles; see [`robot_dynamics::batch::mass_matrix`].
    mass_matrix: MassMatrix(q) -> mass;
    /// M(q)⁻¹ of each state, both triangles; see [`robot_dynamics::batch::inverse_mass_matrix`].
    inverse_mass_matrix: InverseMassMatrix(q) -> inverse;
    /// C(q,v) v + g(q) of each state; see [`robot_dynamics::batch::bias`].
    bias: Bias(q, v) -> bias;
    /// g(q) of each state; see [`robot_dynamics::batch::gravity`].
    gravity: Gravity(q) -> gravity;
}

impl<T> Batches<T> {
    pub(crate) fn new(engine: Box<dyn Engine<T>>) -> Self {
        Self { engine }
    }

    #[cfg(feature = "cuda")]
    pub(crate) fn engine(&self) -> &dyn Engine<T> {
        &*self.engine
    }

    pub(crate) fn engine_mut(&mut self) -> &mut dyn Engine<T> {
        &mut *self.engine
    }

    /// The compiled functions.
    pub fn functions(&self) -> Vec<&Function> {
        self.engine.functions()
    }

    /// Computes any compiled function of each state. Tables of arguments and results are in the order of
    /// [`Function::reads`] and [`Function::writes`].
    ///
    /// ```
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// use robot_dynamics_gpu::{Device, Function};
    /// let energy = Function::KineticEnergy;
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let mut pendulums = device.compile::<f32>(&model, &[energy.clone()])?;
    /// let mut kinetic = [0.0; 2];
    /// pendulums.compute(&energy, &[&[0.0, 1.0], &[2.0, 2.0]], &mut [&mut kinetic])?;
    /// assert!(kinetic.iter().all(|k| (k - 1.0).abs() < 1e-6)); // ½ m l² v²
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::BadStates`] names the states without a valid result; [`DeviceError::NotCompiled`];
    /// [`DeviceError::Failed`] if the device has no memory left, or was lost.
    ///
    /// # Panics
    /// If the number of tables is wrong, or the length of one.
    #[track_caller]
    pub fn compute(
        &mut self,
        function: &Function,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<(), DeviceError> {
        self.engine.compute(function, inputs, outputs)
    }

    /// Simulates each state (q, v) in place over `rollout.steps` steps, as [`robot_dynamics::batch::rollout`]
    /// does. The states stay on the device between steps. The device returns the samples of the trajectory
    /// and the final states.
    ///
    /// The robot's [`Function::SemiImplicitEulerStep`] or [`Function::Rk4Step`] must have been compiled.
    /// `progress`, if it is given, is called at least every 64 steps of the states on the device. If it
    /// breaks, unfinished states keep their initial values, and their trajectories are invalid.
    ///
    /// ```
    /// use robot_dynamics::simulation::Integrator;
    /// use robot_dynamics_gpu::{Device, Function, Rollout, RolloutStates, Torques};
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let mut pendulums = device.compile::<f32>(&model, &[Function::Rk4Step])?;
    /// let (mut q, mut v) = (vec![0.0_f32; 10_000], vec![0.0_f32; 10_000]);
    /// let how = Rollout::new(Integrator::RungeKutta4, 1e-3, 200);
    /// pendulums.rollout(&how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?;
    /// // Energy is conserved: ½ l v² = g sin q.
    /// assert!(q.iter().zip(&v).all(|(q, v)| (0.25 * v * v - 9.81 * q.sin()).abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::BadStates`] and [`DeviceError::Rollout`]: all states that these do not name are valid.
    /// [`DeviceError::NotCompiled`], [`DeviceError::NoStep`], [`DeviceError::Policy`],
    /// [`DeviceError::Dissipation`] for unsupported rollouts; [`DeviceError::Failed`] if the device has no
    /// memory left, or was lost: q and v are then invalid.
    ///
    /// # Panics
    /// If a table has the wrong length.
    #[track_caller]
    pub fn rollout(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        states: RolloutStates<'_, T>,
        progress: Option<RolloutObserver<'_>>,
    ) -> Result<(), DeviceError> {
        self.engine.rollout(rollout, torques, states, progress.unwrap_or(UNOBSERVED))
    }
}

impl<T> core::fmt::Debug for Batches<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Batches").field("functions", &self.functions()).finish()
    }
}
