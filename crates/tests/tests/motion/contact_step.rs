//! The contact step with a fixed number of sweeps: laws, momentum, closed forms, the converged simulation.

use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, forward_dynamics_with_wrenches, frame_velocity,
};
use robot_dynamics::contact::{ContactViolation, Ground};
use robot_dynamics::description::{Limits, PassiveForces, RobotDescription, Shape, ShapeRole, pendulum};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{ContactStep, ContactStepInputs, SimulationBuilder};

use crate::free_body::body;

const G: f64 = 9.81;
const H: f64 = 2e-3;

/// The state of a robot that takes contact steps.
struct Steps<'a> {
    model: &'a Model,
    step: ContactStep,
    q: Vec<f64>,
    v: Vec<f64>,
    impulses: Vec<f64>,
}

impl<'a> Steps<'a> {
    fn new(model: &'a Model, sweeps: usize, q: &[f64], v: &[f64]) -> Self {
        let step = ContactStep::new(model, sweeps).unwrap();
        let impulses = vec![0.0; step.impulse_count()];
        Self { model, step, q: q.to_vec(), v: v.to_vec(), impulses }
    }

    fn take(&mut self, tau: &[f64], friction: f64) {
        let (q, v, before) = (self.q.clone(), self.v.clone(), self.impulses.clone());
        let inputs = ContactStepInputs::new([&q, &v, tau], H, friction, &before);
        let workspace = &mut Workspace::new(self.model);
        self.step.step(self.model, workspace, &inputs, &mut self.q, &mut self.v, &mut self.impulses);
    }
}

/// The quadruped on its feet, of which only the balls touch.
fn quadruped() -> RobotDescription {
    let path = format!("{}/../../robots/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let mut robot = robot_dynamics::load(path).unwrap().model.description().clone();
    robot.base = robot_dynamics::description::Base::Floating;
    robot
        .shapes
        .retain(|shape| shape.role == ShapeRole::Collision && matches!(shape.shape, Shape::Sphere { .. }));
    robot
}

fn standing(height: f64) -> Vec<f64> {
    let mut q = vec![0.0, 0.0, height, 0.0, 0.0, 0.0, 1.0];
    (0..4).for_each(|_| q.extend([0.0, 0.7, -1.4]));
    q
}

/// The height of the lowest point of the feet at a height of the trunk of 1 m.
fn foot_height(model: &Model) -> f64 {
    let contacts = robot_dynamics::contact::ContactSet::new(model, &[Ground::level(0.0)]).unwrap();
    contacts.clearance(model, &mut Workspace::new(model), &standing(1.0)).unwrap()
}

/// Many sweeps satisfy the laws of contact, with the velocities of the feet from the kinematics of frames.
/// The change of momentum is that of the forces as external wrenches. Neither route uses the step's rows.
#[test]
fn converged_sweeps_obey_the_laws_and_conserve_momentum() {
    let model = Model::new(quadruped()).unwrap();
    let lowest = foot_height(&model);
    let mut random = SplitMix64::new(5);
    let (mut pushing, mut sliding) = (0, 0);
    for _ in 0..20 {
        let mut q = standing(1.0 - lowest + random.uniform(-2e-3, 2e-3));
        q[7..].iter_mut().for_each(|angle| *angle += random.uniform(-2e-3, 2e-3));
        let v: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-0.5, 0.5)).collect();
        let tau: Vec<f64> =
            (0..model.nv()).map(|k| if k < 6 { 0.0 } else { random.uniform(-5.0, 5.0) }).collect();
        let mut steps = Steps::new(&model, 20_000, &q, &v);
        steps.take(&tau, 0.6);
        let mut total = tau.clone();
        let mut dissipation = vec![0.0; model.nv()];
        robot_dynamics::algorithms::dissipation_derivative(&model, &mut dissipation);
        total.iter_mut().zip(&dissipation).zip(&steps.v).for_each(|((tau, d), v)| *tau -= d * v);
        // Friction of each joint, then its stop, in the order of the joints.
        let contacts = steps.step.links().len();
        let joint_impulses = &steps.impulses[3 * contacts..];
        assert_eq!(joint_impulses.len(), 24);
        for (joint, pair) in joint_impulses.chunks(2).enumerate() {
            assert!(pair[0].abs() <= H * 0.1 + 1e-12);
            total[6 + joint] += (pair[0] + pair[1]) / H;
        }
        let mut wrenches = Vec::new();
        for (link, impulse) in steps.step.links().iter().zip(steps.impulses.chunks(3)) {
            let shape = model.description().shapes.iter().find(|shape| shape.link == *link).unwrap();
            let Shape::Sphere { radius } = shape.shape else { unreachable!() };
            let frame = model.frame_named(link).unwrap();
            let pose = model.frame_pose(&q, frame).unwrap();
            let offset = shape.link_from_shape.translation;
            let center = pose.apply(offset);
            let arm: [f64; 3] =
                std::array::from_fn(|i| center[i] - pose.translation[i] - if i == 2 { radius } else { 0.0 });
            let force = [impulse[1] / H, impulse[2] / H, impulse[0] / H];
            let moment = cross(arm, force);
            let turn =
                |x: [f64; 3]| std::array::from_fn(|i| (0..3).map(|j| pose.rotation[j][i] * x[j]).sum());
            wrenches.push(FrameWrench { frame, force_in_frame: turn(force), moment_in_frame: turn(moment) });
            let workspace = &mut Workspace::new(&model);
            let twist =
                frame_velocity(&model, workspace, &q, &steps.v, frame, ReferenceFrame::LocalWorldAligned);
            let swept = cross(twist.angular, arm);
            let [x, y, z]: [f64; 3] = std::array::from_fn(|i| twist.linear[i] + swept[i]);
            let gap = center[2] - radius;
            let least = if gap < 0.0 { -gap / (H + 0.1) } else { -gap / H };
            let violation = ContactViolation::of(0.6, 1.0, &[z - least, x, y], impulse);
            assert!(violation.worst() < 1e-9, "{violation:?}");
            pushing += usize::from(impulse[0] > 0.0);
            sliding += usize::from(impulse[0] > 0.0 && x.hypot(y) > 1e-3);
        }
        let mut acceleration = vec![0.0; model.nv()];
        let workspace = &mut Workspace::new(&model);
        forward_dynamics_with_wrenches(&model, workspace, &q, &v, &total, &wrenches, &mut acceleration);
        for ((&before, &after), &a) in v.iter().zip(&steps.v).zip(&acceleration) {
            assert!(
                (after - before - H * a).abs() < 1e-10 * (1.0 + a.abs()),
                "{after} for {}",
                before + H * a
            );
        }
    }
    assert!(pushing > 20 && sliding > 5, "{pushing} {sliding}");
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// A block that slides at v₀ stops after v₀/(μ g) with v₀²/(2 μ g), to first order in h, and then rests.
#[test]
fn a_block_slides_to_rest() {
    let model = Model::new(body(2e-3, Shape::Box { size: [0.2, 0.2, 0.1] })).unwrap();
    let (friction, speed) = (0.4, 1.0);
    let q = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0];
    let mut steps = Steps::new(&model, 200, &q, &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
    (0..500).for_each(|_| steps.take(&[0.0; 6], friction));
    let expected = speed * speed / (2.0 * friction * G);
    assert!((steps.q[0] - expected).abs() < speed * H, "{} for {expected}", steps.q[0]);
    assert!(steps.v.iter().all(|v| v.abs() < 1e-9), "{:?}", steps.v);
    let normal: f64 = steps.impulses.chunks(3).map(|impulse| impulse[0]).sum();
    assert!((normal - H * G).abs() < 1e-9);
}

