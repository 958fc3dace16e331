//! Writes `<contact>`, `<tendon>` and `<equality>`.

use robot_dynamics_core::kinematics::body_placement::Placement;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_core::{Model, Workspace, neutral};
use robot_dynamics_description::{
    ContactPairDescription, Equality, EqualityDescription, JointKind, PassiveForces,
    PolynomialStiffnessDamping, Quaternion, RobotDescription, TendonSolverImpedance,
};
use robot_dynamics_xml::{excerpt, is_name};

use super::{LARGEST_BOUND, MjcfWriter, joint_place};
use crate::names::Names;

impl MjcfWriter<'_> {
    /// The name of the body of a link.
    pub(super) fn body_name(&self, link: &str) -> String {
        let index = self.link_index[link];
        if index == self.root && self.root_is_world() {
            return "world".into();
        }
        self.body_names[index].clone()
    }

    pub(super) fn write_contact(&mut self) {
        let robot = self.robot;
        if robot.contact_exclusions.is_empty() && robot.contact_pairs.is_empty() {
            return;
        }
        self.xml.start("contact");
        let mut names = Names::default();
        for pair in &robot.contact_pairs {
            self.write_pair(pair, &mut names);
        }
        for (first, second) in &robot.contact_exclusions {
            let (first, second) = (self.body_name(first), self.body_name(second));
            self.xml.start("exclude").attribute("body1", &first).attribute("body2", &second).end();
        }
        self.xml.end();
    }

    /// Writes a pair of geoms, if both are in the file.
    fn write_pair(&mut self, pair: &ContactPairDescription, names: &mut Names) {
        let [first, second] = &pair.shapes;
        if let Some(missing) = pair.shapes.iter().find(|shape| !self.shape_names.contains(shape)) {
            let place = format!("pair of {:?} and {:?}", excerpt(first), excerpt(second));
            let message = format!("omitted: the file has no shape {:?}", excerpt(missing));
            self.add_note(&place, message);
            return;
        }
        let usual = ContactPairDescription::new(["", ""]);
        self.xml.start("pair");
        if is_name(&pair.name) && names.reserve(&pair.name) {
            self.xml.attribute("name", &pair.name);
        }
        self.xml.attribute("geom1", first).attribute("geom2", second);
        self.xml.unless("condim", pair.condim.into(), usual.condim.into());
        let of_friction = pair.solreffriction.unwrap_or_default();
        for (name, numbers, usual) in [
            ("friction", &pair.friction[..], &usual.friction[..]),
            ("solref", &pair.solref, &usual.solref),
            ("solreffriction", &of_friction, &[0.0; 2]),
            ("solimp", &pair.solimp, &usual.solimp),
        ] {
            if numbers != usual {
                self.xml.numbers(name, numbers);
            }
        }
        self.xml.unless("margin", pair.margin, 0.0).unless("gap", pair.gap, 0.0);
        self.xml.end();
    }

    /// Whether the joint of this name is fixed.
    pub(super) fn is_locked(&self, joint: &str) -> bool {
        self.robot.joints.iter().any(|own| own.name == joint && own.kind == JointKind::Fixed)
    }

    pub(super) fn write_tendons(&mut self) {
        let robot = self.robot;
        if robot.tendons.is_empty() && robot.spatial_tendons.is_empty() {
            return;
        }
        self.xml.start("tendon");
        for tendon in &robot.tendons {
            let place = format!("tendon {:?}", excerpt(&tendon.name));
            let terms: Vec<_> = tendon.terms.iter().filter(|(joint, _)| !self.is_locked(joint)).collect();
            if terms.is_empty() {
                self.add_note(&place, "omitted: none of its joints moves");
                continue;
            }
            if tendon.offset != 0.0 {
                let message =
                    format!("its length {} with all joints at zero: it is 0 in MJCF", tendon.offset);
                self.add_loss(&place, message);
            }
            self.xml.start("fixed").attribute("name", &tendon.name);
            self.write_tendon_forces(&tendon.passive, &tendon.higher_terms, tendon.dead_band);
            self.xml.unless("springyield", tendon.spring_yield, 0.0);
            self.write_range(&place, "range", [tendon.limits.lower, tendon.limits.upper]);
            self.write_tendon_softness(&tendon.softness);
            self.write_range(&place, "actuatorfrcrange", [-tendon.limits.effort, tendon.limits.effort]);
            if tendon.limits.velocity.is_finite() {
                let message =
                    format!("a velocity bound of {}: not supported by MJCF", tendon.limits.velocity);
                self.add_note(&place, message);
            }
            for (joint, coefficient) in terms {
                self.xml.start("joint").attribute("joint", joint).numbers("coef", &[*coefficient]).end();
            }
            self.xml.end();
        }
        let geoms = core::mem::take(&mut self.tendon_geom_names);
        for (tendon, geoms) in robot.spatial_tendons.iter().zip(geoms) {
            self.write_spatial_tendon(tendon, geoms);
        }
        self.xml.end();
    }

    /// Writes the spring, the damper, friction and armature of a tendon.
    pub(super) fn write_tendon_forces(
        &mut self,
        passive: &PassiveForces,
        higher: &PolynomialStiffnessDamping,
        dead_band: f64,
    ) {
        if passive.stiffness != 0.0 || higher.stiffness != [0.0; 2] {
            // "−1 −1" has a special meaning.
            let from = if passive.rest == -1.0 { (-1.0_f64).next_up() } else { passive.rest };
            self.xml.numbers("springlength", &[from, (from + dead_band).min(LARGEST_BOUND)]);
        }
        self.write_polynomial("stiffness", passive.stiffness, higher.stiffness);
        self.write_polynomial("damping", passive.damping, higher.damping);
        self.xml.unless("frictionloss", passive.friction, 0.0).unless("armature", passive.armature, 0.0);
    }

    pub(super) fn write_tendon_softness(&mut self, softness: &TendonSolverImpedance) {
        self.write_softness("limit", &softness.limit);
        self.write_softness("friction", &softness.friction);
        self.xml.unless("margin", softness.margin, 0.0);
    }

    pub(super) fn write_equalities(&mut self) {
        let robot = self.robot;
        let mut names = Names::default();
        for equality in &robot.equalities {
            names.reserve(&equality.name);
        }
        let mimic_joints = robot.joints.iter().filter_map(|joint| Some((joint, joint.mimic.as_ref()?)));
        let mimic_joints: Vec<EqualityDescription> = mimic_joints
            .map(|(joint, mimic)| {
                let message = format!(
                    "it mimics {:?}: written as an equality, which is soft in MuJoCo; M includes both joints",
                    excerpt(&mimic.joint)
                );
                self.add_note(&joint_place(&joint.name), message);
                let kind = Equality::Joints {
                    joint: (joint.name.clone(), 0.0),
                    leader: Some((mimic.joint.clone(), 0.0)),
                    polynomial: [mimic.offset, mimic.ratio, 0.0, 0.0, 0.0],
                };
                EqualityDescription::new(names.unique(&format!("{}_follows", joint.name)), kind)
            })
            .collect();
        if mimic_joints.is_empty() && robot.equalities.is_empty() {
            return;
        }
        self.xml.start("equality");
        for (index, equality) in robot.equalities.iter().enumerate() {
            self.write_equality(equality, Some(index));
        }
        for equality in &mimic_joints {
            self.write_equality(equality, None);
        }
        self.xml.end();
    }

    /// The length of a tendon in the pose of the file, where all joints are at zero; `None` if it is omitted.
    fn initial_length(&self, name: &str) -> Option<f64> {
        let robot = self.robot;
        if let Some(tendon) = robot.tendons.iter().find(|own| own.name == name) {
            let is_written = tendon.terms.iter().any(|(joint, _)| !self.is_locked(joint));
            return is_written.then_some(tendon.offset);
        }
        let number = robot.spatial_tendons.iter().position(|own| own.name == name)?;
        self.path_lengths.get_or_init(|| initial_path_lengths(robot)).get(number).copied()
    }

    fn write_equality(&mut self, equality: &EqualityDescription, index: Option<usize>) {
        match &equality.kind {
            Equality::Joints { joint, leader, polynomial } => {
                if self.is_locked(&joint.0) || leader.as_ref().is_some_and(|leader| self.is_locked(&leader.0))
                {
                    let message = "omitted: one of its joints is locked";
                    self.add_loss(&format!("equality {:?}", excerpt(&equality.name)), message);
                    return;
                }
                self.xml.start("joint").attribute("name", &equality.name).attribute("joint1", &joint.0);
                let x0 = leader.as_ref().map_or(0.0, |leader| leader.1);
                if let Some((leader, _)) = leader {
                    self.xml.attribute("joint2", leader);
                }
                self.xml.numbers("polycoef", &shift_to_zero(joint.1, x0, polynomial));
            }
            Equality::Tendons { tendon, leader, polynomial } => {
                let own = self.initial_length(&tendon.0);
                let of_leader = leader.as_ref().map(|(name, _)| self.initial_length(name));
                let (Some(own), Some(of_leader)) = (own, of_leader.unwrap_or(Some(0.0))) else {
                    let message = "omitted: one of its tendons is";
                    self.add_loss(&format!("equality {:?}", excerpt(&equality.name)), message);
                    return;
                };
                self.xml.start("tendon").attribute("name", &equality.name).attribute("tendon1", &tendon.0);
                let x0 = leader.as_ref().map_or(0.0, |leader| leader.1);
                if let Some((leader, _)) = leader {
                    self.xml.attribute("tendon2", leader);
                }
                // Lengths count from those in the pose of the file.
                self.xml.numbers("polycoef", &shift_to_zero(tendon.1 - own, x0 - of_leader, polynomial));
            }
            Equality::Connect { .. } => {
                let [first, second] =
                    index.and_then(|index| self.connections.remove(&index)).unwrap_or_default();
                self.xml.start("connect").attribute("name", &equality.name);
                self.xml.attribute("site1", &first).attribute("site2", &second);
            }
            Equality::Weld { a, b, a_from_b, anchor, torque_scale } => {
                let (first, second) = (self.body_name(a), self.body_name(b));
                self.xml.start("weld").attribute("name", &equality.name);
                self.xml.attribute("body1", &first).attribute("body2", &second);
                let turn = Quaternion::from_rotation(&a_from_b.rotation).to_wxyz();
                // The position is that of the anchor.
                self.xml.numbers("relpose", &[&a_from_b.apply(*anchor)[..], &turn].concat());
                if *anchor != [0.0; 3] {
                    self.xml.numbers("anchor", anchor);
                }
                if *torque_scale != 1.0 {
                    self.xml.numbers("torquescale", &[*torque_scale]);
                }
            }
        }
        let usual = robot_dynamics_description::Surface::default();
        if equality.solref != usual.solref {
            self.xml.numbers("solref", &equality.solref);
        }
        if equality.solimp != usual.solimp {
            self.xml.numbers("solimp", &equality.solimp);
        }
        if !equality.active {
            self.xml.attribute("active", "false");
        }
        self.xml.end();
    }
}

