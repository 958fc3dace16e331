//! A hand that grips a point of the robot. It pulls a moving robot, and guides a robot at rest.
//!
//! In motion, a spring and a damper f = k(p\* − p) − dṗ between the point p and the hand p\* act on the link.
//! At rest, inverse kinematics moves p to p\*, as close as the joints' limits allow.

use nalgebra::{DMatrix, Matrix3, Matrix3xX};
use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian, frame_pose, inverse_mass_matrix};
use robot_dynamics::description::{FrameDescription, Pose};
use robot_dynamics::model::{FrameId, Model, Workspace};
use robot_dynamics::simulation::AppliedWrench;

use crate::LabError;

/// Natural frequency \[rad/s\] and damping ratio of the spring with the effective mass at the point.
const FREQUENCY: f64 = 15.0;
const DAMPING_RATIO: f64 = 1.0;

/// Largest force, as a multiple of the robot's weight.
const MOST: f64 = 4.0;

/// The name of the frame at the held point.
const POINT: &str = "the hand on the page";

/// J M⁻¹ Jᵀ of the point's velocity \[1/kg\].
pub(super) fn mobility(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    jacobian: &[f64],
) -> Matrix3<f64> {
    let nv = model.nv();
    let mut inverse = vec![0.0; nv * nv];
    inverse_mass_matrix(model, workspace, q, &mut inverse);
    let inverse = DMatrix::from_row_slice(nv, nv, &inverse);
    let rows = Matrix3xX::from_row_slice(&jacobian[..3 * nv]);
    &rows * inverse * rows.transpose()
}

/// A held point of the robot.
#[derive(Debug)]
pub(crate) struct Hand {
    /// Its link, in the robot without the frame at the point.
    pub(super) link: FrameId,
    /// The robot with a frame at the point.
    pub(super) model: Model,
    pub(super) workspace: Workspace,
    pub(super) point: FrameId,
    pub(super) target: [f64; 3],
    stiffness: f64,
    damping: f64,
    most: f64,
    pub(super) jacobian: Vec<f64>,
}

impl Hand {
    /// Grips a link at a point given in the world.
    pub(super) fn new(model: &Model, q: &[f64], link: usize, place: [f64; 3]) -> Result<Self, LabError> {
        let mut description = model.description().clone();
        let link = description.links.get(link).ok_or_else(|| LabError::new(format!("no link {link}")))?;
        let link = link.name.clone();
        let carrier = model.frame_named(&link)?;
        let world_from_link = frame_pose(model, &mut Workspace::new(model), q, carrier);
        let point = world_from_link.inverse().apply(place);
        let mut name = POINT.to_owned();
        while model.frame(&name).is_some() {
            name.push('\'');
        }
        description.frames.push(FrameDescription::new(&name, link, Pose::from_translation(point)));
        let model = Model::new(description)?;
        let (mut workspace, nv) = (Workspace::new(&model), model.nv());
        let (point, mut jacobian) = (model.frame_named(&name)?, vec![0.0; 6 * nv]);
        frame_jacobian(&model, &mut workspace, q, point, ReferenceFrame::LocalWorldAligned, &mut jacobian);
        // The effective mass 3/tr(J M⁻¹ Jᵀ). It averages over all directions, and the lightest is at most
        // three times lighter.
        let mobility = mobility(&model, &mut workspace, q, &jacobian).trace();
        let felt = if mobility > 0.0 { (3.0 / mobility).min(model.mass()) } else { 0.0 };
        let g = model.gravity().iter().map(|g| g * g).sum::<f64>().sqrt().max(1.0);
        Ok(Self {
            link: carrier,
            target: place,
            stiffness: FREQUENCY * FREQUENCY * felt,
            damping: 2.0 * DAMPING_RATIO * FREQUENCY * felt,
            most: MOST * model.mass() * g,
            model,
            workspace,
            point,
            jacobian,
        })
    }

    /// The force on the point, as a wrench on its link about the world's origin. Writes its generalised
    /// forces Jᵀf into `tau`.
    pub(crate) fn pull(&mut self, q: &[f64], v: &[f64], tau: &mut [f64]) -> AppliedWrench {
        let Self { model, workspace, point, target, stiffness, damping, most, jacobian, .. } = self;
        let nv = v.len();
        let at = frame_pose(model, workspace, q, *point).translation;
        frame_jacobian(model, workspace, q, *point, ReferenceFrame::LocalWorldAligned, jacobian);
        let rows = &jacobian[..3 * nv];
        let mut force = [0.0; 3];
        for (k, f) in force.iter_mut().enumerate() {
            let velocity: f64 = (0..nv).map(|i| rows[k * nv + i] * v[i]).sum();
            *f = *stiffness * (target[k] - at[k]) - *damping * velocity;
        }
        let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let share = if size > *most { *most / size } else { 1.0 };
        let force = force.map(|f| share * f);
        for (i, tau) in tau.iter_mut().enumerate() {
            *tau = (0..3).map(|k| rows[k * nv + i] * force[k]).sum();
        }
        let moment = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            at[i] * force[j] - at[j] * force[i]
        });
        AppliedWrench { frame: self.link, axes: ReferenceFrame::World, force, moment }
    }
}
