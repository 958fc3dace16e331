//! The derivatives of the motion of a point of a body by the coordinates, and of the generalized forces of a
//! wrench there.
//!
//! Let a degree of freedom j move the body B, with the parent P. A point with velocity ṗ and acceleration p̈
//! moves by s_j, and turns by w_j. Everything beyond the joint moves relative to P as before, in axes that
//! turn with w_j. With the velocity V_P and the acceleration A_P of P's point there, and with the relative
//! motion r = ṗ − V_P and r′ = p̈ − A_P − 2 ω_P × r,
//!
//! ∂ṗ/∂q_j = ω_P × s_j + w_j × r,
//! ∂p̈/∂q_j = ω̇_P × s_j + ω_P × (ω_P × s_j) + 2 ω_P × (w_j × r) + w_j × r′,
//! ∂p̈/∂v_j = ∂ṗ/∂q_j + ω_B × s_j + w_j × (ṗ − V_B).
//!
//! The angular parts follow in the same way. They agree with the derivatives of frames in
//! [`derivatives`](crate::derivatives), but serve any point at a cost of O(depth).

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_number::Dual;

use super::body_placement::{BodyMotion, Placement};
use crate::Model;
use crate::model::WORLD;

/// A linear part, then an angular part, along the world's axes.
pub type Six = [f64; 6];

/// The derivatives of a point's motion by one degree of freedom.
#[derive(Clone, Copy, Debug)]
pub struct MotionColumn {
    /// The coordinate in v.
    pub coordinate: usize,
    /// The body that the degree of freedom moves.
    body: usize,
    /// The displacement and rotation; also ∂(ṗ, ω)/∂v and ∂(p̈, ω̇)/∂a.
    pub motion: Six,
    /// ∂(ṗ, ω)/∂q.
    pub velocity_by_position: Six,
    /// ∂(p̈, ω̇)/∂q.
    pub acceleration_by_position: Six,
    /// ∂(p̈, ω̇)/∂v.
    pub acceleration_by_velocity: Six,
}

/// The derivatives of the motion of a point of a body, for the degrees of freedom between the body and one
/// that carries it, from the body on. `motions` are those of all bodies.
pub fn motion_columns(
    model: &Model,
    (placement, motions): (&Placement, &[BodyMotion]),
    [body, carrier]: [usize; 2],
    point: Vector3<f64>,
) -> Vec<MotionColumn> {
    let mut columns = Vec::new();
    if body == WORLD {
        return columns;
    }
    let at_point = |body: usize| {
        if body == WORLD {
            return BodyMotion::default();
        }
        motions[body].at(&(point - placement.origin(body)))
    };
    let moving = at_point(body);
    let mut own = (WORLD, BodyMotion::default(), BodyMotion::default());
    placement.each_motion_on(model, [body, carrier], point, |dof, shift, turn| {
        if own.0 != dof.body {
            own = (dof.body, at_point(dof.body), at_point(model.bodies[dof.body].parent));
        }
        let (_, mover, parent) = &own;
        let (shift, turn) = (shift * dof.ratio, turn * dof.ratio);
        let relative = moving.velocity - parent.velocity;
        let relative_spin = moving.spin - parent.spin;
        let relative_rate = moving.acceleration - parent.acceleration - parent.spin.cross(&relative) * 2.0;
        let relative_spin_rate = moving.spin_rate - parent.spin_rate - parent.spin.cross(&relative_spin);
        let (turned, turned_spin) = (turn.cross(&relative), turn.cross(&relative_spin));
        let carried = parent.spin.cross(&shift);
        let velocity = carried + turned;
        columns.push(MotionColumn {
            coordinate: dof.coordinate,
            body: dof.body,
            motion: six(shift, turn),
            velocity_by_position: six(velocity, turned_spin),
            acceleration_by_position: six(
                parent.spin_rate.cross(&shift)
                    + parent.spin.cross(&(carried + turned * 2.0))
                    + turn.cross(&relative_rate),
                parent.spin.cross(&turned_spin) + turn.cross(&relative_spin_rate),
            ),
            acceleration_by_velocity: six(
                velocity + mover.spin.cross(&shift) + turn.cross(&(moving.velocity - mover.velocity)),
                turned_spin + mover.spin.cross(&turn),
            ),
        });
    });
    columns
}

