//! The objectives of tasks.

use robot_dynamics_core::{FrameId, Model, check_configuration};
use robot_dynamics_description::Pose;
use robot_dynamics_number::{InvalidInput, check_finite, check_number};
use robot_dynamics_simulation::{ConstraintSet, SpatialAxis};

use crate::inverse_kinematics::FrameTarget;
use crate::inverse_kinematics::error::check_target;

/// The quantity that a task brings to zero: an error e(q) with ė = J v.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum KinematicObjective {
    /// The pose of a frame relative to the world or to another frame, T = (R, p), with the target T\* = (R\*,
    /// p\*): e = (R\*ᵀ(p − p\*), log(R\*ᵀR)), along the axes of the target \[m, rad\].
    Pose {
        /// The frame.
        frame: FrameId,
        /// The frame to which the target is relative; `None` for the world.
        reference: Option<FrameId>,
        /// T\*.
        target: Pose,
        /// The weights of x, y, z, rx, ry and rz along the axes of the target; zero leaves a row free.
        weights: [f64; 6],
    },
    /// The centre of mass of the moving links: e = c − c\* \[m\].
    CenterOfMass {
        /// c\* \[m\].
        target: [f64; 3],
        /// The weights of x, y and z; zero leaves a row free.
        weights: [f64; 3],
    },
    /// The configuration: e = q ⊖ q\* of the coordinates with motors \[rad, m\].
    Posture {
        /// q\*, nq numbers; those of coordinates without motors are ignored.
        target: Vec<f64>,
    },
    /// An axis of a frame points at a point: e = a − d, with the axis a and the direction d from the frame's
    /// origin to the point. Both are unit vectors in the world, and |e| = 2 sin ½θ for the angle θ between
    /// them.
    LookAt {
        /// The frame.
        frame: FrameId,
        /// The axis, a unit vector along the frame's axes.
        axis: [f64; 3],
        /// The point in the world \[m\].
        point: [f64; 3],
    },
    /// Relations between coordinates and closed loops: e = φ(q) of the rows that have φ.
    Constraints(ConstraintSet),
}

impl KinematicObjective {
    /// The pose or the position of a frame in the world, with the weight 1 for each row of the target.
    pub fn pose(frame: FrameId, target: impl Into<FrameTarget>) -> Self {
        let (target, turn) = match target.into() {
            FrameTarget::Pose(target) => (target, 1.0),
            FrameTarget::Position(position) => (Pose::from_translation(position), 0.0),
        };
        Self::Pose { frame, reference: None, target, weights: [1.0, 1.0, 1.0, turn, turn, turn] }
    }

    /// The pose or the position of a frame relative to another frame.
    pub fn relative_pose(frame: FrameId, reference: FrameId, target: impl Into<FrameTarget>) -> Self {
        match Self::pose(frame, target) {
            Self::Pose { frame, target, weights, .. } => {
                Self::Pose { frame, reference: Some(reference), target, weights }
            }
            other => other,
        }
    }

    /// Keeps these rows of a pose, with their weights, and leaves the others free. Other objectives do not
    /// change.
    #[must_use]
    pub fn with_axes(mut self, axes: &[SpatialAxis]) -> Self {
        if let Self::Pose { weights, .. } = &mut self {
            for (k, weight) in weights.iter_mut().enumerate() {
                let is_kept = axes.iter().any(|axis| *axis as usize == k);
                *weight = if is_kept { weight.max(1.0) } else { 0.0 };
            }
        }
        self
    }

    /// The centre of mass at a point of the world \[m\].
    pub fn center_of_mass(target: [f64; 3]) -> Self {
        Self::CenterOfMass { target, weights: [1.0; 3] }
    }

    /// The frames of the objective.
    pub(super) fn frames(&self) -> impl Iterator<Item = FrameId> {
        let (frame, reference) = match self {
            Self::Pose { frame, reference, .. } => (Some(*frame), *reference),
            Self::LookAt { frame, .. } => (Some(*frame), None),
            _ => (None, None),
        };
        frame.into_iter().chain(reference)
    }

