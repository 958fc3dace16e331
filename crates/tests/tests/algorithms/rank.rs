//! Robots whose mass matrix is singular, everywhere or in some poses, and robots that are ill-conditioned but
//! regular.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::{MotionError, check_rank, mass_rank};
use robot_dynamics::constraints::{
    ConstraintError, ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis,
    constrained_forward_dynamics,
};
use robot_dynamics::control::operational_space;
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, LinkDescription, MassProperties, Mimic, Pose, RobotDescription,
};
use robot_dynamics::model::{InstructionSet, Model, Workspace, lock_massless, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    ControllerError, Effect, Integrator, Method, RunError, RunOptions, SimulationBuilder, StepError,
    StepForces,
};

use crate::common::families;

fn turn(axis: [f64; 3]) -> JointKind {
    JointKind::Revolute { axis }
}

fn slide(axis: [f64; 3]) -> JointKind {
    JointKind::Prismatic { axis }
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// A chain on a massless base. Each link has a joint, the position of the joint on the previous link, and a
/// mass.
fn chain(links: &[(&str, JointKind, [f64; 3], Option<MassProperties>)]) -> RobotDescription {
    let mut robot = RobotDescription::new("chain");
    robot.links.push(LinkDescription::new("base", None));
    for (i, (name, kind, at, mass_properties)) in links.iter().enumerate() {
        let parent = robot.links[i].name.clone();
        let child = format!("link{i}");
        robot.links.push(LinkDescription::new(child.clone(), *mass_properties));
        robot.joints.push(JointDescription::new(*name, *kind, parent, child, Pose::from_translation(*at)));
    }
    robot
}

/// A body off all axes with a mass of 1 kg times `scale`.
fn body(scale: f64) -> Option<MassProperties> {
    MassProperties::new(scale, Vector3::new(0.1, 0.03, 0.2), Matrix3::identity() * (0.01 * scale)).ok()
}

const HERE: [f64; 3] = [0.0; 3];

/// The joints of each motion that moves no inertia.
fn idle(model: &Model, q: &[f64]) -> Vec<String> {
    let motions = model.singular_motions(q).unwrap();
    assert_eq!(mass_rank(model, &mut Workspace::new(model), q), model.nv() - motions.len());
    assert_eq!(
        mass_rank(model, &mut Workspace::limited(model, InstructionSet::Portable), q),
        model.nv() - motions.len()
    );
    motions.iter().map(|motion| motion.joints.join(" ")).collect()
}

/// Random poses, including quaternions.
fn poses(model: &Model, count: u64) -> impl Iterator<Item = Vec<f64>> + '_ {
    (0..count).map(|seed| random_state(model, &mut SplitMix64::new(seed)).q)
}

/// Wrists and slides with more degrees of freedom than the inertia between them allows: singular in every
/// pose, with the joints that take part.
#[test]
fn redundant_joints_are_singular_in_every_pose() {
    let coaxial =
        |second| chain(&[("one", turn(Z), HERE, None), ("two", turn(second), [0.0, 0.0, 0.3], body(1.0))]);
    for second in [Z, [0.0, 0.0, -1.0]] {
        let model = Model::new(coaxial(second)).unwrap();
        assert!(poses(&model, 20).all(|q| idle(&model, &q) == ["one two"]), "{second:?}");
    }
    let slides = chain(&[
        ("x", slide(X), HERE, None),
        ("y", slide(Y), HERE, None),
        ("again", slide(X), HERE, None),
        ("z", slide(Z), HERE, body(1.0)),
    ]);
    let model = Model::new(slides).unwrap();
    assert!(poses(&model, 20).all(|q| idle(&model, &q) == ["x again"]));
    // Four turns about one point: some combination of them turns nothing, for any axes. If the last three are
    // nearly coplanar, the pivot of the first is amplified noise.
    let wrist = chain(&[
        ("one", turn(Z), HERE, None),
        ("two", turn(Y), HERE, None),
        ("three", turn(X), HERE, None),
        ("four", turn(Z), HERE, body(1.0)),
    ]);
    let model = Model::new(wrist).unwrap();
    for q in poses(&model, 200) {
        assert_eq!(idle(&model, &q).len(), 1, "{q:?}");
    }
    for k in 1..8 {
        let q = [0.3, 0.4, std::f64::consts::FRAC_PI_2 - 10f64.powi(-k), 0.7];
        assert_eq!(idle(&model, &q).len(), 1, "{q:?}");
    }
    // A floating joint on a floating base with a massless link between them: all six motions are redundant.
    let mut twice = chain(&[
        ("inner", JointKind::Floating, [0.2, 0.1, 0.0], body(1.0)),
        ("arm", turn(Y), HERE, body(0.5)),
    ]);
    twice.base = Base::Floating;
    let model = Model::new(twice).unwrap();
    for q in poses(&model, 20) {
        let motions = model.singular_motions(&q).unwrap();
        assert_eq!(motions.len(), 6);
        for motion in &motions {
            assert_eq!(motion.joints, ["floating_base", "inner"], "{motion:?}");
        }
        let error = check_rank(&model, &mut Workspace::new(&model), &q).unwrap_err();
        assert_eq!(error.joints(), ["floating_base", "inner"], "each once");
    }
}

