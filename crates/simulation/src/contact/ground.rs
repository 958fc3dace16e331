//! Half-spaces as grounds.

use core::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use robot_dynamics_description::{Surface, SurfaceVelocity};
use robot_dynamics_number::InvalidInput;

/// A half-space that bodies do not enter: { x : n·x < d }.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ground {
    /// n, a unit vector that points out of it.
    pub normal: [f64; 3],
    /// d: the distance of its plane from the world's origin along n \[m\].
    pub offset: f64,
    /// μ of every contact with it; `None`: that of the surfaces.
    pub friction: Option<f64>,
    /// Its surface, which mixes with that of each shape; `None`: each shape's own surface counts.
    pub surface: Option<Surface>,
    /// e: the fraction of its normal speed with which a body rebounds; 0 if it does not bounce.
    pub restitution: f64,
    /// The motion of its surface, σ(x) = v + ω × x in the world, for example of a conveyor belt.
    pub surface_velocity: SurfaceVelocity,
}

impl Ground {
    /// The half-space below z \[m\].
    ///
    /// ```
    /// assert_eq!(robot_dynamics::contact::Ground::level(0.5).normal, [0.0, 0.0, 1.0]);
    /// ```
    pub const fn level(z: f64) -> Self {
        let surface_velocity = SurfaceVelocity { linear: [0.0; 3], angular: [0.0; 3] };
        let normal = [0.0, 0.0, 1.0];
        Self { normal, offset: z, friction: None, surface: None, restitution: 0.0, surface_velocity }
    }

    /// The half-space below a plane through the world's origin that rises along x by this angle \[rad\],
    /// between −π/2 and π/2.
    ///
    /// ```
    /// let [x, _, z] = robot_dynamics::contact::Ground::slope(0.3)?.normal;
    /// assert!((x / z + 0.3f64.tan()).abs() < 1e-15); // downhill is −x
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`].
    pub fn slope(angle: f64) -> Result<Self, InvalidInput> {
        if angle.is_nan() || angle.abs() >= FRAC_PI_2 {
            return Err(InvalidInput::out_of_range(
                "a slope",
                angle,
                "rad",
                "between -π/2 and π/2, both excluded",
            ));
        }
        Ok(Self { normal: [-angle.sin(), 0.0, angle.cos()], ..Self::level(0.0) })
    }

    /// The half-space below the plane through a point, whose normal (of any length) points out of it.
    ///
    /// # Errors
    /// [`InvalidInput`]: the normal has no direction.
    ///
    /// ```
    /// let wall = robot_dynamics::contact::Ground::through([2.0, 0.0, 0.0], [-3.0, 0.0, 0.0])?;
    /// assert_eq!((wall.normal, wall.offset), ([-1.0, 0.0, 0.0], -2.0));
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn through(point: [f64; 3], normal: [f64; 3]) -> Result<Self, InvalidInput> {
        let unit = Vector3::from(normal).try_normalize(0.0).filter(|unit| unit.iter().all(|x| x.is_finite()));
        let Some(unit) = unit else { return Err(bad_normal(normal)) };
        Ok(Self { normal: unit.into(), offset: unit.dot(&Vector3::from(point)), ..Self::level(0.0) })
    }

    /// Sets the coefficient of friction of every contact.
    pub const fn with_friction(self, friction: f64) -> Self {
        Self { friction: Some(friction), ..self }
    }

    /// Sets the surface. It mixes with the surface of each shape, and its `contype` and `conaffinity`
    /// determine which shapes it touches.
    ///
    /// ```
    /// use robot_dynamics::contact::Ground;
    /// use robot_dynamics::description::Surface;
    /// let mut ice = Surface::default();
    /// ice.friction[0] = 0.05;
    /// assert_eq!(Ground::level(0.0).with_surface(ice).surface, Some(ice));
    /// ```
    pub const fn with_surface(self, surface: Surface) -> Self {
        Self { surface: Some(surface), ..self }
    }

    /// Sets the restitution: the fraction, 0 to 1, of its normal speed with which a body rebounds.
    pub const fn with_restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }

    /// Sets the motion of its surface, σ(x) = v + ω × x in the world.
    ///
    /// ```
    /// use robot_dynamics::contact::Ground;
    /// use robot_dynamics::description::SurfaceVelocity;
    /// let belt = SurfaceVelocity { linear: [0.5, 0.0, 0.0], angular: [0.0; 3] };
    /// assert_eq!(Ground::level(0.0).with_surface_velocity(belt).surface_velocity, belt);
    /// ```
    pub const fn with_surface_velocity(self, surface_velocity: SurfaceVelocity) -> Self {
        Self { surface_velocity, ..self }
    }

    /// Returns an error if a number is invalid.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        let normal = Vector3::from(self.normal);
        if !((normal.norm() - 1.0).abs() < 1e-9 && self.offset.is_finite()) {
            return Err(bad_normal(self.normal));
        }
        if let Some(friction) = self.friction
            && !(friction >= 0.0 && friction.is_finite())
        {
            return Err(bad_friction(friction));
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return Err(bad_restitution(self.restitution));
        }
        if self.surface_velocity.to_array().iter().any(|x| !x.is_finite()) {
            return Err(bad_surface("a ground", "surface velocity"));
        }
        if let Some(quantity) = self.surface.and_then(|surface| surface.not_finite()) {
            return Err(bad_surface("a ground", quantity));
        }
        Ok(())
    }

    /// The world's coordinates of (n, t₁, t₂), an orthonormal basis; for level ground t₁ = x, t₂ = y.
    pub(super) fn axes(&self) -> [Vector3<f64>; 3] {
        axes(self.normal.into())
    }
}

/// The normal and two unit vectors tangential to it.
pub fn axes(n: Vector3<f64>) -> [Vector3<f64>; 3] {
    let from = if n.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let first = (from - n * n.dot(&from)).normalize();
    [n, first, n.cross(&first)]
}

/// The error of a normal without a direction, or of a plane without a position.
fn bad_normal(normal: [f64; 3]) -> InvalidInput {
    let quantity = format!("a ground's normal {normal:?}");
    InvalidInput::unmet(quantity, "is invalid: give a finite unit vector and a finite offset")
}

/// The error of a number that is not finite in the description of a shape, or of a pair of shapes.
pub(super) fn bad_surface(owner: &str, quantity: &str) -> InvalidInput {
    InvalidInput::unmet(format!("{owner}: its {quantity}"), "is not finite; correct the description")
}

/// The error of an invalid coefficient of friction.
pub(super) fn bad_friction(friction: f64) -> InvalidInput {
    InvalidInput::out_of_range("a coefficient of friction", friction, "", "finite and not negative")
}

/// The error of an invalid coefficient of restitution.
pub(super) fn bad_restitution(restitution: f64) -> InvalidInput {
    InvalidInput::out_of_range("a coefficient of restitution", restitution, "", "between 0 and 1")
}
