//! Friction, torque and motion limits that determine the solution, and problems without one.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::{center_of_mass, centroidal_momentum_rate};
use robot_dynamics::control::TaskReference;
use robot_dynamics::control::whole_body::{Limit, WholeBodyError, WholeBodyLimits};
use robot_dynamics::description::{LinkDescription, MassProperties, RobotDescription, pendulum};
use robot_dynamics::{Classified, ErrorKind};

use super::*;

fn accelerate(model: &Model, q: &[f64], acceleration: [f64; 3]) -> Objective {
    let position = center_of_mass(model, &mut Workspace::new(model), q);
    let reference = TaskReference { position, velocity: [0.0; 3], acceleration };
    Objective::CenterOfMass { reference, gains: PdGains::critical(0.0) }
}

/// The acceleration of the centre of mass.
fn found(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> [f64; 3] {
    let rate = centroidal_momentum_rate(model, &mut Workspace::new(model), q, v, a);
    rate.linear.map(|force| force / model.moving_mass())
}

/// A sideways acceleration beyond friction: the centre of mass accelerates with the largest force that the
/// pyramids allow for their normal forces, and reaches what was asked with enough friction.
#[test]
fn sideways_acceleration_is_limited_by_friction() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    for (friction, sides) in [(0.1, 4), (0.2, 8), (0.2, 6), (2.0, 4)] {
        let mut control = WholeBodyControl::new(&model);
        control.set_limits(WholeBodyLimits::none(&model)).expect("no limits");
        for foot in FEET {
            let contact = HeldContact::new(model.frame_named(foot).unwrap(), ContactGeometry::Ball(RADIUS));
            control.add_contact(contact.with_friction(friction, sides).unwrap()).expect("a contact");
        }
        control.add_task_at(0, accelerate(&model, &q, [0.0, 4.0, 0.0]), 1.0).expect("a task");
        control.add_task_at(1, posture(&model, &q, 100.0), 1.0).expect("a task");
        let solution = control.solve(&q, &rest).expect("a solution");
        let a = found(&model, &q, &rest, &solution.acceleration);
        let slope = friction * (std::f64::consts::PI / sides as f64).cos();
        for point in &solution.forces {
            let tangent = point.force[0].hypot(point.force[1]);
            // The pyramid is inside the cone.
            assert!(tangent <= friction * point.force[2] + 1e-7);
        }
        let (force, normal) = solution
            .forces
            .iter()
            .fold((0.0, 0.0), |(force, normal), point| (force + point.force[1], normal + point.force[2]));
        assert!((force - model.mass() * a[1]).abs() < 1e-7, "Newton's law");
        if friction < 1.0 {
            // At sides that face y the force is at their distance; μ (normal force) bounds every pyramid.
            assert!(a[1] < 4.0 - 0.1);
            assert!(force <= friction * normal + 1e-7 && force >= slope * normal - 1e-7, "{force} {normal}");
            let is_friction = |limit: Limit| matches!(limit, Limit::Friction { .. });
            assert!(solution.active_limits.iter().any(|active| is_friction(active.limit)));
        } else {
            // The smallest singular value of the task's rows leaves nine digits.
            assert!((a[1] - 4.0).abs() < 1e-7, "{}", a[1]);
        }
    }
}

/// A jump that the motors cannot give: the torques stay within their limits, some at them, and the jump is
/// slower than without limits.
#[test]
fn torques_saturate_in_a_jump() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    let mut control = on_feet(&model, 0.7);
    control.add_task(accelerate(&model, &q, [0.0, 0.0, 60.0]), 1.0).expect("a task");
    control.add_task(posture(&model, &q, 10.0), 1e-3).expect("a task");
    let solution = control.solve(&q, &rest).expect("a solution").clone();
    let effort: Vec<f64> = model.coordinate_limits().iter().map(|limits| limits.effort).collect();
    let mut at_limit = 0;
    for k in 6..model.nv() {
        assert!(solution.torque[k].abs() <= effort[k] * (1.0 + 1e-9));
        at_limit += usize::from(solution.torque[k].abs() > effort[k] * (1.0 - 1e-9));
    }
    let is_torque = |limit: Limit| matches!(limit, Limit::Torque { .. });
    let stated = solution.active_limits.iter().filter(|active| is_torque(active.limit)).count();
    assert!(stated >= 4 && stated <= at_limit, "{stated} of {at_limit}");
    assert!(solution.active_limits.iter().all(|active| active.multiplier >= 0.0));
    let limited = found(&model, &q, &rest, &solution.acceleration)[2];
    control.set_limits(WholeBodyLimits::none(&model)).expect("limits");
    let solution = control.solve(&q, &rest).expect("a solution");
    let unlimited = found(&model, &q, &rest, &solution.acceleration)[2];
    assert!(limited < 0.9 * unlimited && limited > 5.0, "{limited} {unlimited}");
}

