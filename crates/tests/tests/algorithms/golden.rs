//! Every quantity against Pinocchio's, on the robots of testdata/golden that are given as numbers.
//!
//! bench/golden/README.md states the tool, its version and the meaning of each field. Tolerance: 1e-11 of the
//! largest number of an array, for two programs with different orders of summation; 10 κ(M) ε where M is
//! inverted.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use robot_dynamics::algorithms::{
    ReferenceFrame, bias, center_of_mass, center_of_mass_velocity, centroidal_momentum,
    centroidal_momentum_matrix, coriolis_matrix, forward_dynamics, forward_dynamics_by_cholesky,
    frame_bias_acceleration, frame_jacobian, frame_pose, gravity, inverse_dynamics, inverse_mass_matrix,
    joint_torque_regressor, kinetic_energy, mass_matrix, potential_energy,
};
use robot_dynamics::derivatives::{
    ForwardDynamicsDerivativesMut, InverseDynamicsDerivativesMut, forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
};
use robot_dynamics::description::{Base, RobotDescription};
use robot_dynamics::model::{Model, Workspace};
use serde::Deserialize;
use serde_json::Value;

const TOLERANCE: f64 = 1e-11;

#[derive(Deserialize)]
struct Golden {
    description: Option<RobotDescription>,
    nq: usize,
    nv: usize,
    moving_mass: f64,
    joints: Vec<Place>,
    tip: String,
    states: Vec<BTreeMap<String, Value>>,
}

/// The place of a joint's numbers in Pinocchio's vectors.
#[derive(Deserialize)]
struct Place {
    name: String,
    q_index: usize,
    nq: usize,
    v_index: usize,
    nv: usize,
}

/// One robot with the map from Pinocchio's order of coordinates to the model's.
struct Robot {
    name: String,
    model: Model,
    golden: Golden,
    /// For each entry of the model's q (and v) the index of Pinocchio's entry.
    q: Vec<usize>,
    v: Vec<usize>,
}

fn robots() -> Vec<Robot> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/golden");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).expect(folder).map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    let robots: Vec<Robot> = files
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter_map(|path| {
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let text = std::fs::read_to_string(&path).expect("a readable file");
            let mut golden: Golden =
                serde_json::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
            // The other files refer to URDF files, which this program does not read.
            let description = golden.description.take()?;
            let model = Model::new(description).unwrap_or_else(|error| panic!("{name}: {error}"));
            Some(Robot::new(name, model, golden))
        })
        .collect();
    assert!(robots.len() >= 15, "only {} golden robots found in {folder}", robots.len());
    robots
}

impl Robot {
    fn new(name: String, model: Model, golden: Golden) -> Self {
        assert_eq!((model.nq(), model.nv()), (golden.nq, golden.nv), "{name}");
        let (mut q, mut v) = (vec![usize::MAX; golden.nq], vec![usize::MAX; golden.nv]);
        for place in &golden.joints {
            let joint = model.joint(&place.name).unwrap_or_else(|| panic!("{name}: no joint {}", place.name));
            assert_eq!((joint.nq, joint.nv), (place.nq, place.nv), "{name}, {}", place.name);
            (0..place.nq).for_each(|i| q[joint.q_index + i] = place.q_index + i);
            (0..place.nv).for_each(|i| v[joint.v_index + i] = place.v_index + i);
        }
        Self { name, model, golden, q, v }
    }

    fn states(&self) -> impl Iterator<Item = State<'_>> {
        self.golden.states.iter().enumerate().map(|(index, fields)| State { robot: self, index, fields })
    }
}

struct State<'a> {
    robot: &'a Robot,
    index: usize,
    fields: &'a BTreeMap<String, Value>,
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap_or_else(|| panic!("{number} is not a number"))],
    }
}

fn size(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()))
}

