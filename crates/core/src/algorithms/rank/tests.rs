//! The distance of pivots from their rounding, for regular and for singular robots.

use nalgebra::DMatrix;
use robot_dynamics_description::{
    Base, JointKind, JointKinds, LinkDescription, PassiveForces, Pose, RandomRobotOptions, RobotDescription,
    random_robot,
};
use robot_dynamics_number::SplitMix64;

use super::*;
use crate::random_state;

/// The least bound, in rounding errors, at which some pivot vanishes: a power of √10.
fn roundings(model: &Model, q: &[f64]) -> f64 {
    let workspace = &mut Workspace::new(model);
    let mut tried = (-8..40).map(|k| 10f64.powf(f64::from(k) / 2.0));
    let vanishes = |&roundings: &f64| {
        let mut any = false;
        for_each_vanished(model, &mut workspace.tree, &mut workspace.rank, q, roundings, &mut |_| any = true);
        any
    };
    tried.find(vanishes).unwrap_or(f64::INFINITY)
}

/// The condition number κ of M scaled to a unit diagonal.
fn condition(model: &Model, q: &[f64]) -> f64 {
    let (nv, mut m) = (model.nv, vec![0.0; model.nv * model.nv]);
    crate::mass_matrix(model, &mut Workspace::new(model), q, &mut m);
    let scaled = |i: usize, j: usize| m[i * nv + j] / (m[i * nv + i] * m[j * nv + j]).sqrt();
    let eigenvalues = DMatrix::from_fn(nv, nv, scaled).symmetric_eigenvalues();
    // The least eigenvalue may be lost in rounding.
    eigenvalues.max() / eigenvalues.min().max(f64::EPSILON)
}

fn families() -> Vec<(&'static str, RandomRobotOptions)> {
    let plain = RandomRobotOptions::default();
    let bare = RandomRobotOptions { passive: 0.0, ..plain.clone() };
    let single = JointKinds::SingleDof;
    vec![
        ("trees", plain.clone()),
        ("floating", RandomRobotOptions { base: Base::Floating, ..plain.clone() }),
        ("long chains", RandomRobotOptions { chain: 1.0, joints: 40, ..bare.clone() }),
        ("light and heavy", RandomRobotOptions { mass_ratio: 1e6, thin: 0.5, ..bare.clone() }),
        (
            "specks and planets",
            RandomRobotOptions { mass_ratio: 1e12, thin: 0.5, massless: 0.0, ..plain.clone() },
        ),
        ("links without mass", RandomRobotOptions { massless: 1.0, kinds: single, ..bare }),
        ("mimic joints", RandomRobotOptions { mimic: 0.4, ..plain.clone() }),
        ("tendons", RandomRobotOptions { tendons: 3, ..plain }),
    ]
}

/// A regular robot's pivots vanish only for a bound of about 1/(κ ε) rounding errors. The rank check
/// therefore reports no robot whose accelerations have correct digits. κ of the scaled M comes from the
/// eigenvalues of M by the composite-rigid-body algorithm.
#[test]
fn healthy_pivots_are_far_from_rounding() {
    for (name, options) in families() {
        let (mut least, mut relative) = (f64::INFINITY, f64::INFINITY);
        for seed in 0..100 {
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let q = random_state(&model, &mut SplitMix64::new(seed)).q;
            let found = roundings(&model, &q);
            let product = found * condition(&model, &q) * f64::EPSILON;
            // N grows with the cancellation of the terms of M, here up to a hundred times.
            assert!(product > 0.01, "{name}, seed {seed}: {found:e} roundings, product {product:e}");
            assert!(found > ROUNDINGS, "{name}, seed {seed}: accused");
            (least, relative) = (least.min(found), relative.min(product));
        }
        println!("{name}: from {least:e} roundings on, {relative:.1e}/(κ ε)");
    }
}

/// Inserts a second joint of the same kind and axis before a joint, with no inertia between them.
fn doubled(robot: &mut RobotDescription, random: &mut SplitMix64) -> bool {
    let is_plain = |j: usize| {
        let joint = &robot.joints[j];
        let leads =
            robot.joints.iter().any(|j| j.mimic.as_ref().is_some_and(|mimic| mimic.joint == joint.name));
        joint.kind != JointKind::Fixed && joint.mimic.is_none() && !leads
    };
    let candidates: Vec<usize> = (0..robot.joints.len()).filter(|&j| is_plain(j)).collect();
    if candidates.is_empty() {
        return false;
    }
    let pick = candidates[usize::try_from(random.next_u64() >> 40).unwrap() % candidates.len()];
    let joint = &mut robot.joints[pick];
    joint.passive = PassiveForces::default();
    let mut twin = joint.clone();
    joint.child = "between".into();
    (twin.name, twin.parent, twin.parent_from_joint) = ("twin".into(), "between".into(), Pose::IDENTITY);
    robot.links.push(LinkDescription::new("between", None));
    // Coordinates that move with one joint move with the other too.
    for tendon in &mut robot.tendons {
        let name = &robot.joints[pick].name;
        let own: Vec<_> = tendon.terms.iter().filter(|(joint, _)| joint == name).map(|(_, c)| *c).collect();
        tendon.terms.extend(own.into_iter().map(|c| ("twin".to_owned(), c)));
    }
    robot.joints.push(twin);
    true
}

/// A pivot that should vanish is at most one rounding error, for robots of up to a hundred joints and any
/// masses.
#[test]
fn pivots_that_should_vanish_are_rounding() {
    let mut most: f64 = 0.0;
    for (name, family) in families() {
        for joints in [2, 10, 100] {
            for seed in 0..30 {
                let mut random = SplitMix64::new(seed);
                let mut robot = random_robot(seed, &RandomRobotOptions { joints, ..family.clone() });
                if !doubled(&mut robot, &mut random) {
                    continue;
                }
                let model = Model::new(robot).unwrap();
                let q = random_state(&model, &mut random).q;
                let found = roundings(&model, &q);
                assert!(found <= 1.0, "{name} of {joints}, seed {seed}: {found:e} roundings");
                let error = check_rank(&model, &mut Workspace::new(&model), &q).unwrap_err();
                let told = error.joints();
                assert!(told.contains(&"twin"), "{name} of {joints}, seed {seed}: {error}");
                most = most.max(found);
            }
        }
    }
    println!("singular pivots: at most {most:e} roundings");
}
