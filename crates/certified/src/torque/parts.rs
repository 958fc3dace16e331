//! Torques as a sum of parts, one for each uncertain parameter.

use std::borrow::Cow;

use robot_dynamics_core::{
    Model, PARAMETERS_PER_LINK, Workspace, dissipation, inertial_parameters, inverse_dynamics,
    joint_torque_regressor,
};
use robot_dynamics_number::Scalar;

use crate::Interval;
use crate::torque::payload;
use crate::uncertainty::Uncertainty;

/// A row of the regressor for one link.
type Row<S> = [S; PARAMETERS_PER_LINK];

/// A set of robots, prepared for the computation of torques.
pub(super) struct RobotSet<'a> {
    /// The robot under the gravity in the middle of the set's.
    model: Cow<'a, Model>,
    robots: &'a Uncertainty,
    /// π of the robot as modelled, ten numbers for each link.
    parameters: Vec<f64>,
    /// The robot under a unit of each varied component of gravity, and the difference from the middle.
    gravity: Vec<(Model, Interval)>,
    payload: Option<CarriedPayload>,
}

/// A payload in the axes of the link that carries it.
struct CarriedPayload {
    link: usize,
    mass: Interval,
    center: [Interval; 3],
    radius: f64,
    examples: Vec<(Interval, [Interval; 3])>,
}

/// The parts of the torques, over intervals or over dual numbers of them.
pub(super) struct Parts<S> {
    /// For the robot as modelled.
    nominal: Vec<S>,
    under_gravity: LinkParts<S>,
    /// Under a unit of each varied component of gravity, at rest.
    under_units: Vec<LinkParts<S>>,
}

/// Parts of the torques that are linear in the parameters of links.
struct LinkParts<S> {
    /// The part of link l in τⱼ, at j·links + l.
    links: Vec<S>,
    /// The row of the payload's link for each coordinate; empty without a payload.
    payload: Vec<Row<S>>,
}

impl Parts<Interval> {
    /// The result of a function of each pair of entries.
    pub(super) fn combine<S: Scalar>(
        center: &Self,
        within: &Parts<S>,
        form: impl Fn(&Interval, &S) -> Interval + Copy,
    ) -> Self {
        let all = |a: &[Interval], b: &[S]| a.iter().zip(b).map(|(a, b)| form(a, b)).collect();
        let rows = |(a, b): (&Row<Interval>, &Row<S>)| core::array::from_fn(|k| form(&a[k], &b[k]));
        let links = |a: &LinkParts<Interval>, b: &LinkParts<S>| LinkParts {
            links: all(&a.links, &b.links),
            payload: a.payload.iter().zip(&b.payload).map(rows).collect(),
        };
        Self {
            nominal: all(&center.nominal, &within.nominal),
            under_gravity: links(&center.under_gravity, &within.under_gravity),
            under_units: center
                .under_units
                .iter()
                .zip(&within.under_units)
                .map(|(a, b)| links(a, b))
                .collect(),
        }
    }
}

impl<'a> RobotSet<'a> {
    pub(super) fn new(model: &'a Model, robots: &'a Uncertainty) -> Self {
        assert_eq!(
            robots.mass_factors.len(),
            model.moving_links().count(),
            "this is the set of another robot"
        );
        let under = |gravity: [f64; 3]| {
            let mut description = model.description().clone();
            description.gravity = gravity;
            Model::new(description).expect("a compiled robot under another gravity")
        };
        let middle = robots.gravity.map(Interval::middle);
        let mut gravity = Vec::new();
        for (k, stated) in robots.gravity.iter().enumerate() {
            let difference = *stated - Interval::from(middle[k]);
            if difference != Interval::from(0.0) {
                let mut unit = [0.0; 3];
                unit[k] = 1.0;
                gravity.push((under(unit), difference));
            }
        }
        let payload = robots.payload.as_ref().map(|payload| {
            let body = model.frame_of(payload.frame).body.expect("checked when the payload was set");
            let name = model.description().links[model.bodies[body].link].name.as_str();
            CarriedPayload {
                link: model.moving_links().position(|link| link == name).expect("every body has a link"),
                mass: payload.mass,
                center: payload.center_in_link(model),
                radius: payload.radius_of_gyration,
                examples: payload.examples(model),
            }
        });
        let parameters = inertial_parameters(model);
        let model = if middle == model.gravity() { Cow::Borrowed(model) } else { Cow::Owned(under(middle)) };
        Self { model, robots, parameters, gravity, payload }
    }

    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    /// The parts of τ at a state.
    pub(super) fn parts<S: Scalar>(&self, workspace: &mut Workspace<S>, [q, v, a]: [&[S]; 3]) -> Parts<S> {
        let mut nominal = vec![S::zero(); v.len()];
        inverse_dynamics(&self.model, workspace, q, v, a, &mut nominal);
        let under_gravity = self.of_links(&self.model, workspace, [q, v, a]);
        let rest = vec![S::zero(); v.len()];
        let of_unit =
            |(unit, _): &(Model, Interval)| self.of_links(unit, &mut Workspace::new(unit), [q, &rest, &rest]);
        Parts { nominal, under_gravity, under_units: self.gravity.iter().map(of_unit).collect() }
    }

