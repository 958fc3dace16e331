//! The robot's coordinates.

use robot_dynamics::description::{CoordinateKind, JointKind};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;
use super::text::shown;

/// One entry of v, with its limits.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct RobotCoordinate {
    /// Its name.
    #[wasm_bindgen(readonly)]
    pub name: String,
    /// Its index in q; `undefined` if q has no single number for it (quaternions).
    #[wasm_bindgen(readonly)]
    pub place: Option<u32>,
    /// Whether it is a length \[m\] rather than an angle \[rad\].
    #[wasm_bindgen(readonly)]
    pub slides: bool,
    /// Lower limit.
    #[wasm_bindgen(readonly)]
    pub lower: f64,
    /// Upper limit.
    #[wasm_bindgen(readonly)]
    pub upper: f64,
    /// The largest torque or force \[N·m or N\].
    #[wasm_bindgen(readonly)]
    pub effort: f64,
    /// Whether it belongs to a floating joint, which has no motor.
    #[wasm_bindgen(readonly)]
    pub floats: bool,
}

#[wasm_bindgen]
impl Robot {
    /// Every coordinate, in the order of v.
    pub fn coordinates(&self) -> Vec<RobotCoordinate> {
        let (names, limits) = (self.model.coordinate_names(), self.model.coordinate_limits());
        let mut list = Vec::new();
        for joint in self.model.joints().iter().filter(|joint| joint.nv > 0) {
            for k in 0..joint.nv {
                let (v, own) = (joint.v_index + k, joint.nq == joint.nv);
                list.push(RobotCoordinate {
                    name: shown(&names[v]),
                    place: own.then(|| u32::try_from(joint.q_index + k).ok()).flatten(),
                    slides: joint.kind.velocities()[k].kind == CoordinateKind::Length,
                    lower: limits[v].lower,
                    upper: limits[v].upper,
                    effort: limits[v].effort,
                    floats: joint.kind == JointKind::Floating,
                });
            }
        }
        list
    }
}