impl State<'_> {
    fn field(&self, name: &str) -> Vec<f64> {
        numbers(self.fields.get(name).unwrap_or_else(|| panic!("{}: no field {name}", self.robot.name)))
    }

    fn q(&self) -> Vec<f64> {
        let q = self.field("q");
        self.robot.q.iter().map(|&i| q[i]).collect()
    }

    /// A vector over the degrees of freedom, in the model's order.
    fn vector(&self, name: &str) -> Vec<f64> {
        let x = self.field(name);
        self.robot.v.iter().map(|&i| x[i]).collect()
    }

    /// A matrix whose columns (and rows, if it is square) are degrees of freedom, in the model's order.
    fn columns(&self, x: &[f64]) -> Vec<f64> {
        let nv = self.robot.golden.nv;
        x.chunks(nv).flat_map(|row| self.robot.v.iter().map(|&j| row[j])).collect()
    }

    fn square(&self, name: &str) -> Vec<f64> {
        let nv = self.robot.golden.nv;
        let matrix = self.columns(&self.field(name));
        self.robot.v.iter().flat_map(|&i| matrix[i * nv..(i + 1) * nv].to_vec()).collect()
    }

    fn close(&self, what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
        self.close_at_scale(what, found, expected, tolerance, size(expected));
    }

    #[track_caller]
    fn close_at_scale(&self, what: &str, found: &[f64], expected: &[f64], tolerance: f64, scale: f64) {
        assert_eq!(found.len(), expected.len(), "{what}");
        for (i, (x, y)) in found.iter().zip(expected).enumerate() {
            let gap = (x - y).abs();
            // NaN fails, too.
            assert!(
                gap <= tolerance * scale,
                "{}, state {}: {what}[{i}] is {x}, Pinocchio's {y}: off by {gap:e} at scale {scale:e}",
                self.robot.name,
                self.index
            );
        }
    }

    /// κ(M).
    fn condition(&self) -> f64 {
        let nv = self.robot.golden.nv;
        let eigenvalues =
            DMatrix::from_row_slice(nv, nv, &self.square("mass_matrix")).symmetric_eigenvalues();
        eigenvalues.max() / eigenvalues.min()
    }
}

#[test]
fn dynamics_match_pinocchio() {
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.golden.nv);
        let w = &mut Workspace::new(model);
        for state in robot.states() {
            let q = &state.q()[..];
            let [v, a, tau] = ["v", "a", "tau"].map(|name| state.vector(name));
            let (mut vector, mut matrix) = (vec![0.0; nv], vec![0.0; nv * nv]);
            mass_matrix(model, w, q, &mut matrix);
            state.close("M", &matrix, &state.square("mass_matrix"), TOLERANCE);
            bias(model, w, q, &v, &mut vector);
            state.close("C v + g", &vector, &state.vector("bias"), TOLERANCE);
            // For an arm in balance g is nearly zero: the scale is the weight on a lever of a decimetre.
            gravity(model, w, q, &mut vector);
            let expected = state.vector("gravity");
            let scale = size(&expected).max(robot.golden.moving_mass);
            state.close_at_scale("g", &vector, &expected, TOLERANCE, scale);
            inverse_dynamics(model, w, q, &v, &a, &mut vector);
            state.close("τ", &vector, &state.vector("inverse_dynamics"), TOLERANCE);

            let solved = 10.0 * state.condition() * f64::EPSILON;
            forward_dynamics(model, w, q, &v, &tau, &mut vector);
            state.close("v̇", &vector, &state.vector("forward_dynamics"), solved);
            forward_dynamics_by_cholesky(model, w, q, &v, &tau, &mut vector);
            state.close("v̇ by Cholesky", &vector, &state.vector("forward_dynamics"), solved);
            if state.fields.contains_key("inverse_mass_matrix") {
                inverse_mass_matrix(model, w, q, &mut matrix);
                state.close("M⁻¹", &matrix, &state.square("inverse_mass_matrix"), solved);
            }

            let energy = |name: &str| state.field(name)[0];
            let kinetic = kinetic_energy(model, w, q, &v);
            state.close("K", &[kinetic], &[energy("kinetic_energy")], TOLERANCE);
            // V is a difference of heights: the scale is the weight times a metre.
            let scale = energy("potential_energy").abs().max(9.81 * robot.golden.moving_mass);
            let potential = potential_energy(model, w, q);
            state.close_at_scale("V", &[potential], &[energy("potential_energy")], TOLERANCE, scale);
        }
    }
}

