//! Admittance: the motion of a mass, a damper and a spring under a measured wrench.

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_core::{SpatialAcceleration, Twist};
use robot_dynamics_description::Pose;
use robot_dynamics_number::{InvalidInput, check_finite, check_positive};

use crate::PoseReference;
use crate::rotation_vector::{jacobian, quadratic};

/// The number of directions of a frame.
const DIRECTIONS: usize = 6;

/// Admittance control: a measured wrench moves the reference of a frame, which a position controller follows.
///
/// The displacement x = (d, φ) of the commanded pose from the reference, along the world's axes, obeys
///
/// > M ẍ + D ẋ + K x = f,
///
/// with a diagonal M, D and K. The commanded position is p\* + d, the commanded rotation is exp(φ) R\*. f is
/// held from one step to the next; the steps are exact for it, stable for any step length. With K = 0 the
/// frame can be led by hand. Source: Hogan (1985), as for
/// [`ImpedanceControl`](crate::ImpedanceControl), with cause and effect exchanged.
///
/// ```
/// use robot_dynamics::control::{Admittance, PoseReference};
/// use robot_dynamics::description::Pose;
/// let mut lead = Admittance::new([2.0; 6], [40.0; 6], [0.0; 6])?;
/// let reference = PoseReference::at_rest(Pose::IDENTITY);
/// let mut command = reference;
/// for _ in 0..2000 {
///     command = lead.step(&reference, &[8.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1e-3)?;
/// }
/// // 8 N against 40 N s/m, reached with the time constant 2/40 s
/// assert!((command.velocity.linear[0] - 0.2).abs() < 1e-12);
/// assert!((command.pose.translation[0] - 0.2 * (2.0 - 0.05)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Admittance {
    inertia: [f64; DIRECTIONS],
    damping: [f64; DIRECTIONS],
    stiffness: [f64; DIRECTIONS],
    displacement: [f64; DIRECTIONS],
    rate: [f64; DIRECTIONS],
}

impl Admittance {
    /// M \[kg, kg·m²\], D \[N·s/m, N·m·s/rad\] and K \[N/m, N·m/rad\] along the world's axes x, y, z, rx, ry,
    /// rz; at the reference and at rest.
    ///
    /// # Errors
    /// [`InvalidInput`] if an entry of M is not positive, or one of D or K is negative or not finite.
    pub fn new(
        inertia: [f64; DIRECTIONS],
        damping: [f64; DIRECTIONS],
        stiffness: [f64; DIRECTIONS],
    ) -> Result<Self, InvalidInput> {
        for entry in inertia {
            check_positive("the inertia", entry, "")?;
        }
        for (name, entries) in [("the damping", &damping), ("the stiffness", &stiffness)] {
            check_finite(name, entries)?;
            if let Some(bad) = entries.iter().find(|entry| **entry < 0.0) {
                return Err(InvalidInput::out_of_range(name, *bad, "", "zero or positive"));
            }
        }
        let [displacement, rate] = [[0.0; DIRECTIONS]; 2];
        Ok(Self { inertia, damping, stiffness, displacement, rate })
    }

    /// Advances the displacement by h \[s\] under a wrench: force, then moment about the frame's origin,
    /// along the world's axes \[N, N·m\]. Returns the commanded pose, velocity and acceleration at the end.
    /// It does not allocate.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number is not finite, or h is not positive. The displacement is then unchanged.
    pub fn step(
        &mut self,
        reference: &PoseReference,
        wrench: &[f64; DIRECTIONS],
        h: f64,
    ) -> Result<PoseReference, InvalidInput> {
        check_positive("the step", h, "s")?;
        check_finite("the wrench", wrench)?;
        let mut acceleration = [0.0; DIRECTIONS];
        for k in 0..DIRECTIONS {
            let [m, d, s] = [self.inertia[k], self.damping[k], self.stiffness[k]];
            // d/dt (x, ẋ, 1) = A (x, ẋ, 1)
            let flow = Matrix3::new(0.0, h, 0.0, -s / m * h, -d / m * h, wrench[k] / m * h, 0.0, 0.0, 0.0);
            let end = flow.exp() * Vector3::new(self.displacement[k], self.rate[k], 1.0);
            (self.displacement[k], self.rate[k]) = (end[0], end[1]);
            acceleration[k] = (wrench[k] - d * end[1] - s * end[0]) / m;
        }
        Ok(self.command(reference, &acceleration))
    }

    /// The displacement d \[m\] and φ \[rad\].
    pub fn displacement(&self) -> [f64; DIRECTIONS] {
        self.displacement
    }

    /// Returns to the reference, at rest.
    pub fn reset(&mut self) {
        self.displacement = [0.0; DIRECTIONS];
        self.rate = [0.0; DIRECTIONS];
    }

    /// The commanded motion: d and exp(φ) applied to the reference.
    fn command(&self, reference: &PoseReference, acceleration: &[f64; DIRECTIONS]) -> PoseReference {
        let parts = |all: &[f64; DIRECTIONS]| {
            [Vector3::new(all[0], all[1], all[2]), Vector3::new(all[3], all[4], all[5])]
        };
        let [d, phi] = parts(&self.displacement);
        let [d_rate, phi_rate] = parts(&self.rate);
        let [d_second, phi_second] = parts(acceleration);
        let turn = Rotation3::new(phi);
        let PoseReference { pose, velocity, acceleration } = reference;
        let [omega, omega_rate] = [velocity.angular, acceleration.angular].map(|x| turn * Vector3::from(x));
        // ω = J(−φ) φ̇ + exp(φ) ω*, and exp(φ) turns with J(−φ) φ̇.
        let jacobian = jacobian(&-phi);
        let own = jacobian * phi_rate;
        let angular = own + omega;
        let own_rate = jacobian * phi_second - quadratic(&-phi, &-phi_rate);
        let alpha = own_rate + omega_rate + own.cross(&omega);
        let shifted = |x: [f64; 3], by: Vector3<f64>| (Vector3::from(x) + by).into();
        let rotation = turn.matrix() * Matrix3::from_fn(|i, j| pose.rotation[i][j]);
        PoseReference {
            pose: Pose {
                rotation: core::array::from_fn(|i| core::array::from_fn(|j| rotation[(i, j)])),
                translation: shifted(pose.translation, d),
            },
            velocity: Twist { linear: shifted(velocity.linear, d_rate), angular: angular.into() },
            acceleration: SpatialAcceleration {
                linear: shifted(acceleration.linear, d_second),
                angular: alpha.into(),
            },
        }
    }
}
