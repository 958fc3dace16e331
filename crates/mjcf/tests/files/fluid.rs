//! Compares the forces of a fluid, and motions with them, with MuJoCo (`testdata/mjcf/fluid/golden.json`).
//!
//! Tolerance of forces: 1e-10 of the largest one, because MuJoCo's principal axes have an error of 1e-12 of
//! its inertias, and sums have another order. Motions by the same stages of RK4, or by MuJoCo's Euler steps:
//! 1e-8, because of the tumbling free bodies, whose coordinates differ (see `motion.rs`).

use robot_dynamics::conventions::force_to_mujoco;
use robot_dynamics::description::{FluidForm, RobotDescription};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Actuation, Effect, FluidForces, Integrator, Method, SimulationBuilder};
use robot_dynamics_mjcf::{LoadOptions, load, parse};
use serde_json::Value;

use crate::golden::{Golden, assert_ends, assert_near, numbers, root};

const FORCES: f64 = 1e-10;
const MOTIONS: f64 = 1e-8;

fn golden() -> Value {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/fluid/golden.json"));
    serde_json::from_str(&text.expect("the golden file")).expect("JSON")
}

fn robot(file: &str) -> RobotDescription {
    let robot =
        load(root().join(file), &LoadOptions::default()).unwrap_or_else(|error| panic!("{file}: {error}"));
    assert_eq!(robot.report.counts.ignored_physics, 0, "{}", robot.report);
    robot.description
}

fn compare_forces(file: &str, robot: RobotDescription, states: &Value) {
    let model = Model::new(robot).expect("a robot");
    let fluid = FluidForces::new(&model);
    let mut memory = fluid.workspace(&model);
    for state in states.as_array().expect("states") {
        let (q, v) = Golden::state(&model, state);
        let (mut tau, mut qfrc) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        fluid.forces(&model, &mut memory, &q, &v, &mut tau);
        force_to_mujoco(&model, &q, &tau, &mut qfrc);
        let expected = numbers(&state["qfrc_fluid"]);
        let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let relative = |forces: &[f64]| forces.iter().map(|x| x / scale).collect::<Vec<_>>();
        assert_near(file, &relative(&qfrc), &relative(&expected), FORCES);
    }
}

#[test]
fn forces_are_mujocos() {
    for (file, record) in golden()["files"].as_object().expect("files") {
        compare_forces(file, robot(file), &record["states"]);
    }
}

#[test]
fn added_masses_are_mujocos() {
    let mut compared = 0;
    for (file, record) in golden()["files"].as_object().expect("files") {
        let robot = robot(file);
        for (link, added) in record["added"].as_object().expect("links") {
            let shape = robot.fluid_shapes.iter().find(|shape| shape.link == *link).expect("a shape");
            let FluidForm::Ellipsoid(own) = shape.form else { panic!("{link}: {shape:?}") };
            // The largest moment of the three, because that about an axis of symmetry cancels to zero.
            let added = numbers(added);
            let (mass, moment) = added.split_at(3);
            for (found, expected) in [(own.added_mass, mass), (own.added_inertia, moment)] {
                let scale = expected.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(*x));
                let relative = |numbers: &[f64]| numbers.iter().map(|x| x / scale).collect::<Vec<_>>();
                assert_near(link, &relative(&found), &relative(expected), 1e-11);
            }
            compared += 1;
        }
    }
    assert!(compared >= 8, "{compared}");
}

