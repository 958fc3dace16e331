//! The mass properties of one rigid body.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::error::{finite, positive};
use super::{InertiaError, PrincipalInertia, parallel_axis};

/// How far an inertia may miss symmetry or the triangle inequality, as a fraction of its largest entry
/// or moment. A flat plate lies exactly on the boundary I₃ = I₁ + I₂, so moments that were rounded to
/// single precision or to seven printed digits (1e-7 each) land on either side of it.
const TOLERANCE: f64 = 1e-6;

/// Mass, centre of mass and inertia about it, in one body frame.
///
/// [`new`](Self::new) makes only what some mass distribution has: the mass is positive, every number finite, the
/// inertia symmetric, no principal moment negative, none more than the sum of the other two. Zero moments are
/// allowed: a thin rod has one, a point mass three. Whether a *system* can use such a body is for its mass
/// matrix to say. [`as_written`](Self::as_written) takes what a file says, and [`flaw`](Self::flaw) tells what is
/// wrong with it.
///
/// ```
/// use dynamics::MassProperties;
/// use nalgebra::{Matrix3, Vector3};
/// let com = Vector3::new(0.5, 0.0, 0.0);
/// let rod = MassProperties::new(3.0, com, Matrix3::from_diagonal(&Vector3::new(0.0, 0.25, 0.25)))?;
/// assert!((rod.inertia_about_origin()[(2, 2)] - 1.0).abs() < 1e-15);
/// // Two unit moments cannot go with a third of 3.
/// assert!(MassProperties::new(3.0, com, Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0))).is_err());
/// # Ok::<(), dynamics::InertiaError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    mass: f64,
    center_of_mass: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl MassProperties {
    /// From the mass \[kg\], the centre of mass \[m\] and the inertia about the centre of mass \[kg·m²\],
    /// all in the body frame. The inertia is stored as ½(𝓘 + 𝓘ᵀ).
    ///
    /// # Errors
    /// [`InertiaError`] names the number and the law it breaks. Symmetry and the triangle inequality may
    /// be missed by 1e-6 of the largest moment, the rounding of moments printed with seven digits.
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

    /// What a robot file states, taken as it is: the equations of motion have a meaning for any finite inertia,
    /// also for one that no rigid body has, and for a mass of zero. [`flaw`](Self::flaw) judges it.
    ///
    /// # Errors
    /// [`InertiaError`] if a number is not finite, the mass is negative, or the inertia not symmetric.
    pub fn as_written(
        mass: f64,
        center_of_mass: Vector3<f64>,
        inertia_about_center_of_mass: Matrix3<f64>,
    ) -> Result<Self, InertiaError> {
        finite("mass", &[mass])?;
        if mass < 0.0 {
            return Err(InertiaError::NegativeMass { value: mass });
        }
        finite("center of mass", center_of_mass.as_slice())?;
        // nalgebra stores columns; the transpose lists the entries row by row.
        finite("inertia", inertia_about_center_of_mass.transpose().as_slice())?;
        check_symmetry(&inertia_about_center_of_mass)?;
        let inertia = (inertia_about_center_of_mass + inertia_about_center_of_mass.transpose()) * 0.5;
        Ok(Self { mass, center_of_mass, inertia })
    }

    /// The law that these properties break, if [`new`](Self::new) would refuse them: a mass of zero, a negative
    /// principal moment, or the triangle inequality.
    pub fn flaw(&self) -> Option<InertiaError> {
        positive("mass", self.mass).and_then(|()| check_moments(&self.inertia)).err()
    }

    /// By how much the moments miss the laws \[kg·m²\]: max(−I₁, I₃ − I₁ − I₂), zero for those of a body.
    pub fn moment_violation(&self) -> f64 {
        let [a, b, c]: [f64; 3] = self.principal().moments.into();
        (-a).max(c - a - b).max(0.0)
    }

    /// A point of mass `mass` \[kg\] at `position` \[m\]: no inertia about itself.
    ///
    /// # Errors
    /// [`InertiaError`] if the mass is not positive or a number is not finite.
    pub fn point(mass: f64, position: Vector3<f64>) -> Result<Self, InertiaError> {
        Self::new(mass, position, Matrix3::zeros())
    }

    /// Several bodies fixed to each other, all given in one frame; see [`combine`](Self::combine).
    ///
    /// # Errors
    /// [`InertiaError::NoParts`] for an empty list.
    pub fn composite(parts: &[Self]) -> Result<Self, InertiaError> {
        let (first, rest) = parts.split_first().ok_or(InertiaError::NoParts)?;
        Ok(rest.iter().fold(*first, |sum, part| sum.combine(part)))
    }

    /// The mass m \[kg\].
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// The centre of mass in the body frame \[m\].
    pub fn center_of_mass(&self) -> Vector3<f64> {
        self.center_of_mass
    }

    /// 𝓘_c: the inertia about the centre of mass, body axes \[kg·m²\].
    pub fn inertia_about_center_of_mass(&self) -> Matrix3<f64> {
        self.inertia
    }

    /// 𝓘_o = 𝓘_c + m(|c|²1 − c cᵀ): the inertia about the frame's origin, body axes \[kg·m²\]. **(PRM 10.46)**
    pub fn inertia_about_origin(&self) -> Matrix3<f64> {
        parallel_axis(&self.inertia, self.mass, &self.center_of_mass)
    }

    /// The principal axes and moments about the centre of mass.
    pub fn principal(&self) -> PrincipalInertia {
        PrincipalInertia::of(&self.inertia)
    }

    /// The same mass at the same place with another inertia, which the caller vouches for.
    pub(super) fn with_inertia(&self, inertia_about_center_of_mass: Matrix3<f64>) -> Self {
        Self { inertia: inertia_about_center_of_mass, ..*self }
    }

    /// The same body seen from a parent frame: c′ = R c + t, 𝓘′ = R 𝓘 Rᵀ.
    ///
    /// `parent_from_body` is R; `origin_in_parent` t is the body frame's origin in the parent \[m\].
    pub fn transformed(&self, parent_from_body: &Rotation3<f64>, origin_in_parent: &Vector3<f64>) -> Self {
        let r = parent_from_body.matrix();
        let inertia = r * self.inertia * r.transpose();
        Self {
            mass: self.mass,
            center_of_mass: r * self.center_of_mass + origin_in_parent,
            // The two triangles round differently.
            inertia: (inertia + inertia.transpose()) * 0.5,
        }
    }

    /// Two bodies fixed to each other, both given in the same frame.
    ///
    /// m = m₁ + m₂, c = (m₁c₁ + m₂c₂)/m, 𝓘 = 𝓘₁ + 𝓘₂ + μ(|d|²1 − d dᵀ) with the reduced mass
    /// μ = m₁m₂/m and d = c₂ − c₁: the parallel-axis terms of both, about the common centre, summed.
    pub fn combine(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            // No mass, no centre: the inertias alone add.
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

/// |𝓘_ij − 𝓘_ji| against the largest entry.
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
