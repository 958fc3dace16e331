use robot_dynamics::contact::{ContactSet, Ground, HeightField};
use robot_dynamics::description::{
    ActuatorDescription, Equality, EqualityDescription, Limits, PassiveForces, Pose, Shape, Surface,
    Transmission, pendulum,
};
use robot_dynamics::model::{Model, neutral};
use robot_dynamics::simulation::{
    DivergenceCause, Effect, Event, Integrator, Method, RunError, RunOptions, Simulation, SimulationBuilder,
};

use crate::Section;
use crate::robots::{floating_arm, gimbal, two_bodies};

fn simulation(robot: robot_dynamics::description::RobotDescription) -> Simulation {
    let model = Model::new(robot).expect("a robot");
    let builder = SimulationBuilder::new(&model).method(Method::Fixed(Integrator::RungeKutta4));
    builder.dt(1.0 / 64.0).build().expect("a simulation")
}

pub(crate) fn run_error() -> Section {
    let mut section = Section::new("RunError");
    let mut broken = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = if t > 0.1 { f64::NAN } else { 0.0 };
    };
    let options = RunOptions::new().controller(&mut broken);
    let error = simulation(pendulum(2.0, 0.5)).run_steps_from(&[0.1], &[0.0], 100, options).expect_err("NaN");
    section.row("a torque of NaN", error);
    let mut hot = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = 0.0;
        if t > 0.1 { Err("the motor is too hot") } else { Ok(()) }
    };
    let options = RunOptions::new().controller(&mut hot);
    let error = simulation(pendulum(2.0, 0.5)).run_steps_from(&[0.1], &[0.0], 100, options).expect_err("hot");
    section.row("a controller that fails", error);

    let mut floating = simulation(floating_arm());
    let mut q = neutral(&Model::new(floating_arm()).expect("a robot"));
    q[6] = 0.5;
    let error = floating.run_steps_from(&q, &[0.0; 8], 10, RunOptions::new()).expect_err("a quaternion");
    section.row("a quaternion of length 0.5 at the start", error);
    let error = simulation(gimbal()).run_steps_from(&[0.0; 3], &[0.0; 3], 10, RunOptions::new());
    section.row("a start where M is singular", error.expect_err("singular"));
    for cause in [DivergenceCause::Stiffness, DivergenceCause::Speed, DivergenceCause::Unknown] {
        let (coordinate, speed, step, time) = ("elbow".to_owned(), 2e9, 7, 0.07);
        let error: RunError =
            RunError::Diverged { coordinate, speed, step, time, suggested_step: 1e-3, cause };
        section.row(&format!("growth: {cause:?}"), error);
    }

    let mut fail = |input: &str, event: Event<'_>| {
        let events = &mut [event];
        let options = RunOptions::new().events(events);
        let error = simulation(pendulum(2.0, 0.5)).run_steps_from(&[0.3], &[0.0], 10, options);
        section.row(input, error.expect_err(input));
    };
    fail("a function of NaN", Event::new("root", |_, q: &[f64], _: &[f64]| (q[0] - 0.5).sqrt()));
    fail("a function that fails", Event::new("seen", |_, _: &[f64], _: &[f64]| Err("the light is off")));

    let mut robot = pendulum(2.0, 0.5);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let mut driven = simulation(robot);
    driven.set_controls(&[f64::NAN]);
    section.row("a control of NaN", driven.step().expect_err("NaN"));
    let error = simulation(pendulum(2.0, 0.5)).run(-1.0, RunOptions::new());
    section.row("a negative duration", error.expect_err("negative"));
    let mut pushed = simulation(pendulum(2.0, 0.5));
    pushed.set_torques(&[f64::INFINITY]);
    section.row("an infinite torque", pushed.step().expect_err("infinite"));
    section
}