#[test]
fn motions_end_where_mujocos_do() {
    let mut compared = 0;
    let golden = golden();
    let files = golden["files"].as_object().expect("files").iter();
    let methods = [("motion", Method::Fixed(Integrator::RungeKutta4)), ("euler", Method::Mujoco)];
    for ((file, record), (name, method)) in files.flat_map(|file| methods.map(|method| (file, method))) {
        let Some(motion) = record.get(name) else { continue };
        let model = Model::new(robot(file)).expect("a robot");
        let (q, v) = Golden::state(&model, motion);
        let mut simulation = SimulationBuilder::new(&model)
            .dt(numbers(&motion["step"])[0])
            .method(method)
            .without(Effect::Contacts)
            .build()
            .expect("a simulation");
        assert!(simulation.acting().contains(&Effect::Dissipation));
        simulation.reset(&q, &v).expect("a state");
        simulation.run_for(numbers(&motion["duration"])[0]).unwrap_or_else(|error| panic!("{file}: {error}"));
        let end = (simulation.q(), simulation.v());
        assert_ends(&format!("{file}: {name}"), &model, motion, end, MOTIONS);
        compared += 1;
    }
    assert!(compared >= 6, "{compared}");
}

/// A conservative simulation has no fluid.
#[test]
fn the_fluid_is_part_of_dissipation() {
    let model = Model::new(robot("testdata/mjcf/fluid/drone.xml")).expect("a robot");
    let actuation = Actuation::new(&model).expect("a robot");
    assert!(!actuation.is_empty() && actuation.without_dissipation().is_empty());
}

/// Neither flag alone disables the fluid; both together do, as in MuJoCo.
#[test]
fn flags_disable_the_fluid_together() {
    for (flags, acts) in [("spring='disable'", true), ("spring='disable' damper='disable'", false)] {
        let text = format!(
            "<mujoco><option density='1'><flag {flags}/></option><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>"
        );
        let robot = parse(&text, &LoadOptions::default()).expect("a robot").description;
        assert_eq!((robot.medium.acts(), robot.fluid_shapes.len()), (acts, usize::from(acts)), "{flags}");
    }
}

/// A written robot has the same forces: boxes, ellipsoids on shapes, and others as geoms of their own.
#[test]
fn written_files_keep_the_forces() {
    for (file, record) in golden()["files"].as_object().expect("files") {
        let written = robot_dynamics_mjcf::write(&robot(file), None).expect("a file");
        let lost = written.lost_physics().filter(|lost| lost.message.contains("fluid"));
        assert_eq!(lost.count(), 0, "{file}");
        let back = parse(&written.text, &LoadOptions::default()).expect("its own file").description;
        compare_forces(file, back, &record["states"]);
    }
}

/// The writer names a box other than that of the inertia, and a link that no fluid touches.
#[test]
fn losses_of_a_written_fluid_are_named() {
    let file = "testdata/mjcf/fluid/swimmer.xml";
    let mut robot = robot(file);
    robot.fluid_shapes.retain(|shape| shape.link != "fin");
    let FluidForm::InertiaBox { size } = &mut robot.fluid_shapes[0].form else { panic!("a box") };
    size[0] *= 2.0;
    let written = robot_dynamics_mjcf::write(&robot, None).expect("a file");
    let lost: Vec<&str> = written.lost_physics().map(|lost| lost.message.as_str()).collect();
    let expected = [
        "its fluid box is not that of its inertia, which MuJoCo uses",
        "no fluid acts on it, but MuJoCo applies its inertia box",
    ];
    assert_eq!(lost, expected);
}

#[test]
fn descriptions_keep_the_fluid_as_json() {
    for (file, _) in golden()["files"].as_object().expect("files") {
        let robot = robot(file);
        let text = serde_json::to_string(&robot).expect("a text");
        assert_eq!(serde_json::from_str::<RobotDescription>(&text).expect("a robot"), robot, "{file}");
        // Descriptions of earlier versions have no fluid.
        let mut old: Value = serde_json::from_str(&text).expect("JSON");
        let fields = old.as_object_mut().expect("fields");
        assert!(fields.remove("medium").is_some() && fields.remove("fluid_shapes").is_some());
        let dry: RobotDescription = serde_json::from_value(old).expect("a robot");
        assert!(!dry.medium.acts() && dry.fluid_shapes.is_empty());
    }
}
