//! The settings of a model that the rest of its file depends on.

use core::ops::RangeInclusive;

/// The source of the inertia of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InertiaSource {
    /// The inertia is that of `<inertial>`.
    Never,
    /// The inertia is that of the geoms, even with an `<inertial>`.
    Always,
    /// The inertia is that of the geoms if there is no `<inertial>`.
    WhereMissing,
}

/// The settings; the defaults are those of MuJoCo.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // one for each setting that is on or off
pub(crate) struct Compiler {
    /// Whether angles are in degrees.
    pub(crate) degrees: bool,
    /// The axes of Euler angles: moving axes in lower case, fixed axes in upper case.
    pub(crate) euler_sequence: [u8; 3],
    /// Whether a range implies a limit.
    pub(crate) auto_limits: bool,
    pub(crate) inertia_from_geoms: InertiaSource,
    /// The groups of geoms that contribute to the inertia.
    pub(crate) inertia_groups: RangeInclusive<i64>,
    /// The least mass of a body \[kg\].
    pub(crate) least_mass: f64,
    /// The least principal moment of a body \[kg·m²\].
    pub(crate) least_moment: f64,
    /// Whether moments that violate the triangle inequality are replaced by their mean.
    pub(crate) balance_inertia: bool,
    /// The total mass to which all bodies are scaled \[kg\]; no scaling if it is not positive.
    pub(crate) total_mass: f64,
    /// Whether the frame of a free body without children is moved to its centre of mass and principal axes.
    pub(crate) align_free: bool,
    /// Whether a primitive is fitted to the bounding box of a mesh instead of its inertia.
    pub(crate) fit_bounds: bool,
    /// The folder of the mesh files, relative to the folder of the main file.
    pub(crate) mesh_folder: String,
    /// The folder of other files.
    pub(crate) asset_folder: String,
    /// Whether only the last part of the name of a mesh file counts.
    pub(crate) strip_path: bool,
}

impl Default for Compiler {
    fn default() -> Self {
        Self {
            degrees: true,
            euler_sequence: *b"xyz",
            auto_limits: true,
            inertia_from_geoms: InertiaSource::WhereMissing,
            inertia_groups: 0..=5,
            least_mass: 0.0,
            least_moment: 0.0,
            balance_inertia: false,
            total_mass: -1.0,
            align_free: false,
            fit_bounds: false,
            mesh_folder: String::new(),
            asset_folder: String::new(),
            strip_path: false,
        }
    }
}

impl Compiler {
    /// Converts an angle of the file to radians.
    pub(crate) fn angle(&self, angle: f64) -> f64 {
        if self.degrees { angle.to_radians() } else { angle }
    }
}
