//! The payload at a frame, estimated while the robot moves: recursive least squares in square-root form.
//!
//! A body fixed to a frame adds Y_p(q,v,a) π_p to the torques, with its ten parameters in the frame's axes.
//! The link that carries the frame has J_link = T J_frame Tᵀ, with T the pose of the frame in the link. So
//! Y_p are the link's ten columns of the regressor times a constant 10×10 matrix.
//!
//! The information matrix of the past is RᵀR. Rotations merge each new row into the triangle R, which keeps
//! twice the digits of the information matrix itself. **(Bierman, *Factorization methods for discrete
//! sequential estimation* (1977), ch. 4)**
//!
//! Forgetting by λ multiplies the information of the past by λ, and adds 1 − λ of the prior's. The weights
//! then sum to a window of 1/(1 − λ) samples, and directions without excitation return to the prior. Without
//! the second part their covariance would grow without bound.

use core::borrow::Borrow;

use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3};
use robot_dynamics_core::{
    FrameId, Model, PARAMETERS_PER_LINK, Workspace, check_configuration, check_vector, dissipation,
    inverse_dynamics, joint_torque_regressor,
};
use robot_dynamics_number::{InvalidInput, check_finite};

use super::entropic::parameters_of;
use super::pseudo_inertia;
use super::record::check_noise;

/// The rows of R with the right-hand side in the last column.
type Triangle = [[f64; PARAMETERS_PER_LINK + 1]; PARAMETERS_PER_LINK];

/// The standard deviations of a prior that states nothing: 100 kg, 100 kg·m, 100 kg·m².
const VAGUE: f64 = 100.0;

/// The estimator of a payload at a frame.
///
/// ```
/// use robot_dynamics::control::identification::PayloadEstimator;
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, MassProperties, Pose, pendulum};
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut loaded = pendulum(2.0, 0.5);
/// let body = MassProperties::new(0.7, [0.1, 0.0, 0.0].into(), nalgebra::Matrix3::identity() * 0.01)?;
/// loaded.links.push(LinkDescription::new("load", body));
/// let at = Pose::from_translation([0.5, 0.0, 0.0]); // the tip
/// loaded.joints.push(JointDescription::new("grip", JointKind::Fixed, "rod", "load", at));
/// let loaded = Model::new(loaded)?;
///
/// let mut estimator = PayloadEstimator::new(&model, model.frame_named("tip")?, &[0.01])?;
/// for i in 0..200 {
///     let t = 0.1 * f64::from(i);
///     let (q, v, a) = ([t.sin()], [t.cos()], [-t.sin()]);
///     estimator.push(&q, &v, &a, loaded.inverse_dynamics(&q, &v, &a)?.as_slice())?; // in practice: measured
/// }
/// // One joint shows the first moment about its axis: 0.7 kg · (0.5 m + 0.1 m).
/// let [mass, first_moment, ..] = estimator.parameters();
/// assert!((0.5 * mass + first_moment - 0.42).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PayloadEstimator<M: Borrow<Model>> {
    robot: M,
    workspace: Workspace,
    /// The index of the moving link that carries the frame.
    link: usize,
    link_from_frame: SMatrix<f64, PARAMETERS_PER_LINK, PARAMETERS_PER_LINK>,
    noise: Vec<f64>,
    offsets: Vec<f64>,
    with_dissipation: bool,
    forgetting: f64,
    prior: [f64; PARAMETERS_PER_LINK],
    prior_deviations: [f64; PARAMETERS_PER_LINK],
    triangle: Triangle,
    samples: usize,
    regressor: Vec<f64>,
    expected: Vec<f64>,
    friction: Vec<f64>,
}

impl<'a> PayloadEstimator<&'a Model> {
    /// The estimator of a body fixed to a frame, along the frame's axes. `noise` lists the standard
    /// deviation of each torque \[N·m or N\]; an infinite one leaves out the coordinate.
    ///
    /// # Errors
    /// [`InvalidInput`] if the frame is fixed to the world, or the noise is not nv positive numbers.
    ///
    /// # Panics
    /// If the frame belongs to another robot.
    #[track_caller]
    pub fn new(model: &'a Model, frame: FrameId, noise: &[f64]) -> Result<Self, InvalidInput> {
        Self::owning(model, frame, noise)
    }
}

