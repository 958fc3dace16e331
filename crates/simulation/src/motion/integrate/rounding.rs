//! The rounding error in the equation of the implicit rows.

use robot_dynamics_core::algorithms::mass_matrix::{CompositeBodies, Entries};
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::workspace::buffers::DenseBuffers;
use robot_dynamics_core::workspace::compiled_once::run;
use robot_dynamics_core::{Model, Workspace};

use super::workspace::StepWorkspace;

/// max |xᵢ|; NaN if an entry is NaN.
pub fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| if x.is_nan() || most.is_nan() { f64::NAN } else { most.max(x.abs()) })
}

/// The magnitude of the terms whose sum is v; the rounding error is ε times this, even if the terms cancel.
/// The factor 1 + |q| accounts for joints with many turns, where q and M(q) are known to ε|q|. The position
/// of a floating base does not affect M.
///
/// It is evaluated at the first iterate, because a divergent iterate would raise its own tolerance.
pub(crate) fn rounding_scale(model: &Model, workspace: &mut StepWorkspace, h: f64) -> f64 {
    let StepWorkspace { v, p_start, gravity, held, slope, q_start, factor, displacement, .. } = workspace;
    let mut sizes = [largest(v), 0.0, 0.0, 0.0, 0.0];
    let terms = [(&*p_start, 1.0), (gravity, 0.5 * h), (held, 0.5 * h), (slope, 0.5 * h)];
    for (size, (term, k)) in sizes[1..].iter_mut().zip(terms) {
        displacement.iter_mut().zip(term).for_each(|(d, x)| *d = k * x);
        factor.solve(displacement);
        *size = largest(displacement);
    }
    largest(&sizes) * winding(model, q_start)
}

/// The number of roundings in the sums of a term.
const ROUNDINGS: f64 = 64.0;

/// Whether the residual p₀ + ½hF − p at the middle is within the rounding of its terms |p₀| + ½h(|∂K/∂q| +
/// |g| + |τ|) + |M||v|. Call it after `variational::evaluate_middle`.
///
/// The velocity then solves the equation of a robot that differs from this one by rounding. For a chain of n
/// links M is so ill-conditioned, κ ~ n⁴, that v is determined to κε only, and no iteration can improve it.
pub fn is_rounding(model: &Model, workspace: &mut StepWorkspace, h: f64) -> bool {
    let StepWorkspace {
        dynamics, q, v, q_start, p_start, slope, gravity, held, residual, displacement, ..
    } = workspace;
    dynamics.allocate_matrices(model);
    let Workspace { tree, dense: DenseBuffers { matrix: mass, .. }, .. } = dynamics;
    run(tree, CompositeBodies { model, q, mass, entries: Entries::All });
    for (k, (terms, row)) in displacement.iter_mut().zip(mass.chunks_exact(model.nv)).enumerate() {
        let momentum: f64 = row.iter().zip(&*v).map(|(m, v)| (m * v).abs()).sum();
        let force = slope[k].abs() + gravity[k].abs() + held[k].abs();
        *terms = momentum + p_start[k].abs() + 0.5 * h.abs() * force;
    }
    // A rotation mixes the components of a joint's momentum.
    for (body, stretch) in model.bodies.iter().zip(coordinate_ranges(model)) {
        let k = stretch.v;
        match stretch.chart {
            Chart::Line => {}
            Chart::Rotation => share(&mut displacement[k..k + 3], 0.0),
            Chart::Placement => {
                share(&mut displacement[k..k + 3], 0.0);
                // The moment about the center of mass is c × the linear part away from that about the origin.
                let arm = if body.mass > 0.0 { largest(&body.first_moment) / body.mass } else { 0.0 };
                let moved = 2.0 * arm * displacement[k];
                share(&mut displacement[k + 3..k + 6], moved);
            }
        }
    }
    let allowed = ROUNDINGS * f64::EPSILON * winding(model, q_start);
    residual.iter().zip(&*displacement).all(|(r, terms)| r.abs() <= allowed * terms)
}

/// Sets every term to the largest one plus `more`.
fn share(terms: &mut [f64], more: f64) {
    let most = largest(terms) + more;
    terms.fill(most);
}

/// 1 + |q| of the joint with the largest coordinate.
fn winding(model: &Model, q: &[f64]) -> f64 {
    let lines = coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Line);
    lines.fold(1.0, |most: f64, line| most.max(1.0 + q[line.q].abs()))
}