    fn of_links<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        [q, v, a]: [&[S]; 3],
    ) -> LinkParts<S> {
        let columns = self.parameters.len();
        let mut regressor = vec![S::zero(); v.len() * columns];
        joint_torque_regressor(model, workspace, q, v, a, &mut regressor);
        let mut links = Vec::new();
        for row in regressor.chunks(columns.max(1)) {
            for (row, parameters) in
                row.chunks(PARAMETERS_PER_LINK).zip(self.parameters.chunks(PARAMETERS_PER_LINK))
            {
                let sum = row.iter().zip(parameters).map(|(y, p)| y.scale(*p)).reduce(|a, b| a + b);
                links.extend(sum);
            }
        }
        let payload = self.payload.iter().flat_map(|payload| {
            let first = PARAMETERS_PER_LINK * payload.link;
            regressor.chunks(columns).map(move |row| core::array::from_fn(|k| row[first + k]))
        });
        let payload = payload.collect();
        LinkParts { links, payload }
    }

    /// The torques of all robots from enclosures of the parts and of the velocities.
    pub(super) fn torques(&self, parts: &Parts<Interval>, v: &[Interval]) -> Vec<Interval> {
        let (factors, one) = (&self.robots.mass_factors, Interval::from(1.0));
        let friction = self.friction(v);
        (0..v.len())
            .map(|j| {
                let mut torque = parts.nominal[j] + self.robots.friction_factor * friction[j];
                let own = |of: &LinkParts<Interval>, offset: Interval| {
                    let of_link = of.links[j * factors.len()..].iter().zip(factors);
                    of_link.fold(Interval::from(0.0), |sum, (part, f)| sum + (*f - offset) * *part)
                };
                let carried = |of: &LinkParts<Interval>| match &self.payload {
                    Some(payload) => {
                        payload.mass * payload::range(&of.payload[j], payload.center, payload.radius)
                    }
                    None => Interval::from(0.0),
                };
                torque += own(&parts.under_gravity, one) + carried(&parts.under_gravity);
                for ((_, difference), unit) in self.gravity.iter().zip(&parts.under_units) {
                    torque += *difference * (own(unit, Interval::from(0.0)) + carried(unit));
                }
                torque
            })
            .collect()
    }

    /// For each coordinate a number that the least torque of a robot does not exceed, and one that the
    /// greatest reaches, from the parts at one time.
    pub(super) fn extremes(&self, parts: &Parts<Interval>, v: &[Interval]) -> Vec<(f64, f64)> {
        let friction = self.friction(v);
        (0..v.len())
            .map(|j| {
                let least = self.extreme(parts, friction[j], j, -1.0);
                (least.upper(), self.extreme(parts, friction[j], j, 1.0).lower())
            })
            .collect()
    }

    /// τⱼ of a robot of the set that makes it large (`sign` 1) or small (−1).
    fn extreme(&self, parts: &Parts<Interval>, friction: Interval, j: usize, sign: f64) -> Interval {
        let pick = |range: Interval, slope: Interval| {
            Interval::from(if sign * slope.middle() > 0.0 { range.upper() } else { range.lower() })
        };
        let factors = &self.robots.mass_factors;
        let links = |of: &LinkParts<Interval>| of.links[j * factors.len()..(j + 1) * factors.len()].to_vec();
        let mut torque = parts.nominal[j] + pick(self.robots.friction_factor, friction) * friction;
        let sum = |parts: &[Interval]| parts.iter().fold(Interval::from(0.0), |sum, part| sum + *part);
        // Gravity first, then the masses under this gravity.
        let gravity: Vec<Interval> = self
            .gravity
            .iter()
            .zip(&parts.under_units)
            .map(|((_, difference), unit)| pick(*difference, sum(&links(unit))))
            .collect();
        let mut changed = links(&parts.under_gravity);
        let nominal = changed.clone();
        for (g, unit) in gravity.iter().zip(&parts.under_units) {
            for (part, unit) in changed.iter_mut().zip(links(unit)) {
                *part += *g * unit;
            }
        }
        for ((part, nominal), factor) in changed.iter().zip(nominal).zip(factors) {
            torque += pick(*factor, *part) * *part - nominal;
        }
        let Some(payload) = &self.payload else { return torque };
        let mut row = parts.under_gravity.payload[j];
        for (g, unit) in gravity.iter().zip(&parts.under_units) {
            for (entry, unit) in row.iter_mut().zip(unit.payload[j]) {
                *entry += *g * unit;
            }
        }
        let extension = payload::of_extension(&row, payload.radius, sign);
        let of_example = |(mass, center): &(Interval, [Interval; 3])| {
            *mass * (payload::of_point(&row, *center) + extension)
        };
        let best = payload
            .examples
            .iter()
            .map(of_example)
            .max_by(|a, b| (sign * a.middle()).total_cmp(&(sign * b.middle())));
        torque + best.unwrap_or(Interval::from(0.0))
    }

    /// Damping and dry friction.
    fn friction(&self, v: &[Interval]) -> Vec<Interval> {
        let mut friction = vec![Interval::from(0.0); v.len()];
        if self.robots.friction_factor.upper() > 0.0 {
            dissipation(&self.model, v, &mut friction);
        }
        friction
    }
}