/// ∂τ/∂q, ∂τ/∂v, ∂a/∂q, ∂a/∂v; the columns of q of a floating base are motions along its own axes.
#[test]
fn derivatives_match_pinocchio() {
    let mut tested = 0;
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.golden.nv);
        let w = &mut Workspace::new(model);
        for state in robot.states().filter(|state| state.fields.contains_key("inverse_dynamics_by_q")) {
            tested += 1;
            let q = &state.q()[..];
            let [v, a, tau] = ["v", "a", "tau"].map(|name| state.vector(name));
            let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![0.0; nv * nv]);
            let out = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
            inverse_dynamics_derivatives(model, w, q, &v, &a, out);
            state.close("∂τ/∂q", &by_q, &state.square("inverse_dynamics_by_q"), TOLERANCE);
            state.close("∂τ/∂v", &by_v, &state.square("inverse_dynamics_by_v"), TOLERANCE);
            let solved = 10.0 * state.condition() * f64::EPSILON;
            let out = ForwardDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
            };
            forward_dynamics_derivatives(model, w, q, &v, &tau, out);
            state.close("∂a/∂q", &by_q, &state.square("forward_dynamics_by_q"), solved);
            state.close("∂a/∂v", &by_v, &state.square("forward_dynamics_by_v"), solved);
            state.close("∂a/∂τ", &by_tau, &state.square("inverse_mass_matrix"), solved);
        }
    }
    assert!(tested >= 30, "only {tested} states have derivatives");
}

/// C on a fixed base. On a floating base the reference has another C with the same product: C v and C + Cᵀ.
#[test]
fn coriolis_matrix_matches_pinocchio() {
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.golden.nv);
        for state in robot.states() {
            let (q, v) = (state.q(), state.vector("v"));
            let mut c = vec![0.0; nv * nv];
            coriolis_matrix(model, &mut Workspace::new(model), &q, &v, &mut c);
            let expected = state.square("coriolis_matrix");
            if model.description().base == Base::Fixed {
                state.close("C", &c, &expected, TOLERANCE);
            }
            let symmetric =
                |c: &[f64]| -> Vec<f64> { (0..nv * nv).map(|i| c[i] + c[i % nv * nv + i / nv]).collect() };
            let product = |c: &[f64]| -> Vec<f64> {
                c.chunks(nv).map(|row| row.iter().zip(&v).map(|(c, v)| c * v).sum()).collect()
            };
            let scale = size(&expected);
            state.close_at_scale("C + Cᵀ", &symmetric(&c), &symmetric(&expected), TOLERANCE, scale);
            state.close_at_scale("C v", &product(&c), &product(&expected), TOLERANCE, scale * size(&v));
        }
    }
}

#[test]
fn momentum_matches_pinocchio() {
    for robot in robots() {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        assert!((model.moving_mass() - robot.golden.moving_mass).abs() <= 1e-14 * robot.golden.moving_mass);
        for state in robot.states() {
            let (q, v) = (&state.q()[..], &state.vector("v")[..]);
            state.close("c", &center_of_mass(model, w, q), &state.field("center_of_mass"), TOLERANCE);
            let velocity = center_of_mass_velocity(model, w, q, v);
            state.close("ċ", &velocity, &state.field("center_of_mass_velocity"), TOLERANCE);
            let h = centroidal_momentum(model, w, q, v);
            let expected = state.field("centroidal_momentum");
            state.close("h", &[h.linear, h.angular].concat(), &expected, TOLERANCE);
            let mut matrix = vec![0.0; 6 * model.nv()];
            centroidal_momentum_matrix(model, w, q, &mut matrix);
            let expected = state.columns(&state.field("centroidal_momentum_matrix"));
            state.close("A", &matrix, &expected, TOLERANCE);
        }
    }
}

