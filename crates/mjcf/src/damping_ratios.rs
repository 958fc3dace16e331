//! Computes springs and dampers that are given by time constants and damping ratios, and the peak forces of
//! muscles. They depend on the mass matrix in the pose of the file. The rest lengths of spatial tendons
//! depend on a pose, too.

use std::collections::HashMap;

use robot_dynamics_core::kinematics::body_placement::Placement;
use robot_dynamics_core::kinematics::frame_transmission::FrameTransmission;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_core::model::Joint;
use robot_dynamics_core::{Model, ReferenceFrame, Workspace, frame_jacobian, neutral};
use robot_dynamics_description::{Equality, Quaternion, RobotDescription, Transmission};

use crate::actuator::Actuators;
use crate::assembly::{ElementTable, JointEntry, pose_spring};
use crate::body::Body;
use crate::joint::JointType;
use crate::reader::Reader;

/// The largest number of degrees of freedom for which the mass matrix is inverted here.
const DOF_LIMIT: usize = 1000;

/// MuJoCo's smallest divisor.
const MIN_ACCELERATION: f64 = 1e-15;

impl Reader<'_> {
    /// Sets the rest length of spatial tendons without one, the length where the springs of the joints are at
    /// rest, and the reference lengths of equalities, those in the pose of the file.
    pub(crate) fn resolve_rest_lengths(
        &mut self,
        table: &ElementTable,
        at_rest: &[usize],
        robot: &mut RobotDescription,
    ) {
        if !self.errors.is_empty() {
            return;
        }
        let paths: HashMap<String, usize> =
            robot.spatial_tendons.iter().enumerate().map(|(at, own)| (own.name.clone(), at)).collect();
        let couples_paths = !paths.is_empty()
            && robot.equalities.iter_mut().any(|own| lengths(&mut own.kind).next().is_some());
        if couples_paths && let Some(initial) = InitialPose::new(table, robot, |joint| joint.initial.clone())
        {
            for (name, reference) in robot.equalities.iter_mut().flat_map(|own| lengths(&mut own.kind)) {
                if let Some(&tendon) = paths.get(name) {
                    *reference = initial.paths[tendon].length(&initial.placement);
                }
            }
        }
        if at_rest.is_empty() {
            return;
        }
        let position = |joint: &JointEntry| match joint.motion {
            JointType::Hinge | JointType::Slide => vec![joint.rest],
            _ => joint.initial.clone(),
        };
        let Some(relaxed) = InitialPose::new(table, robot, position) else { return };
        for &tendon in at_rest {
            robot.spatial_tendons[tendon].passive.rest = relaxed.paths[tendon].length(&relaxed.placement);
        }
    }

    /// Sets stiffness and damping of joints with `springdamper`, and the damping of servos with `dampratio`.
    pub(crate) fn resolve_damping_ratios(
        &mut self,
        bodies: &[Body],
        table: &ElementTable,
        actuators: &Actuators,
        robot: &mut RobotDescription,
    ) {
        let springs: Vec<(usize, [f64; 2])> = table
            .joints
            .iter()
            .enumerate()
            .filter_map(|(at, joint)| Some((at, joint.spring_damper?)))
            .collect();
        let depends_on_mass = !springs.is_empty()
            || !actuators.damping_ratios.is_empty()
            || !actuators.muscle_scales.is_empty();
        if !depends_on_mass || !self.errors.is_empty() {
            return;
        }
        let initial = InitialPose::new(table, robot, |joint| joint.initial.clone());
        let inverse = initial.as_ref().and_then(InitialPose::inverse_mass_matrix);
        let (Some(initial), Some(inverse)) = (initial, inverse) else {
            let message = "springdamper, dampratio and the scale of muscles need an invertible mass matrix and at \
                           most 1000 degrees of freedom: their springs, dampers and forces are not in the model";
            let root = self.raw_element(crate::tree::Tree::ROOT);
            self.report_ignored_physics(&root, message);
            for &(at, _) in &actuators.muscle_scales {
                if let Some(muscle) = &mut robot.actuators[at].muscle {
                    muscle.peak_force = 0.0;
                }
            }
            return;
        };
        let dofs = |joint: usize| table.joints[joint].motion.dof_count();
        let mut first = vec![0; table.joints.len() + 1];
        for joint in 0..table.joints.len() {
            first[joint + 1] = first[joint] + dofs(joint);
        }
        for (at, [time, ratio]) in springs {
            // The inertia 1/(M⁻¹)ᵢᵢ, with the mean of (M⁻¹)ᵢᵢ over the joint's degrees of freedom.
            let count = dofs(at) as f64;
            let admittance: f64 = (first[at]..first[at + 1]).map(|i| inverse[(i, i)]).sum();
            let inertia = count / admittance;
            let placed = &table.joints[at];
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
                joint.spring = pose_spring(own, stiffness, &body.parent_from_body);
            }
        }
        for &(at, ratio) in &actuators.damping_ratios {
            // J M⁻¹ Jᵀ for the moment row J of the actuator: 1/m of the mass that it moves.
            let row = moment(robot, &initial, table, &first, at);
            let admittance: f64 = row
                .iter()
                .flat_map(|&(i, a)| row.iter().map(move |&(j, b)| (i, j, a * b)))
                .map(|(i, j, ab)| ab * inverse[(i, j)])
                .sum();
            let moved = if admittance > 0.0 { 1.0 / admittance } else { 0.0 };
            let actuator = &mut robot.actuators[at];
            actuator.bias.velocity = -2.0 * ratio * (-actuator.bias.length * moved).max(0.0).sqrt();
        }
        for &(servo, input) in &actuators.velocity_inputs {
            robot.actuators[input].gain.constant = -robot.actuators[servo].bias.velocity;
        }
        for &(at, scale) in &actuators.muscle_scales {
            // |M⁻¹ Jᵀ|: the acceleration by a unit force.
            let row = moment(robot, &initial, table, &first, at);
            let entry = |i: usize| row.iter().map(|&(j, b)| inverse[(i, j)] * b).sum::<f64>();
            let acceleration = (0..inverse.nrows()).map(|i| entry(i).powi(2)).sum::<f64>().sqrt();
            if let Some(muscle) = &mut robot.actuators[at].muscle {
                muscle.peak_force = scale / acceleration.max(MIN_ACCELERATION);
            }
        }
    }
}

