//! Springs and dampers that the file states by time constants and ratios: they follow from the mass matrix in the file's pose.

use multibody::{Model, RobotDescription, neutral};

use crate::actuator::Actuators;
use crate::assemble::{Places, placement_spring};
use crate::body::Body;
use crate::reader::Reader;

/// The largest robot whose mass matrix is computed for this.
const MOST: usize = 1000;

impl Reader<'_> {
    /// Fills in stiffness and damping of joints with `springdamper`, and the damping of servos with `dampratio`.
    pub(crate) fn derived(
        &mut self,
        bodies: &[Body],
        places: &Places,
        actuators: &Actuators,
        robot: &mut RobotDescription,
    ) {
        let sprung: Vec<(usize, [f64; 2])> = places
            .joints
            .iter()
            .enumerate()
            .filter_map(|(at, joint)| Some((at, joint.spring_damper?)))
            .collect();
        if (sprung.is_empty() && actuators.damping_ratios.is_empty()) || !self.errors.is_empty() {
            return;
        }
        let Some(inverse) = inverse_mass_matrix(places, robot) else {
            let message = "springdamper and dampratio need a mass matrix that can be inverted, of a robot of at most 1000 \
                           freedoms: their springs and dampers are not in the model";
            let root = self.plain(crate::tree::Tree::ROOT);
            self.ignored_physics(&root, message);
            return;
        };
        let freedoms = |joint: usize| places.joints[joint].motion.freedoms();
        let mut first = vec![0; places.joints.len() + 1];
        for joint in 0..places.joints.len() {
            first[joint + 1] = first[joint] + freedoms(joint);
        }
        for (at, [time, ratio]) in sprung {
            // Of a mass 1/(M⁻¹)ᵢᵢ, the mean over the joint's freedoms.
            let count = freedoms(at) as f64;
            let admittance: f64 = (first[at]..first[at + 1]).map(|i| inverse[(i, i)]).sum();
            let inertia = count / admittance;
            let placed = &places.joints[at];
            let Some(joint) = robot.joints.iter_mut().find(|joint| joint.name == placed.name) else {
                continue;
            };
            joint.passive.damping = 2.0 * inertia / time;
            let stiffness = inertia / (time * ratio).powi(2);
            if count == 1.0 {
                joint.passive.stiffness = stiffness;
                continue;
            }
            let mut all = bodies.iter().flat_map(|body| body.joints.iter().map(move |joint| (body, joint)));
            if let Some((body, own)) = all.nth(at) {
                joint.spring = placement_spring(own, stiffness, &body.parent_from_body);
            }
        }
        for &(at, ratio) in &actuators.damping_ratios {
            // J M⁻¹ Jᵀ of the row J that the actuator acts by: 1/m of the mass that it moves.
            let row = moment(robot, places, &first, at);
            let admittance: f64 = row
                .iter()
                .flat_map(|&(i, a)| row.iter().map(move |&(j, b)| (i, j, a * b)))
                .map(|(i, j, ab)| ab * inverse[(i, j)])
                .sum();
            let moved = if admittance > 0.0 { 1.0 / admittance } else { 0.0 };
            let actuator = &mut robot.actuators[at];
            actuator.bias.velocity = -2.0 * ratio * (actuator.gain.constant * moved).max(0.0).sqrt();
        }
    }
}

type Matrix = nalgebra::DMatrix<f64>;

/// M⁻¹ in the file's own pose.
fn inverse_mass_matrix(places: &Places, robot: &RobotDescription) -> Option<Matrix> {
    let mut bare = robot.clone();
    (bare.equalities, bare.actuators, bare.sensors, bare.poses) = Default::default();
    (bare.shapes, bare.contact_exclusions, bare.frames) = Default::default();
    bare.contact_pairs.clear();
    // Its base is the world, whose six freedoms come later if asked for.
    let model = Model::new(bare).ok().filter(|model| model.nv() <= MOST)?;
    let mut q = neutral(&model);
    for joint in &places.joints {
        let placed = model.joints().iter().find(|own| own.name == joint.name)?;
        q[placed.q_index..placed.q_index + placed.nq].copy_from_slice(&joint.initial);
    }
    Some(model.mass_matrix(&q).ok()?.cholesky()?.inverse())
}

/// The freedoms that an actuator acts on, each with its gear.
fn moment(robot: &RobotDescription, places: &Places, first: &[usize], at: usize) -> Vec<(usize, f64)> {
    use multibody::Transmission::{Joint, Tendon};
    let index = |name: &str| places.joints.iter().position(|joint| joint.name == name);
    match &robot.actuators[at].transmission {
        Joint { joint, gear } => index(joint)
            .map(|joint| (first[joint]..first[joint + 1]).zip(*gear).collect())
            .unwrap_or_default(),
        Tendon { tendon, gear } => {
            let tendon = robot.tendons.iter().find(|own| own.name == *tendon);
            let terms = tendon.map(|tendon| &tendon.terms[..]).unwrap_or_default();
            terms.iter().filter_map(|(joint, c)| Some((first[index(joint)?], c * gear))).collect()
        }
        _ => Vec::new(),
    }
}
