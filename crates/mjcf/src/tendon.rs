//! Reads `<tendon>`: tendons whose length is a linear combination of joint positions, and tendons along a
//! path.

use std::collections::HashMap;

use robot_dynamics_description::{
    Limits, PassiveForces, PolynomialStiffnessDamping, RobotDescription, SpatialTendonDescription,
    TendonDescription, TendonPathElement, TendonSolverImpedance, TendonSurface,
};

use crate::assembly::ElementTable;
use crate::body::Body;
use crate::classes::MAIN;
use crate::element::Element;
use crate::geom::{Geom, GeomType};
use crate::joint::JointType;
use crate::names::Names;
use crate::option::DisabledForces;
use crate::orientation::pose;
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

/// The properties that fixed and spatial tendons have in common.
struct TendonSettings {
    passive: PassiveForces,
    higher_terms: PolynomialStiffnessDamping,
    spring_yield: f64,
    dead_band: f64,
    /// Whether the spring is at rest where the springs of the joints are.
    rests_with_joints: bool,
    limits: Limits,
    actuator_force_range: Option<[f64; 2]>,
    softness: TendonSolverImpedance,
}

/// The geoms by name, each with the name of its link.
type Geoms<'a> = HashMap<&'a str, (&'a Geom, &'a str)>;

