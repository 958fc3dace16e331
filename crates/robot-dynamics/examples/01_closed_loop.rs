//! How does a mechanism with a closed loop move, and what does its pin carry?
//!
//! The mechanism is a four-bar linkage. Crank and coupler are one branch of the tree, and the rocker is
//! another. A pin joins coupler and rocker; it is declared in JSON, as in a file beside a robot file. The
//! linkage starts with the crank turning. The plot shows the gap of the pin and the energy error if the drift
//! is left alone, pulled back, or projected out.
//!
//! `cargo run --release --example 01_closed_loop -p robot-dynamics`
#![allow(dead_code)] // the tests use the parts and leave out `main`

pub(crate) mod plot;

use std::error::Error;
use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use plot::{Axis, Figure, Line, Panel};
use robot_dynamics::constraints::{
    Baumgarte, ConstraintDrift, ConstraintOptions, ConstraintSet, DriftCorrection, LoopClosure,
    constrained_forward_dynamics, constraint_drift, project_position, project_velocity,
};
use robot_dynamics::description::{
    FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Effect, Method, RunOptions, SimulationBuilder};

/// The pin. The mechanism is planar, so the rows x and y are sufficient.
pub(crate) const PIN: &str =
    r#"[{"name": "pin", "frame_a": "coupler_end", "frame_b": "rocker_end", "rows": ["x", "y"]}]"#;

/// Lengths of crank, coupler and rocker \[m\]. They are uniform rods.
pub(crate) const LENGTHS: [f64; 3] = [0.3, 0.8, 0.7];
/// Masses of crank, coupler and rocker \[kg\].
pub(crate) const MASSES: [f64; 3] = [1.0, 2.0, 1.5];
/// The distance between the pivots in the ground \[m\].
pub(crate) const GROUND: f64 = 0.9;

/// The tree of the linkage in the x-y plane, gravity along −y.
pub(crate) fn linkage() -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("four_bar");
    robot.gravity = [0.0, -9.81, 0.0];
    robot.links.push(LinkDescription::new("ground", None));
    let places = [("ground", 0.0), ("crank", LENGTHS[0]), ("ground", GROUND)];
    for (i, name) in ["crank", "coupler", "rocker"].into_iter().enumerate() {
        let (length, mass) = (LENGTHS[i], MASSES[i]);
        let across = mass * length * length / 12.0;
        let rod = MassProperties::new(
            mass,
            Vector3::new(length / 2.0, 0.0, 0.0),
            Matrix3::from_diagonal(&Vector3::new(0.0, across, across)),
        )?;
        robot.links.push(LinkDescription::new(name, rod));
        let about_z = JointKind::Continuous { axis: [0.0, 0.0, 1.0] };
        let (parent, x) = places[i];
        let at = Pose::from_translation([x, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("{name}_joint"), about_z, parent, name, at));
        robot.frames.push(FrameDescription::new(
            format!("{name}_end"),
            name,
            Pose::from_translation([length, 0.0, 0.0]),
        ));
    }
    Ok(Model::new(robot)?)
}

/// A state on the constraint: the crank up and turning at 6 rad/s.
pub(crate) fn start(model: &Model, set: &ConstraintSet) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
    let workspace = &mut Workspace::new(model);
    let options = ConstraintOptions::default();
    let mut q = vec![1.2, -0.7, 1.9];
    project_position(model, workspace, set, &options, 1e-13, &mut q)?;
    // The crank's speed is chosen and the others follow: a velocity is projected and then scaled.
    let mut v = vec![1.0, 0.0, 0.0];
    project_velocity(model, workspace, set, &options, &q, &mut v)?;
    let scale = 6.0 / v[0];
    for v in &mut v {
        *v *= scale;
    }
    Ok((q, v))
}

/// The numbers that the example prints.
pub(crate) struct Numbers {
    /// λ of the pin at the start, along the coupler's axes \[N\].
    pub(crate) pin_force: [f64; 2],
    /// max |E − E₀|/|E₀| over ten seconds of 1 ms.
    pub(crate) energy_drift: f64,
    /// The largest gap and gap rate of the pin.
    pub(crate) gap: ConstraintDrift,
    /// Turns of the crank.
    pub(crate) turns: f64,
}

/// Ten seconds of the linkage.
pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let (q, v) = start(&model, &set)?;
    let options = ConstraintOptions::default();
    let workspace = &mut Workspace::new(&model);
    let motion = constrained_forward_dynamics(&model, workspace, &set, &options, &q, &v, &[0.0; 3])?;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(options.integrator))
        .constraints(set.clone())
        .constraint_options(options, DriftCorrection::Position { tolerance: 1e-12 })
        .without(Effect::Dissipation)
        .build()?;
    let run = simulation.run_from(&q, &v, 10.0, RunOptions::new().sample_ends())?;
    let record = simulation.constraint_record().ok_or("no constraint")?;
    Ok(Numbers {
        pin_force: [motion.multipliers[0], motion.multipliers[1]],
        energy_drift: run.energy_account.drift(),
        gap: record.drift,
        turns: (run.q[0] - q[0]) / std::f64::consts::TAU,
    })
}

/// The pin's gap and the energy error over the ten seconds, for three ways to treat the drift.
pub(crate) fn figure() -> Result<Figure, Box<dyn Error>> {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let (q, v) = start(&model, &set)?;
    let pulled = ConstraintOptions { stabilization: Some(Baumgarte { rate: 20.0 }), ..Default::default() };
    let (left, projected) = (ConstraintOptions::default(), DriftCorrection::Position { tolerance: 1e-12 });
    let (mut gaps, mut energies) = (Vec::new(), Vec::new());
    for (name, options, correction) in [
        ("left alone", left, DriftCorrection::None),
        ("Baumgarte, 20/s", pulled, DriftCorrection::None),
        ("projected", left, projected),
    ] {
        let (mut gap, mut energy) = (Vec::new(), Vec::new());
        let workspace = &mut Workspace::new(&model);
        let mut simulation = SimulationBuilder::new(&model)
            .method(Method::Fixed(options.integrator))
            .constraints(set.clone())
            .without(Effect::Dissipation)
            .constraint_options(options, correction)
            .build()?;
        simulation.run_from(
            &q,
            &v,
            10.0,
            RunOptions::new().sample_ends().observer(&mut |info| {
                let drift = constraint_drift(&model, workspace, &set, info.q, info.v);
                gap.push((info.time, drift.position));
                energy.push((
                    info.time,
                    info.energy_account.imbalance().abs() / info.energy_account.start().abs(),
                ));
                ControlFlow::Continue(())
            }),
        )?;
        gaps.push(Line::new(name, gap));
        energies.push(Line::new(name, energy));
    }
    let panel =
        |name: &str, lines| Panel { name: name.into(), axis: Axis::Logarithmic, lines, limits: vec![] };
    Ok(Figure {
        title: "A four-bar linkage for ten seconds in steps of 1 ms".into(),
        across: "t [s]".into(),
        panels: vec![panel("Gap of the pin [m]", gaps), panel("Energy error |E − E₀| / |E₀|", energies)],
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let Numbers { pin_force: [x, y], energy_drift, gap, turns } = numbers()?;
    println!("pin force at the start    {x:.6} N along the coupler, {y:.6} N across");
    println!("crank                     {turns:.6} turns in 10 s");
    println!("energy drift              {energy_drift:.1e}");
    println!("largest gap of the pin    {:.1e} m, {:.1e} m/s", gap.position, gap.velocity);
    figure()?.save("01_closed_loop")
}
