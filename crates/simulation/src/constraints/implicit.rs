//! Constraints in implicit steps.

use nalgebra::{Unit, Vector3};
use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_description::Pose;

use super::frame_constraint::products;
use super::{Anchor, Constraint, ConstraintSet, FrameConstraint, RollingDisc, SpatialAxis};
use crate::ImplicitIntegrator;
use crate::contact::{ConstrainedDirection, EqualityRows, Relation, Rolling, Site};

impl ImplicitIntegrator {
    /// Adds these constraints to those of friction, stops and contacts. They become rows of the step's convex
    /// problem, with multipliers of either sign ([`constraint_forces`](Self::constraint_forces)).
    /// [`ConstraintSet::from_equalities`] returns a robot's own.
    ///
    /// At the end of a step A v = 0, and φ = 0 to 1e-12 m or rad; the constraints do no work. Rows that
    /// depend on others to 1e-5 of their length are left out. A [`Simulation`](crate::simulator::Simulation)
    /// rejects a start with a larger error. Single steps accept it, and their φ decays with a time constant
    /// of 0.1 s.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub(crate) fn with_constraints(self, model: &Model, constraints: &ConstraintSet) -> Self {
        constraints.check_robot(model);
        if constraints.is_empty() {
            return self;
        }
        let relations = constraints.constraints().map(|(_, constraint)| relation(model, constraint));
        let rows = EqualityRows::new(model, relations);
        self.with_equalities(model, rows, constraints.row_names().to_vec())
    }
}