/// A gimbal with massless rings is singular where its first and third axes coincide.
#[test]
fn singular_in_some_poses_only() {
    let gimbal = chain(&[
        ("yaw", turn(Z), HERE, None),
        ("pitch", turn(Y), HERE, None),
        ("roll", turn(X), HERE, body(1.0)),
    ]);
    let model = Model::new(gimbal).unwrap();
    assert!(idle(&model, &[0.3, 0.0, 0.2]).is_empty());
    let quarter = std::f64::consts::FRAC_PI_2;
    for pitch in [quarter, -quarter] {
        assert_eq!(idle(&model, &[0.3, pitch, 0.2]), ["yaw roll"]);
    }
    // A ten-thousandth of a degree away M is ill-conditioned but regular.
    assert!(idle(&model, &[0.3, quarter - 1e-6, 0.2]).is_empty());
    // A point mass at the end of two equal rods: if the arm is folded, it lies on the first axis.
    let rod = |at: [f64; 3]| MassProperties::point(1.0, Vector3::from(at)).ok();
    let arm = chain(&[("one", turn(Z), HERE, None), ("two", turn(Z), X, rod(X))]);
    let model = Model::new(arm).unwrap();
    assert!(idle(&model, &[0.4, 1.0]).is_empty());
    for q in [[0.4, std::f64::consts::PI], [2.0, -std::f64::consts::PI]] {
        assert_eq!(idle(&model, &q), ["one"]);
    }
    // If the arm is stretched, both joints move the mass along one line.
    assert_eq!(idle(&model, &[0.4, 0.0]), ["one two"]);
}

/// Joints without inertia in every pose are found when the robot is compiled, and again from the pivots.
#[test]
fn massless_leaves_are_singular() {
    let mut robot = chain(&[
        ("arm", turn(Y), HERE, body(1.0)),
        ("finger", slide(X), HERE, None),
        ("nail", turn(Z), HERE, None),
    ]);
    let model = Model::new(robot.clone()).unwrap();
    assert_eq!(model.massless_joints().collect::<Vec<_>>(), ["finger", "nail"]);
    for q in poses(&model, 10) {
        assert_eq!(idle(&model, &q), ["nail", "finger"]);
        // Quantities without M⁻¹ are defined.
        let (v, a) = ([0.1, 0.2, 0.3], [1.0, 2.0, 3.0]);
        let tau = model.inverse_dynamics(&q, &v, &a).unwrap();
        assert_eq!((tau[1], tau[2]), (0.0, 0.0));
        assert_eq!(model.mass_matrix(&q).unwrap()[(1, 1)], 0.0);
    }
    let error = model.forward_dynamics(&[0.0; 3], &[0.0; 3], &[0.0; 3]).unwrap_err();
    let MotionError::SingularMass(mass) = &error else { panic!("{error}") };
    assert_eq!(mass.joints(), ["finger", "nail"]);
    // With these joints locked the arm equals the arm without them.
    assert_eq!(lock_massless(&mut robot).unwrap(), ["finger", "nail"]);
    let locked = Model::new(robot).unwrap();
    assert_eq!((locked.nv(), locked.massless_joints().count()), (1, 0));
    let bare = Model::new(chain(&[("arm", turn(Y), HERE, body(1.0))])).unwrap();
    assert_eq!(
        locked.forward_dynamics(&[0.3], &[0.2], &[0.1]),
        bare.forward_dynamics(&[0.3], &[0.2], &[0.1])
    );
}