    /// The most rows.
    pub(super) fn most_rows(&self, nv: usize) -> usize {
        match self {
            Self::Pose { .. } => 6,
            Self::CenterOfMass { .. } | Self::LookAt { .. } => 3,
            Self::Posture { .. } => nv,
            Self::Constraints(set) => set.len(),
        }
    }

    /// The objective in words, for errors.
    pub(super) fn description(&self, model: &Model) -> String {
        let name = |frame: &FrameId| &model.frame_of(*frame).name;
        match self {
            Self::Pose { frame, reference: None, .. } => format!("frame `{}`", name(frame)),
            Self::Pose { frame, reference: Some(reference), .. } => {
                format!("frame `{}` relative to `{}`", name(frame), name(reference))
            }
            Self::CenterOfMass { .. } => "the centre of mass".to_owned(),
            Self::Posture { .. } => "the posture".to_owned(),
            Self::LookAt { frame, .. } => format!("the axis of frame `{}`", name(frame)),
            Self::Constraints(set) => {
                let names: Vec<_> = set.constraints().map(|(name, _)| format!("`{name}`")).collect();
                format!("the constraints {}", names.join(", "))
            }
        }
    }

    /// Checks the numbers.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        match self {
            Self::Pose { target, weights, .. } => {
                check_target(&FrameTarget::Pose(*target))?;
                weights.iter().try_for_each(|weight| check_weight(*weight))
            }
            Self::CenterOfMass { target, weights } => {
                check_finite("the target of the centre of mass", target)?;
                weights.iter().try_for_each(|weight| check_weight(*weight))
            }
            Self::Posture { target } => {
                check_configuration(model, target).map_err(|error| error.of("the posture's q"))
            }
            Self::LookAt { axis, point, .. } => {
                check_finite("the point to look at", point)?;
                check_finite("the axis", axis)?;
                let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                if (length - 1.0).abs() > 1e-6 {
                    return Err(InvalidInput::unmet("the axis", "must be a unit vector"));
                }
                Ok(())
            }
            Self::Constraints(_) => Ok(()),
        }
    }
}

/// Checks that a weight is finite and not negative.
pub(super) fn check_weight(weight: f64) -> Result<(), InvalidInput> {
    check_number("the weight", weight)?;
    if weight < 0.0 {
        return Err(InvalidInput::out_of_range("the weight", weight, "", "zero or positive"));
    }
    Ok(())
}

/// An objective with its weight, level, gain and damping.
#[derive(Clone, Debug, PartialEq)]
pub struct KinematicTask {
    /// The objective.
    pub objective: KinematicObjective,
    /// The factor of |e|²; with zero the task has no influence.
    pub weight: f64,
    /// Tasks at levels with larger numbers do not change those before them.
    pub level: usize,
    /// α: the share of e that one step removes, above 0 and at most 1.
    pub gain: f64,
    /// μ of the task's Levenberg–Marquardt damping, μ w |e|² \|Δq\|².
    pub damping: f64,
}

impl KinematicTask {
    /// A task at level 0 with weight 1, gain 1 and without damping of its own.
    pub fn new(objective: KinematicObjective) -> Self {
        Self { objective, weight: 1.0, level: 0, gain: 1.0, damping: 0.0 }
    }

    /// Sets the weight.
    #[must_use]
    pub fn with_weight(self, weight: f64) -> Self {
        Self { weight, ..self }
    }

    /// Sets the level.
    #[must_use]
    pub fn with_level(self, level: usize) -> Self {
        Self { level, ..self }
    }

    /// Sets α.
    #[must_use]
    pub fn with_gain(self, gain: f64) -> Self {
        Self { gain, ..self }
    }

    /// Sets μ.
    #[must_use]
    pub fn with_damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// Checks the numbers.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        self.objective.check(model)?;
        check_weight(self.weight)?;
        check_weight(self.damping).map_err(|error| error.of("the damping"))?;
        let is_share = self.gain > 0.0 && self.gain <= 1.0;
        if is_share {
            Ok(())
        } else {
            Err(InvalidInput::out_of_range("the gain", self.gain, "", "above 0 and at most 1"))
        }
    }
}

impl From<KinematicObjective> for KinematicTask {
    fn from(objective: KinematicObjective) -> Self {
        Self::new(objective)
    }
}