impl<M: Borrow<Model>> PayloadEstimator<M> {
    /// [`new`](PayloadEstimator::new) with a robot that the estimator stores: an `Arc<Model>`, a `Model`, or
    /// a reference.
    ///
    /// # Errors
    /// As of [`new`](PayloadEstimator::new).
    ///
    /// # Panics
    /// If the frame belongs to another robot.
    #[track_caller]
    pub fn owning(robot: M, frame: FrameId, noise: &[f64]) -> Result<Self, InvalidInput> {
        let model: &Model = robot.borrow();
        let nv = model.nv();
        let own = model.frame_of(frame);
        let carrier = |name: &str| model.frame(name).map(|link| model.frame_of(link));
        let carries = |name: &str| own.body.is_some() && carrier(name).is_some_and(|f| f.body == own.body);
        let found = model.moving_links().enumerate().find(|(_, name)| carries(name));
        let Some((link, carrier)) = found.and_then(|(link, name)| Some((link, carrier(name)?))) else {
            return Err(InvalidInput::unmet(
                format!("the frame `{}`", own.name),
                "must be fixed to a moving link",
            ));
        };
        check_noise(noise, nv)?;
        let pose = carrier.body_from_frame.inverse().compose(&own.body_from_frame);
        let mut transform = Matrix4::identity();
        for i in 0..3 {
            for j in 0..3 {
                transform[(i, j)] = pose.rotation[i][j];
            }
            transform[(i, 3)] = pose.translation[i];
        }
        let mut link_from_frame = SMatrix::<f64, PARAMETERS_PER_LINK, PARAMETERS_PER_LINK>::zeros();
        for k in 0..PARAMETERS_PER_LINK {
            let mut unit = [0.0; PARAMETERS_PER_LINK];
            unit[k] = 1.0;
            let moved = transform * pseudo_inertia(&unit) * transform.transpose();
            link_from_frame.column_mut(k).copy_from_slice(&parameters_of(&moved));
        }
        let regressor = vec![0.0; nv * PARAMETERS_PER_LINK * model.moving_links().count()];
        let mut estimator = Self {
            workspace: Workspace::new(model),
            robot,
            link,
            link_from_frame,
            noise: noise.to_vec(),
            offsets: vec![0.0; nv],
            with_dissipation: false,
            forgetting: 1.0,
            prior: [0.0; PARAMETERS_PER_LINK],
            prior_deviations: [VAGUE; PARAMETERS_PER_LINK],
            triangle: [[0.0; PARAMETERS_PER_LINK + 1]; PARAMETERS_PER_LINK],
            samples: 0,
            regressor,
            expected: vec![0.0; nv],
            friction: vec![0.0; nv],
        };
        estimator.reset();
        Ok(estimator)
    }

    /// Multiplies the information of the past by λ at every sample: a window of 1/(1 − λ) samples. 1 by
    /// default, which forgets nothing.
    ///
    /// # Errors
    /// [`InvalidInput`] if λ is not in (0, 1].
    pub fn with_forgetting(mut self, forgetting: f64) -> Result<Self, InvalidInput> {
        if !(forgetting > 0.0 && forgetting <= 1.0) {
            let requirement = "above 0 and at most 1";
            return Err(InvalidInput::out_of_range("the forgetting factor", forgetting, "", requirement));
        }
        self.forgetting = forgetting;
        Ok(self)
    }

