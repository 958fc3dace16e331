//! A spline through configurations of robots with quaternions.

use nalgebra::Vector3;
use robot_dynamics_core::{Model, check_configuration, difference};
use robot_dynamics_description::Quaternion;
use robot_dynamics_number::InvalidInput;

use super::rotation_spline::RotationSpline;
use super::{CubicSpline, TreePath, TreePathPoint};

/// The twice continuously differentiable spline through configurations of a robot, which may have spherical
/// and floating joints.
///
/// Plain coordinates and positions follow the natural cubic spline of [`CubicSpline`]. Rotations follow a
/// spline on SO(3) with a continuous angular acceleration that is zero at both ends, by Kang and Park (1999).
/// q′ is the body velocity at ṡ = 1, as v is: for a floating joint Rᵀ p′ before ω, with the rate Rᵀ p″ − ω ×
/// Rᵀ p′.
///
/// Knots are centripetal as in [`CubicSpline`], with lengths of q₁ ⊖ q₀. Without quaternions both splines are
/// equal.
///
/// ```
/// use robot_dynamics::control::TreePath;
/// use robot_dynamics::control::time_parameterization::ConfigurationSpline;
/// use robot_dynamics::description::{Base, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.base = Base::Floating;
/// let model = Model::new(robot)?;
/// // A quarter turn about z while the base moves along x and the hinge opens.
/// let half = std::f64::consts::FRAC_1_SQRT_2;
/// let waypoints = [
///     vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
///     vec![1.0, 0.0, 0.0, 0.0, 0.0, half, half, 0.5],
/// ];
/// let path = ConfigurationSpline::through(&model, &waypoints)?;
/// let middle = path.at(0.5);
/// assert!((middle.q[0] - 0.5).abs() < 1e-12 && (middle.dq[5] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
/// # Ok::<(), robot_dynamics::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigurationSpline {
    nq: usize,
    nv: usize,
    /// Numbers of q that are plain, and where they are in q and in v.
    plain: CubicSpline,
    places: Vec<(usize, Option<usize>)>,
    rotations: Vec<Rotation>,
}

/// The rotation of one joint.
#[derive(Clone, Debug, PartialEq)]
struct Rotation {
    /// The index of the quaternion in q, and of ω in v.
    q: usize,
    v: usize,
    /// The index of the position among the plain numbers, and of its velocity in v.
    position: Option<(usize, usize)>,
    spline: RotationSpline,
}

impl ConfigurationSpline {
    /// Creates a spline through these configurations, in order.
    ///
    /// # Errors
    /// [`InvalidInput`] if there are fewer than two waypoints, one is not a configuration, two consecutive
    /// ones are equal, or rotations turn too far between waypoints for the iteration to converge.
    pub fn through(model: &Model, waypoints: &[Vec<f64>]) -> Result<Self, InvalidInput> {
        for (index, waypoint) in waypoints.iter().enumerate() {
            check_configuration(model, waypoint).map_err(|error| error.of(format!("waypoint {index}")))?;
        }
        let mut chords = Vec::new();
        let mut displacement = vec![0.0; model.nv()];
        for ends in waypoints.windows(2) {
            difference(model, &ends[0], &ends[1], &mut displacement);
            chords.push(displacement.iter().map(|x| x * x).sum::<f64>().sqrt());
        }
        let mut places = Vec::new();
        let mut turning = Vec::new();
        for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
            let quaternion = joint.nq > joint.nv;
            let plain = if quaternion { joint.nq - 4 } else { joint.nq };
            if quaternion {
                let position = (plain > 0).then_some((places.len(), joint.v_index));
                turning.push((joint.q_index + plain, joint.v_index + plain, position));
            }
            places
                .extend((0..plain).map(|k| (joint.q_index + k, (!quaternion).then_some(joint.v_index + k))));
        }
        let rows = waypoints.iter().map(|q| places.iter().map(|&(place, _)| q[place]).collect());
        let plain = CubicSpline::with_chords(rows.collect(), &chords)?;
        let mut rotations = Vec::new();
        for (q, v, position) in turning {
            let quaternion = |waypoint: &Vec<f64>| {
                Quaternion::from_xyzw([waypoint[q], waypoint[q + 1], waypoint[q + 2], waypoint[q + 3]])
                    .normalized()
            };
            let through = waypoints.iter().map(quaternion).collect();
            rotations.push(Rotation {
                q,
                v,
                position,
                spline: RotationSpline::through(plain.knots(), through)?,
            });
        }
        Ok(Self { nq: model.nq(), nv: model.nv(), plain, places, rotations })
    }

    /// s of each waypoint.
    pub fn knots(&self) -> &[f64] {
        self.plain.knots()
    }
}

impl TreePath for ConfigurationSpline {
    fn at(&self, s: f64) -> TreePathPoint {
        let mut point =
            TreePathPoint { q: vec![0.0; self.nq], dq: vec![0.0; self.nv], ddq: vec![0.0; self.nv] };
        let plain = self.plain.at(s);
        for (k, &(q, v)) in self.places.iter().enumerate() {
            point.q[q] = plain.q[k];
            if let Some(v) = v {
                (point.dq[v], point.ddq[v]) = (plain.dq[k], plain.ddq[k]);
            }
        }
        let (interval, fraction, length) = self.plain.interval(s);
        for Rotation { q, v, position, spline } in &self.rotations {
            let turned = spline.at(interval, fraction, length);
            point.q[*q..q + 4].copy_from_slice(&turned.rotation.to_xyzw());
            point.dq[*v..v + 3].copy_from_slice(turned.velocity.as_slice());
            point.ddq[*v..v + 3].copy_from_slice(turned.acceleration.as_slice());
            if let Some((k, v)) = *position {
                let in_body =
                    |x: &[f64]| Vector3::from(turned.rotation.rotate_back([x[k], x[k + 1], x[k + 2]]));
                let velocity = in_body(&plain.dq);
                let acceleration = in_body(&plain.ddq) - turned.velocity.cross(&velocity);
                point.dq[v..v + 3].copy_from_slice(velocity.as_slice());
                point.ddq[v..v + 3].copy_from_slice(acceleration.as_slice());
            }
        }
        point
    }

    fn start(&self) -> f64 {
        self.plain.start()
    }

    fn end(&self) -> f64 {
        self.plain.end()
    }

    fn corners(&self) -> &[f64] {
        self.plain.knots()
    }
}
