//! The values at a state.

use robot_dynamics_core::Model;
use robot_dynamics_core::algorithms::energy::energies;
use robot_dynamics_core::algorithms::frame_motion::MovingFrame;
use robot_dynamics_core::algorithms::joint_reactions::{NUMBERS, collect, inertial_forces};
use robot_dynamics_core::kinematics::world_frame::{
    compute_column_rates, compute_columns, compute_twist_rates, compute_twists,
};
use robot_dynamics_core::workspace::tree::TreeMemory;
use robot_dynamics_description::{Quaternion, SensorKind, check_length};
use robot_dynamics_number::algebra::V3;

use super::reading::{Reading, Sensor, SensorFrame};
use super::subtree::subtree_value;
use super::{PointForce, SensorInputs, SensorMemory, SensorSet};

impl SensorSet {
    /// Writes the values of all sensors to `values`, [`value_count`](Self::value_count) numbers, each
    /// sensor's at its [`range`](Self::range).
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model, the memory or a frame belongs to another robot.
    #[track_caller]
    pub fn evaluate(
        &self,
        model: &Model,
        memory: &mut SensorMemory,
        inputs: &SensorInputs<'_>,
        values: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the sensor set");
        self.check_inputs(model, memory, inputs, values.len());
        let SensorInputs { q, v, a, actuator_forces, .. } = *inputs;
        let energy = if self.needs.energy { energies(model, &mut memory.dynamics, q, v) } else { (0.0, 0.0) };
        memory.actuator_torques.fill(0.0);
        if self.needs.actuator_torques && !actuator_forces.is_empty() {
            let SensorMemory { actuation, actuator_torques, .. } = memory;
            self.actuation.torques_of_forces(model, actuation, actuator_forces, q, actuator_torques);
        }
        let tree = &mut memory.dynamics.tree;
        compute_columns(model, tree, q);
        compute_twists(model, tree, v);
        compute_column_rates(model, tree);
        compute_twist_rates(model, tree, Some(a));
        for sensor in &self.sensors {
            let out = &mut values[sensor.range.clone()];
            self.value(model, memory, inputs, sensor, energy, out);
        }
        if self.needs.reactions {
            self.evaluate_reactions(model, memory, inputs, values);
        }
        for sensor in &self.sensors {
            for value in &mut values[sensor.range.clone()] {
                *value = bounded(sensor, *value);
            }
        }
    }

    /// Panics if a slice has the wrong length, or the memory belongs to another robot.
    #[track_caller]
    fn check_inputs(&self, model: &Model, memory: &SensorMemory, inputs: &SensorInputs<'_>, values: usize) {
        let SensorInputs { q, v, a, actuator_forces, joint_limit_forces, tendon_limit_forces, .. } = *inputs;
        memory.dynamics.check_inputs(model, q);
        check_length("v", v.len(), model.nv);
        check_length("a", a.len(), model.nv);
        check_length("the values", values, self.values);
        for (what, forces, count) in [
            ("the actuators' forces", actuator_forces, model.description.actuators.len()),
            ("the limits' forces", joint_limit_forces, model.nv),
            ("the forces of tendons' limits", tendon_limit_forces, model.description.tendon_names().count()),
        ] {
            if !forces.is_empty() {
                check_length(what, forces.len(), count);
            }
        }
    }

    /// Writes the values of force and torque sensors, from the wrenches that joints transmit.
    fn evaluate_reactions(
        &self,
        model: &Model,
        memory: &mut SensorMemory,
        inputs: &SensorInputs<'_>,
        values: &mut [f64],
    ) {
        let SensorInputs { q, v, a, .. } = *inputs;
        gather_external(model, memory, inputs.wrenches);
        let SensorMemory { dynamics, external, reactions, .. } = memory;
        inertial_forces(model, &mut dynamics.tree, (q, v, a), 0, reactions);
        for (reaction, external) in reactions.iter_mut().zip(external) {
            *reaction -= *external;
        }
        collect(model, &dynamics.tree, 0, reactions);
        for sensor in &self.sensors {
            let is_force = match sensor.kind {
                SensorKind::Force => true,
                SensorKind::Torque => false,
                _ => continue,
            };
            if let Reading::Frame { on, .. } = &sensor.reading {
                let value = reaction_in_frame(model, reactions, on, is_force);
                values[sensor.range.clone()].copy_from_slice(&value);
            }
        }
    }

