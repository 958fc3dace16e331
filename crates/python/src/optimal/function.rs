//! Residuals that Python computes.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use robot_dynamics::control::optimal::{Residual, ResidualInputs, ResidualJacobian, StateSpace};
use robot_dynamics::model::cotangent_from_coordinates;
use robot_dynamics::simulation::{CallbackError, StepError};

use crate::numbers::{array, shaped};

/// r(q, v, u) of a Python function, with derivatives of another function, or by central differences.
#[derive(Clone)]
pub(super) struct FunctionResidual {
    pub(super) space: StateSpace,
    pub(super) dimension: usize,
    pub(super) function: Arc<Py<PyAny>>,
    /// (∂r/∂(q, v), ∂r/∂u) by coordinates.
    pub(super) derivatives: Option<Arc<Py<PyAny>>>,
}

/// The displacement of central differences: their error is about its square.
const DISPLACEMENT: f64 = 1e-5;

impl FunctionResidual {
    fn call(&self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let called = Python::attach(|py| {
            let returned = self.function.bind(py).call1(self.arguments(py, x, u)?)?;
            let (_, r) = shaped(py, "the residual of a function", &returned, &[self.dimension])?;
            residual.copy_from_slice(&r);
            PyResult::Ok(())
        });
        called.map_err(|error| CallbackError::new(error).into())
    }

    /// (q, v, u), or (x, u) for plain numbers.
    fn arguments<'py>(&self, py: Python<'py>, x: &[f64], u: &[f64]) -> PyResult<Bound<'py, PyTuple>> {
        let u = array(py, u)?;
        match self.space.model() {
            Some(model) => {
                let (q, v) = x.split_at(model.nq());
                PyTuple::new(py, [array(py, q)?, array(py, v)?, u])
            }
            None => PyTuple::new(py, [array(py, x)?, u]),
        }
    }

    /// The derivatives of the user's function, by displacements.
    fn given(
        &self,
        derivatives: &Py<PyAny>,
        x: &[f64],
        u: &[f64],
        jacobian: &mut ResidualJacobian<'_>,
    ) -> PyResult<()> {
        let (rows, coordinates) = (self.dimension, x.len());
        let (by_x, by_u) = Python::attach(|py| {
            let returned = derivatives.bind(py).call1(self.arguments(py, x, u)?)?;
            let (by_x, by_u): (Bound<'_, PyAny>, Bound<'_, PyAny>) = returned.extract()?;
            let (_, by_x) = shaped(py, "the derivative by the state", &by_x, &[rows, coordinates])?;
            let (_, by_u) = shaped(py, "the derivative by the controls", &by_u, &[rows, u.len()])?;
            PyResult::Ok((by_x, by_u))
        })?;
        jacobian.by_control.copy_from_slice(&by_u);
        let Some(model) = self.space.model() else {
            jacobian.by_state.copy_from_slice(&by_x);
            return Ok(());
        };
        let (nq, nv) = (model.nq(), model.nv());
        for (row, to) in by_x.chunks_exact(coordinates).zip(jacobian.by_state.chunks_exact_mut(2 * nv)) {
            cotangent_from_coordinates(model, &x[..nq], &row[..nq], &mut to[..nv]);
            to[nv..].copy_from_slice(&row[nq..]);
        }
        Ok(())
    }

    /// The derivatives by central differences along displacements.
    fn differences(
        &self,
        x: &[f64],
        u: &[f64],
        jacobian: &mut ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let (n, m) = (self.space.tangent(), u.len());
        let mut sides = [vec![0.0; self.dimension], vec![0.0; self.dimension]];
        let (mut moved, mut pushed) = (x.to_vec(), u.to_vec());
        for column in 0..n + m {
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                if column < n {
                    let mut displacement = vec![0.0; n];
                    displacement[column] = sign * DISPLACEMENT;
                    self.space.integrate(x, &displacement, &mut moved);
                } else {
                    moved.copy_from_slice(x);
                    pushed.copy_from_slice(u);
                    pushed[column - n] += sign * DISPLACEMENT;
                }
                self.call(&moved, &pushed, side)?;
            }
            for row in 0..self.dimension {
                let derivative = (sides[0][row] - sides[1][row]) / (2.0 * DISPLACEMENT);
                match column.checked_sub(n) {
                    None => jacobian.by_state[row * n + column] = derivative,
                    Some(control) => jacobian.by_control[row * m + control] = derivative,
                }
            }
        }
        Ok(())
    }
}

impl Residual for FunctionResidual {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.space.coordinates()), controls: None }
    }

    fn evaluate(&mut self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        self.call(x, u, residual)
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        mut jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        self.call(x, u, residual)?;
        match &self.derivatives {
            Some(derivatives) => {
                self.given(derivatives, x, u, &mut jacobian).map_err(|error| CallbackError::new(error).into())
            }
            None => self.differences(x, u, &mut jacobian),
        }
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
