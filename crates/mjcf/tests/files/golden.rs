//! Compares the files of `testdata/mjcf` and `robots` with MuJoCo: `testdata/mjcf/golden.json`.
//!
//! Tolerances are relative to the largest compared number. They are 1e-12, because sums over a dozen bodies
//! have another order. For M and bias with meshes, or with several primitives in a body, they are 1e-9:
//! MuJoCo diagonalizes such inertias by an iteration that drops off-diagonal entries below 1e-12 kg·m².

use std::path::PathBuf;

use robot_dynamics::algorithms::potential_energy;
use robot_dynamics::conventions::{
    configuration_from_mujoco, configuration_to_mujoco, force_to_mujoco, velocity_from_mujoco,
    velocity_to_mujoco,
};
use robot_dynamics::description::{
    JointKind, PolynomialStiffnessDamping, RobotDescription, TendonDescription,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::Actuation;
use robot_dynamics_mjcf::{LoadOptions, Robot, load};
use serde_json::Value;

pub(crate) const SUMMED: f64 = 1e-12;
const DIAGONALIZED: f64 = 1e-9;

/// A file, as read, and MuJoCo's results for it.
pub(crate) struct Golden {
    pub(crate) file: String,
    pub(crate) robot: Robot,
    pub(crate) value: Value,
}

pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All files of the golden data.
pub(crate) fn goldens() -> Vec<Golden> {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/golden.json")).expect("the golden file");
    let golden: Value = serde_json::from_str(&text).expect("JSON");
    let files = golden["files"].as_object().expect("files");
    let read = |(file, value): (&String, &Value)| {
        let robot = load(root().join(file), &LoadOptions::default());
        let robot = robot.unwrap_or_else(|error| panic!("{file}: {error}"));
        Golden { file: file.clone(), robot, value: value.clone() }
    };
    let goldens: Vec<Golden> = files.iter().map(read).collect();
    let here = |folder: &str| {
        let entries = std::fs::read_dir(root().join(folder)).expect("the folder");
        entries
            .filter(|entry| entry.as_ref().is_ok_and(|e| e.path().extension().is_some_and(|e| e == "xml")))
            .count()
    };
    assert_eq!(goldens.len(), here("testdata/mjcf") + here("robots"), "run bench/golden/make_mjcf_golden.py");
    goldens
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// Checks the end of a motion: the largest difference relative to the largest number, or to 1.
#[track_caller]
pub(crate) fn assert_ends(
    what: &str,
    model: &Model,
    motion: &Value,
    (own_q, own_v): (&[f64], &[f64]),
    allowed: f64,
) {
    let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
    configuration_to_mujoco(model, own_q, &mut q);
    velocity_to_mujoco(model, own_q, own_v, &mut v);
    for (name, found, end) in [("q", &q, "end_qpos"), ("v", &v, "end_qvel")] {
        let expected = numbers(&motion[end]);
        let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
        assert!(off <= allowed, "{what}: {name}: {off:e}\n{found:?}\n{expected:?}");
    }
}

#[track_caller]
pub(crate) fn assert_near(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}: length");
    // Numbers that cancel to zero are compared with 1.
    let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs())).max(1e-3);
    for (at, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance * scale, "{what}[{at}]: {found} for {expected}");
    }
}

impl Golden {
    fn rows(&self, name: &str) -> &[Value] {
        self.value[name].as_array().expect("a list")
    }

    pub(crate) fn tolerance(&self) -> f64 {
        let diagonalized =
            ["meshes.xml", "primitives.xml", "frame_scale.xml"].iter().any(|name| self.file.ends_with(name));
        if diagonalized { DIAGONALIZED } else { SUMMED }
    }

    /// The robot without equalities and actuators.
    fn bare(&self) -> Model {
        let mut description = self.robot.description.clone();
        (description.equalities, description.actuators) = Default::default();
        Model::new(description).unwrap_or_else(|error| panic!("{}: {error}", self.file))
    }

