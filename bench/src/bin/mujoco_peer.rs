//! The library's passive forces and motions in MuJoCo's coordinates, for `bench/robots/menagerie.py`.
//!
//! Reads one JSON object per line: the `file`, a state `qpos`, `qvel`, and for a motion `ctrl`, `step` \[s\]
//! and `steps`. Prints one object. The forces `passive` have springs, damping, tendons, a fluid, and gravity
//! compensation that no actuator provides; `gravcomp` has all gravity compensation. `qpos` and `qvel` are the
//! motion's end by RK4. Friction, equalities and the armature of tendons are left out, as they are part of
//! neither.

use std::collections::HashMap;
use std::error::Error;
use std::io::{BufRead, Write};

use robot_dynamics::algorithms::{dissipation, gravity};
use robot_dynamics::conventions::{
    configuration_from_mujoco, configuration_to_mujoco, force_to_mujoco, velocity_from_mujoco,
    velocity_to_mujoco,
};
use robot_dynamics::description::{Medium, RobotDescription};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Actuation, Effect, Integrator, Method, SimulationBuilder};
use serde_json::{Value, json};

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let mut robots = HashMap::new();
    for line in std::io::stdin().lock().lines() {
        let asked: Value = serde_json::from_str(&line?)?;
        let file = asked["file"].as_str().ok_or("no file")?.to_owned();
        if !robots.contains_key(&file) {
            robots.insert(file.clone(), read(&file)?);
        }
        let answer = answer(&robots[&file], &asked)?;
        writeln!(std::io::stdout(), "{answer}")?;
    }
    Ok(())
}

fn read(file: &str) -> Result<RobotDescription, Failure> {
    let mut robot =
        robot_dynamics::mjcf::load(file, &robot_dynamics::mjcf::LoadOptions::default())?.description;
    robot.equalities.clear();
    for joint in &mut robot.joints {
        joint.passive.friction = 0.0;
    }
    for tendon in &mut robot.tendons {
        tendon.passive.friction = 0.0;
        tendon.passive.armature = 0.0;
    }
    for tendon in &mut robot.spatial_tendons {
        tendon.passive.friction = 0.0;
    }
    robot.sensors.clear();
    Ok(robot)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

fn answer(robot: &RobotDescription, asked: &Value) -> Result<Value, Failure> {
    let model = Model::new(robot.clone())?;
    let actuation = Actuation::new(&model)?;
    let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
    configuration_from_mujoco(&model, &numbers(&asked["qpos"]), &mut q);
    velocity_from_mujoco(&model, &q, &numbers(&asked["qvel"]), &mut v);
    if let Some(step) = asked["step"].as_f64() {
        let controls = numbers(&asked["ctrl"]);
        let steps = asked["steps"].as_u64().ok_or("no steps")?;
        let mut simulation = SimulationBuilder::new(&model)
            .dt(step)
            .method(Method::Fixed(Integrator::RungeKutta4))
            .without(Effect::Contacts)
            .build()?;
        simulation.reset(&q, &v)?;
        simulation.set_controls(&controls);
        for _ in 0..steps {
            simulation.step()?;
        }
        configuration_to_mujoco(&model, simulation.q(), &mut q);
        velocity_to_mujoco(&model, simulation.q(), simulation.v(), &mut v);
        return Ok(json!({ "qpos": q, "qvel": v }));
    }
    let turned = |tau: &[f64]| {
        let mut qfrc = vec![0.0; model.nv()];
        force_to_mujoco(&model, &q, tau, &mut qfrc);
        qfrc
    };
    let (mut passive, mut joints) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    actuation.passive_forces(&model, &mut actuation.workspace(), &q, &v, &mut passive);
    dissipation(&model, &v, &mut joints);
    passive.iter_mut().zip(&joints).for_each(|(passive, joint)| *passive -= joint);
    // Without gravity, g contains the springs only.
    let mut weightless = robot.clone();
    weightless.gravity = [0.0; 3];
    let weightless = Model::new(weightless)?;
    gravity(&weightless, &mut Workspace::new(&weightless), &q, &mut joints);
    passive.iter_mut().zip(&joints).for_each(|(passive, joint)| *passive -= joint);
    // All gravity compensation, by actuators or not.
    let mut carried = robot.clone();
    carried.tendons.clear();
    carried.spatial_tendons.clear();
    carried.actuators.clear();
    carried.medium = Medium::default();
    for joint in &mut carried.joints {
        joint.actuator_compensates_gravity = false;
    }
    let carried = Model::new(carried)?;
    let carrying = Actuation::new(&carried)?;
    let mut weight = vec![0.0; model.nv()];
    carrying.passive_forces(&carried, &mut carrying.workspace(), &q, &v, &mut weight);
    Ok(json!({ "passive": turned(&passive), "gravcomp": turned(&weight) }))
}
