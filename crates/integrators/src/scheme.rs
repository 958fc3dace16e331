//! The stages of integrators, as data.

/// The composition of a step of length h.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "Method")]
pub enum StepScheme {
    /// Explicit stages, in their order.
    Explicit(&'static [Stage]),
    /// Variational midpoint steps with these fractions of h in sequence, palindromic.
    Variational(&'static [f64]),
}

/// A stage of a partitioned explicit Runge–Kutta method. **(HLW §II.2)**
///
/// With q = q₀ ⊕ Θ, stage i is at Θᵢ = h Σⱼ âᵢⱼ Θ̇ⱼ with the velocity vᵢ = v₀ + h Σⱼ aᵢⱼ v̇ⱼ. The step ends
/// at Θ = h Σ b̂ᵢ Θ̇ᵢ and v₁ = v₀ + h Σ bᵢ v̇ᵢ. Without quaternions Θ̇ = v. The rows end with their last
/// nonzero entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// âᵢⱼ, j < i.
    pub q_row: &'static [f64],
    /// aᵢⱼ, j < i.
    pub v_row: &'static [f64],
    /// b̂ᵢ.
    pub q_weight: f64,
    /// bᵢ.
    pub v_weight: f64,
}

impl Stage {
    /// The largest number of stages of any method.
    pub const MOST: usize = 8;

    /// Whether anything depends on Θ̇ of stage `i`.
    pub fn needs_rate(stages: &[Self], i: usize) -> bool {
        stages[i].q_weight != 0.0 || stages.iter().any(|later| later.q_row.get(i).is_some_and(|&a| a != 0.0))
    }

    /// Whether anything depends on the acceleration of stage `i`.
    pub fn needs_acceleration(stages: &[Self], i: usize) -> bool {
        stages[i].v_weight != 0.0 || stages.iter().any(|later| later.v_row.get(i).is_some_and(|&a| a != 0.0))
    }
}
