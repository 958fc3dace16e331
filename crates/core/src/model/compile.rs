//! Compiles a description, which uses names, to the arrays of the recursions.

use std::collections::HashMap;

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_description::validation::{Tree, validate};
use robot_dynamics_description::{
    Base, JointDescription, JointKind, MassProperties, ModelError, PassiveForces, Pose, RobotDescription,
    z_onto,
};
use robot_dynamics_number::algebra::{padded, padded_columns};

use crate::joint::{Chart, PrimitiveJoint};
use crate::model::frame::frames;
use crate::model::identity::Identity;
use crate::model::link;
use crate::model::mass::fixed_first_moment;
use crate::model::placed_link::PlacedLink;
use crate::model::reference_point::{choose_points, travels_far};
use crate::model::robot::Native;
use crate::model::rotor::Rotor;
use crate::model::segment::Segments;
use crate::model::{Body, Dof, Joint, Model, WORLD};

impl Model {
    /// Checks a description and compiles it.
    ///
    /// ```
    /// use robot_dynamics::description::{ModelError, pendulum};
    /// use robot_dynamics::model::Model;
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.nv(), 1);
    /// let mut headless = pendulum(2.0, 0.5);
    /// headless.joints[0].child = "bob".into(); // an unknown link
    /// assert!(Model::new(headless).unwrap_err().to_string().contains("bob"));
    /// # Ok::<(), ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] names the link or joint at fault. The causes are duplicate or unknown names, a link
    /// with two parents, several roots, cycles, a zero axis, and an invalid mimic joint. Joints that move no
    /// inertia are not an error: see [`Model::massless_joints`].
    pub fn new(description: RobotDescription) -> Result<Self, ModelError> {
        compile(description)
    }
}

fn compile(description: RobotDescription) -> Result<Model, ModelError> {
    let tree = validate(&description)?;
    let mut compiler = Compiler::new(&description);
    compiler.place_root(tree.root);
    // Depth first, children in the description's order: a subtree's coordinates are contiguous.
    let mut pending: Vec<usize> = tree.children[tree.root].iter().rev().copied().collect();
    while let Some(joint) = pending.pop() {
        let child = compiler.place_joint(&description.joints[joint]);
        pending.extend(tree.children[child].iter().rev());
    }
    compiler.resolve_followers(&tree);
    compiler.number_subtrees();
    compiler.finish_inertias();
    let rotors = Rotor::of_tendons(&description, &compiler.joints, &mut compiler.dofs);
    let massless = compiler.massless_joints(&rotors);
    let fixed_first_moment = fixed_first_moment(&description, &compiler.links);
    let (link_index, links) = (&compiler.link_index, &compiler.links);
    let frames = frames(&description, link_index, links);
    let segments = Segments::new(&description, link_index, tree.root, &compiler.joints, links);
    let model_links = link::links(&description, &compiler.parent_joints);
    let Compiler { joints, mut bodies, travels, dofs, nq, nv, has_mimic, .. } = compiler;
    let masses = description.links.iter().filter_map(|link| Some(link.mass_properties.as_ref()?.mass()));
    let mass = masses.sum::<f64>() + 0.0; // an empty sum is −0
    let has_armature = !rotors.is_empty() || dofs.iter().any(|dof| dof.passive.armature != 0.0);
    let has_springs = dofs.iter().any(|dof| dof.passive.stiffness != 0.0);
    let mut carries = vec![false; bodies.len()];
    for body in bodies.iter().filter(|body| body.parent != WORLD) {
        carries[body.parent] = true;
    }
    let points = choose_points(&mut bodies, &travels);
    let quaternions = joints.iter().filter(|joint| joint.nq > joint.nv);
    let mut model = Model {
        quaternions: quaternions.map(|joint| joint.q_index + joint.nq - 4).collect(),
        joints,
        links: model_links,
        frames,
        segments,
        first_angle: if has_mimic { None } else { first_angle(&bodies, nq) },
        bodies,
        dofs,
        nq,
        nv,
        mass,
        fixed_first_moment,
        needs_dense_factor: has_mimic || !rotors.is_empty(),
        rotors,
        has_armature,
        has_springs,
        leaf_count: carries.iter().filter(|carries| !**carries).count(),
        points,
        massless,
        actuated: Vec::new(),
        native: Native::default(),
        identity: Identity::of(&description),
        description,
    };
    model.find_actuated();
    Ok(model)
}

