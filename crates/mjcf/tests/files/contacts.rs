//! Compares single steps under MuJoCo's constraint law with MuJoCo, with the contacts, surfaces and weights
//! of the file: `testdata/mjcf/contacts/golden.json`.
//!
//! Tolerance: 1e-8 of the largest change of velocity in a step, because MuJoCo's Newton method stops when the
//! cost no longer decreases: see [`crate::soft`].

use robot_dynamics::conventions::{
    configuration_from_mujoco, configuration_to_mujoco, velocity_from_mujoco, velocity_to_mujoco,
};
use robot_dynamics::mjcf::{LoadOptions, load};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Method, SimulationBuilder};
use serde_json::Value;

use crate::golden::{assert_near, numbers, root};

const SOLVED: f64 = 1e-8;

fn golden() -> Value {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/contacts/golden.json"));
    serde_json::from_str(&text.expect("the file")).expect("JSON")
}

#[test]
fn steps_with_the_surfaces_of_the_file_are_mujocos() {
    let (golden, mut compared) = (golden(), 0);
    for (file, record) in golden["files"].as_object().expect("files") {
        let robot = load(root().join(file), &LoadOptions::default()).expect("a robot");
        assert_eq!(robot.report.counts.ignored_physics, 0, "{file}: {}", robot.report);
        let model = Model::new(robot.description).expect("a model");
        let h = record["time_step"].as_f64().expect("a number");
        let mut simulation =
            SimulationBuilder::new(&model).method(Method::Mujoco).dt(h).build().expect("a simulation");
        assert_eq!(simulation.left_out(), [""; 0], "{file}");
        let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
        let (mut qpos, mut qvel) = (q.clone(), v.clone());
        for (at, step) in record["steps"].as_array().expect("steps").iter().enumerate() {
            let what = format!("{file}, step {at}");
            let [before, after] = ["qvel", "after_qvel"].map(|key| numbers(&step[key]));
            configuration_from_mujoco(&model, &numbers(&step["qpos"]), &mut q);
            velocity_from_mujoco(&model, &q, &before, &mut v);
            simulation.set_state(&q, &v).expect("a state");
            simulation.step().expect("a step");
            velocity_to_mujoco(&model, simulation.q(), simulation.v(), &mut qvel);
            let change =
                |after: &[f64]| -> Vec<f64> { after.iter().zip(&before).map(|(a, b)| a - b).collect() };
            assert_near(&format!("{what}, change of qvel"), &change(&qvel), &change(&after), SOLVED);
            configuration_to_mujoco(&model, simulation.q(), &mut qpos);
            assert_near(&format!("{what}, qpos"), &qpos, &numbers(&step["after_qpos"]), 1e-11);
            assert_eq!(
                simulation.contacts().len() as u64,
                step["contacts"].as_u64().expect("a number"),
                "{what}"
            );
            compared += 1;
        }
    }
    assert!(compared >= 45, "{compared}");
}
