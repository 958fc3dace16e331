//! Elements outside bodies, actuators included.

use super::rule::Handling::{Appearance, NotDynamics, Physics};
use super::rule::{Rule, deformable, read, rule};

/// The parent of sections.
const TOP: &[&str] = &["mujoco"];

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
    "gain",
    "diameter",
    "bias",
    "armature",
    "damping",
    "actlimited",
    "actrange",
    "lengthrange",
    "tausmooth",
    "range",
    "force",
    "scale",
    "lmin",
    "lmax",
    "vmax",
    "fpmax",
    "fvmax",
];
/// `input` names the control, and `actdim` the number of activations, which follow from the kind of the
/// actuator; `velrange` and `ffrange` are those of a kind that is not supported.
const ACTUATOR_IGNORED: &[&str] =
    &["group", "user", "nsample", "interp", "input", "actdim", "velrange", "ffrange"];
const ACTUATOR_PHYSICS: &[(&str, &str)] = &[("delay", "0")];

/// An actuator of a supported kind.
const fn actuator(name: &'static str) -> Rule {
    read(&["actuator", "default"], name, ACTUATOR).ignored(ACTUATOR_IGNORED).physics(ACTUATOR_PHYSICS)
}

const fn unsupported_actuator(name: &'static str) -> Rule {
    rule(&["actuator", "default"], name, Physics("an actuator of this kind is not in the model"))
}

/// The flags that are read.
const FLAGS: &[&str] =
    &["gravity", "spring", "damper", "passive", "frictionloss", "contact", "equality", "limit", "constraint"];
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
    "springyield",
];
const TENDON_IGNORED: &[&str] = &["group", "width", "material", "rgba", "user"];

/// Elements outside bodies.
pub(super) const RULES: &[Rule] = &[
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
    .ignored(&[
        "texturedir",
        "discardvisual",
        "usethread",
        "fusestatic",
        "saveinertial",
        "savecompiled",
        "savecanonical",
        "passthrough",
    ]),
    rule(&["compiler"], "lengthrange", NotDynamics("settings for the length ranges of muscles")),
    read(
        TOP,
        "option",
        &["gravity", "timestep", "integrator", "magnetic", "impratio", "density", "viscosity", "wind"],
    )
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
    .physics(&[("actuatorgroupdisable", "")]),
    read(&["option"], "flag", FLAGS)
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
            "ipc",
            "speculative",
        ])
        .physics(&[("clampctrl", "enable"), ("actuation", "enable"), ("override", "disable")]),
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
            "params",
        ],
    )
    .ignored(&["normal", "texcoord", "smoothnormal", "material", "maxhullvert"]),
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
    rule(&["asset", "default"], "texture", Appearance),
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
    )
    .physics(&[("adhesion", "0")]),
    read(&["tendon"], "fixed", TENDON).ignored(TENDON_IGNORED),
    read(&["fixed"], "joint", &["joint", "coef"]),
    read(&["tendon"], "spatial", TENDON).ignored(TENDON_IGNORED),
    read(&["spatial"], "site", &["site"]),
    read(&["spatial"], "geom", &["geom", "sidesite"]),
    read(&["spatial"], "pulley", &["divisor"]),
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
    read(
        &["equality"],
        "tendon",
        &["name", "class", "active", "solref", "solimp", "tendon1", "tendon2", "polycoef"],
    ),
    rule(&["equality"], "flexstrain", Physics("an equality of deformable bodies is not in the model")),
    rule(&["equality"], "flex", Physics("an equality of deformable bodies is not in the model")),
    read(&["default"], "equality", EQUALITY),
    actuator("general"),
    actuator("motor"),
    actuator("position"),
    actuator("velocity"),
    actuator("intvelocity"),
    actuator("damper"),
    actuator("cylinder"),
    actuator("muscle"),
    actuator("adhesion"),
    unsupported_actuator("dcmotor"),
    unsupported_actuator("pid"),
    unsupported_actuator("orientation"),
    unsupported_actuator("plugin"),
    read(&["keyframe"], "key", &["name", "qpos", "qvel", "ctrl"])
        .ignored(&["time", "act", "mpos", "mquat", "plastic"]),
];
