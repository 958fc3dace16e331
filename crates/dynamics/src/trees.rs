//! A robot from a file as a [`Dynamics`] of N coordinates: the link between the two formulations.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{SMatrix, SVector};
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::{Classified, ErrorKind, Scalar};
use robot_dynamics_verification::lagrange;
use thiserror::Error;

use crate::{Dynamics, FromLagrangian, Lagrangian};

/// The reason why a model is not a system of `N` coordinates.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FixedSizeError {
    /// The number of degrees of freedom differs.
    #[error("robot `{robot}` has {found} degrees of freedom, not {expected}: use FixedSize::<{found}>")]
    WrongSize {
        /// The robot's name.
        robot: String,
        /// N.
        expected: usize,
        /// nv.
        found: usize,
    },
    /// The v of a joint is not the rate of its q.
    #[error(
        "robot `{robot}`: joint `{joint}` ({kind}) has a quaternion in q, and M(q) q̈ + C q̇ + g = u needs q̇ = v; \
         fix the base, replace the joint by revolute ones, or call the functions on `Model`"
    )]
    QuaternionJoint {
        /// The robot's name.
        robot: String,
        /// The first such joint.
        joint: String,
        /// `spherical` or `floating`.
        kind: &'static str,
    },
}

impl Classified for FixedSizeError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Unsupported
    }
}

/// A robot as a [`Dynamics`] of `N` coordinates, so that every law, integrator and controller of the crate
/// `dynamics` runs on it.
///
/// The methods of [`Dynamics`] are the recursions: M by composite rigid bodies, C q̇ + g by Newton and Euler.
/// Springs are in g and V, armature in M, damping and friction in b. The methods of [`Lagrangian`] are the
/// reference [`lagrange`], which shares no code with them; [`by_lagrange`](Self::by_lagrange) derives the
/// whole equation of motion from those. `dynamics::laws::check_all` therefore compares the two routes.
///
/// Each call takes a free [`Workspace`], or makes one: the adapter is `Sync`, and calls are independent of
/// each other. The workspaces are behind a lock. If its cost matters, call the functions on [`Model`] with
/// your own workspace.
///
/// ```
/// use dynamics::{Dynamics, FixedSize, energy_drift};
/// use nalgebra::SVector;
/// use robot_dynamics_core::Model;
/// use robot_dynamics_description::{JointKinds, RandomRobotOptions, random_robot};
/// use robot_dynamics_integrators::Integrator;
/// let options = RandomRobotOptions { joints: 3, kinds: JointKinds::Turning, ..Default::default() };
/// let arm = FixedSize::<3>::new(Model::new(random_robot(1, &options))?)?.without_dissipation();
/// let (q, zero) = (SVector::repeat(0.3), SVector::zeros());
/// assert!(energy_drift(&arm, &q, &zero, &zero, 1e-3, 100, Integrator::RungeKutta4)? < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FixedSize<const N: usize> {
    model: Arc<Model>,
    dissipates: bool,
    /// Free workspaces, shared with clones.
    spare: Arc<Mutex<Vec<Workspace>>>,
}

impl<const N: usize> FixedSize<N> {
    /// The model as a system of `N` coordinates, damping and friction included.
    ///
    /// # Errors
    /// [`FixedSizeError`] if the model does not have `N` degrees of freedom, or has a quaternion in q.
    pub fn new(model: impl Into<Arc<Model>>) -> Result<Self, FixedSizeError> {
        let model = model.into();
        if let Some(joint) = model.joints().iter().find(|joint| joint.nq != joint.nv) {
            return Err(FixedSizeError::QuaternionJoint {
                robot: model.name().into(),
                joint: joint.name.clone(),
                kind: joint.kind.name(),
            });
        }
        if model.nv() != N {
            return Err(FixedSizeError::WrongSize {
                robot: model.name().into(),
                expected: N,
                found: model.nv(),
            });
        }
        Ok(Self { model, dissipates: true, spare: Arc::default() })
    }

    /// The same robot with b = 0, without damping and friction.
    #[must_use]
    pub fn without_dissipation(mut self) -> Self {
        self.dissipates = false;
        self
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The same robot by the Lagrange recipe alone (b = 0): slow, for reference.
    pub fn by_lagrange(&self) -> FromLagrangian<Self> {
        FromLagrangian(self.clone())
    }

    /// Calls `compute` with a workspace that no other call uses.
    fn with_workspace<R>(&self, compute: impl FnOnce(&mut Workspace) -> R) -> R {
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let found = spare().pop();
        let mut workspace = found.unwrap_or_else(|| Workspace::new(&self.model));
        let result = compute(&mut workspace);
        spare().push(workspace);
        result
    }
}

impl<const N: usize> Dynamics<N> for FixedSize<N> {
    fn mass(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let mut mass = SMatrix::<f64, N, N>::zeros();
        // Row-major or column-major does not matter: M is symmetric bit for bit.
        self.with_workspace(|w| {
            robot_dynamics_core::mass_matrix(&self.model, w, q.as_slice(), mass.as_mut_slice());
        });
        mass
    }

    fn velocity_product(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let mut product = SVector::<f64, N>::zeros();
        let (q, v, result) = (q.as_slice(), qd.as_slice(), product.as_mut_slice());
        self.with_workspace(|w| robot_dynamics_core::velocity_product(&self.model, w, q, v, result));
        product
    }

    fn gravity(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        let mut gravity = SVector::<f64, N>::zeros();
        self.with_workspace(|w| {
            robot_dynamics_core::gravity(&self.model, w, q.as_slice(), gravity.as_mut_slice());
        });
        gravity
    }

    fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        self.with_workspace(|w| robot_dynamics_core::potential_energy(&self.model, w, q.as_slice()))
    }

    fn kinetic_energy(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> f64 {
        self.with_workspace(|w| {
            robot_dynamics_core::kinetic_energy(&self.model, w, q.as_slice(), qd.as_slice())
        })
    }

    fn dissipation(&self, _q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let mut dissipation = SVector::<f64, N>::zeros();
        if self.dissipates {
            robot_dynamics_core::dissipation(&self.model, qd.as_slice(), dissipation.as_mut_slice());
        }
        dissipation
    }

    /// One pass of the recursion, not a product with M.
    fn inverse(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, qdd: &SVector<f64, N>) -> SVector<f64, N> {
        let mut u = SVector::<f64, N>::zeros();
        let (at, v, a, result) = (q.as_slice(), qd.as_slice(), qdd.as_slice(), u.as_mut_slice());
        self.with_workspace(|w| robot_dynamics_core::inverse_dynamics(&self.model, w, at, v, a, result));
        u + self.dissipation(q, qd)
    }

    fn bias(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let mut bias = SVector::<f64, N>::zeros();
        let (at, v, result) = (q.as_slice(), qd.as_slice(), bias.as_mut_slice());
        self.with_workspace(|w| robot_dynamics_core::bias(&self.model, w, at, v, result));
        bias + self.dissipation(q, qd)
    }
}

/// The energies by the Lagrange recipe.
impl<const N: usize> Lagrangian<N> for FixedSize<N> {
    fn mass_over<S: Scalar>(&self, q: &[S; N]) -> [[S; N]; N] {
        let mass = lagrange::mass_matrix(&self.model, q);
        core::array::from_fn(|i| core::array::from_fn(|j| mass[i * N + j]))
    }

    fn potential_over<S: Scalar>(&self, q: &[S; N]) -> S {
        lagrange::potential_energy(&self.model, q)
    }
}
