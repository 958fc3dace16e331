//! Conservation of the linear momentum of free bodies.
//!
//! A body without a connection to the world, together with its subtree, satisfies m Δċ = ∫ΣF dt. A step of
//! order 2 in coordinates whose axes rotate with the body satisfies that only to O(h³), and to O(h) for an
//! impulse. Each step therefore ends with a correction of the translational velocity of the whole tree, which
//! restores this momentum. Joint rates, angular velocities and relative velocities within the tree do not
//! change. Sliding joints on the world without forces that depend on their own motion are corrected along
//! their axes.

mod variation;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::joint::{Chart, Position};
use robot_dynamics_core::kinematics::world_frame::{compute_columns, compute_twists};
use robot_dynamics_core::model::{Body, WORLD};
use robot_dynamics_core::spatial::transform::Transform;
use robot_dynamics_core::workspace::compiled_once::{compiled_once, run};
use robot_dynamics_core::workspace::tree::{TreeMemory, TreeStorage};
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::algebra::{M3, V3};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use super::joints::Joints;

pub(super) use self::variation::TargetChanges;

/// A cosine of the angle between two slides' axes below this is rounding.
const SQUARE: f64 = 1e-12;

clone_in_place! {
    /// The bodies that can translate freely, and their momenta in a step.
    #[derive(Debug)]
    pub(super) struct FreeTranslations {
        roots: Vec<Root>,
        /// The momentum of each body with its subtree, along the world's axes \[N·s\].
        momenta: Vec<[f64; 3]>,
    }
}

/// A body that is free of the world or connected to it by slides only.
#[derive(Clone, Debug)]
struct Root {
    body: usize,
    /// The first of its coordinates in v, and the number of coordinates that translate it: one or three.
    first: usize,
    count: usize,
    /// The mass of the body with its subtree \[kg\].
    mass: f64,
    /// The axes of its parent, in the world.
    carrier: Matrix3<f64>,
    /// The target momentum at the end of the step \[N·s\].
    target: Vector3<f64>,
}

/// The axes in the world of a body on slides, and the directions of the slides.
#[derive(Clone)]
struct Slides {
    rotation: Matrix3<f64>,
    along: Vec<Vector3<f64>>,
}

impl FreeTranslations {
    pub(super) fn new(model: &Model) -> Self {
        let bodies = &model.bodies;
        let mut mass: Vec<f64> = bodies.iter().map(|body| body.mass).collect();
        let mut turns: Vec<bool> = bodies.iter().map(|body| body.motion.turns()).collect();
        for (i, body) in bodies.iter().enumerate().rev().filter(|(_, body)| body.parent != WORLD) {
            mass[body.parent] += mass[i];
            turns[body.parent] |= turns[i];
        }
        let mut uses = vec![0; model.nv];
        model.dofs.iter().for_each(|dof| uses[dof.coordinate] += 1);
        let mut sliding: Vec<Option<Slides>> = vec![None; bodies.len()];
        let mut roots = Vec::new();
        for (i, body) in bodies.iter().enumerate() {
            let at_world = Some(Slides { rotation: Matrix3::identity(), along: Vec::new() });
            let carrier = if body.parent == WORLD { at_world } else { sliding[body.parent].clone() };
            let Some(Slides { rotation: carrier, along: mut axes }) = carrier else { continue };
            let is_slide = !body.motion.turns() && body.motion.nv() == 1;
            let is_free = body.motion.chart() == Chart::Placement;
            let own = &model.dofs[body.dof..body.dof + body.motion.nv()];
            if !(is_slide || (is_free && axes.is_empty())) {
                continue;
            }
            let count = if is_free { 3 } else { 1 };
            let is_plain = own[..count].iter().all(|dof| {
                let is_tied = |(coordinate, _): (usize, f64)| coordinate == dof.coordinate;
                dof.ratio == 1.0
                    && dof.passive.armature == 0.0
                    && dof.passive.stiffness == 0.0
                    && uses[dof.coordinate] == 1
                    && !model.rotors.iter().any(|rotor| rotor.roots(&model.dofs).any(is_tied))
            });
            if is_slide {
                let turned = carrier
                    * rotation_of(&Transform::<f64> {
                        rotation: M3::constant(&body.rotation),
                        translation: V3::zero(),
                    });
                let axis = turned.column(2).into_owned();
                let is_square = axes.iter().all(|other: &Vector3<f64>| other.dot(&axis).abs() < SQUARE);
                if !is_square {
                    continue;
                }
                axes.push(axis);
                sliding[i] = Some(Slides { rotation: turned, along: axes });
            }
            // Bodies that only slide conserve their momentum without a correction.
            if is_plain && turns[i] && mass[i] > 0.0 {
                let (first, target) = (own[0].coordinate, Vector3::zeros());
                roots.push(Root { body: i, first, count, mass: mass[i], carrier, target });
            }
        }
        // Correct a child before its parent.
        roots.reverse();
        let momenta = if roots.is_empty() { Vec::new() } else { vec![[0.0; 3]; bodies.len()] };
        Self { roots, momenta }
    }

