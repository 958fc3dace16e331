//! The limits of each coordinate, including those of its mimic joints.

use robot_dynamics_core::Model;

/// A coordinate without quaternions, its indices, and its limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// The index in q.
    pub q: usize,
    /// The index in v.
    pub v: usize,
    pub lower: f64,
    pub upper: f64,
}

/// The bounds of all coordinates with limits.
#[derive(Clone, Debug)]
pub(crate) struct Bounds(pub Vec<Bound>);

impl Bounds {
    pub(crate) fn new(model: &Model) -> Self {
        let mut bounds = Vec::new();
        // The limits of a joint with a quaternion do not bound an entry of q.
        for joint in model.joints().iter().filter(|joint| joint.nv > 0 && joint.nq == joint.nv) {
            let limits = joint.limits;
            // A file may have them in the wrong order.
            let (mut lower, mut upper) = (limits.lower.min(limits.upper), limits.lower.max(limits.upper));
            for (low, high) in model.joints().iter().filter_map(|other| follower_limits(model, other, joint))
            {
                // If both cannot hold, those of the leader apply.
                if lower.max(low) <= upper.min(high) {
                    (lower, upper) = (lower.max(low), upper.min(high));
                }
            }
            if lower.is_finite() || upper.is_finite() {
                bounds.extend((0..joint.nv).map(|k| Bound {
                    q: joint.q_index + k,
                    v: joint.v_index + k,
                    lower,
                    upper,
                }));
            }
        }
        Self(bounds)
    }

    /// Writes the distances of all coordinates from their limits, infinite without one.
    pub(crate) fn write_room(&self, q: &[f64], lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(f64::NEG_INFINITY);
        upper.fill(f64::INFINITY);
        for bound in &self.0 {
            (lower[bound.v], upper[bound.v]) = (bound.lower - q[bound.q], bound.upper - q[bound.q]);
        }
    }

    /// Moves each coordinate beyond a limit to that limit.
    pub(crate) fn clamp(&self, q: &mut [f64]) {
        for bound in &self.0 {
            q[bound.q] = q[bound.q].max(bound.lower).min(bound.upper);
        }
    }
}

/// The limits of a mimic joint as limits of this leader; `None` if it follows another joint, or if its leader
/// does not move.
fn follower_limits(
    model: &Model,
    mimic_joint: &robot_dynamics_core::Joint,
    leader: &robot_dynamics_core::Joint,
) -> Option<(f64, f64)> {
    // mimic joint = ratio · leader + offset, along the chain of leaders.
    let (mut ratio, mut offset) = (1.0, 0.0);
    let mut joint = mimic_joint;
    while let Some(mimic) = &joint.mimic {
        offset += ratio * mimic.offset;
        ratio *= mimic.ratio;
        joint = model.joint(&mimic.joint)?;
    }
    if std::ptr::eq(joint, mimic_joint) || joint.name != leader.name || ratio == 0.0 {
        return None;
    }
    let at = |limit: f64| (limit - offset) / ratio;
    let (one, other) = (at(mimic_joint.limits.lower), at(mimic_joint.limits.upper));
    Some((one.min(other), one.max(other)))
}
