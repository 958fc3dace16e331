//! From velocities v to the rate of the configuration, q̇ = N(q) v. Cost: O(n).
//!
//! N is 1 for plain coordinates. A floating joint's position has ṗ = R u, a quaternion q̇ = ½ q ⊗ (ω, 0).

use robot_dynamics_description::{check_length, rotation_of};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::joint::Chart;

/// q̇ = N(q) v. q̇ = v for joints without a quaternion. For a quaternion q̇ = ½ q ⊗ (ω, 0),
/// and for the position of a floating joint ẋ = R u.
///
/// q and the rate have `nq` entries, v has `nv`. The rate preserves the quaternion's length.
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
pub fn configuration_rate<S: Scalar>(model: &Model, q: &[S], v: &[S], rate: &mut [S]) {
    check_length("q", q.len(), model.nq);
    check_length("v", v.len(), model.nv);
    check_length("the rate of q", rate.len(), model.nq);
    for body in &model.bodies {
        // A mimic joint writes its leader's rate again, with the same value.
        let (i, k) = (body.q_index, model.dofs[body.dof].coordinate);
        match body.motion.chart() {
            Chart::Line => rate[i] = v[k],
            Chart::Rotation => turn(&q[i..i + 4], &v[k..k + 3], &mut rate[i..i + 4]),
            Chart::Placement => {
                let linear = rotation_of(&[q[i + 3], q[i + 4], q[i + 5], q[i + 6]])
                    * V3::new([v[k], v[k + 1], v[k + 2]]);
                rate[i..i + 3].copy_from_slice(&linear.array());
                turn(&q[i + 3..i + 7], &v[k + 3..k + 6], &mut rate[i + 3..i + 7]);
            }
        }
    }
}

/// ½ q ⊗ (ω, 0), with ω in the rotated frame and q = (x y z w).
#[inline(always)]
fn turn<S: Scalar>(xyzw: &[S], angular: &[S], rate: &mut [S]) {
    let vector = V3::new([xyzw[0], xyzw[1], xyzw[2]]);
    let w = V3::new([angular[0], angular[1], angular[2]]);
    let half = S::from_f64(0.5);
    rate[..3].copy_from_slice(&(vector.cross(w).add_scaled(xyzw[3], w) * half).array());
    rate[3] = -(vector.dot(w) * half);
}
