//! What the format has, and what of it is read: every element with its attributes.
//!
//! The account of what is not read ([`crate::unread`]) follows this table, so an attribute is read where it says so or nowhere.

/// What an element is to this reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sort {
    /// Read, and so is what is in it.
    Read,
    /// How things look.
    Looks,
    /// Not read and no part of the motion: why.
    Aside(&'static str),
    /// Not read though it may move the robot: what is missing.
    Physics(&'static str),
}

/// One element of the format.
pub(crate) struct Rule {
    /// The elements that it is found in.
    pub(crate) within: &'static [&'static str],
    pub(crate) name: &'static str,
    pub(crate) sort: Sort,
    /// Attributes that are read.
    pub(crate) read: &'static [&'static str],
    /// Attributes of looks, of contact and of solvers, which do not enter the equations of motion.
    pub(crate) aside: &'static [&'static str],
    /// Attributes of physics that is not in the model, with the value that does nothing.
    pub(crate) physics: &'static [(&'static str, &'static str)],
}

mod bodies;
mod sensors;

use Sort::{Aside, Looks, Physics, Read};

const TOP: &[&str] = &["mujoco"];

const fn rule(within: &'static [&'static str], name: &'static str, sort: Sort) -> Rule {
    Rule { within, name, sort, read: &[], aside: &[], physics: &[] }
}

const fn read(within: &'static [&'static str], name: &'static str, read: &'static [&'static str]) -> Rule {
    Rule { within, name, sort: Read, read, aside: &[], physics: &[] }
}

impl Rule {
    const fn aside(self, aside: &'static [&'static str]) -> Self {
        Self { aside, ..self }
    }

    const fn physics(self, physics: &'static [(&'static str, &'static str)]) -> Self {
        Self { physics, ..self }
    }
}

const SERVO: &[&str] = &[
    "name",
    "class",
    "joint",
    "tendon",
    "site",
    "refsite",
    "gear",
    "ctrlrange",
    "ctrllimited",
    "forcerange",
    "forcelimited",
    "gaintype",
    "gainprm",
    "biastype",
    "biasprm",
    "dyntype",
    "dynprm",
    "kp",
    "kv",
    "dampratio",
    "timeconst",
    "inheritrange",
    "actearly",
    "body",
    "jointinparent",
    "cranksite",
    "slidersite",
    "cranklength",
    "area",
    "diameter",
    "bias",
    "armature",
    "damping",
];
const SERVO_ASIDE: &[&str] = &["group", "user", "lengthrange", "nsample", "interp"];
const SERVO_PHYSICS: &[(&str, &str)] = &[("delay", "0"), ("actlimited", "false"), ("actrange", "0")];

/// An actuator of a kind that is read.
const fn servo(name: &'static str) -> Rule {
    read(&["actuator", "default"], name, SERVO).aside(SERVO_ASIDE).physics(SERVO_PHYSICS)
}

const fn other_actuator(name: &'static str) -> Rule {
    rule(&["actuator", "default"], name, Physics("an actuator of this kind is not in the model"))
}

const fn flexible(within: &'static [&'static str], name: &'static str) -> Rule {
    rule(within, name, Physics("bodies that bend are not in the model"))
}

const EQUALITY: &[&str] = &["name", "class", "active", "solref", "solimp"];
const TENDON: &[&str] = &[
    "name",
    "class",
    "limited",
    "range",
    "actuatorfrclimited",
    "actuatorfrcrange",
    "frictionloss",
    "springlength",
    "stiffness",
    "damping",
    "armature",
    "solreflimit",
    "solimplimit",
    "solreffriction",
    "solimpfriction",
    "margin",
];
const TENDON_ASIDE: &[&str] = &["group", "width", "material", "rgba", "user"];

