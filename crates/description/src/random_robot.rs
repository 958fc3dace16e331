//! Reproducible random robots of every kind, for tests.

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_number::SplitMix64;

use crate::{
    Base, FrameDescription, JointDescription, JointKind, Limits, LinkDescription, MassProperties, Mimic,
    PassiveForces, Pose, RobotDescription, TendonDescription,
};

/// The kinds of moving joints of a random robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKinds {
    /// All kinds.
    All,
    /// All kinds with q̇ = v: neither spherical nor floating.
    VectorSpace,
    /// Kinds of one DoF: revolute, continuous, prismatic, helical.
    #[doc(alias = "SingleFreedom")]
    SingleDof,
    /// Revolute and continuous.
    Turning,
}

impl JointKinds {
    fn contains(self, kind: &JointKind) -> bool {
        match self {
            Self::All => true,
            Self::VectorSpace => kind.nq() == kind.nv(),
            Self::SingleDof => kind.nv() == 1,
            Self::Turning => matches!(kind, JointKind::Revolute { .. } | JointKind::Continuous { .. }),
        }
    }
}

/// Options of [`random_robot`]; probabilities are in \[0, 1\].
#[derive(Clone, Debug, PartialEq)]
pub struct RandomRobotOptions {
    /// The number of moving joints, mimic joints included; fixed joints are additional.
    pub joints: usize,
    /// Whether the root link floats.
    pub base: Base,
    /// The kinds of the moving joints.
    pub kinds: JointKinds,
    /// Probability that a link's parent is the previous link instead of a random one: 1 gives a chain, 0 many
    /// short branches.
    pub chain: f64,
    /// Probability of an extra link on a fixed joint before a moving joint.
    pub fixed: f64,
    /// Probability that a link between joints of one DoF has no mass.
    pub massless: f64,
    /// Probability that a joint of one DoF is a mimic joint (chains of mimic joints arise).
    pub mimic: f64,
    /// The number of tendons with armature, each over two or more joints of one DoF on any branches, so that
    /// M couples branches.
    pub tendons: usize,
    /// Probability that a joint has armature, damping, friction and (if it can have one) a spring.
    pub passive: f64,
    /// Masses are between 1/√ratio and √ratio kg, uniform in the logarithm.
    pub mass_ratio: f64,
    /// Probability that a link is a rod so thin that its smallest moment of inertia is 1e-6 of its largest.
    pub thin: f64,
}

impl Default for RandomRobotOptions {
    /// A tree of 10 joints of all kinds on a fixed base, well conditioned, with all features except mimic
    /// joints and tendons.
    fn default() -> Self {
        Self {
            joints: 10,
            base: Base::Fixed,
            kinds: JointKinds::All,
            chain: 0.6,
            fixed: 0.2,
            massless: 0.1,
            mimic: 0.0,
            tendons: 0,
            passive: 0.5,
            mass_ratio: 10.0,
            thin: 0.0,
        }
    }
}

/// A random robot; equal seeds and options give equal robots.
///
/// Placements, axes, centres of mass and principal axes have random directions. So has gravity, with Earth's
/// magnitude. Every last link of a branch has mass, and no massless link is the child of a joint of several
/// DoFs. M is therefore positive definite at almost every pose. Every third link has a further frame,
/// `frame0`, `frame1`, ...
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// let robot = random_robot(7, &RandomRobotOptions { joints: 20, ..Default::default() });
/// assert_eq!(robot, random_robot(7, &RandomRobotOptions { joints: 20, ..Default::default() }));
/// assert!(Model::new(robot)?.nv() >= 20);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// If a probability is not in \[0, 1\], or `mass_ratio` is less than 1 or not finite.
#[track_caller]
pub fn random_robot(seed: u64, options: &RandomRobotOptions) -> RobotDescription {
    for probability in
        [options.chain, options.fixed, options.massless, options.mimic, options.passive, options.thin]
    {
        assert!((0.0..=1.0).contains(&probability), "a probability of {probability}");
    }
    assert!(options.mass_ratio >= 1.0 && options.mass_ratio.is_finite(), "a ratio of {}", options.mass_ratio);
    let mut random = SplitMix64::new(seed);
    let mut robot = RobotDescription::new(format!("random{seed}"));
    robot.base = options.base;
    robot.gravity = (random_rotation(&mut random) * Vector3::new(0.0, 0.0, 9.81)).into();
    add_link(&mut robot, &mut random, options);
    for _ in 0..options.joints {
        let mut parent = if happens(&mut random, options.chain) {
            robot.links.len() - 1
        } else {
            pick(&mut random, robot.links.len())
        };
        if happens(&mut random, options.fixed) {
            parent = add_joint(&mut robot, &mut random, options, parent, JointKind::Fixed);
        }
        let kind = random_kind(&mut random, options.kinds);
        add_joint(&mut robot, &mut random, options, parent, kind);
    }
    remove_masses(&mut robot, &mut random, options.massless);
    add_followers(&mut robot, &mut random, options.mimic);
    for (i, link) in robot.links.iter().enumerate().step_by(3) {
        let link_from_frame = random_pose(&mut random);
        robot.frames.push(FrameDescription::new(
            format!("frame{}", i / 3),
            link.name.clone(),
            link_from_frame,
        ));
    }
    add_tendons(&mut robot, &mut random, options.tendons);
    robot
}

