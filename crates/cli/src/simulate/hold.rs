//! The controller that holds a pose.

use nalgebra::DMatrix;
use robot_dynamics::algorithms::mass_matrix;
use robot_dynamics::description::JointKind;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{ControllerError, GravityCompensatedPd};

/// Options for the gains.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Gains {
    /// Natural frequency of each joint alone, which determines its gains, in Hz.
    #[arg(long, default_value_t = 1.5, value_name = "HZ", value_parser = crate::arguments::positive)]
    #[arg(allow_negative_numbers = true, conflicts_with_all = ["kp", "kd"])]
    frequency: f64,
    /// Damping ratio of each joint alone; 1 is critical.
    #[arg(long, default_value_t = 1.0, value_name = "RATIO", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, conflicts_with_all = ["kp", "kd"])]
    damping_ratio: f64,
    /// Stiffness of all joints, instead of --frequency [N·m/rad or N/m].
    #[arg(long, value_name = "GAIN", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, requires = "kd")]
    kp: Option<f64>,
    /// Damping gain of all joints [N·m·s/rad or N·s/m].
    #[arg(long, value_name = "GAIN", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, requires = "kp")]
    kd: Option<f64>,
}

/// A controller and a text on its gains.
pub(crate) struct Hold<'a> {
    pub controller: GravityCompensatedPd<&'a Model>,
    pub described: String,
    /// The coordinates whose effort limits are below the weight at the goal.
    pub overloaded: Vec<usize>,
}

impl<'a> Hold<'a> {
    /// τ = g(q\*) + Kp (q\* ⊖ q) − Kd v towards `goal`, in steps of `step`.
    ///
    /// Joint i alone is an oscillator of inertia M_ii: Kp = ω² M_ii, Kd = 2 ζ ω M_ii.
    pub(crate) fn new(
        model: &'a Model,
        goal: &[f64],
        gains: Gains,
        step: f64,
    ) -> Result<Self, ControllerError> {
        let nv = model.nv();
        let is_driven = driven(model);
        let (kp, kd, described) = if let (Some(kp), Some(kd)) = (gains.kp, gains.kd) {
            (vec![kp; nv], vec![kd; nv], format!("Kp = {kp}, Kd = {kd} for all joints"))
        } else {
            let mut mass = vec![0.0; nv * nv];
            mass_matrix(model, &mut Workspace::new(model), goal, &mut mass);
            let inertia: Vec<f64> = (0..nv).map(|i| mass[i * nv + i]).collect();
            let wanted = std::f64::consts::TAU * gains.frequency;
            let omega = wanted.min(fastest(&mass, nv, gains.damping_ratio, step));
            let note = if omega < wanted { ", limited by the step" } else { "" };
            let described = format!(
                "Kp = ω² Mᵢᵢ, Kd = 2ζω Mᵢᵢ with ω = 2π · {:.3} Hz{note}, ζ = {}",
                omega / std::f64::consts::TAU,
                gains.damping_ratio
            );
            let kp = inertia.iter().map(|m| omega * omega * m).collect();
            (kp, inertia.iter().map(|m| 2.0 * gains.damping_ratio * omega * m).collect(), described)
        };
        let controller = GravityCompensatedPd::new(model, goal, &kp, &kd)?;
        let overloaded = controller.overloaded_coordinates();
        let limits = model.coordinate_limits();
        let limits: Vec<f64> =
            limits.iter().zip(&is_driven).map(|(l, &driven)| if driven { l.effort } else { 0.0 }).collect();
        Ok(Self { controller: controller.with_limits(&limits), described, overloaded })
    }
}

/// Coordinates with motors: all except those of floating joints.
pub(crate) fn driven(model: &Model) -> Vec<bool> {
    let mut driven = vec![true; model.nv()];
    for free in model.joints().iter().filter(|joint| joint.kind == JointKind::Floating) {
        driven[free.v()].fill(false);
    }
    driven
}

/// The largest ω whose damping torque, constant over a step, cannot overshoot.
///
/// v₁ = (1 − h M⁻¹Kd) v₀ decays without overshoot if h λmax(M⁻¹Kd) < 1. The bound here is half of that, as
/// the coupled joints are faster than each alone: λmax(M⁻¹Kd) = 2ζω λmax(M⁻¹ diag M).
fn fastest(mass: &[f64], nv: usize, damping_ratio: f64, step: f64) -> f64 {
    // N is M scaled to a unit diagonal. M⁻¹ diag M has the eigenvalues of N⁻¹.
    let scaled =
        DMatrix::from_fn(nv, nv, |i, j| mass[i * nv + j] / (mass[i * nv + i] * mass[j * nv + j]).sqrt());
    let least = scaled.symmetric_eigenvalues().min().max(f64::EPSILON);
    // With little damping, ω itself must be slow relative to the step.
    0.5 * least / (2.0 * damping_ratio.max(0.5) * step)
}
