//! What a caller calls: one robot's functions on many states.

use std::ops::ControlFlow;

use generate::Function;
use multibody::Rollout;
use multibody::batch::{RolloutProgress, Torques};

use crate::DeviceError;
use crate::machine::{Engine, Motion};

/// One robot's functions on one device, as [`Device::compile`](crate::Device::compile) made them.
///
/// Tables are those of [`multibody::batch`]: by rows, one state after the other, q \[batch\]\[nq\], v, a and tau \[batch\]\[nv\], a
/// matrix \[batch\]\[rows\]\[columns\]. A state with a number that is not finite, or whose result is not, is named in
/// [`DeviceError::BadStates`] and has NaN for its results; all others have theirs. The memory that a call needs on the device is
/// kept for the next.
pub struct Batches<T> {
    engine: Box<dyn Engine<T>>,
}

/// Methods named as the function, with its arguments and its one result.
macro_rules! methods {
    ($($(#[$doc:meta])* $name:ident: $function:ident($($argument:ident),*) -> $result:ident;)*) => {
        impl<T> Batches<T> {
            $(
                $(#[$doc])*
                ///
                /// # Errors
                /// [`DeviceError::BadStates`] names the states without a valid result; [`DeviceError::NotCompiled`];
                /// [`DeviceError::Failed`] where the device has no memory left, or was lost.
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
    /// τ = M(q) a + C(q,v) v + g(q) of each state; see [`multibody::batch::inverse_dynamics`].
    inverse_dynamics: InverseDynamics(q, v, a) -> tau;
    /// a = M⁻¹(τ − C v − g) of each state; see [`multibody::batch::forward_dynamics`].
    forward_dynamics: ForwardDynamics(q, v, tau) -> acceleration;
    /// M(q) of each state, both triangles; see [`multibody::batch::mass_matrix`].
    mass_matrix: MassMatrix(q) -> mass;
    /// M(q)⁻¹ of each state, both triangles; see [`multibody::batch::inverse_mass_matrix`].
    inverse_mass_matrix: InverseMassMatrix(q) -> inverse;
    /// C(q,v) v + g(q) of each state; see [`multibody::batch::bias`].
    bias: Bias(q, v) -> bias;
    /// g(q) of each state; see [`multibody::batch::gravity`].
    gravity: Gravity(q) -> gravity;
}

impl<T> Batches<T> {
    pub(crate) fn new(engine: Box<dyn Engine<T>>) -> Self {
        Self { engine }
    }

    /// What was compiled.
    pub fn functions(&self) -> Vec<&Function> {
        self.engine.functions()
    }

    /// Any compiled function of each state: tables of its arguments and of its results, in the order of
    /// [`Function::reads`] and [`Function::writes`].
    ///
    /// ```
    /// # let model = multibody::Model::new(multibody::pendulum(2.0, 0.5))?;
    /// use gpu::{Device, Function};
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
    /// [`DeviceError::Failed`] where the device has no memory left, or was lost.
    ///
    /// # Panics
    /// If there are too many tables or too few, or one has the wrong length.
    #[track_caller]
    pub fn compute(
        &mut self,
        function: &Function,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
    ) -> Result<(), DeviceError> {
        self.engine.compute(function, inputs, outputs)
    }

    /// Moves each state (q, v) in place over `rollout.steps` steps, as [`multibody::batch::rollout`] does. The states stay on
    /// the device: it takes one step after the other, and hands over the samples of the trajectory and the end.
    ///
    /// The robot's [`Function::SemiImplicitEulerStep`] or [`Function::Rk4Step`] must have been compiled. `progress` is called after
    /// at most 64 steps of the states that are on the device; when it breaks, the states not yet at their end stay as they were, and
    /// the trajectories of those are not to be read.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// use gpu::{Device, Function, Rollout, Torques};
    /// use std::ops::ControlFlow;
    /// # let model = multibody::Model::new(multibody::pendulum(2.0, 0.5))?;
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let mut pendulums = device.compile::<f32>(&model, &[Function::Rk4Step])?;
    /// let (mut q, mut v) = (vec![0.0; 10_000], vec![0.0; 10_000]);
    /// let how = Rollout::new(Integrator::RungeKutta4, 1e-3, 200);
    /// let go_on = |_| ControlFlow::Continue(());
    /// pendulums.rollout(&how, Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on)?;
    /// // What it fell, it gained: ½ l v² = g sin q.
    /// assert!(q.iter().zip(&v).all(|(q, v)| (0.25 * v * v - 9.81 * q.sin()).abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::BadStates`] and [`DeviceError::Rollout`], all states that these do not name being valid;
    /// [`DeviceError::NotCompiled`], [`DeviceError::NoStep`], [`DeviceError::Policy`], [`DeviceError::Dissipation`] for what
    /// a device cannot; [`DeviceError::Failed`] where it has no memory left, or was lost: then q and v hold no state.
    ///
    /// # Panics
    /// If a table has the wrong length.
    #[track_caller]
    pub fn rollout(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        q: &mut [T],
        v: &mut [T],
        trajectory: (&mut [T], &mut [T]),
        progress: &(dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
    ) -> Result<(), DeviceError> {
        self.engine.rollout(rollout, torques, Motion { q, v, trajectory }, progress)
    }
}

impl<T> core::fmt::Debug for Batches<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Batches").field("functions", &self.functions()).finish()
    }
}
