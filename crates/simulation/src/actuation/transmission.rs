//! The transmission of an actuator's force to the joints.

use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::kinematics::body_placement::Placement;
use robot_dynamics_core::kinematics::frame_transmission::FrameTransmission;
use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian};
use robot_dynamics_description::{RobotDescription, Transmission};

use super::dof_gear::{Axes, DofGear};
use super::spatial_tendon::{SpatialTendonMemory, SpatialTendons};
use super::tendon::Tendon;

/// Memory for the Jacobians of frames and spatial tendons that actuators act on.
#[derive(Clone, Debug)]
pub(super) struct TransmissionMemory {
    /// The spatial tendons at the last configuration.
    pub(super) spatial: Option<SpatialTendonMemory>,
    /// Allocated if there is such a frame.
    dynamics: Option<Workspace>,
    jacobian: Vec<f64>,
    /// Allocated if there is a transmission between two frames.
    placement: Option<Placement>,
}

impl TransmissionMemory {
    pub(super) fn new(nv: usize, spatial: Option<&SpatialTendons>) -> Self {
        Self {
            spatial: spatial.map(SpatialTendons::memory),
            dynamics: None,
            jacobian: vec![0.0; 6 * nv],
            placement: None,
        }
    }

    /// J in the frame, 6×nv.
    fn jacobian(&mut self, model: &Model, q: &[f64], frame: FrameId) -> &[f64] {
        let dynamics = self.dynamics.get_or_insert_with(|| Workspace::new(model));
        frame_jacobian(model, dynamics, q, frame, ReferenceFrame::Local, &mut self.jacobian);
        &self.jacobian
    }

    /// ℓ of a transmission between two frames, and ∂ℓ̇/∂v.
    fn between_frames(&mut self, model: &Model, q: &[f64], frames: &FrameTransmission) -> (f64, &[f64]) {
        let placement = self.placement.get_or_insert_with(|| Placement::new(model));
        if !placement.is_at(q) {
            placement.set(model, self.dynamics.get_or_insert_with(|| Workspace::new(model)), q);
        }
        let row = &mut self.jacobian[..model.nv()];
        let length = frames.length_and_row(model, placement, row);
        (length, row)
    }
}

/// A transmission of a compiled robot.
#[derive(Clone, Debug)]
pub(super) enum Drive {
    /// ℓ is that of a joint times the gear.
    Joint { length: JointSum },
    /// A joint of several degrees of freedom.
    Dofs(DofGear),
    /// A tendon by its index.
    Tendon { index: usize, gear: f64 },
    /// A spatial tendon by its index among these.
    SpatialTendon { index: usize, gear: f64 },
    /// A wrench on a frame.
    Frame { frame: FrameId, gear: [f64; 6] },
    /// Two frames.
    BetweenFrames(FrameTransmission),
    /// The contacts of a link. Methods with contacts apply the force.
    Contacts { link: FrameId },
    /// A locked joint: no force moves it.
    Nothing,
}

impl Drive {
    pub(super) fn new(model: &Model, transmission: &Transmission) -> Self {
        match transmission {
            Transmission::Joint { joint: name, gear } => {
                let joint = model.joints.iter().find(|joint| joint.name == *name);
                match joint {
                    Some(joint) if joint.nv == 1 || joint.mimic.is_some() => {
                        Self::Joint { length: JointSum::new(model, 0.0, [(name.as_str(), gear[0])]) }
                    }
                    Some(joint) if joint.nv > 1 => Self::Dofs(DofGear::new(model, joint, *gear, Axes::Child)),
                    _ => Self::Nothing,
                }
            }
            Transmission::JointInParent { joint: name, gear, moment_in_child } => {
                let joint = model.joints.iter().find(|joint| joint.name == *name && joint.nv > 1);
                let axes = if *moment_in_child { Axes::ChildForMoments } else { Axes::Joint };
                joint.map_or(Self::Nothing, |joint| Self::Dofs(DofGear::new(model, joint, *gear, axes)))
            }
            Transmission::Tendon { tendon, gear } => {
                let RobotDescription { tendons, spatial_tendons, .. } = &model.description;
                let over_joints = tendons.iter().position(|own| own.name == *tendon);
                let along_path = spatial_tendons.iter().position(|own| own.name == *tendon);
                match (over_joints, along_path) {
                    (Some(index), _) => Self::Tendon { index, gear: *gear },
                    (None, Some(index)) => Self::SpatialTendon { index, gear: *gear },
                    (None, None) => Self::Nothing,
                }
            }
            Transmission::Frame { frame, gear } => {
                model.frame(frame).map_or(Self::Nothing, |frame| Self::Frame { frame, gear: *gear })
            }
            Transmission::Contacts { link } => {
                model.frame(link).map_or(Self::Nothing, |link| Self::Contacts { link })
            }
            Transmission::RelativeFrame { .. } | Transmission::SliderCrank { .. } => {
                let frames = FrameTransmission::new(model, transmission);
                frames.map_or(Self::Nothing, Self::BetweenFrames)
            }
        }
    }

