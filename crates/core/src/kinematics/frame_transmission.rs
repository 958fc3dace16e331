//! Transmissions between two frames: a wrench of one frame on another, and a slider with a crank.
//!
//! Lengths and rows ∂ℓ̇/∂v are those of MuJoCo **(`mj_transmission`)**.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{Pose, Quaternion, Transmission};

use crate::Model;
use crate::kinematics::body_placement::Placement;
use crate::model::WORLD;

/// A frame of a body, or of the world.
#[derive(Clone, Copy, Debug)]
struct BodyFrame {
    body: usize,
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
}

/// A transmission between two frames of a compiled robot.
#[derive(Clone, Debug)]
pub struct FrameTransmission {
    /// The frame that is driven, and the one relative to which it moves.
    frames: [BodyFrame; 2],
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The gear of the position, and that of the rotation vector.
    Relative { gear: [Vector3<f64>; 2] },
    /// The length of the rod, and the gear.
    SliderCrank { rod: f64, gear: f64 },
}

impl FrameTransmission {
    /// `None` for a transmission to something other than two frames, or if a frame is missing.
    pub fn new(model: &Model, transmission: &Transmission) -> Option<Self> {
        let (names, kind) = match transmission {
            Transmission::RelativeFrame { frame, reference, gear: [x, y, z, a, b, c] } => {
                let gear = [Vector3::new(*x, *y, *z), Vector3::new(*a, *b, *c)];
                ([frame, reference], Kind::Relative { gear })
            }
            Transmission::SliderCrank { crank, slider, rod_length, gear } => {
                ([crank, slider], Kind::SliderCrank { rod: *rod_length, gear: *gear })
            }
            _ => return None,
        };
        let [frame, reference] = names.map(|name| BodyFrame::new(model, name));
        Some(Self { frames: [frame?, reference?], kind })
    }

    /// The change of ℓ in a full turn about the gear, if ℓ is a component of the rotation vector.
    pub fn period(&self) -> Option<f64> {
        match self.kind {
            Kind::Relative { gear: [linear, angular] } if linear == Vector3::zeros() => {
                Some(core::f64::consts::TAU * angular.norm())
            }
            _ => None,
        }
    }

    /// ℓ at a placement, and ∂ℓ̇/∂v, nv entries.
    pub fn length_and_row(&self, model: &Model, placement: &Placement, row: &mut [f64]) -> f64 {
        row.fill(0.0);
        let [frame, reference] = self.frames;
        let [(axes, point), (to, origin)] = self.frames.map(|frame| frame.in_world(placement));
        let [a, b] = [frame.body, reference.body];
        let carrier = if a == WORLD || b == WORLD { WORLD } else { model.common_ancestor([a, b]) };
        // Adds uᵀv + wᵀω of a point of a body relative to the carrier.
        let mut add = |body: usize, point: Vector3<f64>, [u, w]: [Vector3<f64>; 2]| {
            if body != WORLD {
                placement.each_motion_on(model, [body, carrier], point, |dof, velocity, spin| {
                    row[dof.coordinate] += dof.ratio * (u.dot(&velocity) + w.dot(&spin));
                });
            }
        };
        match self.kind {
            Kind::Relative { gear: [linear, angular] } => {
                let wrench = [to * linear, to * angular];
                add(a, point, wrench);
                add(b, origin, wrench.map(|part| -part));
                let relative = to.tr_mul(&axes);
                let rotation = core::array::from_fn(|i| core::array::from_fn(|j| relative[(i, j)]));
                let turn = Vector3::from(Quaternion::from_rotation(&rotation).log());
                linear.dot(&to.tr_mul(&(point - origin))) + angular.dot(&turn)
            }
            Kind::SliderCrank { rod, gear } => {
                let axis: Vector3<f64> = to.column(2).into();
                let way = point - origin;
                let along = way.dot(&axis);
                let square = along * along + rod * rod - way.dot(&way);
                // The derivatives by the way and by the axis. A rod that is too short does not act.
                let (length, by_way, by_axis) = if square > 0.0 {
                    let root = square.sqrt();
                    let share = 1.0 - along / root;
                    (along - root, axis * share + way / root, way * share)
                } else {
                    (along, axis, way)
                };
                add(a, point, [by_way * gear, Vector3::zeros()]);
                // The axis turns with the slider: by_axis·(ω × axis).
                add(b, origin, [by_way * -gear, axis.cross(&by_axis) * gear]);
                gear * length
            }
        }
    }
}

impl BodyFrame {
    fn new(model: &Model, name: &str) -> Option<Self> {
        let frame = model.frames().iter().find(|frame| frame.name == name)?;
        let Pose { rotation, translation } = frame.body_from_frame;
        Some(Self {
            body: frame.body.unwrap_or(WORLD),
            rotation: Matrix3::from_fn(|i, j| rotation[i][j]),
            origin: translation.into(),
        })
    }

    /// Its axes and its origin.
    fn in_world(&self, placement: &Placement) -> (Matrix3<f64>, Vector3<f64>) {
        let (rotation, translation) = placement.body(self.body);
        (rotation * self.rotation, rotation * self.origin + translation)
    }
}