    /// Starts from a prior: parameters and their standard deviations, in the order m, m c, Ixx, Ixy, Iyy,
    /// Ixz, Iyz, Izz. By default they are 0 with deviations of 100 kg, 100 kg·m and 100 kg·m². Forgets all
    /// samples.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number is not finite, or a deviation is not positive.
    pub fn with_prior(
        mut self,
        parameters: [f64; PARAMETERS_PER_LINK],
        deviations: [f64; PARAMETERS_PER_LINK],
    ) -> Result<Self, InvalidInput> {
        check_finite("the prior", &parameters)?;
        check_finite("the prior's deviations", &deviations)?;
        if let Some(bad) = deviations.iter().find(|deviation| **deviation <= 0.0) {
            return Err(InvalidInput::out_of_range("the prior's deviations", *bad, "", "positive"));
        }
        (self.prior, self.prior_deviations) = (parameters, deviations);
        self.reset();
        Ok(self)
    }

    /// Subtracts the damping and friction of the model's joints from the torques, and constant offsets
    /// \[N·m or N\].
    ///
    /// # Errors
    /// [`InvalidInput`] if there are not nv finite offsets.
    pub fn with_dissipation_and_offsets(mut self, offsets: &[f64]) -> Result<Self, InvalidInput> {
        check_vector(self.robot.borrow(), "the offsets", offsets)?;
        self.with_dissipation = true;
        self.offsets.copy_from_slice(offsets);
        Ok(self)
    }

    /// Returns to the prior, for example when the robot puts the payload down.
    pub fn reset(&mut self) {
        self.triangle = [[0.0; PARAMETERS_PER_LINK + 1]; PARAMETERS_PER_LINK];
        for (i, row) in self.triangle.iter_mut().enumerate() {
            row[i] = self.prior_deviations[i].recip();
            row[PARAMETERS_PER_LINK] = self.prior[i] / self.prior_deviations[i];
        }
        self.samples = 0;
    }

    /// Adds a state with its acceleration and the torque measured there. It does not allocate memory.
    ///
    /// # Errors
    /// [`InvalidInput`] if a vector has the wrong length or an entry that is not finite; nothing is added.
    /// Torques of coordinates with infinite noise are ignored.
    pub fn push(&mut self, q: &[f64], v: &[f64], a: &[f64], tau: &[f64]) -> Result<(), InvalidInput> {
        let model: &Model = self.robot.borrow();
        check_configuration(model, q)?;
        for (name, values) in [("v", v), ("a", a)] {
            check_vector(model, name, values)?;
        }
        let ignored = |i: usize| self.noise.get(i).is_some_and(|noise| noise.is_infinite());
        if tau.len() != model.nv() || (0..tau.len()).any(|i| !tau[i].is_finite() && !ignored(i)) {
            check_vector(model, "tau", tau)?;
        }
        inverse_dynamics(model, &mut self.workspace, q, v, a, &mut self.expected);
        if self.with_dissipation {
            dissipation(model, v, &mut self.friction);
        }
        joint_torque_regressor(model, &mut self.workspace, q, v, a, &mut self.regressor);
        let columns = self.regressor.len() / model.nv();
        self.forget();
        for i in 0..tau.len() {
            if self.noise[i].is_infinite() {
                continue;
            }
            let link = &self.regressor[i * columns + self.link * PARAMETERS_PER_LINK..];
            let left = tau[i] - self.expected[i] - self.friction[i] - self.offsets[i];
            let mut row = [0.0; PARAMETERS_PER_LINK + 1];
            for (k, entry) in row[..PARAMETERS_PER_LINK].iter_mut().enumerate() {
                let map = self.link_from_frame.column(k);
                *entry = map.iter().zip(link).map(|(map, link)| map * link).sum::<f64>() / self.noise[i];
            }
            row[PARAMETERS_PER_LINK] = left / self.noise[i];
            merge(&mut self.triangle, row);
        }
        self.samples += 1;
        Ok(())
    }

