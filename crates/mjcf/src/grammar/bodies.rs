//! Bodies and what is in them.

use super::Sort::{Looks, Physics};
use super::{Rule, flexible, read, rule};

/// Where bodies and what is in them are found.
const BODIES: &[&str] = &["worldbody", "body", "frame", "replicate"];
/// The same for what has defaults.
const OR_DEFAULT: &[&str] = &["worldbody", "body", "frame", "replicate", "default"];

/// Elements of bodies, with those of `<default>` that stand behind them.
pub(super) const RULES: &[Rule] = &[
    read(
        BODIES,
        "body",
        &["name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mocap", "gravcomp"],
    )
    .aside(&["sleep", "simple", "user"]),
    read(BODIES, "frame", &["name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"]),
    read(BODIES, "replicate", &["count", "offset", "euler", "sep", "childclass"]),
    read(
        BODIES,
        "inertial",
        &["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mass", "diaginertia", "fullinertia"],
    ),
    read(
        OR_DEFAULT,
        "joint",
        &[
            "name",
            "class",
            "type",
            "pos",
            "axis",
            "springdamper",
            "limited",
            "actuatorfrclimited",
            "stiffness",
            "range",
            "actuatorfrcrange",
            "actuatorgravcomp",
            "ref",
            "springref",
            "armature",
            "damping",
            "frictionloss",
            "solreflimit",
            "solimplimit",
            "solreffriction",
            "solimpfriction",
            "margin",
        ],
    )
    .aside(&["group", "user"]),
    read(BODIES, "freejoint", &["name", "align"]).aside(&["group"]),
    read(
        OR_DEFAULT,
        "geom",
        &[
            "name",
            "class",
            "type",
            "contype",
            "conaffinity",
            "condim",
            "group",
            "priority",
            "size",
            "friction",
            "mass",
            "density",
            "shellinertia",
            "solmix",
            "solref",
            "solimp",
            "margin",
            "gap",
            "fromto",
            "pos",
            "quat",
            "axisangle",
            "xyaxes",
            "zaxis",
            "euler",
            "hfield",
            "mesh",
            "fitscale",
            "rgba",
            "material",
        ],
    )
    .aside(&["fluidcoef", "user"])
    .physics(&[("fluidshape", "none"), ("surfacevel", "0"), ("adhesion", "0")]),
    read(
        OR_DEFAULT,
        "site",
        &["name", "class", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "fromto", "type", "size"],
    )
    .aside(&["group", "material", "rgba", "user"]),
    rule(OR_DEFAULT, "camera", Looks),
    rule(OR_DEFAULT, "light", Looks),
    // An attachment that was made is a frame by now.
    read(BODIES, "attach", &["model", "body", "frame", "prefix"]),
    rule(BODIES, "plugin", Physics("the forces of a plugin are not in the model")),
    flexible(BODIES, "composite"),
    flexible(BODIES, "flexcomp"),
];
