//! The equation of motion with wrenches from outside on some frames.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::algorithms::FrameWrench;
use robot_dynamics::model::FrameId;

use crate::call::call;
use crate::robot::Robot;
use crate::row::{Operand, Row, Shape, Width, Work};

const Q: Operand = Operand { name: "q", width: Width::Nq };
const V: Operand = Operand { name: "v", width: Width::Nv };
const WRENCHES: Operand = Operand { name: "wrenches", width: Width::Wrenches };

/// Six numbers for each frame: force, then moment, along the frame's axes.
fn wrenches_of(frames: &[FrameId], numbers: &[f64]) -> Vec<FrameWrench> {
    let three = |numbers: &[f64]| [numbers[0], numbers[1], numbers[2]];
    let rows = frames.iter().zip(numbers.chunks_exact(6));
    rows.map(|(&frame, row)| FrameWrench {
        frame,
        force_in_frame: three(row),
        moment_in_frame: three(&row[3..]),
    })
    .collect()
}

const TAU: Operand = Operand { name: "tau", width: Width::Nv };
const A: Operand = Operand { name: "a", width: Width::Nv };

const INVERSE_DYNAMICS: Row = Row {
    name: "inverse_dynamics_with_wrenches",
    operands: &[Q, V, A, WRENCHES],
    results: &[Shape::Vector],
    work: Work::Each(|m, s, x, frames, [out, ..]| {
        let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
        robot_dynamics::algorithms::inverse_dynamics_with_wrenches(m, w, x[0], x[1], x[2], &pushed, out);
    }),
};

const JOINT_REACTIONS: Row = Row {
    name: "joint_reactions",
    operands: &[Q, V, A, WRENCHES],
    results: &[Shape::Reactions],
    work: Work::Each(|m, s, x, frames, [out, ..]| {
        let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
        robot_dynamics::algorithms::joint_reactions(m, w, x[0], x[1], x[2], &pushed, out);
    }),
};

const FORWARD_DYNAMICS: Row = Row {
    name: "forward_dynamics_with_wrenches",
    operands: &[Q, V, TAU, WRENCHES],
    results: &[Shape::Vector],
    work: Work::Each(|m, s, x, frames, [out, ..]| {
        let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
        robot_dynamics::algorithms::forward_dynamics_with_wrenches(m, w, x[0], x[1], x[2], &pushed, out);
    }),
};

const INVERSE_DYNAMICS_DERIVATIVES: Row = Row {
    name: "inverse_dynamics_derivatives_with_wrenches",
    operands: &[Q, V, A, WRENCHES],
    results: &[Shape::Square, Shape::Square],
    work: Work::Each(|m, s, x, frames, [by_q, by_v, ..]| {
        let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
        let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
            by_position: by_q,
            by_velocity: by_v,
        };
        robot_dynamics::derivatives::inverse_dynamics_derivatives_with_wrenches(
            m, w, x[0], x[1], x[2], &pushed, out,
        );
    }),
};

const FORWARD_DYNAMICS_DERIVATIVES: Row = Row {
    name: "forward_dynamics_derivatives_with_wrenches",
    operands: &[Q, V, TAU, WRENCHES],
    results: &[Shape::Square, Shape::Square, Shape::Square],
    work: Work::Each(|m, s, x, frames, [by_q, by_v, by_tau, ..]| {
        let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
        let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
            by_position: by_q,
            by_velocity: by_v,
            by_force: by_tau,
        };
        robot_dynamics::derivatives::forward_dynamics_derivatives_with_wrenches(
            m, w, x[0], x[1], x[2], &pushed, out,
        );
    }),
};

#[pymethods]
impl Robot {
    /// The results of `row` for states under wrenches: `inverse_dynamics`, `forward_dynamics`,
    /// `joint_reactions`, `inverse_dynamics_derivatives` or `forward_dynamics_derivatives`; `x` is a or τ.
    #[pyo3(signature = (row, q, v, x, frames, wrenches, *, out, threads))]
    fn _with_wrenches<'py>(
        &self,
        py: Python<'py>,
        row: &str,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        x: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let row: &'static Row = match row {
            "inverse_dynamics" => &INVERSE_DYNAMICS,
            "forward_dynamics" => &FORWARD_DYNAMICS,
            "joint_reactions" => &JOINT_REACTIONS,
            "inverse_dynamics_derivatives" => &INVERSE_DYNAMICS_DERIVATIVES,
            "forward_dynamics_derivatives" => &FORWARD_DYNAMICS_DERIVATIVES,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "nothing is computed under wrenches by the name {row:?}"
                )));
            }
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(frame)).collect::<PyResult<_>>()?;
        call(py, self, row, &[q, v, x, wrenches], &frames, out, threads)
    }
}
