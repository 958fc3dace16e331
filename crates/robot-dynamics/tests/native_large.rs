//! Robots of a hundred thousand joints: the recursions compute them, and nothing is traced.
#![cfg(feature = "native")]
#![allow(missing_docs)]

use robot_dynamics::algorithms::{
    bias, forward_dynamics, gravity, inverse_dynamics, kinetic_energy, momentum,
};
use robot_dynamics::derivatives::{
    ForwardPullbackMut, InversePullbackMut, forward_dynamics_pullback, inverse_dynamics_pullback,
};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::with_native_code;

const JOINTS: usize = 100_000;
const MASS: f64 = 2.0;
const LENGTH: f64 = 0.5;
const GRAVITY: f64 = 9.81;

/// Point masses at the ends of massless rods on horizontal hinges. `parent` gives the parent link of each,
/// and `None` the base.
fn robot(name: &str, parent: impl Fn(usize) -> Option<usize>) -> Model {
    let mut robot = RobotDescription::new(name);
    let base = "base".to_owned();
    robot.links.push(LinkDescription::new(&base, None));
    let rod = MassProperties::point(MASS, [LENGTH, 0.0, 0.0].into()).expect("a positive mass");
    for k in 0..JOINTS {
        let carrier = parent(k).map_or_else(|| base.clone(), |parent| format!("rod{parent}"));
        let at = if parent(k).is_some() { LENGTH } else { 0.0 };
        let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
        let (joint, link) = (format!("hinge{k}"), format!("rod{k}"));
        robot.links.push(LinkDescription::new(&link, rod));
        let pose = Pose::from_translation([at, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(joint, hinge, carrier, link, pose));
    }
    with_native_code(Model::new(robot).expect("a robot"))
}

/// Checks that no function was traced: each has another reason for the recursion, or the processor has no
/// encoder.
fn assert_recursions(model: &Model) {
    let report = model.native();
    for used in &report.functions {
        let reason = used.route.as_ref().expect_err("a recursion");
        assert!(reason.starts_with("which needs some"), "{used}");
    }
    assert!(report.reason.is_some() || !report.functions.is_empty());
}

/// Pendulums in parallel: τ = m l² a − m g l cos q.
#[test]
fn a_star_of_pendulums_has_their_equations() {
    let model = robot("star", |_| None);
    let q: Vec<f64> = (0..JOINTS).map(|k| (k % 1000) as f64 * 0.006).collect();
    let a: Vec<f64> = (0..JOINTS).map(|k| (k % 7) as f64 - 3.0).collect();
    let (v, zeros) = (vec![0.7; JOINTS], || vec![0.0; JOINTS]);
    let (w, inertia, weight) = (&mut Workspace::new(&model), MASS * LENGTH * LENGTH, MASS * GRAVITY * LENGTH);
    let (mut tau, mut acceleration) = (zeros(), zeros());
    inverse_dynamics(&model, w, &q, &v, &a, &mut tau);
    forward_dynamics(&model, w, &q, &v, &tau, &mut acceleration);
    let [mut by_q, mut by_v, mut by_a] = [zeros(), zeros(), zeros()];
    let out = InversePullbackMut {
        by_position: &mut by_q,
        by_velocity: &mut by_v,
        by_acceleration: &mut by_a,
        parameters: &mut [],
    };
    inverse_dynamics_pullback(&model, w, &q, &v, &a, &v, out);
    for k in 0..JOINTS {
        assert!((tau[k] - (inertia * a[k] - weight * q[k].cos())).abs() < 1e-12 * weight);
        assert!((acceleration[k] - a[k]).abs() < 1e-12 * weight / inertia);
        assert!((by_q[k] - v[k] * weight * q[k].sin()).abs() < 1e-12 * weight);
        assert!(by_v[k].abs() < 1e-12 && (by_a[k] - v[k] * inertia).abs() < 1e-14);
    }
    let energy = kinetic_energy(&model, w, &q, &v);
    let expected = JOINTS as f64 * 0.5 * inertia * 0.7 * 0.7;
    // The rounding of a sum of that many terms.
    assert!((energy - expected).abs() < JOINTS as f64 * f64::EPSILON * expected);
    assert_recursions(&model);
}

/// A straight horizontal chain at rest: the moment about hinge k is the sum of the weights beyond it times
/// their levers.
#[test]
fn a_chain_carries_its_weight() {
    let model = robot("chain", |k| k.checked_sub(1));
    let (w, rest, mut g) = (&mut Workspace::new(&model), vec![0.0; JOINTS], vec![0.0; JOINTS]);
    gravity(&model, w, &rest, &mut g);
    let (mut count, mut levers) = (0.0, 0.0);
    for k in (0..JOINTS).rev() {
        // The weights beyond hinge k are at l, 2 l, 3 l …
        count += 1.0;
        levers += count * LENGTH;
        let expected = -MASS * GRAVITY * levers;
        // Each sum over the later links rounds by at most ε/2.
        assert!((g[k] - expected).abs() <= 4.0 * count * f64::EPSILON * expected.abs(), "{k}");
    }
    let (mut force, mut p) = (vec![0.0; JOINTS], vec![0.0; JOINTS]);
    bias(&model, w, &rest, &rest, &mut force);
    assert_eq!(force, g);
    momentum(&model, w, &rest, &rest, &mut p);
    assert!(p.iter().all(|p| *p == 0.0));
    assert_recursions(&model);
}

/// A binary tree of links: forward dynamics inverts inverse dynamics, and the pullbacks are symmetric, ā·M⁻¹b
/// = b·M⁻¹ā.
#[test]
fn a_bush_is_accelerated_as_its_forces_say() {
    let model = robot("bush", |k| k.checked_sub(1).map(|before| before / 2));
    let number = |k: usize, period: usize| (k % period) as f64 / period as f64 - 0.5;
    let table = |period: usize| (0..JOINTS).map(|k| number(k, period)).collect::<Vec<f64>>();
    let (q, v, a, weights) = (table(101), table(103), table(107), table(109));
    let (w, zeros) = (&mut Workspace::new(&model), || vec![0.0; JOINTS]);
    let (mut tau, mut found) = (zeros(), zeros());
    inverse_dynamics(&model, w, &q, &v, &a, &mut tau);
    let [mut x, mut y, mut by_force] = [zeros(), zeros(), zeros()];
    let out = ForwardPullbackMut {
        acceleration: &mut found,
        by_position: &mut x,
        by_velocity: &mut y,
        by_force: &mut by_force,
        parameters: &mut [],
    };
    forward_dynamics_pullback(&model, w, &q, &v, &tau, &weights, out);
    // The subtree masses differ by the ratio of the tree's size to a leaf: κ(M) is about 10⁸.
    let off = found.iter().zip(&a).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(off < 1e8 * f64::EPSILON, "{off:e}");
    let mut other = zeros();
    let cotangent = table(113);
    let mut by_other = zeros();
    let out = ForwardPullbackMut {
        acceleration: &mut other,
        by_position: &mut x,
        by_velocity: &mut y,
        by_force: &mut by_other,
        parameters: &mut [],
    };
    forward_dynamics_pullback(&model, w, &q, &v, &tau, &cotangent, out);
    assert_eq!(found, other);
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let scale = dot(&cotangent, &cotangent).sqrt() * dot(&by_force, &by_force).sqrt();
    let off = (dot(&cotangent, &by_force) - dot(&weights, &by_other)).abs() / scale;
    assert!(off < 1e8 * f64::EPSILON, "{off:e}");
    assert_recursions(&model);
}
