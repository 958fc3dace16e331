//! The rotational inertia of a body that is not a line or a point: positive definite, with its inverse.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{InertiaError, MassProperties, PrincipalInertia};

/// 𝓘 about the centre of mass in the body frame, with all three principal moments positive, so that an
/// angular momentum determines an angular velocity.
///
/// ```
/// use nalgebra::Vector3;
/// use robot_dynamics::description::MassProperties;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?.rotational()?;
/// let omega = Vector3::new(0.0, 2.0, 0.0);
/// assert!((brick.angular_velocity(&brick.momentum(&omega)) - omega).norm() < 1e-15);
/// // A thin rod has no angular momentum about its axis, so it is rejected.
/// let rod = [-0.5, 0.5].map(|x| (1.0, Vector3::new(x, 0.0, 0.0)));
/// assert!(MassProperties::point_masses(&rod)?.rotational().is_err());
/// # Ok::<(), robot_dynamics::description::InertiaError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationalInertia {
    matrix: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl RotationalInertia {
    /// Creates it from the inertia about the centre of mass \[kg·m²\], body axes.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::{InertiaError, RotationalInertia};
    /// let body = RotationalInertia::new(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5)))?;
    /// assert_eq!(body.momentum(&Vector3::new(0.0, 3.0, 0.0)), Vector3::new(0.0, 6.0, 0.0));
    /// let line = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0));
    /// assert!(matches!(RotationalInertia::new(line), Err(InertiaError::SingularMoment { .. })));
    /// # Ok::<(), InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`MassProperties::new`]; [`InertiaError::SingularMoment`] if the body is a line or a point.
    pub fn new(inertia_about_center_of_mass: Matrix3<f64>) -> Result<Self, InertiaError> {
        MassProperties::new(1.0, Vector3::zeros(), inertia_about_center_of_mass)?.rotational()
    }

    /// Creates it from three principal moments \[kg·m²\] along the body's own x, y, z.
    ///
    /// ```
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// assert_eq!(body.kinetic_energy(&[0.0, 0.0, 2.0].into()), 0.5 * 2.5 * 4.0);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn from_moments(moments: Vector3<f64>) -> Result<Self, InertiaError> {
        Self::new(Matrix3::from_diagonal(&moments))
    }

    /// 𝓘 \[kg·m²\], body axes.
    ///
    /// ```
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// assert_eq!(body.matrix().diagonal(), nalgebra::Vector3::new(1.0, 2.0, 2.5));
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// R𝓘Rᵀ: the inertia in world axes at an orientation.
    ///
    /// ```
    /// use nalgebra::{UnitQuaternion, Vector3};
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// // After a quarter turn about z the moment about the world's x is that about the body's y.
    /// let r = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    /// assert!((body.in_world(&r)[(0, 0)] - 2.0).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn in_world(&self, world_from_body: &UnitQuaternion<f64>) -> Matrix3<f64> {
        let r = world_from_body.to_rotation_matrix();
        r.matrix() * self.matrix * r.matrix().transpose()
    }

    /// Π = 𝓘ω: the angular momentum \[kg·m²/s\] for ω \[rad/s\], both in the body frame.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// assert_eq!(body.momentum(&Vector3::new(3.0, 3.0, 2.0)), Vector3::new(3.0, 6.0, 5.0));
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn momentum(&self, omega_in_body: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * omega_in_body
    }

    /// ω = 𝓘⁻¹Π \[rad/s\], body frame.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// assert_eq!(body.angular_velocity(&Vector3::new(3.0, 6.0, 5.0)), Vector3::new(3.0, 3.0, 2.0));
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn angular_velocity(&self, momentum_in_body: &Vector3<f64>) -> Vector3<f64> {
        self.inverse * momentum_in_body
    }

    /// K = ½ ωᵀ𝓘ω \[J\].
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// let (body, omega) =
    ///     (robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?, Vector3::new(3.0, 3.0, 2.0));
    /// assert_eq!(body.kinetic_energy(&omega), 0.5 * omega.dot(&body.momentum(&omega))); // ½ ω·Π
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn kinetic_energy(&self, omega_in_body: &Vector3<f64>) -> f64 {
        0.5 * omega_in_body.dot(&(self.matrix * omega_in_body))
    }

    /// L = R𝓘ω: the angular momentum in the world frame, constant without torque.
    ///
    /// ```
    /// use nalgebra::{UnitQuaternion, Vector3};
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([1.0, 2.0, 2.5].into())?;
    /// let (r, omega) = (UnitQuaternion::from_euler_angles(0.3, -0.8, 1.1), Vector3::new(3.0, 3.0, 2.0));
    /// let in_world = body.in_world(&r) * (r * omega); // R𝓘Rᵀ times Rω
    /// assert!((body.momentum_in_world(&r, &omega) - in_world).norm() < 1e-14);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn momentum_in_world(
        &self,
        world_from_body: &UnitQuaternion<f64>,
        omega_in_body: &Vector3<f64>,
    ) -> Vector3<f64> {
        world_from_body * self.momentum(omega_in_body)
    }

    /// The principal axes and moments.
    ///
    /// ```
    /// let body = robot_dynamics::description::RotationalInertia::from_moments([2.5, 1.0, 2.0].into())?;
    /// assert!((body.principal().moments - nalgebra::Vector3::new(1.0, 2.0, 2.5)).norm() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn principal(&self) -> PrincipalInertia {
        PrincipalInertia::of(&self.matrix)
    }
}

impl MassProperties {
    /// The inertia about the centre of mass as a [`RotationalInertia`].
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// let brick = MassProperties::solid_box(1000.0, [0.3, 0.2, 0.1].into())?;
    /// assert_eq!(brick.rotational()?.matrix(), &brick.inertia_about_center_of_mass());
    /// assert!(MassProperties::point(2.0, [0.5, 0.0, 0.0].into())?.rotational().is_err()); // a point has no rotational inertia
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError::SingularMoment`] if the smallest principal moment is zero up to rounding.
    pub fn rotational(&self) -> Result<RotationalInertia, InertiaError> {
        let matrix = self.inertia_about_center_of_mass();
        let moments: [f64; 3] = self.principal().moments.into();
        // Eigenvalues have an error of a few ε of the largest.
        if moments[0] <= 8.0 * f64::EPSILON * moments[2] {
            return Err(InertiaError::SingularMoment { moments });
        }
        let inverse = matrix.try_inverse().ok_or(InertiaError::SingularMoment { moments })?;
        Ok(RotationalInertia { matrix, inverse: (inverse + inverse.transpose()) * 0.5 })
    }
}
