//! Proven bounds of the torques of a motion, for sets of robots.
//!
//! τ = M a + C v + g is linear in the inertial parameters of every link. With the part cₗ of link l,
//! τ = τ₀ + Σ (fₗ − 1) cₗ for factors fₗ on the masses, so a range of masses costs no overestimate. A payload
//! adds the column of its own parameters, and gravity that of each of its components.
//!
//! In an interval of time every part has the mean-value form x(s) ∈ x(m) + x′(S)(S − m), with the derivative
//! by dual numbers over intervals. Its overestimate falls with the square of the interval's length. Source:
//! Moore, Kearfott, Cloud, *Introduction to Interval Analysis*, SIAM 2009, ch. 6.

mod parts;
mod payload;

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::Dual;

use self::parts::{Parts, RobotSet};
use crate::motion::{Piece, PolynomialMotion};
use crate::search::{SearchOptions, map_on_threads};
use crate::uncertainty::Uncertainty;
use crate::{EnclosureError, Interval};

/// Bounds of the torques of a motion \[N·m, N\], for all times and all robots of a set.
#[derive(Clone, Debug)]
pub struct TorqueBounds {
    /// No torque is outside, for each coordinate.
    pub proven: Vec<Interval>,
    /// The least and the greatest torque that some robot of the set attains at some time.
    pub attained: Vec<Attained>,
    /// The intervals of time that were computed, which cover the motion.
    pub parts: Vec<TimePart>,
    /// Whether dividing the time further changes no bound by more than the tolerance.
    pub is_tight: bool,
}

/// Torques that are attained, and their times.
#[derive(Clone, Copy, Debug)]
pub struct Attained {
    /// The least torque is at most this.
    pub least: f64,
    /// Its time from the start of the motion \[s\].
    pub least_time: f64,
    /// The greatest torque is at least this.
    pub greatest: f64,
    /// Its time from the start of the motion \[s\].
    pub greatest_time: f64,
}

/// An interval of time of one piece of a motion.
#[derive(Clone, Debug)]
pub struct TimePart {
    /// The piece.
    pub piece: usize,
    /// The time from the start of the piece \[s\].
    pub time: Interval,
    /// The torques in this interval.
    pub torques: Vec<Interval>,
    /// The torques in the middle of the interval.
    at_middle: Vec<Interval>,
    /// Torques that robots attain there, the least and the greatest.
    extremes: Vec<(f64, f64)>,
}

/// Proven bounds of τ along a motion for all robots of a set, in N·m and N. Damping and dry friction count
/// with the factor of the set.
///
/// The tolerance of the options is relative to the range of each joint's torques. Time is divided until its
/// steps add no more than that to the ranges at single times.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{Interval, PolynomialMotion, SearchOptions, Uncertainty, torque_bounds};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let motion = PolynomialMotion::rest_to_rest(&[0.0], &[0.0], 1.0)?; // at rest: τ = −m g l
/// let robots = Uncertainty::none(&model).with_mass_factor(Interval::new(0.9, 1.1))?;
/// let bounds = torque_bounds(&model, &motion, &robots, &SearchOptions::default())?;
/// assert!((bounds.proven[0].lower() + 1.1 * 9.81).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EnclosureError::Quaternions`] if the robot has joints with quaternions.
///
/// # Panics
/// If the motion has another number of coordinates than the robot, or the set belongs to another robot.
pub fn torque_bounds(
    model: &Model,
    motion: &PolynomialMotion,
    robots: &Uncertainty,
    options: &SearchOptions,
) -> Result<TorqueBounds, EnclosureError> {
    if !model.is_vector_space() {
        return Err(EnclosureError::Quaternions);
    }
    let (nv, count) = (model.nv(), motion.coordinates());
    assert_eq!(count, nv, "the motion has {count} coordinates, but {nv} are needed");
    let robots = RobotSet::new(model, robots);
    let mut workers: Vec<Torques> = (0..options.thread_count()).map(|_| Torques::new(&robots)).collect();
    let per_piece = 64_usize.div_ceil(motion.pieces().len());
    let mut times = Vec::new();
    for (piece, Piece { duration, .. }) in motion.pieces().iter().enumerate() {
        let at = |k: usize| if k == per_piece { *duration } else { duration * k as f64 / per_piece as f64 };
        times.extend((0..per_piece).map(|k| (piece, Interval::new(at(k), at(k + 1)))));
    }
    let mut parts =
        map_on_threads(&mut workers, &times, |torques, (piece, time)| torques.in_part(motion, *piece, *time));
    loop {
        let proven = hull(&parts, nv, |part| &part.torques);
        let at_points = hull(&parts, nv, |part| &part.at_middle);
        let is_loose = |part: &TimePart| {
            let divides = part.time.lower() < part.time.middle() && part.time.middle() < part.time.upper();
            divides
                && part.torques.iter().zip(&proven).zip(&at_points).any(|((part, proven), points)| {
                    let allowed = options.tolerance * proven.width();
                    part.upper() - points.upper() > allowed || points.lower() - part.lower() > allowed
                })
        };
        let loose: Vec<usize> = (0..parts.len()).filter(|k| is_loose(&parts[*k])).collect();
        let is_over = parts.len() + loose.len() > options.boxes || options.is_interrupted();
        if loose.is_empty() || is_over {
            let starts = motion.starts();
            let start = |part: &TimePart| starts[part.piece] + part.time.lower();
            parts.sort_by(|a, b| start(a).total_cmp(&start(b)));
            let attained = attained(&parts, &starts, nv);
            return Ok(TorqueBounds { proven, attained, parts, is_tight: loose.is_empty() });
        }
        let halves: Vec<(usize, Interval)> =
            loose.iter().flat_map(|k| parts[*k].time.halves().map(|time| (parts[*k].piece, time))).collect();
        let mut found = map_on_threads(&mut workers, &halves, |torques, (piece, time)| {
            torques.in_part(motion, *piece, *time)
        })
        .into_iter();
        for k in loose {
            let (first, second) = (found.next(), found.next());
            parts[k] = first.expect("two halves for each part");
            parts.extend(second);
        }
    }
}

