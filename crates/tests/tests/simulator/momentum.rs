//! The impulses of contacts and gravity equal the change of momentum.

use nalgebra::Vector3;
use robot_dynamics::algorithms::center_of_mass_velocity;
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, PassiveForces, Pose,
    RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::simulation::{Simulation, SimulationBuilder};

use crate::hopper::hopper;

/// ∫Σf dt = m Δċ − m g T. The contact forces of a step are its mean; the forces by link and by contact point
/// agree.
fn check(simulation: &mut Simulation, mass: f64, steps: u32) {
    let h = simulation.dt();
    let velocity = |simulation: &Simulation| {
        let model = simulation.model();
        center_of_mass_velocity(model, &mut Workspace::new(model), simulation.q(), simulation.v())
    };
    let before = velocity(simulation);
    let (mut of_links, mut of_points) = ([0.0; 3], [0.0; 3]);
    for _ in 0..steps {
        simulation.step().expect("a step");
        for k in 0..3 {
            of_links[k] += simulation.ground_forces().iter().map(|force| h * force[k]).sum::<f64>();
            let on_ground = simulation.contacts().into_iter().filter(|contact| contact.ground.is_some());
            of_points[k] += on_ground.map(|contact| h * contact.force[k]).sum::<f64>();
        }
    }
    let after = velocity(simulation);
    let time = f64::from(steps) * h;
    let gravity = [0.0, 0.0, -9.81];
    for k in 0..3 {
        let expected = mass * (after[k] - before[k]) - mass * gravity[k] * time;
        for impulse in [of_links[k], of_points[k]] {
            // Tolerance: the residual of the contact solver over some thousand steps.
            assert!((impulse - expected).abs() < 1e-10, "axis {k}: {impulse} {expected}");
        }
    }
    assert!(of_links[2] > 0.2 * mass * 9.81 * time, "{of_links:?}");
}

#[test]
fn contact_impulses_of_hopper_are_momentum_change() {
    let (mut simulation, mass) = hopper();
    check(&mut simulation, mass, 1500);
}

/// A body with swinging, sprung legs; each has a ball as a foot.
fn add_legs(robot: &mut RobotDescription, trunk: &str) {
    for (k, x) in [0.2, -0.2].into_iter().enumerate() {
        let (leg, foot) = (format!("leg {k}"), Vector3::new(0.02, 0.0, -0.2));
        let mass = MassProperties::point(0.5, foot).expect("a mass");
        robot.links.push(LinkDescription::new(&leg, Some(mass)));
        let kind = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
        let pose = Pose::from_xyz_rpy([x, 0.0, 0.0], [0.0; 3]);
        let mut joint = JointDescription::new(format!("hip {k}"), kind, trunk, &leg, pose);
        joint.passive = PassiveForces::default().with_spring(30.0, 0.3).with_damping(0.2).with_friction(0.1);
        robot.joints.push(joint);
        let ball = Shape::Sphere { radius: 0.03 };
        robot.shapes.push(LinkShape::new(
            &leg,
            ShapeRole::Collision,
            Pose::from_xyz_rpy(foot.into(), [0.0; 3]),
            ball,
        ));
    }
}

fn trunk() -> LinkDescription {
    let mass = MassProperties::solid_box(400.0, Vector3::new(0.3, 0.2, 0.1)).expect("a box");
    LinkDescription::new("trunk", mass)
}

fn dropped(robot: RobotDescription, (q, v): (&[f64], &[f64])) -> Simulation {
    let model = Model::new(robot).expect("a robot");
    let mut start = neutral(&model);
    start[..q.len()].copy_from_slice(q);
    let mut velocity = vec![0.0; model.nv()];
    velocity[..v.len()].copy_from_slice(v);
    let ground = Ground::level(0.0).with_friction(0.6);
    let mut simulation = SimulationBuilder::new(&model).ground(ground).build().expect("a simulation");
    simulation.reset(&start, &velocity).expect("a start");
    simulation
}

/// Coordinates that turn with the body: a spinning ball, a tumbling box, and a body with swinging legs.
#[test]
fn contact_impulses_of_turning_bodies_are_momentum_change() {
    for shape in [Shape::Sphere { radius: 0.1 }, Shape::Box { size: [0.3, 0.2, 0.1] }] {
        let mut robot = RobotDescription::new("body");
        robot.base = Base::Floating;
        robot.links.push(trunk());
        robot.shapes.push(LinkShape::new("trunk", ShapeRole::Collision, Pose::IDENTITY, shape));
        let start = [0.0, 0.0, 0.4];
        let mut simulation = dropped(robot, (&start, &[0.4, 0.0, 0.0, 3.0, 10.0, 20.0]));
        check(&mut simulation, 2.4, 1000);
    }
    let mut robot = RobotDescription::new("walker");
    robot.base = Base::Floating;
    robot.links.push(trunk());
    add_legs(&mut robot, "trunk");
    let mut simulation = dropped(robot, (&[0.0, 0.0, 0.5], &[0.4, 0.1, 0.0, 1.0, 2.0, 3.0]));
    check(&mut simulation, 3.4, 1000);
}

/// In a plane, on two slides and a hinge.
#[test]
fn contact_impulses_of_planar_walker_are_momentum_change() {
    let mut robot = RobotDescription::new("planar");
    for link in ["world", "cart", "lift"] {
        robot.links.push(LinkDescription::new(link, None));
    }
    robot.links.push(trunk());
    let slide = |axis| JointKind::Prismatic { axis };
    let turn = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    for (name, kind, parent, child) in [
        ("x", slide([1.0, 0.0, 0.0]), "world", "cart"),
        ("z", slide([0.0, 0.0, 1.0]), "cart", "lift"),
        ("pitch", turn, "lift", "trunk"),
    ] {
        robot.joints.push(JointDescription::new(name, kind, parent, child, Pose::IDENTITY));
    }
    add_legs(&mut robot, "trunk");
    let mut simulation = dropped(robot, (&[0.0, 0.5, 0.2], &[0.5, 0.0, 3.0]));
    check(&mut simulation, 3.4, 1000);
}
