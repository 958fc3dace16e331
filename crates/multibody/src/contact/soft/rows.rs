//! The rows of A that constraints have, and those of joints: limits, friction, equalities.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::active_set::ActiveLimits;
use super::connection::Connection;
use super::impedance::Response;
use super::weights::InverseWeights;
use super::{Asked, Of, State};
use crate::clone_in_place::clone_in_place;
use crate::contact::ConeProblem;
use crate::contact::cone_problem::Set;
use crate::contact::placement::Placement;
use crate::factor::sparse::{carriers, coordinate_carriers};
use crate::model::softness::{JointSoftness, Softness};
use crate::space::joint_sum::JointSum;
use crate::{Equality, FrameId, JointKind, Model, Quaternion, TendonDescription, TendonSoftness};

/// A point of a body that a constraint acts on, and with which sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    body: Option<usize>,
    sign: f64,
    point: Vector3<f64>,
}

impl Side {
    #[track_caller]
    pub(super) fn new(model: &Model, frame: FrameId, sign: f64, point: Vector3<f64>) -> Self {
        Self { body: model.frame_of(frame).body, sign, point }
    }
}

/// Rows that take the velocities and spins of the sides along these directions; the first row's index.
pub(super) fn push(
    problem: &mut ConeProblem,
    model: &Model,
    placement: &Placement,
    set: Set,
    sides: [Option<Side>; 2],
    directions: &[(Vector3<f64>, Vector3<f64>)],
) -> usize {
    // Coordinates of both sides, rising, each once.
    let path =
        |side: Option<Side>| side.and_then(|side| side.body).map_or(&[][..], |body| placement.path(body));
    let [mut one, mut two] = sides.map(path);
    let support = core::iter::from_fn(|| {
        let next = match (one.first(), two.first()) {
            (Some(a), Some(b)) => a.min(b),
            (a, b) => a.or(b)?,
        };
        one = if one.first() == Some(next) { &one[1..] } else { one };
        two = if two.first() == Some(next) { &two[1..] } else { two };
        Some(*next)
    });
    let row = problem.push(set, directions.len(), support);
    let (support, entries) = problem.last();
    let count = support.len();
    for side in sides.into_iter().flatten() {
        let Some(body) = side.body else { continue };
        placement.each_motion(model, body, side.point, |dof, velocity, spin| {
            let Ok(column) = support.binary_search(&dof.coordinate) else { return };
            let factor = side.sign * dof.ratio;
            for (r, (along, about)) in directions.iter().enumerate() {
                entries[r * count + column] += factor * (along.dot(&velocity) + about.dot(&spin));
            }
        });
    }
    row
}

/// ℓ(q).
pub(super) fn tendon_length(model: &Model, tendon: &TendonDescription) -> JointSum {
    let terms = tendon.terms.iter().map(|(joint, factor)| (joint.as_str(), *factor));
    JointSum::new(model, tendon.offset, terms)
}

clone_in_place! {
    /// The constraints of joints and tendons.
    #[derive(Debug)]
    pub(super) struct JointRows {
        frictions: Vec<Friction>,
        limits: Vec<Limit>,
        turns: Vec<Turn>,
        tendons: Vec<TendonLimit>,
        equalities: Vec<Equal>,
        connections: Vec<Connection>,
        /// Whether each row moves with freedoms that carry one another.
        keeps_tree: bool,
    }
}

#[derive(Clone, Debug)]
struct Friction {
    /// Its coordinates, rising, with ∂/∂q of what it rubs along.
    slopes: Vec<(usize, f64)>,
    /// \[N·m or N\].
    most: f64,
    softness: Softness,
    weight: f64,
}

/// sign·(ratio·q + offset − bound) ≥ 0.
#[derive(Clone, Debug)]
struct Limit {
    q: usize,
    coordinate: usize,
    ratio: f64,
    offset: f64,
    bound: f64,
    sign: f64,
    margin: f64,
    softness: Softness,
    weight: f64,
}

/// most − |log q| ≥ 0 of a ball joint.
#[derive(Clone, Debug)]
struct Turn {
    q: usize,
    coordinate: usize,
    most: f64,
    margin: f64,
    softness: Softness,
    weight: f64,
}

/// sign·(ℓ − bound) ≥ 0 of a tendon's length.
#[derive(Clone, Debug)]
struct TendonLimit {
    /// In the description.
    number: usize,
    length: JointSum,
    /// ∂ℓ/∂q by its coordinates, rising.
    slopes: Vec<(usize, f64)>,
    bound: f64,
    sign: f64,
    softness: TendonSoftness,
    weight: f64,
}

/// y − y⁰ = Σ cₖ(x − x⁰)ᵏ of joints' positions, each (q, coordinate, reference).
#[derive(Clone, Debug)]
struct Equal {
    joint: (usize, usize, f64),
    leader: Option<(usize, usize, f64)>,
    polynomial: [f64; 5],
    softness: Softness,
    weight: f64,
}

