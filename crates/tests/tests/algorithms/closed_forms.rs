//! A robot described link by link equals the closed-form arm of the crate `dynamics`, and every law and
//! integrator holds on described robots.

use std::f64::consts::PI;
use std::sync::Arc;

use dynamics::{
    Dynamics, FixedSize, FixedSizeError, Link, PlanarArm, Reach2R, SystemStep, energy_drift, laws,
};
use nalgebra::{Matrix3, Quaternion, SVector, UnitQuaternion, Vector3, vector};
use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, JointKinds, LinkDescription, MassProperties, Mimic, PassiveForces,
    Pose, RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Integrator, IntegratorError};
use robot_dynamics::verification::lagrange;
use robot_dynamics::{InputProblem, InvalidInput};

use crate::common::{Robot, families};

/// A planar arm in the x–z plane: its joints turn about −y, which rotates x towards z; gravity is along −z.
fn described(links: &[Link], a_g: f64) -> RobotDescription {
    let mut robot = RobotDescription::new("arm");
    robot.gravity = [0.0, 0.0, -a_g];
    robot.links.push(LinkDescription::new("base", None));
    for (i, link) in links.iter().enumerate() {
        // The moments about axes that a planar arm never turns about are arbitrary.
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.7, 1.0, 0.9)) * link.inertia;
        let properties = MassProperties::new(link.mass, Vector3::new(link.centre, 0.0, 0.0), inertia);
        robot.links.push(LinkDescription::new(format!("link{i}"), properties.unwrap()));
        let at = if i == 0 { 0.0 } else { links[i - 1].length };
        let parent = if i == 0 { "base".into() } else { format!("link{}", i - 1) };
        robot.joints.push(JointDescription::new(
            format!("joint{i}"),
            JointKind::Revolute { axis: [0.0, -1.0, 0.0] },
            parent,
            format!("link{i}"),
            Pose::from_translation([at, 0.0, 0.0]),
        ));
    }
    robot
}

fn reach_2r_links(arm: &Reach2R) -> [Link; 2] {
    [
        Link { length: arm.l1, centre: arm.r1, mass: arm.m1, inertia: arm.i1 },
        Link { length: arm.l2, centre: arm.r2, mass: arm.m2, inertia: arm.i2 },
    ]
}

fn fixed_size<const N: usize>(robot: RobotDescription) -> FixedSize<N> {
    FixedSize::new(Model::new(robot).unwrap()).unwrap()
}

/// Asserts that every term agrees at 100 states, to 1e-12 of entries of order 1 to 30.
fn assert_same<const N: usize>(a: &impl Dynamics<N>, b: &impl Dynamics<N>) {
    for laws::Sample { index, q, qd, u, qdd, .. } in laws::States::<N>::new(11).count(100).iter() {
        let close =
            |law: &str, defect: f64| assert!(defect < 1e-12, "{law}: {defect:e} at state {index}, q {q}");
        close("M", (a.mass(&q) - b.mass(&q)).amax());
        close("C q̇", (a.velocity_product(&q, &qd) - b.velocity_product(&q, &qd)).amax());
        close("C", (a.coriolis_matrix(&q, &qd) - b.coriolis_matrix(&q, &qd)).amax());
        close("g", (a.gravity(&q) - b.gravity(&q)).amax());
        close("V", (a.potential_energy(&q) - b.potential_energy(&q)).abs());
        close("K", (a.kinetic_energy(&q, &qd) - b.kinetic_energy(&q, &qd)).abs());
        // κ(M) of these arms reaches 100, forces 100 N·m.
        close("q̈", (a.forward(&q, &qd, &u) - b.forward(&q, &qd, &u)).amax() / 100.0);
        close("u", (a.inverse(&q, &qd, &qdd) - b.inverse(&q, &qd, &qdd)).amax() / 10.0);
    }
}

#[test]
fn two_links_match_reach_2r() {
    let closed_form = Reach2R::worked_example();
    let robot = fixed_size::<2>(described(&reach_2r_links(&closed_form), 9.81));
    assert_same(&robot, &closed_form);
    assert_same(&robot.by_lagrange(), &closed_form);
}

#[test]
fn three_links_match_reach_3r() {
    let closed_form = PlanarArm::reach_3r();
    let robot = fixed_size::<3>(described(&closed_form.links, closed_form.a_g));
    assert_same(&robot, &closed_form);
    assert_same(&robot.by_lagrange(), &closed_form);
}

