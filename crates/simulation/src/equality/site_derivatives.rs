//! The derivatives of rows between two sites.
//!
//! A row is a closed formula of the poses and motions of both sites. Dual numbers give its gradient by these,
//! and `motion_columns` the derivatives of the motions by the coordinates.

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;

use super::direction::ConstrainedDirection;
use super::site::{Site, SitePlace};
use crate::motion_columns::{
    MotionColumn, MotionGradient, Seeded, Six, force_derivative, motion_columns, seeded_motion, seeded_place,
    wrench_derivative,
};
use crate::placement::{BodyMotion, Placement};

/// The factors of a combination of A a + Ȧv and A v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowWeights {
    /// The factor of A a + Ȧv.
    pub(crate) acceleration: f64,
    /// The factor of A v.
    pub(crate) rate: f64,
}

/// Two sites at a state.
pub(super) struct MovingSites {
    bodies: [usize; 2],
    places: [SitePlace; 2],
    moving: [BodyMotion; 2],
    columns: [Vec<MotionColumn>; 2],
}

impl MovingSites {
    /// `common` is the body that carries both sites.
    pub(super) fn new(
        model: &Model,
        sites: &[Site; 2],
        common: usize,
        (placement, motions): (&Placement, &[BodyMotion]),
    ) -> Self {
        let places = [&sites[0], &sites[1]].map(|site| site.place(placement));
        let columns = [0, 1]
            .map(|k| motion_columns(model, (placement, motions), [sites[k].body, common], places[k].origin));
        Self {
            bodies: [sites[0].body, sites[1].body],
            moving: [&sites[0], &sites[1]].map(|site| site.motion(placement, motions)),
            places,
            columns,
        }
    }

    /// Whether the row is a component of the motion of b's origin along an axis that is fixed in the world.
    fn is_point_in_world(&self, direction: &ConstrainedDirection) -> bool {
        self.bodies[0] == WORLD && matches!(direction, ConstrainedDirection::Shift(_))
    }

    /// Both places, with the derivatives by the pose of one.
    fn seeded_places(&self, variable: Option<usize>) -> [SitePlace<Seeded>; 2] {
        [0, 1].map(|k| {
            let SitePlace { axes, origin } = &self.places[k];
            let (axes, origin) = seeded_place(axes, origin, variable == Some(k));
            SitePlace { axes, origin }
        })
    }

    /// Both motions, with the derivatives by the velocity of one.
    fn seeded_motions(&self, variable: Option<usize>) -> [BodyMotion<Seeded>; 2] {
        [0, 1].map(|k| seeded_motion(&self.moving[k], variable == Some(k)))
    }

    /// Calls `visit` with coordinates and the derivatives of a row's combination by q and v. A coordinate may
    /// come several times.
    pub(super) fn each_entry(
        &self,
        direction: &ConstrainedDirection,
        weights: RowWeights,
        mut visit: impl FnMut(usize, [f64; 2]),
    ) {
        let wrenches = direction.row(&self.places).wrenches(&self.places).map(six);
        for k in (0..2).filter(|&k| self.bodies[k] != WORLD) {
            let gradient = self.gradient(direction, weights, k, &wrenches[k]);
            for column in &self.columns[k] {
                visit(column.coordinate, gradient.by_state(column));
            }
        }
    }

    /// The gradient of a row's combination by the motion of site k; `wrench` is that by its velocity of A v.
    fn gradient(
        &self,
        direction: &ConstrainedDirection,
        weights: RowWeights,
        k: usize,
        wrench: &Six,
    ) -> MotionGradient {
        let mut gradient = MotionGradient::default();
        if self.is_point_in_world(direction) {
            // A v = e·ṗ and A a + Ȧv = e·p̈, with e fixed in the world.
            gradient.velocity = wrench.map(|x| weights.rate * x);
            gradient.acceleration = wrench.map(|x| weights.acceleration * x);
            return gradient;
        }
        let places = self.seeded_places(Some(k));
        let moving = self.seeded_motions(None);
        if weights.rate != 0.0 {
            let rate = direction.row(&places).rate(&places, &moving);
            gradient.pose = rate.gradient.map(|x| weights.rate * x);
            gradient.velocity = wrench.map(|x| weights.rate * x);
        }
        if weights.acceleration != 0.0 {
            let by_pose = direction.acceleration(&places, &moving).gradient;
            let by_velocity =
                direction.acceleration(&self.seeded_places(None), &self.seeded_motions(Some(k))).gradient;
            for i in 0..6 {
                gradient.pose[i] += weights.acceleration * by_pose[i];
                gradient.velocity[i] += weights.acceleration * by_velocity[i];
                gradient.acceleration[i] = weights.acceleration * wrench[i];
            }
        }
        gradient
    }

    /// Calls `add` with the entries (i, j) of ∂(Aᵀλ)/∂q for the rows of these directions.
    pub(super) fn force_derivative(
        &self,
        directions: &[ConstrainedDirection],
        multipliers: &[f64],
        add: impl FnMut(usize, usize, f64),
    ) {
        if directions.iter().all(|direction| self.is_point_in_world(direction)) {
            // A force on a point keeps its components.
            let mut sum = [0.0; 6];
            for (direction, multiplier) in directions.iter().zip(multipliers) {
                let [_, on_b] = direction.row(&self.places).wrenches(&self.places).map(six);
                sum.iter_mut().zip(on_b).for_each(|(sum, x)| *sum += multiplier * x);
            }
            return wrench_derivative(&self.columns[1], &sum, add);
        }
        let wrenches = |variable: usize| {
            let places = self.seeded_places(Some(variable));
            let mut sum = vec![[Seeded::constant(0.0); 6]; 2];
            for (direction, multiplier) in directions.iter().zip(multipliers) {
                let wrenches = direction.row(&places).wrenches(&places);
                for (sum, [force, moment]) in sum.iter_mut().zip(wrenches) {
                    for (i, part) in force.iter().chain(&moment).enumerate() {
                        sum[i] += *part * Seeded::constant(*multiplier);
                    }
                }
            }
            sum
        };
        force_derivative(&self.columns, wrenches, add);
    }
}

fn six([force, moment]: [Vector3<f64>; 2]) -> Six {
    crate::motion_columns::six(force, moment)
}
