//! The robots' values that the native and both WebAssembly builds must agree on.

use robot_dynamics::algorithms::{check_rank, frame_poses, gravity, inverse_mass_matrix};
use robot_dynamics::model::{Model, Workspace, neutral, normalize_quaternions};
use robot_dynamics::simulation::{Controller, Effect, GravityCompensatedPd, Method, energy_account};
use robot_dynamics::{LoadOptions, load_description_from_text, simulation};
use wasm_bindgen::prelude::wasm_bindgen;

use super::Robot;
use crate::LabError;
use crate::parity::entry;
use robot_dynamics::description::Pose;

/// Lines like the chapter's (`parityValues`), for a robot from a file: every algorithm of its experiment, and
/// every integrator.
///
/// # Errors
/// Fails if the file is invalid or a step fails.
#[wasm_bindgen(js_name = robotParityValues)]
pub fn robot_parity_values(text: &str, floating_base: bool) -> Result<Vec<String>, LabError> {
    let options = LoadOptions { floating_base, ..LoadOptions::default() };
    let model = Model::new(load_description_from_text(text, &options)?.description)?;
    let (mut workspace, nv) = (Workspace::new(&model), model.nv());
    let mut lines = Vec::new();
    let mut line =
        |what: &str, numbers: &[f64]| lines.push(entry(&format!("{}: {what}", model.name()), false, numbers));

    // No joint is at zero, and no two neighbours move alike.
    let mut start = neutral(&model);
    start.iter_mut().enumerate().for_each(|(k, x)| *x += 0.1 + 0.07 * k as f64);
    normalize_quaternions(&model, &mut start);
    let speeds: Vec<f64> = (0..nv).map(|k| 0.5 - 0.3 * (k % 4) as f64).collect();
    check_rank(&model, &mut workspace, &start)?;

    let still = Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
    let mut poses = vec![still; model.frames().len()];
    frame_poses(&model, &mut workspace, &start, &mut poses);
    let poses: Vec<f64> = poses
        .iter()
        .flat_map(|pose| pose.rotation.iter().flatten().chain(&pose.translation).copied())
        .collect();
    line("poses", &poses);
    let mut torques = vec![0.0; nv];
    gravity(&model, &mut workspace, &start, &mut torques);
    line("gravity", &torques);
    let mut inverse = vec![0.0; nv * nv];
    inverse_mass_matrix(&model, &mut workspace, &start, &mut inverse);
    line("inverse of M", &inverse);
    let energy_account = energy_account(&model, &mut workspace, &start, &speeds);
    line("energies", &[energy_account.kinetic(), energy_account.potential()]);
    let gains = vec![20.0; nv];
    let target = neutral(&model);
    GravityCompensatedPd::new(&model, &target, &gains, &gains)?.torque(0.0, &start, &speeds, &mut torques)?;
    line("torques that hold", &torques);
    // The lab's modules have no adaptive steps, unlike a build with all features.
    for name in Method::names().filter(|name| *name != "adaptive") {
        // Links overlap in this pose, and contact magnifies rounding.
        let builder = simulation(&model).without(Effect::Contacts);
        let mut stepped = builder.method(name.parse()?).dt(1e-4).build()?;
        stepped.reset(&start, &speeds)?;
        for _ in 0..20 {
            stepped.step()?;
        }
        line(&format!("2 ms of {name}"), &[stepped.q(), stepped.v()].concat());
    }

    let mut robot = Robot::load(text, floating_base, false)?;
    robot.choose("rk4", 1e-4, Vec::new())?;
    robot.place(&start)?;
    robot.advance(500)?;
    let b = robot.energy_account();
    let account = vec![b.kinetic, b.potential, b.energy, b.start, b.work, b.dissipated, b.unaccounted];
    line("50 ms of falling", &[robot.q(), robot.v(), account].concat());
    Ok(lines)
}
