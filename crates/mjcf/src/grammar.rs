//! The table of all elements and attributes of MJCF, and whether they are read.
//!
//! The report of what is not read ([`crate::unread_parts`]) follows this table, so an attribute that is read
//! must be listed here.

/// The handling of an element by this reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handling {
    /// Reads it and its content.
    Read,
    /// Counts it as appearance.
    Appearance,
    /// Ignores it because it does not affect the motion, with a description.
    NotDynamics(&'static str),
    /// Warns that it may affect the motion and is not in the model, with a description.
    Physics(&'static str),
}

/// One element of the format.
pub(crate) struct Rule {
    /// The possible parents.
    pub(crate) within: &'static [&'static str],
    pub(crate) name: &'static str,
    pub(crate) handling: Handling,
    /// Attributes that are read.
    pub(crate) read: &'static [&'static str],
    /// Attributes of appearance, contact and solvers, which do not enter the equations of motion.
    pub(crate) ignored: &'static [&'static str],
    /// Attributes of physics that is not in the model, with the value that has no effect.
    pub(crate) physics: &'static [(&'static str, &'static str)],
}

mod bodies;
mod sensors;

use Handling::{Appearance, NotDynamics, Physics, Read};

const TOP: &[&str] = &["mujoco"];

const fn rule(within: &'static [&'static str], name: &'static str, handling: Handling) -> Rule {
    Rule { within, name, handling, read: &[], ignored: &[], physics: &[] }
}

const fn read(within: &'static [&'static str], name: &'static str, read: &'static [&'static str]) -> Rule {
    Rule { within, name, handling: Read, read, ignored: &[], physics: &[] }
}

impl Rule {
    const fn ignored(self, ignored: &'static [&'static str]) -> Self {
        Self { ignored, ..self }
    }

    const fn physics(self, physics: &'static [(&'static str, &'static str)]) -> Self {
        Self { physics, ..self }
    }
}

const ACTUATOR: &[&str] = &[
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
const ACTUATOR_IGNORED: &[&str] = &["group", "user", "lengthrange", "nsample", "interp"];
const ACTUATOR_PHYSICS: &[(&str, &str)] = &[("delay", "0"), ("actlimited", "false"), ("actrange", "0")];

/// An actuator of a supported kind.
const fn actuator(name: &'static str) -> Rule {
    read(&["actuator", "default"], name, ACTUATOR).ignored(ACTUATOR_IGNORED).physics(ACTUATOR_PHYSICS)
}

const fn unsupported_actuator(name: &'static str) -> Rule {
    rule(&["actuator", "default"], name, Physics("an actuator of this kind is not in the model"))
}

const fn deformable(within: &'static [&'static str], name: &'static str) -> Rule {
    rule(within, name, Physics("deformable bodies are not in the model"))
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
const TENDON_IGNORED: &[&str] = &["group", "width", "material", "rgba", "user"];

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
    .ignored(&["texturedir", "discardvisual", "usethread", "fusestatic", "saveinertial"]),
    rule(&["compiler"], "lengthrange", NotDynamics("settings for the length ranges of muscles")),
    read(TOP, "option", &["gravity", "timestep", "integrator", "magnetic", "impratio"])
        .ignored(&[
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
        .ignored(&[
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
    rule(TOP, "size", NotDynamics("memory sizes of MuJoCo")),
    rule(TOP, "statistic", Appearance),
    rule(TOP, "visual", Appearance),
    read(TOP, "default", &["class"]),
    read(&["default"], "default", &["class"]),
    rule(TOP, "custom", NotDynamics("data for other programs")),
    rule(TOP, "extension", NotDynamics("declarations of plugins")),
    read(TOP, "asset", &[]),
    read(TOP, "worldbody", &[]),
    read(TOP, "contact", &[]),
    deformable(TOP, "deformable"),
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
    .ignored(&["normal", "texcoord", "smoothnormal", "params", "material", "maxhullvert"]),
    rule(&["mesh", "geom"], "plugin", Physics("the shape of a plugin is not in the model")),
    read(&["asset"], "hfield", &["name", "file", "size", "nrow", "ncol", "elevation"])
        .ignored(&["content_type"]),
    read(&["asset", "default"], "material", &["name", "class", "rgba"]).ignored(&[
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
    rule(&["material"], "layer", Appearance),
    rule(&["asset"], "texture", Appearance),
    rule(&["asset", "deformable"], "skin", Appearance),
    read(&["asset"], "model", &["name", "file", "content_type"]),
    read(&["contact"], "exclude", &["body1", "body2"]).ignored(&["name"]),
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
    read(&["tendon"], "fixed", TENDON).ignored(TENDON_IGNORED),
    read(&["fixed"], "joint", &["joint", "coef"]),
    rule(&["tendon"], "spatial", Physics("a spatial tendon is not in the model")),
    read(&["default"], "tendon", TENDON).ignored(TENDON_IGNORED),
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
    .ignored(&["torquescale"]),
    rule(&["equality"], "tendon", Physics("an equality of tendons is not in the model")),
    rule(&["equality"], "flex", Physics("an equality of deformable bodies is not in the model")),
    read(&["default"], "equality", EQUALITY),
    actuator("general"),
    actuator("motor"),
    actuator("position"),
    actuator("velocity"),
    actuator("intvelocity"),
    actuator("damper"),
    actuator("cylinder"),
    unsupported_actuator("muscle"),
    unsupported_actuator("adhesion"),
    unsupported_actuator("dcmotor"),
    unsupported_actuator("pid"),
    unsupported_actuator("orientation"),
    unsupported_actuator("plugin"),
    read(&["keyframe"], "key", &["name", "qpos", "qvel", "ctrl"]).ignored(&["time", "act", "mpos", "mquat"]),
];

/// The rule for an element of this name within another.
pub(crate) fn rule_of(name: &str, within: &str) -> Option<&'static Rule> {
    SECTIONS
        .iter()
        .chain(bodies::RULES)
        .chain(sensors::RULES)
        .find(|rule| rule.name == name && rule.within.contains(&within))
}
