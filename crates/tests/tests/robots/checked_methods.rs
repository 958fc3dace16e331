//! The checked methods of `Model` return the numbers of the free functions, and an error for each invalid
//! input.

use nalgebra::{DMatrix, Vector3};
use robot_dynamics::algorithms::{MotionError, ReferenceFrame};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{FrameId, Model, Workspace};
use robot_dynamics::{InputProblem, InvalidInput};

use crate::common::families;

/// Row-major entries, as the free functions write them.
fn rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// Methods and functions run the same code, so they agree bit for bit.
#[test]
fn methods_match_free_functions() {
    for robot in families().iter().flat_map(|family| family.robots().take(5)) {
        let (model, nv) = (&robot.model, robot.model.nv());
        let s = &robot.state;
        let (q, v, a, tau) = (&s.q[..], &s.v[..], &s.a[..], &s.tau[..]);
        let w = &mut Workspace::new(model);
        let frame: FrameId = model.frame(&model.frames()[model.frames().len() - 1].name).expect("a frame");
        let (mut x, mut m, mut j) = (vec![0.0; nv], vec![0.0; nv * nv], vec![0.0; 6 * nv]);

        robot_dynamics::algorithms::mass_matrix(model, w, q, &mut m);
        assert_eq!(rows(&model.mass_matrix(q).unwrap()), m);
        robot_dynamics::algorithms::inverse_mass_matrix(model, w, q, &mut m);
        assert_eq!(rows(&model.inverse_mass_matrix(q).unwrap()), m);
        robot_dynamics::algorithms::coriolis_matrix(model, w, q, v, &mut m);
        assert_eq!(rows(&model.coriolis_matrix(q, v).unwrap()), m);
        robot_dynamics::algorithms::velocity_product(model, w, q, v, &mut x);
        assert_eq!(model.velocity_product(q, v).unwrap().as_slice(), x);
        robot_dynamics::algorithms::gravity(model, w, q, &mut x);
        assert_eq!(model.gravity_forces(q).unwrap().as_slice(), x);
        robot_dynamics::algorithms::bias(model, w, q, v, &mut x);
        assert_eq!(model.bias(q, v).unwrap().as_slice(), x);
        robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, &mut x);
        assert_eq!(model.inverse_dynamics(q, v, a).unwrap().as_slice(), x);
        robot_dynamics::algorithms::forward_dynamics(model, w, q, v, tau, &mut x);
        assert_eq!(model.forward_dynamics(q, v, tau).unwrap().as_slice(), x);
        assert_eq!(
            model.kinetic_energy(q, v).unwrap(),
            robot_dynamics::algorithms::kinetic_energy(model, w, q, v)
        );
        assert_eq!(
            model.potential_energy(q).unwrap(),
            robot_dynamics::algorithms::potential_energy(model, w, q)
        );
        assert_eq!(
            model.center_of_mass(q).unwrap().as_slice(),
            robot_dynamics::algorithms::center_of_mass(model, w, q)
        );
        let momentum = robot_dynamics::algorithms::centroidal_momentum(model, w, q, v);
        assert_eq!(model.centroidal_momentum(q, v).unwrap(), momentum);
        robot_dynamics::algorithms::centroidal_momentum_matrix(model, w, q, &mut j);
        assert_eq!(rows(&model.centroidal_momentum_matrix(q).unwrap()), j);
        assert_eq!(
            model.frame_pose(q, frame).unwrap().rotation,
            robot_dynamics::algorithms::frame_pose(model, w, q, frame).rotation
        );
        for seen in ReferenceFrame::ALL {
            robot_dynamics::algorithms::frame_jacobian(model, w, q, frame, seen, &mut j);
            assert_eq!(rows(&model.frame_jacobian(q, frame, seen).unwrap()), j);
        }
        robot_dynamics::algorithms::center_of_mass_jacobian(model, w, q, &mut j[..3 * nv]);
        assert_eq!(rows(&model.center_of_mass_jacobian(q).unwrap()), &j[..3 * nv]);
        let mut y = vec![0.0; nv * robot_dynamics::algorithms::inertial_parameters(model).len()];
        robot_dynamics::algorithms::joint_torque_regressor(model, w, q, v, a, &mut y);
        assert_eq!(rows(&model.joint_torque_regressor(q, v, a).unwrap()), y);
    }
}