impl Reader<'_> {
    /// Reads all tendons, in the order of the file. Returns the indices of the spatial tendons whose rest
    /// length is that of the joints' springs at rest.
    pub(crate) fn tendons(
        &mut self,
        bodies: &[Body],
        table: &ElementTable,
        disabled: DisabledForces,
        robot: &mut RobotDescription,
    ) -> Vec<usize> {
        let mut names = Names::default();
        let mut at_rest = Vec::new();
        let all: Vec<Id> = self
            .tree
            .in_sections("tendon")
            .filter(|&id| matches!(self.tree.nodes[id].name.as_str(), "fixed" | "spatial"))
            .collect();
        let mut geoms = Geoms::new();
        if all.iter().any(|&id| self.tree.nodes[id].name == "spatial") {
            for (body, link) in bodies.iter().zip(&table.links) {
                for geom in &body.geoms {
                    geoms.entry(&geom.name).or_insert((geom, link));
                }
            }
        }
        for (index, id) in all.into_iter().enumerate() {
            let element = self.element(id, MAIN);
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("tendon_{index}"), str::to_owned);
            let own = names.unique(&name);
            if written.is_some() && own != name {
                self.refuse(&element, format!("the tendon {name:?} already exists; give each its own name"));
            }
            let settings = self.tendon_settings(&element, disabled);
            if self.tree.nodes[id].name == "fixed" {
                let tendon = self.fixed_tendon(&element, own, table, &settings);
                self.report_read(&element, "a tendon over joints");
                robot.tendons.push(tendon);
            } else if let Some(path) = self.tendon_path(&element, &geoms, table) {
                if settings.rests_with_joints {
                    at_rest.push(robot.spatial_tendons.len());
                }
                let tendon = self.spatial_tendon(&element, own, path, &settings);
                self.report_read(&element, "a tendon along a path");
                robot.spatial_tendons.push(tendon);
            }
        }
        at_rest
    }

    fn fixed_tendon(
        &mut self,
        element: &Element,
        name: String,
        table: &ElementTable,
        settings: &TendonSettings,
    ) -> TendonDescription {
        let mut terms = Vec::new();
        // The length at the rest positions of the joints' springs.
        let mut relaxed = 0.0;
        for term in self.tree.children(element.node, "joint").collect::<Vec<_>>() {
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
        let mut tendon = TendonDescription::new(name, terms);
        tendon.passive = settings.passive;
        if settings.rests_with_joints {
            tendon.passive.rest = relaxed;
        }
        tendon.higher_terms = settings.higher_terms;
        tendon.spring_yield = settings.spring_yield;
        tendon.dead_band = settings.dead_band;
        tendon.limits = settings.limits;
        if let Some([lower, upper]) = settings.actuator_force_range {
            tendon.limits.effort = lower.abs().max(upper.abs());
            if -lower != upper {
                let message = format!(
                    "actuatorfrcrange {lower} {upper}: a fixed tendon has one bound for both directions, {}",
                    tendon.limits.effort
                );
                self.report_ignored_physics(element, message);
            }
        }
        tendon.softness = settings.softness;
        tendon
    }

    fn spatial_tendon(
        &mut self,
        element: &Element,
        name: String,
        path: Vec<TendonPathElement>,
        settings: &TendonSettings,
    ) -> SpatialTendonDescription {
        let mut tendon = SpatialTendonDescription::new(name, path);
        tendon.passive = settings.passive;
        if core::mem::take(&mut tendon.passive.armature) != 0.0 {
            self.report_ignored_physics(element, "the armature of a spatial tendon is not in the model");
        }
        tendon.higher_terms = settings.higher_terms;
        tendon.spring_yield = settings.spring_yield;
        tendon.dead_band = settings.dead_band;
        tendon.limits = settings.limits;
        if let Some(range) = settings.actuator_force_range {
            tendon.actuator_force_range = range;
        }
        tendon.softness = settings.softness;
        tendon
    }

    /// The elements of a spatial tendon's path; `None`, with an error, if the path is invalid.
    fn tendon_path(
        &mut self,
        element: &Element,
        geoms: &Geoms<'_>,
        table: &ElementTable,
    ) -> Option<Vec<TendonPathElement>> {
        let mut path = Vec::new();
        let errors = self.errors.len();
        for id in self.tree.nodes[element.node].children.clone() {
            let part = self.raw_element(id);
            match self.tree.nodes[id].name.as_str() {
                "site" => {
                    let Some(name) = self.required_text(&part, "site", "SITE") else { continue };
                    match table.site(name) {
                        Some(site) => path.push(TendonPathElement::Point { frame: site.frame.clone() }),
                        None => self.refuse_unknown_name(&part, "site", name),
                    }
                }
                "geom" => path.extend(self.tendon_surface(&part, geoms, table)),
                "pulley" => {
                    let divisor = self.required_number(&part, "divisor");
                    if divisor <= 0.0 {
                        self.refuse(&part, format!("the divisor {divisor} of a pulley is not positive"));
                    }
                    path.push(TendonPathElement::Pulley { divisor });
                }
                _ => {} // reported by `list_unread`
            }
        }
        if self.errors.len() > errors {
            return None;
        }
        if let Err(message) = SpatialTendonDescription::check_path(&path) {
            self.refuse(element, message);
            return None;
        }
        Some(path)
    }

    fn tendon_surface(
        &mut self,
        part: &Element,
        geoms: &Geoms<'_>,
        table: &ElementTable,
    ) -> Option<TendonPathElement> {
        let name = self.required_text(part, "geom", "GEOM")?;
        let Some(&(geom, link)) = geoms.get(name) else {
            self.refuse_unknown_name(part, "geom", name);
            return None;
        };
        let surface = match (geom.form, &geom.mesh) {
            (GeomType::Sphere, None) => TendonSurface::Sphere,
            (GeomType::Cylinder, None) => TendonSurface::Cylinder,
            _ => {
                self.refuse(part, format!("the geom {name:?} is neither a sphere nor a cylinder"));
                return None;
            }
        };
        let side = match self.text(part, "sidesite") {
            None | Some("") => None,
            Some(side) => {
                let Some(site) = table.site(side) else {
                    self.refuse_unknown_name(part, "site", side);
                    return None;
                };
                Some(site.frame.clone())
            }
        };
        Some(TendonPathElement::Surface {
            link: link.to_owned(),
            link_from_surface: pose(&geom.body_from_geom),
            surface,
            radius: geom.size[0] * geom.scale.length,
            side,
        })
    }

    fn tendon_settings(&mut self, element: &Element, disabled: DisabledForces) -> TendonSettings {
        let [armature, friction] =
            ["armature", "frictionloss"].map(|name| self.number(element, name).unwrap_or(0.0));
        let [damping, d2, d3] = self.polynomial(element, "damping");
        let [stiffness, k2, k3] = self.polynomial(element, "stiffness");
        // One number gives both ends of the dead band; −1 stands for the length at rest.
        let [from, to] = match self.all_numbers(element, "springlength").as_deref() {
            Some(&[length]) => [length, length],
            Some(&[from, to]) => [from, to],
            _ => [-1.0, -1.0],
        };
        let on = |is_off: bool, value: f64| if is_off { 0.0 } else { value };
        let passive = PassiveForces::default()
            .with_armature(armature)
            .with_damping(on(disabled.dampers, damping))
            .with_friction(on(disabled.friction, friction))
            .with_spring(on(disabled.springs, stiffness), from);
        let higher_terms = PolynomialStiffnessDamping {
            stiffness: [k2, k3].map(|k| on(disabled.springs, k)),
            damping: [d2, d3].map(|d| on(disabled.dampers, d)),
        };
        let mut limits = Limits::default();
        if let Some([lower, upper]) = self.limit(element, "limited", "range") {
            (limits.lower, limits.upper) = (lower, upper);
        }
        let mut softness = TendonSolverImpedance::default();
        let TendonSolverImpedance { limit, friction, margin, .. } = &mut softness;
        limit.solref = self.overlay(element, "solreflimit", limit.solref);
        limit.solimp = self.overlay(element, "solimplimit", limit.solimp);
        friction.solref = self.overlay(element, "solreffriction", friction.solref);
        friction.solimp = self.overlay(element, "solimpfriction", friction.solimp);
        *margin = self.number(element, "margin").unwrap_or(0.0);
        TendonSettings {
            passive,
            higher_terms,
            spring_yield: self.magnitude(element, "springyield").unwrap_or(0.0),
            dead_band: to - from,
            rests_with_joints: from == -1.0 && to == -1.0,
            limits,
            actuator_force_range: self.limit(element, "actuatorfrclimited", "actuatorfrcrange"),
            softness,
        }
    }
}
