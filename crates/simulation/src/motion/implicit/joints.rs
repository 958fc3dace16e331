//! The passive properties of joints and tendons, coordinate by coordinate.

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_description::{JointKind, Quaternion};

use super::measured::Measured;
use crate::Actuation;
use crate::actuation::Coupling;

/// A bound sign·(x − bound) ≥ 0, where x is a coordinate q\[i\], the length ℓ(q) of a tendon over joints or
/// along a path, or the rotation angle of a ball joint.
#[derive(Clone, Debug)]
pub(super) struct Stop {
    /// The row that it bounds.
    pub(super) row: usize,
    pub(super) length: Length,
    pub(super) bound: f64,
    pub(super) sign: f64,
}

/// The bounded quantity.
#[derive(Clone, Debug)]
pub(super) enum Length {
    /// This entry of q.
    Coordinate(usize),
    Tendon(JointSum),
    /// The length of the path with this index among those that are bounded.
    Path(usize),
    /// The angle of the quaternion that starts at this entry.
    Turn(usize),
}

impl Stop {
    /// The distance from the stop, negative beyond it.
    #[inline]
    pub(super) fn gap<'a>(&self, at: impl Into<Measured<'a>>) -> f64 {
        let Measured { q, lengths } = at.into();
        let length = match &self.length {
            Length::Coordinate(at) => q[*at],
            Length::Tendon(sum) => sum.at(q),
            Length::Path(path) => lengths[*path],
            Length::Turn(at) => turned(*at, q).norm(),
        };
        self.sign * (length - self.bound)
    }

    /// The gap at q without the fraction `kept` of a violation at q₀: a correction makes it nonnegative.
    #[inline]
    pub(super) fn gap_to_correct<'a>(
        &self,
        q0: impl Into<Measured<'a>>,
        kept: f64,
        q: impl Into<Measured<'a>>,
    ) -> f64 {
        self.gap(q) - self.gap(q0).min(0.0) * kept
    }
}

/// The rotation vector of a ball joint, which has the same components in both links; the angle increases with
/// the angular velocity along it.
pub(super) fn turned(at: usize, q: &[f64]) -> Vector3<f64> {
    Quaternion::from_xyzw([0, 1, 2, 3].map(|k| q[at + k])).log().into()
}

clone_in_place! {
    /// The damping, stiffness and friction of each coordinate, with those of its mimic joints, and all stops.
    #[derive(Debug)]
    pub(super) struct Joints {
        /// The damping that acts in this step; negative damping in a file adds energy, as specified.
        pub(super) damping: Vec<f64>,
        /// The dry friction of each row.
        pub(super) friction: Vec<f64>,
        /// Springs with positive stiffness; the explicit part handles negative stiffness.
        pub(super) stiffness: Vec<f64>,
        pub(super) stops: Vec<Stop>,
        /// Whether each coordinate has a stop of its own.
        is_bounded: Vec<bool>,
        /// The rows along which impulses act, each as coordinates with factors: first every coordinate, then
        /// tendons over joints with bounds or friction, then paths with bounds, then ball joints with bounds.
        /// The factors of paths and ball joints depend on q.
        pub(super) rows: Vec<Vec<(usize, f64)>>,
        /// The stiffness and damping of servos and tendons, whose forces are evaluated elsewhere.
        driven_stiffness: Vec<f64>,
        driven_damping: Vec<f64>,
        /// The stiffness and damping of servos and tendons over several coordinates.
        couplings: Vec<Coupling>,
        /// Whether a fluid resists each coordinate.
        is_in_fluid: Vec<bool>,
        /// Whether some damping is negative, or wind drives the robot.
        pub(super) adds_energy: bool,
        /// The damping and friction with dissipation switched on.
        all_damping: Vec<f64>,
        all_friction: Vec<f64>,
        /// The row and the dry friction of each tendon with a row.
        tendons: Vec<(usize, f64)>,
        /// The indices of these tendons in the description.
        tendon_numbers: Vec<usize>,
        /// The row of each bounded path, and its index among the spatial tendons of the description.
        paths: Vec<(usize, usize)>,
    }
}

impl Joints {
    pub(super) fn new(model: &Model) -> Self {
        let nv = model.nv;
        let mut joints = Self {
            damping: vec![0.0; nv],
            friction: vec![0.0; nv],
            stiffness: vec![0.0; nv],
            stops: Vec::new(),
            is_bounded: vec![false; nv],
            rows: (0..nv).map(|k| vec![(k, 1.0)]).collect(),
            driven_stiffness: vec![0.0; nv],
            driven_damping: vec![0.0; nv],
            couplings: Vec::new(),
            is_in_fluid: vec![false; nv],
            adds_energy: false,
            all_damping: vec![0.0; nv],
            all_friction: vec![0.0; nv],
            tendons: Vec::new(),
            tendon_numbers: Vec::new(),
            paths: Vec::new(),
        };
        joints.add_passive_forces(model);
        joints.add_joint_stops(model);
        joints.add_tendons(model);
        joints.add_paths(model);
        joints.add_ball_stops(model);
        joints.friction.resize(joints.rows.len(), 0.0);
        joints.all_friction.resize(joints.rows.len(), 0.0);
        joints
    }