/// A joint that is driven towards its stop and beyond its speed keeps to both limits.
#[test]
fn joints_keep_to_the_limits_of_their_motion() {
    let model = Model::new(pendulum(1.0, 0.5)).expect("a robot");
    let mut limits = WholeBodyLimits::none(&model);
    limits.position[0] = [-0.5, 0.8];
    limits.velocity[0] = 1.5;
    limits.acceleration[0] = 40.0;
    let mut control = WholeBodyControl::new(&model);
    control.set_limits(limits).expect("limits");
    control.add_task(posture(&model, &[2.0], 400.0), 1.0).expect("a task");
    let (mut q, mut v, step) = ([0.0], [0.0], 1e-3);
    let mut fastest: f64 = 0.0;
    for _ in 0..2000 {
        let a = control.solve(&q, &v).expect("a solution").acceleration[0];
        assert!(a.abs() <= 40.0 + 1e-6);
        v[0] += step * a;
        q[0] += step * v[0];
        fastest = fastest.max(v[0]);
        // The bounds hold to 1e-10 of 40 rad/s², for 2000 steps of 1 ms.
        assert!(q[0] <= 0.8 + 1e-8 && v[0] <= 1.5 + 1e-8, "{q:?} {v:?}");
    }
    assert!(q[0] > 0.799 && fastest > 1.4);
}

/// A box without motors on a slope stands if the slope is less than friction, and has no solution otherwise.
#[test]
fn a_box_on_a_slope_beyond_friction_has_no_solution() {
    let inertia = Matrix3::from_diagonal(&Vector3::repeat(0.02));
    let cube = MassProperties::new(2.0, Vector3::zeros(), inertia).expect("a body");
    let mut robot = RobotDescription::new("box");
    robot.links = vec![LinkDescription::new("box", cube)];
    robot.base = Base::Floating;
    let model = Model::new(robot).expect("a robot");
    let corners: Vec<[f64; 3]> =
        [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.1], [-0.1, -0.1]].map(|[x, y]| [x, y, -0.1]).to_vec();
    let frame = model.frame_named("box").expect("a frame");
    for (angle, stands) in [(0.1_f64, true), (0.3, false)] {
        let normal = [angle.sin(), 0.0, angle.cos()];
        let contact = HeldContact::new(frame, ContactGeometry::Face(corners.clone()))
            .with_normal(normal)
            .and_then(|contact| contact.with_friction(0.2, 4))
            .expect("a contact");
        let mut control = WholeBodyControl::new(&model);
        control.add_contact(contact).expect("a contact");
        // The box itself is rotated with the slope.
        let half = 0.5 * angle;
        let q = [0.0, 0.0, 0.0, 0.0, half.sin(), 0.0, half.cos()];
        let result = control.solve(&q, &[0.0; 6]);
        match result {
            Ok(solution) => {
                assert!(stands);
                let weight: f64 = solution.forces.iter().map(|point| point.force[2]).sum();
                assert!((weight - 2.0 * 9.81).abs() < 1e-9);
            }
            Err(error) => {
                assert!(!stands, "{error}");
                assert!(
                    matches!(error, WholeBodyError::Infeasible { limit: Limit::Friction { .. } }),
                    "{error}"
                );
                assert_eq!(error.kind(), ErrorKind::Infeasible);
            }
        }
    }
}

/// A pendulum whose tip is held has more equations than coordinates. They are consistent at rest. They
/// contradict each other if the tip moves: it accelerates along the rod.
#[test]
fn dependent_contacts_are_accepted_if_they_are_consistent() {
    let model = Model::new(pendulum(1.0, 0.5)).expect("a robot");
    let tip = model.frame_named("tip").expect("a tip");
    let mut control = WholeBodyControl::new(&model);
    let contact =
        HeldContact::new(tip, ContactGeometry::Point([0.0; 3])).with_damping(0.0).expect("a contact");
    control.add_contact(contact).expect("a contact");
    assert!(control.solve(&[0.3], &[0.0]).is_ok());
    let refused = control.solve(&[0.3], &[1.0]).expect_err("the tip moves on a circle");
    assert!(matches!(refused, WholeBodyError::ContradictoryContacts { .. }), "{refused}");
}

#[test]
fn bad_input_is_refused() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    let mut control = on_feet(&model, 0.5);
    assert_eq!(
        control.solve(&q, &vec![f64::NAN; model.nv()]).expect_err("NaN").kind(),
        ErrorKind::InvalidInput
    );
    assert_eq!(control.solve(&q[1..], &rest).expect_err("a length").kind(), ErrorKind::InvalidInput);
    assert!(control.add_task(Objective::ContactForces, -1.0).is_err());
    let mut limits = WholeBodyLimits::of(&model);
    limits.torque[7] = f64::NAN;
    assert!(control.set_limits(limits).is_err());
    let mut limits = WholeBodyLimits::of(&model);
    limits.velocity.pop();
    assert!(control.set_limits(limits).is_err());
    let task = control.add_task(Objective::Torque { torque: vec![0.0; 3] }, 1.0).expect("a task");
    assert_eq!(control.solve(&q, &rest).expect_err("a length").kind(), ErrorKind::InvalidInput);
    control.set_weight(task, 0.0).expect("a weight");
    assert!(control.solve(&q, &rest).is_ok(), "tasks with the weight zero are not evaluated");
    let foot = model.frame_named(FEET[0]).expect("a foot");
    let contact = || HeldContact::new(foot, ContactGeometry::Point([0.0; 3]));
    assert!(contact().with_friction(0.5, 2).is_err());
    assert!(contact().with_friction(-0.5, 4).is_err());
    assert!(contact().with_normal([0.0, 0.0, 2.0]).is_err());
    assert!(contact().with_normal_force(5.0, 1.0).is_err());
    assert!(contact().with_damping(f64::NAN).is_err());
    assert!(control.add_contact(HeldContact::new(foot, ContactGeometry::Ball(-1.0))).is_err());
    assert!(control.add_contact(HeldContact::new(foot, ContactGeometry::Face(Vec::new()))).is_err());
}