/// The tendons of an equality, with their reference lengths.
fn lengths(kind: &mut Equality) -> impl Iterator<Item = &mut (String, f64)> {
    let (tendon, leader) = match kind {
        Equality::Tendons { tendon, leader, .. } => (Some(tendon), leader.as_mut()),
        _ => (None, None),
    };
    tendon.into_iter().chain(leader)
}

type Matrix = nalgebra::DMatrix<f64>;

/// The robot of the file without its base, constraints and actuators, in one pose.
struct InitialPose {
    model: Model,
    q: Vec<f64>,
    placement: Placement,
    paths: Vec<TendonPath>,
}

impl InitialPose {
    /// The positions of the joints are those that `position` gives.
    fn new(
        table: &ElementTable,
        robot: &RobotDescription,
        position: impl Fn(&JointEntry) -> Vec<f64>,
    ) -> Option<Self> {
        let mut bare = robot.clone();
        (bare.equalities, bare.actuators, bare.sensors, bare.poses) = Default::default();
        (bare.shapes, bare.contact_exclusions) = Default::default();
        bare.contact_pairs.clear();
        if bare.spatial_tendons.is_empty()
            && robot.actuators.iter().all(|own| own.transmission.frames().next().is_none())
        {
            bare.frames.clear();
        }
        // The base is fixed here. A floating base is added later.
        let model = Model::new(bare).ok()?;
        let mut q = neutral(&model);
        let ranges: HashMap<&str, _> =
            model.joints().iter().map(|joint| (joint.name.as_str(), joint.q())).collect();
        for joint in &table.joints {
            q[ranges.get(joint.name.as_str())?.clone()].copy_from_slice(&position(joint));
        }
        let mut placement = Placement::new(&model);
        placement.set(&model, &mut Workspace::new(&model), &q);
        let paths = TendonPath::all(&model);
        Some(Self { model, q, placement, paths })
    }

