//! The Coriolis matrix and the Christoffel symbols, on every kind of robot.
//!
//! Tolerance: an entry of C is a sum of products of an inertia and a velocity over at most about 60 bodies.
//! 1e-12 of the product of M's and v's largest entries allows 4500 roundings.

use robot_dynamics::algorithms::{christoffel_symbols, coriolis_matrix, mass_matrix_rate, velocity_product};
use robot_dynamics::description::Base;
use robot_dynamics::model::Workspace;
use robot_dynamics::verification::lagrange;

use crate::common::{Family, Robot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-12;

fn transpose(matrix: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|at| matrix[at % n * n + at / n]).collect()
}

fn coriolis(robot: &Robot, v: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; v.len() * v.len()];
    coriolis_matrix(&robot.model, &mut Workspace::new(&robot.model), &robot.state.q, v, &mut c);
    c
}

/// The size of the terms of C.
fn scale(robot: &Robot) -> f64 {
    size(&robot.mass()) * size(&robot.state.v)
}

#[test]
fn product_with_v_matches_newton_euler() {
    for robot in families().iter().flat_map(Family::robots) {
        let v = &robot.state.v[..];
        let mut product = vec![0.0; v.len()];
        velocity_product(&robot.model, &mut Workspace::new(&robot.model), &robot.state.q, v, &mut product);
        let defect = max_difference(&times(&coriolis(&robot, v), v), &product);
        // One additional sum over the entries of v.
        robot.require("C v", defect, ROUNDING * scale(&robot) * size(v) * v.len() as f64);
    }
}

/// Ṁ by differentiating the composite-rigid-body algorithm shares no step with C.
#[test]
fn mass_rate_is_c_plus_its_transpose() {
    let mut largest = 0.0_f64;
    for robot in families().iter().flat_map(Family::robots) {
        let (model, v, n) = (&robot.model, &robot.state.v[..], robot.model.nv());
        let c = coriolis(&robot, v);
        let sum: Vec<f64> = c.iter().zip(transpose(&c, n)).map(|(c, t)| c + t).collect();
        let mut rate = vec![0.0; n * n];
        mass_matrix_rate(model, &mut Workspace::new(model), &robot.state.q, v, &mut rate);
        robot.require("Ṁ = C + Cᵀ", max_difference(&sum, &rate), ROUNDING * scale(&robot));
        largest = largest.max(size(&rate) / scale(&robot));
    }
    assert!(largest > 0.1, "Ṁ is nowhere larger than {largest}: the law was hardly tested");
}

/// C(q, v) is linear in v, and its values C(q, eₖ) are the slices of the table of symbols.
#[test]
fn symbols_are_slices_of_c() {
    for robot in families().iter().flat_map(|family| family.robots().take(20)) {
        let (v, n) = (&robot.state.v[..], robot.model.nv());
        let mut symbols = vec![0.0; n * n * n];
        let workspace = &mut Workspace::new(&robot.model);
        christoffel_symbols(&robot.model, workspace, &robot.state.q, &mut symbols);
        let inertia = size(&robot.mass());
        let defect = max_difference(&times(&symbols, v), &coriolis(&robot, v));
        robot.require("C = Γ v", defect, ROUNDING * scale(&robot) * n as f64);
        for k in 0..n.min(20) {
            let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == k))).collect();
            let slice: Vec<f64> = symbols.iter().skip(k).step_by(n).copied().collect();
            let defect = max_difference(&coriolis(&robot, &unit), &slice);
            robot.require("Γ_k = C(q, e_k)", defect, ROUNDING * inertia);
        }
    }
}

/// Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ) with exact derivatives of M from the Lagrange recipe, for q
/// without quaternions.
#[test]
fn symbols_match_christoffel_formula() {
    let mut tested = 0;
    for robot in families().iter().flat_map(|family| family.robots().take(40)) {
        let (model, n) = (&robot.model, robot.model.nv());
        if !model.is_vector_space() {
            continue;
        }
        tested += 1;
        let mut symbols = vec![0.0; n * n * n];
        christoffel_symbols(model, &mut Workspace::new(model), &robot.state.q, &mut symbols);
        let oracle = lagrange::christoffel(model, &robot.state.q);
        let inertia = size(&robot.mass());
        for (at, symbol) in symbols.iter().enumerate() {
            let defect = (symbol - oracle.get(at / (n * n), at / n % n, at % n)).abs();
            robot.require("Γ of M", defect, ROUNDING * inertia);
        }
    }
    assert!(tested > 50, "only {tested} robots have plain numbers in q");
}

/// A robot 10 km from the origin of the world has the same C bit for bit: no term depends on that origin.
#[test]
fn coriolis_matrix_is_exact_far_from_origin() {
    let mut tested = 0;
    for mut robot in families().iter().flat_map(Family::robots) {
        if robot.model.description().base != Base::Floating {
            continue;
        }
        tested += 1;
        let near = coriolis(&robot, &robot.state.v);
        robot.state.q[0] += 1e4;
        robot.state.q[1] -= 1e4;
        robot.require("C far away", max_difference(&near, &coriolis(&robot, &robot.state.v)), 0.0);
    }
    assert!(tested > 50, "only {tested} robots float");
}