/// The run of the worked example, 10 s of RK4 at 1 ms: the same drift, to the rounding of 10 000 steps.
#[test]
fn integrators_run_on_a_described_robot() {
    let closed_form = Reach2R::worked_example();
    let robot = fixed_size::<2>(described(&reach_2r_links(&closed_form), 9.81));
    let (q0, rest) = (vector![PI / 4.0, PI / 2.0], SVector::<f64, 2>::zeros());
    let drift = |system: &dyn Dynamics<2>| {
        energy_drift(system, &q0, &rest, &rest, 1e-3, 10_000, Integrator::RungeKutta4).unwrap()
    };
    let (tree, exact) = (drift(&robot), drift(&closed_form));
    // The motion is chaotic: a rounding of 1e-16 grows over the run, and E is sampled along it.
    assert!((tree - exact).abs() < 1e-10, "drift {tree:e} of the tree, {exact:e} of the closed form");
    assert!((1.1e-8..1.4e-8).contains(&tree), "drift {tree:e}");
    for integrator in Integrator::ALL {
        let (a, _) = integrator.step(&robot, &q0, &rest, &rest, 1e-3).unwrap();
        let (b, _) = integrator.step(&closed_form, &q0, &rest, &rest, 1e-3).unwrap();
        assert!((a - b).norm() < 1e-14, "{integrator}: {a} {b}");
    }
}

/// A random robot of N coordinates with single-coordinate joints, mimic joints and all passive forces.
fn random_of_size<const N: usize>(seed: u64, mimic: f64) -> FixedSize<N> {
    // Mimic joints share coordinates: joints are added until N coordinates remain.
    for joints in N.. {
        let options = RandomRobotOptions {
            joints,
            kinds: if mimic > 0.0 { JointKinds::SingleDof } else { JointKinds::Turning },
            mimic,
            passive: 0.7,
            ..Default::default()
        };
        let model = Model::new(random_robot(seed, &options)).unwrap();
        if model.nv() == N {
            return FixedSize::new(model).unwrap();
        }
    }
    unreachable!()
}

/// All laws by both routes: the recursions are the `Dynamics`, the Lagrange recipe is the `Lagrangian`.
#[test]
fn every_law_holds_on_described_robots() {
    let states = || laws::States::<4>::new(3).count(40);
    for seed in 0..6 {
        let name = format!("random robot {seed}");
        let arm = random_of_size::<4>(seed, 0.0).without_dissipation();
        laws::check_all(&name, &arm, &states()).unwrap();
        laws::check_all(&format!("{name} by Lagrange"), &arm.by_lagrange(), &states()).unwrap();
        laws::check_all(&format!("{name} with dissipation"), &random_of_size::<4>(seed, 0.0), &states())
            .unwrap();
        laws::check_all(
            &format!("{name} with mimic joints"),
            &random_of_size::<3>(seed, 0.4),
            &laws::States::new(3).count(40),
        )
        .unwrap();
    }
    laws::check_all("seven joints", &random_of_size::<7>(1, 0.0), &laws::States::new(4).count(10)).unwrap();
}

/// The forces without dissipation differ from those with it by exactly the dissipation.
#[test]
fn dissipation_can_be_switched_off() {
    let arm = random_of_size::<4>(2, 0.0);
    let (q, qd) = (SVector::<f64, 4>::repeat(0.2), vector![1.0, -1.0, 0.5, 2.0]);
    let b = arm.dissipation(&q, &qd);
    assert!(b.dot(&qd) > 0.0, "this robot has damping: {b}");
    let free = arm.clone().without_dissipation();
    let zero = SVector::<f64, 4>::zeros();
    assert_eq!(free.dissipation(&q, &qd), zero);
    let difference = arm.inverse(&q, &qd, &zero) - free.inverse(&q, &qd, &zero);
    assert!((difference - b).norm() < 1e-14 * arm.bias(&q, &qd).norm());
}

#[test]
fn wrong_size_is_an_error() {
    let model = Arc::new(Model::new(described(&PlanarArm::reach_3r().links, 9.81)).unwrap());
    let error = FixedSize::<6>::new(Arc::clone(&model)).unwrap_err();
    assert!(matches!(error, FixedSizeError::WrongSize { expected: 6, found: 3, .. }));
    assert_eq!(FixedSize::<3>::new(model).unwrap().model().nv(), 3);
}

#[test]
fn quaternion_joint_is_an_error() {
    let mut robot = described(&PlanarArm::reach_3r().links, 9.81);
    robot.base = Base::Floating;
    let error = FixedSize::<9>::new(Model::new(robot).unwrap()).unwrap_err();
    let (robot, joint) = ("arm".to_owned(), "floating_base".to_owned());
    assert_eq!(error, FixedSizeError::QuaternionJoint { robot, joint, kind: "floating" });
}

