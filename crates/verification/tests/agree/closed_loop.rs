//! A loop declared in addition to a robot file: the hands of the two-armed robot hold each other.

use std::error::Error;
use std::path::Path;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::constraints::{
    ConstraintOptions, ConstraintSet, Coupling, DriftCorrection, LoopClosure, project_position,
};
use robot_dynamics::model::{Workspace, neutral};
use robot_dynamics::simulation::{Effect, GravityCompensatedPd, Method, RunOptions, SimulationBuilder};

#[test]
fn hands_of_dual_arm_hold_each_other() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let robot = robot_dynamics::urdf::load(
        root.join("robots/dual_arm.urdf"),
        &robot_dynamics::urdf::LoadOptions::default(),
    )?;
    let model = robot_dynamics::model::Model::new(robot.description)?;
    let loops: Vec<LoopClosure> =
        serde_json::from_str(&std::fs::read_to_string(root.join("testdata/loops/dual_arm.json"))?)?;
    // The lift of the column is locked: otherwise the grasp carries no force in free fall.
    let lift = Coupling::new(&model, &[("lift", 1.0)], 0.0)?;
    let grasp = loops[0].resolve(&model)?;
    let set = ConstraintSet::new(&model, [("grasp", grasp.into()), ("block", lift.into())])?;
    let w = &mut Workspace::new(&model);
    let options = ConstraintOptions::default();

    // From bent elbows to the nearest pose in which the hands meet.
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

    // The arms fall with joined hands, and the energy account closes.
    let rest = vec![0.0; model.nv()];
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(options.integrator))
        .constraints(set.clone())
        .dt(5e-4)
        .without(Effect::Dissipation)
        .constraint_options(options, DriftCorrection::Position { tolerance: 1e-12 })
        .build()?;
    let fall = simulation.run_steps_from(&q, &rest, 2000, RunOptions::new().sample_ends())?;
    let record = *simulation.constraint_record().ok_or("no constraint")?;
    println!(
        "fall: {:?}, energy {:e}, K {} J",
        record.drift,
        fall.energy_account.drift(),
        fall.energy_account.kinetic()
    );
    assert_eq!(record.smallest_rank, 4);
    assert!(record.drift.position <= 1e-12 && record.drift.velocity < 1e-10, "{:?}", record.drift);
    assert!(
        fall.energy_account.kinetic() > 10.0 && fall.energy_account.drift() < 1e-6,
        "{:?}",
        fall.energy_account
    );

    // With gravity-compensating motors the robot stays at its pose, and the grasp carries no force.
    let gains = (vec![200.0; model.nv()], vec![20.0; model.nv()]);
    let mut pd = GravityCompensatedPd::new(&model, &q, &gains.0, &gains.1)?;
    let hold =
        simulation.run_steps_from(&q, &rest, 200, RunOptions::new().sample_ends().controller(&mut pd))?;
    let moved = hold.q.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(moved < 1e-9, "{moved}");
    Ok(())
}
