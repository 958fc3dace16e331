//! Second derivatives as methods of [`Model`], which check their input and allocate their memory.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_number::check_result;

use crate::{Model, MotionError, SecondOrderWorkspace, check_configuration, check_vector};

/// The product H α of the Hessian of λᵀτ(q, v, a) and a direction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseHessianProduct {
    /// The rows for q, nv numbers.
    pub by_position: DVector<f64>,
    /// The rows for v.
    pub by_velocity: DVector<f64>,
    /// The rows for a.
    pub by_acceleration: DVector<f64>,
}

/// The product H α of the Hessian of āᵀa(q, v, τ) and a direction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ForwardHessianProduct {
    /// The rows for q, nv numbers.
    pub by_position: DVector<f64>,
    /// The rows for v.
    pub by_velocity: DVector<f64>,
    /// The rows for τ.
    pub by_force: DVector<f64>,
}

/// The second derivatives of τ(q, v, a): for each component i of τ an nv×nv matrix.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseSecondDerivatives {
    /// ∂²τᵢ/∂qⱼ∂qₖ, symmetric.
    pub position_position: Vec<DMatrix<f64>>,
    /// ∂²τᵢ/∂qⱼ∂vₖ.
    pub position_velocity: Vec<DMatrix<f64>>,
    /// ∂²τᵢ/∂vⱼ∂vₖ, symmetric.
    pub velocity_velocity: Vec<DMatrix<f64>>,
    /// ∂²τᵢ/∂qⱼ∂aₖ = ∂M_ik/∂qⱼ.
    pub position_acceleration: Vec<DMatrix<f64>>,
}

/// The second derivatives of a(q, v, τ): for each component i of a an nv×nv matrix.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ForwardSecondDerivatives {
    /// ∂²aᵢ/∂qⱼ∂qₖ, symmetric.
    pub position_position: Vec<DMatrix<f64>>,
    /// ∂²aᵢ/∂qⱼ∂vₖ.
    pub position_velocity: Vec<DMatrix<f64>>,
    /// ∂²aᵢ/∂vⱼ∂vₖ, symmetric.
    pub velocity_velocity: Vec<DMatrix<f64>>,
    /// ∂²aᵢ/∂qⱼ∂τₖ = ∂(M⁻¹)_ik/∂qⱼ.
    pub position_force: Vec<DMatrix<f64>>,
}

type Result<T> = core::result::Result<T, MotionError>;

