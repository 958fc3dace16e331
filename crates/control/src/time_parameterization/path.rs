//! Paths in the space of configurations.

/// A point of a path with its first two derivatives by the path parameter s.
#[derive(Clone, Debug, PartialEq)]
pub struct TreePathPoint {
    /// q(s), nq.
    pub q: Vec<f64>,
    /// q′: the velocity v at ṡ = 1, nv. It is dq/ds for plain coordinates, and the body velocity for
    /// quaternions.
    pub dq: Vec<f64>,
    /// q″ = dq′/ds, nv.
    pub ddq: Vec<f64>,
}

/// A curve q(s) on s from [`start`](TreePath::start) to [`end`](TreePath::end), twice differentiable.
pub trait TreePath {
    /// q, q′ and q″ at s.
    fn at(&self, s: f64) -> TreePathPoint;

    /// The first s.
    fn start(&self) -> f64;

    /// The last s.
    fn end(&self) -> f64;

    /// The values of s, in order, at which q″ or one of its derivatives is discontinuous. Grids contain these
    /// points, because a motion is smooth only between them.
    fn corners(&self) -> &[f64] {
        &[]
    }
}

/// A closure s ↦ (q, q′, q″) with its range of s.
impl<F: Fn(f64) -> TreePathPoint> TreePath for (F, core::ops::RangeInclusive<f64>) {
    fn at(&self, s: f64) -> TreePathPoint {
        (self.0)(s)
    }

    fn start(&self) -> f64 {
        *self.1.start()
    }

    fn end(&self) -> f64 {
        *self.1.end()
    }
}