/// See [`Model::first_angle`]. Quaternion joints have no angle, so their index is arbitrary.
fn first_angle(bodies: &[Body], nq: usize) -> Option<usize> {
    let first = nq.checked_sub(bodies.len())?;
    let in_line = |(i, body): (usize, &Body)| body.motion.nv() > 1 || body.q_index == first + i;
    bodies.iter().enumerate().all(in_line).then_some(first)
}

struct Compiler<'a> {
    description: &'a RobotDescription,
    link_index: HashMap<&'a str, usize>,
    links: Vec<PlacedLink>,
    /// For each link, the joint of which it is the child.
    parent_joints: Vec<Option<usize>>,
    joints: Vec<Joint>,
    bodies: Vec<Body>,
    /// Whether each body can slide far from its parent.
    travels: Vec<bool>,
    /// The total mass properties of each body, in its rotated frame.
    masses: Vec<Option<MassProperties>>,
    dofs: Vec<Dof>,
    /// For each moving joint of the description: its first tree DoF and its entry in `joints`.
    placed: HashMap<&'a str, (usize, usize)>,
    nq: usize,
    nv: usize,
    has_mimic: bool,
}

impl<'a> Compiler<'a> {
    fn new(description: &'a RobotDescription) -> Self {
        let link_index =
            description.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
        Self {
            description,
            link_index,
            links: vec![PlacedLink { body: None, body_from_link: Pose::IDENTITY }; description.links.len()],
            parent_joints: vec![None; description.links.len()],
            joints: Vec::new(),
            bodies: Vec::new(),
            travels: Vec::new(),
            masses: Vec::new(),
            dofs: Vec::new(),
            placed: HashMap::new(),
            nq: 0,
            nv: 0,
            has_mimic: false,
        }
    }

    fn place_root(&mut self, root: usize) {
        if self.description.base == Base::Floating {
            let child = &self.description.links[root].name;
            let name = self.description.floating_base_name();
            let joint = JointDescription::new(name, JointKind::Floating, "world", child, Pose::IDENTITY);
            let world = PlacedLink { body: None, body_from_link: Pose::IDENTITY };
            self.move_link(&joint, world, root);
        }
        self.gather_mass(root);
    }

    /// Places the child of a joint and returns its link index.
    fn place_joint(&mut self, joint: &'a JointDescription) -> usize {
        let parent = self.links[self.link_index[joint.parent.as_str()]];
        let child = self.link_index[joint.child.as_str()];
        if joint.kind.nv() == 0 {
            let body_from_link = parent.body_from_link.compose(&joint.parent_from_joint);
            self.links[child] = PlacedLink { body: parent.body, body_from_link };
            self.push_joint(joint, child, (0, 0));
        } else {
            self.placed.insert(&joint.name, (self.dofs.len(), self.joints.len()));
            self.move_link(joint, parent, child);
        }
        self.gather_mass(child);
        child
    }

