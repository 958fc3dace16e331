//! The rows of A of constraints, and those of joints: limits, friction, equalities.

use std::collections::HashMap;

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::factorization::sparse::{coordinate_parents, dof_ancestors};
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_description::{
    Equality, JointKind, JointSolverImpedance, RobotDescription, SolverImpedance, TendonSolverImpedance,
};

use super::connection::Connection;
use super::weights::InverseWeights;
use crate::equality::polynomial::PolynomialRelation;
use crate::equality::position::CoupledPosition;

clone_in_place! {
    /// The constraints of joints and tendons.
    #[derive(Debug)]
    pub(super) struct JointRows {
        pub(super) frictions: Vec<Friction>,
        pub(super) limits: Vec<Limit>,
        pub(super) turns: Vec<BallLimit>,
        pub(super) tendons: Vec<TendonLimit>,
        pub(super) paths: Vec<PathRows>,
        pub(super) equalities: Vec<PolynomialEquality>,
        pub(super) connections: Vec<Connection>,
        /// Derivatives of a length by all coordinates.
        pub(super) memory: Vec<f64>,
        /// Whether the coordinates of each row lie on one path to the root.
        pub(super) keeps_tree: bool,
    }
}

#[derive(Clone, Debug)]
pub(super) struct Friction {
    /// Its coordinates, in increasing order, with ∂/∂q of the position along which friction acts.
    pub(super) derivatives: Vec<(usize, f64)>,
    /// \[N·m or N\].
    pub(super) most: f64,
    pub(super) softness: SolverImpedance,
    pub(super) weight: f64,
}

/// sign·(ratio·q + offset − bound) ≥ 0.
#[derive(Clone, Debug)]
pub(super) struct Limit {
    pub(super) q: usize,
    pub(super) coordinate: usize,
    pub(super) ratio: f64,
    pub(super) offset: f64,
    pub(super) bound: f64,
    pub(super) sign: f64,
    pub(super) margin: f64,
    pub(super) softness: SolverImpedance,
    pub(super) weight: f64,
}

/// most − |log q| ≥ 0 of a ball joint.
#[derive(Clone, Debug)]
pub(super) struct BallLimit {
    pub(super) q: usize,
    pub(super) coordinate: usize,
    pub(super) most: f64,
    pub(super) margin: f64,
    pub(super) softness: SolverImpedance,
    pub(super) weight: f64,
}

/// sign·(ℓ − bound) ≥ 0 of a tendon's length.
#[derive(Clone, Debug)]
pub(super) struct TendonLimit {
    /// The index in the description.
    pub(super) number: usize,
    pub(super) length: JointSum,
    /// ∂ℓ/∂q by its coordinates, in increasing order.
    pub(super) derivatives: Vec<(usize, f64)>,
    pub(super) bound: f64,
    pub(super) sign: f64,
    pub(super) softness: TendonSolverImpedance,
    pub(super) weight: f64,
}

/// The dry friction and the limits of a spatial tendon.
#[derive(Clone, Debug)]
pub(super) struct PathRows {
    /// The index among all tendons, those over joints first.
    pub(super) number: usize,
    pub(super) path: TendonPath,
    /// The coordinates that may change the length, in increasing order.
    pub(super) support: Vec<usize>,
    /// Dry friction \[N\].
    pub(super) most: f64,
    /// The bounds of the length, each with the sign of sign·(ℓ − bound) ≥ 0.
    pub(super) bounds: Vec<(f64, f64)>,
    pub(super) softness: TendonSolverImpedance,
    pub(super) weight: f64,
}

/// y − y⁰ = Σ cₖ(x − x⁰)ᵏ of two positions.
#[derive(Clone, Debug)]
pub(super) struct PolynomialEquality {
    pub(super) relation: PolynomialRelation,
    /// The coordinates of both positions, in increasing order.
    pub(super) support: Vec<usize>,
    pub(super) softness: SolverImpedance,
    pub(super) weight: f64,
}

