//! Sensors: those that are answered, with their attributes, and why the others are not.

use super::Sort::Aside;
use super::{Rule, read, rule};

const WITHIN: &[&str] = &["sensor"];

/// Attributes of every sensor that do not enter its value, or are told where they would.
const SIDE: &[&str] = &["user", "nsample", "interp", "interval"];

/// A sensor with these attributes beside those of every sensor.
macro_rules! sensor {
    ($name:literal $(, $own:literal)*) => {
        read(WITHIN, $name, &["name", "cutoff", "noise", "delay" $(, $own)*]).aside(SIDE)
    };
}

macro_rules! frame {
    ($name:literal) => {
        sensor!($name, "objtype", "objname", "reftype", "refname")
    };
}

const fn unanswered(name: &'static str, why: &'static str) -> Rule {
    rule(WITHIN, name, Aside(why))
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
    sensor!("insidesite", "site", "objtype", "objname"),
    sensor!("e_potential"),
    sensor!("e_kinetic"),
    sensor!("clock"),
    unanswered("rangefinder", "a sensor that is not answered: no rays are cast at shapes"),
    unanswered("camprojection", "a sensor that is not answered: cameras are not in the model"),
    unanswered("distance", "a sensor that is not answered: distances of shapes are not computed for it"),
    unanswered("normal", "a sensor that is not answered: distances of shapes are not computed for it"),
    unanswered("fromto", "a sensor that is not answered: distances of shapes are not computed for it"),
    unanswered("contact", "a sensor that is not answered: a run's contacts are its own results"),
    unanswered("tactile", "a sensor that is not answered: meshes have no pressure"),
    unanswered("user", "a sensor that is not answered: a program computes it"),
    unanswered("plugin", "a sensor that is not answered: a plugin computes it"),
];
