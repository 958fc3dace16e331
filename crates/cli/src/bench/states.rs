//! Random states for all measurements.

use robot_dynamics::model::{FrameId, Joint, Model, random_state};
use robot_dynamics_number::{Scalar, SplitMix64};

/// q, v, a and tau of all states, one state after the other.
pub(super) struct States<T> {
    pub(super) count: usize,
    pub(super) nq: usize,
    pub(super) nv: usize,
    pub(super) q: Vec<T>,
    pub(super) v: Vec<T>,
    pub(super) a: Vec<T>,
    pub(super) tau: Vec<T>,
}

impl<T: Scalar> States<T> {
    /// States that depend only on the seed, in either precision.
    pub(super) fn random(model: &Model, count: usize, seed: u64) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        let [q, v, a, tau] = [nq, nv, nv, nv].map(|n| Vec::with_capacity(count * n));
        let mut states = Self { count, nq, nv, q, v, a, tau };
        let mut random = SplitMix64::new(seed);
        for _ in 0..count {
            let state = random_state(model, &mut random);
            let tables = [&mut states.q, &mut states.v, &mut states.a, &mut states.tau];
            for (table, part) in tables.into_iter().zip([state.q, state.v, state.a, state.tau]) {
                table.extend(part.into_iter().map(T::from_f64));
            }
        }
        states
    }

    /// q, v, a and tau of some states.
    pub(super) fn part<'a>(&'a self, first: usize, count: usize) -> [&'a [T]; 4] {
        let part = |table: &'a [T], width: usize| &table[first * width..][..count * width];
        [part(&self.q, self.nq), part(&self.v, self.nv), part(&self.a, self.nv), part(&self.tau, self.nv)]
    }
}

/// Number of states in one call of a batch: enough for every thread, few enough for results that fit a cache.
#[cfg(feature = "batch")]
pub(super) fn piece(model: &Model, count: usize, threads: usize) -> usize {
    // Each thread has at least one block of the widest lanes.
    (32768 / model.nv()).next_multiple_of(16).max(16 * threads).min(count)
}

/// The frame with the most joints between it and the world, and its name.
pub(super) fn tip(model: &Model) -> (FrameId, String) {
    let joints = model.joints();
    let depth = |joint: &Joint| {
        let carrier = |joint: &Joint| joints.iter().find(|other| other.child_link == joint.parent_link);
        core::iter::successors(Some(joint), |joint| carrier(joint)).filter(|joint| joint.nv > 0).count()
    };
    // The first of equally deep frames.
    let deepest = joints.iter().rev().max_by_key(|joint| depth(joint));
    let name = deepest.map_or(&model.frames()[0].name, |joint| &joint.child_link);
    (model.frame(name).expect("every link is a frame"), name.clone())
}