pub(crate) fn contact_error() -> Section {
    let mut section = Section::new("grounds and contacts");
    section.row("a slope of 1.6 rad", Ground::slope(1.6).expect_err("a wall"));
    section.row("a normal of zeros", Ground::through([0.0; 3], [0.0; 3]).expect_err("no direction"));
    let ball = || Shape::Sphere { radius: 0.1 };
    let robot = two_bodies([ball(), ball()]);
    let model = Model::new(robot.clone()).expect("a robot");
    let level = Ground::level(0.0);
    for (input, ground) in [
        ("negative friction", level.with_friction(-1.0)),
        ("friction of NaN", level.with_friction(f64::NAN)),
        ("a restitution of 1.5", level.with_restitution(1.5)),
        ("a ground at infinity", Ground::level(f64::INFINITY)),
    ] {
        section.row(input, ContactSet::new(&model, &[ground]).expect_err(input));
    }
    for (input, rows, columns, half_size, heights) in [
        ("a field of one row", 1, 4, [1.0, 1.0], vec![0.0; 4]),
        ("a field without width", 2, 2, [1.0, 0.0], vec![0.0; 4]),
        ("five heights for four", 2, 2, [1.0, 1.0], vec![0.0; 5]),
        ("an infinite height", 2, 2, [1.0, 1.0], vec![f64::INFINITY; 4]),
    ] {
        section.row(input, HeightField::new(rows, columns, half_size, heights).expect_err(input));
    }
    let field = || HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4]).expect("a field");
    let askew = Pose { rotation: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..Pose::IDENTITY };
    let mut slippery = Surface::default();
    slippery.friction[0] = f64::NAN;
    for (input, field) in [
        ("a field with friction of NaN", field().with_surface(slippery)),
        ("a field with negative friction", field().with_friction(-1.0)),
        ("a field with a restitution of 2", field().with_restitution(2.0)),
        ("a field stretched by its pose", field().with_pose(askew)),
    ] {
        let set = ContactSet::new(&model, &[]).expect("a set");
        section.row(input, set.with_height_field(&field).expect_err(input));
    }
    let mut rough = robot;
    rough.shapes[0].surface.friction[0] = f64::NAN;
    let rough = Model::new(rough).expect("a robot");
    section.row("a shape with friction of NaN", ContactSet::new(&rough, &[level]).expect_err("NaN"));
    let set = ContactSet::new(&model, &[]).expect("a set");
    let same = set.with_pair(&model, ["body0", "body0"], 0.5);
    section.row("a pair of shapes without contact", same.expect_err("one link"));
    let pair = SimulationBuilder::new(&model).ignore_contacts([("body0", "body2")]).build();
    section.row("a pair with an unknown link", pair.expect_err("no link"));
    section
}

pub(crate) fn unknown_effect() -> Section {
    let mut section = Section::new("UnknownEffect");
    section.row("friction", "friction".parse::<Effect>().expect_err("no effect"));
    section
}

/// Reasons that a simulation reports, and parts that it leaves out.
pub(crate) fn left_out() -> Section {
    let mut section = Section::new("Simulation::reason and Simulation::left_out");
    let build = |robot, method: Option<Method>| {
        let model = Model::new(robot).expect("a robot");
        let builder = SimulationBuilder::new(&model);
        let builder = method.into_iter().fold(builder, SimulationBuilder::method);
        builder.build().expect("a simulation")
    };
    section.row("smooth forces", build(pendulum(2.0, 0.5), None).reason());
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_friction(0.3);
    section.row("dry friction", build(robot, None).reason());
    let mut robot = pendulum(2.0, 0.5);
    let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0));
    robot.actuators.push(servo.servo(1e7, 0.0));
    section.row("a stiff servo", build(robot, None).reason());

    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits = Limits::new(-0.1, 0.1);
    let end = |link: &str| (link.to_owned(), [0.5, 0.0, 0.0]);
    let pin = Equality::Connect { a: end("rod"), b: end("ceiling") };
    robot.equalities.push(EqualityDescription::new("pin", pin));
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    for row in [Integrator::RungeKutta4, Integrator::VariationalMidpoint] {
        let simulation = build(robot.clone(), Some(Method::Fixed(row)));
        section.row(&format!("limits, a loop and a motor with {row}"), simulation.left_out().join("\n    "));
    }
    section
}
