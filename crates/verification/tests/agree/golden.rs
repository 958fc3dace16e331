//! Robots from the files of this repository against Pinocchio with the same files: `testdata/golden`.
//!
//! The two readers choose frames and merge fixed links differently. Tolerances, relative to the largest
//! entry: 1e-12 for sums over at most 40 bodies; solving with M multiplies that by κ(M), at most about 1e4
//! here, hence 1e-9.

use std::collections::BTreeMap;
use std::path::PathBuf;

use robot_dynamics::algorithms::{forward_dynamics, inverse_dynamics, mass_matrix};
use robot_dynamics::batch::{self, BatchWorkspace};
use robot_dynamics::derivatives::{
    ForwardDynamicsDerivativesMut, InverseDynamicsDerivativesMut, forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::urdf::{LoadOptions, load};
use serde_json::Value;

const SUMMED: f64 = 1e-12;
const SOLVED: f64 = 1e-9;

/// A robot, its states, and for each entry of the model's q (and v) the index of Pinocchio's entry.
struct Golden {
    name: String,
    model: Model,
    q: Vec<usize>,
    v: Vec<usize>,
    states: Vec<BTreeMap<String, Value>>,
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// Every golden file that names a robot file.
fn robots() -> Vec<Golden> {
    let folder = root().join("testdata/golden");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    let robots: Vec<Golden> = files
        .iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter_map(|path| {
            let text = std::fs::read_to_string(path).expect("a readable file");
            read(&serde_json::from_str(&text).expect("JSON"))
        })
        .collect();
    assert_eq!(robots.len(), 10, "the robots of `robots/`");
    robots
}

fn read(golden: &Value) -> Option<Golden> {
    let name = golden["urdf"].as_str()?;
    let options = LoadOptions::default().with_strict();
    let options = if golden["base"] == "Floating" { options.with_floating_base() } else { options };
    let loaded = load(root().join(name), &options).unwrap_or_else(|error| panic!("{name}: {error}"));
    let model = Model::new(loaded.description).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (mut q, mut v) = (vec![usize::MAX; model.nq()], vec![usize::MAX; model.nv()]);
    for place in golden["joints"].as_array().expect("joints") {
        let index = |field: &str| usize::try_from(place[field].as_u64().expect(field)).expect(field);
        let joint = place["name"].as_str().expect("a name");
        let joint = model.joint(joint).unwrap_or_else(|| panic!("{name}: no joint {joint}"));
        assert_eq!((joint.nq, joint.nv), (index("nq"), index("nv")), "{name}, {}", joint.name);
        (0..joint.nq).for_each(|i| q[joint.q_index + i] = index("q_index") + i);
        (0..joint.nv).for_each(|i| v[joint.v_index + i] = index("v_index") + i);
    }
    let states = golden["states"].as_array().expect("states").iter();
    let states = states.map(|state| serde_json::from_value(state.clone()).expect("a state")).collect();
    Some(Golden { name: name.to_owned(), model, q, v, states })
}

impl Golden {
    /// A vector over the degrees of freedom, in the model's order.
    fn vector(&self, state: usize, field: &str) -> Vec<f64> {
        let x = numbers(&self.states[state][field]);
        self.v.iter().map(|&i| x[i]).collect()
    }

    fn position(&self, state: usize) -> Vec<f64> {
        let q = numbers(&self.states[state]["q"]);
        self.q.iter().map(|&i| q[i]).collect()
    }

    /// A matrix over the degrees of freedom, in the model's order.
    fn matrix(&self, state: usize, field: &str) -> Vec<f64> {
        let (x, n) = (numbers(&self.states[state][field]), self.model.nv());
        self.v.iter().flat_map(|&i| self.v.iter().map(move |&j| (i, j))).map(|(i, j)| x[i * n + j]).collect()
    }

    fn require(&self, what: &str, state: usize, found: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(found.len(), expected.len(), "{what}");
        let scale = expected.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()));
        for (i, (x, y)) in found.iter().zip(expected).enumerate() {
            // NaN fails, too.
            assert!(
                (x - y).abs() <= tolerance * scale,
                "{}, state {state}: {what}[{i}] is {x}, Pinocchio's {y}, at scale {scale:e}",
                self.name
            );
        }
    }
}