    /// Whether no body can translate freely.
    pub(super) fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Starts a step of h at (q, v), and adds the impulse of gravity.
    pub(super) fn begin(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) {
        self.find_momenta(model, workspace, (q, v));
        let gravity = Vector3::from(model.gravity());
        for root in &mut self.roots {
            root.target = Vector3::from(self.momenta[root.body]) + gravity * (h * root.mass);
        }
    }

    /// Adds generalized impulses at the configuration q.
    pub(super) fn add(&mut self, model: &Model, q: &[f64], impulse: impl Fn(usize) -> f64) {
        for root in &mut self.roots {
            let body = &model.bodies[root.body];
            let axes = root.axes(body, q);
            for k in 0..root.count {
                root.target += axis_of(&axes, root.count, k) * impulse(root.first + k);
            }
        }
    }

    /// Translates the state at q at the end of the step, so that its momentum equals the sum of the impulses.
    pub(super) fn restore(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        joints: &Joints,
        q: &[f64],
        v: &mut [f64],
    ) {
        self.find_momenta(model, workspace, (q, v));
        for root in &self.roots {
            let coordinates = root.first..root.first + root.count;
            if coordinates.clone().any(|k| joints.resists(k)) {
                continue;
            }
            let missing = root.target - Vector3::from(self.momenta[root.body]);
            let axes = root.axes(&model.bodies[root.body], q);
            for (k, coordinate) in coordinates.enumerate() {
                v[coordinate] += axis_of(&axes, root.count, k).dot(&missing) / root.mass;
            }
        }
    }

    fn find_momenta(&mut self, model: &Model, workspace: &mut Workspace, (q, v): (&[f64], &[f64])) {
        if !self.is_empty() {
            let momenta = self.momenta.as_flattened_mut();
            run(&mut workspace.tree, CarriedMomenta { model, q, v, momenta });
        }
    }
}

/// The linear momentum of each body with its subtree, along the world's axes, three numbers per body \[N·s\].
pub(crate) struct CarriedMomenta<'a, S> {
    model: &'a Model,
    q: &'a [S],
    v: &'a [S],
    momenta: &'a mut [S],
}

compiled_once!(CarriedMomenta);

impl<S: Scalar> Kernel<TreeStorage, S> for CarriedMomenta<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, momenta } = self;
        compute_columns(model, tree, N::view(q));
        compute_twists(model, tree, N::view(v));
        let (momenta, _) = N::view_mut(momenta).as_chunks_mut::<3>();
        for (i, body) in model.bodies.iter().enumerate() {
            let (place, twist) = (&tree.world.pose[i], &tree.world.twist[i]);
            let mass = N::from_f64(body.mass);
            let turned = place.rotation * V3::constant(&body.first_moment);
            let first_moment = turned.add_scaled(mass, place.translation);
            momenta[i] = twist.angular.cross(first_moment).add_scaled(mass, twist.linear).array();
        }
        for (i, body) in model.bodies.iter().enumerate().rev().filter(|(_, body)| body.parent != WORLD) {
            let own = momenta[i];
            for (sum, own) in momenta[body.parent].iter_mut().zip(own) {
                *sum += own;
            }
        }
    }
}

impl Root {
    /// The world axes of its coordinates: all columns, or the last column for a slide.
    fn axes(&self, body: &Body, q: &[f64]) -> Matrix3<f64> {
        let rest = Transform {
            rotation: M3::constant(&body.rotation),
            translation: V3::constant(&body.translation),
        };
        let position = Position { angle: 0.0, sine: 0.0, cosine: 1.0, q, start: body.q_index };
        self.carrier * rotation_of(&body.motion.place(&rest, &position))
    }
}

fn axis_of(axes: &Matrix3<f64>, count: usize, k: usize) -> Vector3<f64> {
    axes.column(if count == 1 { 2 } else { k }).into_owned()
}

fn rotation_of(place: &Transform<f64>) -> Matrix3<f64> {
    let [x, y, z] = place.rotation.rows();
    Matrix3::from_fn(|i, j| [x, y, z][i][j])
}
