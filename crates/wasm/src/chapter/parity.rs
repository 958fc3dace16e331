//! The chapter's values that the native and the WebAssembly build must agree on.

use wasm_bindgen::prelude::wasm_bindgen;

use super::{Brick, ClosedForm, FallingArm, integrator_names};
use crate::LabError;
use crate::parity::entry;

/// Lines `name<TAB>exact|rounded<TAB>numbers`. Lines marked `exact` contain no sine or cosine and must agree
/// bit for bit. Lines marked `rounded` must agree to 1e-12 of their largest number, as builds differ in their
/// sines and in fused multiply-add.
///
/// # Errors
/// Fails only if a model fails.
#[wasm_bindgen(js_name = parityValues)]
pub fn parity_values() -> Result<Vec<String>, LabError> {
    let mut lines = Vec::new();
    let mut line = |name: &str, exact: bool, numbers: &[f64]| lines.push(entry(name, exact, numbers));

    // Arithmetic and square roots only, with the same bits everywhere.
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

    // With sines and cosines. A second of falling magnifies a difference in the last bit by less than 1e3.
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
