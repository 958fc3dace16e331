//! Redundant equality constraints on robots from files.

use std::path::PathBuf;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, constrained_inverse_dynamics};
use robot_dynamics::description::{FrameDescription, Pose};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::simulation::{Effect, Method, Simulation, SimulationBuilder};
use robot_dynamics::{LoadOptions, load_with};

/// The humanoid with a frame at each corner of its left sole.
fn humanoid() -> Model {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots/humanoid.urdf");
    let robot = load_with(path, &LoadOptions::default().with_floating_base()).expect("a robot");
    let mut description = robot.model.description().clone();
    let corners = [(0.1, 0.04), (0.1, -0.04), (-0.05, 0.04), (-0.05, -0.04)];
    for (i, (x, y)) in corners.into_iter().enumerate() {
        let pose = Pose::from_xyz_rpy([x, y, 0.0], [0.0; 3]);
        description.frames.push(FrameDescription::new(format!("corner {i}"), "left_foot", pose));
    }
    Model::new(description).expect("a model")
}

/// The foot welded to the world, or connected at its first corners.
fn hold(model: &Model, corners: usize) -> ConstraintSet {
    let (workspace, q) = (&mut Workspace::new(model), neutral(model));
    let mut held = |name: &str, rows: &[_]| {
        let frame = model.frame_named(name).expect("a frame");
        let pose = frame_pose(model, workspace, &q, frame);
        (name.to_owned(), FrameConstraint::contact(frame, pose, rows).into())
    };
    let holds: Vec<_> = match corners {
        0 => vec![held("left_foot", &FrameConstraint::WELD)],
        _ => (0..corners).map(|i| held(&format!("corner {i}"), &FrameConstraint::BALL)).collect(),
    };
    ConstraintSet::new(model, holds).expect("a set")
}

fn standing(model: &Model, set: ConstraintSet, torques: &[f64]) -> Simulation {
    let builder = SimulationBuilder::new(model).method(Method::Implicit).without(Effect::Limits);
    let mut simulation = builder.dt(1e-3).constraints(set).build().expect("a simulation");
    simulation.reset(&neutral(model), &vec![0.0; model.nv()]).expect("a start");
    simulation.set_torques(torques);
    simulation
}

/// A humanoid stands on one foot with the torques of equilibrium. The 9 or 12 rows of the corners have rank
/// 6, and the robot stays at rest, as with one weld.
#[test]
fn a_sole_held_at_its_corners_moves_as_one_weld() {
    let (model, weld) = (humanoid(), 0);
    let (q, zero) = (neutral(&model), vec![0.0; model.nv()]);
    let actuated: Vec<bool> = (0..model.nv()).map(|k| k >= 6).collect();
    let workspace = &mut Workspace::new(&model);
    let set = hold(&model, weld);
    let torques = constrained_inverse_dynamics(&model, workspace, &set, &q, &zero, &zero, &actuated);
    let torques = torques.expect("torques").tau;
    for corners in [weld, 3, 4] {
        let mut simulation = standing(&model, hold(&model, corners), torques.as_slice());
        simulation.run_for(0.02).expect("a run");
        let fastest = simulation.v().iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
        // The constraint forces of the first step have a relative error of h³.
        assert!(fastest < 1e-8, "{corners} corners: {fastest}");
        assert!(simulation.energy_account().imbalance().abs() < 1e-11, "{corners} corners");
    }
}

/// When the humanoid falls, the selected rows differ from those of a weld, and the motion is the same.
#[test]
fn what_moves_over_a_sole_moves_as_over_a_weld() {
    let model = humanoid();
    let torques: Vec<f64> = (0..model.nv()).map(|k| if k < 6 { 0.0 } else { (k as f64).sin() }).collect();
    let [weld, three, four] = [0, 3, 4].map(|corners| {
        let mut simulation = standing(&model, hold(&model, corners), &torques);
        simulation.run_for(0.05).expect("a run");
        simulation.q().to_vec()
    });
    let most = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(most(&weld, &neutral(&model)) > 0.01);
    for other in [three, four] {
        // Positions are projected to 1e-12 m, fifty times.
        assert!(most(&weld, &other) < 1e-9, "{}", most(&weld, &other));
    }
}
