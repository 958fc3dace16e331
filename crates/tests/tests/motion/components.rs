//! Scenes of several robots: a step couples only bodies in contact.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::centroidal_momentum;
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, PassiveForces, Pose,
    RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{IntegratorError, StepForces, StepWorkspace, Stepper};

use crate::free_body::{implicit_on, run_watched, stepper};

const G: f64 = 9.81;

/// An empty world.
fn world() -> RobotDescription {
    let mut scene = RobotDescription::new("scene");
    scene.links.push(LinkDescription::new("world", None));
    scene
}

fn add_ball(scene: &mut RobotDescription, name: &str, parent: &str, kind: JointKind, at: [f64; 3]) {
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.004, 0.005, 0.006));
    let mass = MassProperties::new(1.0, Vector3::new(0.01, 0.02, 0.0), inertia).unwrap();
    scene.links.push(LinkDescription::new(name, mass));
    let at = Pose::from_translation(at);
    scene.joints.push(JointDescription::new(format!("to {name}"), kind, parent, name, at));
    let shape = Shape::Sphere { radius: 0.1 };
    scene.shapes.push(LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, shape));
}

/// A free body with two arms on hinges with friction, damping and limits; its q and v.
fn add_hopper(scene: &mut RobotDescription) -> (Vec<f64>, Vec<f64>) {
    add_ball(scene, "hull", "world", JointKind::Floating, [0.0; 3]);
    for (arm, x) in [("left", -0.3), ("right", 0.3)] {
        let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
        add_ball(scene, arm, "hull", hinge, [x, 0.0, 0.0]);
        let joint = scene.joints.last_mut().unwrap();
        joint.passive = PassiveForces::default().with_damping(0.05).with_friction(0.02);
        joint.limits = Limits::new(-0.02, 0.02);
    }
    let q = vec![0.0, 0.0, 0.12, 0.0, 0.05, 0.0, (1.0_f64 - 0.05 * 0.05).sqrt(), 0.0, 0.01];
    (q, vec![0.3, 0.1, 0.0, 0.4, 0.2, 0.1, 0.5, -1.0])
}

/// A leg with three hinges in place of a ball joint, as in `gimbal.rs`; steps at its limit are subdivided.
/// Its q and v.
fn add_leg(scene: &mut RobotDescription) -> (Vec<f64>, Vec<f64>) {
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.16, 0.16, 0.008));
    let thigh = MassProperties::new(8.0, Vector3::new(0.0, 0.0, -0.2), inertia).unwrap();
    let chain = [
        ("world", "first", None, [0.0, 0.0, 1.0], (-1.047, 3.1)),
        ("first", "second", None, [1.0, 0.0, 0.0], (-1.047, 1.570795)),
        ("second", "thigh", Some(thigh), [0.0, -1.0, 0.0], (-1.570795, 1.047)),
    ];
    for (parent, child, mass, axis, (lower, upper)) in chain {
        scene.links.push(LinkDescription::new(child, mass));
        let kind = JointKind::Revolute { axis };
        let joint = JointDescription::new(format!("to {child}"), kind, parent, child, Pose::IDENTITY);
        scene.joints.push(joint.with_limits(Limits::new(lower, upper)));
    }
    (vec![0.0; 3], vec![1.0, 9.0, 2.0])
}