    /// The forces of springs and of dampers of joints with several degrees of freedom, in MuJoCo's
    /// convention.
    fn of_joints_that_turn_freely(&self, q: &[f64], v: &[f64]) -> [Vec<f64>; 2] {
        let mut robot = self.bare().description().clone();
        robot.tendons.clear();
        robot.links.iter_mut().for_each(|link| link.gravity_compensation = 0.0);
        for joint in robot.joints.iter_mut().filter(|joint| joint.kind.nv() == 1) {
            joint.higher_terms = PolynomialStiffnessDamping::default();
        }
        let model = Model::new(robot).expect("a robot");
        let actuation = Actuation::new(&model).expect("a robot");
        let zeros = vec![0.0; v.len()];
        let [at_rest, moving] = [&zeros[..], v].map(|v| {
            let (mut tau, mut qfrc) = (zeros.clone(), zeros.clone());
            actuation.passive_forces(&model, &mut actuation.workspace(), q, v, &mut tau);
            force_to_mujoco(&model, q, &tau, &mut qfrc);
            qfrc
        });
        let damper = moving.iter().zip(&at_rest).map(|(all, spring)| all - spring).collect();
        [at_rest, damper]
    }

    /// The q and v of a state.
    pub(crate) fn state(model: &Model, state: &Value) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
        configuration_from_mujoco(model, &numbers(&state["qpos"]), &mut q);
        velocity_from_mujoco(model, &q, &numbers(&state["qvel"]), &mut v);
        (q, v)
    }

    /// The index of the degree of freedom of each joint of a tendon, with its coefficient.
    fn terms(model: &Model, tendon: &TendonDescription) -> Vec<(usize, f64)> {
        let joint = |name: &str| model.joints().iter().find(|joint| joint.name == name).expect("a joint");
        tendon.terms.iter().map(|(name, c)| (joint(name).v_index, *c)).collect()
    }
}

/// The moving joints of the description, in order.
fn moving(robot: &RobotDescription) -> impl Iterator<Item = &robot_dynamics::description::JointDescription> {
    robot.joints.iter().filter(|joint| joint.kind.nv() > 0)
}

/// The joints with one degree of freedom whose springs or dampers have nonlinear terms.
fn higher_terms<'a>(
    robot: &'a RobotDescription,
    model: &'a Model,
) -> impl Iterator<Item = (&'a robot_dynamics::model::Joint, &'a robot_dynamics::description::JointDescription)>
{
    let of = |own: &'a robot_dynamics::description::JointDescription| {
        let joint = model.joints().iter().find(|joint| joint.name == own.name).expect("a joint");
        (joint, own)
    };
    let single = |own: &&robot_dynamics::description::JointDescription| {
        own.kind.nv() == 1 && !own.higher_terms.is_zero()
    };
    robot.joints.iter().filter(single).map(of)
}

#[test]
fn names_order_and_properties_of_joints() {
    for golden in goldens() {
        let joints: Vec<_> = moving(&golden.robot.description).collect();
        assert_eq!(joints.len(), golden.rows("joints").len(), "{}", golden.file);
        for (joint, theirs) in joints.into_iter().zip(golden.rows("joints")) {
            let what = format!("{}: joint {:?}", golden.file, joint.name);
            let name = theirs["name"].as_str().expect("a name");
            assert!(name.is_empty() || joint.name == name, "{what} for {name:?}");
            let kind = match joint.kind {
                JointKind::Revolute { .. } | JointKind::Continuous { .. } => "hinge",
                JointKind::Prismatic { .. } => "slide",
                JointKind::Spherical => "ball",
                JointKind::Floating => "free",
                _ => "none",
            };
            assert_eq!(theirs["kind"], kind, "{what}");
            let range = numbers(&theirs["range"]);
            let limited = theirs["limited"].as_bool().expect("a word");
            let [lower, upper] =
                if limited { [range[0], range[1]] } else { [f64::NEG_INFINITY, f64::INFINITY] };
            let near = |a: f64, b: f64| a == b || (a - b).abs() < 1e-15 * a.abs();
            assert!(
                near(joint.limits.lower, lower) && near(joint.limits.upper, upper),
                "{what}: {:?}",
                joint.limits
            );
            let force = numbers(&theirs["force_range"]);
            let force = if theirs["force_limited"] == true {
                [force[0], force[1]]
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            };
            assert_eq!(joint.actuator_force_range, force, "{what}");
            let passive = joint.passive;
            let ours = [passive.armature, passive.damping, passive.friction];
            let names = ["armature", "damping", "friction"];
            let expected: Vec<f64> =
                names.iter().map(|name| theirs[*name].as_f64().expect("a number")).collect();
            assert_near(&what, &ours, &expected, SUMMED);
            if joint.kind.nv() == 1 {
                let expected = [&theirs["stiffness"], &theirs["spring_reference"]]
                    .map(|x| x.as_f64().expect("a number"));
                assert_near(&what, &[passive.stiffness, passive.rest], &expected, SUMMED);
            }
        }
    }
}

