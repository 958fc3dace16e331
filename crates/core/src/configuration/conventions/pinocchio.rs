//! The layout of q and v in Pinocchio, for a robot read from a URDF file.
//!
//! | | this library | Pinocchio |
//! | --- | --- | --- |
//! | order of joints | depth first, siblings in the file's order | depth first, siblings sorted by the joint's name |
//! | continuous joint, q | angle θ | cos θ, sin θ |
//! | planar joint, q | x y θ | x y cos θ, sin θ |
//! | planar joint, v | along the axes of the joint | along the axes of the moving link |
//! | quaternion, free joint | x y z w, velocity in body axes | the same |
//!
//! Mimic joints have no entry on either side: read the file with Pinocchio's `mimic=True`. Pinocchio reads a
//! planar joint as one in the plane z = 0, whatever its axis.

use robot_dynamics_description::{JointKind, check_length};

use crate::Model;

/// The layout of Pinocchio's q and v for one model.
///
/// Its methods convert states and forces in both directions. Slices of Pinocchio's numbers have
/// [`nq`](Self::nq) and [`nv`](Self::nv) entries.
#[derive(Clone, Debug)]
pub struct PinocchioLayout {
    joints: Vec<Segment>,
    model_nq: usize,
    nq: usize,
    nv: usize,
}

/// How the numbers of a joint differ.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Equal,
    Continuous,
    Planar,
}

/// The entries of one joint on both sides.
#[derive(Clone, Copy, Debug)]
struct Segment {
    kind: Kind,
    q: usize,
    nq: usize,
    v: usize,
    nv: usize,
    pinocchio_q: usize,
    pinocchio_v: usize,
}