impl JointRows {
    pub(super) fn new(model: &Model, weights: &InverseWeights) -> Self {
        let described: HashMap<&str, &JointSoftness> =
            model.description().joints.iter().map(|joint| (joint.name.as_str(), &joint.softness)).collect();
        let of = |joint: usize| -> JointSoftness {
            described.get(model.joints[joint].name.as_str()).copied().copied().unwrap_or_default()
        };
        let mut rows = Self {
            frictions: Vec::new(),
            limits: Vec::new(),
            turns: Vec::new(),
            tendons: Vec::new(),
            equalities: Vec::new(),
            connections: Vec::new(),
            keeps_tree: true,
        };
        for dof in &model.dofs {
            let (k, softness, square) = (dof.coordinate, of(dof.joint), dof.ratio * dof.ratio);
            if dof.passive.friction > 0.0 {
                rows.frictions.push(Friction {
                    slopes: vec![(k, 1.0)],
                    most: dof.ratio.abs() * dof.passive.friction,
                    softness: softness.friction,
                    weight: weights.coordinates[k],
                });
            }
            let joint = &model.joints[dof.joint];
            let leader = model.joints.iter().find(|own| own.nv == 1 && own.v_index == k);
            let Some(leader) = leader.filter(|_| dof.ratio != 0.0) else { continue };
            for (bound, sign) in [(joint.limits.lower, 1.0), (joint.limits.upper, -1.0)] {
                if bound.is_finite() {
                    rows.limits.push(Limit {
                        q: leader.q_index,
                        coordinate: k,
                        ratio: dof.ratio,
                        offset: dof.offset,
                        bound,
                        sign,
                        margin: softness.margin,
                        softness: softness.limit,
                        weight: square * weights.coordinates[k],
                    });
                }
            }
        }
        for (joint, own) in
            model.joints.iter().enumerate().filter(|(_, own)| own.kind == JointKind::Spherical)
        {
            let (most, softness) = (own.limits.turn, of(joint));
            if most.is_finite() {
                let (q, coordinate) = (own.q_index, own.v_index);
                let (margin, softness) = (softness.margin, softness.limit);
                let weight = weights.coordinates[coordinate];
                rows.turns.push(Turn { q, coordinate, most, margin, softness, weight });
            }
        }
        rows.add_tendons(model, weights);
        for equality in model.description().equalities.iter().filter(|own| own.active) {
            let softness = Softness { solref: equality.solref, solimp: equality.solimp };
            let single = |(name, reference): &(String, f64)| {
                let joint = model.joints.iter().find(|own| own.name == *name && own.nv == 1)?;
                Some((joint.q_index, joint.v_index, *reference))
            };
            match &equality.kind {
                Equality::Joints { joint, leader, polynomial } => {
                    let (Some(joint), leader) = (single(joint), leader.as_ref().and_then(single)) else {
                        continue;
                    };
                    let other = leader.map_or(0.0, |leader| weights.coordinates[leader.1]);
                    let weight = weights.coordinates[joint.1] + other;
                    rows.equalities.push(Equal { joint, leader, polynomial: *polynomial, softness, weight });
                }
                Equality::Connect { a: (a, _), b: (b, _) } | Equality::Weld { a, b, .. } => {
                    let sides = ["a", "b"].map(|side| model.frame(&equality.frame_name(side)));
                    let [Some(one), Some(two)] = sides else { continue };
                    let of =
                        |link: &str| model.frame(link).map_or([0.0; 2], |link| weights.frames[link.index]);
                    let (frames, weights) = ([one, two], [0, 1].map(|part| of(a)[part] + of(b)[part]));
                    let is_weld = matches!(equality.kind, Equality::Weld { .. });
                    rows.connections.push(Connection { frames, is_weld, softness, weights });
                }
            }
        }
        rows.keeps_tree &= rows.equalities.is_empty() && rows.connections.is_empty();
        rows
    }

    fn add_tendons(&mut self, model: &Model, weights: &InverseWeights) {
        let carrier = coordinate_carriers(model);
        for (number, (tendon, &weight)) in
            model.description().tendons.iter().zip(&weights.tendons).enumerate()
        {
            let length = tendon_length(model, tendon);
            let slopes = length.row();
            let Some(((last, _), others)) = slopes.split_last() else { continue };
            let is_path = others.iter().all(|(k, _)| carriers(&carrier, *last).any(|i| i == *k));
            let most = tendon.passive.friction;
            if most > 0.0 {
                let (slopes, softness) = (slopes.clone(), tendon.softness.friction);
                self.frictions.push(Friction { slopes, most, softness, weight });
                self.keeps_tree &= is_path;
            }
            for (bound, sign) in [(tendon.limits.lower, 1.0), (tendon.limits.upper, -1.0)] {
                if bound.is_finite() {
                    let (length, slopes, softness) = (length.clone(), slopes.clone(), tendon.softness);
                    self.tendons.push(TendonLimit { number, length, slopes, bound, sign, softness, weight });
                    self.keeps_tree &= is_path;
                }
            }
        }
    }