/// The rows of a constraint.
fn relation(model: &Model, constraint: &Constraint) -> Relation {
    let site = |anchor: &Anchor| match anchor {
        Anchor::Frame(frame) => Site::of_frame(model, *frame),
        Anchor::World(pose) => Site::in_world(pose),
    };
    let world = Site::in_world(&Pose::IDENTITY);
    match constraint {
        Constraint::FrameConstraint(FrameConstraint { a, b, rows }) => {
            let turns: Vec<usize> = rows.iter().filter(|row| row.is_turn()).map(|row| row.axis()).collect();
            let forbidden = |row: &SpatialAxis| {
                if row.is_turn() {
                    ConstrainedDirection::Turn(products(row.axis(), &turns))
                } else {
                    ConstrainedDirection::Shift(row.axis())
                }
            };
            Relation::Sites([site(a), site(b)], rows.iter().map(forbidden).collect())
        }
        Constraint::NoSlip(no_slip) => {
            let forbidden =
                no_slip.rows.iter().map(|row| ConstrainedDirection::Slip(*row as usize)).collect();
            Relation::Sites([world, Site::of_frame(model, no_slip.frame)], forbidden)
        }
        Constraint::RollingDisc(RollingDisc { frame, axle, radius, plane, rows }) => {
            let forbidden = rows.iter().map(|row| {
                ConstrainedDirection::Roll(Box::new(Rolling {
                    axle: Unit::new_normalize(Vector3::from(*axle)).into_inner(),
                    radius: *radius,
                    normal: plane.normal.into_inner(),
                    offset: plane.offset,
                    direction: *row as usize,
                }))
            });
            Relation::Sites([world, Site::of_frame(model, *frame)], forbidden.collect())
        }
        Constraint::Coupling(coupling) => {
            let position = |&(coordinate, factor): &(usize, f64)| {
                let plain = coordinate_ranges(model).find(|s| s.chart == Chart::Line && s.v == coordinate)?;
                Some((plain.q, factor))
            };
            Relation::Sum {
                terms: coupling.terms.clone(),
                positions: coupling.terms.iter().map(position).collect(),
                offset: coupling.offset,
            }
        }
        Constraint::PolynomialCoupling(coupling) => Relation::Polynomial {
            joint: coupling.joint.clone(),
            leader: coupling.leader.clone(),
            polynomial: coupling.polynomial,
        },
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{Workspace, random_state};
    use robot_dynamics_description::{RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::constraints::{Coupling, NoSlip, Plane, PolynomialCoupling, RollingRow};

    /// The rows by the bodies' placements equal those by the frames' Jacobians, for every kind of constraint,
    /// on trees with ball, floating and mimic joints.
    #[test]
    fn rows_are_those_of_the_set() {
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).unwrap();
            let mut random = SplitMix64::new(seed);
            let links: Vec<&str> = model.description().links.iter().map(|link| link.name.as_str()).collect();
            let mut frame = || {
                let at = random.uniform(0.0, links.len() as f64 - 1e-9);
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                // below the number of links
                model.frame(links[at as usize]).unwrap()
            };
            let [a, b, c, d, e] = core::array::from_fn(|_| frame());
            let place = Pose::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, 0.5, -0.6]);
            let rolls = RollingDisc {
                frame: e,
                axle: [0.3, 2.0, -0.5],
                radius: 0.3,
                plane: Plane::new([0.1, 0.2, 1.0], [0.0, 0.0, 0.4]),
                rows: vec![RollingRow::Normal, RollingRow::Forward, RollingRow::Side],
            };
            let turns = [SpatialAxis::Y, SpatialAxis::Rz];
            let mut all: Vec<(&str, Constraint)> = vec![
                ("weld", FrameConstraint::between(a, b, &FrameConstraint::WELD).into()),
                ("hinge", FrameConstraint::between(c, a, &FrameConstraint::HINGE).into()),
                ("universal", FrameConstraint::between(b, d, &turns).into()),
                ("held", FrameConstraint::contact(c, place, &FrameConstraint::WELD).into()),
                (
                    "slips",
                    NoSlip { frame: d, rows: vec![SpatialAxis::Y, SpatialAxis::Rx, SpatialAxis::Z] }.into(),
                ),
                ("rolls", rolls.into()),
            ];
            let names = model.coordinate_names();
            let terms = [(names[0].as_str(), 0.7), (names[names.len() - 1].as_str(), -1.3)];
            all.push(("sum", Coupling::new(&model, &terms, 0.2).unwrap().into()));
            let single: Vec<&str> = (model.joints().iter())
                .filter(|joint| joint.nv == 1 || joint.mimic.is_some())
                .map(|joint| joint.name.as_str())
                .collect();
            if let (Some(first), Some(last)) = (single.first(), single.last()) {
                let polynomial = [0.3, -0.7, 0.2, 0.1, -0.4];
                let cam = PolynomialCoupling::new(&model, (last, 0.3), Some((first, -0.1)), polynomial);
                all.push(("cam", cam.unwrap().into()));
            }
            let set = ConstraintSet::new(&model, all).unwrap();
            let relations = set.constraints().map(|(_, constraint)| relation(&model, constraint));
            let mut rows = EqualityRows::new(&model, relations);
            let workspace = &mut Workspace::new(&model);
            for _ in 0..3 {
                let state = random_state(&model, &mut random);
                let expected = set.rows(&model, workspace, &state.q, &state.v);
                rows.place(&model, workspace, &state.q);
                assert_eq!(rows.rows().len(), set.len());
                for (i, row) in rows.rows().iter().enumerate() {
                    let mut dense = vec![0.0; model.nv()];
                    row.terms.iter().for_each(|&(k, factor)| dense[k] = factor);
                    let scale = 1.0 + expected.matrix.row(i).amax();
                    for (k, found) in dense.iter().enumerate() {
                        let off = found - expected.matrix[(i, k)];
                        assert!(off.abs() < 1e-12 * scale, "robot {seed}, {}: {k} {off}", set.row_names()[i]);
                    }
                    assert_eq!(row.error.is_some(), expected.holonomic[i], "{}", set.row_names()[i]);
                    let off = row.error.unwrap_or(0.0) - expected.position_error[i];
                    assert!(off.abs() < 1e-12, "robot {seed}, {}: {off}", set.row_names()[i]);
                }
            }
        }
    }
}
