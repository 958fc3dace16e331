//! The memory of the derivatives.

use robot_dynamics_number::Scalar;

use crate::Model;
use crate::factorization::tile::WIDTH;
use crate::factorization::tree_factor::TreeFactor;
use crate::spatial::motion::MotionVector;
use crate::workspace::dof_blocks::Paths;
use crate::workspace::motion_derivatives::MotionDerivatives;
use crate::workspace::passes::{Pass, SolvedColumns, passes};

/// Buffers for the derivatives.
#[derive(Clone, Debug)]
pub struct DerivativeBuffers<S: Scalar> {
    pub motion: Vec<MotionDerivatives<S>>,
    pub paths: Paths<S>,
    pub mass: TreeFactor<S>,
    /// τ − the forces at a = 0, then a.
    pub vector: Vec<S>,
    /// ∂τ/∂q and ∂τ/∂v, with rows padded to multiples of eight columns. Entries between DoFs on different
    /// branches are initialized to zero and never written.
    pub by_position: Vec<[S; WIDTH]>,
    pub by_velocity: Vec<[S; WIDTH]>,
    pub passes: Vec<Pass>,
    /// The right sides by groups of columns, and the rows of one tile's ancestors.
    pub solved: Vec<SolvedColumns<S>>,
    pub ancestors: Vec<SolvedColumns<S>>,
    /// A one among zeros: eight consecutive numbers of it are a block of a unit row, or zero.
    pub unit: [S; 2 * WIDTH],
}

impl<S: Scalar> DerivativeBuffers<S> {
    /// `dof_parent` is λ of each coordinate; if it is empty, there is no memory for matrices.
    pub fn new(model: &Model, dof_parent: &[usize]) -> Self {
        let (dofs, nv) = (model.dofs.len(), dof_parent.len());
        let zero = S::zero();
        let motion = MotionVector::zero();
        let mass = TreeFactor::new(dof_parent);
        let rows = mass.deepest();
        let groups = nv.div_ceil(WIDTH);
        let derivatives = vec![[zero; WIDTH]; groups * nv];
        let mut unit = [zero; 2 * WIDTH];
        unit[WIDTH] = S::one();
        Self {
            motion: vec![MotionDerivatives { psi: motion, psi_prime: motion, velocity_term: motion }; dofs],
            paths: Paths::new(model),
            vector: vec![zero; nv],
            by_position: derivatives.clone(),
            by_velocity: derivatives,
            passes: passes::<S>(dof_parent, &mass.tiles),
            solved: vec![SolvedColumns::zero(); groups * nv],
            ancestors: vec![SolvedColumns::zero(); groups * rows],
            unit,
            mass,
        }
    }
}
