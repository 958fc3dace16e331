//! Armature and damping of an actuator: those of its motor.

use std::collections::HashMap;

use multibody::{RobotDescription, Transmission};

use crate::option::Disabled;
use crate::reader::{Element, Reader};

impl Reader<'_> {
    /// The rotor's inertia and the motor's damping are the joint's or the tendon's, seen through the gear, whose first number is
    /// that of all freedoms.
    pub(crate) fn motor(
        &mut self,
        element: &Element,
        transmission: &Transmission,
        disabled: Disabled,
        joints: &HashMap<String, usize>,
        tendons: &HashMap<String, usize>,
        robot: &mut RobotDescription,
    ) {
        let armature = self.magnitude(element, "armature").unwrap_or(0.0);
        let damping = if disabled.dampers { [0.0; 3] } else { self.polynomial(element, "damping") };
        if armature == 0.0 && damping == [0.0; 3] {
            return;
        }
        let (target, gear) = match transmission {
            Transmission::Joint { joint, gear } => {
                let own = joints.get(joint).map(|&index| &mut robot.joints[index]);
                (own.map(|own| (&mut own.passive, &mut own.higher_terms)), gear[0])
            }
            Transmission::Tendon { tendon, gear } => {
                let own = tendons.get(tendon).map(|&index| &mut robot.tendons[index]);
                (own.map(|own| (&mut own.passive, &mut own.higher_terms)), *gear)
            }
            _ => {
                self.misplaced(element, "armature and damping are for an actuator of a joint or a tendon");
                return;
            }
        };
        let Some((passive, higher)) = target else { return };
        let [linear, beyond @ ..] = damping.map(|damping| damping * gear * gear);
        passive.armature += armature * gear * gear;
        passive.damping += linear;
        higher.damping.iter_mut().zip(beyond).for_each(|(own, added)| *own += added);
    }
}
