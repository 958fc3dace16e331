//! A free rigid body in the plane.

use nalgebra::{SMatrix, SVector, matrix, vector};
use robot_dynamics_number::Scalar;

use crate::{Dynamics, Lagrangian, PlanarKinematics};

/// A free rigid body in a vertical plane.
///
/// q = (x, y \[m\], θ \[rad\]): position of the centre of mass, y up, and heading from the x axis,
/// counter-clockwise. M = diag(m, m, I_zz) is constant, so C q̇ = 0; V = m a_g y.
///
/// Forces act through [`force_map`](PlanarKinematics::force_map): a force off the centre of mass also turns
/// the body.
///
/// ```
/// use dynamics::{Dynamics, PlanarBody, PlanarKinematics, generalized_force};
/// use nalgebra::vector;
/// let body = PlanarBody { m: 2.0, i_zz: 0.5, a_g: 0.0 };
/// // 1 N upwards, 0.3 m in front of the centre of mass of a body that heads along x.
/// let q = vector![1.0, 2.0, 0.0];
/// let u = generalized_force(&body.force_map(&q, 0, [0.3, 0.0]), &vector![0.0, 1.0]);
/// assert!((body.forward(&q, &vector![0.0, 0.0, 4.0], &u) - vector![0.0, 0.5, 0.6]).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarBody {
    /// Mass \[kg\].
    pub m: f64,
    /// Moment of inertia about the centre of mass \[kg·m²\].
    pub i_zz: f64,
    /// Gravitational acceleration along −y \[m/s²\]; 0 for a body on a table.
    pub a_g: f64,
}

impl Dynamics<3> for PlanarBody {
    fn mass(&self, _: &SVector<f64, 3>) -> SMatrix<f64, 3, 3> {
        matrix![self.m, 0.0, 0.0; 0.0, self.m, 0.0; 0.0, 0.0, self.i_zz]
    }

    fn velocity_product(&self, _: &SVector<f64, 3>, _: &SVector<f64, 3>) -> SVector<f64, 3> {
        SVector::zeros()
    }

    fn gravity(&self, _: &SVector<f64, 3>) -> SVector<f64, 3> {
        vector![0.0, self.m * self.a_g, 0.0]
    }

    fn potential_energy(&self, q: &SVector<f64, 3>) -> f64 {
        self.m * self.a_g * q[1]
    }
}

impl Lagrangian<3> for PlanarBody {
    fn mass_over<S: Scalar>(&self, _: &[S; 3]) -> [[S; 3]; 3] {
        let (m, i_zz, o) = (S::from_f64(self.m), S::from_f64(self.i_zz), S::zero());
        [[m, o, o], [o, m, o], [o, o, i_zz]]
    }

    fn potential_over<S: Scalar>(&self, q: &[S; 3]) -> S {
        q[1].scale(self.m * self.a_g)
    }
}

impl PlanarKinematics<3> for PlanarBody {
    /// Body 0 is the only one; its frame is at its centre of mass, x along the heading.
    ///
    /// # Panics
    /// If `body` is not 0.
    fn point_over<S: Scalar>(&self, q: &[S; 3], body: usize, point: [f64; 2]) -> [S; 2] {
        assert!(body == 0, "this is a single body, number 0; there is no body {body}");
        let (sine, cosine) = q[2].sin_cos();
        let [along, across] = point;
        [q[0] + cosine.scale(along) - sine.scale(across), q[1] + sine.scale(along) + cosine.scale(across)]
    }
}