/// Calls `add` with the entries (i, j) of ∂(Jᵀw)/∂q for a wrench w at the point, with constant components
/// along the world's axes. `columns` are those of the point.
///
/// The motions of i turn with j if j carries the joint of i. If j is beyond it, the point moves.
pub fn wrench_derivative(columns: &[MotionColumn], wrench: &Six, mut add: impl FnMut(usize, usize, f64)) {
    let [force, moment] = parts(wrench);
    let mut first = 0;
    for (at, one) in columns.iter().enumerate() {
        if columns[first].body != one.body {
            first = at;
        }
        let [shift, turn] = parts(&one.motion);
        for (k, other) in columns.iter().enumerate() {
            let [other_shift, other_turn] = parts(&other.motion);
            // Columns before `first` belong to bodies beyond the joint.
            let entry = if k < first {
                turn.cross(&other_shift).dot(&force)
            } else {
                other_turn.cross(&shift).dot(&force) + other_turn.cross(&turn).dot(&moment)
            };
            add(one.coordinate, other.coordinate, entry);
        }
    }
}

/// Six numbers of two vectors.
pub fn six(linear: Vector3<f64>, angular: Vector3<f64>) -> Six {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// The two vectors of six numbers.
pub fn parts([a, b, c, d, e, f]: &Six) -> [Vector3<f64>; 2] {
    [Vector3::new(*a, *b, *c), Vector3::new(*d, *e, *f)]
}

/// x·y.
pub fn dot_six(x: &Six, y: &Six) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// A number with its derivatives by six numbers.
pub type Seeded = Dual<f64, 6>;

/// The gradient of a number by the motion of a point with axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionGradient {
    /// By the displacement and the rotation.
    pub pose: Six,
    /// By ṗ and ω.
    pub velocity: Six,
    /// By p̈ and ω̇.
    pub acceleration: Six,
}

impl MotionGradient {
    /// The derivatives by a coordinate's position and velocity.
    pub fn by_state(&self, column: &MotionColumn) -> [f64; 2] {
        let by_position = dot_six(&self.pose, &column.motion)
            + dot_six(&self.velocity, &column.velocity_by_position)
            + dot_six(&self.acceleration, &column.acceleration_by_position);
        let by_velocity = dot_six(&self.velocity, &column.motion)
            + dot_six(&self.acceleration, &column.acceleration_by_velocity);
        [by_position, by_velocity]
    }
}

/// The axes and the origin of a frame as constants, or with their derivatives by a displacement and a
/// rotation along the world's axes.
pub fn seeded_place(
    axes: &Matrix3<f64>,
    origin: &Vector3<f64>,
    is_variable: bool,
) -> (Matrix3<Seeded>, Vector3<Seeded>) {
    let (mut place, mut moved) = (axes.map(Seeded::constant), origin.map(Seeded::constant));
    if is_variable {
        for k in 0..3 {
            moved[k].gradient[k] = 1.0;
            let turned = Matrix3::from_columns(
                &axes.column_iter().map(|axis| unit(k).cross(&axis)).collect::<Vec<_>>(),
            );
            place.iter_mut().zip(&turned).for_each(|(entry, rate)| entry.gradient[3 + k] = *rate);
        }
    }
    (place, moved)
}

/// A motion as constants, or with its derivatives by ṗ and ω.
pub fn seeded_motion(motion: &BodyMotion, is_variable: bool) -> BodyMotion<Seeded> {
    let constant = |x: &Vector3<f64>| x.map(Seeded::constant);
    let mut seeded = BodyMotion {
        velocity: constant(&motion.velocity),
        spin: constant(&motion.spin),
        acceleration: constant(&motion.acceleration),
        spin_rate: constant(&motion.spin_rate),
    };
    if is_variable {
        for k in 0..3 {
            seeded.velocity[k].gradient[k] = 1.0;
            seeded.spin[k].gradient[3 + k] = 1.0;
        }
    }
    seeded
}

fn unit(k: usize) -> Vector3<f64> {
    let mut unit = Vector3::zeros();
    unit[k] = 1.0;
    unit
}

/// Calls `add` with the entries (i, j) of ∂f/∂q of the generalized forces f = Σ Jᵀw of wrenches at several
/// points. `columns` has those of each point. `wrenches(k)` gives the wrenches at all points, with their
/// derivatives by the pose of point k.
pub fn force_derivative(
    columns: &[Vec<MotionColumn>],
    wrenches: impl Fn(usize) -> Vec<[Seeded; 6]>,
    mut add: impl FnMut(usize, usize, f64),
) {
    for (k, moved) in columns.iter().enumerate().filter(|(_, columns)| !columns.is_empty()) {
        let seeded = wrenches(k);
        wrench_derivative(moved, &seeded[k].map(|x| x.value), &mut add);
        for other in moved {
            for (wrench, own) in seeded.iter().zip(columns) {
                let change = wrench.map(|x| dot_six(&x.gradient, &other.motion));
                for one in own {
                    add(one.coordinate, other.coordinate, dot_six(&one.motion, &change));
                }
            }
        }
    }
}
