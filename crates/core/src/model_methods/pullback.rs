//! The pullbacks as methods of [`Model`], which check their input and allocate their memory.

use nalgebra::DVector;
use robot_dynamics_number::check_result;

use crate::{Model, MotionError, Workspace, check_configuration, check_vector, parameter_count};

/// The gradient of λᵀτ(q, v, a).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InversePullback {
    /// λᵀ∂τ/∂q, nv numbers; along [`integrate`](crate::integrate)(q, δ eⱼ) for quaternion joints.
    pub by_position: DVector<f64>,
    /// λᵀ∂τ/∂v.
    pub by_velocity: DVector<f64>,
    /// λᵀ∂τ/∂a = M λ.
    pub by_acceleration: DVector<f64>,
    /// λᵀ∂τ/∂ of the description's parameters: see
    /// [`ParameterCotangents::of`](crate::ParameterCotangents::of).
    pub parameters: DVector<f64>,
}

/// a(q, v, τ) and the gradient of āᵀa.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ForwardPullback {
    /// a.
    pub acceleration: DVector<f64>,
    /// āᵀ∂a/∂q, nv numbers; along [`integrate`](crate::integrate)(q, δ eⱼ) for quaternion joints.
    pub by_position: DVector<f64>,
    /// āᵀ∂a/∂v.
    pub by_velocity: DVector<f64>,
    /// āᵀ∂a/∂τ = M⁻¹ā.
    pub by_force: DVector<f64>,
    /// āᵀ∂a/∂ of the description's parameters: see
    /// [`ParameterCotangents::of`](crate::ParameterCotangents::of).
    pub parameters: DVector<f64>,
}

type Result<T> = core::result::Result<T, MotionError>;

impl Model {
    /// The gradient of λᵀτ; see [`inverse_dynamics_pullback`](crate::inverse_dynamics_pullback).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // τ = m l² a − m g l cos q
    /// let by = Model::new(pendulum(2.0, 0.5))?.inverse_dynamics_pullback(&[0.3], &[1.0], &[2.0], &[3.0])?;
    /// assert!((by.by_position[0] - 3.0 * 9.81 * 0.3_f64.sin()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotionError`] names the number at fault.
    pub fn inverse_dynamics_pullback(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        cotangent: &[f64],
    ) -> Result<InversePullback> {
        check_configuration(self, q)?;
        for (quantity, numbers) in [("v", v), ("a", a), ("the cotangent", cotangent)] {
            check_vector(self, quantity, numbers)?;
        }
        let [mut x, mut y, mut z] = [(); 3].map(|()| DVector::zeros(self.nv));
        let mut parameters = DVector::zeros(parameter_count(self));
        let out = crate::InversePullbackMut {
            by_position: x.as_mut_slice(),
            by_velocity: y.as_mut_slice(),
            by_acceleration: z.as_mut_slice(),
            parameters: parameters.as_mut_slice(),
        };
        crate::inverse_dynamics_pullback_with_parameters(
            self,
            &mut Workspace::new(self),
            crate::InversePullbackInputs { q, v, a, wrenches: &[], cotangent },
            out,
        );
        for (quantity, numbers) in
            [("λᵀ∂τ/∂q", &x), ("λᵀ∂τ/∂v", &y), ("M λ", &z), ("the cotangent of a parameter", &parameters)]
        {
            check_result(quantity, numbers.as_slice())?;
        }
        Ok(InversePullback { by_position: x, by_velocity: y, by_acceleration: z, parameters })
    }

    /// a and the gradient of āᵀa; see [`forward_dynamics_pullback`](crate::forward_dynamics_pullback).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // a = (τ + m g l cos q)/(m l²)
    /// let by = Model::new(pendulum(2.0, 0.5))?.forward_dynamics_pullback(&[0.3], &[1.0], &[0.7], &[3.0])?;
    /// assert!((by.by_force[0] - 3.0 / 0.5).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotionError`] names the number at fault; [`MotionError::SingularMass`] the joints that move no
    /// inertia.
    pub fn forward_dynamics_pullback(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        cotangent: &[f64],
    ) -> Result<ForwardPullback> {
        check_configuration(self, q)?;
        for (quantity, numbers) in [("v", v), ("tau", tau), ("the cotangent", cotangent)] {
            check_vector(self, quantity, numbers)?;
        }
        self.check_mass(q)?;
        let [mut a, mut x, mut y, mut z] = [(); 4].map(|()| DVector::zeros(self.nv));
        let mut parameters = DVector::zeros(parameter_count(self));
        let out = crate::ForwardPullbackMut {
            acceleration: a.as_mut_slice(),
            by_position: x.as_mut_slice(),
            by_velocity: y.as_mut_slice(),
            by_force: z.as_mut_slice(),
            parameters: parameters.as_mut_slice(),
        };
        crate::forward_dynamics_pullback_with_parameters(
            self,
            &mut Workspace::new(self),
            crate::ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent },
            out,
        );
        for (quantity, numbers) in [
            ("a", &a),
            ("āᵀ∂a/∂q", &x),
            ("āᵀ∂a/∂v", &y),
            ("M⁻¹ā", &z),
            ("the cotangent of a parameter", &parameters),
        ] {
            check_result(quantity, numbers.as_slice())?;
        }
        Ok(ForwardPullback { acceleration: a, by_position: x, by_velocity: y, by_force: z, parameters })
    }
}