/// Second derivatives, with H of [`inverse_dynamics_hessian`](crate::inverse_dynamics_hessian).
///
/// # Errors
/// [`MotionError`] names the number at fault; [`MotionError::SingularMass`] the joints that move no inertia.
#[allow(clippy::missing_errors_doc)] // documented on the block
impl Model {
    /// The Hessian of λᵀτ, 3nv×3nv in the order q, v, a; see
    /// [`inverse_dynamics_hessian`](crate::inverse_dynamics_hessian).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // τ = m l² a − m g l cos q
    /// let h = Model::new(pendulum(2.0, 0.5))?.inverse_dynamics_hessian(&[0.3], &[1.0], &[2.0], &[3.0])?;
    /// assert!((h[(0, 0)] - 3.0 * 9.81 * 0.3_f64.cos()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse_dynamics_hessian(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        cotangent: &[f64],
    ) -> Result<DMatrix<f64>> {
        self.check_point(q, [("v", v), ("a", a), ("the cotangent", cotangent)])?;
        let inputs = crate::InversePullbackInputs { q, v, a, wrenches: &[], cotangent };
        let mut hessian = vec![0.0; 9 * self.nv * self.nv];
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::inverse_dynamics_hessian(self, workspace, inputs, &mut hessian);
        check_result("the Hessian", &hessian)?;
        Ok(DMatrix::from_row_slice(3 * self.nv, 3 * self.nv, &hessian))
    }

    /// The Hessian of āᵀa, 3nv×3nv in the order q, v, τ; see
    /// [`forward_dynamics_hessian`](crate::forward_dynamics_hessian).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // a = (τ + m g l cos q)/(m l²)
    /// let h = Model::new(pendulum(2.0, 0.5))?.forward_dynamics_hessian(&[0.3], &[1.0], &[0.7], &[3.0])?;
    /// assert!((h[(0, 0)] + 3.0 * 9.81 / 0.5 * 0.3_f64.cos()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward_dynamics_hessian(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        cotangent: &[f64],
    ) -> Result<DMatrix<f64>> {
        self.check_point(q, [("v", v), ("tau", tau), ("the cotangent", cotangent)])?;
        self.check_mass(q)?;
        let inputs = crate::ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent };
        let mut hessian = vec![0.0; 9 * self.nv * self.nv];
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::forward_dynamics_hessian(self, workspace, inputs, &mut hessian);
        check_result("the Hessian", &hessian)?;
        Ok(DMatrix::from_row_slice(3 * self.nv, 3 * self.nv, &hessian))
    }

    /// The product of the Hessian of λᵀτ and a direction (δq, δv, δa); see
    /// [`inverse_dynamics_hessian_product`](crate::inverse_dynamics_hessian_product).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let along = [&[0.1][..], &[0.0], &[0.0]];
    /// let by = model.inverse_dynamics_hessian_product(&[0.3], &[1.0], &[2.0], &[3.0], along)?;
    /// assert!((by.by_position[0] - 0.1 * 3.0 * 9.81 * 0.3_f64.cos()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse_dynamics_hessian_product(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        cotangent: &[f64],
        direction: [&[f64]; 3],
    ) -> Result<InverseHessianProduct> {
        self.check_point(q, [("v", v), ("a", a), ("the cotangent", cotangent)])?;
        let [position, velocity, acceleration] = direction;
        self.check_point(q, [("δq", position), ("δv", velocity), ("δa", acceleration)])?;
        let [mut x, mut y, mut z] = [(); 3].map(|()| DVector::zeros(self.nv));
        let results = crate::InverseHessianProductMut {
            by_position: x.as_mut_slice(),
            by_velocity: y.as_mut_slice(),
            by_acceleration: z.as_mut_slice(),
        };
        let inputs = crate::InversePullbackInputs { q, v, a, wrenches: &[], cotangent };
        let directions = crate::InverseDirections { position, velocity, acceleration };
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::inverse_dynamics_hessian_product(self, workspace, inputs, directions, results);
        for numbers in [&x, &y, &z] {
            check_result("H α", numbers.as_slice())?;
        }
        Ok(InverseHessianProduct { by_position: x, by_velocity: y, by_acceleration: z })
    }

    /// The product of the Hessian of āᵀa and a direction (δq, δv, δτ); see
    /// [`forward_dynamics_hessian_product`](crate::forward_dynamics_hessian_product).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let along = [&[0.1][..], &[0.0], &[0.0]];
    /// let by = model.forward_dynamics_hessian_product(&[0.3], &[1.0], &[0.7], &[3.0], along)?;
    /// assert!((by.by_position[0] + 0.1 * 3.0 * 9.81 / 0.5 * 0.3_f64.cos()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward_dynamics_hessian_product(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        cotangent: &[f64],
        direction: [&[f64]; 3],
    ) -> Result<ForwardHessianProduct> {
        self.check_point(q, [("v", v), ("tau", tau), ("the cotangent", cotangent)])?;
        let [position, velocity, force] = direction;
        self.check_point(q, [("δq", position), ("δv", velocity), ("δτ", force)])?;
        self.check_mass(q)?;
        let [mut x, mut y, mut z] = [(); 3].map(|()| DVector::zeros(self.nv));
        let results = crate::ForwardHessianProductMut {
            by_position: x.as_mut_slice(),
            by_velocity: y.as_mut_slice(),
            by_force: z.as_mut_slice(),
        };
        let inputs = crate::ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent };
        let directions = crate::ForwardDirections { position, velocity, force };
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::forward_dynamics_hessian_product(self, workspace, inputs, directions, results);
        for numbers in [&x, &y, &z] {
            check_result("H α", numbers.as_slice())?;
        }
        Ok(ForwardHessianProduct { by_position: x, by_velocity: y, by_force: z })
    }

    /// The second derivatives of τ(q, v, a); see
    /// [`inverse_dynamics_second_derivatives`](crate::inverse_dynamics_second_derivatives).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let second = model.inverse_dynamics_second_derivatives(&[0.3], &[1.0], &[2.0])?;
    /// assert!((second.position_position[0][(0, 0)] - 9.81 * 0.3_f64.cos()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse_dynamics_second_derivatives(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
    ) -> Result<InverseSecondDerivatives> {
        self.check_point(q, [("v", v), ("a", a)])?;
        let [mut x, mut y, mut z, mut u] = [(); 4].map(|()| vec![0.0; self.nv.pow(3)]);
        let results = crate::InverseSecondDerivativesMut {
            position_position: &mut x,
            position_velocity: &mut y,
            velocity_velocity: &mut z,
            position_acceleration: &mut u,
        };
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::inverse_dynamics_second_derivatives(self, workspace, q, v, a, &[], results);
        Ok(InverseSecondDerivatives {
            position_position: self.tensor(&x)?,
            position_velocity: self.tensor(&y)?,
            velocity_velocity: self.tensor(&z)?,
            position_acceleration: self.tensor(&u)?,
        })
    }

    /// The second derivatives of a(q, v, τ); see
    /// [`forward_dynamics_second_derivatives`](crate::forward_dynamics_second_derivatives).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let second = model.forward_dynamics_second_derivatives(&[0.3], &[1.0], &[0.7])?;
    /// assert!((second.position_position[0][(0, 0)] + 9.81 / 0.5 * 0.3_f64.cos()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward_dynamics_second_derivatives(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
    ) -> Result<ForwardSecondDerivatives> {
        self.check_point(q, [("v", v), ("tau", tau)])?;
        self.check_mass(q)?;
        let [mut x, mut y, mut z, mut u] = [(); 4].map(|()| vec![0.0; self.nv.pow(3)]);
        let results = crate::ForwardSecondDerivativesMut {
            position_position: &mut x,
            position_velocity: &mut y,
            velocity_velocity: &mut z,
            position_force: &mut u,
        };
        let workspace = &mut SecondOrderWorkspace::new(self);
        crate::forward_dynamics_second_derivatives(self, workspace, q, v, tau, &[], results);
        Ok(ForwardSecondDerivatives {
            position_position: self.tensor(&x)?,
            position_velocity: self.tensor(&y)?,
            velocity_velocity: self.tensor(&z)?,
            position_force: self.tensor(&u)?,
        })
    }

    fn check_point<const N: usize>(&self, q: &[f64], vectors: [(&str, &[f64]); N]) -> Result<()> {
        check_configuration(self, q)?;
        for (quantity, numbers) in vectors {
            check_vector(self, quantity, numbers)?;
        }
        Ok(())
    }

    /// The nv matrices of a tensor.
    fn tensor(&self, numbers: &[f64]) -> Result<Vec<DMatrix<f64>>> {
        check_result("the second derivatives", numbers)?;
        let matrices = numbers.chunks_exact((self.nv * self.nv).max(1));
        Ok(matrices.map(|matrix| DMatrix::from_row_slice(self.nv, self.nv, matrix)).collect())
    }
}
