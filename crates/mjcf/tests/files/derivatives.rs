//! Compares the derivatives of forces outside the tree (actuators, tendons, springs, dampers, compensated
//! weight, fluids) by position, velocity, controls and activations with those of MuJoCo's forces
//! (`testdata/mjcf/derivatives.json`).
//!
//! Tolerance: 1e-10 of the largest entry of a matrix. The golden differences of eighth order are certain to
//! 1e-11. The truncation of this library's formula of sixth order is 1e-11 for lengths of 3 cm.

use robot_dynamics::algorithms::{dissipation, gravity};
use robot_dynamics::description::{Activation, RobotDescription};
use robot_dynamics::model::{Model, Workspace, integrate};
use robot_dynamics::simulation::{Actuation, ActuationDerivatives};
use robot_dynamics_mjcf::{LoadOptions, load};
use serde_json::Value;

use crate::controllers::{controls, is_passive, state_count};
use crate::golden::{Golden, assert_near, numbers, root};

const DERIVATIVES: f64 = 1e-10;

/// A golden matrix, and the index of a column in it.
type GoldenColumn = (&'static str, usize);

/// The inputs u of a state, and for each the golden column of its derivative: of a control, or of an
/// activation. The setpoint of a rate limit is at the end of the step and has no column.
fn inputs(robot: &RobotDescription, state: &Value, step: f64) -> (Vec<f64>, Vec<Option<GoldenColumn>>) {
    let act = numbers(&state["act"]);
    let (mut u, mut columns) = (controls(robot, &numbers(&state["ctrl"])), Vec::new());
    let (mut states, mut state_columns) = (Vec::new(), Vec::new());
    let (mut control, mut at) = (0, 0);
    for (k, actuator) in robot.actuators.iter().enumerate() {
        let [lower, upper] = actuator.control_range;
        columns.push((!is_passive(actuator)).then_some(("by_control", control)));
        control += usize::from(!is_passive(actuator));
        if actuator.activation != Activation::None {
            (u[k], columns[k]) = match actuator.activation {
                Activation::RateLimit { .. } => {
                    (actuator.activation.after(step, u[k].max(lower).min(upper), act[at]), None)
                }
                _ => (act[at], Some(("by_activation", at))),
            };
            at += 1;
        }
        for _ in 0..state_count(actuator) {
            states.push(act[at]);
            state_columns.push(Some(("by_activation", at)));
            at += 1;
        }
    }
    assert_eq!(at, act.len());
    (u.into_iter().chain(states).collect(), columns.into_iter().chain(state_columns).collect())
}

/// Subtracts the derivatives of the springs and dampers of joints, which are part of the tree. Both are
/// linear.
fn subtract_joints(model: &Model, q: &[f64], by_position: &mut [f64], by_velocity: &mut [f64]) {
    let mut weightless = model.description().clone();
    weightless.gravity = [0.0; 3];
    let weightless = Model::new(weightless).expect("a robot");
    let (workspace, nv) = (&mut Workspace::new(&weightless), model.nv());
    let (mut unit, mut moved) = (vec![0.0; nv], q.to_vec());
    let [mut here, mut there, mut damped] = [(); 3].map(|()| vec![0.0; nv]);
    gravity(&weightless, workspace, q, &mut here);
    for k in 0..nv {
        unit[k] = 1.0;
        integrate(&weightless, q, &unit, &mut moved);
        gravity(&weightless, workspace, &moved, &mut there);
        dissipation(&weightless, &unit, &mut damped);
        unit[k] = 0.0;
        for i in 0..nv {
            by_position[i * nv + k] -= there[i] - here[i];
            by_velocity[i * nv + k] -= damped[i];
        }
    }
}

#[test]
fn derivatives_of_forces_are_those_of_mujocos() {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/derivatives.json")).expect("a golden file");
    let golden: Value = serde_json::from_str(&text).expect("JSON");
    let mut columns_of_inputs = 0;
    for (file, record) in golden["files"].as_object().expect("files") {
        let mut robot = load(root().join(file), &LoadOptions::default()).expect("a robot").description;
        // Dry friction is a constraint in MuJoCo.
        robot.joints.iter_mut().for_each(|joint| joint.passive.friction = 0.0);
        let model = Model::new(robot.clone()).expect("a robot");
        let actuation = Actuation::new(&model).expect("actuation").without_tendon_friction();
        let mut workspace = actuation.workspace();
        let nv = model.nv();
        for state in record["states"].as_array().expect("states") {
            let (q, v) = Golden::state(&model, state);
            let (u, columns) = inputs(&robot, state, numbers(&record["step"])[0]);
            let [mut by_q, mut by_v] = [(); 2].map(|()| vec![0.0; nv * nv]);
            let mut by_u = vec![0.0; nv * u.len()];
            let out = ActuationDerivatives {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_control: &mut by_u,
            };
            actuation.derivatives(&model, &mut workspace, &u, &q, &v, out);
            subtract_joints(&model, &q, &mut by_q, &mut by_v);
            assert_near(&format!("{file}: by position"), &by_q, &numbers(&state["by_position"]), DERIVATIVES);
            assert_near(&format!("{file}: by velocity"), &by_v, &numbers(&state["by_velocity"]), DERIVATIVES);
            for (k, (name, at)) in columns.iter().enumerate().filter_map(|(k, column)| Some((k, (*column)?)))
            {
                let all = numbers(&state[name]);
                let width = all.len() / nv;
                let expected: Vec<f64> = all.chunks_exact(width).map(|row| row[at]).collect();
                let found: Vec<f64> = by_u.chunks_exact(u.len()).map(|row| row[k]).collect();
                let largest = all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                let off = found.iter().zip(&expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                assert!(off <= DERIVATIVES * largest, "{file}: {name} {at}: {found:?} for {expected:?}");
                columns_of_inputs += 1;
            }
        }
    }
    assert!(columns_of_inputs > 100, "{columns_of_inputs}");
}
