//! Numbers that the native and the WebAssembly build are compared on, computed by the same code in both.

#[cfg(feature = "robots")]
use multibody::{
    Controller, EnergyLedger, FramePose, GravityCompensatedPd, Model, StepForces, StepWorkspace, Workspace,
    check_rank, frame_poses, gravity, inverse_mass_matrix, neutral, normalize_quaternions, step,
};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
#[cfg(feature = "robots")]
use crate::Robot;
#[cfg(feature = "chapter")]
use crate::{Brick, ClosedForm, FallingArm, integrator_names};

/// Lines `name<TAB>exact|rounded<TAB>numbers`: `exact` must agree bit for bit (no sine, cosine in it), `rounded`
/// to 1e-12 of a line's largest number, since the builds take their sines from different libraries, and their
/// registers do not all have a multiply-add that rounds once.
///
/// # Errors
/// None, unless a model fails.
#[cfg(feature = "chapter")]
#[wasm_bindgen(js_name = parityValues)]
pub fn parity_values() -> Result<Vec<String>, LabError> {
    let mut lines = Vec::new();
    let mut line = |name: &str, exact: bool, numbers: &[f64]| lines.push(entry(name, exact, numbers));

    // Arithmetic and square roots only: the same bits everywhere.
    for method in ["cayley", "rk4"] {
        let mut brick = Brick::new(0.3, 0.2, 0.1, 1000.0)?;
        brick.set_method(method, 1e-3)?;
        brick.spin(&[0.02, 5.0, 0.01])?;
        brick.advance(10_000)?;
        let state = [brick.quaternion_xyzw(), brick.omega(), brick.momentum_in_world()].concat();
        line(&format!("brick, 10000 steps of {method}"), true, &state);
    }
    let polar = ClosedForm::polar_mass(2.0, 0.0)?;
    let (mut q, mut qd) = (vec![1.5, 0.2], vec![0.3, -0.4]);
    for _ in 0..1000 {
        let next = polar.step("explicit-euler", &q, &qd, &[0.0, 0.0], 1e-3)?;
        (q, qd) = (next[..2].to_vec(), next[2..].to_vec());
    }
    line(
        "polar mass on a table, mass and symbols",
        true,
        &[polar.mass(&q)?, polar.christoffel(&q)?].concat(),
    );

    // With sines and cosines. A second of falling magnifies a last bit by less than 1e3.
    let arm = ClosedForm::reach_2r(1.0, 2.0, 1.0, 1.0, 9.81)?;
    let three = ClosedForm::reach_3r();
    let (q2, q3) = ([0.3, -0.8], [0.4, 1.1, -2.0]);
    line("2R mass", false, &arm.mass(&q2)?);
    line("2R symbols", false, &arm.christoffel(&q2)?);
    line("2R forward", false, &arm.forward(&q2, &[1.0, 2.0], &[0.5, 0.1])?);
    line("2R ellipse", false, &arm.inertia_ellipse(&q2)?);
    line("3R mass", false, &three.mass(&q3)?);
    line("3R inverse", false, &three.inverse(&q3, &[1.0, -0.3, 0.7], &[0.2, 0.1, -0.5])?);
    for name in integrator_names() {
        let mut lab = FallingArm::worked_example()?;
        lab.set_method(&name, 1e-3)?;
        lab.advance(500)?;
        line(&format!("2R fall, half a second of {name}"), false, &[lab.q(), lab.qd()].concat());
    }
    let example = dynamics::WorkedExample::compute()?;
    line(
        "worked example, energies",
        false,
        &[example.kinetic_energy, example.potential_energy, example.energy],
    );
    Ok(lines)
}

/// The same for a robot from a file: every algorithm that its experiment calls, and every integrator.
///
/// # Errors
/// If the file is no robot, or a step fails.
#[cfg(feature = "robots")]
#[wasm_bindgen(js_name = robotParityValues)]
pub fn robot_parity_values(text: &str, floating_base: bool) -> Result<Vec<String>, LabError> {
    let options = urdf::Options { floating_base, ..urdf::Options::default() };
    let model = Model::new(urdf::parse(text, &options)?.description)?;
    let (mut workspace, nv) = (Workspace::new(&model), model.nv());
    let mut lines = Vec::new();
    let mut line =
        |what: &str, numbers: &[f64]| lines.push(entry(&format!("{}: {what}", model.name()), false, numbers));

    // No joint is at zero, and none moves as its neighbours do.
    let mut start = neutral(&model);
    start.iter_mut().enumerate().for_each(|(k, x)| *x += 0.1 + 0.07 * k as f64);
    normalize_quaternions(&model, &mut start);
    let speeds: Vec<f64> = (0..nv).map(|k| 0.5 - 0.3 * (k % 4) as f64).collect();
    check_rank(&model, &mut workspace, &start)?;

    let still = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
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
    let ledger = EnergyLedger::open(&model, &mut workspace, &start, &speeds);
    line("energies", &[ledger.kinetic(), ledger.potential()]);
    let gains = vec![20.0; nv];
    let target = neutral(&model);
    GravityCompensatedPd::new(&model, &target, &gains, &gains)?.torque(0.0, &start, &speeds, &mut torques)?;
    line("torques that hold", &torques);
    let mut stepping = StepWorkspace::new(&model);
    let forces = StepForces { tau: &vec![0.0; nv], dissipation: true };
    for method in dynamics::Integrator::ALL {
        let (mut q, mut v) = (start.clone(), speeds.clone());
        for _ in 0..20 {
            step(&model, method, &mut stepping, &forces, 1e-4, &mut q, &mut v)?;
        }
        line(&format!("2 ms of {}", method.name()), &[q, v].concat());
    }

    let mut robot = Robot::load(text, floating_base, false)?;
    robot.place(&start)?;
    robot.set_method("rk4", 1e-4, true)?;
    robot.advance(500)?;
    line("50 ms of falling", &[robot.q(), robot.v(), robot.books()].concat());
    Ok(lines)
}

fn entry(name: &str, exact: bool, numbers: &[f64]) -> String {
    let kind = if exact { "exact" } else { "rounded" };
    // Rust prints the shortest digits that read back as the same number.
    let digits: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("{name}\t{kind}\t{}", digits.join(" "))
}