    /// Adds them at q; whether each moves with freedoms that carry one another.
    pub(super) fn add(
        &self,
        placement: &Placement,
        state: &mut State<'_>,
        mut active: ActiveLimits<'_>,
        (problem, asked): (&mut ConeProblem, &mut Vec<Asked>),
    ) -> bool {
        let State { h, q, .. } = *state;
        for friction in self.frictions.iter().filter(|_| state.dissipates) {
            let response = Response::new(&friction.softness, h, 0.0);
            let set = Set::Interval(-friction.most, friction.most);
            let row = problem.push_row(set, 1.0, &friction.slopes);
            problem.soften(response.softness(friction.weight));
            asked.push(Asked::new(Of::Friction, row, response.damping, 0.0));
        }
        let [first_turn, first_tendon] = [self.limits.len(), self.limits.len() + self.turns.len()];
        for (number, limit) in self.limits.iter().enumerate() {
            let distance = limit.sign * (limit.ratio * q[limit.q] + limit.offset - limit.bound);
            if !active.admits(number, distance < limit.margin) {
                continue;
            }
            let response = Response::new(&limit.softness, h, distance - limit.margin);
            let row = problem.push(Set::Interval(0.0, f64::INFINITY), 1, core::iter::once(limit.coordinate));
            problem.last().1[0] = limit.sign * limit.ratio;
            problem.soften(response.softness(limit.weight));
            asked.push(Asked::new(
                Of::Limit(limit.coordinate, limit.sign * limit.ratio),
                row,
                response.damping,
                response.spring,
            ));
        }
        for (number, turn) in self.turns.iter().enumerate() {
            // The angle grows with the part of the angular velocity along the axis, which both frames see alike.
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| q[turn.q + k]);
            let turned = Vector3::from(Quaternion::from_xyzw([x, y, z, w]).log());
            let angle = turned.norm();
            let distance = turn.most - angle;
            if !active.admits(first_turn + number, distance < turn.margin && angle != 0.0) || angle == 0.0 {
                continue;
            }
            let response = Response::new(&turn.softness, h, distance - turn.margin);
            let row =
                problem.push(Set::Interval(0.0, f64::INFINITY), 1, turn.coordinate..turn.coordinate + 3);
            problem.last().1.copy_from_slice((turned / -angle).as_slice());
            problem.soften(response.softness(turn.weight));
            asked.push(Asked::new(Of::Stop, row, response.damping, response.spring));
        }
        for (number, limit) in self.tendons.iter().enumerate() {
            let distance = limit.sign * (limit.length.at(q) - limit.bound) - limit.softness.margin;
            if !active.admits(first_tendon + number, distance < 0.0) {
                continue;
            }
            let response = Response::new(&limit.softness.limit, h, distance);
            let row = problem.push_row(Set::Interval(0.0, f64::INFINITY), limit.sign, &limit.slopes);
            problem.soften(response.softness(limit.weight));
            asked.push(Asked::new(
                Of::TendonLimit(limit.number, limit.sign),
                row,
                response.damping,
                response.spring,
            ));
        }
        let free = Set::Interval(f64::NEG_INFINITY, f64::INFINITY);
        for equal in &self.equalities {
            let [c0, c1, c2, c3, c4] = equal.polynomial;
            let x = equal.leader.map_or(0.0, |(at, _, reference)| q[at] - reference);
            let value = c0 + x * (c1 + x * (c2 + x * (c3 + x * c4)));
            let slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4));
            let (at, coordinate, reference) = equal.joint;
            let response = Response::new(&equal.softness, h, q[at] - reference - value);
            let leader = equal.leader.map(|(_, leader, _)| leader);
            let (least, most) = (
                leader.map_or(coordinate, |leader| leader.min(coordinate)),
                leader.map_or(coordinate, |leader| leader.max(coordinate)),
            );
            let support = core::iter::once(least).chain((most != least).then_some(most));
            let row = problem.push(free, 1, support);
            let (support, entries) = problem.last();
            for (&k, entry) in support.iter().zip(entries) {
                *entry = if k == coordinate { 1.0 } else { -slope };
            }
            problem.soften(response.softness(equal.weight));
            asked.push(Asked::new(Of::Stop, row, response.damping, response.spring));
        }
        for connection in &self.connections {
            connection.add(placement, state, problem, asked);
        }
        self.keeps_tree
    }
}