fn happens(random: &mut SplitMix64, probability: f64) -> bool {
    random.uniform(0.0, 1.0) < probability
}

#[allow(clippy::cast_possible_truncation)] // the remainder fits in a usize
fn pick(random: &mut SplitMix64, count: usize) -> usize {
    (random.next_u64() % count as u64) as usize
}

/// A unit vector: a point of the cube inside the ball, projected.
fn random_direction(random: &mut SplitMix64) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0));
        if (0.01..1.0).contains(&v.norm_squared()) {
            return v.normalize();
        }
    }
}

/// (x y z w), |q| = 1.
#[doc(hidden)]
pub fn random_quaternion(random: &mut SplitMix64) -> [f64; 4] {
    let half = random.uniform(-1.5, 1.5);
    let axis = random_direction(random) * half.sin();
    [axis.x, axis.y, axis.z, half.cos()]
}

fn random_rotation(random: &mut SplitMix64) -> Rotation3<f64> {
    let turn = random.uniform(-3.0, 3.0);
    Rotation3::new(random_direction(random) * turn)
}

fn random_pose(random: &mut SplitMix64) -> Pose {
    let translation = random_direction(random) * random.uniform(0.1, 0.6);
    Pose::from_translation_quaternion_xyzw(translation.into(), random_quaternion(random))
}

fn random_kind(random: &mut SplitMix64, kinds: JointKinds) -> JointKind {
    // Axes of any length: descriptions need not normalize them.
    let mut axis = || -> [f64; 3] {
        let length = random.uniform(0.5, 2.0);
        (random_direction(random) * length).into()
    };
    let (axis, second) = (axis(), axis());
    let pitch = random.uniform(-0.3, 0.3);
    let all = [
        JointKind::Revolute { axis },
        JointKind::Continuous { axis },
        JointKind::Prismatic { axis },
        JointKind::Helical { axis, pitch },
        JointKind::Universal { first: axis, second },
        JointKind::Planar { normal: axis },
        JointKind::Spherical,
        JointKind::Floating,
    ];
    let chosen: Vec<JointKind> = all.into_iter().filter(|kind| kinds.contains(kind)).collect();
    chosen[pick(random, chosen.len())]
}

fn random_mass_properties(random: &mut SplitMix64, options: &RandomRobotOptions) -> MassProperties {
    let mass = options.mass_ratio.powf(random.uniform(-0.5, 0.5));
    // Moments from ⟨x²⟩, ⟨y²⟩, ⟨z²⟩: any three positive numbers are valid. [m²]
    let mut spread = Vector3::from_fn(|_, _| random.uniform(0.01, 0.05));
    if happens(random, options.thin) {
        spread.y = 1e-6 * spread.x;
        spread.z = 1e-7 * spread.x;
    }
    let moments = Vector3::new(spread.y + spread.z, spread.x + spread.z, spread.x + spread.y) * mass;
    let turn = random_rotation(random);
    let inertia = turn * Matrix3::from_diagonal(&moments) * turn.transpose();
    let center = random_direction(random) * random.uniform(0.0, 0.3);
    MassProperties::new(mass, center, (inertia + inertia.transpose()) * 0.5)
        .expect("moments of a mass distribution")
}