fn hull(parts: &[TimePart], nv: usize, torques: fn(&TimePart) -> &[Interval]) -> Vec<Interval> {
    let of = |j: usize| parts.iter().map(|part| torques(part)[j]).reduce(Interval::hull);
    (0..nv).map(|j| of(j).expect("a motion has parts")).collect()
}

fn attained(parts: &[TimePart], starts: &[f64], nv: usize) -> Vec<Attained> {
    let of = |j: usize| {
        let mut attained = Attained {
            least: f64::INFINITY,
            least_time: 0.0,
            greatest: f64::NEG_INFINITY,
            greatest_time: 0.0,
        };
        for part in parts {
            let time = starts[part.piece] + part.time.middle();
            let (least, greatest) = part.extremes[j];
            if least < attained.least {
                (attained.least, attained.least_time) = (least, time);
            }
            if greatest > attained.greatest {
                (attained.greatest, attained.greatest_time) = (greatest, time);
            }
        }
        attained
    };
    (0..nv).map(of).collect()
}

/// Torques in intervals of time, with workspaces.
struct Torques<'a> {
    robots: &'a RobotSet<'a>,
    points: Workspace<Interval>,
    slopes: Workspace<Dual<Interval, 1>>,
}

impl<'a> Torques<'a> {
    fn new(robots: &'a RobotSet<'a>) -> Self {
        let (points, slopes) = (Workspace::new(robots.model()), Workspace::new(robots.model()));
        Self { robots, points, slopes }
    }

    /// The torques in an interval of time, for all robots.
    fn in_part(&mut self, motion: &PolynomialMotion, piece: usize, time: Interval) -> TimePart {
        let middle = Interval::from(time.middle());
        let [q, rates, a] = motion.state(piece, middle);
        let center = self.robots.parts(&mut self.points, [&q, &rates, &a]);
        let [q, v, a] = motion.state(piece, Dual::<Interval, 1>::variable(time, 0));
        let within = self.robots.parts(&mut self.slopes, [&q, &v, &a]);
        let offset = time - middle;
        let form = |center: &Interval, within: &Dual<Interval, 1>| {
            let mean_value = *center + within.gradient[0] * offset;
            mean_value.intersection(within.value).unwrap_or(within.value)
        };
        let all_rates: Vec<Interval> = rates.iter().zip(&v).map(|(c, w)| form(c, w)).collect();
        let all = Parts::combine(&center, &within, form);
        TimePart {
            piece,
            time,
            torques: self.robots.torques(&all, &all_rates),
            at_middle: self.robots.torques(&center, &rates),
            extremes: self.robots.extremes(&center, &rates),
        }
    }
}