/// A joint that moves only massless joints becomes massless once they are locked. A massless floating base is
/// fixed.
#[test]
fn locking_repeats_until_no_joint_is_massless() {
    let on_axis = MassProperties::point(1.0, Vector3::new(0.0, 0.0, 0.5)).ok();
    let mut robot = chain(&[("one", turn(Z), HERE, None), ("two", turn(Z), HERE, on_axis)]);
    assert_eq!(Model::new(robot.clone()).unwrap().massless_joints().collect::<Vec<_>>(), ["two"]);
    assert_eq!(lock_massless(&mut robot).unwrap(), ["two", "one"]);
    let mut stone = RobotDescription::new("stone");
    stone.base = Base::Floating;
    stone.links.push(LinkDescription::new("stone", None));
    assert_eq!(lock_massless(&mut stone).unwrap(), ["floating_base"]);
    assert_eq!((stone.base, Model::new(stone).unwrap().nv()), (Base::Fixed, 0));
    // A joint is locked at its limit if zero is beyond it, a ball joint at the identity.
    let mut robot = chain(&[
        ("slide", slide(X), HERE, body(1.0)),
        ("finger", turn(X), HERE, None),
        ("ball", JointKind::Spherical, HERE, None),
    ]);
    robot.joints[1].limits.lower = 0.25;
    assert_eq!(robot.resting_position("finger").unwrap(), [0.25]);
    assert_eq!(robot.resting_position("ball").unwrap(), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(lock_massless(&mut robot).unwrap(), ["finger", "ball"]);
    assert_eq!(Model::new(robot).unwrap().nv(), 1);
}

/// Mimic joints: the leader carries their inertia, and a coordinate combination without inertia is found in
/// M_y.
#[test]
fn mimic_joints_carry_inertia_to_leaders() {
    let mut fingers = chain(&[
        ("one", turn(Z), HERE, None),
        ("two", turn(Z), HERE, body(1.0)),
        ("tip", turn(Y), X, body(0.1)),
    ]);
    let follow = |leader: &str, ratio: f64| Some(Mimic::new(leader, ratio, 0.1));
    // The mimic joint reverses the turn of its leader, so that the body does not turn: M_y vanishes along it.
    fingers.joints[1].mimic = follow("one", -1.0);
    let model = Model::new(fingers.clone()).unwrap();
    assert!(poses(&model, 20).all(|q| idle(&model, &q) == ["one"]));
    fingers.joints[1].mimic = follow("one", -0.5);
    let model = Model::new(fingers).unwrap();
    assert!(poses(&model, 20).all(|q| idle(&model, &q).is_empty()));
    // Two coaxial coordinates, independent of a mimic joint further along the chain.
    let mut coaxial = chain(&[
        ("one", turn(Z), HERE, None),
        ("two", turn(Z), HERE, body(1.0)),
        ("three", turn(Y), X, body(0.1)),
        ("four", turn(Y), X, body(0.1)),
    ]);
    coaxial.joints[3].mimic = follow("three", 0.7);
    let model = Model::new(coaxial.clone()).unwrap();
    assert!(poses(&model, 20).all(|q| idle(&model, &q) == ["one two"]));
    // A massless leader with a massless mimic joint.
    coaxial.links[1].mass_properties = body(1.0);
    coaxial.links[3].mass_properties = None;
    coaxial.links[4].mass_properties = None;
    let model = Model::new(coaxial).unwrap();
    assert_eq!(model.massless_joints().collect::<Vec<_>>(), ["three"]);
    assert!(poses(&model, 20).all(|q| idle(&model, &q) == ["three"]));
}

/// Robots of any scale and any mass ratio that f64 can represent are regular, independent of the units, as
/// long as the ratio leaves digits. The digits of the last robot are lost.
#[test]
fn rank_is_independent_of_scale() {
    let arm = |masses: [f64; 3], size: f64| {
        let link = |mass: f64| {
            let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 1.1, 0.9)) * (0.01 * mass * size * size);
            MassProperties::new(mass, Vector3::new(0.3, 0.02, 0.1) * size, inertia).ok()
        };
        let at = [size, 0.0, 0.0];
        Model::new(chain(&[
            ("one", turn(Y), HERE, link(masses[0])),
            ("two", turn([0.1, 1.0, 0.2]), at, link(masses[1])),
            ("three", slide([0.3, 0.2, 1.0]), at, link(masses[2])),
        ]))
        .unwrap()
    };
    for (masses, size) in [
        ([1.0; 3], 1.0),
        ([1e-15; 3], 1e-9),
        ([1e-30; 3], 1e-20),
        ([1e24; 3], 1e7),
        ([1.0, 1e-6, 1e-12], 1.0),
        ([1e-12, 1e-6, 1.0], 1.0),
        ([1.0, 1e-12, 1.0], 1.0),
        ([1e-12, 1.0, 1e-12], 1.0),
        ([1.0, 1e-30, 1e-60], 1.0),
    ] {
        let model = arm(masses, size);
        for mut q in poses(&model, 50) {
            q[2] *= size;
            assert_eq!(idle(&model, &q), [""; 0], "masses {masses:?}, size {size}, {q:?}");
        }
    }
    // Two coaxial joints with a tiny body between them: an inertia of 1e-13 of the last body's is still
    // visible, one of 1e-17 is not.
    let speck = |mass: f64| {
        let axis =
            |mass: f64| MassProperties::new(mass, Vector3::zeros(), Matrix3::identity() * (0.01 * mass)).ok();
        Model::new(chain(&[("one", turn(Z), HERE, axis(mass)), ("two", turn(Z), HERE, axis(1.0))])).unwrap()
    };
    assert!(idle(&speck(1e-13), &[0.1, 0.2]).is_empty());
    assert_eq!(idle(&speck(1e-17), &[0.1, 0.2]), ["one two"]);
    // A slide at a distance of a million kilometres.
    let rail = Model::new(chain(&[
        ("rail", slide(X), HERE, body(1.0)),
        ("arm", turn(Y), X, body(1.0)),
        ("hand", turn(Y), X, body(1e-3)),
    ]));
    assert!(idle(&rail.unwrap(), &[1e9, 0.1, 0.2]).is_empty());
}

