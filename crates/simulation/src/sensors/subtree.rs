//! Centre of mass, its velocity, and angular momentum of a link and its descendants.

use robot_dynamics_core::Model;
use robot_dynamics_core::algorithms::frame_motion::MovingFrame;
use robot_dynamics_core::algorithms::joint_reactions::rotation;
use robot_dynamics_core::workspace::tree::TreeMemory;
use robot_dynamics_description::SensorKind;
use robot_dynamics_number::algebra::{M3, V3};

/// The motion of one link's centre of mass.
struct Link {
    mass: f64,
    center: V3<f64>,
    velocity: V3<f64>,
    /// I ω about the centre of mass.
    spin: V3<f64>,
}

/// Σ m c / Σ m, Σ m ċ / Σ m, or Σ (c − C) × m ċ + I ω, at the bodies' present motion.
pub(super) fn subtree_value(
    model: &Model,
    tree: &TreeMemory<f64>,
    segment: usize,
    kind: SensorKind,
) -> [f64; 3] {
    let links = segment..model.segments.list[segment].end;
    let (mut mass, mut center, mut momentum) = (0.0, V3::zero(), V3::zero());
    for link in links.clone().map(|index| of_link(model, tree, index)) {
        mass += link.mass;
        center = center.add_scaled(link.mass, link.center);
        momentum = momentum.add_scaled(link.mass, link.velocity);
    }
    if mass == 0.0 {
        let still = kind != SensorKind::SubtreeCenterOfMass;
        return if still { [0.0; 3] } else { of_link(model, tree, segment).center.array() };
    }
    let center = center * (1.0 / mass);
    match kind {
        SensorKind::SubtreeCenterOfMass => center.array(),
        SensorKind::SubtreeLinearVelocity => (momentum * (1.0 / mass)).array(),
        _ => {
            let mut angular = V3::zero();
            for link in links.map(|index| of_link(model, tree, index)) {
                angular += link.spin + (link.center - center).cross(link.velocity * link.mass);
            }
            angular.array()
        }
    }
}

fn of_link(model: &Model, tree: &TreeMemory<f64>, index: usize) -> Link {
    let segment = &model.segments.list[index];
    let at = MovingFrame::at(model, tree, segment.body);
    let turn = rotation(tree, segment);
    // Relative to the link's origin, and to the body's.
    let own = if segment.mass == 0.0 {
        V3::zero()
    } else {
        turn * V3::constant(&segment.first_moment) * (1.0 / segment.mass)
    };
    let arm = at.place.rotation * V3::constant(&segment.translation) + own;
    let from_point = at.place.translation + arm;
    let omega = at.twist.angular;
    let velocity = at.twist.linear + omega.cross(from_point);
    let about_origin = turn * (M3::constant(&segment.inertia) * turn.transpose_mul(omega));
    let spin = about_origin - own.cross(omega.cross(own)) * segment.mass;
    Link { mass: segment.mass, center: at.origin + from_point, velocity, spin }
}