#[test]
fn dynamics_match_pinocchio() {
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.model.nv());
        let w = &mut Workspace::new(model);
        for i in 0..robot.states.len() {
            let q = &robot.position(i)[..];
            let [v, a, tau] = ["v", "a", "tau"].map(|name| robot.vector(i, name));
            let (mut vector, mut matrix) = (vec![0.0; nv], vec![0.0; nv * nv]);
            mass_matrix(model, w, q, &mut matrix);
            robot.require("M", i, &matrix, &robot.matrix(i, "mass_matrix"), SUMMED);
            inverse_dynamics(model, w, q, &v, &a, &mut vector);
            robot.require("τ", i, &vector, &robot.vector(i, "inverse_dynamics"), SUMMED);
            forward_dynamics(model, w, q, &v, &tau, &mut vector);
            robot.require("a", i, &vector, &robot.vector(i, "forward_dynamics"), SOLVED);
        }
    }
}

/// Each state alone, and all as a batch; the columns of q of a floating base are motions along its own axes.
#[test]
fn derivatives_match_pinocchio() {
    let mut tested = 0;
    for robot in robots() {
        let (model, nv, count) = (&robot.model, robot.model.nv(), robot.states.len());
        let w = &mut Workspace::new(model);
        let of_inverse = ["inverse_dynamics_by_q", "inverse_dynamics_by_v"];
        let of_forward = ["forward_dynamics_by_q", "forward_dynamics_by_v", "inverse_mass_matrix"];
        let all = |name: &str| -> Vec<f64> { (0..count).flat_map(|i| robot.vector(i, name)).collect() };
        let q: Vec<f64> = (0..count).flat_map(|i| robot.position(i)).collect();
        let [v, a, tau] = ["v", "a", "tau"].map(all);
        let batch = &mut BatchWorkspace::<f64>::new(model);
        let [mut x, mut y, mut fx, mut fy, mut fz] = [(); 5].map(|()| vec![0.0; count * nv * nv]);
        let out = batch::InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
        batch::inverse_dynamics_derivatives(model, batch, &q, &v, &a, out).expect("good states");
        let out = batch::ForwardDynamicsDerivativesMut {
            by_position: &mut fx,
            by_velocity: &mut fy,
            by_force: &mut fz,
        };
        batch::forward_dynamics_derivatives(model, batch, &q, &v, &tau, out).expect("good states");
        for i in (0..count).filter(|&i| robot.states[i].contains_key(of_inverse[0])) {
            tested += 1;
            let q = &robot.position(i)[..];
            let [v, a, tau] = ["v", "a", "tau"].map(|name| robot.vector(i, name));
            let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![0.0; nv * nv]);
            let own = i * nv * nv..(i + 1) * nv * nv;
            let out = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
            inverse_dynamics_derivatives(model, w, q, &v, &a, out);
            for (field, found, of_batch) in [(of_inverse[0], &by_q, &x), (of_inverse[1], &by_v, &y)] {
                let expected = robot.matrix(i, field);
                robot.require(field, i, found, &expected, SUMMED);
                robot.require(&format!("{field} of a batch"), i, &of_batch[own.clone()], &expected, SUMMED);
            }
            let out = ForwardDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
            };
            forward_dynamics_derivatives(model, w, q, &v, &tau, out);
            let found = [(&by_q, &fx), (&by_v, &fy), (&by_tau, &fz)];
            for (field, (found, of_batch)) in of_forward.iter().zip(found) {
                let expected = robot.matrix(i, field);
                robot.require(field, i, found, &expected, SOLVED);
                robot.require(&format!("{field} of a batch"), i, &of_batch[own.clone()], &expected, SOLVED);
            }
        }
    }
    assert!(tested >= 20, "only {tested} states have derivatives");
}
