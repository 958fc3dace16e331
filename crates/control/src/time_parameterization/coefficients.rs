//! The dynamics of a tree along a path.

use robot_dynamics_core::{Model, Workspace, bias, inverse_dynamics};

use super::TreePathPoint;

/// a(s) s̈ + b(s) ṡ² + c(s) = τ at a point of a path. **(PRM ch. 11; MR §9.4)**
#[derive(Clone, Debug, PartialEq)]
pub struct PathCoefficients {
    /// a = M q′.
    pub a: Vec<f64>,
    /// b = M q″ + C(q,q′) q′.
    pub b: Vec<f64>,
    /// c = g(q), springs included.
    pub c: Vec<f64>,
}

impl PathCoefficients {
    /// τ = a s̈ + b ṡ² + c \[N·m or N\].
    pub fn torque(&self, speed: f64, acceleration: f64) -> Vec<f64> {
        let motion = self.motion_torque(speed, acceleration);
        motion.iter().zip(&self.c).map(|(motion, c)| motion + c).collect()
    }

    /// The motion part a s̈ + b ṡ²; k times faster (ṡ by k, s̈ by k²) it grows by k².
    pub fn motion_torque(&self, speed: f64, acceleration: f64) -> Vec<f64> {
        self.a.iter().zip(&self.b).map(|(a, b)| a * acceleration + b * (speed * speed)).collect()
    }
}

/// a, b and c of a robot at a point of a path, by three evaluations of inverse dynamics, without damping and
/// friction.
///
/// ```
/// use robot_dynamics::control::{TreePathPoint, path_coefficients};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // m l² q″ and m l² q′, and gravity.
/// let point = TreePathPoint { q: vec![0.3], dq: vec![2.0], ddq: vec![-1.0] };
/// let on_path = path_coefficients(&model, &mut Workspace::new(&model), &point);
/// assert!((on_path.a[0] - 0.5 * 2.0).abs() < 1e-14 && (on_path.b[0] + 0.5 * 1.0).abs() < 1e-14);
/// assert!((on_path.c[0] + 9.81 * 0.3_f64.cos()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if the point's vectors have the wrong length.
#[track_caller]
pub fn path_coefficients(
    model: &Model,
    workspace: &mut Workspace,
    point: &TreePathPoint,
) -> PathCoefficients {
    let nv = model.nv();
    let TreePathPoint { q, dq, ddq } = point;
    let rest = vec![0.0; nv];
    let [mut a, mut b, mut c] = [(); 3].map(|()| vec![0.0; nv]);
    bias(model, workspace, q, &rest, &mut c);
    inverse_dynamics(model, workspace, q, &rest, dq, &mut a);
    inverse_dynamics(model, workspace, q, dq, ddq, &mut b);
    for k in 0..nv {
        a[k] -= c[k];
        b[k] -= c[k];
    }
    PathCoefficients { a, b, c }
}
