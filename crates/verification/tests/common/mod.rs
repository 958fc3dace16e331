//! The random robots of the comparisons with the reference, and their tolerances.
#![allow(dead_code)] // each test file uses a part of it

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use robot_dynamics::algorithms::FrameWrench;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, JointKinds, LinkDescription, MassProperties, Pose, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::{Dual, SplitMix64};
use robot_dynamics::verification::lagrange;

/// Robots of one sort.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) options: RandomRobotOptions,
    pub(crate) count: u64,
}

/// A random robot at a random state.
pub(crate) struct Robot {
    pub(crate) family: &'static str,
    pub(crate) seed: u64,
    pub(crate) model: Model,
    pub(crate) state: RandomState,
    condition: OnceCell<f64>,
}

/// Every kind of tree: small and large, chains and bushes, fixed and floating, with mimic joints, tendons and
/// bad conditioning.
pub(crate) fn families() -> Vec<Family> {
    let base = RandomRobotOptions::default();
    let family = |name, count, options| Family { name, options, count };
    vec![
        family("one joint", 60, RandomRobotOptions { joints: 1, fixed: 0.5, ..base.clone() }),
        family("trees of all joints", 100, base.clone()),
        family("floating trees", 60, RandomRobotOptions { base: Base::Floating, joints: 8, ..base.clone() }),
        family("chains", 40, RandomRobotOptions { chain: 1.0, ..base.clone() }),
        family("bushes", 40, RandomRobotOptions { chain: 0.0, joints: 15, ..base.clone() }),
        family(
            "single-coordinate trees with massless links",
            60,
            RandomRobotOptions {
                kinds: JointKinds::SingleDof,
                massless: 0.8,
                fixed: 0.0,
                joints: 12,
                ..base.clone()
            },
        ),
        family("mimic joints", 100, RandomRobotOptions { mimic: 0.6, base: Base::Floating, ..base.clone() }),
        family("tendons with armature", 60, RandomRobotOptions { mimic: 0.1, tendons: 3, ..base.clone() }),
        family(
            "thin rods, masses 1 to 10 000",
            60,
            RandomRobotOptions { thin: 0.5, mass_ratio: 1e4, passive: 0.0, ..base.clone() },
        ),
        family("large", 3, RandomRobotOptions { joints: 60, base: Base::Floating, chain: 0.8, ..base }),
    ]
}

impl Family {
    /// The robots of the family; each seed determines a robot and its state.
    pub(crate) fn robots(&self) -> impl Iterator<Item = Robot> + '_ {
        (0..self.count).map(|seed| Robot::new(self.name, seed, &self.options))
    }
}

impl Robot {
    pub(crate) fn new(family: &'static str, seed: u64, options: &RandomRobotOptions) -> Self {
        let model = Model::new(random_robot(seed, options))
            .unwrap_or_else(|error| panic!("{family}, seed {seed}: {error}"));
        let state = random_state(&model, &mut SplitMix64::new(seed ^ 0x5eed));
        Self { family, seed, model, state, condition: OnceCell::new() }
    }

    /// M by the recursion.
    pub(crate) fn mass(&self) -> Vec<f64> {
        let mut mass = vec![0.0; self.model.nv() * self.model.nv()];
        robot_dynamics::algorithms::mass_matrix(
            &self.model,
            &mut Workspace::new(&self.model),
            &self.state.q,
            &mut mass,
        );
        mass
    }

    /// κ(M) from the eigenvalues of the reference's M; at least 1.
    pub(crate) fn condition(&self) -> f64 {
        *self.condition.get_or_init(|| {
            let (nv, mass) = (self.model.nv(), lagrange::mass_matrix(&self.model, &self.state.q));
            let eigenvalues = DMatrix::from_row_slice(nv, nv, &mass).symmetric_eigenvalues();
            let (low, high) = (eigenvalues.min(), eigenvalues.max());
            // A smallest eigenvalue below the rounding of the largest is not accurate.
            high / low.max(f64::EPSILON * high)
        })
    }

    /// The size of the terms of a force with the acceleration a.
    pub(crate) fn force_size(&self, a: &[f64]) -> f64 {
        let Robot { model, state, .. } = self;
        let stiffness = model.joints().iter().map(|joint| joint.passive.stiffness).sum::<f64>();
        model.mass() * 9.81 + size(&self.mass()) * (dot(&state.v, &state.v) + dot(a, a).sqrt()) + stiffness
    }

