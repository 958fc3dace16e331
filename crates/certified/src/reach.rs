//! Proven bounds of where a frame can be.
//!
//! The positions of a frame relative to a body of its chain, for all angles of the joints beyond, are a set
//! with support function h. A joint turns and moves this set, so that the support function relative to the
//! parent is h'(m) = m · p + max over q of h(R(q)ᵀ m). It has two arguments whatever the number of joints, so
//! it is computed on a grid of directions, from the tip to the root.

use std::borrow::Cow;

use robot_dynamics_core::joint::PrimitiveJoint;
use robot_dynamics_core::model::{Body, WORLD};
use robot_dynamics_core::{FrameId, Model, Workspace, frame_pose};

use crate::linear::one_turn;
use crate::search::{SearchOptions, map_on_threads};
use crate::support::{Arc, Support, Vector, dot, vertices};
use crate::{EnclosureError, Interval};

/// An outer bound of the positions of a frame's origin in the world: a convex set that contains all of them.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{Interval, ReachableSet, SearchOptions};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let set = ReachableSet::new(&model, &[Interval::new(-3.2, 3.2)], tip, 64, &SearchOptions::default())?;
/// let highest = set.farthest([0.0, 0.0, 1.0]);
/// assert!(highest.proven >= 0.5 && highest.proven < 0.5 + 1e-3 && highest.attained > 0.5 - 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ReachableSet<'a> {
    model: Cow<'a, Model>,
    frame: FrameId,
    /// From the root to the tip.
    joints: Vec<ChainJoint>,
    /// The support functions relative to each body of the chain, from the root; the last is relative to the
    /// tip's body.
    supports: Vec<Support>,
    /// The position if the frame does not move.
    fixed: Vector,
}

/// A joint of the chain.
struct ChainJoint {
    body: Body,
    range: Interval,
    /// The interval of its coordinate.
    own: Interval,
    arc: Option<Arc>,
}

/// The farthest position in a direction.
#[derive(Clone, Debug)]
pub struct Farthest {
    /// n · p is at most this in all configurations.
    pub proven: f64,
    /// n · p at `q` is at least this.
    pub attained: f64,
    /// A configuration far in this direction.
    pub q: Vec<f64>,
}

impl<'a> ReachableSet<'a> {
    /// Computes the set for a box of configurations. `cells` is the number of the grid's steps along an edge
    /// of a cube, a power of two: with 64 the overestimate is about 0.1 % of the chain's length.
    ///
    /// An interrupt makes the bounds infinite.
    ///
    /// Mimic joints count as joints of their own, which makes the set larger. Revolute joints may have
    /// unbounded intervals.
    ///
    /// # Errors
    /// [`EnclosureError::Quaternions`] if a joint of the chain has a quaternion,
    /// [`EnclosureError::Unbounded`] if an interval is unbounded.
    ///
    /// # Panics
    /// If q has the wrong length, the frame belongs to another model, or `cells` is not a power of two
    /// above 1.
    pub fn new(
        model: &'a Model,
        q: &[Interval],
        frame: FrameId,
        cells: usize,
        options: &SearchOptions,
    ) -> Result<Self, EnclosureError> {
        assert_eq!(q.len(), model.nq(), "q has {} entries, but {} are needed", q.len(), model.nq());
        assert!(cells.is_power_of_two() && cells > 1, "{cells} is not a power of two above 1");
        let own = model.frame_of(frame);
        let mut joints = Vec::new();
        let mut at = own.body.unwrap_or(WORLD);
        while at != WORLD {
            joints.push(ChainJoint::new(model, &model.bodies[at], q, cells)?);
            at = model.bodies[at].parent;
        }
        joints.reverse();
        let fixed = own.body_from_frame.translation.map(Interval::from);
        let directions: Vec<Vector> = vertices(cells).into_iter().map(|v| v.map(Interval::from)).collect();
        let tip = directions.iter().map(|m| dot(*m, fixed).upper()).collect();
        let mut supports = vec![Support::new(cells, tip)];
        let mut workers = vec![(); options.thread_count()];
        for joint in joints.iter().skip(1).rev() {
            let beyond = &supports[supports.len() - 1];
            let bounds = map_on_threads(&mut workers, &directions, |(), m| {
                if options.is_interrupted() { f64::INFINITY } else { joint.bound(beyond, *m).0 }
            });
            supports.push(Support::new(cells, bounds));
        }
        supports.reverse();
        Ok(Self { model: Cow::Borrowed(model), frame, joints, supports, fixed })
    }

