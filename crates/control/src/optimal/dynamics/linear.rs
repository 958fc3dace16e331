//! Linear dynamics.

use nalgebra::DMatrix;
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::StepError;

use super::{DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// x′ = A x + B u + c on plain numbers: the dynamics of linear-quadratic problems.
#[derive(Clone, Debug)]
pub struct LinearDynamics {
    space: StateSpace,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    offset: Vec<f64>,
}

impl LinearDynamics {
    /// x′ = A x + B u, with A n×n and B n×m.
    ///
    /// # Errors
    /// [`InvalidInput`] if a matrix has the wrong shape or is not finite.
    pub fn new(a: DMatrix<f64>, b: DMatrix<f64>) -> Result<Self, InvalidInput> {
        let n = a.nrows();
        for (name, matrix, columns) in [("A", &a, n), ("B", &b, b.ncols())] {
            if matrix.is_empty() || matrix.shape() != (n, columns) {
                let (rows, columns) = matrix.shape();
                let shape = format!("is {rows}×{columns}; A must be n×n and B n×m, with n and m above 0");
                return Err(InvalidInput::unmet(name, shape));
            }
            robot_dynamics_number::check_finite(name, matrix.as_slice())?;
        }
        Ok(Self { space: StateSpace::vector(n), offset: vec![0.0; n], a, b })
    }

    /// The same with a constant c: x′ = A x + B u + c.
    ///
    /// # Errors
    /// [`InvalidInput`] if c does not have n finite numbers.
    pub fn with_offset(mut self, offset: &[f64]) -> Result<Self, InvalidInput> {
        self.space.check("the offset", offset)?;
        self.offset.copy_from_slice(offset);
        Ok(self)
    }
}

impl DiscreteDynamics for LinearDynamics {
    fn state_space(&self) -> &StateSpace {
        &self.space
    }

    fn controls(&self) -> usize {
        self.b.ncols()
    }

    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        for (i, next) in next.iter_mut().enumerate() {
            let by_state: f64 = self.a.row(i).iter().zip(x).map(|(a, x)| a * x).sum();
            let by_control: f64 = self.b.row(i).iter().zip(u).map(|(b, u)| b * u).sum();
            *next = by_state + by_control + self.offset[i];
        }
        Ok(())
    }

    fn linearize(
        &mut self,
        _x: &[f64],
        _u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        let LinearizedDynamics { by_state, by_control } = derivatives;
        for (matrix, to) in [(&self.a, by_state), (&self.b, by_control)] {
            for (row, to) in matrix.row_iter().zip(to.chunks_exact_mut(matrix.ncols())) {
                to.iter_mut().zip(row.iter()).for_each(|(to, x)| *to = *x);
            }
        }
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}
