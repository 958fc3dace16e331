//! Equalities as rows of a step's problem: closed loops, coupled joints, rolling wheels.
//!
//! Each row has A v, sparse over the coordinates that move its sides relative to each other. If it comes from
//! a position, it has φ with φ̇ = A v. The rows equal those of the constraints of explicit runs. They need
//! only the bodies' placement in the world: no Jacobians of frames, and no memory of their own in a step.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{FrameId, Model, Workspace};
use robot_dynamics_description::Pose;

use super::placement::Placement;

/// A frame on a body, or in the world.
#[derive(Clone, Debug)]
pub struct Site {
    body: usize,
    /// `body_from_site`.
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Site {
    #[track_caller]
    pub fn of_frame(model: &Model, frame: FrameId) -> Self {
        let frame = model.frame_of(frame);
        Self::new(frame.body.unwrap_or(WORLD), &frame.body_from_frame)
    }

    pub(crate) fn in_world(pose: &Pose) -> Self {
        Self::new(WORLD, pose)
    }

    fn new(body: usize, pose: &Pose) -> Self {
        let rotation = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
        Self { body, rotation, translation: pose.translation.into() }
    }

    /// Its axes and its origin in the world.
    fn placed(&self, placement: &Placement) -> (Matrix3<f64>, Vector3<f64>) {
        let (rotation, origin) = placement.body(self.body);
        (rotation * self.rotation, origin + rotation * self.translation)
    }
}

/// The motion that a row prevents, between two sites a and b, or of b in the world.
#[derive(Clone, Debug)]
pub enum ConstrainedDirection {
    /// φ = a_k·(p_b − p_a).
    Shift(usize),
    /// φ = Σ c aᵢ·bⱼ.
    Turn(Vec<(f64, usize, usize)>),
    /// Component k of b's velocity, or k − 3 of its angular velocity, along b's own axes.
    Slip(usize),
    /// A component of the velocity of a disc's contact point on a plane.
    Roll(Box<Rolling>),
}

/// A thin disc about the origin of b, with this axle in b, on the plane n·x = offset. Its point p − r u does
/// not move along the heading (0), across it (1), or along n (2), where φ is its height.
#[derive(Clone, Debug)]
pub struct Rolling {
    pub(crate) axle: Vector3<f64>,
    pub(crate) radius: f64,
    pub normal: Vector3<f64>,
    pub offset: f64,
    pub direction: usize,
}

/// An equality with its rows.
#[derive(Clone, Debug)]
pub enum Relation {
    /// Between two sites a and b.
    Sites([Site; 2], Vec<ConstrainedDirection>),
    /// y = p(x) of two sums of joint positions.
    Polynomial { joint: JointSum, leader: JointSum, polynomial: [f64; 5] },
    /// Σ cᵢvᵢ = 0; φ = Σ cᵢqᵢ − offset of these entries of q, if they are plain numbers.
    Sum { terms: Vec<(usize, f64)>, positions: Option<Vec<(usize, f64)>>, offset: f64 },
}

/// A row at the last configuration.
#[derive(Clone, Debug)]
pub struct EqualityRow {
    /// Its coordinates, in increasing order, with their factors.
    pub terms: Vec<(usize, f64)>,
    /// φ, if the row has one.
    pub error: Option<f64>,
    /// Rows of one relation and unit have the same number; a short row among them is rounding.
    pub(crate) group: usize,
}

clone_in_place! {
    /// All rows of a robot's equalities.
    #[derive(Debug)]
    pub struct EqualityRows {
        placement: Placement,
        relations: Vec<Placed>,
        rows: Vec<EqualityRow>,
    }
}

#[derive(Clone, Debug)]
struct Placed {
    relation: Relation,
    /// The index of its first row.
    first: usize,
    /// The body that carries both sites, or [`WORLD`].
    common: usize,
}

impl EqualityRows {
    pub fn new(model: &Model, relations: impl IntoIterator<Item = Relation>) -> Self {
        let mut all = Self { placement: Placement::new(model), relations: Vec::new(), rows: Vec::new() };
        for relation in relations {
            let first = all.rows.len();
            let (common, support, count) = match &relation {
                Relation::Sites([a, b], forbidden) => {
                    // A slip row is relative to the world: a is the world.
                    let (common, support) = between(model, a.body, b.body);
                    (common, support, forbidden.len())
                }
                Relation::Polynomial { joint, leader, .. } => {
                    (WORLD, joint.terms().chain(leader.terms()).map(|(k, _)| k).collect(), 1)
                }
                Relation::Sum { terms, .. } => (WORLD, terms.iter().map(|(k, _)| *k).collect(), 1),
            };
            let terms: Vec<(usize, f64)> = support.into_iter().map(|k| (k, 0.0)).collect();
            let is_turn = |row: usize| match &relation {
                Relation::Sites(_, forbidden) => match &forbidden[row] {
                    ConstrainedDirection::Turn(_) => true,
                    ConstrainedDirection::Slip(k) => *k >= 3,
                    ConstrainedDirection::Shift(_) | ConstrainedDirection::Roll(_) => false,
                },
                Relation::Polynomial { .. } | Relation::Sum { .. } => false,
            };
            let group = |row: usize| 2 * all.relations.len() + usize::from(is_turn(row));
            let row = |row: usize| EqualityRow { terms: terms.clone(), error: None, group: group(row) };
            let rows: Vec<EqualityRow> = (0..count).map(row).collect();
            all.rows.extend(rows);
            all.relations.push(Placed { relation, first, common });
        }
        all
    }

    /// The rows at the last configuration.
    pub fn rows(&self) -> &[EqualityRow] {
        &self.rows
    }

