//! The macros that write a table of methods, a line for each.

/// An argument as an operand of the row.
macro_rules! operand {
    (q) => {
        $crate::row::Operand { name: "q", width: $crate::row::Width::Nq }
    };
    (q0) => {
        $crate::row::Operand { name: "q0", width: $crate::row::Width::Nq }
    };
    (q1) => {
        $crate::row::Operand { name: "q1", width: $crate::row::Width::Nq }
    };
    (coordinates) => {
        $crate::row::Operand { name: "coordinates", width: $crate::row::Width::Coordinates }
    };
    (direction) => {
        $crate::row::Operand { name: "direction", width: $crate::row::Width::Direction }
    };
    (weights) => {
        $crate::row::Operand { name: "weights", width: $crate::row::Width::Six }
    };
    (s) => {
        $crate::row::Operand { name: "s", width: $crate::row::Width::One }
    };
    ($vector:ident) => {
        $crate::row::Operand { name: stringify!($vector), width: $crate::row::Width::Nv }
    };
}

/// A method for each line: `name(operands) at frame => Class[results] raises Error`, then the examples, then
/// `=` and the work. A result has its shape, its field in the class if there are several, and a text. The
/// sections of the docstring follow from these.
macro_rules! rows {
    ($(
        $(#[$doc:meta])*
        $name:ident($($operand:ident),*) $(at $frame:ident)?
            => $($class:ident)?[$($shape:ident$(($rows:literal))? $($field:ident)? $text:literal),* $(,)?]
            $(raises $error:ident)?
        $(#[$example:meta])*
        = $work:expr;
    )*) => {
        /// The rows of this file, by their methods' names.
        #[allow(non_upper_case_globals)]
        mod table {
            #[allow(clippy::wildcard_imports)] // the lines use the names of the file
            use super::*;
            $(
                pub(super) static $name: $crate::row::Row = $crate::row::Row {
                    name: stringify!($name),
                    operands: &[$($crate::rows::table::operand!($operand)),*],
                    results: &[$($crate::row::Shape::$shape$(($rows))?),*],
                    work: $work,
                };
            )*
            pub(in crate::rows) static ALL: &[&$crate::row::Row] = &[$(&$name),*];
        }
        pub(in crate::rows) use table::ALL;

        #[pyo3::pymethods]
        impl $crate::robot::Robot {
            $(
                $(#[$doc])*
                #[doc = $crate::rows::sections::sections!(
                    ($($operand)* $($frame)?) -> $($class)?[$($shape$(($rows))? $($field)? $text),*]
                    raises ($($error)? $($frame)?)
                )]
                $(#[$example])*
                #[pyo3(signature = ($($operand,)* $($frame,)? *, out=None, threads=None))]
                fn $name<'py>(
                    &self,
                    py: pyo3::Python<'py>,
                    $($operand: &pyo3::Bound<'py, pyo3::PyAny>,)*
                    $($frame: &pyo3::Bound<'py, pyo3::PyAny>,)?
                    out: Option<&pyo3::Bound<'py, pyo3::PyAny>>,
                    threads: Option<&pyo3::Bound<'py, pyo3::PyAny>>,
                ) -> pyo3::PyResult<pyo3::Bound<'py, pyo3::PyAny>> {
                    let frames = &[$(self.frame_of($frame)?)?];
                    $crate::call::call(py, self, &table::$name, &[$($operand),*], frames, out, threads)
                }
            )*
        }
    };
}

/// A method with a frame and a reference frame for each line, as [`rows`], with the work in each of
/// [`ReferenceFrame::ALL`].
macro_rules! frame_rows {
    ($(
        $(#[$doc:meta])*
        $name:ident($($operand:ident),*)
            => $($class:ident)?[$($shape:ident$(($rows:literal))? $($field:ident)? $text:literal),* $(,)?]
        $(#[$example:meta])*
        = $work:expr;
    )*) => {
        /// The rows of this file in each reference frame, by their methods' names.
        #[allow(non_upper_case_globals)]
        mod frame_table {
            #[allow(clippy::wildcard_imports)] // the lines use the names of the file
            use super::*;
            $(
                pub(super) static $name: [$crate::row::Row; 3] = {
                    const fn of(work: Work) -> $crate::row::Row {
                        $crate::row::Row {
                            name: stringify!($name),
                            operands: &[$($crate::rows::table::operand!($operand)),*],
                            results: &[$($crate::row::Shape::$shape$(($rows))?),*],
                            work,
                        }
                    }
                    let [local, world, aligned]: [Work; 3] = $work;
                    [of(local), of(world), of(aligned)]
                };
            )*
            /// The rows in the default reference frame.
            pub(in crate::rows) static FRAMES: &[&$crate::row::Row] =
                &[$(&$name[ReferenceFrame::LocalWorldAligned as usize]),*];
        }
        pub(in crate::rows) use frame_table::FRAMES;

        #[pyo3::pymethods]
        impl $crate::robot::Robot {
            $(
                $(#[$doc])*
                #[doc = $crate::rows::sections::sections!(
                    ($($operand)* frame reference_frame) -> $($class)?[$($shape$(($rows))? $($field)? $text),*]
                    raises (frame reference_frame)
                )]
                $(#[$example])*
                #[pyo3(signature = (
                    $($operand,)* frame, reference_frame="local_world_aligned", *, out=None, threads=None
                ))]
                fn $name<'py>(
                    &self,
                    py: pyo3::Python<'py>,
                    $($operand: &pyo3::Bound<'py, pyo3::PyAny>,)*
                    frame: &pyo3::Bound<'py, pyo3::PyAny>,
                    reference_frame: &str,
                    out: Option<&pyo3::Bound<'py, pyo3::PyAny>>,
                    threads: Option<&pyo3::Bound<'py, pyo3::PyAny>>,
                ) -> pyo3::PyResult<pyo3::Bound<'py, pyo3::PyAny>> {
                    let seen = $crate::row::reference_frame_of("reference_frame", reference_frame)?;
                    let (row, frames) = (&frame_table::$name[seen as usize], &[self.frame_of(frame)?]);
                    $crate::call::call(py, self, row, &[$($operand),*], frames, out, threads)
                }
            )*
        }
    };
}
pub(super) use {frame_rows, operand, rows};

/// Linear, then angular.
pub(super) fn six(out: &mut [f64], linear: [f64; 3], angular: [f64; 3]) {
    out[..3].copy_from_slice(&linear);
    out[3..].copy_from_slice(&angular);
}
