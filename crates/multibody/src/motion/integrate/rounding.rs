//! What rounding leaves of the implicit rows' equation.

use super::StepWorkspace;
use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::joint::Chart;
use crate::scratch::compiled_once::run;
use crate::scratch::workspace::{Dense, Workspace};
use crate::space::configuration::stretches;

/// max |xᵢ|; NaN where there is one.
pub(crate) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| if x.is_nan() || most.is_nan() { f64::NAN } else { most.max(x.abs()) })
}

/// The size of the terms whose sum is v: rounding leaves ε of it, even where the terms cancel. The factor
/// 1 + |q| is for joints that have turned many times: q is known to ε|q| and M(q) with it. Where a floating
/// base is does not matter to M.
///
/// Taken at the first iterate: one that ran away must not set its own measure.
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

/// Roundings that the sums of a term may gather.
const ROUNDINGS: f64 = 64.0;

/// Whether the residual p₀ + ½hF − p at the middle is no more than the rounding of its terms
/// |p₀| + ½h(|∂K/∂q| + |g| + |τ|) + |M||v|, after
/// [`evaluate_middle`](super::variational::evaluate_middle).
///
/// Then the velocity solves the equation of a robot that differs from this one by rounding. Along a chain of n links M
/// is so ill-conditioned, κ ~ n⁴, that v itself is known to κε only, and no iteration finds more.
pub(crate) fn is_rounding(model: &Model, workspace: &mut StepWorkspace, h: f64) -> bool {
    let StepWorkspace {
        dynamics, q, v, q_start, p_start, slope, gravity, held, residual, displacement, ..
    } = workspace;
    dynamics.make_room_for_matrices(model);
    let Workspace { tree, dense: Dense { matrix: mass, .. }, .. } = dynamics;
    run(tree, CompositeBodies { model, q, mass, entries: Entries::All });
    for (k, (terms, row)) in displacement.iter_mut().zip(mass.chunks_exact(model.nv)).enumerate() {
        let momentum: f64 = row.iter().zip(&*v).map(|(m, v)| (m * v).abs()).sum();
        let force = slope[k].abs() + gravity[k].abs() + held[k].abs();
        *terms = momentum + p_start[k].abs() + 0.5 * h.abs() * force;
    }
    // A turn mixes the components of a joint's momentum.
    for (body, stretch) in model.bodies.iter().zip(stretches(model)) {
        let k = stretch.v;
        match stretch.chart {
            Chart::Line => {}
            Chart::Rotation => share(&mut displacement[k..k + 3], 0.0),
            Chart::Placement => {
                share(&mut displacement[k..k + 3], 0.0);
                // The moment about the centre of mass, c × the linear part away from the one about the origin.
                let arm = if body.mass > 0.0 { largest(&body.first_moment) / body.mass } else { 0.0 };
                let moved = 2.0 * arm * displacement[k];
                share(&mut displacement[k + 3..k + 6], moved);
            }
        }
    }
    let allowed = ROUNDINGS * f64::EPSILON * winding(model, q_start);
    residual.iter().zip(&*displacement).all(|(r, terms)| r.abs() <= allowed * terms)
}

/// Each becomes the largest, and some more.
fn share(terms: &mut [f64], more: f64) {
    let most = largest(terms) + more;
    terms.fill(most);
}

/// 1 + |q| of the joint that has turned or slid most.
fn winding(model: &Model, q: &[f64]) -> f64 {
    let lines = stretches(model).filter(|stretch| stretch.chart == Chart::Line);
    lines.fold(1.0, |most: f64, line| most.max(1.0 + q[line.q].abs()))
}
