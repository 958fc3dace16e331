//! Principal axes and moments of an inertia.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// The frame in which an inertia is diagonal: 𝓘 = R diag(moments) Rᵀ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalInertia {
    /// The principal moments, ascending \[kg·m²\].
    pub moments: Vector3<f64>,
    /// R: its columns are the principal axes in the body frame, right-handed.
    pub body_from_principal: Rotation3<f64>,
}

impl PrincipalInertia {
    /// Eigenvalues and eigenvectors of a finite symmetric matrix, sorted and made right-handed.
    pub(super) fn of(inertia: &Matrix3<f64>) -> Self {
        let eigen = inertia.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [a, b, c] = order.map(|k| eigen.eigenvectors.column(k).into_owned());
        // ±axis is the same axis: the sign of the third one makes the frame right-handed.
        let c = if a.cross(&b).dot(&c) < 0.0 { -c } else { c };
        Self {
            moments: Vector3::from(order.map(|k| eigen.eigenvalues[k])),
            body_from_principal: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[a, b, c])),
        }
    }
}
