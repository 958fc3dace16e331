//! Records of measured motions.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{
    FrameWrench, Model, PARAMETERS_PER_LINK, Workspace, check_configuration, check_vector, dissipation,
    inertial_parameters, inverse_dynamics_with_wrenches, joint_torque_regressor,
};
use robot_dynamics_number::{InvalidInput, check_result};

use super::joint_term::{Exponential, JointTerm, check_terms};
use super::parameter_names;

/// Samples (q, v, a, τ) of one robot, as equations W x = τ.
///
/// x lists the inertial parameters π and then the parameters of the joint terms that
/// [`with_terms`](Self::with_terms) names. All other forces of the model are subtracted from τ: armature and
/// springs, measured external wrenches, and optionally damping and friction.
///
/// ```
/// use robot_dynamics::control::identification::{BaseParameters, JointTerm, JointTermKind, MotionRecord};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let terms = JointTerm::of_all(&model, &[JointTermKind::Damping, JointTermKind::Friction]);
/// let mut record = MotionRecord::new(&model, true).with_terms(&terms)?.with_noise(&[0.1])?;
/// for i in 0..50 {
///     let t = 0.1 * f64::from(i);
///     let (q, v, a) = (t.sin(), t.cos(), -t.sin());
///     let rigid = model.inverse_dynamics(&[q], &[v], &[a])?[0];
///     record.push(&[q], &[v], &[a], &[rigid + 0.3 * v + 0.2 * v.signum()])?; // in practice: measured
/// }
/// let base = BaseParameters::of_record(&record);
/// let found = base.identify(&record)?;
/// let names: Vec<String> = base.parameters.iter().map(ToString::to_string).collect();
/// assert_eq!(names[2..], ["rod.Iyy", "hinge.damping", "hinge.friction"]);
/// assert!((found.values[3] - 0.3).abs() < 1e-9 && (found.values[4] - 0.2).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MotionRecord<'a> {
    pub(super) model: &'a Model,
    workspace: Workspace,
    /// Whether τ includes the joints' damping and friction.
    with_dissipation: bool,
    pub(super) terms: Vec<JointTerm>,
    /// The standard deviation of the noise of each coordinate; infinite if it is not measured.
    deviations: Vec<f64>,
    /// x of the robot as described.
    pub(super) nominal: DVector<f64>,
    /// W, row-major, divided by the standard deviations.
    pub(super) rows: Vec<f64>,
    /// τ less the forces that do not depend on x, divided by the standard deviations.
    pub(super) torques: Vec<f64>,
    /// The coordinate of each row.
    coordinates: Vec<usize>,
    samples: usize,
}

impl<'a> MotionRecord<'a> {
    /// Creates an empty record. `with_dissipation` states whether the torques include the damping and
    /// friction of the model's joints.
    pub fn new(model: &'a Model, with_dissipation: bool) -> Self {
        Self {
            model,
            workspace: Workspace::new(model),
            with_dissipation,
            terms: Vec::new(),
            deviations: vec![1.0; model.nv()],
            nominal: DVector::from_vec(inertial_parameters(model)),
            rows: Vec::new(),
            torques: Vec::new(),
            coordinates: Vec::new(),
            samples: 0,
        }
    }

    /// Identifies these parameters of the joints as well. The description's values of the others are taken
    /// as known.
    ///
    /// # Errors
    /// [`InvalidInput`] if a joint has several degrees of freedom, a term occurs twice, or the record has
    /// samples.
    pub fn with_terms(mut self, terms: &[JointTerm]) -> Result<Self, InvalidInput> {
        check_terms(self.model, terms)?;
        self.check_empty("the joint terms")?;
        self.terms = terms.to_vec();
        let mut nominal = inertial_parameters(self.model);
        nominal.extend(terms.iter().map(|term| term.nominal(self.model)));
        self.nominal = DVector::from_vec(nominal);
        Ok(self)
    }

    /// States the standard deviation of the noise of each torque \[N·m or N\]. Rows are divided by it, so
    /// precise sensors count more. An infinite one leaves out the coordinate, whose torque is then ignored:
    /// a legged robot's joints without torque sensors, for example.
    ///
    /// # Errors
    /// [`InvalidInput`] if there are not nv positive numbers, or the record has samples.
    pub fn with_noise(mut self, deviations: &[f64]) -> Result<Self, InvalidInput> {
        self.check_empty("the noise")?;
        check_noise(deviations, self.model.nv())?;
        self.deviations = deviations.to_vec();
        Ok(self)
    }

    /// Adds a state with its acceleration and the torque measured there.
    ///
    /// # Errors
    /// [`InvalidInput`] with the number of the sample.
    pub fn push(&mut self, q: &[f64], v: &[f64], a: &[f64], tau: &[f64]) -> Result<(), InvalidInput> {
        self.push_with_wrenches(q, v, a, tau, &[])
    }

