//! Active effects, the chosen method, and the features that a method leaves out.

use robot_dynamics::InvalidInput;
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    ActuatorDescription, Base, Equality, EqualityDescription, Limits, LinkDescription, LinkShape,
    PassiveForces, Pose, RobotDescription, Shape, ShapeRole, TendonDescription, Transmission, pendulum,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Effect, Integrator, Method, SimulationBuilder, SimulationError};

fn method_of(change: impl Fn(&mut RobotDescription)) -> (String, String) {
    let mut robot = pendulum(2.0, 0.5);
    change(&mut robot);
    let simulation =
        SimulationBuilder::new(&Model::new(robot).expect("a robot")).build().expect("a simulation");
    (simulation.method().name().to_owned(), simulation.reason().to_owned())
}

#[test]
fn smooth_forces_are_integrated_explicitly_and_others_implicitly() {
    let damped = |robot: &mut RobotDescription, passive| robot.joints[0].passive = passive;
    assert_eq!(method_of(|_| {}).0, "rk4");
    assert_eq!(method_of(|robot| damped(robot, PassiveForces::default().with_damping(0.3))).0, "rk4");
    let servo = |gains: (f64, f64)| {
        move |robot: &mut RobotDescription| {
            let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0));
            robot.actuators.push(servo.servo(gains.0, gains.1));
        }
    };
    assert_eq!(method_of(servo((30.0, 2.0))).0, "rk4");
    let (name, reason) = method_of(servo((1e7, 0.0)));
    assert!(name == "implicit" && reason.contains("hinge"), "{reason}");
    assert_eq!(method_of(|robot| damped(robot, PassiveForces::default().with_friction(0.3))).0, "implicit");
    assert_eq!(method_of(|robot| robot.joints[0].limits = Limits::new(-1.0, 1.0)).0, "implicit");
    assert_eq!(method_of(|robot| damped(robot, PassiveForces::default().with_damping(1e4))).0, "implicit");
}

#[test]
fn conservative_simulation_keeps_energy_of_springs() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_damping(1.0).with_friction(0.5);
    robot.joints[0].limits = Limits::new(-0.1, 0.1).with_effort(1.0);
    let mut cable = TendonDescription::new("cable", [("hinge".to_owned(), 0.4)]);
    cable.passive = PassiveForces::default().with_spring(30.0, 0.0).with_damping(1.0).with_friction(0.5);
    robot.tendons.push(cable);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let model = Model::new(robot).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).conservative().build().expect("a simulation");
    assert_eq!((simulation.method().name(), simulation.control_names().count()), ("rk4", 0));
    simulation.set_torques(&[0.0]);
    simulation.run_for(2.0).expect("steps");
    assert!(simulation.energy_account().drift() < 1e-9 && simulation.energy_account().dissipated() == 0.0);
    assert!(simulation.q()[0].abs() > 0.1); // it passes its limits
    let mut all = SimulationBuilder::new(&model).build().expect("a simulation");
    all.run_for(2.0).expect("steps");
    assert!(all.q()[0].abs() <= 0.1 + 1e-9 && all.energy_account().dissipated() > 0.0);
}

#[test]
fn each_effect_can_be_switched_off_by_name() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits = Limits::new(-0.1, 0.1);
    let model = Model::new(robot).expect("a robot");
    for name in Effect::ALL.map(Effect::name) {
        let effect: Effect = name.parse().expect("a name");
        let mut simulation = SimulationBuilder::new(&model).without(effect).build().expect("a simulation");
        simulation.run_for(1.0).expect("steps");
        assert_eq!(simulation.q()[0] > 0.2, effect == Effect::Limits, "{name}");
    }
    let error = "friction".parse::<Effect>().expect_err("no effect");
    assert_eq!(error.name, "friction");
}