impl PinocchioLayout {
    /// The layout for a model.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// use robot_dynamics::description::{JointKind, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].kind = JointKind::Continuous { axis: [0.0, 1.0, 0.0] };
    /// let model = Model::new(robot)?;
    /// let layout = PinocchioLayout::new(&model);
    /// assert_eq!((model.nq(), layout.nq(), layout.nv()), (1, 2, 1));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn new(model: &Model) -> Self {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); model.joints.len() + 1];
        for joint in &model.joints {
            children[joint.parent_joint.map_or(0, |parent| parent + 1)].push(joint.index);
        }
        for siblings in &mut children {
            // The last one first, for the stack.
            siblings.sort_by(|&a, &b| model.joints[b].name.cmp(&model.joints[a].name));
        }
        let mut layout = Self { joints: Vec::new(), model_nq: model.nq, nq: 0, nv: 0 };
        let mut pending = children[0].clone();
        while let Some(index) = pending.pop() {
            pending.extend(&children[index + 1]);
            let joint = &model.joints[index];
            if joint.nv == 0 {
                continue;
            }
            let kind = match joint.kind {
                JointKind::Continuous { .. } => Kind::Continuous,
                JointKind::Planar { .. } => Kind::Planar,
                _ => Kind::Equal,
            };
            layout.joints.push(Segment {
                kind,
                q: joint.q_index,
                nq: joint.nq,
                v: joint.v_index,
                nv: joint.nv,
                pinocchio_q: layout.nq,
                pinocchio_v: layout.nv,
            });
            layout.nq += joint.nq + usize::from(kind != Kind::Equal);
            layout.nv += joint.nv;
        }
        layout
    }

    /// The length of Pinocchio's q: one more than the model's for each continuous and planar joint.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// The length of v, which is the same on both sides.
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// q → Pinocchio's q.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let mut theirs = vec![0.0; layout.nq()];
    /// let mut back = vec![0.0; model.nq()];
    /// layout.configuration_to_pinocchio(&q, &mut theirs);
    /// layout.configuration_from_pinocchio(&theirs, &mut back);
    /// assert!(back.iter().zip(&q).all(|(back, q)| (back - q).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn configuration_to_pinocchio(&self, q: &[f64], pinocchio_q: &mut [f64]) {
        check_length("q", q.len(), self.model_nq);
        check_length("the result", pinocchio_q.len(), self.nq);
        for joint in &self.joints {
            let (from, to) = (&q[joint.q..], &mut pinocchio_q[joint.pinocchio_q..]);
            match joint.kind {
                Kind::Equal => to[..joint.nq].copy_from_slice(&from[..joint.nq]),
                Kind::Continuous => (to[0], to[1]) = (from[0].cos(), from[0].sin()),
                Kind::Planar => {
                    to[..2].copy_from_slice(&from[..2]);
                    (to[2], to[3]) = (from[2].cos(), from[2].sin());
                }
            }
        }
    }

    /// Pinocchio's q → q. Angles of continuous and planar joints are from −π to π.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nq()], vec![0.0; model.nq()]);
    /// layout.configuration_to_pinocchio(&q, &mut theirs);
    /// layout.configuration_from_pinocchio(&theirs, &mut back);
    /// assert!(back.iter().zip(&q).all(|(back, q)| (back - q).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn configuration_from_pinocchio(&self, pinocchio_q: &[f64], q: &mut [f64]) {
        check_length("the configuration", pinocchio_q.len(), self.nq);
        check_length("q", q.len(), self.model_nq);
        for joint in &self.joints {
            let (from, to) = (&pinocchio_q[joint.pinocchio_q..], &mut q[joint.q..]);
            match joint.kind {
                Kind::Equal => to[..joint.nq].copy_from_slice(&from[..joint.nq]),
                Kind::Continuous => to[0] = from[1].atan2(from[0]),
                Kind::Planar => {
                    to[..2].copy_from_slice(&from[..2]);
                    to[2] = from[3].atan2(from[2]);
                }
            }
        }
    }

    /// v → Pinocchio's v.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.velocity_to_pinocchio(&q, &v, &mut theirs);
    /// layout.velocity_from_pinocchio(&q, &theirs, &mut back);
    /// assert!(back.iter().zip(&v).all(|(back, v)| (back - v).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn velocity_to_pinocchio(&self, q: &[f64], v: &[f64], pinocchio_v: &mut [f64]) {
        self.tangent_to_pinocchio(q, v, pinocchio_v);
    }

    /// Pinocchio's v → v. q is in this library's convention.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.velocity_to_pinocchio(&q, &v, &mut theirs);
    /// layout.velocity_from_pinocchio(&q, &theirs, &mut back);
    /// assert!(back.iter().zip(&v).all(|(back, v)| (back - v).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn velocity_from_pinocchio(&self, q: &[f64], pinocchio_v: &[f64], v: &mut [f64]) {
        self.tangent_from_pinocchio(q, pinocchio_v, v);
    }

    /// τ → Pinocchio's τ; the power τ·v is preserved.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.force_to_pinocchio(&q, &tau, &mut theirs);
    /// layout.force_from_pinocchio(&q, &theirs, &mut back);
    /// assert!(back.iter().zip(&tau).all(|(back, tau)| (back - tau).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn force_to_pinocchio(&self, q: &[f64], tau: &[f64], pinocchio_tau: &mut [f64]) {
        self.tangent_to_pinocchio(q, tau, pinocchio_tau);
    }

    /// Pinocchio's τ → τ. q is in this library's convention.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.force_to_pinocchio(&q, &tau, &mut theirs);
    /// layout.force_from_pinocchio(&q, &theirs, &mut back);
    /// assert!(back.iter().zip(&tau).all(|(back, tau)| (back - tau).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn force_from_pinocchio(&self, q: &[f64], pinocchio_tau: &[f64], tau: &mut [f64]) {
        self.tangent_from_pinocchio(q, pinocchio_tau, tau);
    }

    /// v̇ → Pinocchio's v̇. Axes of a planar joint's link rotate: u̇ = Rᵀẍ − ω × u with u = Rᵀẋ.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.acceleration_to_pinocchio(&q, &v, &a, &mut theirs);
    /// layout.acceleration_from_pinocchio(&q, &v, &theirs, &mut back);
    /// assert!(back.iter().zip(&a).all(|(back, a)| (back - a).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn acceleration_to_pinocchio(&self, q: &[f64], v: &[f64], a: &[f64], pinocchio_a: &mut [f64]) {
        check_length("v", v.len(), self.nv);
        self.tangent_to_pinocchio(q, a, pinocchio_a);
        self.add_transport(q, v, -1.0, pinocchio_a);
    }

    /// Pinocchio's v̇ → v̇. q and v are in this library's convention.
    ///
    /// ```
    /// use robot_dynamics::conventions::PinocchioLayout;
    /// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// # use robot_dynamics::model::{Model, RandomState, random_state};
    /// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
    /// let layout = PinocchioLayout::new(&model);
    /// let (mut theirs, mut back) = (vec![0.0; layout.nv()], vec![0.0; model.nv()]);
    /// layout.acceleration_to_pinocchio(&q, &v, &a, &mut theirs);
    /// layout.acceleration_from_pinocchio(&q, &v, &theirs, &mut back);
    /// assert!(back.iter().zip(&a).all(|(back, a)| (back - a).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn acceleration_from_pinocchio(&self, q: &[f64], v: &[f64], pinocchio_a: &[f64], a: &mut [f64]) {
        check_length("v", v.len(), self.nv);
        check_length("the accelerations", pinocchio_a.len(), self.nv);
        let mut sum = pinocchio_a.to_vec();
        self.add_transport(q, v, 1.0, &mut sum);
        self.tangent_from_pinocchio(q, &sum, a);
    }

    /// Rotates and reorders nv numbers. The axes are orthonormal, so velocities, forces and the accelerations
    /// without transport convert alike.
    #[track_caller]
    fn tangent_to_pinocchio(&self, q: &[f64], x: &[f64], pinocchio_x: &mut [f64]) {
        self.check(q, x, pinocchio_x);
        for joint in &self.joints {
            pinocchio_x[joint.pinocchio_v..][..joint.nv].copy_from_slice(&x[joint.v..][..joint.nv]);
            if joint.kind == Kind::Planar {
                rotate(-q[joint.q + 2], &mut pinocchio_x[joint.pinocchio_v..]);
            }
        }
    }

    /// The inverse of [`tangent_to_pinocchio`](Self::tangent_to_pinocchio).
    #[track_caller]
    fn tangent_from_pinocchio(&self, q: &[f64], pinocchio_x: &[f64], x: &mut [f64]) {
        self.check(q, pinocchio_x, x);
        for joint in &self.joints {
            x[joint.v..][..joint.nv].copy_from_slice(&pinocchio_x[joint.pinocchio_v..][..joint.nv]);
            if joint.kind == Kind::Planar {
                rotate(q[joint.q + 2], &mut x[joint.v..]);
            }
        }
    }

    /// Adds `sign` ω × u to the linear acceleration of each planar joint, with u along the link's axes.
    fn add_transport(&self, q: &[f64], v: &[f64], sign: f64, a: &mut [f64]) {
        for joint in self.joints.iter().filter(|joint| joint.kind == Kind::Planar) {
            let mut u = [v[joint.v], v[joint.v + 1]];
            rotate(-q[joint.q + 2], &mut u);
            let (omega, k) = (sign * v[joint.v + 2], joint.pinocchio_v);
            a[k] -= omega * u[1];
            a[k + 1] += omega * u[0];
        }
    }

    #[track_caller]
    fn check(&self, q: &[f64], from: &[f64], to: &[f64]) {
        check_length("q", q.len(), self.model_nq);
        check_length("the vector", from.len(), self.nv);
        check_length("the result", to.len(), self.nv);
    }
}

/// Rotates the first two numbers by an angle.
fn rotate(angle: f64, x: &mut [f64]) {
    let (sine, cosine) = angle.sin_cos();
    (x[0], x[1]) = (cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1]);
}
