//! The generalized forces of controls.

use robot_dynamics_core::Model;
use robot_dynamics_number::{InvalidInput, check_finite};

/// τ = S u: the constant map from m controls to nv generalized forces.
///
/// ```
/// use robot_dynamics::control::optimal::ActuationMatrix;
/// // One motor with a gear of 50 drives the second of two joints.
/// let gear = ActuationMatrix::new(2, 1, &[0.0, 50.0])?;
/// let mut tau = [f64::NAN; 2];
/// gear.forces(&[0.1], &mut tau);
/// assert_eq!(tau, [0.0, 5.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "selection matrix")]
#[doc(alias = "gear")]
pub struct ActuationMatrix {
    dofs: usize,
    controls: usize,
    /// The entries that are not zero: row, column, value.
    entries: Vec<(usize, usize, f64)>,
}

impl ActuationMatrix {
    /// S with nv rows and m columns, row-major.
    ///
    /// # Errors
    /// [`InvalidInput`] if the number of entries is not nv·m, or an entry is not finite.
    pub fn new(dofs: usize, controls: usize, entries: &[f64]) -> Result<Self, InvalidInput> {
        if entries.len() != dofs * controls {
            let shape = format!("has {} numbers, {dofs}×{controls} are needed", entries.len());
            return Err(InvalidInput::unmet("the actuation matrix", shape));
        }
        check_finite("the actuation matrix", entries)?;
        let at = |k: usize| (k / controls, k % controls, entries[k]);
        let entries = (0..entries.len()).map(at).filter(|entry| entry.2 != 0.0).collect();
        Ok(Self { dofs, controls, entries })
    }

    /// One control for each of the nv coordinates: τ = u.
    pub fn identity(model: &Model) -> Self {
        let dofs = model.nv();
        Self { dofs, controls: dofs, entries: (0..dofs).map(|i| (i, i, 1.0)).collect() }
    }

    /// One control for each actuated coordinate of the robot, in the order of v: a floating base has none.
    pub fn actuated(model: &Model) -> Self {
        let driven = model.actuated_dofs().iter().enumerate().filter(|(_, driven)| **driven);
        let entries: Vec<_> = driven.enumerate().map(|(control, (dof, _))| (dof, control, 1.0)).collect();
        Self { dofs: model.nv(), controls: entries.len(), entries }
    }

    /// The number of generalized forces, nv.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// The number of controls, m.
    pub fn controls(&self) -> usize {
        self.controls
    }

    /// # Errors
    /// S does not have nv rows, or has no column.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        if self.dofs != model.nv() || self.controls == 0 {
            let (rows, columns, nv) = (self.dofs, self.controls, model.nv());
            let shape = format!("is {rows}×{columns}; robot `{}` needs {nv} rows and a column", model.name());
            return Err(InvalidInput::unmet("the actuation matrix", shape));
        }
        Ok(())
    }

    /// S, nv×m, row-major.
    pub(super) fn columns(&self) -> Vec<f64> {
        let mut columns = vec![0.0; self.dofs * self.controls];
        self.entries.iter().for_each(|&(dof, control, gear)| columns[dof * self.controls + control] = gear);
        columns
    }

    /// τ = S u.
    pub fn forces(&self, u: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
        for &(dof, control, gear) in &self.entries {
            tau[dof] += gear * u[control];
        }
    }

    /// `product` = X S for X with nv columns, row-major.
    pub fn multiply(&self, x: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        for (product, x) in product.chunks_exact_mut(self.controls).zip(x.chunks_exact(self.dofs)) {
            for &(dof, control, gear) in &self.entries {
                product[control] += gear * x[dof];
            }
        }
    }
}
