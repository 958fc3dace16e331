//! Reads `<joint>` and `<freejoint>`: type, placement, axis, limits and passive forces.

use nalgebra::{Isometry3, Point3, Vector3};
use robot_dynamics_description::{JointSolverImpedance, Limits, PassiveForces, PolynomialStiffnessDamping};

use crate::element::Element;
use crate::reader::Reader;

/// The type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointType {
    Hinge,
    Slide,
    Ball,
    Free,
}

impl JointType {
    /// The name of the type in MJCF.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Hinge => "hinge",
            Self::Slide => "slide",
            Self::Ball => "ball",
            Self::Free => "free",
        }
    }

    /// The number of position coordinates.
    pub(crate) fn positions(self) -> usize {
        match self {
            Self::Hinge | Self::Slide => 1,
            Self::Ball => 4,
            Self::Free => 7,
        }
    }

    /// The number of degrees of freedom.
    pub(crate) fn dof_count(self) -> usize {
        match self {
            Self::Hinge | Self::Slide => 1,
            Self::Ball => 3,
            Self::Free => 6,
        }
    }
}

/// A joint between a body and its parent.
pub(crate) struct Joint {
    /// Empty for a joint without a name.
    pub(crate) name: String,
    pub(crate) element: Element,
    pub(crate) motion: JointType,
    /// The fixed point of the rotation, in the frame of the body \[m\].
    pub(crate) anchor: Vector3<f64>,
    /// The unit axis, in the frame of the body.
    pub(crate) axis: Vector3<f64>,
    /// q in the pose of the file \[rad or m\].
    pub(crate) reference: f64,
    pub(crate) limits: Limits,
    pub(crate) passive: PassiveForces,
    /// The stiffness of the spring of a ball or free joint.
    pub(crate) placement_stiffness: f64,
    pub(crate) higher_terms: PolynomialStiffnessDamping,
    /// The largest elastic stretch of the spring of a hinge or slide joint; 0 if it never yields.
    pub(crate) spring_yield: f64,
    /// Bounds on the total force of its actuators \[N·m or N\].
    pub(crate) actuator_force_range: [f64; 2],
    /// Whether the actuators provide the gravity compensation.
    pub(crate) actuator_compensates_gravity: bool,
    /// The softness of limits and friction.
    pub(crate) softness: JointSolverImpedance,
    /// `springdamper`: time constant \[s\] and damping ratio, which determine stiffness and damping.
    pub(crate) spring_damper: Option<[f64; 2]>,
    /// Whether the frame of a free body is aligned with its inertia; `None` if the file leaves it to
    /// `alignfree`.
    pub(crate) align: Option<bool>,
}