    /// Adds one body for each DoF in series; the last one has the child link.
    fn move_link(&mut self, joint: &JointDescription, parent: PlacedLink, child: usize) {
        let parent_from_joint = parent.body_from_link.compose(&joint.parent_from_joint);
        // Each element: the motion, and the rotation C of the joint's frame that aligns its axis with z.
        let series: Vec<(PrimitiveJoint, Pose)> = match joint.kind {
            JointKind::Fixed => unreachable!("fixed joints move nothing"),
            JointKind::Revolute { axis } | JointKind::Continuous { axis } => {
                vec![(PrimitiveJoint::Revolute, z_onto(axis))]
            }
            JointKind::Prismatic { axis } => vec![(PrimitiveJoint::Prismatic, z_onto(axis))],
            JointKind::Helical { axis, pitch } => vec![(PrimitiveJoint::Helical(pitch), z_onto(axis))],
            JointKind::Universal { first, second } => {
                vec![(PrimitiveJoint::Revolute, z_onto(first)), (PrimitiveJoint::Revolute, z_onto(second))]
            }
            JointKind::Planar { normal } => {
                let triad = z_onto(normal);
                let [x, y] = [0, 1].map(|column| triad.rotation.map(|row| row[column]));
                vec![
                    (PrimitiveJoint::Prismatic, z_onto(x)),
                    (PrimitiveJoint::Prismatic, z_onto(y)),
                    (PrimitiveJoint::Revolute, triad),
                ]
            }
            JointKind::Spherical => vec![(PrimitiveJoint::Spherical, Pose::IDENTITY)],
            JointKind::Floating => vec![(PrimitiveJoint::Floating, Pose::IDENTITY)],
        };
        let (nq, nv) = if joint.mimic.is_some() { (0, 0) } else { (joint.kind.nq(), joint.kind.nv()) };
        let mut placed = PlacedLink { body: parent.body, body_from_link: parent_from_joint };
        for (k, (motion, turn)) in series.into_iter().enumerate() {
            let parent_from_body = placed.body_from_link.compose(&turn);
            let body = self.bodies.len();
            let first = self.dofs.len();
            for i in 0..motion.nv() {
                self.dofs.push(Dof {
                    // Only elements of one DoF come in series, so element k starts at coordinate k.
                    coordinate: self.nv + k + i,
                    ratio: 1.0,
                    offset: 0.0,
                    body,
                    joint: self.joints.len(), // pushed below
                    end: 0,                   // set by `number_subtrees`
                    passive: joint.elastic_forces(),
                });
            }
            self.bodies.push(Body {
                parent: placed.body.unwrap_or(WORLD),
                motion,
                point: 0, // this and the next three set by `choose_points`
                tree: 0,
                is_point: false,
                shifts_reference_point: false,
                q_index: self.nq + k,
                dof: first,
                rotation: padded_columns(parent_from_body.rotation),
                translation: padded(parent_from_body.translation),
                mass: 0.0,
                first_moment: [0.0; 4],
                inertia: [[0.0; 4]; 3],
                second_moment: [[0.0; 4]; 3],
                link: child,
                body_from_link: turn.inverse(),
            });
            self.masses.push(None);
            self.travels.push(travels_far(motion, &joint.limits));
            placed = PlacedLink { body: Some(body), body_from_link: turn.inverse() };
        }
        self.links[child] = placed;
        self.push_joint(joint, child, (nq, nv));
        self.nq += nq;
        self.nv += nv;
    }

    fn push_joint(&mut self, joint: &JointDescription, child: usize, (nq, nv): (usize, usize)) {
        let index = self.joints.len();
        let parent_link = self.link_index.get(joint.parent.as_str()); // missing for a floating base
        let parent_joint = parent_link.and_then(|&link| self.parent_joints[link]);
        self.parent_joints[child] = Some(index);
        self.joints.push(Joint {
            index,
            name: joint.name.clone(),
            kind: joint.kind,
            parent_link: joint.parent.clone(),
            child_link: joint.child.clone(),
            parent_joint,
            q_index: self.nq,
            nq,
            v_index: self.nv,
            nv,
            mimic: joint.mimic.clone(),
            limits: joint.limits,
            passive: joint.elastic_forces(),
        });
    }

