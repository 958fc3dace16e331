//! The gains of a robot that holds a pose.

use multibody::{ControllerError, GravityCompensatedPd, JointKind, Model, Workspace, mass_matrix};
use nalgebra::DMatrix;

/// Which gains are wanted.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Gains {
    /// Natural frequency of each joint on its own, from which its gains follow (Hz).
    #[arg(long, default_value_t = 1.5, value_name = "HZ", value_parser = crate::arguments::positive)]
    #[arg(allow_negative_numbers = true, conflicts_with_all = ["kp", "kd"])]
    frequency: f64,
    /// Damping ratio of each joint on its own: 1 is critical.
    #[arg(long, default_value_t = 1.0, value_name = "RATIO", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, conflicts_with_all = ["kp", "kd"])]
    damping_ratio: f64,
    /// The same stiffness for every joint, instead of one from the frequency [N·m/rad or N/m].
    #[arg(long, value_name = "GAIN", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, requires = "kd")]
    kp: Option<f64>,
    /// The same damping gain for every joint [N·m·s/rad or N·s/m].
    #[arg(long, value_name = "GAIN", value_parser = crate::arguments::not_negative)]
    #[arg(allow_negative_numbers = true, requires = "kp")]
    kd: Option<f64>,
}

/// A controller and its gains in words.
pub(crate) struct Hold<'a> {
    pub controller: GravityCompensatedPd<&'a Model>,
    pub described: String,
    /// The coordinates whose motors are too weak to carry the weight in the goal.
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
            (vec![kp; nv], vec![kd; nv], format!("Kp = {kp}, Kd = {kd} for every joint"))
        } else {
            let mut mass = vec![0.0; nv * nv];
            mass_matrix(model, &mut Workspace::new(model), goal, &mut mass);
            let inertia: Vec<f64> = (0..nv).map(|i| mass[i * nv + i]).collect();
            let wanted = std::f64::consts::TAU * gains.frequency;
            let omega = wanted.min(fastest(&mass, nv, gains.damping_ratio, step));
            let note = if omega < wanted { ", as much as the step allows" } else { "" };
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

/// Which coordinates have motors: all but those of floating joints.
pub(crate) fn driven(model: &Model) -> Vec<bool> {
    let mut driven = vec![true; model.nv()];
    for free in model.joints().iter().filter(|joint| joint.kind == JointKind::Floating) {
        driven[free.v_index..free.v_index + free.nv].fill(false);
    }
    driven
}

/// The largest ω whose damping torque, held over a step, cannot overshoot.
///
/// v₁ = (1 − h M⁻¹Kd) v₀ shrinks without overshoot if h λmax(M⁻¹Kd) < 1; half of that is taken here, as the
/// joints together are livelier than each alone: λmax(M⁻¹Kd) = 2ζω λmax(M⁻¹ diag M).
fn fastest(mass: &[f64], nv: usize, damping_ratio: f64, step: f64) -> f64 {
    // Scaled to a unit diagonal, M is N; M⁻¹ diag M has the eigenvalues of N⁻¹.
    let scaled =
        DMatrix::from_fn(nv, nv, |i, j| mass[i * nv + j] / (mass[i * nv + i] * mass[j * nv + j]).sqrt());
    let least = scaled.symmetric_eigenvalues().min().max(f64::EPSILON);
    // ω itself must be slow against the step, too, with little damping.
    0.5 * least / (2.0 * damping_ratio.max(0.5) * step)
}