#[test]
fn frames_match_pinocchio() {
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.golden.nv);
        let w = &mut Workspace::new(model);
        let frame = |joint: &str| {
            let child = &model.joint(joint).unwrap_or_else(|| panic!("no joint {joint}")).child_link;
            model.frame(child).expect("every link is a frame")
        };
        let tip = frame(&robot.golden.tip);
        for state in robot.states() {
            let (q, v) = (&state.q()[..], &state.vector("v")[..]);
            for (joint, expected) in state.fields["world_from_joint"].as_object().expect("poses by joint") {
                let pose = frame_pose(model, w, q, frame(joint));
                let found: Vec<f64> = (0..3)
                    .flat_map(|i| pose.rotation[i].into_iter().chain([pose.translation[i]]))
                    .chain([0.0, 0.0, 0.0, 1.0])
                    .collect();
                state.close(&format!("pose of {joint}"), &found, &numbers(expected), TOLERANCE);
            }
            let mut jacobian = vec![0.0; 6 * nv];
            for form in ["world", "local", "local_world_aligned"] {
                let of = |field: &str| state.columns(&numbers(&state.fields[field][form]));
                let bias = match form {
                    "world" => {
                        frame_jacobian(model, w, q, tip, ReferenceFrame::World, &mut jacobian);
                        frame_bias_acceleration(model, w, q, v, tip, ReferenceFrame::World)
                    }
                    "local" => {
                        frame_jacobian(model, w, q, tip, ReferenceFrame::Local, &mut jacobian);
                        frame_bias_acceleration(model, w, q, v, tip, ReferenceFrame::Local)
                    }
                    _ => {
                        frame_jacobian(model, w, q, tip, ReferenceFrame::LocalWorldAligned, &mut jacobian);
                        frame_bias_acceleration(model, w, q, v, tip, ReferenceFrame::LocalWorldAligned)
                    }
                };
                state.close(&format!("J {form}"), &jacobian, &of("tip_jacobian"), TOLERANCE);
                // J̇ v from Pinocchio's J̇.
                let rate = of("tip_jacobian_rate");
                let expected: Vec<f64> =
                    rate.chunks(nv).map(|row| row.iter().zip(v).map(|(j, v)| j * v).sum()).collect();
                let found = [bias.linear, bias.angular].concat();
                let scale = size(&rate) * size(v);
                state.close_at_scale(&format!("J̇ v {form}"), &found, &expected, TOLERANCE, scale);
            }
        }
    }
}

/// Pinocchio's columns are in the order of its moving links, which are named after their joints.
#[test]
fn regressor_matches_pinocchio() {
    let mut tested = 0;
    for robot in robots() {
        let (model, nv) = (&robot.model, robot.golden.nv);
        let links: Vec<&str> = model.moving_links().collect();
        for state in robot.states().filter(|state| state.fields.contains_key("joint_torque_regressor")) {
            tested += 1;
            let n = 10 * links.len();
            let mut found = vec![0.0; nv * n];
            let [v, a] = ["v", "a"].map(|name| state.vector(name));
            joint_torque_regressor(model, &mut Workspace::new(model), &state.q(), &v, &a, &mut found);
            let theirs = state.field("joint_torque_regressor");
            let mut expected = vec![0.0; nv * n];
            for (column, place) in robot.golden.joints.iter().enumerate() {
                let child = &model.joint(&place.name).expect("matched by name").child_link;
                let own = links.iter().position(|link| link == child).expect("a moving link");
                for row in 0..nv {
                    let from = robot.v[row] * n + 10 * column;
                    expected[row * n + 10 * own..row * n + 10 * (own + 1)]
                        .copy_from_slice(&theirs[from..from + 10]);
                }
            }
            state.close("Y", &found, &expected, TOLERANCE);
        }
    }
    assert!(tested >= 8, "only {tested} states have a regressor");
}
