//! The stiffness and damping of servos and tendons, for implicit steps.

use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_description::ActuatorDescription;

use super::pose_spring::PoseSpring;
use super::transmission::Drive;
use super::{Actuation, Coupling};

impl Actuation {
    /// Adds the stiffness and damping of servos and tendons to those of the coordinates. Terms over several
    /// coordinates are added to the couplings. Negative values are left out.
    pub(crate) fn add_gains(
        &self,
        stiffness: &mut [f64],
        damping: &mut [f64],
        couplings: &mut Vec<Coupling>,
    ) {
        for (coordinate, k) in self.springs.iter().flat_map(PoseSpring::gains) {
            stiffness[coordinate] += k.max(0.0);
        }
        let mut add = |length: &JointSum, (k, d): (f64, f64)| {
            let (k, d) = (k.max(0.0), d.max(0.0));
            match length.row().as_slice() {
                [] => {}
                &[(coordinate, factor)] => {
                    stiffness[coordinate] += factor * factor * k;
                    damping[coordinate] += factor * factor * d;
                }
                _ if k == 0.0 && d == 0.0 => {}
                row => couplings.push(Coupling { row: row.to_vec(), stiffness: k, damping: d }),
            }
        };
        for tendon in &self.tendons {
            add(&tendon.length, tendon.law.gains());
        }
        for (actuator, drive) in &self.actuators {
            let (k, d) = gains(actuator);
            match drive {
                Drive::Joint { length } => add(length, (k, d)),
                Drive::Tendon { index, gear } => {
                    add(&self.tendons[*index].length, (gear * gear * k, gear * gear * d));
                }
                Drive::Dofs(_)
                | Drive::SpatialTendon { .. }
                | Drive::Frame { .. }
                | Drive::BetweenFrames(_)
                | Drive::Contacts { .. }
                | Drive::Nothing => {}
            }
        }
    }
}

/// The stiffness and damping of an actuator, without bounds. The back-EMF of a motor without a controller
/// damps it, and bristles resist like a spring and a damper.
fn gains(actuator: &ActuatorDescription) -> (f64, f64) {
    let (mut k, mut d) = (-actuator.bias.length, -actuator.bias.velocity);
    if let Some(motor) = &actuator.motor {
        if actuator.at_terminals && motor.current.is_none() {
            d += motor.constant * motor.constant / motor.resistance;
        }
        if let Some(friction) = &motor.friction {
            k += friction.stiffness;
            d += friction.damping;
        }
    }
    (k, d)
}
