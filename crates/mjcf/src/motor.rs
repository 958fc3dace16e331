//! Reads `armature`, `damping` and `group` of an actuator.

use std::collections::HashMap;

use robot_dynamics_description::{ActuatorDescription, RobotDescription, Transmission};

use crate::element::Element;
use crate::option::DisabledForces;
use crate::reader::Reader;

impl Reader<'_> {
    /// Adds the armature and damping of an actuator to its joint or tendon, multiplied by the square of the
    /// gear. The first number of the gear applies to all degrees of freedom.
    pub(crate) fn motor(
        &mut self,
        element: &Element,
        transmission: &Transmission,
        disabled: DisabledForces,
        joints: &HashMap<String, usize>,
        tendons: &HashMap<String, usize>,
        robot: &mut RobotDescription,
    ) {
        let mut armature = self.magnitude(element, "armature").unwrap_or(0.0);
        let damping = if disabled.dampers { [0.0; 3] } else { self.polynomial(element, "damping") };
        if armature == 0.0 && damping == [0.0; 3] {
            return;
        }
        let (target, gear) = match transmission {
            Transmission::Joint { joint, gear } | Transmission::JointInParent { joint, gear, .. } => {
                let own = joints.get(joint).map(|&index| &mut robot.joints[index]);
                (own.map(|own| (&mut own.passive, &mut own.higher_terms)), gear[0])
            }
            Transmission::Tendon { tendon, gear } => {
                let over_joints = robot.tendons.len();
                let target = tendons.get(tendon).map(|&index| match index.checked_sub(over_joints) {
                    None => {
                        let own = &mut robot.tendons[index];
                        (&mut own.passive, &mut own.higher_terms)
                    }
                    Some(index) => {
                        let own = &mut robot.spatial_tendons[index];
                        (&mut own.passive, &mut own.higher_terms)
                    }
                });
                if armature != 0.0 && tendons.get(tendon).is_some_and(|&index| index >= over_joints) {
                    let message = "the armature of a motor on a spatial tendon is not in the model";
                    self.report_ignored_physics(element, message);
                    armature = 0.0;
                }
                (target, *gear)
            }
            Transmission::Frame { .. }
            | Transmission::RelativeFrame { .. }
            | Transmission::Contacts { .. }
            | Transmission::SliderCrank { .. } => {
                self.refuse(
                    element,
                    "armature and damping are only supported for actuators of joints and tendons",
                );
                return;
            }
        };
        let Some((passive, higher)) = target else { return };
        let [linear, beyond @ ..] = damping.map(|damping| damping * gear * gear);
        passive.armature += armature * gear * gear;
        passive.damping += linear;
        higher.damping.iter_mut().zip(beyond).for_each(|(own, added)| *own += added);
    }

    /// Removes the bounds of controls if they are disabled, and the forces of disabled actuators. Controls
    /// stay.
    pub(crate) fn disable(
        &mut self,
        element: &Element,
        disabled: DisabledForces,
        actuators: &mut [ActuatorDescription],
    ) {
        let group = self.number(element, "group").unwrap_or(0.0);
        if disabled.control_bounds {
            // A motor without an input has the range 0 0.
            for actuator in actuators.iter_mut().filter(|actuator| actuator.control_range != [0.0; 2]) {
                actuator.control_range = [f64::NEG_INFINITY, f64::INFINITY];
            }
        }
        for actuator in actuators.iter_mut().filter(|_| disabled.has_actuator_group(group)) {
            (actuator.gain, actuator.bias) = Default::default();
            (actuator.muscle, actuator.cogging, actuator.integral, actuator.motor) = (None, None, None, None);
        }
    }
}
