//! Parameters of a joint on which its torque depends linearly: damping, friction, armature, offset.

use robot_dynamics_core::{Joint, Model};
use robot_dynamics_description::JointKind;
use robot_dynamics_number::{Dual, InvalidInput, Scalar, check_positive};

/// A force of a joint that is linear in one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointTermKind {
    /// Viscous friction b v: b in N·m·s/rad or N·s/m.
    #[doc(alias = "viscous friction")]
    Damping,
    /// Coulomb friction F sign v: F in N·m or N.
    #[doc(alias = "Coulomb friction")]
    Friction,
    /// Inertia of the rotor behind the gear, I a: I in kg·m² or kg.
    #[doc(alias = "rotor inertia")]
    Armature,
    /// A constant torque, for example the zero error of the sensor \[N·m or N\].
    Offset,
    /// Additional friction at low speed, ΔF sign v exp(−(v/v_s)²): ΔF in N·m or N.
    Stribeck {
        /// v_s \[rad/s or m/s\]; [`identify_nonlinear`](super::identify_nonlinear) identifies it.
        velocity: f64,
    },
}

impl JointTermKind {
    /// The kinds without constants of their own.
    pub const ALL: [Self; 4] = [Self::Damping, Self::Friction, Self::Armature, Self::Offset];

    /// Its name: `damping`, `friction`, `armature`, `offset` or `stribeck`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Damping => "damping",
            Self::Friction => "friction",
            Self::Armature => "armature",
            Self::Offset => "offset",
            Self::Stribeck { .. } => "stribeck",
        }
    }
}

/// A parameter of a joint of one degree of freedom that is identified together with the inertial parameters.
///
/// ```
/// use robot_dynamics::control::identification::{JointTerm, JointTermKind};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let terms = JointTerm::of_all(&model, &[JointTermKind::Damping, JointTermKind::Offset]);
/// let names: Vec<String> = terms.iter().map(|term| term.label(&model)).collect();
/// assert_eq!(names, ["hinge.damping", "hinge.offset"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTerm {
    /// The index of the joint in [`Model::joints`].
    pub joint: usize,
    /// Its force.
    pub kind: JointTermKind,
}

impl JointTerm {
    /// The terms of these kinds of all joints of one degree of freedom, one kind after another.
    pub fn of_all(model: &Model, kinds: &[JointTermKind]) -> Vec<Self> {
        let joints = || model.joints().iter().filter(|joint| joint.nv == 1);
        kinds.iter().flat_map(|&kind| joints().map(move |joint| Self { joint: joint.index, kind })).collect()
    }

    /// The name of its parameter, for example `elbow.damping`.
    ///
    /// # Panics
    /// If the robot does not have the joint.
    #[track_caller]
    pub fn label(self, model: &Model) -> String {
        format!("{}.{}", model.joints()[self.joint].name, self.kind.name())
    }

    /// The value of the robot's description; 0 for an offset and for Stribeck friction.
    ///
    /// # Panics
    /// If the robot does not have the joint.
    #[track_caller]
    pub fn nominal(self, model: &Model) -> f64 {
        let passive = &model.joints()[self.joint].passive;
        match self.kind {
            JointTermKind::Damping => passive.damping,
            JointTermKind::Friction => passive.friction,
            JointTermKind::Armature => passive.armature,
            JointTermKind::Offset | JointTermKind::Stribeck { .. } => 0.0,
        }
    }

    /// Its coordinate in v.
    pub(super) fn coordinate(self, model: &Model) -> usize {
        model.joints()[self.joint].v_index
    }

    /// The torque for a parameter of 1, at the rate and the acceleration of its coordinate.
    pub(super) fn factor<S: Exponential>(self, v: S, a: S) -> S {
        match self.kind {
            JointTermKind::Damping => v,
            JointTermKind::Friction => v.signum0(),
            JointTermKind::Armature => a,
            JointTermKind::Offset => S::one(),
            JointTermKind::Stribeck { velocity } => {
                let ratio = v.scale(1.0 / velocity);
                v.signum0() * (ratio * ratio).scale(-1.0).exponential()
            }
        }
    }

    /// Whether it is a part of damping and friction.
    pub(super) fn is_dissipation(self) -> bool {
        matches!(self.kind, JointTermKind::Damping | JointTermKind::Friction)
    }
}

/// Checks that each term is of a joint with one degree of freedom, and is named once.
pub(super) fn check_terms(model: &Model, terms: &[JointTerm]) -> Result<(), InvalidInput> {
    let one_dof = |joint: &Joint| joint.nv == 1 && joint.kind != JointKind::Fixed;
    for (i, term) in terms.iter().enumerate() {
        if !model.joints().get(term.joint).is_some_and(one_dof) {
            return Err(InvalidInput::unmet("a joint term", "must be of a joint with one degree of freedom"));
        }
        if terms[..i].contains(term) {
            let quantity = format!("the joint term `{}`", term.label(model));
            return Err(InvalidInput::unmet(quantity, "must be named once"));
        }
        if let JointTermKind::Stribeck { velocity } = term.kind {
            check_positive("a Stribeck velocity", velocity, "")?;
        }
    }
    Ok(())
}

/// Numbers with an exponential function, which Stribeck friction needs.
pub(super) trait Exponential: Scalar {
    /// exp x.
    fn exponential(self) -> Self;
}

impl Exponential for f64 {
    fn exponential(self) -> Self {
        self.exp()
    }
}

impl<const N: usize> Exponential for Dual<f64, N> {
    fn exponential(self) -> Self {
        let value = self.value.exp();
        Self { value, gradient: self.gradient.map(|own| own * value) }
    }
}
