//! The transmission of an actuator's force to the joints.

use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian};
use robot_dynamics_description::{Quaternion, RobotDescription, Transmission};

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
}

impl TransmissionMemory {
    pub(super) fn new(nv: usize, spatial: Option<&SpatialTendons>) -> Self {
        Self { spatial: spatial.map(SpatialTendons::memory), dynamics: None, jacobian: vec![0.0; 6 * nv] }
    }

    /// J in the frame, 6×nv.
    fn jacobian(&mut self, model: &Model, q: &[f64], frame: FrameId) -> &[f64] {
        let dynamics = self.dynamics.get_or_insert_with(|| Workspace::new(model));
        frame_jacobian(model, dynamics, q, frame, ReferenceFrame::Local, &mut self.jacobian);
        &self.jacobian
    }
}

/// A transmission of a compiled robot.
#[derive(Clone, Debug)]
pub(super) enum Drive {
    /// ℓ is that of a joint times the gear.
    Joint { length: JointSum },
    /// A joint of several degrees of freedom.
    Dofs { q: usize, v: usize, count: usize, chart: Chart, gear: [f64; 6] },
    /// A tendon by its index.
    Tendon { index: usize, gear: f64 },
    /// A spatial tendon by its index among these.
    SpatialTendon { index: usize, gear: f64 },
    /// A wrench on a frame.
    Frame { frame: FrameId, gear: [f64; 6] },
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
                    Some(joint) if joint.nv > 1 => {
                        let stretch = coordinate_ranges(model).find(|stretch| stretch.v == joint.v_index);
                        let chart = stretch.map_or(Chart::Line, |stretch| stretch.chart);
                        Self::Dofs { q: joint.q_index, v: joint.v_index, count: joint.nv, chart, gear: *gear }
                    }
                    _ => Self::Nothing,
                }
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
            Self::Dofs { q: at, v: first, count, chart, gear } => {
                let rate = (0..*count).map(|k| gear[k] * v[first + k]).sum();
                let length = match chart {
                    Chart::Line => (0..*count).map(|k| gear[k] * q[at + k]).sum(),
                    Chart::Rotation => {
                        let turn = Quaternion::from_xyzw(core::array::from_fn(|k| q[at + k])).log();
                        (0..3).map(|k| gear[k] * turn[k]).sum()
                    }
                    Chart::Placement => 0.0,
                };
                (length, rate)
            }
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
            Self::Nothing => (0.0, 0.0),
        }
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
            Self::Dofs { v, count, gear, .. } => {
                for k in 0..*count {
                    tau[v + k] += gear[k] * force;
                }
            }
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
            Self::Nothing => {}
        }
    }
}