    /// Adds a state with its acceleration, the torque, and the external wrenches measured there: contact
    /// forces of feet, for example. W x = τ + Σ Jᵀ f.
    ///
    /// # Errors
    /// [`InvalidInput`] with the number of the sample.
    ///
    /// # Panics
    /// If a frame belongs to another robot.
    #[track_caller]
    pub fn push_with_wrenches(
        &mut self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        tau: &[f64],
        wrenches: &[FrameWrench],
    ) -> Result<(), InvalidInput> {
        let sample = self.samples;
        let bad_sample = |error: InvalidInput| {
            let quantity = format!("sample {sample}: {}", error.quantity);
            error.of(quantity)
        };
        let model = self.model;
        check_configuration(model, q).map_err(bad_sample)?;
        let mut measured = tau.to_vec();
        for (tau, _) in measured.iter_mut().zip(&self.deviations).filter(|(_, noise)| noise.is_infinite()) {
            *tau = 0.0;
        }
        for (name, values) in [("v", v), ("a", a), ("tau", &measured)] {
            check_vector(model, name, values).map_err(bad_sample)?;
        }
        let columns = self.columns();
        let mut rows = vec![0.0; model.nv() * columns];
        write_rows(model, &mut self.workspace, &self.terms, [q, v, a], &mut rows);
        let rows = DMatrix::from_row_slice(model.nv(), columns, &rows);
        let torques = DVector::from_vec(measured) - self.known_forces(&rows, [q, v, a], wrenches);
        check_result("W x − τ", rows.iter().chain(torques.iter())).map_err(bad_sample)?;
        self.samples += 1;
        for (i, &deviation) in self.deviations.iter().enumerate().filter(|(_, noise)| noise.is_finite()) {
            self.rows.extend(rows.row(i).iter().map(|entry| entry / deviation));
            self.torques.push(torques[i] / deviation);
            self.coordinates.push(i);
        }
        Ok(())
    }

    /// The number of samples.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Whether the record is empty.
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// The names of x: `link.m`, ..., then `joint.damping` and the like.
    pub fn parameter_names(&self) -> Vec<String> {
        parameter_names(self.model, &self.terms)
    }

    /// The joint terms that are identified.
    pub fn terms(&self) -> &[JointTerm] {
        &self.terms
    }

    /// x of the robot as described.
    pub fn nominal(&self) -> &[f64] {
        self.nominal.as_slice()
    }

    /// The root mean square of τ − W x of each coordinate \[N·m or N\]; NaN if it is not measured.
    ///
    /// # Panics
    /// If x has the wrong length.
    #[track_caller]
    pub fn residuals(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.columns(), "the length of x");
        let x = DVector::from_column_slice(x);
        self.residuals_of(&(DVector::from_column_slice(&self.torques) - self.stacked() * x))
    }

    /// The root mean square of each coordinate, for differences in units of the noise.
    pub(super) fn residuals_of(&self, left: &DVector<f64>) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.model.nv()];
        for (left, &coordinate) in left.iter().zip(&self.coordinates) {
            sums[coordinate].0 += left * left;
            sums[coordinate].1 += 1.0;
        }
        sums.iter().zip(&self.deviations).map(|((sum, count), noise)| (sum / count).sqrt() * noise).collect()
    }

    /// The number of entries of x.
    pub(super) fn columns(&self) -> usize {
        self.nominal.len()
    }

    /// The number of moving links.
    pub(super) fn links(&self) -> usize {
        (self.nominal.len() - self.terms.len()) / PARAMETERS_PER_LINK
    }

    /// W, with one block of the measured rows per sample.
    pub(super) fn stacked(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.torques.len(), self.columns(), &self.rows)
    }

    /// The forces that do not depend on x: the difference of inverse dynamics and W x at the nominal x.
    fn known_forces(
        &mut self,
        rows: &DMatrix<f64>,
        [q, v, a]: [&[f64]; 3],
        wrenches: &[FrameWrench],
    ) -> DVector<f64> {
        let nv = self.model.nv();
        let mut known = DVector::zeros(nv);
        let out = known.as_mut_slice();
        inverse_dynamics_with_wrenches(self.model, &mut self.workspace, q, v, a, wrenches, out);
        if self.with_dissipation {
            let mut friction = DVector::zeros(nv);
            dissipation(self.model, v, friction.as_mut_slice());
            known += friction;
        }
        let mut present = self.nominal.clone();
        let inertial = self.columns() - self.terms.len();
        for (k, term) in self.terms.iter().enumerate() {
            if term.is_dissipation() && !self.with_dissipation {
                present[inertial + k] = 0.0;
            }
        }
        known - rows * present
    }

    fn check_empty(&self, quantity: &str) -> Result<(), InvalidInput> {
        if self.is_empty() {
            return Ok(());
        }
        Err(InvalidInput::unmet(quantity, "must be stated before the first sample"))
    }
}

/// Writes the nv rows of W at one state, row-major: Y(q,v,a), then one column for each joint term.
pub(super) fn write_rows<S: Exponential>(
    model: &Model,
    workspace: &mut Workspace<S>,
    terms: &[JointTerm],
    [q, v, a]: [&[S]; 3],
    rows: &mut [S],
) {
    let inertial = PARAMETERS_PER_LINK * model.moving_links().count();
    if terms.is_empty() {
        return joint_torque_regressor(model, workspace, q, v, a, rows);
    }
    let columns = inertial + terms.len();
    let mut regressor = vec![S::zero(); model.nv() * inertial];
    joint_torque_regressor(model, workspace, q, v, a, &mut regressor);
    rows.fill(S::zero());
    for (row, own) in rows.chunks_exact_mut(columns).zip(regressor.chunks_exact(inertial.max(1))) {
        row[..inertial].copy_from_slice(own);
    }
    for (k, term) in terms.iter().enumerate() {
        let coordinate = term.coordinate(model);
        rows[coordinate * columns + inertial + k] = term.factor(v[coordinate], a[coordinate]);
    }
}

/// Checks that there are nv positive standard deviations, which may be infinite.
pub(super) fn check_noise(deviations: &[f64], nv: usize) -> Result<(), InvalidInput> {
    if let Some(bad) = deviations.iter().find(|deviation| deviation.is_nan() || **deviation <= 0.0) {
        return Err(InvalidInput::out_of_range("the noise", *bad, "", "positive"));
    }
    if deviations.len() != nv {
        return Err(InvalidInput::unmet("the noise", "must have nv entries"));
    }
    Ok(())
}