impl Reader<'_> {
    /// Reads a `<freejoint>`, which has no defaults.
    pub(crate) fn free_joint(&mut self, element: &Element, name: String) -> Joint {
        let align = self.word(element, "align", &["false", "true", "auto"]);
        Joint {
            name,
            motion: JointType::Free,
            anchor: Vector3::zeros(),
            axis: Vector3::z(),
            reference: 0.0,
            limits: Limits::default(),
            passive: PassiveForces::default(),
            placement_stiffness: 0.0,
            higher_terms: PolynomialStiffnessDamping::default(),
            spring_yield: 0.0,
            actuator_force_range: [f64::NEG_INFINITY, f64::INFINITY],
            actuator_compensates_gravity: false,
            softness: JointSolverImpedance::default(),
            spring_damper: None,
            align: align.and_then(|word| match word {
                "true" => Some(true),
                "false" => Some(false),
                _ => None,
            }),
            element: element.clone(),
        }
    }

    /// Reads a `<joint>`; `frame` is the pose of the `<frame>` elements around it in the body.
    pub(crate) fn joint(&mut self, element: &Element, name: String, frame: &Isometry3<f64>) -> Joint {
        let motion = match self.word(element, "type", &["hinge", "slide", "ball", "free"]) {
            Some("slide") => JointType::Slide,
            Some("ball") => JointType::Ball,
            Some("free") => JointType::Free,
            _ => JointType::Hinge,
        };
        let mut joint = self.free_joint(element, name);
        joint.motion = motion;
        if matches!(motion, JointType::Hinge | JointType::Slide) {
            let axis = self.numbers::<3>(element, "axis").unwrap_or([0.0, 0.0, 1.0]);
            joint.axis = frame.rotation * self.direction(element, "axis", Vector3::from(axis));
        }
        if motion != JointType::Free {
            let anchor = self.numbers::<3>(element, "pos").unwrap_or_default();
            joint.anchor = (frame * Point3::from(anchor)).coords;
        }
        if motion == JointType::Hinge || motion == JointType::Slide {
            let reference = self.number(element, "ref").unwrap_or(0.0);
            joint.reference = self.joint_angle(element, motion, reference);
        }
        joint.limits = self.limits(element, motion);
        if matches!(motion, JointType::Hinge | JointType::Slide)
            && let Some([lower, upper]) = self.limit(element, "actuatorfrclimited", "actuatorfrcrange")
        {
            joint.actuator_force_range = [lower, upper];
            joint.limits.effort = lower.abs().max(upper.abs());
        }
        joint.actuator_compensates_gravity = self.boolean(element, "actuatorgravcomp").unwrap_or(false);
        self.passive_forces(element, &mut joint);
        joint.softness = self.softness(element, &joint);
        joint.spring_damper =
            self.numbers::<2>(element, "springdamper").filter(|&[t, d]| t != 0.0 || d != 0.0);
        if joint.spring_damper.is_some_and(|[time, ratio]| time <= 0.0 || ratio <= 0.0) {
            self.refuse(
                element,
                "both numbers of springdamper must be positive: time constant and damping ratio",
            );
        }
        joint
    }

    fn softness(&mut self, element: &Element, joint: &Joint) -> JointSolverImpedance {
        let mut softness = JointSolverImpedance::default();
        let (limit, friction) = (&mut softness.limit, &mut softness.friction);
        limit.solref = self.overlay(element, "solreflimit", limit.solref);
        limit.solimp = self.overlay(element, "solimplimit", limit.solimp);
        friction.solref = self.overlay(element, "solreffriction", friction.solref);
        friction.solimp = self.overlay(element, "solimpfriction", friction.solimp);
        // In radians, even if the angles of the file are in degrees.
        softness.margin = self.number(element, "margin").unwrap_or(0.0);
        softness.reference = joint.reference;
        softness
    }

    /// Converts a number of a hinge or ball joint from the angle unit of the file.
    fn joint_angle(&self, element: &Element, motion: JointType, number: f64) -> f64 {
        let turns = matches!(motion, JointType::Hinge | JointType::Ball);
        if turns { self.compiler(element).angle(number) } else { number }
    }

    fn limits(&mut self, element: &Element, motion: JointType) -> Limits {
        let mut limits = Limits::default();
        if let Some([lower, upper]) = self.limit(element, "limited", "range") {
            let [lower, upper] = [lower, upper].map(|bound| self.joint_angle(element, motion, bound));
            match motion {
                JointType::Hinge | JointType::Slide => (limits.lower, limits.upper) = (lower, upper),
                // The larger number counts, as in MuJoCo.
                JointType::Ball => limits.turn = lower.max(upper),
                JointType::Free => self.warn(element, "range: a free joint has no limits"),
            }
        }
        limits
    }

    /// A range if it is a limit: because the attribute `word` says so, or, with `auto`, because the range is
    /// present.
    pub(crate) fn limit(
        &mut self,
        element: &Element,
        word: &'static str,
        range: &'static str,
    ) -> Option<[f64; 2]> {
        let limited = self.word(element, word, &["false", "true", "auto"]);
        let bounds = self.bounds(element, range);
        match (limited, bounds) {
            (Some("false"), _) | (_, None | Some([f64::NEG_INFINITY, f64::INFINITY])) => None,
            (Some("true"), Some([lower, upper])) => {
                if lower >= upper {
                    self.warn(
                        element,
                        format!("{range}: the lower limit {lower} is not below the upper limit {upper}: taken as written"),
                    );
                }
                Some([lower, upper])
            }
            (_, Some([lower, upper])) => {
                if !self.compiler(element).auto_limits && (lower != 0.0 || upper != 0.0) {
                    self.warn(
                        element,
                        format!(
                            "{range} without {word}, and autolimits is off: no limit; give {word}=\"true\" or \"false\""
                        ),
                    );
                    return None;
                }
                (lower < upper).then_some([lower, upper])
            }
        }
    }

    fn passive_forces(&mut self, element: &Element, joint: &mut Joint) {
        let motion = joint.motion;
        let [armature, friction] = ["armature", "frictionloss"].map(|name| {
            let value = self.number(element, name).unwrap_or(0.0);
            if value < 0.0 {
                self.warn(element, format!("{name}={value} is negative: taken as written; correct its sign"));
            }
            value
        });
        let [damping, d2, d3] = self.polynomial(element, "damping");
        let [stiffness, k2, k3] = self.polynomial(element, "stiffness");
        let rest = self.number(element, "springref").unwrap_or(0.0);
        joint.passive =
            PassiveForces::default().with_armature(armature).with_damping(damping).with_friction(friction);
        joint.higher_terms = PolynomialStiffnessDamping { stiffness: [k2, k3], damping: [d2, d3] };
        if motion == JointType::Free && armature != 0.0 {
            let message = format!(
                "armature={armature} of a free joint: in the model it acts along the axes of the body, in MuJoCo along those \
                 of the world; M is equal, and the bias lacks armature·ω×v"
            );
            self.report_ignored_physics(element, message);
        }
        if motion == JointType::Free && friction != 0.0 {
            let message = format!(
                "frictionloss={friction} of a free joint: in the model it acts along the axes of the body, in MuJoCo along those of the world"
            );
            self.report_ignored_physics(element, message);
        }
        if matches!(motion, JointType::Hinge | JointType::Slide) {
            joint.passive = joint.passive.with_spring(stiffness, self.joint_angle(element, motion, rest));
            let stretch = self.magnitude(element, "springyield").unwrap_or(0.0);
            joint.spring_yield = self.joint_angle(element, motion, stretch);
        } else {
            joint.placement_stiffness = stiffness;
            let yields = self.number(element, "springyield").unwrap_or(0.0);
            if yields != 0.0 && stiffness != 0.0 {
                let message =
                    format!("springyield={yields}: the spring of a {} joint does not yield", motion.word());
                self.report_ignored_physics(element, message);
            }
        }
    }

    /// The coefficients of the first to third power.
    pub(crate) fn polynomial(&mut self, element: &Element, name: &'static str) -> [f64; 3] {
        let coefficients = self.overlay(element, name, [0.0; 3]);
        if coefficients[0] < 0.0 {
            self.warn(
                element,
                format!("{name}={} is negative: taken as written; correct its sign", coefficients[0]),
            );
        }
        coefficients
    }
}