#[test]
fn masses_of_bodies_and_the_world() {
    for golden in goldens() {
        let description = &golden.robot.description;
        assert_near(&golden.file, &description.gravity, &numbers(&golden.value["gravity"]), 0.0);
        let step = golden.value["time_step"].as_f64();
        assert!(description.time_step.is_none_or(|own| Some(own) == step), "{}", golden.file);
        let mut compared = 0;
        for body in golden.rows("bodies") {
            let name = body["name"].as_str().expect("a name");
            let Some(link) = description.links.iter().find(|link| link.name == name) else {
                assert!(name.is_empty(), "{}: no link {name:?}", golden.file);
                continue;
            };
            let mass = link.mass_properties.map_or(0.0, |body| body.mass());
            // MuJoCo's numbers for the world include the mass of its geoms, which does not move.
            if name != "world" {
                assert_near(&format!("{}: {name}", golden.file), &[mass], &numbers(&body["mass"]), SUMMED);
                compared += 1;
            }
            assert_eq!(Some(link.gravity_compensation), body["gravity_compensation"].as_f64(), "{name}");
        }
        assert!(compared > 0, "{}", golden.file);
    }
}

#[test]
fn mass_matrices_and_biases() {
    for golden in goldens() {
        let model = golden.bare();
        let nv = model.nv();
        for (at, state) in golden.rows("states").iter().enumerate() {
            let what = format!("{}: state {at}", golden.file);
            let (q, v) = Golden::state(&model, state);
            let mass = numbers(&state["mass_matrix"]);
            let mut spring = numbers(&state["spring"]);
            for tendon in &golden.robot.description.tendons {
                // The force of the spring along c.
                let terms = Golden::terms(&model, tendon);
                let position = |v: usize| {
                    model.joints().iter().find(|joint| joint.v_index == v).expect("a joint").q_index
                };
                let length: f64 = terms.iter().map(|&(i, c)| c * q[position(i)]).sum();
                let stretch = tendon.stretch(length);
                let pull = tendon.passive.stiffness * stretch - tendon.higher_terms.spring_force(stretch);
                for &(i, a) in &terms {
                    spring[i] += a * pull;
                }
            }
            // The nonlinear terms of joint springs are passive forces, too.
            for (joint, own) in higher_terms(&golden.robot.description, &model) {
                spring[joint.v_index] -= own.higher_terms.spring_force(q[joint.q_index] - own.passive.rest);
            }
            let [turning, _] = golden.of_joints_that_turn_freely(&q, &v);
            spring.iter_mut().zip(turning).for_each(|(spring, own)| *spring -= own);
            // The same acceleration on both sides: MuJoCo's M ẇ + bias, with q̈ of this library converted to
            // MuJoCo's convention. Columns of M are differences of such forces, so they need no convention of
            // their own.
            let inverse_dynamics = |a: &[f64]| {
                let mut qfrc = vec![0.0; nv];
                let tau = model.inverse_dynamics(&q, &v, a).expect("finite");
                force_to_mujoco(&model, &q, tau.as_slice(), &mut qfrc);
                qfrc
            };
            let bias = numbers(&state["bias"]);
            let mut qacc = vec![0.0; nv];
            for k in 0..=nv {
                let mut a = vec![0.0; nv];
                if k > 0 {
                    a[k - 1] = 1.0;
                }
                robot_dynamics::conventions::acceleration_to_mujoco(&model, &q, &v, &a, &mut qacc);
                let expected: Vec<f64> = (0..nv)
                    .map(|i| bias[i] - spring[i] + (0..nv).map(|j| mass[i * nv + j] * qacc[j]).sum::<f64>())
                    .collect();
                assert_near(
                    &format!("{what}, column {k}"),
                    &inverse_dynamics(&a),
                    &expected,
                    golden.tolerance(),
                );
            }
        }
    }
}

#[test]
fn damping_of_joints() {
    for golden in goldens() {
        let model = golden.bare();
        for state in golden.rows("states") {
            let (q, v) = Golden::state(&model, state);
            let mut damper = numbers(&state["damper"]);
            for tendon in &golden.robot.description.tendons {
                let terms = Golden::terms(&model, tendon);
                let rate: f64 = terms.iter().map(|&(i, c)| c * v[i]).sum();
                for &(i, c) in &terms {
                    damper[i] +=
                        c * (tendon.passive.damping * rate - tendon.higher_terms.damping_force(rate));
                }
            }
            for (joint, own) in higher_terms(&golden.robot.description, &model) {
                damper[joint.v_index] -= own.higher_terms.damping_force(v[joint.v_index]);
            }
            let [_, turning] = golden.of_joints_that_turn_freely(&q, &v);
            damper.iter_mut().zip(turning).for_each(|(damper, own)| *damper -= own);
            let own: Vec<f64> = model
                .joints()
                .iter()
                .flat_map(|joint| v[joint.v_index..][..joint.nv].iter().map(|v| -joint.passive.damping * v))
                .collect();
            let mut found = vec![0.0; model.nv()];
            force_to_mujoco(&model, &q, &own, &mut found);
            assert_near(&golden.file, &found, &damper, SUMMED);
        }
    }
}