impl JointRows {
    pub(super) fn new(model: &Model, weights: &InverseWeights) -> Self {
        let described: HashMap<&str, &JointSolverImpedance> =
            model.description().joints.iter().map(|joint| (joint.name.as_str(), &joint.softness)).collect();
        let of = |joint: usize| -> JointSolverImpedance {
            described.get(model.joints[joint].name.as_str()).copied().copied().unwrap_or_default()
        };
        let mut rows = Self {
            frictions: Vec::new(),
            limits: Vec::new(),
            turns: Vec::new(),
            tendons: Vec::new(),
            paths: Vec::new(),
            equalities: Vec::new(),
            connections: Vec::new(),
            memory: vec![0.0; model.nv],
            keeps_tree: true,
        };
        rows.add_degrees_of_freedom(model, weights, of);
        rows.add_ball_joints(model, weights, of);
        rows.add_tendons(model, weights);
        rows.add_paths(model, weights);
        rows.add_equalities(model, weights);
        rows.keeps_tree &= rows.equalities.is_empty() && rows.connections.is_empty();
        rows
    }

    /// Adds dry friction and limits of joints with one degree of freedom.
    fn add_degrees_of_freedom(
        &mut self,
        model: &Model,
        weights: &InverseWeights,
        of: impl Fn(usize) -> JointSolverImpedance,
    ) {
        for dof in &model.dofs {
            let (k, softness, square) = (dof.coordinate, of(dof.joint), dof.ratio * dof.ratio);
            if dof.passive.friction > 0.0 {
                self.frictions.push(Friction {
                    derivatives: vec![(k, 1.0)],
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
                    self.limits.push(Limit {
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
    }

    /// Adds the limits of ball joints' angles.
    fn add_ball_joints(
        &mut self,
        model: &Model,
        weights: &InverseWeights,
        of: impl Fn(usize) -> JointSolverImpedance,
    ) {
        for (joint, own) in
            model.joints.iter().enumerate().filter(|(_, own)| own.kind == JointKind::Spherical)
        {
            let (most, softness) = (own.limits.turn, of(joint));
            if most.is_finite() {
                let (q, coordinate) = (own.q_index, own.v_index);
                let (margin, softness) = (softness.margin, softness.limit);
                let weight = weights.coordinates[coordinate];
                self.turns.push(BallLimit { q, coordinate, most, margin, softness, weight });
            }
        }
    }

    fn add_equalities(&mut self, model: &Model, weights: &InverseWeights) {
        for equality in model.description().equalities.iter().filter(|own| own.active) {
            let softness = SolverImpedance { solref: equality.solref, solimp: equality.solimp };
            let of_joint = |(name, reference): &(String, f64)| {
                let sum = JointSum::new(model, -*reference, [(name.as_str(), 1.0)]);
                let weight = sum.terms().map(|(k, c)| c * c * weights.coordinates[k]).sum();
                (CoupledPosition::Joints(sum), weight)
            };
            let of_tendon = |(name, reference): &(String, f64)| {
                let RobotDescription { tendons, spatial_tendons, .. } = model.description();
                let names = tendons.iter().map(|own| &own.name);
                let number =
                    names.chain(spatial_tendons.iter().map(|own| &own.name)).position(|own| own == name);
                let position = CoupledPosition::of_tendon(model, name, *reference).unwrap_or_default();
                (position, number.map_or(0.0, |number| weights.tendons[number]))
            };
            match &equality.kind {
                Equality::Joints { joint, leader, polynomial } => {
                    self.add_polynomial(
                        model,
                        [Some(of_joint(joint)), leader.as_ref().map(of_joint)],
                        *polynomial,
                        softness,
                    );
                }
                Equality::Tendons { tendon, leader, polynomial } => {
                    self.add_polynomial(
                        model,
                        [Some(of_tendon(tendon)), leader.as_ref().map(of_tendon)],
                        *polynomial,
                        softness,
                    );
                }
                Equality::Connect { a: (a, _), b: (b, _) } | Equality::Weld { a, b, .. } => {
                    let sides = ["a", "b"].map(|side| model.frame(&equality.frame_name(side)));
                    let [Some(one), Some(two)] = sides else { continue };
                    let of =
                        |link: &str| model.frame(link).map_or([0.0; 2], |link| weights.frames[link.index]);
                    let (frames, weights) = ([one, two], [0, 1].map(|part| of(a)[part] + of(b)[part]));
                    let torque_scale = match equality.kind {
                        Equality::Weld { torque_scale, .. } => Some(torque_scale),
                        _ => None,
                    };
                    self.connections.push(Connection { frames, torque_scale, softness, weights });
                }
            }
        }
    }

    /// Adds a relation of positions with their weights, unless no coordinate changes the first one.
    fn add_polynomial(
        &mut self,
        model: &Model,
        positions: [Option<(CoupledPosition, f64)>; 2],
        polynomial: [f64; 5],
        softness: SolverImpedance,
    ) {
        let [(position, weight), (leader, other)] = positions.map(Option::unwrap_or_default);
        if position.coordinates(model).is_empty() {
            return;
        }
        let relation = PolynomialRelation { position, leader, polynomial };
        let support = relation.coordinates(model).into_iter().collect();
        self.equalities.push(PolynomialEquality { relation, support, softness, weight: weight + other });
    }

    fn add_paths(&mut self, model: &Model, weights: &InverseWeights) {
        let dof_parent = coordinate_parents(model);
        let first = model.description().tendons.len();
        let described = &model.description().spatial_tendons;
        for (at, (tendon, path)) in described.iter().zip(TendonPath::all(model)).enumerate() {
            let bounds: Vec<(f64, f64)> = [(tendon.limits.lower, 1.0), (tendon.limits.upper, -1.0)]
                .into_iter()
                .filter(|(bound, _)| bound.is_finite())
                .collect();
            let support = path.coordinates(model);
            let Some((last, others)) = support.split_last() else { continue };
            let most = tendon.passive.friction;
            if bounds.is_empty() && most <= 0.0 {
                continue;
            }
            self.keeps_tree &= others.iter().all(|k| dof_ancestors(&dof_parent, *last).any(|i| i == *k));
            let (number, weight) = (first + at, weights.tendons[first + at]);
            self.paths.push(PathRows {
                number,
                path,
                support,
                most,
                bounds,
                softness: tendon.softness,
                weight,
            });
        }
    }

    fn add_tendons(&mut self, model: &Model, weights: &InverseWeights) {
        let dof_parent = coordinate_parents(model);
        for (number, (tendon, &weight)) in
            model.description().tendons.iter().zip(&weights.tendons).enumerate()
        {
            let length = JointSum::of_tendon(model, tendon);
            let derivatives = length.row();
            let Some(((last, _), others)) = derivatives.split_last() else { continue };
            let is_path = others.iter().all(|(k, _)| dof_ancestors(&dof_parent, *last).any(|i| i == *k));
            let most = tendon.passive.friction;
            if most > 0.0 {
                let (derivatives, softness) = (derivatives.clone(), tendon.softness.friction);
                self.frictions.push(Friction { derivatives, most, softness, weight });
                self.keeps_tree &= is_path;
            }
            for (bound, sign) in [(tendon.limits.lower, 1.0), (tendon.limits.upper, -1.0)] {
                if bound.is_finite() {
                    let (length, derivatives, softness) =
                        (length.clone(), derivatives.clone(), tendon.softness);
                    self.tendons.push(TendonLimit {
                        number,
                        length,
                        derivatives,
                        bound,
                        sign,
                        softness,
                        weight,
                    });
                    self.keeps_tree &= is_path;
                }
            }
        }
    }
}