    /// A wrench on every third frame.
    pub(crate) fn wrenches(&self) -> Vec<FrameWrench> {
        let random = &mut SplitMix64::new(self.seed ^ 0xf0);
        let frames = self.model.frames().iter().step_by(3);
        frames
            .map(|frame| FrameWrench {
                frame: self.model.frame(&frame.name).expect("its own frame"),
                force_in_frame: core::array::from_fn(|_| random.uniform(-3.0, 3.0)),
                moment_in_frame: core::array::from_fn(|_| random.uniform(-3.0, 3.0)),
            })
            .collect()
    }

    /// Asserts `found ≤ allowed`; the message has all that is needed to reproduce a failure.
    #[track_caller]
    pub(crate) fn require(&self, law: &str, found: f64, allowed: f64) {
        // NaN fails, too.
        assert!(
            found <= allowed,
            "{law}: found {found:e}, allowed {allowed:e}; family \"{}\", seed {}, nv {}, {:?}",
            self.family,
            self.seed,
            self.model.nv(),
            self.state
        );
    }
}

/// max |aᵢ − bᵢ|; NaN if any is.
pub(crate) fn max_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |worst, x| if x.is_nan() { x } else { x.max(worst) })
}

/// max |aᵢ|.
pub(crate) fn size(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()))
}

/// M x for a row-major M.
pub(crate) fn times(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    matrix.chunks(x.len().max(1)).map(|row| dot(row, x)).collect()
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    DVector::from_column_slice(a).dot(&DVector::from_column_slice(b))
}

/// q ⊕ ε δ to first order over dual numbers: q̇ of v = δ, with quaternions by nalgebra.
pub(crate) fn moved_along(model: &Model, q: &[f64], delta: &[f64]) -> Vec<Dual<f64, 1>> {
    let mut moved: Vec<_> = q.iter().map(|&q| Dual::constant(q)).collect();
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        let delta = &delta[joint.v()];
        if joint.nq == joint.nv {
            (0..joint.nq).for_each(|i| moved[joint.q_index + i].gradient = [delta[i]]);
            continue;
        }
        let at = joint.q_index + joint.nq - 4;
        let turn = Quaternion::new(q[at + 3], q[at], q[at + 1], q[at + 2]);
        if joint.nq == 7 {
            let along = UnitQuaternion::from_quaternion(turn) * Vector3::from_column_slice(&delta[..3]);
            (0..3).for_each(|i| moved[joint.q_index + i].gradient = [along[i]]);
        }
        let angular = Vector3::from_column_slice(&delta[joint.nv - 3..]);
        let rate = turn * Quaternion::from_imag(angular) * 0.5;
        (0..4).for_each(|i| moved[at + i].gradient = [rate.coords[i]]);
    }
    moved
}

/// A floating tree of all kinds of joints, with damping but no friction.
pub(crate) fn damped_tree(seed: u64) -> Model {
    let options = RandomRobotOptions { joints: 5, base: Base::Floating, massless: 0.0, ..Default::default() };
    let mut robot = random_robot(seed, &options);
    for joint in &mut robot.joints {
        joint.passive.friction = 0.0;
        joint.passive.damping = 0.2;
    }
    Model::new(robot).unwrap()
}

/// A hanging chain of rods, 0.1 kg and 0.1 m each, on hinges about y.
pub(crate) fn chain(links: usize) -> Model {
    let mut robot = RobotDescription::new("chain");
    robot.links.push(LinkDescription::new("ceiling", None));
    for k in 0..links {
        let moment = 0.1 * 0.1 * 0.1 / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(moment, moment, 0.1 * moment));
        let rod = MassProperties::new(0.1, Vector3::new(0.0, 0.0, -0.05), inertia).unwrap();
        robot.links.push(LinkDescription::new(format!("rod {k}"), rod));
        let (parent, at) = match k {
            0 => ("ceiling".into(), [0.0; 3]),
            _ => (format!("rod {}", k - 1), [0.0, 0.0, -0.1]),
        };
        let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
        let child = format!("rod {k}");
        let pose = Pose::from_translation(at);
        robot.joints.push(JointDescription::new(format!("hinge {k}"), hinge, &parent, &child, pose));
    }
    Model::new(robot).unwrap()
}