/// Compares all passive forces, and the energy of gravity and springs up to a constant.
#[test]
fn passive_forces_and_the_potential_energy() {
    for golden in goldens() {
        let mut robot = golden.robot.description.clone();
        // Dry friction is a constraint in MuJoCo.
        robot.tendons.iter_mut().for_each(|tendon| tendon.passive.friction = 0.0);
        let model = Model::new(robot).expect("a robot");
        let actuation = Actuation::new(&model).expect("a robot");
        let (mut memory, mut workspace) = (actuation.workspace(), Workspace::new(&model));
        let mut energies = Vec::new();
        // MuJoCo's energy includes the weight that is compensated.
        let mut heavy = golden.robot.description.clone();
        heavy.links.iter_mut().for_each(|link| link.gravity_compensation = 0.0);
        let springs = Actuation::new(&Model::new(heavy).expect("a robot")).expect("a robot");
        for state in golden.rows("states") {
            let (q, v) = Golden::state(&model, state);
            let (mut tau, mut found) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
            actuation.passive_forces(&model, &mut memory, &q, &v, &mut tau);
            for joint in model.joints() {
                let passive = &joint.passive;
                for k in joint.v() {
                    tau[k] -= passive.damping * v[k];
                    if passive.stiffness != 0.0 {
                        tau[k] -= passive.stiffness * (q[joint.q_index] - passive.rest);
                    }
                }
            }
            force_to_mujoco(&model, &q, &tau, &mut found);
            let compensated =
                golden.robot.description.links.iter().any(|link| link.gravity_compensation != 0.0);
            let allowed = if compensated { golden.tolerance() } else { SUMMED };
            assert_near(&golden.file, &found, &numbers(&state["passive"]), allowed);
            energies.push((
                potential_energy(&model, &mut workspace, &q) + springs.stored_energy(&mut memory, &q),
                state["potential_energy"].as_f64().expect("a number"),
            ));
        }
        let (ours, theirs): (Vec<f64>, Vec<f64>) =
            energies.windows(2).map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1)).unzip();
        assert_near(&golden.file, &ours, &theirs, golden.tolerance());
    }
}

/// Compares the poses of bodies and sites by name, in random states.
#[test]
fn places_of_bodies_and_sites() {
    let mut compared = 0;
    for golden in goldens() {
        let model = golden.bare();
        let names = |list: &str, key: Option<&str>| -> Vec<String> {
            let own = |row: &Value| key.map_or(row, |key| &row[key]).as_str().expect("a name").to_owned();
            golden.rows(list).iter().map(own).collect()
        };
        for state in golden.rows("states") {
            let (q, _) = Golden::state(&model, state);
            for (names, positions, rotations) in [
                (names("bodies", Some("name")), "body_positions", "body_rotations"),
                (names("sites", None), "site_positions", "site_rotations"),
            ] {
                let (positions, rotations) = (numbers(&state[positions]), numbers(&state[rotations]));
                for (at, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
                    let pose = model.frame_pose(&q, model.frame(name).expect("a frame")).expect("finite");
                    let what = format!("{}: {name}", golden.file);
                    assert_near(&what, &pose.translation, &positions[3 * at..3 * at + 3], SUMMED);
                    assert_near(&what, pose.rotation.as_flattened(), &rotations[9 * at..9 * at + 9], SUMMED);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

/// The conversions to and from MuJoCo's convention are inverse, so converted states equal those of the file.
#[test]
fn states_are_the_files() {
    for golden in goldens() {
        let model = golden.bare();
        for state in golden.rows("states") {
            let (q, v) = Golden::state(&model, state);
            let mut qvel = vec![0.0; model.nv()];
            velocity_to_mujoco(&model, &q, &v, &mut qvel);
            assert_near(&golden.file, &qvel, &numbers(&state["qvel"]), SUMMED);
        }
    }
}
