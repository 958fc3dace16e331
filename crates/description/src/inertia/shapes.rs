//! Inertia from density for solid shapes: 𝓘 = ∫ ρ (|r|²1 − r rᵀ) dV in closed form. **(PRM 10.42)**
//!
//! Every shape is centred on the origin with its axes along x, y, z; use [`MassProperties::transformed`] to
//! place it.

use core::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::error::positive;
use super::{InertiaError, MassProperties};

impl MassProperties {
    /// A box of edges (a, b, c) \[m\] and density ρ \[kg/m³\]: 𝓘 = m/12 diag(b²+c², a²+c², a²+b²).
    ///
    /// ```
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, [0.3, 0.2, 0.1].into())?;
    /// assert!((brick.mass() - 6.0).abs() < 1e-14);
    /// assert!((brick.inertia_about_center_of_mass()[(0, 0)] - 0.5 * (0.04 + 0.01)).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the density or an edge is not positive and finite.
    pub fn solid_box(density: f64, edges: Vector3<f64>) -> Result<Self, InertiaError> {
        // ⟨x²⟩ over an interval of length a is a²/12.
        Self::diagonal(density, edges, edges.product(), 1.0 / 12.0)
    }

    /// An ellipsoid of semi-axes (a, b, c) \[m\] and density ρ \[kg/m³\]: 𝓘 = m/5 diag(b²+c², a²+c², a²+b²).
    ///
    /// ```
    /// // With three equal semi-axes it is a ball.
    /// use robot_dynamics::description::MassProperties;
    /// let ball = MassProperties::solid_ellipsoid(1000.0, [0.1, 0.1, 0.1].into())?;
    /// assert_eq!(ball, MassProperties::solid_sphere(1000.0, 0.1)?);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the density or a semi-axis is not positive and finite.
    pub fn solid_ellipsoid(density: f64, semi_axes: Vector3<f64>) -> Result<Self, InertiaError> {
        Self::diagonal(density, semi_axes, 4.0 / 3.0 * PI * semi_axes.product(), 1.0 / 5.0)
    }

    /// A ball of radius r \[m\] and density ρ \[kg/m³\]: 𝓘 = ⅖ m r² 1.
    ///
    /// # Errors
    /// [`InertiaError`] if the density or the radius is not positive and finite.
    ///
    /// ```
    /// let ball = robot_dynamics::description::MassProperties::solid_sphere(1000.0, 0.1)?;
    /// let expected = 0.4 * ball.mass() * 0.01;
    /// assert!((ball.inertia_about_center_of_mass()[(0, 0)] - expected).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn solid_sphere(density: f64, radius: f64) -> Result<Self, InertiaError> {
        Self::solid_ellipsoid(density, Vector3::repeat(radius))
    }

    /// A cylinder of radius r and length l \[m\] along z, density ρ \[kg/m³\]:
    /// 𝓘 = m diag(r²/4 + l²/12, r²/4 + l²/12, r²/2).
    ///
    /// ```
    /// let disc = robot_dynamics::description::MassProperties::solid_cylinder(8000.0, 0.2, 0.01)?;
    /// let along = disc.inertia_about_center_of_mass()[(2, 2)];
    /// assert!((along - 0.5 * disc.mass() * 0.04).abs() < 1e-15); // ½ m r²
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the density, the radius or the length is not positive and finite.
    pub fn solid_cylinder(density: f64, radius: f64, length: f64) -> Result<Self, InertiaError> {
        positive("density", density)?;
        positive("radius", radius)?;
        positive("length", length)?;
        let mass = density * PI * radius * radius * length;
        let (across, along) = (radius * radius / 4.0, length * length / 12.0);
        let moments = Vector3::new(across + along, across + along, 2.0 * across) * mass;
        Self::new(mass, Vector3::zeros(), Matrix3::from_diagonal(&moments))
    }

    /// A capsule along z, density ρ \[kg/m³\]: a cylinder of radius r and length l \[m\] with two half balls.
    /// The centre of mass of a half ball is 3r/8 beyond the end of the cylinder.
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// // Without a cylinder it is a ball.
    /// let (short, ball) = (MassProperties::solid_capsule(1000.0, 0.1, 0.0)?, MassProperties::solid_sphere(1000.0, 0.1)?);
    /// assert!((short.mass() - ball.mass()).abs() < 1e-14);
    /// let moments = short.inertia_about_center_of_mass() - ball.inertia_about_center_of_mass();
    /// assert!(moments.amax() < 1e-16);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the density or the radius is not positive and finite, or the length is negative or
    /// not finite.
    pub fn solid_capsule(density: f64, radius: f64, length: f64) -> Result<Self, InertiaError> {
        positive("density", density)?;
        positive("radius", radius)?;
        if length != 0.0 {
            positive("length", length)?;
        }
        let cylinder = density * PI * radius * radius * length;
        let balls = density * 4.0 / 3.0 * PI * radius.powi(3);
        let along = cylinder * radius * radius / 2.0 + balls * 0.4 * radius * radius;
        let half = 0.5 * length;
        let across = cylinder * (radius * radius / 4.0 + length * length / 12.0)
            + balls * (0.4 * radius * radius + half * half + 0.75 * radius * half);
        let moments = Vector3::new(across, across, along);
        Self::new(cylinder + balls, Vector3::zeros(), Matrix3::from_diagonal(&moments))
    }

    /// Point masses (m_k \[kg\], r_k \[m\]) fixed to each other: 𝓘_o = Σ m_k(|r_k|²1 − r_k r_kᵀ).
    ///
    /// ```
    /// // The corners of a square, 1 kg each, 1 m from its centre: Σ m r² = 4 about its axis.
    /// let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    /// let square = robot_dynamics::description::MassProperties::point_masses(&corners.map(|r| (1.0, r.into())))?;
    /// assert!((square.inertia_about_center_of_mass()[(2, 2)] - 4.0).abs() < 1e-14);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the list is empty, a mass is not positive or a number is not finite.
    pub fn point_masses(points: &[(f64, Vector3<f64>)]) -> Result<Self, InertiaError> {
        let parts = points
            .iter()
            .map(|&(mass, position)| Self::point(mass, position))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self::composite(&parts)?)
    }

    /// ⟨x²⟩ = `spread` a² and so on, for a shape with three symmetry planes.
    fn diagonal(density: f64, lengths: Vector3<f64>, volume: f64, spread: f64) -> Result<Self, InertiaError> {
        positive("density", density)?;
        lengths.iter().try_for_each(|&length| positive("length", length))?;
        let mass = density * volume;
        let [x, y, z] = lengths.map(|a| spread * a * a).into();
        let moments = Vector3::new(y + z, x + z, x + y) * mass;
        Self::new(mass, Vector3::zeros(), Matrix3::from_diagonal(&moments))
    }
}