/// A method without joint limits lists them as left out.
#[test]
fn method_lists_what_it_leaves_out() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits = Limits::new(-0.1, 0.1);
    let pin =
        Equality::Connect { a: ("rod".into(), [0.5, 0.0, 0.0]), b: ("ceiling".into(), [0.5, 0.0, 0.0]) };
    robot.equalities.push(EqualityDescription::new("pin", pin));
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let model = Model::new(robot).expect("a robot");
    let row = Method::Fixed(Integrator::RungeKutta4);
    let simulation = SimulationBuilder::new(&model).method(row).build().expect("a simulation");
    // The position limits and the motor; the loop is held.
    assert_eq!(simulation.left_out().len(), 2, "{:?}", simulation.left_out());
    assert!(SimulationBuilder::new(&model).build().expect("a simulation").left_out().is_empty());
}

/// The loop of the file is held, by rk4 alone and by implicit steps with a motor.
#[test]
fn equalities_of_file_hold() {
    let mut robot = pendulum(2.0, 0.5);
    let pin =
        Equality::Connect { a: ("rod".into(), [0.5, 0.0, 0.0]), b: ("ceiling".into(), [0.5, 0.0, 0.0]) };
    robot.equalities.push(EqualityDescription::new("pin", pin));
    let model = Model::new(robot.clone()).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    assert_eq!(simulation.method().name(), "rk4");
    simulation.run_for(0.5).expect("steps");
    assert!(simulation.q()[0].abs() < 1e-9);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let model = Model::new(robot).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    assert_eq!(simulation.method().name(), "implicit");
    simulation.set_controls(&[3.0]);
    simulation.run_for(0.5).expect("steps");
    assert!(simulation.q()[0].abs() < 1e-9);
}

/// A joint held by an equality: the multiplier is the moment that carries the weight and the motor's torque.
#[test]
fn multipliers_of_equalities_are_constraint_forces() {
    let mut robot = pendulum(2.0, 0.5);
    let held = Equality::Joints { joint: ("hinge".into(), 0.0), leader: None, polynomial: [0.0; 5] };
    robot.equalities.push(EqualityDescription::new("lock", held));
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let model = Model::new(robot).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.set_controls(&[3.0]);
    simulation.run_for(0.5).expect("steps");
    let forces = simulation.constraint_forces();
    // Gravity turns the rod by +9.81 N m, and the motor by 3 N m.
    assert!(
        forces[0].0 == "lock.position" && (forces[0].1 + 2.0 * 9.81 * 0.5 + 3.0).abs() < 1e-6,
        "{forces:?}"
    );
}

fn ball_over(shapes: &[(Shape, [f64; 3], &str)]) -> Model {
    let mut robot = RobotDescription::new("ball");
    robot.links.push(LinkDescription::new("world", None));
    let ball = robot_dynamics::description::MassProperties::new(
        1.0,
        nalgebra::Vector3::zeros(),
        nalgebra::Matrix3::identity() * 4e-3,
    );
    robot.links.push(LinkDescription::new("ball", ball.expect("a mass")));
    let at = Pose::from_translation([0.0, 0.0, 1.0]);
    let free = robot_dynamics::description::JointDescription::new(
        "free",
        robot_dynamics::description::JointKind::Floating,
        "world",
        "ball",
        at,
    );
    robot.joints.push(free);
    robot.base = Base::Fixed;
    let sphere = Shape::Sphere { radius: 0.1 };
    robot.shapes.push(LinkShape::new("ball", ShapeRole::Collision, Pose::IDENTITY, sphere));
    for (shape, at, name) in shapes {
        let mut shape =
            LinkShape::new("world", ShapeRole::Collision, Pose::from_translation(*at), shape.clone());
        (*name).clone_into(&mut shape.name);
        robot.shapes.push(shape);
    }
    Model::new(robot).expect("a robot")
}