/// A rod that falls onto its stop rests there; friction of the joint holds it below its bound.
#[test]
fn stops_and_friction_hold_a_rod() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].kind = robot_dynamics::description::JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.joints[0].limits = Limits::new(-0.3, 0.4);
    let model = Model::new(robot.clone()).unwrap();
    let mut steps = Steps::new(&model, 4, &[0.0], &[0.0]);
    (0..500).for_each(|_| steps.take(&[0.0], 0.5));
    let stop = if steps.q[0] > 0.0 { 0.4 } else { -0.3 };
    assert!((steps.q[0] - stop).abs() < 1e-12 && steps.v[0].abs() < 1e-12, "{:?}", steps.q);
    robot.joints[0].passive = PassiveForces::default().with_friction(10.0); // m g l is 9.81 N m
    let model = Model::new(robot).unwrap();
    let mut steps = Steps::new(&model, 4, &[0.1], &[0.0]);
    (0..100).for_each(|_| steps.take(&[0.0], 0.5));
    assert!((steps.q[0] - 0.1).abs() < 1e-12, "{:?}", steps.q);
}

/// The quadruped lands on its feet and stands, by joint springs as torques. After three seconds its state is
/// that of the converged simulation with the same torques, to the order of the steps.
#[test]
fn a_quadruped_stands_as_in_the_converged_simulation() {
    let model = Model::new(quadruped()).unwrap();
    let target = standing(1.02 - foot_height(&model));
    let torques = |q: &[f64], v: &[f64]| -> Vec<f64> {
        let spring = |k: usize| 60.0 * (target[k + 1] - q[k + 1]) - 2.0 * v[k];
        (0..18).map(|k| if k < 6 { 0.0 } else { spring(k) }).collect()
    };
    let mut steps = Steps::new(&model, 16, &target, &[0.0; 18]);
    let ground = Ground::level(0.0).with_friction(0.8);
    let mut simulation = SimulationBuilder::new(&model).ground(ground).dt(H).build().unwrap();
    simulation.reset(&target, &[0.0; 18]).unwrap();
    for _ in 0..1500 {
        let tau = torques(&steps.q, &steps.v);
        steps.take(&tau, 0.8);
        let tau = torques(simulation.q(), simulation.v());
        simulation.set_torques(&tau);
        simulation.step().unwrap();
    }
    let off = steps.q.iter().zip(simulation.q()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 2e-3, "{off}: {:?} for {:?}", steps.q, simulation.q());
    let weight: f64 = steps.impulses.chunks(3).take(4).map(|impulse| impulse[0] / H).sum();
    assert!((weight - model.mass() * G).abs() < 0.01 * model.mass() * G, "{weight}");
}

/// A mesh on the ground, a closed loop and no sweeps are errors that say what to do.
#[test]
fn unsupported_robots_are_refused() {
    let mut robot = quadruped();
    let mut mesh = robot.shapes[0].clone();
    (mesh.shape, mesh.name) = (Shape::mesh("foot.stl"), "sole".into());
    robot.shapes.push(mesh);
    let error = ContactStep::new(&Model::new(robot).unwrap(), 8).unwrap_err().to_string();
    assert!(error.contains("`sole`") && error.contains("remove or replace it"), "{error}");
    let model = Model::new(quadruped()).unwrap();
    assert!(ContactStep::new(&model, 0).unwrap_err().to_string().contains("at least 1"));
    let path = format!("{}/../../robots/linkage.xml", env!("CARGO_MANIFEST_DIR"));
    let linkage = robot_dynamics::load(path).unwrap().model;
    let error = ContactStep::new(&linkage, 8).unwrap_err().to_string();
    assert!(error.contains("equality"), "{error}");
}