fn add_link(robot: &mut RobotDescription, random: &mut SplitMix64, options: &RandomRobotOptions) -> String {
    let name = format!("link{}", robot.links.len());
    let mass_properties = Some(random_mass_properties(random, options));
    robot.links.push(LinkDescription::new(name.clone(), mass_properties));
    name
}

/// Adds a joint and its child link; returns the child's index.
fn add_joint(
    robot: &mut RobotDescription,
    random: &mut SplitMix64,
    options: &RandomRobotOptions,
    parent: usize,
    kind: JointKind,
) -> usize {
    let child = add_link(robot, random, options);
    let name = format!("joint{}", robot.joints.len());
    let parent = robot.links[parent].name.clone();
    let mut joint = JointDescription::new(name, kind, parent, child, random_pose(random));
    let rest = random.uniform(-1.0, 1.0);
    if happens(random, options.passive) && kind != JointKind::Fixed {
        let free = matches!(kind, JointKind::Spherical | JointKind::Floating);
        joint.passive = PassiveForces::default()
            .with_armature(random.uniform(0.0, 0.2))
            .with_damping(random.uniform(0.0, 0.5))
            .with_friction(random.uniform(0.0, 0.3))
            .with_spring(if free { 0.0 } else { random.uniform(0.0, 5.0) }, if free { 0.0 } else { rest });
    }
    let bound = match kind {
        JointKind::Revolute { .. } | JointKind::Helical { .. } => random.uniform(1.0, 3.0),
        JointKind::Prismatic { .. } => random.uniform(0.2, 1.0),
        _ => f64::INFINITY,
    };
    joint.limits = Limits::new(-bound, bound).with_velocity(5.0 * bound).with_effort(50.0 * bound);
    robot.joints.push(joint);
    robot.links.len() - 1
}

/// Removes the mass of links between joints of one DoF whose other ends have mass.
fn remove_masses(robot: &mut RobotDescription, random: &mut SplitMix64, probability: f64) {
    for link in 0..robot.links.len() {
        let name = robot.links[link].name.clone();
        let has_mass = |robot: &RobotDescription, name: &str| {
            robot.links.iter().any(|link| link.name == name && link.mass_properties.is_some())
        };
        let above = robot.joints.iter().find(|joint| joint.child == name);
        let single = above.is_some_and(|joint| joint.kind.nv() == 1 && has_mass(robot, &joint.parent));
        let mut below = robot.joints.iter().filter(|joint| joint.parent == name).peekable();
        let carries = below.peek().is_some()
            && below.all(|joint| joint.kind.nv() == 1 && has_mass(robot, &joint.child));
        if single && carries && happens(random, probability) {
            robot.links[link].mass_properties = None;
        }
    }
}

/// Makes mimic joints. A leader always comes earlier in one random order, so there is no cycle.
fn add_followers(robot: &mut RobotDescription, random: &mut SplitMix64, probability: f64) {
    let mut single: Vec<usize> =
        (0..robot.joints.len()).filter(|&j| robot.joints[j].kind.nv() == 1).collect();
    for i in (1..single.len()).rev() {
        single.swap(i, pick(random, i + 1));
    }
    for i in 1..single.len() {
        if happens(random, probability) {
            let joint = robot.joints[single[pick(random, i)]].name.clone();
            let sign = if happens(random, 0.5) { 1.0 } else { -1.0 };
            let (ratio, offset) = (sign * random.uniform(0.3, 1.0), random.uniform(-0.5, 0.5));
            robot.joints[single[i]].mimic = Some(Mimic::new(joint, ratio, offset));
        }
    }
}

fn add_tendons(robot: &mut RobotDescription, random: &mut SplitMix64, count: usize) {
    let single = robot.joints.iter().filter(|joint| joint.kind.nv() == 1);
    let single: Vec<String> = single.map(|joint| joint.name.clone()).collect();
    for i in 0..if single.len() < 2 { 0 } else { count } {
        let terms: Vec<(String, f64)> = (0..2 + pick(random, 3))
            .map(|_| (single[pick(random, single.len())].clone(), random.uniform(-1.5, 1.5)))
            .collect();
        let mut tendon = TendonDescription::new(format!("tendon{i}"), terms);
        tendon.passive = PassiveForces::default().with_armature(random.uniform(0.05, 0.5));
        robot.tendons.push(tendon);
    }
}
