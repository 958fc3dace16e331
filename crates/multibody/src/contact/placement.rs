//! Where each body is, and how each freedom moves it, in the world.

use dynamics::Scalar;
use nalgebra::{Matrix3, Vector3};
use number::View;
use number::dispatch::{Hardware, Kernel};

use super::coordinates_of;
use crate::clone_in_place::clone_in_place;
use crate::model::{Dof, WORLD};
use crate::scratch::compiled_once::{OverNumber, compiled_once, run};
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::V3;
use crate::spatial::screw::Place;
use crate::stages::place::place_all_in_world;
use crate::{Frame, FrameId, Model, Workspace};

/// A velocity and ω, or a force and its moment.
pub(super) type Twist = [Vector3<f64>; 2];

clone_in_place! {
    /// The bodies in one configuration.
    #[derive(Debug)]
    pub(super) struct Placement {
        /// `world_from_body`: R by rows, then p.
        bodies: Vec<[f64; 12]>,
        /// The velocity of the body's origin, and ω, for each freedom of the tree.
        columns: Vec<[f64; 6]>,
        paths: Vec<Vec<usize>>,
        /// The configuration; NaN before the first.
        q: Vec<f64>,
    }
}

impl Placement {
    pub(super) fn new(model: &Model) -> Self {
        let bodies = model.bodies.len();
        Self {
            bodies: vec![[0.0; 12]; bodies],
            columns: vec![[0.0; 6]; model.dofs.len()],
            paths: (0..bodies).map(|body| coordinates_of(model, body)).collect(),
            q: vec![f64::NAN; model.nq],
        }
    }

    /// Takes the configuration q.
    pub(super) fn set(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.q.copy_from_slice(q);
        let Self { bodies, columns, .. } = self;
        run(&mut workspace.tree, PlacedBodies { model, q, bodies, columns });
    }

    /// Whether it is of the configuration q.
    pub(super) fn is_at(&self, q: &[f64]) -> bool {
        self.q == q
    }

    /// R and p of a body, or of the world.
    pub(super) fn body(&self, body: usize) -> (Matrix3<f64>, Vector3<f64>) {
        if body == WORLD {
            return (Matrix3::identity(), Vector3::zeros());
        }
        let [a, b, c, d, e, f, g, h, i, x, y, z] = self.bodies[body];
        (Matrix3::new(a, b, c, d, e, f, g, h, i), Vector3::new(x, y, z))
    }

    /// Rᵀn of a body, and n·p: how it sees a direction, and how far along that its origin is.
    #[inline]
    pub(super) fn along(&self, body: usize, n: &Vector3<f64>) -> (Vector3<f64>, f64) {
        if body == WORLD {
            return (*n, 0.0);
        }
        let [a, b, c, d, e, f, g, h, i, x, y, z] = self.bodies[body];
        let row = |k: usize| n.x * [a, b, c][k] + n.y * [d, e, f][k] + n.z * [g, h, i][k];
        (Vector3::new(row(0), row(1), row(2)), n.x * x + n.y * y + n.z * z)
    }

    /// A frame's axes and origin.
    pub(super) fn frame(&self, model: &Model, frame: FrameId) -> (Matrix3<f64>, Vector3<f64>) {
        let Frame { body, body_from_frame, .. } = model.frame_of(frame);
        let turn = Matrix3::from_fn(|i, j| body_from_frame.rotation[i][j]);
        let at = Vector3::from(body_from_frame.translation);
        let (rotation, origin) =
            body.map_or_else(|| (Matrix3::identity(), Vector3::zeros()), |b| self.body(b));
        (rotation * turn, origin + rotation * at)
    }

    /// Calls `look` with each freedom that moves a body, from its own last one to the root's first, and the velocity that it gives to a point of the body,
    /// and ω.
    #[inline]
    pub(super) fn each_motion(
        &self,
        model: &Model,
        body: usize,
        point: Vector3<f64>,
        look: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        self.each_motion_on(model, [body, WORLD], point, look);
    }

