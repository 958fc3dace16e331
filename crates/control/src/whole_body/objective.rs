//! The objectives of tasks, and their rows.

use robot_dynamics_core::{
    FrameId, ReferenceFrame, SpatialAcceleration, Twist, center_of_mass, center_of_mass_bias_acceleration,
    center_of_mass_jacobian, center_of_mass_velocity, centroidal_momentum, centroidal_momentum_bias_rate,
    centroidal_momentum_matrix, check_configuration, check_vector, difference, frame_bias_acceleration,
    frame_jacobian, frame_pose, frame_velocity,
};
use robot_dynamics_number::{check_finite, check_number};
use robot_dynamics_simulation::{ControllerError, SpatialAxis};

use super::matrix::Matrix;
use super::state::State;
use crate::operational_space::{PoseReference, Reference, TaskReference, TaskTarget};

/// The gains of a spring and a damper: kp \[1/s²\] and kd \[1/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdGains {
    /// kp \[1/s²\].
    pub stiffness: f64,
    /// kd \[1/s\].
    pub damping: f64,
}

impl PdGains {
    /// kp with kd = 2 √kp: the error decays without oscillation.
    pub fn critical(stiffness: f64) -> Self {
        Self { stiffness, damping: 2.0 * stiffness.max(0.0).sqrt() }
    }
}

/// The quantity that a task controls: r = A x − b for x = (q̈, f), of which the squares are minimized.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Objective {
    /// J q̈ + J̇ v = V̇\* + kp e + kd (V\* − V), with e = (x\* − x, log(R\*Rᵀ)), in some directions along the
    /// world's axes.
    FramePose {
        /// The frame.
        frame: FrameId,
        /// The controlled directions.
        axes: Vec<SpatialAxis>,
        /// The pose, velocity and acceleration that the frame follows.
        reference: PoseReference,
        /// kp and kd.
        gains: PdGains,
    },
    /// J q̈ + J̇ v = V̇\* + kd (V\* − V), in some directions along the world's axes.
    FrameVelocity {
        /// The frame.
        frame: FrameId,
        /// The controlled directions.
        axes: Vec<SpatialAxis>,
        /// V\* along the world's axes \[m/s, rad/s\].
        velocity: Twist,
        /// V̇\* \[m/s², rad/s²\].
        acceleration: SpatialAcceleration,
        /// kd \[1/s\].
        damping: f64,
    },
    /// c̈ = c̈\* + kp (c\* − c) + kd (ċ\* − ċ) of the centre of mass.
    CenterOfMass {
        /// c\*, ċ\* and c̈\*.
        reference: TaskReference,
        /// kp and kd.
        gains: PdGains,
    },
    /// q̈ = q̈\* + kp (q\* ⊖ q) + kd (v\* − v) of the coordinates with motors.
    Posture {
        /// q\*, v\* and q̈\*; entries of coordinates without motors are ignored.
        reference: Reference,
        /// kp and kd.
        gains: PdGains,
    },
    /// k̇ = k̇\* + kd (k\* − k) of the angular momentum about the centre of mass.
    AngularMomentum {
        /// k\* \[kg·m²/s\].
        momentum: [f64; 3],
        /// k̇\* \[N·m\].
        rate: [f64; 3],
        /// kd \[1/s\].
        damping: f64,
    },
    /// τ = τ\* of the coordinates with motors.
    Torque {
        /// τ\*, nv entries \[N·m, N\].
        torque: Vec<f64>,
    },
    /// f = 0 for the forces of all contacts \[N\].
    ContactForces,
}