/// The lengths of all spatial tendons with all joints at zero; empty for a robot that does not compile.
fn initial_path_lengths(robot: &RobotDescription) -> Vec<f64> {
    let mut zero = robot.clone();
    (zero.equalities, zero.actuators, zero.sensors, zero.poses) = Default::default();
    zero.joints.iter_mut().for_each(|joint| joint.mimic = None);
    let Ok(model) = Model::new(zero) else { return Vec::new() };
    let mut placement = Placement::new(&model);
    placement.set(&model, &mut Workspace::new(&model), &neutral(&model));
    TendonPath::all(&model).iter().map(|path| path.length(&placement)).collect()
}

/// The coefficients of y = y⁰ + Σ cₖ (x − x⁰)ᵏ in powers of x. The references of the file are zero.
fn shift_to_zero(y0: f64, x0: f64, polynomial: &[f64; 5]) -> [f64; 5] {
    let mut about = [0.0; 5];
    // Horner's rule: p ← p (x − x⁰) + c, from the highest power down.
    for &c in polynomial.iter().rev() {
        for power in (1..5).rev() {
            about[power] = about[power - 1] - x0 * about[power];
        }
        about[0] = c - x0 * about[0];
    }
    about[0] += y0;
    about
}

#[cfg(test)]
mod tests {
    use super::shift_to_zero;

    #[test]
    fn a_polynomial_moves_to_zero() {
        let (y0, x0, c) = (0.3, -0.7, [0.1, -2.0, 0.5, 3.0, -1.5]);
        let moved = shift_to_zero(y0, x0, &c);
        for x in [-2.0, 0.0, 0.4_f64] {
            let value = |c: &[f64; 5], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let there = y0 + value(&c, x - x0);
            assert!((value(&moved, x) - there).abs() < 1e-13 * there.abs().max(1.0), "{x}");
        }
        assert_eq!(shift_to_zero(0.0, 0.0, &c), c);
    }
}