/// Planes and other fixed shapes of the world carry the bodies that fall on them, under both contact laws,
/// and contacts report their names.
#[test]
fn fixed_shapes_of_world_carry_bodies() {
    let plane = (Shape::Plane { half_size: [0.0; 2] }, [0.0, 0.0, 0.0], "floor");
    let post = (Shape::Sphere { radius: 0.2 }, [0.0, 0.0, 0.1], "post");
    for (shapes, height, name) in [(vec![plane.clone()], 0.1, "floor"), (vec![plane, post], 0.4, "post")] {
        let model = ball_over(&shapes);
        for method in [Method::Implicit, Method::Mujoco] {
            let mut simulation = SimulationBuilder::new(&model).method(method).build().expect("a simulation");
            simulation.run_for(2.0).expect("steps");
            let z = simulation.q()[2] + 1.0;
            assert!((z - height).abs() < 2e-3, "{name}, {method}: {z}");
            let contacts = simulation.contacts();
            let force: f64 = contacts.iter().map(|contact| contact.force[2]).sum();
            assert!(contacts[0].other_shape == name && contacts[0].link == "ball", "{contacts:?}");
            assert!((force - 9.81).abs() < 1e-3, "{name}, {method}: {force}");
        }
        let model = ball_over(&shapes);
        let mut free =
            SimulationBuilder::new(&model).without(Effect::Contacts).build().expect("a simulation");
        free.run_for(1.0).expect("steps");
        assert!((free.q()[2] + 0.5 * 9.81).abs() < 1e-9);
    }
}

/// A link on a joint of the world still touches the shapes of the world.
#[test]
fn link_on_world_joint_touches_world_shapes() {
    let mut robot =
        ball_over(&[(Shape::Sphere { radius: 0.2 }, [0.0, 0.0, 0.1], "post")]).description().clone();
    robot.joints[0].kind = robot_dynamics::description::JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
    let model = Model::new(robot).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.run_for(1.0).expect("steps");
    assert!((simulation.q()[0] + 1.0 - 0.4).abs() < 1e-6, "{:?}", simulation.q());
}

/// A shape passes through a plane of the file if their masks do not match. A ground given to the builder
/// still carries it.
#[test]
fn contact_masks_of_planes_apply() {
    let model = ball_over(&[(Shape::Plane { half_size: [0.0; 2] }, [0.0; 3], "floor")]);
    let mut robot = model.description().clone();
    (robot.shapes[1].surface.contype, robot.shapes[1].surface.conaffinity) = (2, 2);
    let model = Model::new(robot.clone()).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.run_for(1.0).expect("steps");
    assert!(simulation.q()[2] < -4.0);
    let on_ground = SimulationBuilder::new(&model).ground(Ground::level(-0.5)).build();
    let mut simulation = on_ground.expect("a simulation");
    simulation.run_for(2.0).expect("steps");
    assert!((simulation.q()[2] + 1.0 - (-0.4)).abs() < 1e-6);
    robot.shapes[0].surface.contype = 2;
    let mut simulation =
        SimulationBuilder::new(&Model::new(robot).expect("a robot")).build().expect("a simulation");
    simulation.run_for(2.0).expect("steps");
    assert!((simulation.q()[2] + 1.0 - 0.1).abs() < 1e-6);
}

#[test]
fn conflicting_options_are_errors() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let ground = SimulationBuilder::new(&model).conservative().ground(Ground::level(0.0)).build();
    assert_eq!(ground.expect_err("no contacts"), SimulationError::GroundWithoutContacts);
    let step = SimulationBuilder::new(&model).dt(0.0).build();
    assert_eq!(
        step.expect_err("no step"),
        InvalidInput::out_of_range("the step", 0.0, "s", "positive and finite").into()
    );
    let mujoco = SimulationBuilder::new(&model).method(Method::Mujoco).without(Effect::Limits).build();
    assert!(matches!(mujoco.expect_err("limits"), SimulationError::Method { .. }));
    assert_eq!("rk5".parse::<Method>().expect_err("no method").name, "rk5");
}
