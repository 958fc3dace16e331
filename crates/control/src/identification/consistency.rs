//! Physical consistency of inertial parameters.

use nalgebra::{Matrix3, Matrix4, Vector3};
use robot_dynamics_core::{Model, PARAMETERS_PER_LINK};
use robot_dynamics_number::check_result;

use super::IdentificationError;
use super::error::check_inertial_parameters;

/// J = \[Σ h; hᵀ m\] with Σ = ½ tr(I) 1 − I: the pseudo-inertia of a link's ten parameters.
///
/// J = ∫ (r, 1)(r, 1)ᵀ dm is positive semidefinite for every distribution of mass, and every such J belongs
/// to one. This condition includes the positive mass and the triangle inequalities of the moments of inertia.
/// **(Wensing, Kim, Slotine 2018)**
///
/// ```
/// use nalgebra::Vector4;
/// use robot_dynamics::control::pseudo_inertia;
/// // A point of 2 kg at r = (0.5, 0, 0): J = m (r, 1)(r, 1)ᵀ.
/// let at = Vector4::new(0.5, 0.0, 0.0, 1.0);
/// let point = pseudo_inertia(&[2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5]);
/// assert!((point - at * at.transpose() * 2.0).norm() < 1e-15);
/// ```
pub fn pseudo_inertia(parameters: &[f64; PARAMETERS_PER_LINK]) -> Matrix4<f64> {
    let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = *parameters;
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let second = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
    let first = Vector3::new(hx, hy, hz);
    let mut pseudo = Matrix4::zeros();
    pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&second);
    pseudo.fixed_view_mut::<3, 1>(0, 3).copy_from(&first);
    pseudo.fixed_view_mut::<1, 3>(3, 0).copy_from(&first.transpose());
    pseudo[(3, 3)] = m;
    pseudo
}

/// The physical consistency of one link.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LinkConsistency {
    /// The name of the link.
    pub link: String,
    /// Its mass \[kg\].
    pub mass: f64,
    /// The smallest eigenvalue of its pseudo-inertia.
    pub smallest: f64,
    /// The largest eigenvalue of its pseudo-inertia.
    pub largest: f64,
}

impl LinkConsistency {
    /// Whether a body with these parameters exists, up to rounding: the smallest eigenvalue is at least
    /// −1e-12 of the largest. That of a thin rod is zero.
    pub fn is_consistent(&self) -> bool {
        self.smallest >= -1e-12 * self.largest.abs() && self.largest >= 0.0
    }
}

/// The extreme eigenvalues of the pseudo-inertia of every moving link.
///
/// ```
/// use robot_dynamics::algorithms::inertial_parameters;
/// use robot_dynamics::control::physical_consistency;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut parameters = inertial_parameters(&model);
/// assert!(physical_consistency(&model, &parameters)?[0].is_consistent());
/// parameters[6] = 0.4; // too small a moment about y for 2 kg with this first moment
/// let verdict = &physical_consistency(&model, &parameters)?[0];
/// assert!(!verdict.is_consistent() && verdict.smallest < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentificationError`] if the list has the wrong length or an entry that is not finite.
pub fn physical_consistency(
    model: &Model,
    parameters: &[f64],
) -> Result<Vec<LinkConsistency>, IdentificationError> {
    let expected = PARAMETERS_PER_LINK * model.moving_links().count();
    check_inertial_parameters(parameters, expected)?;
    let (links, _) = parameters.as_chunks::<PARAMETERS_PER_LINK>();
    let verdict = |(link, parameters): (&str, &[f64; PARAMETERS_PER_LINK])| {
        let eigenvalues = pseudo_inertia(parameters).symmetric_eigenvalues();
        LinkConsistency {
            link: link.to_owned(),
            mass: parameters[0],
            smallest: eigenvalues.min(),
            largest: eigenvalues.max(),
        }
    };
    let verdicts: Vec<LinkConsistency> = model.moving_links().zip(links).map(verdict).collect();
    check_result("a pseudo-inertia", verdicts.iter().flat_map(|link| [&link.smallest, &link.largest]))?;
    Ok(verdicts)
}