/// A scene with its state and its contacts, with the ground and between links.
struct Scene {
    model: Model,
    contacts: ContactSet,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Scene {
    fn new(description: RobotDescription, q: Vec<f64>, v: Vec<f64>, ground: Ground) -> Self {
        let model = Model::new(description).unwrap();
        let contacts = ContactSet::new(&model, &[ground]).unwrap().with_links(&model);
        Self { model, contacts, q, v }
    }

    /// The states of a run with steps of 1 ms.
    fn run(&self, steps: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
        let mut states = Vec::new();
        let builder = implicit_on(&self.model, self.contacts.clone());
        run_watched(builder, (&self.q, &self.v), (1e-3, steps), |info| {
            states.push((info.q.to_vec(), info.v.to_vec()));
        });
        states
    }
}

/// Balls at rest at these positions.
fn balls(places: &[[f64; 3]]) -> (RobotDescription, Vec<f64>, Vec<f64>) {
    let mut scene = world();
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for (k, [x, y, z]) in places.iter().enumerate() {
        add_ball(&mut scene, &format!("ball {k}"), "world", JointKind::Floating, [0.0; 3]);
        q.extend([*x, *y, *z, 0.0, 0.0, 0.0, 1.0]);
        v.extend([0.0; 6]);
    }
    (scene, q, v)
}

/// A falling, sliding robot that reaches its joint limits moves identically, bit for bit, whatever is far
/// away. That may be nothing, a resting ball, a landing ball, or a leg with subdivided steps.
#[test]
fn distant_robots_do_not_affect_each_other() {
    let ground = Ground::level(0.0).with_friction(0.4);
    let alone = {
        let mut scene = world();
        let (q, v) = add_hopper(&mut scene);
        Scene::new(scene, q, v, ground).run(600)
    };
    let (nq, nv) = (alone[0].0.len(), alone[0].1.len());
    let stops = alone.iter().filter(|(q, _)| q[nq - 2..].iter().any(|q| q.abs() == 0.02)).count();
    assert!(stops > 50, "{stops} steps on a stop");
    for neighbour in ["at rest", "lands", "is divided"] {
        let mut scene = world();
        let (mut q, mut v) = add_hopper(&mut scene);
        if neighbour == "is divided" {
            let (own_q, own_v) = add_leg(&mut scene);
            q.extend(own_q);
            v.extend(own_v);
        } else {
            let height = if neighbour == "lands" { 0.13 } else { 0.1 };
            add_ball(&mut scene, "ball", "world", JointKind::Floating, [0.0; 3]);
            q.extend([100.0, 0.0, height, 0.0, 0.0, 0.0, 1.0]);
            v.extend([0.0, 0.0, 0.0, 0.1, 0.0, 0.2]);
        }
        let beside = Scene::new(scene, q, v, ground).run(600);
        for (step, (own, other)) in alone.iter().zip(&beside).enumerate() {
            assert_eq!(own.0, other.0[..nq], "the neighbour {neighbour}, q after step {step}");
            assert_eq!(own.1, other.1[..nv], "the neighbour {neighbour}, v after step {step}");
        }
    }
}

/// Balls of which one lands in almost every step, on the ground or on another. The impulse of the ground and
/// the weight equal the change of momentum in each step. The energy account of the run closes as for impacts
/// one after the other.
#[test]
fn momentum_includes_all_components() {
    let mut places = Vec::new();
    for k in 0..12 {
        let (x, height) = (0.5 * f64::from(k), 0.101 + 0.0015 * f64::from(k));
        places.push([x, 0.0, height]);
        places.push([x + 0.03, 0.02, height + 0.21 + 0.001 * f64::from(k)]);
    }
    let (description, q, v) = balls(&places);
    let scene = Scene::new(description, q, v, Ground::level(0.0).with_friction(0.3));
    let mut workspace = Workspace::new(&scene.model);
    let mut momentum = |q: &[f64], v: &[f64]| centroidal_momentum(&scene.model, &mut workspace, q, v).linear;
    let (mut before, mut most, mut carried) = (momentum(&scene.q, &scene.v), 0.0_f64, 0.0_f64);
    let builder = implicit_on(&scene.model, scene.contacts.clone());
    let run = run_watched(builder, (&scene.q, &scene.v), (1e-3, 150), |info| {
        let after = momentum(info.q, info.v);
        let mut force = [0.0, 0.0, -G * places.len() as f64];
        info.contact_forces.iter().for_each(|own| (0..3).for_each(|k| force[k] += own[k]));
        if info.step > 0 {
            for k in 0..3 {
                most = most.max((after[k] - before[k] - 1e-3 * force[k]).abs());
            }
            carried = carried.max(force[2]);
        }
        before = after;
    });
    assert!(carried > 100.0, "nothing landed: {carried} N");
    assert!(most < 1e-9, "{most} N·s");
    let (off, scale) = (run.energy_account.max_imbalance(), run.energy_account.scale());
    assert!(off < 1e-3 * scale, "{off} of {scale} J");
}

/// A ball bounces off the ground within one step and hits another that hangs above it. The step is repeated
/// with both balls in one component, and they separate.
#[test]
fn colliding_components_are_merged() {
    let (mut description, q, mut v) = balls(&[[0.0, 0.0, 0.101], [0.0, 0.0, 0.3015], [9.0, 0.0, 0.5]]);
    description.gravity = [0.0; 3];
    for link in &mut description.links[1..] {
        let sphere = Matrix3::identity() * 0.004;
        link.mass_properties = Some(MassProperties::new(1.0, Vector3::zeros(), sphere).unwrap());
    }
    v[2] = -5.0;
    let model = Model::new(description).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0).with_restitution(1.0)]).unwrap();
    let contacts = contacts.with_links(&model).with_link_restitution(1.0).unwrap();
    let mut stepper = stepper(implicit_on(&model, contacts));
    let (mut q, mut workspace) = (q, StepWorkspace::new(&model));
    let none = StepForces::new(&[0.0; 18], true);
    stepper.step(&model, &mut workspace, &none, 1e-3, &mut q, &mut v).unwrap();
    let gap = q[9] - q[2] - 0.2;
    assert!(gap > -1e-9, "{gap} m");
    // The lower ball transfers all of its momentum.
    assert!((v[8] - 5.0).abs() < 1e-9 && v[2].abs() < 1e-9, "{v:?}");
    assert_eq!((q[16], v[14]), (0.5, 0.0));
}