    /// Adds the damping, friction and springs of the joints, and of their mimic joints, to each coordinate.
    fn add_passive_forces(&mut self, model: &Model) {
        for dof in &model.dofs {
            let (k, square, passive) = (dof.coordinate, dof.ratio * dof.ratio, &dof.passive);
            self.all_damping[k] += square * passive.damping;
            self.all_friction[k] += dof.ratio.abs() * passive.friction.max(0.0);
            self.stiffness[k] += square * passive.stiffness;
        }
        self.adds_energy = self.all_damping.iter().any(|damping| *damping < 0.0);
        self.stiffness.iter_mut().for_each(|stiffness| *stiffness = stiffness.max(0.0));
    }

    /// Adds the stops of joints with one coordinate.
    fn add_joint_stops(&mut self, model: &Model) {
        for range in coordinate_ranges(model).filter(|range| range.chart == Chart::Line) {
            // A mimic joint repeats the coordinate of its leader.
            if self.is_bounded[range.v] {
                continue;
            }
            let (lower, upper) = limits_of(model, range.v);
            for (bound, sign) in [(lower, 1.0), (upper, -1.0)] {
                if bound.is_finite() {
                    self.stops.push(Stop { row: range.v, length: Length::Coordinate(range.q), bound, sign });
                    self.is_bounded[range.v] = true;
                }
            }
        }
    }

    /// Adds the rows of tendons with bounds or friction, and their stops.
    fn add_tendons(&mut self, model: &Model) {
        for (number, tendon) in model.description().tendons.iter().enumerate() {
            let (lower, upper) = (tendon.limits.lower, tendon.limits.upper);
            let sum = JointSum::of_tendon(model, tendon);
            let (row, terms) = (self.rows.len(), sum.row());
            let is_bounded = (lower.is_finite() || upper.is_finite()) && lower <= upper;
            let friction = tendon.passive.friction.max(0.0);
            if terms.is_empty() || !(is_bounded || friction > 0.0) {
                continue;
            }
            self.tendons.push((row, friction));
            self.tendon_numbers.push(number);
            for (bound, sign) in [(lower, 1.0), (upper, -1.0)] {
                if is_bounded && bound.is_finite() {
                    self.stops.push(Stop { row, length: Length::Tendon(sum.clone()), bound, sign });
                }
            }
            self.rows.push(terms);
        }
    }

    /// Adds the rows of spatial tendons with bounds, and their stops.
    fn add_paths(&mut self, model: &Model) {
        let tendons = model.description().spatial_tendons.iter();
        if !tendons.clone().any(|tendon| tendon.limits.lower.is_finite() || tendon.limits.upper.is_finite()) {
            return;
        }
        for (number, (tendon, path)) in tendons.zip(TendonPath::all(model)).enumerate() {
            let (lower, upper) = (tendon.limits.lower, tendon.limits.upper);
            let coordinates = path.coordinates(model);
            let is_bounded = lower.is_finite() || upper.is_finite();
            if coordinates.is_empty() || !is_bounded || lower > upper {
                continue;
            }
            let (row, length) = (self.rows.len(), Length::Path(self.paths.len()));
            for (bound, sign) in [(lower, 1.0), (upper, -1.0)] {
                if bound.is_finite() {
                    self.stops.push(Stop { row, length: length.clone(), bound, sign });
                }
            }
            self.paths.push((row, number));
            self.rows.push(coordinates.into_iter().map(|k| (k, 0.0)).collect());
        }
    }

    /// Adds the rows of ball joints with a limit of their angle, and their stops.
    fn add_ball_stops(&mut self, model: &Model) {
        for joint in model.joints.iter().filter(|joint| joint.kind == JointKind::Spherical) {
            let bound = joint.limits.turn;
            if bound.is_finite() {
                let (row, length) = (self.rows.len(), Length::Turn(joint.q_index));
                self.stops.push(Stop { row, length, bound, sign: -1.0 });
                self.rows.push((0..3).map(|k| (joint.v_index + k, 0.0)).collect());
            }
        }
    }

