//! Three traced numbers as one value.
//!
//! As three separate components, each operation of the recursions would be inlined many thousand times. As
//! functions that are not inlined, they compile in a fifth of the time.

use robot_dynamics_number::{Symmetric, Triple};

use crate::traced::Traced;

type Array = [Traced; 3];
type Entries = [Traced; 6];

/// Three components; each operation is that of the array.
#[derive(Clone, Copy, Debug)]
pub struct TracedTriple(Array);

/// The entries xx, xy, xz, yy, yz, zz; each operation is that of the array.
#[derive(Clone, Copy, Debug)]
pub struct TracedSymmetric(Entries);

fn unwrap_columns(columns: [TracedTriple; 3]) -> [Array; 3] {
    columns.map(|column| column.0)
}

fn wrap_columns(columns: [Array; 3]) -> [TracedTriple; 3] {
    columns.map(TracedTriple)
}

/// Defines methods that call those of the array.
macro_rules! delegate {
    ($($name:ident($($argument:ident: $kind:ident),*) -> $result:ident;)*) => {
        $(
            #[inline(never)]
            fn $name(self, $($argument: delegate!(@type $kind)),*) -> delegate!(@type $result) {
                delegate!(@wrap $result, Triple::$name(self.0, $(delegate!(@bare $kind, $argument)),*))
            }
        )*
    };
    (@type triple) => { Self };
    (@type columns) => { [Self; 3] };
    (@type number) => { Traced };
    (@wrap triple, $x:expr) => { Self($x) };
    (@wrap columns, $x:expr) => { wrap_columns($x) };
    (@wrap number, $x:expr) => { $x };
    (@bare triple, $x:expr) => { $x.0 };
    (@bare columns, $x:expr) => { unwrap_columns($x) };
    (@bare number, $x:expr) => { $x };
}

impl Triple<Traced> for TracedTriple {
    const COLUMNS: bool = <Array as Triple<Traced>>::COLUMNS;
    const FOLDS_ZEROS: bool = true;

    fn new(components: Array) -> Self {
        Self(components)
    }
    #[inline(never)]
    fn constant(components: &[f64; 4]) -> Self {
        Self(Triple::constant(components))
    }
    fn array(self) -> Array {
        self.0
    }
    fn get(self, i: usize) -> Traced {
        self.0[i]
    }

    delegate! {
        plus(b: triple) -> triple;
        minus(b: triple) -> triple;
        negated() -> triple;
        times(k: number) -> triple;
        times_plus(k: number, b: triple) -> triple;
        minus_times(k: number, b: triple) -> triple;
        plus_z(z: number) -> triple;
        cross(b: triple) -> triple;
        cross_sum(b: triple, c: triple, d: triple) -> triple;
        cross_z(z: number) -> triple;
        skew() -> columns;
        spin_gradient(alpha: triple) -> columns;
        dot(b: triple) -> number;
    }

    #[inline(never)]
    fn times_lane<const I: usize>(self, v: Self) -> Self {
        Self(self.0.times_lane::<I>(v.0))
    }
    #[inline(never)]
    fn times_lane_plus<const I: usize>(self, v: Self, b: Self) -> Self {
        Self(self.0.times_lane_plus::<I>(v.0, b.0))
    }
    #[inline(never)]
    fn minus_times_lane<const I: usize>(self, v: Self, b: Self) -> Self {
        Self(self.0.minus_times_lane::<I>(v.0, b.0))
    }
    fn transpose(columns: [Self; 3]) -> [Self; 3] {
        wrap_columns(Triple::transpose(unwrap_columns(columns)))
    }
    #[inline(never)]
    fn minus_scaled_outer(columns: [Self; 3], a: Self, b: Self, k: Traced, scaled: Self) -> [Self; 3] {
        wrap_columns(Triple::minus_scaled_outer(unwrap_columns(columns), a.0, b.0, k, scaled.0))
    }
}

impl Symmetric<Traced, TracedTriple> for TracedSymmetric {
    fn from_columns(columns: [TracedTriple; 3]) -> Self {
        Self(Symmetric::from_columns(unwrap_columns(columns)))
    }
    fn columns(self) -> [TracedTriple; 3] {
        wrap_columns(self.0.columns())
    }
    #[inline(never)]
    fn plus(self, b: Self) -> Self {
        Self(Symmetric::plus(self.0, b.0))
    }
    #[inline(never)]
    fn plus_multiple_of_identity(self, k: Traced) -> Self {
        Self(self.0.plus_multiple_of_identity(k))
    }
    #[inline(never)]
    fn minus_square(self, a: TracedTriple, k: Traced, scaled: TracedTriple) -> Self {
        Self(self.0.minus_square(a.0, k, scaled.0))
    }
    #[inline(never)]
    fn apply(self, v: TracedTriple) -> TracedTriple {
        TracedTriple(self.0.apply(v.0))
    }
}
