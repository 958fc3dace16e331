//! Bodies and their content.

use super::rule::Handling::{Appearance, Physics};
use super::rule::{Rule, deformable, read, rule};

/// The possible parents of bodies and their content.
const BODIES: &[&str] = &["worldbody", "body", "frame", "replicate"];
/// The possible parents of elements that have defaults.
const BODIES_OR_DEFAULT: &[&str] = &["worldbody", "body", "frame", "replicate", "default"];

/// Elements of bodies, and their defaults in `<default>`.
pub(super) const RULES: &[Rule] = &[
    read(
        BODIES,
        "body",
        &["name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mocap", "gravcomp"],
    )
    .ignored(&["sleep", "simple", "fuse", "user"]),
    read(
        BODIES,
        "frame",
        &[
            "name",
            "childclass",
            "pos",
            "quat",
            "axisangle",
            "xyaxes",
            "zaxis",
            "euler",
            "scale",
            "massscale",
            "scaling",
        ],
    ),
    // MuJoCo accepts any attribute here; `prefix` changes nothing.
    read(BODIES, "replicate", &["count", "offset", "euler", "sep", "childclass"]).ignored(&["prefix"]),
    read(
        BODIES,
        "inertial",
        &["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mass", "diaginertia", "fullinertia"],
    ),
    read(
        BODIES_OR_DEFAULT,
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
            "springyield",
        ],
    )
    .ignored(&["group", "user"]),
    read(BODIES, "freejoint", &["name", "align"]).ignored(&["group"]),
    read(
        BODIES_OR_DEFAULT,
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
            "fluidshape",
            "fluidcoef",
            "surfacevel",
        ],
    )
    .ignored(&["castshadow", "user"])
    .physics(&[("adhesion", "0")]),
    read(
        BODIES_OR_DEFAULT,
        "site",
        &["name", "class", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "fromto", "type", "size"],
    )
    .ignored(&["group", "material", "mesh", "rgba", "user"]),
    rule(BODIES_OR_DEFAULT, "camera", Appearance),
    rule(BODIES_OR_DEFAULT, "light", Appearance),
    // An <attach> that was expanded has become a frame.
    read(BODIES, "attach", &["model", "body", "frame", "prefix"]),
    rule(BODIES, "plugin", Physics("the forces of a plugin are not in the model")),
    deformable(BODIES, "composite"),
    deformable(BODIES, "flexcomp"),
];
