//! `<contact>`, `<tendon>` and `<equality>`.

use multibody::{ContactPairDescription, Equality, EqualityDescription, JointKind, Quaternion};
use robot_xml::{excerpt, is_name};

use super::{ENDLESS, Writing, joint_place};
use crate::names::Names;

impl Writing<'_> {
    /// The name of a link's body.
    pub(super) fn body_name(&self, link: &str) -> String {
        let index = self.link_index[link];
        if index == self.root && self.root_is_world() {
            return "world".into();
        }
        self.body_names[index].clone()
    }

    pub(super) fn contact(&mut self) {
        let robot = self.robot;
        if robot.contact_exclusions.is_empty() && robot.contact_pairs.is_empty() {
            return;
        }
        self.xml.start("contact");
        let mut names = Names::default();
        for pair in &robot.contact_pairs {
            self.pair(pair, &mut names);
        }
        for (first, second) in &robot.contact_exclusions {
            let (first, second) = (self.body_name(first), self.body_name(second));
            self.xml.start("exclude").attribute("body1", &first).attribute("body2", &second).end();
        }
        self.xml.end();
    }

    /// A pair of geoms that are in the file.
    fn pair(&mut self, pair: &ContactPairDescription, names: &mut Names) {
        let [first, second] = &pair.shapes;
        if let Some(missing) = pair.shapes.iter().find(|shape| !self.shape_names.has(shape)) {
            let place = format!("pair of {:?} and {:?}", excerpt(first), excerpt(second));
            let message = format!("left out: the file has no shape {:?}", excerpt(missing));
            self.note(&place, message);
            return;
        }
        let usual = ContactPairDescription::new(["", ""]);
        self.xml.start("pair");
        if is_name(&pair.name) && names.take(&pair.name) {
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

    /// Whether the robot's joint of this name has been locked.
    pub(super) fn is_locked(&self, joint: &str) -> bool {
        self.robot.joints.iter().any(|own| own.name == joint && own.kind == JointKind::Fixed)
    }

    pub(super) fn tendons(&mut self) {
        let robot = self.robot;
        if robot.tendons.is_empty() {
            return;
        }
        self.xml.start("tendon");
        for tendon in &robot.tendons {
            let place = format!("tendon {:?}", excerpt(&tendon.name));
            let terms: Vec<_> = tendon.terms.iter().filter(|(joint, _)| !self.is_locked(joint)).collect();
            if terms.is_empty() {
                self.note(&place, "left out: none of its joints moves");
                continue;
            }
            if tendon.offset != 0.0 {
                let message = format!(
                    "its length {} where all joints are at zero: the format has 0 there",
                    tendon.offset
                );
                self.lost(&place, message);
            }
            self.xml.start("fixed").attribute("name", &tendon.name);
            let passive = &tendon.passive;
            let higher = &tendon.higher_terms;
            if passive.stiffness != 0.0 || higher.stiffness != [0.0; 2] {
                // −1 −1 has a meaning of its own.
                let from = if passive.rest == -1.0 { (-1.0_f64).next_up() } else { passive.rest };
                self.xml.numbers("springlength", &[from, (from + tendon.dead_band).min(ENDLESS)]);
            }
            self.polynomial("stiffness", passive.stiffness, higher.stiffness);
            self.polynomial("damping", passive.damping, higher.damping);
            self.xml.unless("frictionloss", passive.friction, 0.0).unless("armature", passive.armature, 0.0);
            self.range(&place, "range", [tendon.limits.lower, tendon.limits.upper]);
            self.softness("limit", &tendon.softness.limit);
            self.softness("friction", &tendon.softness.friction);
            self.xml.unless("margin", tendon.softness.margin, 0.0);
            self.range(&place, "actuatorfrcrange", [-tendon.limits.effort, tendon.limits.effort]);
            if tendon.limits.velocity.is_finite() {
                let message =
                    format!("a bound on its velocity, {}: the format has none", tendon.limits.velocity);
                self.note(&place, message);
            }
            for (joint, coefficient) in terms {
                self.xml.start("joint").attribute("joint", joint).numbers("coef", &[*coefficient]).end();
            }
            self.xml.end();
        }
        self.xml.end();
    }

    pub(super) fn equalities(&mut self) {
        let robot = self.robot;
        let mut names = Names::default();
        for equality in &robot.equalities {
            names.take(&equality.name);
        }
        let followers = robot.joints.iter().filter_map(|joint| Some((joint, joint.mimic.as_ref()?)));
        let followers: Vec<EqualityDescription> = followers
            .map(|(joint, mimic)| {
                let message = format!(
                    "it follows {:?}: written as an equality, which MuJoCo holds softly; M is that of all joints",
                    excerpt(&mimic.joint)
                );
                self.note(&joint_place(&joint.name), message);
                let kind = Equality::Joints {
                    joint: (joint.name.clone(), 0.0),
                    leader: Some((mimic.joint.clone(), 0.0)),
                    polynomial: [mimic.offset, mimic.ratio, 0.0, 0.0, 0.0],
                };
                EqualityDescription::new(names.free(&format!("{}_follows", joint.name)), kind)
            })
            .collect();
        if followers.is_empty() && robot.equalities.is_empty() {
            return;
        }
        self.xml.start("equality");
        for (index, equality) in robot.equalities.iter().enumerate() {
            self.equality(equality, Some(index));
        }
        for equality in &followers {
            self.equality(equality, None);
        }
        self.xml.end();
    }

    fn equality(&mut self, equality: &EqualityDescription, index: Option<usize>) {
        match &equality.kind {
            Equality::Joints { joint, leader, polynomial } => {
                if self.is_locked(&joint.0) || leader.as_ref().is_some_and(|leader| self.is_locked(&leader.0))
                {
                    let message = "left out: one of its joints is locked";
                    self.lost(&format!("equality {:?}", excerpt(&equality.name)), message);
                    return;
                }
                self.xml.start("joint").attribute("name", &equality.name).attribute("joint1", &joint.0);
                let x0 = leader.as_ref().map_or(0.0, |leader| leader.1);
                if let Some((leader, _)) = leader {
                    self.xml.attribute("joint2", leader);
                }
                self.xml.numbers("polycoef", &about_zero(joint.1, x0, polynomial));
            }
            Equality::Connect { .. } => {
                let [first, second] =
                    index.and_then(|index| self.connections.remove(&index)).unwrap_or_default();
                self.xml.start("connect").attribute("name", &equality.name);
                self.xml.attribute("site1", &first).attribute("site2", &second);
            }
            Equality::Weld { a, b, a_from_b } => {
                let (first, second) = (self.body_name(a), self.body_name(b));
                self.xml.start("weld").attribute("name", &equality.name);
                self.xml.attribute("body1", &first).attribute("body2", &second);
                let turn = Quaternion::from_rotation(&a_from_b.rotation).to_wxyz();
                self.xml.numbers("relpose", &[&a_from_b.translation[..], &turn].concat());
            }
            _ => {
                let message = "left out: the format has none of its kind";
                self.lost(&format!("equality {:?}", excerpt(&equality.name)), message);
                return;
            }
        }
        let usual = multibody::Surface::default();
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

/// y = y⁰ + Σ cₖ (x − x⁰)ᵏ in powers of x: the file places its joints at zero.
fn about_zero(y0: f64, x0: f64, polynomial: &[f64; 5]) -> [f64; 5] {
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
    use super::about_zero;

    #[test]
    fn a_polynomial_moves_to_zero() {
        let (y0, x0, c) = (0.3, -0.7, [0.1, -2.0, 0.5, 3.0, -1.5]);
        let moved = about_zero(y0, x0, &c);
        for x in [-2.0, 0.0, 0.4_f64] {
            let value = |c: &[f64; 5], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let there = y0 + value(&c, x - x0);
            assert!((value(&moved, x) - there).abs() < 1e-13 * there.abs().max(1.0), "{x}");
        }
        assert_eq!(about_zero(0.0, 0.0, &c), c);
    }
}
