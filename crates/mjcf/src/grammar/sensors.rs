//! Sensors: the supported ones with their attributes, and the reasons for which the others are not supported.

use super::rule::Handling::NotDynamics;
use super::rule::{Rule, read, rule};

const PARENTS: &[&str] = &["sensor"];

/// Attributes of every sensor that do not enter its value.
const IGNORED: &[&str] = &["user", "nsample", "interp", "interval"];

/// A sensor with these attributes in addition to those of every sensor.
macro_rules! sensor {
    ($name:literal $(, $own:literal)*) => {
        read(PARENTS, $name, &["name", "cutoff", "noise", "delay" $(, $own)*]).ignored(IGNORED)
    };
}

macro_rules! frame {
    ($name:literal) => {
        sensor!($name, "objtype", "objname", "reftype", "refname")
    };
}

const fn unsupported(name: &'static str, why: &'static str) -> Rule {
    rule(PARENTS, name, NotDynamics(why))
}

pub(super) const RULES: &[Rule] = &[
    sensor!("accelerometer", "site"),
    sensor!("velocimeter", "site"),
    sensor!("gyro", "site"),
    sensor!("magnetometer", "site"),
    sensor!("force", "site"),
    sensor!("torque", "site"),
    sensor!("touch", "site"),
    sensor!("jointpos", "joint"),
    sensor!("jointvel", "joint"),
    sensor!("jointactuatorfrc", "joint"),
    sensor!("jointlimitpos", "joint"),
    sensor!("jointlimitvel", "joint"),
    sensor!("jointlimitfrc", "joint"),
    sensor!("ballquat", "joint"),
    sensor!("ballangvel", "joint"),
    sensor!("tendonpos", "tendon"),
    sensor!("tendonvel", "tendon"),
    sensor!("tendonactuatorfrc", "tendon"),
    sensor!("tendonlimitpos", "tendon"),
    sensor!("tendonlimitvel", "tendon"),
    sensor!("tendonlimitfrc", "tendon"),
    sensor!("actuatorpos", "actuator"),
    sensor!("actuatorvel", "actuator"),
    sensor!("actuatorfrc", "actuator"),
    frame!("framepos"),
    frame!("framequat"),
    frame!("framexaxis"),
    frame!("frameyaxis"),
    frame!("framezaxis"),
    frame!("framelinvel"),
    frame!("frameangvel"),
    sensor!("framelinacc", "objtype", "objname"),
    sensor!("frameangacc", "objtype", "objname"),
    sensor!("subtreecom", "body"),
    sensor!("subtreelinvel", "body"),
    sensor!("subtreeangmom", "body"),
    sensor!("insidesite", "site", "objtype", "objname").physics(&[("enclosed", "false")]),
    sensor!("e_potential"),
    sensor!("e_kinetic"),
    sensor!("clock"),
    unsupported("rangefinder", "sensor not supported: rays to shapes are not computed"),
    unsupported("camprojection", "sensor not supported: cameras are not in the model"),
    unsupported("distance", "sensor not supported: distances between shapes are not computed"),
    unsupported("normal", "sensor not supported: distances between shapes are not computed"),
    unsupported("fromto", "sensor not supported: distances between shapes are not computed"),
    unsupported("contact", "sensor not supported: contacts are results of the simulation"),
    unsupported("tactile", "sensor not supported: pressures on meshes are not computed"),
    unsupported("user", "sensor not supported: a user program computes its value"),
    unsupported("plugin", "sensor not supported: a plugin computes its value"),
];