/// Every random robot of the tests is regular.
#[test]
fn random_robots_are_regular() {
    for robot in families().iter().flat_map(crate::common::Family::robots) {
        assert_eq!(idle(&robot.model, &robot.state.q), [""; 0], "{}", robot.model.name());
    }
}

/// Functions that need M⁻¹ return an error that names the joints where M is singular; the others work.
#[test]
fn functions_with_inverse_name_singular_joints() {
    // The robot moves to where the tip passes the first axis: singular at the start only.
    let robot = chain(&[("one", turn(Z), HERE, None), ("two", turn(Z), [0.0, 0.0, 0.2], body(1.0))]);
    let model = Model::new(robot).unwrap();
    let (q, v, tau) = ([0.1, 0.2], [0.3, 0.4], [0.5, 0.6]);
    let names = ["one", "two"];
    for integrator in Integrator::ALL {
        let mut simulation = SimulationBuilder::new(&model)
            .method(Method::Fixed(integrator))
            .dt(1e-3)
            .without(Effect::Dissipation)
            .build()
            .unwrap();
        let failure = simulation.run_steps_from(&q, &v, 10, RunOptions::new()).unwrap_err();
        let RunError::SingularMass { step: 0, time: 0.0, source } = &failure.error else {
            panic!("{integrator}: {failure}")
        };
        assert_eq!(source.joints(), names, "{integrator}");
        // A run without steps needs no M⁻¹.
        assert!(simulation.run_steps_from(&q, &v, 0, RunOptions::new()).is_ok());
    }
    let workspace = &mut Workspace::new(&model);
    let frame = model.frame("link1").unwrap();
    let error = operational_space(&model, workspace, &q, &v, frame, &[SpatialAxis::X]).unwrap_err();
    let ControllerError::Motion(MotionError::SingularMass(mass)) = &error else { panic!("{error}") };
    assert_eq!(mass.joints(), names);
    let set = ConstraintSet::new(&model, [("pin", FrameConstraint::point_contact(frame, [0.0; 3]).into())])
        .unwrap();
    let options = ConstraintOptions::default();
    let error = constrained_forward_dynamics(&model, workspace, &set, &options, &q, &v, &tau).unwrap_err();
    let ConstraintError::SingularMass(mass) = &error else { panic!("{error}") };
    assert_eq!(mass.joints(), names);
    let forces = StepForces::new(&tau, false);
    let (a, b) = (&mut [0.0; 16], &mut [0.0; 8]);
    let stepping = &mut LinearizeStepWorkspace::new(&model);
    let out = LinearizedStep { by_state: a, by_force: b };
    let error = linearize_step(
        &model,
        Integrator::RungeKutta4,
        stepping,
        &forces,
        1e-3,
        RobotState { q: &q, v: &v },
        out,
    )
    .unwrap_err();
    let StepError::SingularMass(mass) = &error else { panic!("{error}") };
    assert_eq!(mass.joints(), names);
    // Finite numbers that overflow during the computation do not indicate a singular mass matrix.
    let slide =
        Model::new(chain(&[("x", slide(X), HERE, body(1.0)), ("turn", turn(Y), HERE, body(1.0))])).unwrap();
    assert_eq!(mass_rank(&slide, &mut Workspace::new(&slide), &[1e300, 0.0]), 2);
    assert!(model.bias(&q, &v).is_ok() && model.gravity_forces(&q).is_ok());
}