    /// The value, before its cutoff, of a sensor that does not need reactions.
    fn value(
        &self,
        model: &Model,
        memory: &mut SensorMemory,
        inputs: &SensorInputs<'_>,
        sensor: &Sensor,
        (kinetic, potential): (f64, f64),
        out: &mut [f64],
    ) {
        let SensorInputs { time, q, v, actuator_forces, .. } = *inputs;
        let tree = &memory.dynamics.tree;
        match &sensor.reading {
            Reading::Robot => {
                out[0] = match sensor.kind {
                    SensorKind::KineticEnergy => kinetic,
                    SensorKind::PotentialEnergy => {
                        potential + self.fixed_energy + self.actuation.spring_energy(&mut memory.actuation, q)
                    }
                    _ => time,
                };
            }
            Reading::Frame { .. } => frame_value(model, tree, inputs.wrenches, sensor, out),
            Reading::Subtree(segment) => {
                out.copy_from_slice(&subtree_value(model, tree, *segment, sensor.kind));
            }
            Reading::Length { length, limits, margin, index } => {
                let (position, rate) = (length.at(q), length.rate(v));
                let limited = nearest_limit(position, *limits, *margin);
                let force_of = |forces: &[f64]| forces.get(*index).copied().unwrap_or(0.0);
                out[0] = match sensor.kind {
                    SensorKind::JointPosition | SensorKind::TendonPosition => position,
                    SensorKind::JointVelocity | SensorKind::TendonVelocity => rate,
                    SensorKind::JointActuatorForce => memory.actuator_torques[*index],
                    SensorKind::TendonActuatorForce => {
                        self.actuation.force_on_tendon(*index, actuator_forces)
                    }
                    SensorKind::JointLimitPosition | SensorKind::TendonLimitPosition => {
                        limited.map_or(0.0, |(distance, _)| distance)
                    }
                    SensorKind::JointLimitVelocity | SensorKind::TendonLimitVelocity => {
                        limited.map_or(0.0, |(_, side)| side * rate)
                    }
                    SensorKind::JointLimitForce => {
                        side_of_limit(position, *limits) * force_of(inputs.joint_limit_forces)
                    }
                    _ => side_of_limit(position, *limits) * force_of(inputs.tendon_limit_forces),
                };
            }
            Reading::SpatialTendon { index, limits, margin } => {
                let state = (q, v);
                let (length, rate) =
                    self.actuation.path_length_and_rate(&mut memory.actuation, *index, state);
                let limited = nearest_limit(length, *limits, *margin);
                out[0] = match sensor.kind {
                    SensorKind::TendonPosition => length,
                    SensorKind::TendonVelocity => rate,
                    SensorKind::TendonActuatorForce => self.actuation.force_on_path(*index, actuator_forces),
                    SensorKind::TendonLimitPosition => limited.map_or(0.0, |(distance, _)| distance),
                    SensorKind::TendonLimitVelocity => limited.map_or(0.0, |(_, side)| side * rate),
                    _ => {
                        let number = model.description.tendons.len() + index;
                        let force = inputs.tendon_limit_forces.get(number).copied().unwrap_or(0.0);
                        side_of_limit(length, *limits) * force
                    }
                };
            }
            Reading::Ball { q: at, v: first } => match sensor.kind {
                SensorKind::BallQuaternion => out.copy_from_slice(&q[*at..at + 4]),
                _ => out.copy_from_slice(&v[*first..first + 3]),
            },
            Reading::Actuator(index) => {
                out[0] = if sensor.kind == SensorKind::ActuatorForce {
                    actuator_forces.get(*index).copied().unwrap_or(0.0)
                } else {
                    let memory = &mut memory.actuation;
                    let (length, rate) = self.actuation.length_and_rate(model, memory, *index, (q, v));
                    if sensor.kind == SensorKind::ActuatorPosition { length } else { rate }
                };
            }
        }
    }
}

/// The value of a sensor on a frame, for the motion in the tree's workspace.
fn frame_value(
    model: &Model,
    tree: &TreeMemory<f64>,
    wrenches: &[PointForce],
    sensor: &Sensor,
    out: &mut [f64],
) {
    let Reading::Frame { on, reference, zone, field } = &sensor.reading else { return };
    let at = MovingFrame::of_frame(model, tree, &on.frame);
    let seen = reference.as_ref().map(|reference| MovingFrame::of_frame(model, tree, &reference.frame));
    let turn = at.place.rotation;
    // In the frame that the sensor's values are relative to.
    let relative = |x: V3<f64>| seen.as_ref().map_or(x, |seen| seen.place.rotation.transpose_mul(x)).array();
    let position = at.origin + at.place.translation;
    let from_reference = seen.as_ref().map(|seen| position - (seen.origin + seen.place.translation));
    let gravity = V3::new(model.gravity());
    let value = match sensor.kind {
        SensorKind::Accelerometer => {
            turn.transpose_mul(V3::new(at.classical_world_aligned().linear) - gravity).array()
        }
        SensorKind::Velocimeter => turn.transpose_mul(V3::new(at.velocity_world_aligned().linear)).array(),
        SensorKind::Gyro => turn.transpose_mul(at.twist.angular).array(),
        SensorKind::Magnetometer => turn.transpose_mul(V3::new(*field)).array(),
        SensorKind::FramePosition => relative(from_reference.unwrap_or(position)),
        SensorKind::FrameXAxis => relative(turn.column(0)),
        SensorKind::FrameYAxis => relative(turn.column(1)),
        SensorKind::FrameZAxis => relative(turn.column(2)),
        SensorKind::FrameLinearVelocity => {
            let velocity = V3::new(at.velocity_world_aligned().linear);
            let (Some(seen), Some(arm)) = (&seen, from_reference) else {
                out.copy_from_slice(&velocity.array());
                return;
            };
            // ṗ − ṗ_ref − ω_ref × (p − p_ref).
            let carried = V3::new(seen.velocity_world_aligned().linear) + seen.twist.angular.cross(arm);
            relative(velocity - carried)
        }
        SensorKind::FrameAngularVelocity => {
            let carried = seen.as_ref().map_or(V3::zero(), |seen| seen.twist.angular);
            relative(at.twist.angular - carried)
        }
        SensorKind::FrameLinearAcceleration => {
            (V3::new(at.classical_world_aligned().linear) - gravity).array()
        }
        SensorKind::FrameAngularAcceleration => at.rate.angular.array(),
        SensorKind::FrameQuaternion => {
            let rotation = seen.as_ref().map_or(turn, |seen| seen.place.rotation.transpose().times(&turn));
            let xyzw = Quaternion::from_rotation(&rotation.rows()).to_xyzw();
            out.copy_from_slice(&if xyzw[3] < 0.0 { xyzw.map(|x| -x) } else { xyzw });
            return;
        }
        SensorKind::InsideSite => {
            let point = relative(from_reference.unwrap_or(position));
            out[0] = f64::from(u8::from(zone.is_some_and(|zone| zone.contains(point))));
            return;
        }
        SensorKind::Touch => {
            out[0] = touch(model, wrenches, on, |point, along| {
                let place = |x: [f64; 3]| turn.transpose_mul(V3::new(x) - position).array();
                zone.is_none_or(|zone| zone.meets(place(point), turn.transpose_mul(along).array()))
            });
            return;
        }
        _ => [0.0; 3],
    };
    out.copy_from_slice(&value);
}

