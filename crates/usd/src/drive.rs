//! Reads drives: springs and dampers to a target, with a largest force.

use crate::findings::Findings;
use crate::geometry::Geometry;
use crate::prim::Prim;

/// f = stiffness (target − q) + damping (target velocity − v), bounded, in N, m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) max_force: f64,
    /// \[rad or m\]
    pub(crate) target: f64,
    /// \[rad/s or m/s\]
    pub(crate) velocity: f64,
}

/// The drive of a joint's axis.
pub(crate) fn read_drive(
    geometry: &Geometry<'_>,
    prim: &Prim,
    instance: &str,
    is_angle: bool,
    findings: &mut Findings,
) -> Option<Drive> {
    if !prim.has(&format!("PhysicsDriveAPI:{instance}")) {
        return None;
    }
    let number = |name: &str| {
        let value = prim.number(&format!("drive:{instance}:physics:{name}"));
        value.filter(|value| !value.is_nan())
    };
    let force = geometry.force_unit(is_angle);
    let length = if is_angle { 1_f64.to_radians() } else { geometry.meters };
    let finite = |name: &str| number(name).filter(|value| value.is_finite()).unwrap_or_default();
    let drive = Drive {
        stiffness: finite("stiffness") * force / length,
        damping: finite("damping") * force / length,
        max_force: number("maxForce").map_or(f64::INFINITY, |limit| limit * force),
        target: finite("targetPosition") * length,
        velocity: finite("targetVelocity") * length,
    };
    let is_acceleration = prim.word(&format!("drive:{instance}:physics:type")) == Some("acceleration");
    if is_acceleration && (drive.stiffness != 0.0 || drive.damping != 0.0) {
        let message = format!(
            "the drive {instance:?} of type acceleration is not in the model; give it the type force, with the \
             stiffness and damping times the inertia"
        );
        findings.leave_out(&prim.path, message);
        return None;
    }
    Some(drive)
}
