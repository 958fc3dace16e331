//! The random states that everything is measured on.

use dynamics::{Scalar, SplitMix64};
use multibody::{FrameId, Joint, Model, random_state};

/// q, v, a and tau of many states, each one state after the other.
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
    /// The same for the same seed, in either precision.
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

/// How many states a batch takes at once: enough for every thread, few enough for the results to stay in a cache.
#[cfg(feature = "batch")]
pub(super) fn piece(model: &Model, count: usize, threads: usize) -> usize {
    // Each thread has at least one block of the widest lanes.
    (32768 / model.nv()).next_multiple_of(16).max(16 * threads).min(count)
}

/// The frame with the most joints between it and the world, and its name.
pub(super) fn tip(model: &Model) -> (FrameId, String) {
    let joints = model.joints();
    let depth = |joint: &Joint| {
        let carrier = |joint: &Joint| joints.iter().find(|other| other.child == joint.parent);
        core::iter::successors(Some(joint), |joint| carrier(joint)).filter(|joint| joint.nv > 0).count()
    };
    // Of equally deep ones the first.
    let deepest = joints.iter().rev().max_by_key(|joint| depth(joint));
    let name = deepest.map_or(&model.frames()[0].name, |joint| &joint.child);
    (model.frame(name).expect("every link is a frame"), name.clone())
}
