//! The inertia of a body that rotates: positive definite, with its inverse.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{InertiaError, MassProperties, PrincipalInertia};

/// 𝓘 about the centre of mass in the body frame, with all three principal moments positive, so that an
/// angular momentum determines an angular velocity.
///
/// ```
/// use dynamics::MassProperties;
/// use nalgebra::Vector3;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?.rotational()?;
/// let omega = Vector3::new(0.0, 2.0, 0.0);
/// assert!((brick.angular_velocity(&brick.momentum(&omega)) - omega).norm() < 1e-15);
/// // A thin rod spinning about itself has no momentum: it has no place here.
/// let rod = [-0.5, 0.5].map(|x| (1.0, Vector3::new(x, 0.0, 0.0)));
/// assert!(MassProperties::point_masses(&rod)?.rotational().is_err());
/// # Ok::<(), dynamics::InertiaError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationalInertia {
    matrix: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl RotationalInertia {
    /// From the inertia about the centre of mass \[kg·m²\], body axes.
    ///
    /// # Errors
    /// As for [`MassProperties::new`]; [`InertiaError::SingularMoment`] if the body is a line or a point.
    pub fn new(inertia_about_center_of_mass: Matrix3<f64>) -> Result<Self, InertiaError> {
        MassProperties::new(1.0, Vector3::zeros(), inertia_about_center_of_mass)?.rotational()
    }

    /// From three principal moments \[kg·m²\] along the body's own x, y, z.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn from_moments(moments: Vector3<f64>) -> Result<Self, InertiaError> {
        Self::new(Matrix3::from_diagonal(&moments))
    }

    /// 𝓘 \[kg·m²\], body axes.
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// R𝓘Rᵀ: the inertia in world axes at an orientation.
    pub fn in_world(&self, world_from_body: &UnitQuaternion<f64>) -> Matrix3<f64> {
        let r = world_from_body.to_rotation_matrix();
        r.matrix() * self.matrix * r.matrix().transpose()
    }

    /// Π = 𝓘ω: the angular momentum in the body frame \[kg·m²/s\] of ω \[rad/s\] in the body frame.
    pub fn momentum(&self, omega_in_body: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * omega_in_body
    }

    /// ω = 𝓘⁻¹Π, body frame.
    pub fn angular_velocity(&self, momentum_in_body: &Vector3<f64>) -> Vector3<f64> {
        self.inverse * momentum_in_body
    }

    /// K = ½ ωᵀ𝓘ω \[J\].
    pub fn kinetic_energy(&self, omega_in_body: &Vector3<f64>) -> f64 {
        0.5 * omega_in_body.dot(&(self.matrix * omega_in_body))
    }

    /// L = R𝓘ω: the angular momentum in the world frame, constant without torque.
    pub fn momentum_in_world(
        &self,
        world_from_body: &UnitQuaternion<f64>,
        omega_in_body: &Vector3<f64>,
    ) -> Vector3<f64> {
        world_from_body * self.momentum(omega_in_body)
    }

    /// The principal axes and moments.
    pub fn principal(&self) -> PrincipalInertia {
        PrincipalInertia::of(&self.matrix)
    }
}

impl MassProperties {
    /// The inertia about the centre of mass as one that can rotate about every axis.
    ///
    /// # Errors
    /// [`InertiaError::SingularMoment`] if the smallest principal moment is zero but for rounding.
    pub fn rotational(&self) -> Result<RotationalInertia, InertiaError> {
        let matrix = self.inertia_about_center_of_mass();
        let moments: [f64; 3] = self.principal().moments.into();
        // Eigenvalues carry an error of a few ε of the largest.
        if moments[0] <= 8.0 * f64::EPSILON * moments[2] {
            return Err(InertiaError::SingularMoment { moments });
        }
        let inverse = matrix.try_inverse().ok_or(InertiaError::SingularMoment { moments })?;
        Ok(RotationalInertia { matrix, inverse: (inverse + inverse.transpose()) * 0.5 })
    }
}
