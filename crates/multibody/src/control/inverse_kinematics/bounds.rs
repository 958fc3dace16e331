//! The limits of each coordinate, those of its followers among them.

use crate::Model;

/// A coordinate of plain numbers, where it stands, and its limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// Entry in q.
    pub q: usize,
    /// Entry in v.
    pub v: usize,
    pub lower: f64,
    pub upper: f64,
}

/// The bounds of all coordinates that have any.
pub(crate) struct Bounds(pub Vec<Bound>);

impl Bounds {
    pub(crate) fn new(model: &Model) -> Self {
        let mut bounds = Vec::new();
        // The limits of a joint with a quaternion are of no entry of q.
        for joint in model.joints().iter().filter(|joint| joint.nv > 0 && joint.nq == joint.nv) {
            let limits = joint.limits;
            // A file may have them the wrong way round.
            let (mut lower, mut upper) = (limits.lower.min(limits.upper), limits.lower.max(limits.upper));
            for (low, high) in model.joints().iter().filter_map(|other| follower_limits(model, other, joint))
            {
                // Where both cannot be kept, those of the leader are.
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

    /// Moves each coordinate to the limit that it is beyond.
    pub(super) fn clamp(&self, q: &mut [f64]) {
        for bound in &self.0 {
            q[bound.q] = q[bound.q].max(bound.lower).min(bound.upper);
        }
    }
}

/// What the limits of a follower ask of its leader: none where it follows another joint, or nothing moves it.
fn follower_limits(model: &Model, follower: &crate::Joint, leader: &crate::Joint) -> Option<(f64, f64)> {
    // follower = ratio · leader + offset, along the chain of leaders.
    let (mut ratio, mut offset) = (1.0, 0.0);
    let mut joint = follower;
    while let Some(mimic) = &joint.mimic {
        offset += ratio * mimic.offset;
        ratio *= mimic.ratio;
        joint = model.joint(&mimic.joint)?;
    }
    if std::ptr::eq(joint, follower) || joint.name != leader.name || ratio == 0.0 {
        return None;
    }
    let at = |limit: f64| (limit - offset) / ratio;
    let (one, other) = (at(follower.limits.lower), at(follower.limits.upper));
    Some((one.min(other), one.max(other)))
}