    /// ℓ(q) and ℓ̇(q, v). The memory has the spatial tendons at q.
    pub(super) fn length_and_rate(
        &self,
        model: &Model,
        tendons: &[Tendon],
        memory: &mut TransmissionMemory,
        (q, v): (&[f64], &[f64]),
    ) -> (f64, f64) {
        match self {
            Self::Joint { length } => (length.at(q), length.rate(v)),
            Self::Dofs(dofs) => dofs.length_and_rate(q, v),
            Self::Tendon { index, gear } => {
                let length = &tendons[*index].length;
                (gear * length.at(q), gear * length.rate(v))
            }
            Self::SpatialTendon { index, gear } => match &memory.spatial {
                Some(spatial) => (gear * spatial.length(*index), gear * spatial.rate(*index, v)),
                None => (0.0, 0.0),
            },
            Self::Frame { frame, gear } => {
                let (jacobian, nv) = (memory.jacobian(model, q, *frame), v.len());
                let row = |i: usize| -> f64 { (0..nv).map(|k| jacobian[i * nv + k] * v[k]).sum() };
                (0.0, (0..6).map(|i| gear[i] * row(i)).sum())
            }
            Self::BetweenFrames(frames) => {
                let (length, row) = memory.between_frames(model, q, frames);
                (length, row.iter().zip(v).map(|(entry, v)| entry * v).sum())
            }
            Self::Contacts { .. } | Self::Nothing => (0.0, 0.0),
        }
    }

    /// The change of ℓ in a full turn, if ℓ is a component of a rotation vector.
    pub(super) fn period(&self) -> Option<f64> {
        let period = match self {
            Self::Dofs(dofs) => dofs.period(),
            Self::BetweenFrames(frames) => frames.period(),
            _ => None,
        };
        period.filter(|&period| period > 0.0)
    }

    /// τ += (∂ℓ̇/∂v)ᵀ f. The memory has the spatial tendons at q.
    pub(super) fn spread(
        &self,
        model: &Model,
        tendons: &[Tendon],
        memory: &mut TransmissionMemory,
        q: &[f64],
        force: f64,
        tau: &mut [f64],
    ) {
        match self {
            Self::Joint { length } => length.spread(force, tau),
            Self::Dofs(dofs) => dofs.spread(q, force, tau),
            Self::Tendon { index, gear } => tendons[*index].length.spread(gear * force, tau),
            Self::SpatialTendon { index, gear } => {
                if let Some(spatial) = &memory.spatial {
                    spatial.spread(*index, gear * force, tau);
                }
            }
            Self::Frame { frame, gear } => {
                let (jacobian, nv) = (memory.jacobian(model, q, *frame), tau.len());
                for k in 0..nv {
                    tau[k] += force * (0..6).map(|i| gear[i] * jacobian[i * nv + k]).sum::<f64>();
                }
            }
            Self::BetweenFrames(frames) => {
                let (_, row) = memory.between_frames(model, q, frames);
                tau.iter_mut().zip(row).for_each(|(tau, entry)| *tau += force * entry);
            }
            Self::Contacts { .. } | Self::Nothing => {}
        }
    }
}
