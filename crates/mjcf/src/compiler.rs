//! Reads `<compiler>`: the settings that the rest of the file depends on.

use core::ops::RangeInclusive;

use crate::reader::{Element, Reader};
use crate::tree::Id;

/// The source of the inertia of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FromGeoms {
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
    pub(crate) inertia_from_geoms: FromGeoms,
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
            inertia_from_geoms: FromGeoms::WhereMissing,
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

impl Reader<'_> {
    /// Reads the settings of the main file and of each attached model.
    pub(crate) fn read_compilers(&mut self) {
        for model in 0..self.tree.models.len() {
            let compiler = self.read_compiler(self.tree.models[model].root);
            self.compilers.push(compiler);
        }
    }

    /// Reads all `<compiler>` elements of a file. The last value of an attribute counts.
    fn read_compiler(&mut self, root: Id) -> Compiler {
        let mut compiler = Compiler::default();
        let mut asset_folder = None;
        let mut mesh_folder = None;
        for node in self.tree.children(root, "compiler").collect::<Vec<_>>() {
            let element = self.raw_element(node);
            if let Some(unit) = self.word(&element, "angle", &["radian", "degree"]) {
                compiler.degrees = unit == "degree";
            }
            if self.word(&element, "coordinate", &["local", "global"]) == Some("global") {
                self.refuse(
                    &element,
                    "coordinate=\"global\" is not supported; convert the file with MuJoCo 2.3.3 or older",
                );
            }
            if let Some(sequence) = self.text(&element, "eulerseq") {
                self.euler_sequence(&element, sequence, &mut compiler);
            }
            let from_geoms = self.word(&element, "inertiafromgeom", &["false", "true", "auto"]);
            if let Some(word) = from_geoms {
                compiler.inertia_from_geoms = match word {
                    "false" => FromGeoms::Never,
                    "true" => FromGeoms::Always,
                    _ => FromGeoms::WhereMissing,
                };
            }
            if let Some([first, last]) = self.numbers::<2>(&element, "inertiagrouprange") {
                #[allow(clippy::cast_possible_truncation)] // groups are small whole numbers
                let range = first as i64..=last as i64;
                compiler.inertia_groups = range;
            }
            if let Some(mass) = self.magnitude(&element, "boundmass") {
                compiler.least_mass = mass;
            }
            if let Some(moment) = self.magnitude(&element, "boundinertia") {
                compiler.least_moment = moment;
            }
            if let Some(mass) = self.number(&element, "settotalmass") {
                compiler.total_mass = mass;
            }
            let mut truth = |name, setting: fn(&mut Compiler) -> &mut bool| {
                if let Some(value) = self.boolean(&element, name) {
                    *setting(&mut compiler) = value;
                }
            };
            truth("autolimits", |compiler| &mut compiler.auto_limits);
            truth("balanceinertia", |compiler| &mut compiler.balance_inertia);
            truth("alignfree", |compiler| &mut compiler.align_free);
            truth("fitaabb", |compiler| &mut compiler.fit_bounds);
            truth("strippath", |compiler| &mut compiler.strip_path);
            asset_folder = self.text(&element, "assetdir").map(str::to_owned).or(asset_folder);
            mesh_folder = self.text(&element, "meshdir").map(str::to_owned).or(mesh_folder);
            self.report_read(&element, "settings");
        }
        compiler.asset_folder = asset_folder.unwrap_or_default();
        compiler.mesh_folder = mesh_folder.unwrap_or_else(|| compiler.asset_folder.clone());
        compiler
    }

    fn euler_sequence(&mut self, element: &Element, sequence: &str, compiler: &mut Compiler) {
        match sequence.as_bytes() {
            &[a, b, c] if [a, b, c].iter().all(|axis| b"xyzXYZ".contains(axis)) => {
                compiler.euler_sequence = [a, b, c];
            }
            _ => self.refuse(element, "eulerseq must be three letters of x, y, z, X, Y, Z"),
        }
    }
}