/// `yaw` and `spin` turn about the same axis at pitch 0, and the first link is a point on it. M is singular
/// there and only there.
fn gimbal() -> Model {
    let mut robot = RobotDescription::new("gimbal");
    let mass = |at: [f64; 3]| MassProperties::point(1.0, Vector3::from(at)).ok();
    robot.links.push(LinkDescription::new("base", None));
    robot.links.push(LinkDescription::new("ring", mass([0.0, 0.0, 0.5])));
    robot.links.push(LinkDescription::new("fork", mass([0.0, 0.0, 0.3])));
    robot.links.push(LinkDescription::new("rotor", mass([0.0, 0.4, 0.2])));
    let turn = |name: &str, axis, parent: &str, child: &str| {
        JointDescription::new(name, JointKind::Revolute { axis }, parent, child, Pose::IDENTITY)
    };
    robot.joints.push(turn("yaw", [0.0, 0.0, 1.0], "base", "ring"));
    robot.joints.push(turn("pitch", [0.0, 1.0, 0.0], "ring", "fork"));
    robot.joints.push(turn("spin", [0.0, 0.0, 1.0], "fork", "rotor"));
    Model::new(robot).expect("a robot")
}

/// At pitch 0, yaw and spin turn the same mass about the same axis; elsewhere they do not.
#[test]
fn singular_mass_names_its_joints() {
    let model = gimbal();
    let zero = [0.0; 3];
    let error = model.forward_dynamics(&zero, &zero, &zero).unwrap_err();
    let MotionError::SingularMass(mass) = &error else { panic!("{error}") };
    let [motion] = &mass.motions[..] else { panic!("{error}") };
    assert_eq!((motion.joints.join(" "), motion.index), ("yaw spin".to_owned(), 0));
    assert!(motion.pivot.abs() < 1e-15 && (0.1..1.0).contains(&motion.inertia), "{motion:?}");
    let error = model.inverse_mass_matrix(&zero).unwrap_err();
    assert!(matches!(error, MotionError::SingularMass(_)), "{error}");
    let error = model.forward_dynamics_derivatives(&zero, &zero, &zero).unwrap_err();
    assert!(matches!(error, MotionError::SingularMass(_)), "{error}");
    assert!(model.forward_dynamics(&[0.0, 0.5, 0.0], &zero, &zero).is_ok());
    assert!(model.mass_matrix(&zero).is_ok());
}

#[test]
fn errors_name_quantity_and_coordinate() {
    let model = gimbal();
    let input = |error| match error {
        MotionError::Input(error) => error,
        other => panic!("{other}"),
    };
    let (good, zero) = ([0.1, 0.2, 0.3], [0.0; 3]);
    let error = model.inverse_dynamics(&good, &[0.0, f64::NAN, 0.0], &zero).unwrap_err();
    let InvalidInput { quantity, problem, .. } = input(error);
    assert_eq!(quantity, "v");
    assert!(
        matches!(&problem, InputProblem::NotFinite { index: Some(1), coordinate: Some(coordinate), value }
            if coordinate == "pitch" && value.is_nan()),
        "{problem:?}"
    );
    let error = input(model.forward_dynamics(&good, &zero, &[0.0, 0.0, f64::INFINITY]).unwrap_err());
    let (index, coordinate, value) = (Some(2), Some("spin".to_owned()), f64::INFINITY);
    assert_eq!(error, InvalidInput::new("tau", InputProblem::NotFinite { index, coordinate, value }));
    let InvalidInput { quantity, problem, .. } = input(model.bias(&good, &[0.0; 4]).unwrap_err());
    assert_eq!(quantity, "v");
    let InputProblem::WrongLength { found: 4, expected: 3, owner, .. } = problem else {
        panic!("{problem:?}")
    };
    assert_eq!(owner, "robot `gimbal`");
    let InvalidInput { quantity, problem, .. } = input(model.mass_matrix(&[0.0, f64::NAN, 0.0]).unwrap_err());
    assert_eq!(quantity, "q");
    assert!(matches!(problem, InputProblem::NotFinite { index: Some(1), .. }), "{problem:?}");
    let InvalidInput { quantity, problem, .. } =
        input(model.velocity_product(&good, &[1e200; 3]).unwrap_err());
    assert_eq!(quantity, "C v");
    assert!(matches!(problem, InputProblem::Overflow { .. }), "{problem:?}");
}

