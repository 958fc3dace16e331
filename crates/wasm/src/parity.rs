//! Numbers that the native and the WebAssembly build are compared on, computed by the same code in both.

use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
#[cfg(feature = "robots")]
use crate::Robot;
#[cfg(feature = "chapter")]
use crate::{Brick, ClosedForm, FallingArm, integrator_names};

/// A two-joint robot whose file is part of this function, so that both builds read the same text.
#[cfg(feature = "robots")]
const ROBOT: &str = include_str!("../../../robots/two_r.urdf");

/// Lines `name<TAB>exact|rounded<TAB>numbers`: `exact` must agree bit for bit (no sine, cosine in it), `rounded`
/// to 1e-12, since the two builds take their sines from different libraries.
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

/// The same for a robot from a file.
///
/// # Errors
/// As [`parity_values`].
#[cfg(feature = "robots")]
#[wasm_bindgen(js_name = robotParityValues)]
pub fn robot_parity_values() -> Result<Vec<String>, LabError> {
    let mut robot = Robot::load(ROBOT, false, false)?;
    robot.place(&[0.4, -0.7])?;
    robot.advance(500)?;
    let state = [robot.q(), robot.v(), robot.books()].concat();
    Ok(vec![entry("two_r.urdf fall, half a second of rk4", false, &state)])
}

fn entry(name: &str, exact: bool, numbers: &[f64]) -> String {
    let kind = if exact { "exact" } else { "rounded" };
    // Rust prints the shortest digits that read back as the same number.
    let digits: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("{name}\t{kind}\t{}", digits.join(" "))
}
