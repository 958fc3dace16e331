//! The pose of each body, and its motion by each degree of freedom, in the world.

use crate::clone_in_place::clone_in_place;
use crate::kinematics::placement::place_all_in_world;
use crate::model::{Dof, WORLD};
use crate::spatial::transform::Transform;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};
use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_number::algebra::V3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

/// A velocity and ω, or a force and its moment.
pub type Twist = [Vector3<f64>; 2];

/// A number that closed formulas over vectors accept: `f64` or dual numbers.
pub trait VectorNumber: Scalar + PartialEq {}

impl<S: Scalar + PartialEq> VectorNumber for S {}

/// The motion of a body's origin in world axes.
#[derive(Clone, Copy, Debug)]
pub struct BodyMotion<S = f64> {
    pub velocity: Vector3<S>,
    /// ω.
    pub spin: Vector3<S>,
    pub acceleration: Vector3<S>,
    /// ω̇.
    pub spin_rate: Vector3<S>,
}

/// At rest.
impl Default for BodyMotion {
    fn default() -> Self {
        let zero = Vector3::zeros();
        Self { velocity: zero, spin: zero, acceleration: zero, spin_rate: zero }
    }
}

impl<S: VectorNumber> BodyMotion<S> {
    /// The motion of a point of the body, at this distance from the origin in world axes.
    #[must_use]
    pub fn at(&self, lever: &Vector3<S>) -> Self {
        let Self { velocity, spin, acceleration, spin_rate } = *self;
        let carried = spin.cross(lever);
        Self {
            velocity: velocity + carried,
            acceleration: acceleration + spin_rate.cross(lever) + spin.cross(&carried),
            spin,
            spin_rate,
        }
    }

    /// The acceleration of d in axes that turn with the body, d̈ − ω̇ × d − 2 ω × ḋ + ω × (ω × d), in world
    /// axes.
    pub fn relative_acceleration(&self, [d, rate, acceleration]: [&Vector3<S>; 3]) -> Vector3<S> {
        let (spin, two) = (&self.spin, S::from_f64(2.0));
        acceleration - self.spin_rate.cross(d) - spin.cross(rate) * two + spin.cross(&spin.cross(d))
    }
}

clone_in_place! {
    /// The bodies in one configuration.
    #[derive(Debug)]
    pub struct Placement {
        /// `world_from_body`: R by rows, then p.
        bodies: Vec<[f64; 12]>,
        /// The velocity of the body's origin, and ω, for each degree of freedom of the tree.
        columns: Vec<[f64; 6]>,
        /// The configuration; NaN before the first call.
        q: Vec<f64>,
    }
}

impl Placement {
    pub fn new(model: &Model) -> Self {
        let bodies = model.bodies.len();
        Self {
            bodies: vec![[0.0; 12]; bodies],
            columns: vec![[0.0; 6]; model.dofs.len()],
            q: vec![f64::NAN; model.nq],
        }
    }

    /// Computes the placement at q.
    pub fn set(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.q.copy_from_slice(q);
        let Self { bodies, columns, .. } = self;
        run(&mut workspace.tree, PlacedBodies { model, q, bodies, columns });
    }

    /// Calls `with` on this placement with one body moved relative to all others: its point `at` by `shift`,
    /// and the body about it by the rotation vector `turn`.
    pub fn with_moved<R>(
        &mut self,
        body: usize,
        at: &Vector3<f64>,
        [shift, turn]: &Twist,
        with: impl FnOnce(&Self) -> R,
    ) -> R {
        let before = self.bodies[body];
        let (rotation, origin) = self.body(body);
        let turn = Rotation3::new(*turn);
        let (rotation, origin) = (turn * rotation, at + shift + turn * (origin - at));
        for i in 0..3 {
            for j in 0..3 {
                self.bodies[body][3 * i + j] = rotation[(i, j)];
            }
            self.bodies[body][9 + i] = origin[i];
        }
        let result = with(self);
        self.bodies[body] = before;
        result
    }

    /// Whether this is the placement at q.
    pub fn is_at(&self, q: &[f64]) -> bool {
        self.q == q
    }

    /// R and p of a body, or of the world.
    pub fn body(&self, body: usize) -> (Matrix3<f64>, Vector3<f64>) {
        if body == WORLD {
            return (Matrix3::identity(), Vector3::zeros());
        }
        let [a, b, c, d, e, f, g, h, i, x, y, z] = self.bodies[body];
        (Matrix3::new(a, b, c, d, e, f, g, h, i), Vector3::new(x, y, z))
    }

    /// Rᵀn of a body, and n·p: a direction in the body's axes, and the distance of its origin along it.
    #[inline]
    pub fn along(&self, body: usize, n: &Vector3<f64>) -> (Vector3<f64>, f64) {
        if body == WORLD {
            return (*n, 0.0);
        }
        let [a, b, c, d, e, f, g, h, i, x, y, z] = self.bodies[body];
        let row = |k: usize| n.x * [a, b, c][k] + n.y * [d, e, f][k] + n.z * [g, h, i][k];
        (Vector3::new(row(0), row(1), row(2)), n.x * x + n.y * y + n.z * z)
    }

    /// Calls `visit` with each degree of freedom that moves a body, from its own last one to the root's
    /// first. The other arguments are the velocity of a point of the body and ω per unit rate.
    #[inline]
    pub fn each_motion(
        &self,
        model: &Model,
        body: usize,
        point: Vector3<f64>,
        visit: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        self.each_motion_on(model, [body, WORLD], point, visit);
    }

