//! The response of the blocks to x: p = Π(p̄ − (c + s n)/R), and the derivatives of Π there.

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use super::ConeProblem;
use super::entries::{map, sum};
use super::projection::{
    MultiplierZone, ProjectionDerivative, is_between, place_of, project, project_to_border,
    project_with_derivative,
};
use super::set::Set;
use super::tolerances::TOLERANCES;
use crate::contact::law::ContactViolation;

impl ConeProblem {
    /// Computes p at x + t δ and the derivative of each row or cone. Returns whether each acts as in the last
    /// factor.
    ///
    /// With `first`, each block is assumed to continue to stick or slide as p̄ does. The true derivatives
    /// change within R times the impulse. From the assumed ones, the iteration reaches the solution in few
    /// steps.
    pub(super) fn respond(&mut self, t: f64, first: bool) -> bool {
        let mut acts_as_before = self.known.is_factored;
        run_here(Respond { problem: self, t, first, acts_as_before: &mut acts_as_before });
        acts_as_before
    }

    /// Computes p at x + t δ. Returns (A δ)ᵀ(p − counted).
    pub(super) fn evaluate(&mut self, t: f64) -> f64 {
        let mut pull = 0.0;
        run_here(Evaluate { problem: self, t, pull: &mut pull });
        pull
    }

    /// The violation of their laws by the contacts that begin at these rows. The velocities are c₀ + A x,
    /// without the rounding errors of the updated c.
    pub(in crate::contact) fn violation(
        &mut self,
        contacts: impl Iterator<Item = usize>,
    ) -> ContactViolation {
        let (mut speeds, x) = (core::mem::take(&mut self.change), core::mem::take(&mut self.x));
        self.find_products(&x, &mut speeds);
        self.x = x;
        speeds.iter_mut().zip(&self.start).for_each(|(speed, start)| *speed += start);
        let (mut worst, mut blocks) = (ContactViolation::default(), self.blocks.iter());
        for row in contacts {
            // Blocks and contacts have the same order.
            let Some(block) = blocks.by_ref().find(|block| block.rows.start == row) else { break };
            let friction = if let Set::Cone(slope) = block.set { slope } else { 0.0 };
            let (c, p) = (&speeds[block.rows.clone()], &self.multiplier[block.rows.clone()]);
            worst = worst.max(&ContactViolation::of(
                friction,
                block.softness / TOLERANCES.relative_softness,
                c,
                p,
            ));
        }
        self.change = speeds;
        worst
    }

    /// (A δ)ᵀ(p − counted) of the present p.
    #[inline(always)]
    pub(super) fn pull(&self) -> f64 {
        sum([&self.change, &self.p, &self.counted], |[change, p, counted]| change * (p - counted))
    }

    /// Computes p̄ − (c + t A δ)/R of all rows into `p`: the argument of the projection without s.
    #[inline(always)]
    fn aim(&mut self, t: f64) {
        let Self { p, multiplier, inverses, c, change, .. } = self;
        map(p, [multiplier, inverses, c, change], |_, [before, inverse, c, change]| {
            before - inverse * (c + t * change)
        });
    }

    /// Projects the single rows, and returns whether each acts as before. The rows of cones have no bounds.
    #[inline(always)]
    fn bound(&mut self, first: bool) -> bool {
        let Self { p, multiplier, lower, upper, inverses, weights, next, .. } = self;
        let goes_on = |before: f64, lower: f64, upper: f64| first && is_between(before, lower, upper);
        map(next, [p, lower, upper, inverses, multiplier], |_, [p, lower, upper, inverse, before]| {
            let is_within = p > lower && p < upper;
            if is_within || goes_on(before, lower, upper) { inverse } else { 0.0 }
        });
        map(p, [lower, upper, multiplier], |p, [lower, upper, before]| {
            let bounded = clamp(p, lower, upper);
            if goes_on(before, lower, upper) { p } else { bounded }
        });
        core::mem::swap(weights, next);
        sum([weights, next], |[now, before]| if now == before { 0.0 } else { 1.0 }) == 0.0
    }

    #[inline(always)]
    fn respond_here(&mut self, t: f64, first: bool) -> bool {
        self.aim(t);
        let mut acts_as_before = if first { self.bound(true) } else { self.bound(false) };
        let Self { blocks, cones, multiplier, inverses, c, p, derivatives: all, .. } = self;
        for (&index, now) in cones.iter().zip(all) {
            let (set, shift, rows) = (blocks[index].set, blocks[index].shift, blocks[index].rows.clone());
            let Set::Cone(slope) = set else { continue };
            let place =
                if first { place_of(set, &multiplier[rows.clone()]) } else { MultiplierZone::Elsewhere };
            let push = [shift, c[rows.start]].map(|speed| inverses[rows.start] * speed);
            let p = &mut p[rows];
            let derivatives = match <&mut [f64; 3]>::try_from(&mut *p) {
                Ok(p) => answer(slope, place, push, p),
                Err(_) => answer(slope, place, push, p),
            };
            let is_as_before = derivatives.place == now.place;
            acts_as_before &= is_as_before;
            // In the other zones the derivative is constant.
            if !is_as_before || derivatives.place == MultiplierZone::Border {
                *now = derivatives;
            }
        }
        acts_as_before
    }

    #[inline(always)]
    fn evaluate_here(&mut self, t: f64) -> f64 {
        self.aim(t);
        let Self { blocks, cones, lower, upper, inverses, p, .. } = self;
        map(p, [lower, upper], |p, [lower, upper]| clamp(p, lower, upper));
        for &index in &*cones {
            let (set, shift, rows) = (blocks[index].set, blocks[index].shift, blocks[index].rows.clone());
            let Set::Cone(slope) = set else { continue };
            let push = inverses[rows.start] * shift;
            let p = &mut p[rows];
            p[0] -= push;
            match <&mut [f64; 3]>::try_from(&mut *p) {
                Ok(p) => project(slope, p),
                Err(_) => project(slope, p),
            }
        }
        self.pull()
    }
}

/// Projects p onto a cone, after s and the normal velocity moved it by these amounts.
#[inline(always)]
fn answer(slope: f64, place: MultiplierZone, [shift, push]: [f64; 2], p: &mut [f64]) -> ProjectionDerivative {
    p[0] -= shift;
    match place {
        MultiplierZone::Interior => ProjectionDerivative::WITHIN,
        MultiplierZone::Border => {
            // Project as if the normal velocity were 0, and then move p along the derivative.
            p[0] += push;
            let derivatives = project_to_border(slope, p);
            p.iter_mut().enumerate().for_each(|(i, p)| *p -= derivatives.by_normal(i) * push);
            derivatives
        }
        MultiplierZone::Elsewhere => project_with_derivative(slope, p),
    }
}

/// Limits p to the bounds; NaN stays NaN.
#[inline(always)]
fn clamp(p: f64, lower: f64, upper: f64) -> f64 {
    let p = if lower > p { lower } else { p };
    if upper < p { upper } else { p }
}

/// [`ConeProblem::respond`].
struct Respond<'a> {
    problem: &'a mut ConeProblem,
    t: f64,
    first: bool,
    acts_as_before: &'a mut bool,
}

impl Call for Respond<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        *self.acts_as_before &= self.problem.respond_here(self.t, self.first);
    }
}

/// [`ConeProblem::evaluate`].
struct Evaluate<'a> {
    problem: &'a mut ConeProblem,
    t: f64,
    pull: &'a mut f64,
}

impl Call for Evaluate<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        *self.pull = self.problem.evaluate_here(self.t);
    }
}
