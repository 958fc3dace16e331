//! Connections of points and welds of links.
//!
//! For frames with orientations q₀, q₁, the violation is the distance r of their origins along the world's
//! axes. A weld also has c e, with its torque scale c and the vector part of q₁⁻¹q₀ = (s, e). With
//! w = R₁ᵀ(ω₀ − ω₁), ė = ½(s w + w × e) and ṡ = −½ w·e. The second derivatives are
//! ẇ = R₁ᵀ(ω̇₀ − ω̇₁ − ω₁ × (ω₀ − ω₁)) and ë = ½(ṡ w + s ẇ + ẇ × e + w × ė). For these constraints alone,
//! MuJoCo includes the part that does not depend on v̇. **(MuJoCo's source, 4.0)**

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use robot_dynamics_core::{FrameId, ReferenceFrame, frame_bias_acceleration, frame_velocity};
use robot_dynamics_description::SolverImpedance;

use super::impedance::Response;
use super::point_rows::{Bodies, Side, push};
use super::reference::{RowOrigin, RowReference, StepState};
use crate::contact::ConeProblem;
use crate::contact::cone_problem::Set;
use crate::equality::site::{Site, SitePlace};

/// Two frames whose origins coincide, or that coincide.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    pub(super) frames: [FrameId; 2],
    /// c of a weld.
    pub(super) torque_scale: Option<f64>,
    pub(super) softness: SolverImpedance,
    /// The sum of both sides' weights, translation and rotation.
    pub(super) weights: [f64; 2],
}

impl Connection {
    pub(super) fn add(
        &self,
        bodies: &Bodies,
        state: &mut StepState<'_>,
        problem: &mut ConeProblem,
        asked: &mut Vec<RowReference>,
    ) {
        let StepState { model, workspace, q, v, h, .. } = state;
        let [SitePlace { axes: turn, origin: at }, SitePlace { axes: other_turn, origin: other_at }] =
            self.frames.map(|frame| Site::of_frame(model, frame).place(&bodies.placement));
        let drift = self.frames.map(|frame| {
            frame_bias_acceleration(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned)
        });
        let spin = self.frames.map(|frame| {
            frame_velocity(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned).angular
        });
        let apart = at - other_at;
        let turned = Rotation3::from_matrix_unchecked(other_turn.transpose() * turn);
        let between = UnitQuaternion::from_rotation_matrix(&turned);
        let (s, e) = (between.scalar(), between.vector().into_owned());
        let scale = self.torque_scale.unwrap_or(0.0);
        let size = apart.norm().hypot(scale * e.norm());
        let response = Response::new(&self.softness, *h, size);
        // K d per unit of violation.
        let stiffness = if size > 0.0 { response.spring / size } else { 0.0 };
        let moving = [0, 1].map(|side| Vector3::from(drift[side].linear));
        let spin = spin.map(Vector3::from);
        let apart_spin = spin[0] - spin[1];
        let w = other_turn.tr_mul(&apart_spin);
        let turning = Vector3::from(drift[0].angular) - Vector3::from(drift[1].angular);
        let w_rate = other_turn.tr_mul(&(turning - spin[1].cross(&apart_spin)));
        let e_rate = (w * s + w.cross(&e)) * 0.5;
        let e_bend = (w * (-0.5 * w.dot(&e)) + w_rate * s + w_rate.cross(&e) + w.cross(&e_rate)) * 0.5;
        let sides = [(0, 1.0, at), (1, -1.0, other_at)]
            .map(|(side, sign, at)| Some(Side::new(model, self.frames[side], sign, at)));
        let free = Set::Interval(f64::NEG_INFINITY, f64::INFINITY);
        let none = Vector3::zeros();
        for k in 0..if self.torque_scale.is_some() { 6 } else { 3 } {
            let axis = Vector3::ith(k % 3, 1.0);
            let (direction, violation, drift) = if k < 3 {
                ((axis, none), apart[k], moving[0][k] - moving[1][k])
            } else {
                let about = other_turn * (axis * s + e.cross(&axis)) * (0.5 * scale);
                ((none, about), scale * e[k - 3], scale * e_bend[k - 3])
            };
            let row = push(problem, model, bodies, free, sides, &[direction]);
            problem.soften(response.softness(self.weights[k / 3]));
            let drift = Some(drift);
            asked.push(RowReference {
                drift,
                ..RowReference::new(RowOrigin::Stop, row, response.damping, stiffness * violation)
            });
        }
    }
}