    /// The same, up to a body that carries it, without that body's own degrees of freedom.
    #[inline]
    pub fn each_motion_on(
        &self,
        model: &Model,
        [body, carrier]: [usize; 2],
        point: Vector3<f64>,
        mut visit: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        let mut at = body;
        while at != carrier {
            let lever = point - self.origin(at);
            for (dof, [velocity, spin]) in self.dofs(model, at).rev() {
                visit(dof, velocity + spin.cross(&lever), spin);
            }
            at = model.bodies[at].parent;
        }
    }

    /// The velocity of each body's origin, and ω.
    pub fn velocities(&self, model: &Model, v: &[f64], to: &mut Vec<Twist>) {
        to.clear();
        for (i, body) in model.bodies.iter().enumerate() {
            let [mut velocity, mut spin] = [Vector3::zeros(); 2];
            if body.parent != WORLD {
                [velocity, spin] = to[body.parent];
                velocity += spin.cross(&(self.origin(i) - self.origin(body.parent)));
            }
            for (dof, [u, w]) in self.dofs(model, i) {
                let rate = dof.ratio * v[dof.coordinate];
                velocity += u * rate;
                spin += w * rate;
            }
            to.push([velocity, spin]);
        }
    }

    /// The motion of each body at v̇ = 0.
    pub fn motions(&self, model: &Model, v: &[f64]) -> Vec<BodyMotion> {
        self.accelerated_motions(model, v, None)
    }

    /// The motion of each body; `None` means v̇ = 0.
    pub fn accelerated_motions(&self, model: &Model, v: &[f64], a: Option<&[f64]>) -> Vec<BodyMotion> {
        let mut motions: Vec<BodyMotion> = Vec::with_capacity(model.bodies.len());
        for (i, body) in model.bodies.iter().enumerate() {
            let carrier = if body.parent == WORLD { BodyMotion::default() } else { motions[body.parent] };
            let lever = if body.parent == WORLD {
                Vector3::zeros()
            } else {
                self.origin(i) - self.origin(body.parent)
            };
            let [mut moved, mut turned] = [Vector3::zeros(); 2];
            let mut driven = [Vector3::zeros(); 2];
            for (dof, [u, w]) in self.dofs(model, i) {
                let rate = dof.ratio * v[dof.coordinate];
                moved += u * rate;
                turned += w * rate;
                if let Some(a) = a {
                    let rate = dof.ratio * a[dof.coordinate];
                    driven[0] += u * rate;
                    driven[1] += w * rate;
                }
            }
            let BodyMotion { velocity, spin, acceleration, spin_rate } = carrier;
            let carried = spin.cross(&lever);
            let own_spin = spin + turned;
            let mut motion = BodyMotion {
                velocity: velocity + carried + moved,
                spin: own_spin,
                // The columns of a joint are constant in its body, and turn with it.
                acceleration: acceleration
                    + spin_rate.cross(&lever)
                    + spin.cross(&(carried + moved))
                    + own_spin.cross(&moved),
                spin_rate: spin_rate + own_spin.cross(&turned),
            };
            if a.is_some() {
                motion.acceleration += driven[0];
                motion.spin_rate += driven[1];
            }
            motions.push(motion);
        }
        motions
    }

    /// Adds to `forces` the generalized forces of a force on each body, with its moment about the world's
    /// origin. They are passed on to the bodies that carry the bodies.
    pub fn add_forces(&self, model: &Model, wrenches: &mut [Twist], forces: &mut [f64]) {
        for i in (0..wrenches.len()).rev() {
            let [force, moment] = wrenches[i];
            let about = moment - self.origin(i).cross(&force);
            for (dof, [u, w]) in self.dofs(model, i) {
                forces[dof.coordinate] += dof.ratio * (u.dot(&force) + w.dot(&about));
            }
            let parent = model.bodies[i].parent;
            if parent != WORLD {
                wrenches[parent][0] += force;
                wrenches[parent][1] += moment;
            }
        }
    }

    /// The origin of a body's frame.
    pub fn origin(&self, body: usize) -> Vector3<f64> {
        let [.., x, y, z] = self.bodies[body];
        Vector3::new(x, y, z)
    }

    /// A body's own degrees of freedom, with the velocity of its origin and ω.
    #[inline]
    fn dofs<'a>(
        &'a self,
        model: &'a Model,
        body: usize,
    ) -> impl DoubleEndedIterator<Item = (&'a Dof, Twist)> {
        let body = &model.bodies[body];
        let dofs = body.dof..body.dof + body.motion.nv();
        let columns = self.columns[dofs.clone()].iter();
        model.dofs[dofs]
            .iter()
            .zip(columns.map(|&[a, b, c, d, e, f]| [Vector3::new(a, b, c), Vector3::new(d, e, f)]))
    }
}

/// The arguments of [`Placement::set`].
pub struct PlacedBodies<'a, S> {
    model: &'a Model,
    q: &'a [S],
    bodies: &'a mut [[S; 12]],
    columns: &'a mut [[S; 6]],
}

compiled_once!(PlacedBodies);

impl<S: Scalar> Kernel<TreeStorage, S> for PlacedBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, bodies, columns } = self;
        place_all_in_world(model, tree, N::view(q));
        for (i, body) in model.bodies.iter().enumerate() {
            let world = &tree.world.pose[i];
            let ([x, y, z], p) = (world.rotation.rows(), world.translation.array());
            for (to, from) in bodies[i].iter_mut().zip([x, y, z, p].into_iter().flatten()) {
                *to = from.value();
            }
            let at_origin = Transform { rotation: world.rotation, translation: V3::zero() };
            for k in 0..body.motion.nv() {
                let column = body.motion.screw(k, &at_origin);
                let parts = column.linear.array().into_iter().chain(column.angular.array());
                for (to, from) in columns[body.dof + k].iter_mut().zip(parts) {
                    *to = from.value();
                }
            }
        }
    }
}