    /// The number of samples since the last reset.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// The ten parameters about the frame's origin and along its axes: m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz
    /// \[kg, kg·m, kg·m²\]. It does not allocate memory.
    pub fn parameters(&self) -> [f64; PARAMETERS_PER_LINK] {
        let mut x = [0.0; PARAMETERS_PER_LINK];
        for i in (0..PARAMETERS_PER_LINK).rev() {
            let row = &self.triangle[i];
            let later: f64 = (i + 1..PARAMETERS_PER_LINK).map(|k| row[k] * x[k]).sum();
            x[i] = (row[PARAMETERS_PER_LINK] - later) / row[i];
        }
        x
    }

    /// The covariance of the parameters. It does not allocate memory.
    pub fn covariance(&self) -> SMatrix<f64, PARAMETERS_PER_LINK, PARAMETERS_PER_LINK> {
        // R⁻¹, column by column.
        let mut inverse = SMatrix::<f64, PARAMETERS_PER_LINK, PARAMETERS_PER_LINK>::zeros();
        for j in 0..PARAMETERS_PER_LINK {
            for i in (0..=j).rev() {
                let row = &self.triangle[i];
                let later: f64 = (i + 1..=j).map(|k| row[k] * inverse[(k, j)]).sum();
                inverse[(i, j)] = (f64::from(i == j) - later) / row[i];
            }
        }
        inverse * inverse.transpose()
    }

    /// The mass, the centre of mass in the frame, the inertia about the centre of mass, and their standard
    /// deviations. It does not allocate memory.
    pub fn payload(&self) -> Payload {
        let parameters = self.parameters();
        let covariance = self.covariance();
        let [mass, hx, hy, hz, xx, xy, yy, xz, yz, zz] = parameters;
        let center = Vector3::new(hx, hy, hz) / mass;
        let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let shift = Matrix3::identity() * center.norm_squared() - center * center.transpose();
        // c = h/m: δc = (δh − c δm)/m.
        let variance = |i: usize| {
            let own = covariance[(i + 1, i + 1)] - 2.0 * center[i] * covariance[(0, i + 1)];
            (own + center[i] * center[i] * covariance[(0, 0)]).max(0.0)
        };
        Payload {
            mass,
            center_of_mass: center.into(),
            inertia: about_origin - shift * mass,
            mass_deviation: covariance[(0, 0)].sqrt(),
            center_of_mass_deviation: [0, 1, 2].map(|i| variance(i).sqrt() / mass.abs()),
        }
    }

    /// R ← √λ R, merged with √(1 − λ) of the prior.
    fn forget(&mut self) {
        let forgetting = self.forgetting;
        if forgetting >= 1.0 {
            return;
        }
        self.triangle.iter_mut().flatten().for_each(|entry| *entry *= forgetting.sqrt());
        for i in 0..PARAMETERS_PER_LINK {
            let mut row = [0.0; PARAMETERS_PER_LINK + 1];
            row[i] = (1.0 - forgetting).sqrt() / self.prior_deviations[i];
            row[PARAMETERS_PER_LINK] = row[i] * self.prior[i];
            merge(&mut self.triangle, row);
        }
    }
}

/// Merges a row into the triangle by plane rotations.
fn merge(triangle: &mut Triangle, mut row: [f64; PARAMETERS_PER_LINK + 1]) {
    for (i, own) in triangle.iter_mut().enumerate() {
        if row[i] == 0.0 {
            continue;
        }
        let length = own[i].hypot(row[i]);
        let (cosine, sine) = (own[i] / length, row[i] / length);
        for (own, new) in own.iter_mut().zip(&mut row).skip(i) {
            (*own, *new) = (cosine * *own + sine * *new, cosine * *new - sine * *own);
        }
    }
}

/// A body at a frame, with standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Payload {
    /// The mass \[kg\].
    pub mass: f64,
    /// The centre of mass in the frame \[m\].
    pub center_of_mass: [f64; 3],
    /// The inertia about the centre of mass, along the frame's axes \[kg·m²\].
    pub inertia: Matrix3<f64>,
    /// The standard deviation of the mass \[kg\].
    pub mass_deviation: f64,
    /// The standard deviations of the centre of mass \[m\].
    pub center_of_mass_deviation: [f64; 3],
}