    /// The same set with a copy of the model, which it then owns.
    pub fn into_owned(self) -> ReachableSet<'static> {
        ReachableSet {
            model: Cow::Owned(self.model.into_owned()),
            frame: self.frame,
            joints: self.joints,
            supports: self.supports,
            fixed: self.fixed,
        }
    }

    /// A proven bound of n · p over all configurations, and a configuration near it. p is the frame's origin
    /// in the world \[m\].
    pub fn farthest(&self, direction: [f64; 3]) -> Farthest {
        let mut m = direction.map(Interval::from);
        let mut proven = dot(m, self.fixed).upper();
        let mut q: Vec<f64> = robot_dynamics_core::neutral(&self.model);
        for (k, (joint, support)) in self.joints.iter().zip(&self.supports).enumerate() {
            let (bound, position) = joint.bound(support, m);
            if k == 0 {
                proven = bound;
            }
            let dof = &self.model.dofs[joint.body.dof];
            let own = (position - dof.offset) / dof.ratio;
            q[joint.body.q_index] = own.clamp(joint.own.lower(), joint.own.upper());
            m = joint.direction_beyond(m, position);
        }
        let intervals: Vec<Interval> = q.iter().copied().map(Interval::from).collect();
        let pose = frame_pose(&self.model, &mut Workspace::new(&self.model), &intervals, self.frame);
        let attained = dot(direction.map(Interval::from), pose.translation).lower();
        Farthest { proven, attained, q }
    }

    /// The box that contains all positions \[m\]: bounds of x, y and z.
    pub fn bounding_box(&self) -> [Interval; 3] {
        [0, 1, 2].map(|k| {
            let mut direction = [0.0; 3];
            direction[k] = 1.0;
            let upper = self.farthest(direction).proven;
            direction[k] = -1.0;
            Interval::new(-self.farthest(direction).proven, upper)
        })
    }
}

impl ChainJoint {
    fn new(model: &Model, body: &Body, q: &[Interval], cells: usize) -> Result<Self, EnclosureError> {
        if body.motion.nv() != 1 {
            return Err(EnclosureError::Quaternions);
        }
        let dof = &model.dofs[body.dof];
        let mut range = q[body.q_index] * Interval::from(dof.ratio) + Interval::from(dof.offset);
        if body.motion == PrimitiveJoint::Revolute {
            range = one_turn(range);
        }
        if !range.is_bounded() {
            return Err(EnclosureError::Unbounded);
        }
        let arc = body.motion.turns().then(|| Arc::new(range, 2.0 / cells as f64));
        Ok(Self { body: body.clone(), range, own: q[body.q_index], arc })
    }

    /// A bound of the support function relative to the parent, and the position of the joint for the largest
    /// value found.
    fn bound(&self, beyond: &Support, m: Vector) -> (f64, f64) {
        let offset =
            dot(m, self.body.translation.first_chunk::<3>().expect("three numbers").map(Interval::from));
        let m = self.in_body(m);
        let pitch = match self.body.motion {
            PrimitiveJoint::Helical(pitch) => pitch,
            PrimitiveJoint::Prismatic => 1.0,
            _ => 0.0,
        };
        let slope = m[2] * Interval::from(pitch);
        let (bound, position) = if let Some(arc) = &self.arc {
            arc.largest(beyond, m, slope)
        } else {
            let position = if slope.middle() > 0.0 { self.range.upper() } else { self.range.lower() };
            ((Interval::from(beyond.bound(m)) + slope * self.range).upper(), position)
        };
        ((Interval::from(bound) + offset).upper(), position)
    }

    /// Rᵀ m, R the rotation of the body in its parent at q = 0. The rotation's columns are stored.
    fn in_body(&self, m: Vector) -> Vector {
        [0, 1, 2].map(|k| {
            let column = &self.body.rotation[k];
            dot(m, [0, 1, 2].map(|i| Interval::from(column[i])))
        })
    }

    /// The direction in the body's frame at a position of the joint.
    fn direction_beyond(&self, m: Vector, position: f64) -> Vector {
        let [x, y, z] = self.in_body(m);
        if self.arc.is_none() {
            return [x, y, z];
        }
        let (sine, cosine) = position.sin_cos();
        let (sine, cosine) = (Interval::from(sine), Interval::from(cosine));
        [x * cosine + y * sine, y * cosine - x * sine, z]
    }
}