/// Steps that a flag interrupts at any point leave the state of their start. The run then continues as if it
/// had not been interrupted.
#[test]
fn interrupted_step_of_components_can_be_repeated() {
    let places: Vec<_> = (0..24).map(|k| [0.3 * f64::from(k), 0.0, 0.1005 + 0.0007 * f64::from(k)]).collect();
    let (description, q, v) = balls(&places);
    let scene = Scene::new(description, q, v, Ground::level(0.0));
    let flag = Arc::new(AtomicBool::new(false));
    let builder = || implicit_on(&scene.model, scene.contacts.clone());
    let mut steppers = [builder(), builder().interrupt(Arc::clone(&flag))].map(stepper);
    let mut states = [(scene.q.clone(), scene.v.clone()), (scene.q.clone(), scene.v.clone())];
    let (mut workspace, tau) = (StepWorkspace::new(&scene.model), vec![0.0; scene.v.len()]);
    let none = StepForces::new(&tau, true);
    let mut interrupted = 0;
    for step in 0..60 {
        let [(q, v), (other_q, other_v)] = &mut states;
        steppers[0].step(&scene.model, &mut workspace, &none, 1e-3, q, v).unwrap();
        for tried in 0..4 {
            let (before, forces) =
                ((other_q.clone(), other_v.clone()), steppers[1].contact_forces().to_vec());
            let mut copies = (other_q.clone(), other_v.clone());
            let mut other = steppers[1].clone();
            let ended = std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(Duration::from_micros(40 * tried));
                    flag.store(true, Ordering::Relaxed);
                });
                other.step(&scene.model, &mut workspace, &none, 1e-3, &mut copies.0, &mut copies.1)
            });
            flag.store(false, Ordering::Relaxed);
            if ended.is_ok() {
                continue;
            }
            assert_eq!(ended, Err(IntegratorError::Interrupted.into()));
            interrupted += 1;
            assert_eq!((&before.0, &before.1), (&copies.0, &copies.1), "step {step}");
            assert_eq!(forces, other.contact_forces());
            steppers[1] = other;
        }
        steppers[1].step(&scene.model, &mut workspace, &none, 1e-3, other_q, other_v).unwrap();
        assert_eq!(states[0], states[1], "step {step}");
    }
    println!("{interrupted} of 240 steps were interrupted");
}