    fn gather_mass(&mut self, link: usize) {
        let PlacedLink { body: Some(body), body_from_link } = self.links[link] else { return };
        let Some(properties) = &self.description.links[link].mass_properties else { return };
        let r = &body_from_link.rotation;
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| r[i][j]));
        let moved = properties.transformed(&rotation, &Vector3::from(body_from_link.translation));
        let slot = &mut self.masses[body];
        *slot = Some(match slot.take() {
            Some(gathered) => gathered.combine(&moved),
            None => moved,
        });
    }

    /// Sets the coordinate of each mimic joint to its leader's, through chains of mimic joints.
    fn resolve_followers(&mut self, tree: &Tree) {
        for &mimic_joint in &tree.mimic_joints {
            let joint = &self.description.joints[mimic_joint];
            let mimic = joint.mimic.as_ref().expect("listed as a mimic joint");
            let (leader_dof, leader_joint) = self.placed[mimic.joint.as_str()];
            let (dof, _) = self.placed[joint.name.as_str()];
            // q = k (k' q' + c') + c. Leaders come before their mimic joints in `tree.mimic_joints`.
            let leader = self.dofs[leader_dof];
            let mimic_joint = &mut self.dofs[dof];
            mimic_joint.coordinate = leader.coordinate;
            mimic_joint.ratio = mimic.ratio * leader.ratio;
            mimic_joint.offset = mimic.ratio * leader.offset + mimic.offset;
            let body = self.dofs[dof].body;
            self.bodies[body].q_index = self.bodies[leader.body].q_index;
            debug_assert!(self.joints[leader_joint].nv <= 1);
            self.has_mimic = true;
        }
    }

    /// In depth-first order, a subtree's DoFs end where those of the next sibling (or of an ancestor's)
    /// begin.
    fn number_subtrees(&mut self) {
        let mut end: Vec<usize> = self.bodies.iter().map(|body| body.dof + body.motion.nv()).collect();
        for (i, body) in self.bodies.iter().enumerate().rev() {
            if body.parent != WORLD {
                end[body.parent] = end[body.parent].max(end[i]);
            }
        }
        for dof in &mut self.dofs {
            dof.end = end[dof.body];
        }
    }

    /// Writes m, h, I and ∫rrᵀdm of each body.
    fn finish_inertias(&mut self) {
        for (body, properties) in self.bodies.iter_mut().zip(&self.masses) {
            let Some(properties) = properties else { continue };
            let c = properties.center_of_mass();
            let i = properties.inertia_about_origin();
            let half_trace = 0.5 * i.trace();
            body.mass = properties.mass();
            body.first_moment = padded((c * properties.mass()).into());
            let symmetric = |m: nalgebra::Matrix3<f64>| padded_columns(m.transpose().data.0);
            body.inertia = symmetric(i);
            body.second_moment = symmetric(nalgebra::Matrix3::from_diagonal_element(half_trace) - i);
        }
    }

    /// The joints with a coordinate whose motion has no kinetic energy in any pose, so that M is singular in
    /// all of them.
    fn massless_joints(&self, rotors: &[Rotor]) -> Vec<usize> {
        let count = self.bodies.len();
        // For each body's subtree. Values are as in the description, of either sign.
        let (mut has_mass, mut has_moments) = (vec![false; count], vec![false; count]);
        let mut is_leaf = vec![true; count];
        let mut moves_inertia = vec![false; count];
        for (index, body) in self.bodies.iter().enumerate().rev() {
            has_mass[index] |= body.mass != 0.0;
            has_moments[index] |= body.inertia.as_flattened().iter().any(|&x| x != 0.0);
            if body.parent != WORLD {
                has_mass[body.parent] |= has_mass[index];
                has_moments[body.parent] |= has_moments[index];
                is_leaf[body.parent] = false;
            }
            let what_it_moves = (has_mass[index], has_moments[index]);
            moves_inertia[index] = self.moves_inertia(index, what_it_moves, is_leaf[index]);
        }
        // Mimic joints share their leader's coordinate, so one with inertia is enough.
        let mut costs_energy = vec![false; self.nv];
        for dof in &self.dofs {
            costs_energy[dof.coordinate] |= moves_inertia[dof.body] && dof.ratio != 0.0;
        }
        for (coordinate, root) in rotors.iter().flat_map(|rotor| rotor.roots(&self.dofs)) {
            costs_energy[coordinate] |= root > 0.0;
        }
        let is_massless = |joint: &Joint| costs_energy[joint.v()].iter().any(|costs| !costs);
        self.joints.iter().enumerate().filter(|(_, joint)| is_massless(joint)).map(|(i, _)| i).collect()
    }

    /// Whether motion of a body's DoFs has kinetic energy in some pose.
    fn moves_inertia(&self, index: usize, (has_mass, has_moments): (bool, bool), is_leaf: bool) -> bool {
        let body = &self.bodies[index];
        let PassiveForces { armature, .. } = self.dofs[body.dof].passive;
        if armature > 0.0 {
            return true;
        }
        let smallest =
            |m: Matrix3<f64>| m.symmetric_eigenvalues().iter().fold(f64::INFINITY, |s, x| x.abs().min(s));
        let about_some_axis = |properties: &MassProperties| {
            let origin = properties.inertia_about_origin();
            let moment = match body.motion.chart() {
                Chart::Line => origin[(2, 2)].abs(),
                Chart::Rotation => smallest(origin),
                Chart::Placement => smallest(properties.inertia_about_center_of_mass()),
            };
            moment > 1e-14 * origin.trace().abs()
        };
        // Only a leaf's inertia is the same in every pose.
        let turns = !is_leaf || self.masses[index].as_ref().is_some_and(about_some_axis);
        let turning = (has_mass || has_moments) && turns;
        let sliding = body.motion.slides() && has_mass;
        match body.motion.chart() {
            // One DoF: the inertia may resist its translation or its rotation.
            Chart::Line => sliding || (body.motion.turns() && turning),
            Chart::Rotation => turning,
            // Six DoFs, each of which must move inertia.
            Chart::Placement => has_mass && turns,
        }
    }
}
