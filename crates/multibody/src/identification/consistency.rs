//! Whether inertial parameters are those of a body that can exist.

use nalgebra::{Matrix3, Matrix4, Vector3};

use super::IdentificationError;
use super::error::{check_entries, check_results};
use crate::{Model, PARAMETERS_PER_LINK};

/// J = \[Σ h; hᵀ m\] with Σ = ½ tr(I) 1 − I: the pseudo-inertia of a link's ten parameters.
///
/// J = ∫ (r, 1)(r, 1)ᵀ dm is positive semidefinite for every distribution of mass, and every such J is that of
/// one: it contains the positive mass and the triangle inequalities of the moments. **(Wensing, Kim, Slotine 2018)**
///
/// ```
/// use multibody::pseudo_inertia;
/// use nalgebra::Vector4;
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

/// The verdict on one link.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LinkConsistency {
    /// The link.
    pub link: String,
    /// Its mass \[kg\].
    pub mass: f64,
    /// The smallest eigenvalue of its pseudo-inertia.
    pub smallest: f64,
    /// The largest.
    pub largest: f64,
}

impl LinkConsistency {
    /// Whether a body with these parameters can exist, up to rounding: the smallest eigenvalue is not below
    /// −1e-12 of the largest. A thin rod has one of zero.
    pub fn is_consistent(&self) -> bool {
        self.smallest >= -1e-12 * self.largest.abs() && self.largest >= 0.0
    }
}

/// The pseudo-inertia's extreme eigenvalues of every moving link.
///
/// ```
/// use multibody::{Model, inertial_parameters, pendulum, physical_consistency};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut parameters = inertial_parameters(&model);
/// assert!(physical_consistency(&model, &parameters)?[0].is_consistent());
/// parameters[6] = 0.4; // no 2 kg with this first moment have so small a moment about y
/// let verdict = &physical_consistency(&model, &parameters)?[0];
/// assert!(!verdict.is_consistent() && verdict.smallest < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentificationError`]: a list of the wrong length, or with a number that is not finite.
pub fn physical_consistency(
    model: &Model,
    parameters: &[f64],
) -> Result<Vec<LinkConsistency>, IdentificationError> {
    let expected = PARAMETERS_PER_LINK * model.moving_links().count();
    if parameters.len() != expected {
        return Err(IdentificationError::WrongLength { found: parameters.len(), expected });
    }
    check_entries("the inertial parameters", parameters)?;
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
    check_results("a pseudo-inertia", verdicts.iter().flat_map(|link| [&link.smallest, &link.largest]))?;
    Ok(verdicts)
}