/// Σ max(f·n, 0) over the contacts of the frame's link whose ray, from the point away from the link, meets
/// the zone.
fn touch(
    model: &Model,
    wrenches: &[PointForce],
    on: &SensorFrame,
    meets: impl Fn([f64; 3], V3<f64>) -> bool,
) -> f64 {
    let mut sum = 0.0;
    for contact in wrenches {
        let normal = V3::new(contact.normal);
        let pressed = normal.dot(V3::new(contact.force));
        let is_here = model.frame_of(contact.link).link == on.frame.link;
        if is_here && pressed > 0.0 && meets(contact.point, -normal) {
            sum += pressed;
        }
    }
    sum
}

/// Computes the external wrench on each link, in world axes, about its origin.
fn gather_external(model: &Model, memory: &mut SensorMemory, wrenches: &[PointForce]) {
    memory.external.fill(0.0);
    for wrench in wrenches {
        let link = model.frame_of(wrench.link).link;
        let origin = MovingFrame::of_frame(model, &memory.dynamics.tree, &model.frames[link]);
        let arm = V3::new(wrench.point) - (origin.origin + origin.place.translation);
        let force = V3::new(wrench.force);
        let moment = V3::new(wrench.moment) + arm.cross(force);
        let sums = &mut memory.external[NUMBERS * model.segments.of_link[link]..];
        for (sum, x) in sums.iter_mut().zip(force.array().into_iter().chain(moment.array())) {
            *sum += x;
        }
    }
}

/// The force, or the moment about the frame's origin, in the frame's axes.
fn reaction_in_frame(model: &Model, reactions: &[f64], on: &SensorFrame, is_force: bool) -> [f64; 3] {
    let own = &reactions[NUMBERS * model.segments.of_link[on.frame.link]..][..NUMBERS];
    let (force, moment) = (V3::new([own[0], own[1], own[2]]), V3::new([own[3], own[4], own[5]]));
    let back = on.link_from_frame.inverse();
    let shifted = moment - V3::new(on.link_from_frame.translation).cross(force);
    back.rotate(if is_force { force.array() } else { shifted.array() })
}

/// The distance from the limit that is reached, less the margin, and the sign of q that leads away from it.
fn nearest_limit(position: f64, [lower, upper]: [f64; 2], margin: f64) -> Option<(f64, f64)> {
    let reached = |distance: f64, side: f64| (distance < margin).then_some((distance - margin, side));
    reached(position - lower, 1.0).or_else(|| reached(upper - position, -1.0))
}

/// The sign of q that leads away from the nearer limit, because rounding may hide that an active limit is
/// reached. 0 without limits.
fn side_of_limit(position: f64, [lower, upper]: [f64; 2]) -> f64 {
    match (position - lower, upper - position) {
        (below, above) if below.is_infinite() && above.is_infinite() => 0.0,
        (below, above) => {
            if below <= above {
                1.0
            } else {
                -1.0
            }
        }
    }
}

/// Limits a value to the sensor's cutoff.
fn bounded(sensor: &Sensor, value: f64) -> f64 {
    match sensor.kind {
        SensorKind::FrameQuaternion
        | SensorKind::BallQuaternion
        | SensorKind::FrameXAxis
        | SensorKind::FrameYAxis
        | SensorKind::FrameZAxis => value,
        SensorKind::Touch => value.min(sensor.cutoff),
        _ => value.clamp(-sensor.cutoff, sensor.cutoff),
    }
}