    /// The same, up to a body that carries it, whose own freedoms are left out.
    #[inline]
    pub(super) fn each_motion_on(
        &self,
        model: &Model,
        [body, carrier]: [usize; 2],
        point: Vector3<f64>,
        mut look: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        let mut at = body;
        while at != carrier {
            let lever = point - self.origin(at);
            for (dof, [velocity, spin]) in self.freedoms(model, at).rev() {
                look(dof, velocity + spin.cross(&lever), spin);
            }
            at = model.bodies[at].parent;
        }
    }

    /// Velocity of each body's origin, and ω.
    pub(super) fn velocities(&self, model: &Model, v: &[f64], to: &mut Vec<Twist>) {
        to.clear();
        for (i, body) in model.bodies.iter().enumerate() {
            let [mut velocity, mut spin] = [Vector3::zeros(); 2];
            if body.parent != WORLD {
                [velocity, spin] = to[body.parent];
                velocity += spin.cross(&(self.origin(i) - self.origin(body.parent)));
            }
            for (dof, [u, w]) in self.freedoms(model, i) {
                let rate = dof.ratio * v[dof.coordinate];
                velocity += u * rate;
                spin += w * rate;
            }
            to.push([velocity, spin]);
        }
    }

    /// Adds to `forces` what a force on each body makes, with its moment about the world's origin. They are passed on to what carries the bodies.
    pub(super) fn add_forces(&self, model: &Model, wrenches: &mut [Twist], forces: &mut [f64]) {
        for i in (0..wrenches.len()).rev() {
            let [force, moment] = wrenches[i];
            let about = moment - self.origin(i).cross(&force);
            for (dof, [u, w]) in self.freedoms(model, i) {
                forces[dof.coordinate] += dof.ratio * (u.dot(&force) + w.dot(&about));
            }
            let parent = model.bodies[i].parent;
            if parent != WORLD {
                wrenches[parent][0] += force;
                wrenches[parent][1] += moment;
            }
        }
    }

    /// Where a body's frame is.
    pub(super) fn origin(&self, body: usize) -> Vector3<f64> {
        let [.., x, y, z] = self.bodies[body];
        Vector3::new(x, y, z)
    }

    /// A body's own freedoms, with the velocity of its origin and ω.
    #[inline]
    fn freedoms<'a>(
        &'a self,
        model: &'a Model,
        body: usize,
    ) -> impl DoubleEndedIterator<Item = (&'a Dof, Twist)> {
        let body = &model.bodies[body];
        let freedoms = body.dof..body.dof + body.motion.nv();
        let columns = self.columns[freedoms.clone()].iter();
        model.dofs[freedoms]
            .iter()
            .zip(columns.map(|&[a, b, c, d, e, f]| [Vector3::new(a, b, c), Vector3::new(d, e, f)]))
    }

    /// The coordinates that move a body, rising.
    pub(super) fn path(&self, body: usize) -> &[usize] {
        &self.paths[body]
    }
}

/// The arguments of [`Placement::set`].
pub(crate) struct PlacedBodies<'a, S> {
    model: &'a Model,
    q: &'a [S],
    bodies: &'a mut [[S; 12]],
    columns: &'a mut [[S; 6]],
}

compiled_once!(PlacedBodiesKind, PlacedBodies);

impl<S: Scalar> Kernel<OverNumber, S> for PlacedBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, bodies, columns } = self;
        place_all_in_world(model, tree, N::view(q));
        for (i, body) in model.bodies.iter().enumerate() {
            let world = &tree.screws.world[i];
            let ([x, y, z], p) = (world.rotation.rows(), world.translation.array());
            for (to, from) in bodies[i].iter_mut().zip([x, y, z, p].into_iter().flatten()) {
                *to = from.value();
            }
            let at_origin = Place { rotation: world.rotation, translation: V3::zero() };
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
