//! The effort of a search for a proof, and the divisions of boxes.

use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

use crate::Interval;

/// How long a search runs, and its accuracy.
#[derive(Clone, Debug)]
pub struct SearchOptions {
    /// The search ends if divisions change no bound by more than this part of its range.
    pub tolerance: f64,
    /// The largest number of boxes.
    pub boxes: usize,
    /// The number of threads; 0 for all.
    pub threads: usize,
    /// Ends the search early if it is set. The bound is proven at any time.
    pub interrupt: Option<Arc<AtomicBool>>,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { tolerance: 1e-2, boxes: 200_000, threads: 0, interrupt: None }
    }
}

impl SearchOptions {
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    pub(crate) fn thread_count(&self) -> usize {
        if self.threads > 0 {
            return self.threads;
        }
        std::thread::available_parallelism().map_or(1, usize::from)
    }
}

/// The divisions of a box into parts, as a binary tree. A division halves one coordinate at its middle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Divisions {
    /// For each node the divided coordinate and the index of the first half; the second half follows it.
    nodes: Vec<Option<(usize, usize)>>,
}

impl Divisions {
    pub(crate) fn root() -> Self {
        Self { nodes: vec![None] }
    }

    pub(crate) fn divide(&mut self, node: usize, coordinate: usize) -> [usize; 2] {
        let first = self.nodes.len();
        self.nodes[node] = Some((coordinate, first));
        self.nodes.extend([None, None]);
        [first, first + 1]
    }

    /// The nodes from the root, each before its halves: the divided coordinate, or −1 for a part that is not
    /// divided.
    pub fn preorder(&self) -> Vec<i64> {
        let (mut order, mut pending) = (Vec::new(), vec![0]);
        while let Some(node) = pending.pop() {
            match self.nodes.get(node).copied().flatten() {
                Some((coordinate, first)) => {
                    order.push(i64::try_from(coordinate).unwrap_or(i64::MAX));
                    pending.extend([first + 1, first]);
                }
                None => order.push(-1),
            }
        }
        order
    }
}

/// The results for each item in order, computed by the workers in parallel.
pub(crate) fn map_on_threads<W: Send, T: Sync, R: Send>(
    workers: &mut [W],
    items: &[T],
    apply: impl Fn(&mut W, &T) -> R + Sync,
) -> Vec<R> {
    if workers.len() < 2 || items.len() < 2 {
        return items.iter().map(|item| apply(&mut workers[0], item)).collect();
    }
    let share = items.len().div_ceil(workers.len());
    std::thread::scope(|scope| {
        let apply = &apply;
        let running: Vec<_> = workers
            .iter_mut()
            .zip(items.chunks(share))
            .map(|(worker, items)| {
                scope.spawn(move || items.iter().map(|item| apply(worker, item)).collect::<Vec<R>>())
            })
            .collect();
        running.into_iter().flat_map(|thread| thread.join().expect("a bound does not panic")).collect()
    })
}

pub(crate) fn middle(region: &[Interval]) -> Vec<f64> {
    region.iter().map(|x| x.middle()).collect()
}
