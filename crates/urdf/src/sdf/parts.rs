//! The content of SDF files before frames are resolved: links, joints and frames with their full names.

use std::collections::HashMap;
use std::path::PathBuf;

use robot_dynamics_description::{Limits, MassProperties, PassiveForces, Pose, Shape, ShapeRole, Surface};
use robot_dynamics_xml::Budget;

use crate::mesh_file::Search;

/// The index of a frame in [`Parts::frames`].
pub(super) type FrameId = usize;

/// The world's frame.
pub(super) const WORLD: FrameId = 0;

/// A line and an element, with the name of an included file.
#[derive(Clone, Debug, Default)]
pub(super) struct Place {
    pub(super) line: usize,
    pub(super) place: String,
}

/// A reference to a frame.
#[derive(Clone, Debug)]
pub(super) enum Target {
    Id(FrameId),
    /// Its full name.
    Name(String),
}

/// The object that a frame moves with.
#[derive(Clone, Debug)]
pub(super) enum Attachment {
    World,
    Link(usize),
    Frame(Target),
}

/// The kind of element that defines a frame. If elements of several kinds have one name, the first counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameKind {
    Link,
    Model,
    Frame,
    Joint,
}

/// A frame: the world, a link, a joint, a `<frame>` or the frame of a model.
#[derive(Debug)]
pub(super) struct Frame {
    pub(super) at: Place,
    pub(super) relative_to: Target,
    /// The frame in that other frame. For a model with a placement frame, the pose of that frame.
    pub(super) pose: Pose,
    /// The frame of a model that `pose` places instead of the model's own.
    pub(super) placement: Option<Target>,
    pub(super) attached_to: Attachment,
}

#[derive(Debug)]
pub(super) struct SdfLink {
    pub(super) name: String,
    pub(super) at: Place,
    pub(super) frame: FrameId,
    pub(super) mass_properties: Option<MassProperties>,
    pub(super) has_gravity: bool,
    pub(super) is_static: bool,
    pub(super) self_collides: bool,
    pub(super) shapes: Vec<SdfShape>,
}

#[derive(Debug)]
pub(super) struct SdfShape {
    pub(super) at: Place,
    pub(super) name: String,
    pub(super) role: ShapeRole,
    /// `None` for the link.
    pub(super) relative_to: Option<Target>,
    pub(super) pose: Pose,
    pub(super) shape: Shape,
    pub(super) color: Option<[f64; 4]>,
    pub(super) surface: Surface,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Screw,
    Ball,
    /// `universal` and `revolute2`: two axes.
    TwoAxes,
}

#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) xyz: [f64; 3],
    /// `None` for the joint's frame.
    pub(super) expressed_in: Option<Target>,
    pub(super) limits: Limits,
    pub(super) passive: PassiveForces,
    pub(super) mimic: Option<SdfMimic>,
}

#[derive(Clone, Debug)]
pub(super) struct SdfMimic {
    /// The full name of the leader.
    pub(super) joint: String,
    pub(super) is_second_axis: bool,
    pub(super) ratio: f64,
    pub(super) offset: f64,
}

#[derive(Debug)]
pub(super) struct SdfJoint {
    pub(super) name: String,
    pub(super) at: Place,
    pub(super) kind: JointType,
    pub(super) frame: FrameId,
    pub(super) parent: Target,
    pub(super) child: Target,
    pub(super) axes: Vec<Axis>,
    /// \[m/rad\], of a screw.
    pub(super) pitch: f64,
    /// Whether its model is static.
    pub(super) is_static: bool,
}

/// A `<frame>`.
#[derive(Debug)]
pub(super) struct NamedFrame {
    pub(super) name: String,
    pub(super) frame: FrameId,
}

/// A source of files in memory.
pub(crate) type FilesInMemory<'f> = dyn Fn(&std::path::Path) -> Option<Vec<u8>> + 'f;

/// Everything that was read so far.
pub(super) struct Parts<'f> {
    pub(super) frames: Vec<Frame>,
    pub(super) names: HashMap<String, [Option<FrameId>; 4]>,
    pub(super) links: Vec<SdfLink>,
    pub(super) joints: Vec<SdfJoint>,
    pub(super) named_frames: Vec<NamedFrame>,
    pub(super) budget: Budget,
    /// The number of includes so far.
    pub(super) includes: usize,
    /// The included files.
    pub(super) files: Vec<PathBuf>,
    pub(super) gravity: Option<[f64; 3]>,
    /// The prefix of places in the current file: empty in the main file.
    pub(super) file: String,
    pub(super) version: (u32, u32),
    /// Locates files from the current file.
    pub(super) search: Search,
    /// Whether there is a folder, so that meshes are located.
    pub(super) locates: bool,
    pub(super) in_memory: Option<&'f FilesInMemory<'f>>,
    /// The path of the current file in memory.
    pub(super) memory_path: PathBuf,
    /// Meshes without a file.
    pub(super) missing_meshes: std::collections::BTreeSet<String>,
}

/// The surroundings of a model or of its parts.
#[derive(Clone)]
pub(super) struct Scope {
    /// The prefix of full names: `outer::inner::`.
    pub(super) prefix: String,
    /// The frame of the model, `__model__`.
    pub(super) model: FrameId,
    pub(super) is_static: bool,
    pub(super) self_collides: bool,
    /// The number of models around.
    pub(super) depth: usize,
}

impl Scope {
    /// The frame that a name in this scope means.
    pub(super) fn target(&self, name: &str) -> Target {
        match name {
            "__model__" => Target::Id(self.model),
            "world" | "__root__" => Target::Id(WORLD),
            _ => Target::Name(format!("{}{}", self.prefix, name.strip_suffix("::__model__").unwrap_or(name))),
        }
    }
}
