//! Reads `<tendon>/<fixed>`: tendons whose length is a linear combination of joint positions.

use std::collections::HashMap;

use robot_dynamics_description::{PassiveForces, RobotDescription, TendonDescription, TendonSolverImpedance};

use crate::assembly::ElementTable;
use crate::classes::MAIN;
use crate::joint::JointType;
use crate::names::Names;
use crate::option::DisabledForces;
use crate::reader::Reader;
use crate::tree::Id;

/// Moves the armature of each tendon over a single joint to that joint, as armature·c² on the diagonal of M.
/// Formats without tendons can represent it there.
pub(crate) fn armature_to_joints(robot: &mut RobotDescription) {
    let joints: HashMap<String, usize> =
        robot.joints.iter().enumerate().map(|(at, joint)| (joint.name.clone(), at)).collect();
    for tendon in robot.tendons.iter_mut().filter(|tendon| tendon.passive.armature != 0.0) {
        let c: f64 = tendon.terms.iter().map(|(_, c)| c).sum();
        let Some((first, _)) = tendon.terms.first() else { continue };
        if let Some(&joint) = joints.get(first).filter(|_| tendon.terms.iter().all(|(name, _)| name == first))
        {
            robot.joints[joint].passive.armature += core::mem::take(&mut tendon.passive.armature) * c * c;
        }
    }
}

impl Reader<'_> {
    /// Reads all fixed tendons, in the order of the file.
    pub(crate) fn tendons(
        &mut self,
        table: &ElementTable,
        disabled: DisabledForces,
        robot: &mut RobotDescription,
    ) {
        let mut names = Names::default();
        let all: Vec<Id> =
            self.tree.in_sections("tendon").filter(|&id| self.tree.nodes[id].name == "fixed").collect();
        for (index, id) in all.into_iter().enumerate() {
            let element = self.element(id, MAIN);
            let mut terms = Vec::new();
            // The length at the rest positions of the joints' springs.
            let mut relaxed = 0.0;
            for term in self.tree.children(id, "joint").collect::<Vec<_>>() {
                let term = self.raw_element(term);
                let coefficient = self.required_number(&term, "coef");
                let Some(name) = self.required_text(&term, "joint", "JOINT") else { continue };
                let Some(joint) = self.joint_named(&term, name, table) else { continue };
                if matches!(joint.motion, JointType::Hinge | JointType::Slide) {
                    terms.push((joint.name.clone(), coefficient));
                    relaxed += coefficient * joint.rest;
                } else {
                    let word = joint.motion.word();
                    self.refuse(
                        &term,
                        format!("joint {name:?} is a {word} joint; a fixed tendon needs hinges or slides"),
                    );
                }
            }
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("tendon_{index}"), str::to_owned);
            let own = names.unique(&name);
            if written.is_some() && own != name {
                self.refuse(&element, format!("the tendon {name:?} already exists; give each its own name"));
            }
            let mut tendon = TendonDescription::new(own, terms);
            let [armature, friction] =
                ["armature", "frictionloss"].map(|name| self.number(&element, name).unwrap_or(0.0));
            let [damping, d2, d3] = self.polynomial(&element, "damping");
            let [stiffness, k2, k3] = self.polynomial(&element, "stiffness");
            // One number gives both ends of the dead band; −1 stands for the length at rest.
            let [from, to] = match self.all_numbers(&element, "springlength").as_deref() {
                Some(&[length]) => [length, length],
                Some(&[from, to]) => [from, to],
                _ => [-1.0, -1.0],
            };
            let [from, to] = if from == -1.0 && to == -1.0 { [relaxed; 2] } else { [from, to] };
            let on = |is_off: bool, value: f64| if is_off { 0.0 } else { value };
            tendon.passive = PassiveForces::default()
                .with_armature(armature)
                .with_damping(on(disabled.dampers, damping))
                .with_friction(on(disabled.friction, friction))
                .with_spring(on(disabled.springs, stiffness), from);
            tendon.higher_terms.stiffness = [k2, k3].map(|k| on(disabled.springs, k));
            tendon.higher_terms.damping = [d2, d3].map(|d| on(disabled.dampers, d));
            tendon.dead_band = to - from;
            if let Some([lower, upper]) = self.limit(&element, "limited", "range") {
                (tendon.limits.lower, tendon.limits.upper) = (lower, upper);
            }
            if let Some([lower, upper]) = self.limit(&element, "actuatorfrclimited", "actuatorfrcrange") {
                tendon.limits.effort = lower.abs().max(upper.abs());
            }
            let TendonSolverImpedance { limit, friction, margin, .. } = &mut tendon.softness;
            limit.solref = self.overlay(&element, "solreflimit", limit.solref);
            limit.solimp = self.overlay(&element, "solimplimit", limit.solimp);
            friction.solref = self.overlay(&element, "solreffriction", friction.solref);
            friction.solimp = self.overlay(&element, "solimpfriction", friction.solimp);
            *margin = self.number(&element, "margin").unwrap_or(0.0);
            self.report_read(&element, "a tendon over joints");
            robot.tendons.push(tendon);
        }
    }
}
