//! Checks of the parts of a description outside its tree: tendons, equalities, actuators.

use std::collections::HashMap;

use crate::robot::LinkDescription;
use crate::validate::{check, check_pose, index_names, is_single};
use crate::validate_sensors::check_sensors;
use crate::{Equality, HigherTerms, JointDescription, JointKind, ModelError, RobotDescription, Transmission};

/// The names that can be referred to.
pub(super) struct Names<'a> {
    pub(super) links: HashMap<&'a str, &'a LinkDescription>,
    pub(super) joints: HashMap<&'a str, &'a JointDescription>,
}

pub(crate) fn validate_beside(description: &RobotDescription) -> Result<(), ModelError> {
    let names = Names {
        links: description.links.iter().map(|link| (link.name.as_str(), link)).collect(),
        joints: description.joints.iter().map(|joint| (joint.name.as_str(), joint)).collect(),
    };
    for link in &description.links {
        let (owner, value) = (format!("link `{}`", link.name), link.gravity_compensation);
        check(value.is_finite(), &owner, "gravity compensation", value, "finite")?;
    }
    for joint in &description.joints {
        let owner = format!("joint `{}`", joint.name);
        check_range(&owner, "actuator force range", joint.actuator_force_range)?;
        check_terms(&owner, &joint.higher_terms)?;
        let turns_freely =
            matches!(joint.kind, JointKind::Spherical | JointKind::Floating | JointKind::Fixed);
        if !joint.higher_terms.is_zero() && !is_single(&joint.kind) && !turns_freely {
            let [k2, _] = joint.higher_terms.stiffness;
            check(
                false,
                &owner,
                "higher terms",
                k2,
                "of a joint of one freedom, a spherical or a floating one",
            )?;
        }
        if let Some(spring) = &joint.spring {
            check(spring.stiffness.is_finite(), &owner, "stiffness", spring.stiffness, "finite")?;
            check_pose(&owner, &spring.rest)?;
            check(
                turns_freely,
                &owner,
                "stiffness of a placement's spring",
                spring.stiffness,
                "of a spherical or floating joint",
            )?;
        }
    }
    check_tendons(description, &names)?;
    check_equalities(description, &names)?;
    check_actuators(description, &names)?;
    check_sensors(description, &names)
}

impl Names<'_> {
    fn link(&self, user: &str, name: &str) -> Result<(), ModelError> {
        let found = self.links.contains_key(name);
        if found { Ok(()) } else { Err(unknown(user, "link", name)) }
    }

    /// A joint of one DoF, or a locked one.
    fn single_joint(&self, user: &str, name: &str) -> Result<(), ModelError> {
        let joint = self.joints.get(name).ok_or_else(|| unknown(user, "joint", name))?;
        if is_single(&joint.kind) || joint.kind == JointKind::Fixed {
            return Ok(());
        }
        Err(ModelError::UnknownName { user: user.into(), sort: "joint of one freedom", name: name.into() })
    }
}

pub(super) fn unknown(user: &str, sort: &'static str, name: &str) -> ModelError {
    ModelError::UnknownName { user: user.into(), sort, name: name.into() }
}

fn check_range(owner: &str, quantity: &'static str, [lower, upper]: [f64; 2]) -> Result<(), ModelError> {
    check(!lower.is_nan(), owner, quantity, lower, "a number")?;
    check(upper >= lower, owner, quantity, upper, "at or above its lower end")
}

fn check_terms(owner: &str, terms: &HigherTerms) -> Result<(), ModelError> {
    for value in terms.stiffness.into_iter().chain(terms.damping) {
        check(value.is_finite(), owner, "higher term", value, "finite")?;
    }
    Ok(())
}

fn check_tendons(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("tendon", description.tendons.iter().map(|tendon| tendon.name.as_str()))?;
    for tendon in &description.tendons {
        let owner = format!("tendon `{}`", tendon.name);
        for (joint, coefficient) in &tendon.terms {
            names.single_joint(&owner, joint)?;
            check(coefficient.is_finite(), &owner, "coefficient", *coefficient, "finite")?;
        }
        let passive = &tendon.passive;
        for (value, quantity) in [
            (tendon.offset, "length where its joints are at 0"),
            (passive.armature, "armature"),
            (passive.damping, "damping"),
            (passive.friction, "friction"),
            (passive.stiffness, "stiffness"),
            (passive.rest, "rest length"),
        ] {
            check(value.is_finite(), &owner, quantity, value, "finite")?;
        }
        check_terms(&owner, &tendon.higher_terms)?;
        check(tendon.dead_band >= 0.0, &owner, "dead band", tendon.dead_band, "zero or positive")?;
    }
    Ok(())
}

fn check_equalities(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("equality", description.equalities.iter().map(|equality| equality.name.as_str()))?;
    for equality in &description.equalities {
        let owner = format!("equality `{}`", equality.name);
        let finite = |quantity: &'static str, numbers: &[f64]| {
            let bad = numbers.iter().find(|x| !x.is_finite());
            bad.map_or(Ok(()), |&x| check(false, &owner, quantity, x, "finite"))
        };
        match &equality.kind {
            Equality::Joints { joint, leader, polynomial } => {
                for (name, reference) in core::iter::once(joint).chain(leader) {
                    names.single_joint(&owner, name)?;
                    finite("reference position", &[*reference])?;
                }
                finite("coefficient", polynomial)?;
            }
            Equality::Connect { a, b } => {
                for (link, point) in [a, b] {
                    names.link(&owner, link)?;
                    finite("point", point)?;
                }
            }
            Equality::Weld { a, b, a_from_b } => {
                names.link(&owner, a)?;
                names.link(&owner, b)?;
                check_pose(&owner, a_from_b)?;
            }
        }
    }
    Ok(())
}

fn check_actuators(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("actuator", description.actuators.iter().map(|actuator| actuator.name.as_str()))?;
    for actuator in &description.actuators {
        let owner = format!("actuator `{}`", actuator.name);
        let gear: &[f64] = match &actuator.transmission {
            Transmission::Joint { joint, gear } => {
                names.joints.get(joint.as_str()).ok_or_else(|| unknown(&owner, "joint", joint))?;
                gear
            }
            Transmission::Tendon { tendon, gear } => {
                let found = description.tendons.iter().any(|own| own.name == *tendon);
                if !found {
                    return Err(unknown(&owner, "tendon", tendon));
                }
                core::slice::from_ref(gear)
            }
            Transmission::Frame { frame, gear } => {
                let is_frame = description.frames.iter().any(|own| own.name == *frame);
                if !is_frame {
                    names.link(&owner, frame)?;
                }
                gear
            }
        };
        let laws = [actuator.gain, actuator.bias];
        let numbers = laws.iter().flat_map(|law| [law.constant, law.length, law.velocity]);
        for number in gear.iter().copied().chain(numbers) {
            check(number.is_finite(), &owner, "gear, gain or bias", number, "finite")?;
        }
        if let crate::Activation::Filter { time_constant } = actuator.activation {
            check(time_constant > 0.0, &owner, "time constant", time_constant, "positive")?;
        }
        check_range(&owner, "control range", actuator.control_range)?;
        check_range(&owner, "force range", actuator.force_range)?;
    }
    Ok(())
}