/// Elements outside bodies.
const SECTIONS: &[Rule] = &[
    read(
        TOP,
        "compiler",
        &[
            "angle",
            "coordinate",
            "eulerseq",
            "autolimits",
            "inertiafromgeom",
            "inertiagrouprange",
            "boundmass",
            "boundinertia",
            "balanceinertia",
            "settotalmass",
            "alignfree",
            "fitaabb",
            "strippath",
            "meshdir",
            "assetdir",
            "conflict",
        ],
    )
    .aside(&["texturedir", "discardvisual", "usethread", "fusestatic", "saveinertial"]),
    rule(&["compiler"], "lengthrange", Aside("how ranges of muscles are found")),
    read(TOP, "option", &["gravity", "timestep", "integrator", "magnetic", "impratio"])
        .aside(&[
            "tolerance",
            "ls_tolerance",
            "noslip_tolerance",
            "ccd_tolerance",
            "sleep_tolerance",
            "o_margin",
            "o_solref",
            "o_solimp",
            "o_friction",
            "cone",
            "jacobian",
            "solver",
            "iterations",
            "ls_iterations",
            "noslip_iterations",
            "ccd_iterations",
            "sdf_iterations",
            "sdf_initpoints",
            "apirate",
            "mpr_iterations",
            "mpr_tolerance",
        ])
        .physics(&[("density", "0"), ("viscosity", "0"), ("wind", "0"), ("actuatorgroupdisable", "")]),
    read(&["option"], "flag", &["gravity", "spring", "damper", "frictionloss", "passive"])
        .aside(&[
            "warmstart",
            "filterparent",
            "refsafe",
            "sensor",
            "midphase",
            "eulerdamp",
            "autoreset",
            "nativeccd",
            "island",
            "multiccd",
            "energy",
            "fwdinv",
            "invdiscrete",
            "sleep",
            "diagexact",
        ])
        .physics(&[
            ("constraint", "enable"),
            ("equality", "enable"),
            ("limit", "enable"),
            ("contact", "enable"),
            ("clampctrl", "enable"),
            ("actuation", "enable"),
            ("override", "disable"),
        ]),
    rule(TOP, "size", Aside("sizes of MuJoCo's memory")),
    rule(TOP, "statistic", Looks),
    rule(TOP, "visual", Looks),
    read(TOP, "default", &["class"]),
    read(&["default"], "default", &["class"]),
    rule(TOP, "custom", Aside("data for other programs")),
    rule(TOP, "extension", Aside("declares plugins")),
    read(TOP, "asset", &[]),
    read(TOP, "worldbody", &[]),
    read(TOP, "contact", &[]),
    flexible(TOP, "deformable"),
    read(TOP, "tendon", &[]),
    read(TOP, "equality", &[]),
    read(TOP, "actuator", &[]),
    read(TOP, "sensor", &[]),
    read(TOP, "keyframe", &[]),
    read(
        &["asset", "default"],
        "mesh",
        &[
            "name",
            "class",
            "content_type",
            "file",
            "vertex",
            "face",
            "refpos",
            "refquat",
            "scale",
            "inertia",
            "builtin",
        ],
    )
    .aside(&["normal", "texcoord", "smoothnormal", "params", "material", "maxhullvert"]),
    rule(&["mesh", "geom"], "plugin", Physics("a shape made by a plugin is not in the model")),
    read(&["asset"], "hfield", &["name", "file", "size", "nrow", "ncol", "elevation"])
        .aside(&["content_type"]),
    read(&["asset", "default"], "material", &["name", "class", "rgba"]).aside(&[
        "texture",
        "texrepeat",
        "texuniform",
        "emission",
        "specular",
        "shininess",
        "reflectance",
        "metallic",
        "roughness",
    ]),
    rule(&["material"], "layer", Looks),
    rule(&["asset"], "texture", Looks),
    rule(&["asset", "deformable"], "skin", Looks),
    read(&["asset"], "model", &["name", "file", "content_type"]),
    read(&["contact"], "exclude", &["body1", "body2"]).aside(&["name"]),
    read(
        &["contact", "default"],
        "pair",
        &[
            "name",
            "class",
            "geom1",
            "geom2",
            "condim",
            "friction",
            "solref",
            "solreffriction",
            "solimp",
            "margin",
            "gap",
        ],
    ),
    read(&["tendon"], "fixed", TENDON).aside(TENDON_ASIDE),
    read(&["fixed"], "joint", &["joint", "coef"]),
    rule(&["tendon"], "spatial", Physics("a tendon through space is not in the model")),
    read(&["default"], "tendon", TENDON).aside(TENDON_ASIDE),
    read(
        &["equality"],
        "joint",
        &["name", "class", "active", "solref", "solimp", "joint1", "joint2", "polycoef"],
    ),
    read(
        &["equality"],
        "connect",
        &["name", "class", "active", "solref", "solimp", "body1", "body2", "anchor", "site1", "site2"],
    ),
    read(
        &["equality"],
        "weld",
        &[
            "name", "class", "active", "solref", "solimp", "body1", "body2", "anchor", "site1", "site2",
            "relpose",
        ],
    )
    .aside(&["torquescale"]),
    rule(&["equality"], "tendon", Physics("an equality of tendons is not in the model")),
    rule(&["equality"], "flex", Physics("an equality of bodies that bend is not in the model")),
    read(&["default"], "equality", EQUALITY),
    servo("general"),
    servo("motor"),
    servo("position"),
    servo("velocity"),
    servo("intvelocity"),
    servo("damper"),
    servo("cylinder"),
    other_actuator("muscle"),
    other_actuator("adhesion"),
    other_actuator("dcmotor"),
    other_actuator("pid"),
    other_actuator("orientation"),
    other_actuator("plugin"),
    read(&["keyframe"], "key", &["name", "qpos", "qvel", "ctrl"]).aside(&["time", "act", "mpos", "mquat"]),
];

/// The rule for an element of this name within another.
pub(crate) fn rule_of(name: &str, within: &str) -> Option<&'static Rule> {
    SECTIONS
        .iter()
        .chain(bodies::RULES)
        .chain(sensors::RULES)
        .find(|rule| rule.name == name && rule.within.contains(&within))
}
