//! The quantity that each sensor reads, with its names resolved.

use core::ops::Range;

use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges};
use robot_dynamics_core::{Frame, Model};
use robot_dynamics_description::{
    Pose, SensorDescription, SensorKind, SensorObject, SpatialTendonDescription,
};

use super::zone::Zone;

pub(crate) use robot_dynamics_description::sensor::ObjectSort;

/// A sensor of a compiled robot.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    pub(super) name: String,
    pub(super) kind: SensorKind,
    pub(super) reading: Reading,
    /// Infinite if the sensor has none.
    pub(super) cutoff: f64,
    pub(super) range: Range<usize>,
}

#[derive(Clone, Debug)]
pub(super) enum Reading {
    Robot,
    Frame {
        on: Box<SensorFrame>,
        reference: Option<Box<SensorFrame>>,
        zone: Option<Zone>,
        field: [f64; 3],
    },
    /// A link and its descendants, by the number of its segment.
    Subtree(usize),
    /// A joint of one degree of freedom, or a tendon, with its limits. For a joint, its entry in v; for a
    /// tendon, its index.
    Length {
        length: JointSum,
        limits: [f64; 2],
        margin: f64,
        index: usize,
    },
    /// A spatial tendon by its number among these, with its limits.
    SpatialTendon {
        index: usize,
        limits: [f64; 2],
        margin: f64,
    },
    /// First entries in q and v.
    Ball {
        q: usize,
        v: usize,
    },
    Actuator(usize),
}

/// A frame that a sensor is attached to.
#[derive(Clone, Debug)]
pub(super) struct SensorFrame {
    pub(super) frame: Frame,
    pub(super) link_from_frame: Pose,
}

impl SensorFrame {
    fn new(model: &Model, object: &SensorObject) -> Self {
        let description = &model.description;
        // `Model::new` has found all names.
        let link_of = |name: &str| description.links.iter().position(|link| link.name == name).unwrap_or(0);
        let (link, link_from_frame) = match object {
            SensorObject::Named(name) => match description.frames.iter().find(|frame| frame.name == *name) {
                Some(frame) => (link_of(&frame.link), frame.link_from_frame),
                None => (link_of(name), Pose::IDENTITY),
            },
            SensorObject::CenterOfMass(name) => {
                let link = link_of(name);
                let mass = description.links[link].mass_properties.as_ref();
                let center = mass.map_or([0.0; 3], |mass| mass.center_of_mass().into());
                (link, Pose::from_translation(center))
            }
            SensorObject::Shape(name) => {
                let shape = description.shapes.iter().find(|shape| shape.name == *name);
                shape.map_or((0, Pose::IDENTITY), |shape| (link_of(&shape.link), shape.link_from_shape))
            }
            SensorObject::Robot => (0, Pose::IDENTITY),
        };
        let of_link = &model.frames[link];
        let body_from_frame = of_link.body_from_frame.compose(&link_from_frame);
        Self { frame: Frame::new(String::new(), link, of_link.body, body_from_frame), link_from_frame }
    }
}

impl Reading {
    pub(super) fn new(model: &Model, sensor: &SensorDescription) -> Self {
        let description = &model.description;
        let name = match &sensor.object {
            SensorObject::Named(name) => name.as_str(),
            _ => "",
        };
        match sensor.kind.sort() {
            ObjectSort::Robot => Self::Robot,
            ObjectSort::Frame => {
                let sensed = |object| Box::new(SensorFrame::new(model, object));
                let reference = sensor.reference.as_ref().map(sensed);
                let zone = sensor.zone.as_ref().and_then(Zone::new);
                Self::Frame { on: sensed(&sensor.object), reference, zone, field: sensor.field }
            }
            ObjectSort::Link => {
                let link = description.links.iter().position(|link| link.name == name).unwrap_or(0);
                Self::Subtree(model.segments.of_link[link])
            }
            ObjectSort::Joint => {
                let joint = description.joints.iter().find(|joint| joint.name == name);
                let (limits, margin) = joint.map_or(([f64::NEG_INFINITY, f64::INFINITY], 0.0), |joint| {
                    ([joint.limits.lower, joint.limits.upper], joint.softness.margin)
                });
                let index = model.joint(name).map_or(0, |joint| joint.v_index);
                Self::Length { length: JointSum::new(model, 0.0, [(name, 1.0)]), limits, margin, index }
            }
            ObjectSort::Ball => {
                let first = model.joint(name).map_or(0, |joint| joint.v_index);
                let stretch = coordinate_ranges(model).find(|stretch| stretch.v == first);
                let (q, v) = stretch.map_or((0, 0), |CoordinateRange { q, v, .. }| (q, v));
                Self::Ball { q, v }
            }
            ObjectSort::Tendon => {
                let spatial = &description.spatial_tendons;
                if let Some(index) = spatial.iter().position(|tendon| tendon.name == name) {
                    let SpatialTendonDescription { limits, softness, .. } = &spatial[index];
                    let (limits, margin) = ([limits.lower, limits.upper], softness.margin);
                    return Self::SpatialTendon { index, limits, margin };
                }
                let index = description.tendons.iter().position(|tendon| tendon.name == name).unwrap_or(0);
                let tendon = &description.tendons[index];
                Self::Length {
                    length: JointSum::of_tendon(model, tendon),
                    limits: [tendon.limits.lower, tendon.limits.upper],
                    margin: tendon.softness.margin,
                    index,
                }
            }
            ObjectSort::Actuator => {
                let index = description.actuators.iter().position(|actuator| actuator.name == name);
                Self::Actuator(index.unwrap_or(0))
            }
        }
    }
}

/// −Σ m g·c of links fixed to the world, which [`potential_energy`](robot_dynamics_core::potential_energy)
/// leaves out.
pub(super) fn energy_of_fixed_links(model: &Model) -> f64 {
    let gravity = model.gravity();
    let fixed = model.description.links.iter().zip(&model.frames).filter(|(_, frame)| frame.body.is_none());
    let weight = fixed.filter_map(|(link, frame)| {
        let mass = link.mass_properties.as_ref()?;
        let center = frame.body_from_frame.apply(mass.center_of_mass().into());
        Some(-mass.mass() * center.iter().zip(gravity).map(|(c, g)| c * g).sum::<f64>())
    });
    weight.sum()
}
