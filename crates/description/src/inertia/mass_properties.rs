//! The mass properties of one rigid body.

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_number::InvalidInput;

use super::error::{finite, negative_mass, positive};
use super::{InertiaError, PrincipalInertia, parallel_axis};

/// The tolerance for symmetry and the triangle inequality, relative to the largest entry or moment. A flat
/// plate lies exactly on the boundary I₃ = I₁ + I₂. Rounding its moments to single precision or to seven
/// printed digits (1e-7 each) can put them on either side.
const TOLERANCE: f64 = 1e-6;

/// Mass, centre of mass and inertia about it, in one body frame.
///
/// [`new`](Self::new) accepts only values that some mass distribution has. The mass is positive, every number
/// finite, the inertia symmetric, no principal moment negative, and none larger than the sum of the other
/// two. Zero moments are allowed: a thin rod has one, a point mass three. A system's mass matrix decides
/// whether such a body is usable.
///
/// [`as_written`](Self::as_written) accepts the values of a file, and [`flaw`](Self::flaw) reports the law
/// that they break.
///
/// ```
/// use nalgebra::{Matrix3, Vector3};
/// use robot_dynamics::description::MassProperties;
/// let com = Vector3::new(0.5, 0.0, 0.0);
/// let rod = MassProperties::new(3.0, com, Matrix3::from_diagonal(&Vector3::new(0.0, 0.25, 0.25)))?;
/// assert!((rod.inertia_about_origin()[(2, 2)] - 1.0).abs() < 1e-15);
/// // Two unit moments are incompatible with a third of 3.
/// assert!(MassProperties::new(3.0, com, Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0))).is_err());
/// # Ok::<(), robot_dynamics::description::InertiaError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    mass: f64,
    center_of_mass: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl MassProperties {
    /// From the mass \[kg\], the centre of mass \[m\] and the inertia about the centre of mass \[kg·m²\], all
    /// in the body frame. The inertia is stored as ½(𝓘 + 𝓘ᵀ).
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::{InertiaError, MassProperties};
    /// let with = |moments: [f64; 3]| {
    ///     MassProperties::new(2.0, Vector3::zeros(), Matrix3::from_diagonal(&moments.into()))
    /// };
    /// assert_eq!(with([1.0, 1.0, 2.0])?.mass(), 2.0); // a flat disc
    /// assert!(matches!(with([1.0, 1.0, 3.0]), Err(InertiaError::TriangleInequality { .. })));
    /// # Ok::<(), InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] names the number and the law that it breaks. The tolerance for symmetry and the
    /// triangle inequality is 1e-6 of the largest moment, which covers moments printed with seven digits.
    pub fn new(
        mass: f64,
        center_of_mass: Vector3<f64>,
        inertia_about_center_of_mass: Matrix3<f64>,
    ) -> Result<Self, InertiaError> {
        positive("mass", mass)?;
        let body = Self::as_written(mass, center_of_mass, inertia_about_center_of_mass)?;
        check_moments(&body.inertia)?;
        Ok(body)
    }

    /// Accepts the values of a robot file unchanged. The equations of motion are defined for any finite
    /// inertia, including one that no rigid body has, and for a mass of zero. [`flaw`](Self::flaw) reports
    /// violations.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::MassProperties;
    /// let impossible = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0));
    /// let body = MassProperties::as_written(2.0, Vector3::zeros(), impossible)?;
    /// assert_eq!(body.inertia_about_center_of_mass(), impossible); // unchanged
    /// assert_eq!(body.flaw(), MassProperties::new(2.0, Vector3::zeros(), impossible).err());
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if a number is not finite, the mass is negative, or the inertia is not symmetric.
    pub fn as_written(
        mass: f64,
        center_of_mass: Vector3<f64>,
        inertia_about_center_of_mass: Matrix3<f64>,
    ) -> Result<Self, InertiaError> {
        finite("mass", &[mass])?;
        if mass < 0.0 {
            return Err(negative_mass(mass).into());
        }
        finite("center of mass", center_of_mass.as_slice())?;
        // nalgebra stores columns; the transpose gives the entries row by row.
        finite("inertia", inertia_about_center_of_mass.transpose().as_slice())?;
        check_symmetry(&inertia_about_center_of_mass)?;
        let inertia = (inertia_about_center_of_mass + inertia_about_center_of_mass.transpose()) * 0.5;
        Ok(Self { mass, center_of_mass, inertia })
    }

    /// The law that these properties break, if [`new`](Self::new) would reject them: a mass of zero, a
    /// negative principal moment, or the triangle inequality.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::{InertiaError, MassProperties};
    /// let nothing = MassProperties::as_written(0.0, Vector3::zeros(), Matrix3::zeros())?;
    /// assert!(nothing.flaw().is_some()); // no mass
    /// assert_eq!(MassProperties::solid_sphere(1000.0, 0.1)?.flaw(), None);
    /// # Ok::<(), InertiaError>(())
    /// ```
    pub fn flaw(&self) -> Option<InertiaError> {
        positive("mass", self.mass)
            .map_err(InertiaError::from)
            .and_then(|()| check_moments(&self.inertia))
            .err()
    }

    /// The violation of the laws by the moments \[kg·m²\]: max(−I₁, I₃ − I₁ − I₂), or zero if they are valid.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::MassProperties;
    /// let moments = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0));
    /// let body = MassProperties::as_written(2.0, Vector3::zeros(), moments)?;
    /// assert!((body.moment_violation() - (3.0 - 1.0 - 1.0)).abs() < 1e-14);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn moment_violation(&self) -> f64 {
        let [a, b, c]: [f64; 3] = self.principal().moments.into();
        (-a).max(c - a - b).max(0.0)
    }

    /// [`flaw`](Self::flaw), unless the violation is within the rounding of computed moments, 1e-9 m·size².
    /// The size \[m\] is at least the body's own radius of gyration √(tr 𝓘 / 2m).
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::MassProperties;
    /// // A rod with rounded moments: negligible on a robot of 1 m.
    /// let moments = Matrix3::from_diagonal(&Vector3::new(-1e-11, 1e-6, 1e-6));
    /// let rod = MassProperties::as_written(2.0, Vector3::zeros(), moments)?;
    /// assert!(rod.flaw().is_some() && rod.flaw_beyond_rounding(1.0).is_none());
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn flaw_beyond_rounding(&self, size: f64) -> Option<InertiaError> {
        let squared = 0.5 * self.inertia.trace() / self.mass;
        let gyration = if squared > 0.0 && squared.is_finite() { squared.sqrt() } else { 0.0 };
        let size = size.max(gyration);
        let rounding = 1e-9 * self.mass * size * size;
        self.flaw().filter(|_| self.moment_violation() > rounding || self.mass == 0.0)
    }

    /// A point of mass `mass` \[kg\] at `position` \[m\], with zero inertia about itself.
    ///
    /// ```
    /// let bob = robot_dynamics::description::MassProperties::point(2.0, [0.5, 0.0, 0.0].into())?;
    /// assert_eq!(bob.inertia_about_origin()[(2, 2)], 2.0 * 0.5 * 0.5); // m l²
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if the mass is not positive or a number is not finite.
    pub fn point(mass: f64, position: Vector3<f64>) -> Result<Self, InertiaError> {
        Self::new(mass, position, Matrix3::zeros())
    }

    /// Several bodies fixed to each other, all in one frame; see [`combine`](Self::combine).
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// let [left, right] = [-1.0, 1.0].map(|x| MassProperties::point(2.0, [x, 0.0, 0.0].into()));
    /// let dumbbell = MassProperties::composite(&[left?, right?])?;
    /// assert_eq!((dumbbell.mass(), dumbbell.center_of_mass().x), (4.0, 0.0));
    /// assert_eq!(dumbbell.inertia_about_center_of_mass()[(2, 2)], 2.0 * 2.0 * 1.0); // 2 m r²
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] for an empty list.
    pub fn composite(parts: &[Self]) -> Result<Self, InvalidInput> {
        let missing = || InvalidInput::unmet("a composite body", "needs at least one part");
        let (first, rest) = parts.split_first().ok_or_else(missing)?;
        Ok(rest.iter().fold(*first, |sum, part| sum.combine(part)))
    }

    /// The mass m \[kg\].
    ///
    /// ```
    /// // A litre of water.
    /// let cube = robot_dynamics::description::MassProperties::solid_box(1000.0, [0.1, 0.1, 0.1].into())?;
    /// assert!((cube.mass() - 1.0).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// The centre of mass in the body frame \[m\].
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// // 1 kg and 3 kg, 1 m apart.
    /// let points = [(1.0, [0.0; 3].into()), (3.0, [1.0, 0.0, 0.0].into())];
    /// assert_eq!(MassProperties::point_masses(&points)?.center_of_mass().x, 0.75);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn center_of_mass(&self) -> Vector3<f64> {
        self.center_of_mass
    }

    /// 𝓘_c: the inertia about the centre of mass, body axes \[kg·m²\].
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// // The inertia of a point about itself is zero, wherever it is.
    /// let bob = MassProperties::point(2.0, [0.5, 0.0, 0.0].into())?;
    /// assert_eq!(bob.inertia_about_center_of_mass().amax(), 0.0);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn inertia_about_center_of_mass(&self) -> Matrix3<f64> {
        self.inertia
    }

    /// 𝓘_o = 𝓘_c + m(|c|²1 − c cᵀ): the inertia about the frame's origin, body axes \[kg·m²\]. **(PRM
    /// 10.46)**
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// let bob = MassProperties::point(2.0, [0.5, 0.0, 0.0].into())?;
    /// let about_origin = bob.inertia_about_origin();
    /// assert_eq!((about_origin[(0, 0)], about_origin[(1, 1)]), (0.0, 2.0 * 0.5 * 0.5));
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn inertia_about_origin(&self) -> Matrix3<f64> {
        parallel_axis(&self.inertia, self.mass, &self.center_of_mass)
    }

    /// The principal axes and moments about the centre of mass.
    ///
    /// ```
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, [0.3, 0.2, 0.1].into())?; // 6 kg
    /// let principal = brick.principal();
    /// assert!((principal.moments[0] - 0.5 * (0.04 + 0.01)).abs() < 1e-15); // m/12 (b² + c²), about its longest edge
    /// assert!((principal.body_from_principal.matrix()[(0, 0)].abs() - 1.0).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn principal(&self) -> PrincipalInertia {
        PrincipalInertia::of(&self.inertia)
    }

    /// The same mass and centre of mass with another inertia. The caller guarantees that it is valid.
    pub(super) fn with_inertia(&self, inertia_about_center_of_mass: Matrix3<f64>) -> Self {
        Self { inertia: inertia_about_center_of_mass, ..*self }
    }

    /// The same body in a parent frame: c′ = R c + t, 𝓘′ = R 𝓘 Rᵀ.
    ///
    /// `parent_from_body` is R; `origin_in_parent` t is the body frame's origin in the parent \[m\].
    ///
    /// ```
    /// use nalgebra::{Rotation3, Vector3};
    /// use robot_dynamics::description::MassProperties;
    /// let brick = MassProperties::solid_box(1000.0, [0.3, 0.2, 0.1].into())?;
    /// let quarter = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    /// let moved = brick.transformed(&quarter, &Vector3::new(1.0, 0.0, 0.0));
    /// assert_eq!(moved.center_of_mass(), Vector3::new(1.0, 0.0, 0.0));
    /// // Its longest edge is along y.
    /// let (own, turned) = (brick.inertia_about_center_of_mass(), moved.inertia_about_center_of_mass());
    /// assert!((turned[(1, 1)] - own[(0, 0)]).abs() < 1e-15 && (turned[(2, 2)] - own[(2, 2)]).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn transformed(&self, parent_from_body: &Rotation3<f64>, origin_in_parent: &Vector3<f64>) -> Self {
        let r = parent_from_body.matrix();
        let inertia = r * self.inertia * r.transpose();
        Self {
            mass: self.mass,
            center_of_mass: r * self.center_of_mass + origin_in_parent,
            // The upper and lower triangle round differently.
            inertia: (inertia + inertia.transpose()) * 0.5,
        }
    }

    /// Two bodies fixed to each other, both in the same frame.
    ///
    /// m = m₁ + m₂, c = (m₁c₁ + m₂c₂)/m, 𝓘 = 𝓘₁ + 𝓘₂ + μ(|d|²1 − d dᵀ) with the reduced mass μ = m₁m₂/m and
    /// d = c₂ − c₁. The last term is the sum of both parallel-axis terms about the common centre.
    ///
    /// ```
    /// use robot_dynamics::description::MassProperties;
    /// // Two half rods make a rod: m l²/12 = 0.25 for 3 kg and 1 m.
    /// let half = |x| {
    ///     let moments = nalgebra::Vector3::new(0.0, 1.5 / 48.0, 1.5 / 48.0);
    ///     MassProperties::new(1.5, [x, 0.0, 0.0].into(), nalgebra::Matrix3::from_diagonal(&moments))
    /// };
    /// let rod = half(-0.25)?.combine(&half(0.25)?);
    /// assert!((rod.inertia_about_center_of_mass()[(2, 2)] - 0.25).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn combine(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            // Without mass there is no centre; the inertias add.
            return Self { inertia: self.inertia + other.inertia, ..*self };
        }
        let (share, other_share) = (self.mass / mass, other.mass / mass);
        let apart = other.center_of_mass - self.center_of_mass;
        Self {
            mass,
            center_of_mass: self.center_of_mass * share + other.center_of_mass * other_share,
            inertia: parallel_axis(&(self.inertia + other.inertia), share * other.mass, &apart),
        }
    }
}

/// |𝓘_ij − 𝓘_ji| relative to the largest entry.
fn check_symmetry(inertia: &Matrix3<f64>) -> Result<(), InertiaError> {
    let allowed = TOLERANCE * inertia.amax();
    for (row, column) in [(0, 1), (0, 2), (1, 2)] {
        let (upper, lower) = (inertia[(row, column)], inertia[(column, row)]);
        if (upper - lower).abs() > allowed {
            return Err(InertiaError::NotSymmetric { row, column, upper, lower });
        }
    }
    Ok(())
}

/// Principal moments 0 ≤ I₁ ≤ I₂ ≤ I₃ ≤ I₁ + I₂.
fn check_moments(inertia: &Matrix3<f64>) -> Result<(), InertiaError> {
    let moments: [f64; 3] = PrincipalInertia::of(inertia).moments.into();
    let allowed = TOLERANCE * inertia.amax();
    if moments[0] < -allowed {
        return Err(InertiaError::NegativeMoment { moments });
    }
    if moments[2] > moments[0] + moments[1] + allowed {
        return Err(InertiaError::TriangleInequality { moments });
    }
    Ok(())
}