/// A run that reaches a singular pose ends there with its time, and its steps are kept.
#[test]
fn run_ends_where_mass_becomes_singular() {
    // The motion passes the gimbal lock at a constant 1 rad/s, a hundred steps after the start.
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut gimbal = chain(&[("yaw", turn(Z), HERE, None), ("pitch", turn(Y), HERE, None)]);
    gimbal.gravity = [0.0; 3];
    // A ball about the common point: without velocity of the outer axes it turns at constant speed.
    let ball = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity()).ok();
    gimbal.links.push(LinkDescription::new("ball", ball));
    gimbal.joints.push(JointDescription::new("roll", turn(X), "link1", "ball", Pose::IDENTITY));
    let model = Model::new(gimbal).unwrap();
    let step = 1.0 / 1024.0;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(Integrator::ExplicitEuler))
        .dt(step)
        .without(Effect::Dissipation)
        .build()
        .unwrap();
    let start = [0.0, quarter - 100.0 * step, 0.0];
    let failure = simulation.run_steps_from(&start, &[0.0, 1.0, 0.0], 200, RunOptions::new()).unwrap_err();
    let RunError::SingularMass { step: 100, time, source } = &failure.error else { panic!("{failure}") };
    assert_eq!((*time, source.joints()), (100.0 * step, vec!["yaw", "roll"]));
    assert_eq!((failure.until.steps, failure.until.trajectory.len()), (100, 101));
    assert_eq!(neutral(&model), [0.0; 3]);
}

/// Inertias as files may state them: moments without mass are inertia, negative moments are an error.
#[test]
fn negative_inertia_is_not_positive_definite() {
    let written = |mass: f64, moment: f64| {
        Some(MassProperties::as_written(mass, Vector3::zeros(), Matrix3::identity() * moment).unwrap())
    };
    let model = Model::new(chain(&[
        ("arm", turn(Y), HERE, body(1.0)),
        ("flywheel", turn(Z), HERE, written(0.0, 0.1)),
    ]));
    let model = model.unwrap();
    assert_eq!(model.massless_joints().count(), 0);
    assert!(idle(&model, &[0.1, 0.2]).is_empty());
    // A slide needs mass.
    let model =
        Model::new(chain(&[("arm", turn(Y), HERE, body(1.0)), ("slide", slide(Z), HERE, written(0.0, 0.1))]));
    assert_eq!(model.unwrap().massless_joints().collect::<Vec<_>>(), ["slide"]);
    let model = Model::new(chain(&[
        ("arm", turn(Y), HERE, body(100.0)),
        ("ghost", turn(Z), HERE, written(1.0, -0.1)),
    ]));
    let model = model.unwrap();
    assert_eq!(model.massless_joints().count(), 0);
    let error = model.forward_dynamics(&[0.1, 0.2], &[0.0; 2], &[0.0; 2]).unwrap_err();
    let MotionError::SingularMass(mass) = &error else { panic!("{error}") };
    assert_eq!(mass.joints(), ["ghost"]);
    assert!(mass.motions[0].pivot < 0.0, "{error}");
}
