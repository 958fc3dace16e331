//! Compares a motion with actuators that pull at contacts with MuJoCo: `testdata/mjcf/soft/golden.json`.

use robot_dynamics::conventions::{configuration_from_mujoco, force_from_mujoco};
use robot_dynamics::mjcf::{LoadOptions, load};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Method, RunOptions, SimulationBuilder};
use serde_json::Value;

use crate::golden::{assert_ends, assert_near, numbers, root};

fn robot() -> Model {
    let path = root().join("testdata/mjcf/soft/adhesion.xml");
    Model::new(load(path, &LoadOptions::default()).expect("a robot").description).expect("a model")
}

/// A cup lifts a ball that another actuator holds to the ground. Some contacts are in the gap beyond their
/// margin. Tolerance: the difference between the two solvers, 1e-11 of the accelerations, grows in contacts.
#[test]
fn adhesion_pulls_as_mujocos() {
    let file = root().join("testdata/mjcf/soft/golden.json");
    let golden: Value =
        serde_json::from_str(&std::fs::read_to_string(file).expect("the file")).expect("JSON");
    let golden = &golden["adhesion"];
    let model = robot();
    let start = numbers(&golden["start"]);
    let mut q = vec![0.0; model.nq()];
    configuration_from_mujoco(&model, &start, &mut q);
    let mut simulation =
        SimulationBuilder::new(&model).dt(1e-3).method(Method::Mujoco).build().expect("a law");
    simulation.reset(&q, &vec![0.0; model.nv()]).expect("a state");
    simulation.set_controls(&numbers(&golden["ctrl"]));
    let (mut step, mut compared) = (0, 0);
    let records = golden["torques"].as_array().expect("a list");
    let count = usize::try_from(golden["steps"].as_u64().expect("a number")).expect("small");
    let mut torques = Vec::new();
    for _ in 0..count {
        simulation.run_steps(1, RunOptions::new()).expect("a step");
        if step % 10 == 0 {
            torques.push(simulation.actuator_torques().to_vec());
        }
        step += 1;
    }
    for (own, record) in torques.iter().zip(records) {
        // The torques are those at the start of the step, whose attitude differs from the end's by h v.
        let mut expected = vec![0.0; model.nv()];
        configuration_from_mujoco(&model, &numbers(&record["qpos"]), &mut q);
        force_from_mujoco(&model, &q, &numbers(&record["torques"]), &mut expected);
        assert_near("torques", &own[..2], &expected[..2], 1e-7);
        compared += 1;
    }
    assert_eq!((compared, step), (30, 300));
    assert_ends("adhesion.xml", &model, golden, (simulation.q(), simulation.v()), 1e-7);
}

/// The work of adhesion is in the energy account, and other methods list what they leave out.
#[test]
fn adhesion_is_in_the_account() {
    let model = robot();
    let mut simulation =
        SimulationBuilder::new(&model).dt(1e-4).method(Method::Mujoco).build().expect("a law");
    assert!(simulation.unsupported_features().is_empty());
    simulation.set_controls(&[1.8, 0.9, 1.0, 0.5]);
    simulation.run_for(0.2).expect("a run");
    let account = simulation.energy_account();
    let scale = account.work().abs().max(1.0);
    assert!(account.imbalance().abs() < 1e-3 * scale, "{account:?}");
    let implicit =
        SimulationBuilder::new(&model).dt(1e-3).method(Method::Implicit).build().expect("contacts");
    let left_out = implicit.unsupported_features();
    assert_eq!(left_out[0].features, ["actuators that pull at contacts"]);
}