/// The mass and the centre of mass count the same links: the links that move, or all links if those that move
/// have no mass.
#[test]
fn mass_and_center_count_the_same_links() {
    let point = |mass: f64, at: [f64; 3]| MassProperties::point(mass, at.into()).ok();
    let build = |arm: Option<MassProperties>| {
        let mut robot = RobotDescription::new("crane");
        robot.links.push(LinkDescription::new("ground", None));
        robot.links.push(LinkDescription::new("base", point(3.0, [1.0, 0.0, 0.0])));
        robot.links.push(LinkDescription::new("arm", arm));
        let turned = Pose {
            rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.0, 0.0, 2.0],
        };
        robot.joints.push(JointDescription::new("mount", JointKind::Fixed, "ground", "base", turned));
        let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
        robot.joints.push(JointDescription::new("hinge", hinge, "base", "arm", Pose::IDENTITY));
        Model::new(robot).expect("a robot")
    };
    let model = build(point(1.0, [0.0, 0.0, 1.0]));
    assert_eq!((model.mass(), model.total_mass()), (1.0, 4.0));
    assert_eq!(model.center_of_mass(&[0.0]).unwrap(), Vector3::new(0.0, 0.0, 3.0));
    // A quarter turn of the base maps its x axis to y.
    let model = build(None);
    assert_eq!((model.mass(), model.total_mass()), (3.0, 3.0));
    assert_eq!(model.center_of_mass(&[0.7]).unwrap(), Vector3::new(0.0, 1.0, 2.0));
    assert!(model.center_of_mass_jacobian(&[0.7]).unwrap().iter().all(|entry| *entry == 0.0));
}

/// A robot with one fixed link has empty matrices, a centre of mass, and a frame pose.
#[test]
fn robot_without_joints_has_empty_matrices() {
    let mut robot = RobotDescription::new("post");
    let mass = MassProperties::point(1.0, Vector3::new(0.0, 0.0, 0.5)).ok();
    robot.links.push(LinkDescription::new("post", mass));
    let model = Model::new(robot).expect("a robot");
    assert_eq!(model.mass_matrix(&[]).unwrap().shape(), (0, 0));
    assert_eq!(model.inverse_mass_matrix(&[]).unwrap().shape(), (0, 0));
    assert_eq!(model.coriolis_matrix(&[], &[]).unwrap().shape(), (0, 0));
    assert_eq!(model.forward_dynamics(&[], &[], &[]).unwrap().len(), 0);
    assert_eq!(model.joint_torque_regressor(&[], &[], &[]).unwrap().shape(), (0, 0));
    assert_eq!(model.kinetic_energy(&[], &[]).unwrap(), 0.0);
    let post = model.frame("post").expect("the link");
    assert_eq!(model.frame_pose(&[], post).unwrap(), Pose::IDENTITY);
    assert_eq!(model.frame_jacobian(&[], post, ReferenceFrame::World).unwrap().shape(), (6, 0));
    assert_eq!((model.mass(), model.center_of_mass(&[]).unwrap()), (1.0, Vector3::new(0.0, 0.0, 0.5)));
    let mut robot = model.description().clone();
    robot.links[0].mass_properties = None;
    let model = Model::new(robot).expect("a robot");
    assert!(model.mass() == 0.0 && model.mass().is_sign_positive() && model.total_mass().is_sign_positive());
    let error = model.center_of_mass(&[]).unwrap_err();
    assert!(matches!(&error, MotionError::NoMass { robot } if robot == "post"), "{error}");
}
