//! The equation of motion with wrenches from outside on some frames.

use pyo3::prelude::*;
use robot_dynamics::{FrameId, FrameWrench};

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

#[pymethods]
impl Robot {
    /// See `inverse_dynamics_with_wrenches`.
    #[pyo3(signature = (q, v, a, frames, wrenches, *, out, threads))]
    fn _inverse_dynamics_with_wrenches<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row = Row {
            name: "inverse_dynamics_with_wrenches",
            operands: &[Q, V, Operand { name: "a", width: Width::Nv }, WRENCHES],
            results: &[Shape::Vector],
            work: Work::Each(|m, s, x, frames, [out, ..]| {
                let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
                robot_dynamics::inverse_dynamics_with_wrenches(m, w, x[0], x[1], x[2], &pushed, out);
            }),
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q, v, a, wrenches], &frames, out, threads)
    }

    /// See `joint_reactions`.
    #[pyo3(signature = (q, v, a, frames, wrenches, *, out, threads))]
    fn _joint_reactions<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row = Row {
            name: "joint_reactions",
            operands: &[Q, V, Operand { name: "a", width: Width::Nv }, WRENCHES],
            results: &[Shape::Reactions],
            work: Work::Each(|m, s, x, frames, [out, ..]| {
                let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
                robot_dynamics::joint_reactions(m, w, x[0], x[1], x[2], &pushed, out);
            }),
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q, v, a, wrenches], &frames, out, threads)
    }

    /// See `forward_dynamics_with_wrenches`.
    #[pyo3(signature = (q, v, tau, frames, wrenches, *, out, threads))]
    fn _forward_dynamics_with_wrenches<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row = Row {
            name: "forward_dynamics_with_wrenches",
            operands: &[Q, V, Operand { name: "tau", width: Width::Nv }, WRENCHES],
            results: &[Shape::Vector],
            work: Work::Each(|m, s, x, frames, [out, ..]| {
                let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
                robot_dynamics::forward_dynamics_with_wrenches(m, w, x[0], x[1], x[2], &pushed, out);
            }),
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q, v, tau, wrenches], &frames, out, threads)
    }

    /// See `inverse_dynamics_derivatives_with_wrenches`.
    #[pyo3(signature = (q, v, a, frames, wrenches, *, out, threads))]
    fn _inverse_dynamics_derivatives_with_wrenches<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row = Row {
            name: "inverse_dynamics_derivatives_with_wrenches",
            operands: &[Q, V, Operand { name: "a", width: Width::Nv }, WRENCHES],
            results: &[Shape::Square, Shape::Square],
            work: Work::Each(|m, s, x, frames, [by_q, by_v, ..]| {
                let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
                robot_dynamics::inverse_dynamics_derivatives_with_wrenches(
                    m, w, x[0], x[1], x[2], &pushed, by_q, by_v,
                );
            }),
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q, v, a, wrenches], &frames, out, threads)
    }

    /// See `forward_dynamics_derivatives_with_wrenches`.
    #[pyo3(signature = (q, v, tau, frames, wrenches, *, out, threads))]
    fn _forward_dynamics_derivatives_with_wrenches<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        frames: Vec<Bound<'py, PyAny>>,
        wrenches: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row = Row {
            name: "forward_dynamics_derivatives_with_wrenches",
            operands: &[Q, V, Operand { name: "tau", width: Width::Nv }, WRENCHES],
            results: &[Shape::Square, Shape::Square, Shape::Square],
            work: Work::Each(|m, s, x, frames, [by_q, by_v, by_tau, ..]| {
                let (w, pushed) = (&mut s.workspace, wrenches_of(frames, x[3]));
                robot_dynamics::forward_dynamics_derivatives_with_wrenches(
                    m, w, x[0], x[1], x[2], &pushed, by_q, by_v, by_tau,
                );
            }),
        };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q, v, tau, wrenches], &frames, out, threads)
    }
}
