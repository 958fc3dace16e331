//! Three components as one value, and symmetric 3×3 matrices, in the fastest layout for each number.
//!
//! Most numbers keep three components apart (`[S; 3]`). A single hardware float is faster with all three in
//! one vector register ([`Quad`](crate::Quad)). Products with a matrix then use its columns, and storing the
//! transpose beside the matrix saves time.

use core::fmt::Debug;

/// Three components of a number `S`.
pub trait Triple<S>: Copy + Debug + Send + Sync + 'static {
    /// Whether Mᵀ v is better computed from the stored columns of Mᵀ than by three inner products.
    const COLUMNS: bool;

    /// Whether a product with a known zero or one costs nothing, as in a trace of operations for generated
    /// code. Recursions then use the bodies' own frames, in which most constants are zero or one.
    const FOLDS_ZEROS: bool = false;

    /// From the components.
    fn new(components: [S; 3]) -> Self;
    /// From constants; the fourth is padding.
    fn constant(components: &[f64; 4]) -> Self;
    /// The components.
    fn array(self) -> [S; 3];
    /// Component `i` < 3.
    fn get(self, i: usize) -> S;
    /// a + b.
    fn plus(self, b: Self) -> Self;
    /// a − b.
    fn minus(self, b: Self) -> Self;
    /// −a.
    fn negated(self) -> Self;
    /// k a.
    fn times(self, k: S) -> Self;
    /// k a + b.
    fn times_plus(self, k: S, b: Self) -> Self;
    /// b − k a.
    fn minus_times(self, k: S, b: Self) -> Self;
    /// v_I a.
    fn times_lane<const I: usize>(self, v: Self) -> Self;
    /// v_I a + b.
    fn times_lane_plus<const I: usize>(self, v: Self, b: Self) -> Self;
    /// b − v_I a.
    fn minus_times_lane<const I: usize>(self, v: Self, b: Self) -> Self;
    /// a + (0, 0, z).
    fn plus_z(self, z: S) -> Self;
    /// a × b.
    fn cross(self, b: Self) -> Self;
    /// a × b + c × d.
    fn cross_sum(self, b: Self, c: Self, d: Self) -> Self;
    /// a × (0, 0, z).
    fn cross_z(self, z: S) -> Self;
    /// The columns of \[a\]×, the matrix of a × ….
    fn skew(self) -> [Self; 3];
    /// The columns of \[α\]× + \[ω\]×\[ω\]× = \[α\]× + ω ωᵀ − |ω|² 1, `self` being ω.
    fn spin_gradient(self, alpha: Self) -> [Self; 3];
    /// a · b.
    fn dot(self, b: Self) -> S;
    /// The rows of the matrix with these columns.
    fn transpose(columns: [Self; 3]) -> [Self; 3];
    /// The columns of M − k a bᵀ from M's; `scaled` is k b.
    fn minus_scaled_outer(columns: [Self; 3], a: Self, b: Self, k: S, scaled: Self) -> [Self; 3];
}

/// A symmetric 3×3 matrix over triples `T`.
pub trait Symmetric<S, T>: Copy + Debug + Send + Sync + 'static {
    /// From its three columns; only one triangle may be read.
    fn from_columns(columns: [T; 3]) -> Self;
    /// Its three columns.
    fn columns(self) -> [T; 3];
    /// A + B.
    fn plus(self, b: Self) -> Self;
    /// A + k 1.
    fn plus_multiple_of_identity(self, k: S) -> Self;
    /// A − k a aᵀ; `scaled` is k a.
    fn minus_square(self, a: T, k: S, scaled: T) -> Self;
    /// A v.
    fn apply(self, v: T) -> T;
}