/// Two joints about one axis without inertia between them: checks of single links miss this, the
/// factorisation finds it.
#[test]
fn singular_pose_is_an_error() {
    let mut robot = described(&[Link::rod(1.0, 2.0), Link::rod(1.0, 1.0)], 9.81);
    // A second joint at the same position about the same axis, without inertia between them.
    robot.links.push(LinkDescription::new("ghost", None));
    robot.joints[1].child = "ghost".into();
    robot.joints.push(JointDescription::new(
        "double",
        JointKind::Revolute { axis: [0.0, -1.0, 0.0] },
        "ghost",
        "link1",
        Pose::IDENTITY,
    ));
    let arm = fixed_size::<3>(robot);
    let zero = SVector::<f64, 3>::zeros();
    let error = arm.try_forward(&vector![0.1, 0.2, 0.3], &zero, &zero).unwrap_err();
    assert!(matches!(error, IntegratorError::SingularMass { coordinate: 2, .. }), "{error}");
    let error = arm.try_forward(&vector![0.1, f64::NAN, 0.3], &zero, &zero).unwrap_err();
    let IntegratorError::Input(input) = &error else { panic!("{error}") };
    let InvalidInput { quantity, problem, .. } = &**input;
    assert_eq!(quantity, "q");
    assert!(matches!(problem, InputProblem::NotFinite { index: Some(1), .. }), "{error}");
}

/// g of a spring and of the spring of a mimic joint: V = ½ k (q − rest)² + ½ k (r q + c − rest)².
#[test]
fn spring_forces_match_hand_calculation() {
    let mut robot = described(&[Link::rod(1.0, 2.0), Link::rod(1.0, 1.0)], 0.0);
    for joint in &mut robot.joints {
        joint.passive = PassiveForces::default().with_armature(0.1).with_spring(3.0, 0.5);
    }
    robot.joints[1].mimic = Some(Mimic::new("joint0", -2.0, 0.3));
    let arm = fixed_size::<1>(robot);
    let q = 0.7_f64;
    let (stretch, follower) = (q - 0.5, -2.0 * q + 0.3 - 0.5);
    assert!((arm.gravity(&vector![q])[0] - 3.0 * (stretch - 2.0 * follower)).abs() < 1e-14);
    let energy = 1.5 * (stretch * stretch + follower * follower);
    assert!((arm.potential_energy(&vector![q]) - energy).abs() < 1e-14);
    // Both rotors: 0.1 (1 + 4), in addition to the M11 − 4 M12 + 4 M22 of the bodies.
    let m = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0).mass(&vector![q, -2.0 * q + 0.3]);
    let expected = m[(0, 0)] - 4.0 * m[(0, 1)] + 4.0 * m[(1, 1)] + 0.5;
    assert!((arm.mass(&vector![q])[(0, 0)] - expected).abs() < 1e-14);
}

/// A free body obeys Newton's and Euler's equations in its own axes, by either route:
/// F = m (u̇ + ω × u + ω̇ × c + ω × (ω × c) − Rᵀg), N = 𝓘_c ω̇ + ω × 𝓘_c ω + c × F. (PRM 10.44)
#[test]
fn free_body_obeys_newton_and_euler() {
    let center = Vector3::new(0.1, -0.2, 0.3);
    let inertia = Matrix3::new(0.5, 0.05, -0.02, 0.05, 0.6, 0.03, -0.02, 0.03, 0.4);
    let mut robot = RobotDescription::new("stone");
    robot.base = Base::Floating;
    let properties = MassProperties::new(2.0, center, inertia).ok();
    robot.links.push(LinkDescription::new("stone", properties));
    let model = Model::new(robot).unwrap();
    let mut random = SplitMix64::new(8);
    for _ in 0..100 {
        let RandomState { q, v, a, .. } = random_state(&model, &mut random);
        let part = |x: &[f64], i: usize| Vector3::new(x[i], x[i + 1], x[i + 2]);
        let (u, w, du, dw) = (part(&v, 0), part(&v, 3), part(&a, 0), part(&a, 3));
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
        let weight = turn.inverse() * Vector3::new(0.0, 0.0, -9.81);
        let force = (du + w.cross(&u) + dw.cross(&center) + w.cross(&w.cross(&center)) - weight) * 2.0;
        let moment = inertia * dw + w.cross(&(inertia * w)) + center.cross(&force);
        let mut tau = vec![0.0; 6];
        inverse_dynamics(&model, &mut Workspace::new(&model), &q, &v, &a, &mut tau);
        for tau in [tau, lagrange::inverse_dynamics(&model, &q, &v, &a)] {
            // Forces of up to 100 N: a hundred roundings.
            let defect = (part(&tau, 0) - force).norm() + (part(&tau, 3) - moment).norm();
            assert!(defect < 1e-12, "off by {defect:e} at q {q:?}, v {v:?}, a {a:?}");
        }
    }
}

/// A robot with quaternion joints has no Christoffel symbols.
#[test]
fn christoffel_symbols_of_quaternions_panic() {
    let families = families();
    let robot: Robot = families.iter().find(|f| f.name == "floating trees").unwrap().robots().next().unwrap();
    let call = std::panic::AssertUnwindSafe(|| drop(lagrange::christoffel(&robot.model, &robot.state.q)));
    assert!(std::panic::catch_unwind(call).is_err());
}