    /// Adds the stiffness and damping of servos and tendons, and the tendons' dry friction. Marks the
    /// coordinates that a fluid resists.
    pub(super) fn add_gains(&mut self, model: &Model, actuation: &Actuation) {
        if let Some(fluid) = actuation.fluid() {
            self.is_in_fluid = fluid.moving_coordinates(model);
            self.adds_energy |= fluid.has_wind();
        }
        self.tendons.iter().for_each(|&(row, friction)| self.all_friction[row] = friction);
        actuation.add_gains(&mut self.driven_stiffness, &mut self.driven_damping, &mut self.couplings);
    }

    /// K and D over several coordinates.
    pub(super) fn couplings(&self) -> &[Coupling] {
        &self.couplings
    }

    /// y −= g K x.
    pub(super) fn subtract_stiffness(&self, g: f64, x: &[f64], y: &mut [f64]) {
        for k in 0..x.len() {
            y[k] -= g * self.derivatives(k).0 * x[k];
        }
        self.couplings.iter().for_each(|coupling| coupling.subtract_stiffness(g, x, y));
    }

    /// K and D of coordinate k alone, without negative values.
    pub(super) fn derivatives(&self, k: usize) -> (f64, f64) {
        let damping = self.damping[k].max(0.0) + self.driven_damping[k];
        (self.stiffness[k] + self.driven_stiffness[k], damping)
    }

    /// Whether the forces on coordinate k depend on its motion, alone or coupled with other coordinates.
    pub(super) fn resists(&self, k: usize) -> bool {
        let is_coupled = |coupling: &Coupling| coupling.row.iter().any(|(coordinate, _)| *coordinate == k);
        self.damping[k] != 0.0
            || self.friction[k] != 0.0
            || self.derivatives(k) != (0.0, 0.0)
            || self.couplings.iter().any(is_coupled)
            || self.is_bounded[k]
            || self.is_in_fluid[k]
    }

    /// Selects whether damping and friction act.
    pub(super) fn choose(&mut self, dissipation: bool) {
        if dissipation {
            self.damping.copy_from_slice(&self.all_damping);
            self.friction.copy_from_slice(&self.all_friction);
        } else {
            self.damping.fill(0.0);
            self.friction.fill(0.0);
        }
    }

    /// The dry friction along a row.
    pub(super) fn friction_along(&self, row: usize) -> f64 {
        self.friction[row]
    }

    /// The first row whose factors depend on q.
    pub(super) fn first_turning(&self) -> usize {
        let turns = |stop: &&Stop| matches!(stop.length, Length::Path(_) | Length::Turn(_));
        self.stops.iter().find(turns).map_or(self.rows.len(), |stop| stop.row)
    }

    pub(super) fn has_friction(&self) -> bool {
        self.friction.iter().any(|friction| *friction > 0.0)
    }

    /// The row of each bounded path, and its index among the spatial tendons of the description.
    pub(super) fn path_rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.paths.iter().copied()
    }

    /// The rows of tendons over joints, each with the tendon's index in the description.
    pub(super) fn tendon_rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.tendons.iter().zip(&self.tendon_numbers).map(|(&(row, _), &number)| (row, number))
    }

    pub(super) fn has_stops(&self) -> bool {
        !self.stops.is_empty()
    }
}

/// The limits of a coordinate that satisfy those of its joint and of its mimic joints.
fn limits_of(model: &Model, coordinate: usize) -> (f64, f64) {
    let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
    for dof in model.dofs.iter().filter(|dof| dof.coordinate == coordinate) {
        let limits = &model.joints[dof.joint].limits;
        if dof.ratio == 0.0 || limits.lower > limits.upper {
            continue;
        }
        let ends = [limits.lower, limits.upper].map(|end| (end - dof.offset) / dof.ratio);
        lower = lower.max(ends[0].min(ends[1]));
        upper = upper.min(ends[0].max(ends[1]));
    }
    (lower, upper)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::Model;
    use robot_dynamics_description::Mimic;

    use super::super::test_robot::arm;
    use super::{Joints, limits_of};

    /// The elbow turns by ½ − 2q and is limited to 0 ≤ ½ − 2q ≤ 3, the shoulder to −3 ≤ q ≤ 0.
    #[test]
    fn limits_of_mimic_joints_bound_their_leader() {
        let mut robot = arm().description().clone();
        robot.joints[1] = robot.joints[1].clone().with_mimic(Mimic::new("shoulder", -2.0, 0.5));
        let model = Model::new(robot).unwrap();
        assert_eq!(limits_of(&model, 0), (-1.25, 0.0));
        let stops: Vec<_> =
            Joints::new(&model).stops.iter().map(|stop| (stop.row, stop.bound, stop.sign)).collect();
        assert_eq!(stops, [(0, -1.25, 1.0), (0, 0.0, -1.0)]);
    }
}
