//! A loop declared beside a robot file: the two-armed robot's hands hold each other.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use multibody::{
    ConstrainedSimulation, ConstraintOptions, ConstraintSet, Coupling, DriftCorrection, GravityCompensatedPd,
    LoopClosure, Workspace, ZeroTorque, frame_pose, neutral, project_position,
};

#[test]
fn dual_arm_holds_its_own_hand() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let robot = urdf::load(root.join("robots/dual_arm.urdf"), &urdf::Options::default())?;
    let model = multibody::Model::new(robot.description)?;
    let loops: Vec<LoopClosure> =
        serde_json::from_str(&std::fs::read_to_string(root.join("testdata/loops/dual_arm.json"))?)?;
    // The column's lift is blocked: in free fall the hands would not feel each other.
    let lift = Coupling::new(&model, &[("lift", 1.0)], 0.0)?;
    let grasp = loops[0].resolve(&model)?;
    let set = ConstraintSet::new(&model, [("grasp", grasp.into()), ("block", lift.into())])?;
    let w = &mut Workspace::new(&model);
    let options = ConstraintOptions::default();

    // From elbows bent to the nearest pose in which the hands meet.
    let mut q = neutral(&model);
    for name in ["left_elbow", "right_elbow"] {
        q[model.joint(name).ok_or("no elbow")?.q_index] = 1.0;
    }
    let report = project_position(&model, w, &set, &options, 1e-12, &mut q)?;
    assert!(report.before > 0.1 && report.after <= 1e-12, "{report:?}");
    let hand = |w: &mut Workspace, name| {
        model.frame(name).map(|frame| frame_pose(&model, w, &q, frame).translation).ok_or("no hand")
    };
    let (left, right) = (hand(w, "left_hand")?, hand(w, "right_hand")?);
    assert!((0..3).all(|k| (left[k] - right[k]).abs() < 1e-11), "{left:?} {right:?}");

    // Let go: hand in hand the arms fall, and the books close.
    let rest = vec![0.0; model.nv()];
    let simulation = ConstrainedSimulation::new(&model, &set, 5e-4)
        .with_options(options)
        .with_correction(DriftCorrection::Position { tolerance: 1e-12 })
        .with_dissipation(false)
        .with_samples_every(0);
    let fall = simulation.run(&q, &rest, 2000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    println!(
        "fall: {:?}, energy {:e}, K {} J",
        fall.record.drift,
        fall.motion.ledger.drift(),
        fall.motion.ledger.kinetic()
    );
    assert_eq!(fall.record.smallest_rank, 4);
    assert!(
        fall.record.drift.position <= 1e-12 && fall.record.drift.velocity < 1e-10,
        "{:?}",
        fall.record.drift
    );
    assert!(
        fall.motion.ledger.kinetic() > 10.0 && fall.motion.ledger.drift() < 1e-6,
        "{:?}",
        fall.motion.ledger
    );

    // With gravity-compensated motors at the pose it is held: no force in the grasp is needed, none moves it.
    let gains = (vec![200.0; model.nv()], vec![20.0; model.nv()]);
    let mut pd = GravityCompensatedPd::new(&model, &q, &gains.0, &gains.1)?;
    let hold = simulation.run(&q, &rest, 200, &mut pd, |_| ControlFlow::Continue(()))?;
    let moved = hold.motion.q.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(moved < 1e-9, "{moved}");
    Ok(())
}