    /// Computes all rows at q.
    pub fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        let Self { placement, relations, rows } = self;
        if relations.iter().any(|placed| matches!(placed.relation, Relation::Sites(..))) {
            placement.set(model, workspace, q);
        }
        for Placed { relation, first, common } in relations {
            match relation {
                Relation::Sites(sites, forbidden) => {
                    let at = [&sites[0], &sites[1]].map(|site| site.placed(placement));
                    let bodies = [sites[0].body, sites[1].body];
                    for (row, forbidden) in rows[*first..].iter_mut().zip(forbidden) {
                        let found = forbidden.at(&at);
                        row.error = found.error;
                        row.terms.iter_mut().for_each(|(_, factor)| *factor = 0.0);
                        for (body, sign) in [(bodies[1], 1.0), (bodies[0], -1.0)] {
                            let point = found.point;
                            placement.each_motion_on(model, [body, *common], point, |dof, velocity, spin| {
                                let moved = found.along.dot(&velocity) + found.about.dot(&spin);
                                add(&mut row.terms, dof.coordinate, sign * dof.ratio * moved);
                            });
                        }
                    }
                }
                Relation::Polynomial { joint, leader, polynomial } => {
                    let x = leader.at(q);
                    // p and p′ by Horner's rule.
                    let (mut p, mut slope) = (0.0, 0.0);
                    for c in polynomial.iter().rev() {
                        slope = slope * x + p;
                        p = p * x + c;
                    }
                    let row = &mut rows[*first];
                    row.error = Some(joint.at(q) - p);
                    row.terms.iter_mut().for_each(|(_, factor)| *factor = 0.0);
                    joint.terms().for_each(|(k, c)| add(&mut row.terms, k, c));
                    leader.terms().for_each(|(k, c)| add(&mut row.terms, k, -slope * c));
                }
                Relation::Sum { terms, positions, offset } => {
                    let row = &mut rows[*first];
                    let length = |positions: &Vec<(usize, f64)>| {
                        positions.iter().map(|(at, c)| c * q[*at]).sum::<f64>() - *offset
                    };
                    row.error = positions.as_ref().map(length);
                    row.terms.iter_mut().for_each(|(_, factor)| *factor = 0.0);
                    for &(k, c) in &*terms {
                        add(&mut row.terms, k, c);
                    }
                }
            }
        }
    }

    /// Adds Aᵀλ to the forces.
    pub(crate) fn add_forces(&self, multipliers: &[f64], forces: &mut [f64]) {
        for (row, multiplier) in
            self.rows.iter().zip(multipliers).filter(|(_, multiplier)| **multiplier != 0.0)
        {
            row.terms.iter().for_each(|&(k, factor)| forces[k] += factor * multiplier);
        }
    }
}

/// A v as the velocity of b's point relative to a's along one direction plus b's relative angular velocity
/// about another, and φ.
struct Found {
    point: Vector3<f64>,
    along: Vector3<f64>,
    about: Vector3<f64>,
    error: Option<f64>,
}

impl ConstrainedDirection {
    fn at(&self, [(a, p_a), (b, p_b)]: &[(Matrix3<f64>, Vector3<f64>); 2]) -> Found {
        let none = Vector3::zeros();
        match self {
            // With the velocity of a's point there, the rotation of a_k is included.
            Self::Shift(k) => {
                let along: Vector3<f64> = a.column(*k).into();
                Found { point: *p_b, along, about: none, error: Some(along.dot(&(p_b - p_a))) }
            }
            // The rate of α·β is ω·(β × α).
            Self::Turn(products) => {
                let (mut about, mut error) = (none, 0.0);
                for &(c, i, j) in products {
                    let [alpha, beta]: [Vector3<f64>; 2] = [a.column(i).into(), b.column(j).into()];
                    about += beta.cross(&alpha) * c;
                    error += c * alpha.dot(&beta);
                }
                Found { point: *p_b, along: none, about, error: Some(error) }
            }
            Self::Slip(k) => {
                let axis = b.column(k % 3).into();
                let (along, about) = if *k < 3 { (axis, none) } else { (none, axis) };
                Found { point: *p_b, along, about, error: None }
            }
            Self::Roll(rolling) => {
                let Rolling { axle, radius, normal: n, offset, direction } = &**rolling;
                let s = b * axle;
                let w = n - s * n.dot(&s);
                let (length, h) = (w.norm(), s.cross(n) / w.norm());
                let along = [h, n.cross(&h), *n][*direction];
                let error = (*direction == 2).then(|| n.dot(p_b) - radius * length - offset);
                Found { point: p_b - w * (radius / length), along, about: none, error }
            }
        }
    }
}

/// Adds to the factor of a coordinate. A coordinate that is not among the terms moves both sides alike.
fn add(terms: &mut [(usize, f64)], coordinate: usize, factor: f64) {
    if let Ok(at) = terms.binary_search_by_key(&coordinate, |(k, _)| *k) {
        terms[at].1 += factor;
    }
}

/// The body that carries both, and the coordinates that move one relative to the other.
fn between(model: &Model, a: usize, b: usize) -> (usize, BTreeSet<usize>) {
    let path = |body: usize| {
        let parent = |&at: &usize| (model.bodies[at].parent != WORLD).then(|| model.bodies[at].parent);
        core::iter::successors((body != WORLD).then_some(body), parent)
    };
    let common = path(a).find(|body| path(b).any(|other| other == *body)).unwrap_or(WORLD);
    let coordinates = [a, b].into_iter().flat_map(|body| {
        path(body).take_while(|at| *at != common).flat_map(|at| {
            let dofs = model.bodies[at].dof..model.bodies[at].dof + model.bodies[at].motion.nv();
            dofs.map(|dof| model.dofs[dof].coordinate)
        })
    });
    (common, coordinates.collect())
}