    fn inverse_mass_matrix(&self) -> Option<Matrix> {
        if self.model.nv() > DOF_LIMIT {
            return None;
        }
        Some(self.model.mass_matrix(&self.q).ok()?.cholesky()?.inverse())
    }

    /// The derivatives of a spatial tendon's length by the coordinates, where they are not zero.
    fn row(&self, tendon: usize) -> Vec<(usize, f64)> {
        let mut row = vec![0.0; self.model.nv()];
        self.paths[tendon].length_and_row(&self.model, &self.placement, &mut row);
        not_zero(row)
    }

    /// The gear of a joint along the axes of its frame, along the axes of its v.
    fn row_in_parent(&self, joint: &str, gear: [f64; 6], moment_in_child: bool) -> Vec<f64> {
        let Some(q) = self.model.joints().iter().find(|own| own.name == joint).map(Joint::q) else {
            return Vec::new();
        };
        let q = &self.q[q];
        let Some(&[x, y, z, w]) = q.last_chunk() else { return Vec::new() };
        let back = |[a, b, c]: [f64; 3]| Quaternion::from_xyzw([x, y, z, w]).rotate_back([a, b, c]);
        let [a, b, c, d, e, f] = gear;
        let (first, second) = ([a, b, c], [d, e, f]);
        [back(first), if moment_in_child { second } else { back(second) }].concat()
    }

    fn row_of_frame(&self, frame: &str, gear: &[f64; 6]) -> Vec<(usize, f64)> {
        let Some(frame) = self.model.frame(frame) else { return Vec::new() };
        let nv = self.model.nv();
        let mut jacobian = vec![0.0; 6 * nv];
        let workspace = &mut Workspace::new(&self.model);
        frame_jacobian(&self.model, workspace, &self.q, frame, ReferenceFrame::Local, &mut jacobian);
        not_zero((0..nv).map(|k| (0..6).map(|i| gear[i] * jacobian[i * nv + k]).sum()))
    }

    fn row_between_frames(&self, transmission: &Transmission) -> Vec<(usize, f64)> {
        let Some(frames) = FrameTransmission::new(&self.model, transmission) else { return Vec::new() };
        let mut row = vec![0.0; self.model.nv()];
        frames.length_and_row(&self.model, &self.placement, &mut row);
        not_zero(row)
    }
}

/// The entries that are not zero, with their indices.
fn not_zero(row: impl IntoIterator<Item = f64>) -> Vec<(usize, f64)> {
    row.into_iter().enumerate().filter(|(_, entry)| *entry != 0.0).collect()
}

/// The derivatives of an actuator's length by the coordinates, where they are not zero.
fn moment(
    robot: &RobotDescription,
    initial: &InitialPose,
    table: &ElementTable,
    first: &[usize],
    at: usize,
) -> Vec<(usize, f64)> {
    use robot_dynamics_description::Transmission::{Frame, Joint, JointInParent, Tendon};
    let index = |name: &str| table.joints.iter().position(|joint| joint.name == name);
    match &robot.actuators[at].transmission {
        Joint { joint, gear } => index(joint)
            .map(|joint| (first[joint]..first[joint + 1]).zip(*gear).collect())
            .unwrap_or_default(),
        JointInParent { joint, gear, moment_in_child } => {
            let Some(joint) = index(joint) else { return Vec::new() };
            let row = initial.row_in_parent(&table.joints[joint].name, *gear, *moment_in_child);
            (first[joint]..first[joint + 1]).zip(row).collect()
        }
        Tendon { tendon, gear } => {
            if let Some(path) = robot.spatial_tendons.iter().position(|own| own.name == *tendon) {
                return initial.row(path).into_iter().map(|(k, entry)| (k, entry * gear)).collect();
            }
            let tendon = robot.tendons.iter().find(|own| own.name == *tendon);
            let terms = tendon.map(|tendon| &tendon.terms[..]).unwrap_or_default();
            terms.iter().filter_map(|(joint, c)| Some((first[index(joint)?], c * gear))).collect()
        }
        Frame { frame, gear } => initial.row_of_frame(frame, gear),
        other => initial.row_between_frames(other),
    }
}