/// All six directions of a frame.
pub const ALL_AXES: [SpatialAxis; 6] =
    [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

impl Objective {
    /// The frame of the objective, if it has one.
    pub(super) fn frame(&self) -> Option<FrameId> {
        match self {
            Self::FramePose { frame, .. } | Self::FrameVelocity { frame, .. } => Some(*frame),
            _ => None,
        }
    }

    /// The most rows that it has beside those of contact forces.
    pub(super) fn most_rows(&self, nv: usize) -> usize {
        match self {
            Self::Posture { .. } | Self::Torque { .. } => nv,
            _ => 6,
        }
    }

    /// Appends the rows A and b to `rows` and `right`.
    pub(super) fn write(
        &self,
        state: &mut State<'_>,
        rows: &mut Matrix,
        right: &mut Vec<f64>,
    ) -> Result<(), ControllerError> {
        match self {
            Self::FramePose { frame, axes, reference, gains } => {
                let State { model, workspace, q, v, .. } = state;
                let aligned = ReferenceFrame::LocalWorldAligned;
                let pose = frame_pose(model, workspace, q, *frame);
                let velocity = frame_velocity(model, workspace, q, v, *frame, aligned);
                check_gains(*gains)?;
                let command =
                    (*reference).deviation(&pose, &velocity)?.acceleration(gains.stiffness, gains.damping);
                write_frame(state, *frame, axes, command, (rows, right));
            }
            Self::FrameVelocity { frame, axes, velocity, acceleration, damping } => {
                let State { model, workspace, q, v, .. } = state;
                check_number("the damping", *damping)?;
                let aligned = ReferenceFrame::LocalWorldAligned;
                let found = join(frame_velocity(model, workspace, q, v, *frame, aligned));
                let (wanted, rate) = (join(*velocity), [acceleration.linear, acceleration.angular]);
                let rate = rate.as_flattened();
                check_finite("the reference velocity", &wanted)?;
                check_finite("the reference acceleration", rate)?;
                let command = core::array::from_fn(|k| rate[k] + damping * (wanted[k] - found[k]));
                write_frame(state, *frame, axes, command, (rows, right));
            }
            Self::CenterOfMass { reference, gains } => {
                write_center_of_mass(state, *reference, *gains, (rows, right))?;
            }
            Self::Posture { reference, gains } => write_posture(state, reference, *gains, (rows, right))?,
            Self::AngularMomentum { momentum, rate, damping } => {
                check_finite("the angular momentum", momentum)?;
                check_finite("the rate of the angular momentum", rate)?;
                check_number("the damping", *damping)?;
                let State { model, workspace, q, v, jacobian, .. } = state;
                let found = centroidal_momentum(model, workspace, q, v).angular;
                let bias = centroidal_momentum_bias_rate(model, workspace, q, v).angular;
                centroidal_momentum_matrix(model, workspace, q, jacobian);
                let nv = model.nv();
                for k in 0..3 {
                    rows.push_row()[..nv].copy_from_slice(&jacobian[(3 + k) * nv..(4 + k) * nv]);
                    right.push(rate[k] + damping * (momentum[k] - found[k]) - bias[k]);
                }
            }
            Self::Torque { torque } => {
                check_vector(state.model, "the reference torque", torque)?;
                for i in (0..state.model.nv()).filter(|i| state.model.actuated_dofs()[*i]) {
                    rows.push_row().copy_from_slice(state.dynamics.row(i));
                    right.push(torque[i] - state.bias[i]);
                }
            }
            Self::ContactForces => {
                for column in state.model.nv()..rows.columns {
                    rows.push_row()[column] = 1.0;
                    right.push(0.0);
                }
            }
        }
        Ok(())
    }
}

fn check_gains(gains: PdGains) -> Result<(), ControllerError> {
    check_number("the stiffness", gains.stiffness)?;
    Ok(check_number("the damping", gains.damping)?)
}

fn join(twist: Twist) -> [f64; 6] {
    let Twist { linear: [a, b, c], angular: [d, e, f] } = twist;
    [a, b, c, d, e, f]
}

/// J q̈ + J̇ v = command.
fn write_frame(
    state: &mut State<'_>,
    frame: FrameId,
    axes: &[SpatialAxis],
    command: [f64; 6],
    (rows, right): (&mut Matrix, &mut Vec<f64>),
) {
    let State { model, workspace, q, v, jacobian, .. } = state;
    let (nv, aligned) = (model.nv(), ReferenceFrame::LocalWorldAligned);
    frame_jacobian(model, workspace, q, frame, aligned, jacobian);
    let bias = frame_bias_acceleration(model, workspace, q, v, frame, aligned);
    let bias = [bias.linear, bias.angular];
    for axis in axes.iter().map(|axis| *axis as usize) {
        rows.push_row()[..nv].copy_from_slice(&jacobian[axis * nv..(axis + 1) * nv]);
        right.push(command[axis] - bias.as_flattened()[axis]);
    }
}

fn write_center_of_mass(
    state: &mut State<'_>,
    reference: TaskReference,
    gains: PdGains,
    (rows, right): (&mut Matrix, &mut Vec<f64>),
) -> Result<(), ControllerError> {
    let State { model, workspace, q, v, jacobian, .. } = state;
    let TaskReference { position, velocity, acceleration } = reference;
    check_gains(gains)?;
    check_finite("the reference position", &position)?;
    check_finite("the reference velocity", &velocity)?;
    check_finite("the reference acceleration", &acceleration)?;
    let c = center_of_mass(model, workspace, q);
    let rate = center_of_mass_velocity(model, workspace, q, v);
    let bias = center_of_mass_bias_acceleration(model, workspace, q, v);
    let nv = model.nv();
    center_of_mass_jacobian(model, workspace, q, &mut jacobian[..3 * nv]);
    for k in 0..3 {
        rows.push_row()[..nv].copy_from_slice(&jacobian[k * nv..(k + 1) * nv]);
        let spring = gains.stiffness * (position[k] - c[k]) + gains.damping * (velocity[k] - rate[k]);
        right.push(acceleration[k] + spring - bias[k]);
    }
    Ok(())
}

fn write_posture(
    state: &mut State<'_>,
    reference: &Reference,
    gains: PdGains,
    (rows, right): (&mut Matrix, &mut Vec<f64>),
) -> Result<(), ControllerError> {
    let State { model, q, v, error, .. } = state;
    check_gains(gains)?;
    check_configuration(model, &reference.q).map_err(|error| error.of("the reference's q"))?;
    check_vector(model, "the reference's v", &reference.v)?;
    check_vector(model, "the reference's a", &reference.a)?;
    difference(model, q, &reference.q, error);
    for i in (0..model.nv()).filter(|i| model.actuated_dofs()[*i]) {
        rows.push_row()[i] = 1.0;
        let spring = gains.stiffness * error[i] + gains.damping * (reference.v[i] - v[i]);
        right.push(reference.a[i] + spring);
    }
    Ok(())
}
