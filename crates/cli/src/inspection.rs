//! The JSON output of `dynamics inspect`.

use robot_dynamics::description::{
    ActuatorDescription, Base, EndEffectorDescription, EqualityDescription, FluidShape, GroupDescription,
    Limits, LinkShape, LoadReport, Medium, Mimic, NamedPose, PassiveForces, SensorDescription,
    SpatialTendonDescription, TendonDescription,
};
use robot_dynamics::model::{Joint, Model};
use serde::Serialize;

use crate::inspect::{DefaultSimulation, MachineCode};
use crate::singular_poses::{Json, SingularPoses};

#[derive(Serialize)]
pub(crate) struct Inspection<'a> {
    name: &'a str,
    nq: usize,
    nv: usize,
    mass: f64,
    floating_base: bool,
    gravity: [f64; 3],
    joints: Vec<JointRow<'a>>,
    links: Vec<LinkRow<'a>>,
    actuators: &'a [ActuatorDescription],
    tendons: &'a [TendonDescription],
    /// The fluid and the shapes on which it acts; absent without a fluid.
    #[serde(skip_serializing_if = "Option::is_none")]
    medium: Option<Medium>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    fluid_shapes: &'a [FluidShape],
    spatial_tendons: &'a [SpatialTendonDescription],
    equalities: &'a [EqualityDescription],
    sensors: &'a [SensorDescription],
    poses: &'a [NamedPose],
    groups: &'a [GroupDescription],
    end_effectors: &'a [EndEffectorDescription],
    shapes: &'a [LinkShape],
    singular_mass: Json<'a>,
    simulation: &'a DefaultSimulation,
    machine_code: MachineCode,
    report: &'a LoadReport,
}

#[derive(Serialize)]
struct JointRow<'a> {
    name: &'a str,
    kind: &'static str,
    /// The parent link.
    parent: &'a str,
    child: &'a str,
    q_index: usize,
    nq: usize,
    v_index: usize,
    nv: usize,
    limits: &'a Limits,
    passive: &'a PassiveForces,
    mimic: &'a Option<Mimic>,
}

#[derive(Serialize)]
struct LinkRow<'a> {
    name: &'a str,
    mass: f64,
    /// In the link's frame; `None` without mass.
    center_of_mass: Option<[f64; 3]>,
    /// About the centre of mass, in the link's axes: xx, xy, xz, yy, yz, zz.
    inertia: Option<[f64; 6]>,
}

impl<'a> Inspection<'a> {
    pub(crate) fn of(
        model: &'a Model,
        report: &'a LoadReport,
        singular: &SingularPoses<'a>,
        simulation: &'a DefaultSimulation,
    ) -> Self {
        let joint = |joint: &'a Joint| JointRow {
            name: &joint.name,
            kind: joint.kind.name(),
            parent: &joint.parent_link,
            child: &joint.child_link,
            q_index: joint.q_index,
            nq: joint.nq,
            v_index: joint.v_index,
            nv: joint.nv,
            limits: &joint.limits,
            passive: &joint.passive,
            mimic: &joint.mimic,
        };
        let description = model.description();
        let links = description.links.iter().map(|link| {
            let body = link.mass_properties.as_ref();
            let inertia = body.map(robot_dynamics::description::MassProperties::inertia_about_center_of_mass);
            LinkRow {
                name: &link.name,
                mass: body.map_or(0.0, robot_dynamics::description::MassProperties::mass),
                center_of_mass: body.map(|body| body.center_of_mass().into()),
                inertia: inertia.map(|i| [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]),
            }
        });
        Self {
            name: model.name(),
            nq: model.nq(),
            nv: model.nv(),
            mass: model.total_mass(),
            floating_base: model.description().base == Base::Floating,
            gravity: model.gravity(),
            joints: model.joints().iter().map(joint).collect(),
            links: links.collect(),
            actuators: &description.actuators,
            tendons: &description.tendons,
            medium: Some(description.medium).filter(Medium::acts),
            fluid_shapes: &description.fluid_shapes,
            spatial_tendons: &description.spatial_tendons,
            equalities: &description.equalities,
            sensors: &description.sensors,
            poses: &description.poses,
            groups: &description.groups,
            end_effectors: &description.end_effectors,
            shapes: &description.shapes,
            singular_mass: singular.json(),
            simulation,
            machine_code: MachineCode::of(model),
            report,
        }
    }
}
