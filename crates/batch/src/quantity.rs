//! Batches of the quantities in the table of algorithms.

use robot_dynamics_core::{Inputs, Model, Quantity, ReferenceFrame};

use crate::{BadStates, BatchFloat, BatchWorkspace};

/// Computes a [`Quantity`] on batches.
pub trait BatchQuantity {
    /// Whether the quantity can be computed on batches.
    fn has_batch(self) -> bool;

    /// Computes the quantity for each state of a batch. The results are in the order of
    /// [`Quantity::results`], and unused ones are empty. Returns `None` if [`has_batch`](Self::has_batch) is
    /// false.
    ///
    /// ```
    /// use robot_dynamics::batch::{BatchQuantity, BatchWorkspace};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::quantity::{Inputs, Quantity};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let (mut workspace, mut mass) = (BatchWorkspace::<f64>::new(&model), [0.0; 3]);
    /// let inputs = Inputs { q: &[0.0, 0.5, 1.0], ..Inputs::default() };
    /// let results = [&mut mass[..], &mut [], &mut []];
    /// Quantity::MassMatrix.compute_batch(&model, &mut workspace, &inputs, results).expect("there are batches of M")?;
    /// assert_eq!(mass, [0.5; 3]);
    /// assert!(!Quantity::Momentum.has_batch());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BadStates`] lists the states without a valid result; all other results are valid.
    ///
    /// # Panics
    /// Panics if a table has the wrong length, or the workspace belongs to another model.
    #[track_caller]
    fn compute_batch<T: BatchFloat>(
        self,
        model: &Model,
        workspace: &mut BatchWorkspace<T>,
        inputs: &Inputs<'_, T>,
        results: [&mut [T]; 3],
    ) -> Option<Result<(), BadStates>>;
}

/// Implements [`BatchQuantity`] from one list: the quantities with batches, and the call of each.
macro_rules! batches {
    (
        ($model:ident, $workspace:ident, $inputs:pat_param, $results:pat_param)
        $($variant:ident => $call:expr,)*
    ) => {
        impl BatchQuantity for Quantity {
            fn has_batch(self) -> bool {
                matches!(self, $(Self::$variant)|*)
            }

            fn compute_batch<T: BatchFloat>(
                self,
                $model: &Model,
                $workspace: &mut BatchWorkspace<T>,
                $inputs: &Inputs<'_, T>,
                $results: [&mut [T]; 3],
            ) -> Option<Result<(), BadStates>> {
                match self {
                    $(Self::$variant => Some($call),)*
                    _ => None,
                }
            }
        }
    };
}

batches! {
    (model, workspace, &Inputs { q, v, a, tau, frames }, [x, y, z])
    MassMatrix => crate::mass_matrix(model, workspace, q, x),
    Bias => crate::bias(model, workspace, q, v, x),
    Gravity => crate::gravity(model, workspace, q, x),
    InverseDynamics => crate::inverse_dynamics(model, workspace, q, v, a, x),
    ForwardDynamics => crate::forward_dynamics(model, workspace, q, v, tau, x),
    InverseMassMatrix => crate::inverse_mass_matrix(model, workspace, q, x),
    FramePoses => crate::frame_poses(model, workspace, q, frames, x),
    FrameJacobianLocalWorldAligned => {
        crate::frame_jacobian(model, workspace, q, frames[0], ReferenceFrame::LocalWorldAligned, x)
    },
    FrameJacobianLocal => {
        crate::frame_jacobian(model, workspace, q, frames[0], ReferenceFrame::Local, x)
    },
    FrameJacobianWorld => {
        crate::frame_jacobian(model, workspace, q, frames[0], ReferenceFrame::World, x)
    },
    InverseDynamicsDerivatives => {
        let out = crate::InverseDynamicsDerivativesMut { by_position: x, by_velocity: y };
        crate::inverse_dynamics_derivatives(model, workspace, q, v, a, out)
    },
    ForwardDynamicsDerivatives => {
        let out = crate::ForwardDynamicsDerivativesMut { by_position: x, by_velocity: y, by_force: z };
        crate::forward_dynamics_derivatives(model, workspace, q, v, tau, out)
    },
}
