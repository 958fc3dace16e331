//! `<compiler>`: how the rest of the file is to be understood.

use core::ops::RangeInclusive;

use crate::reader::{Element, Reader};
use crate::tree::Id;

/// Where bodies' inertia comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FromGeoms {
    /// From `<inertial>` alone.
    Never,
    /// From the geoms, whatever `<inertial>` says.
    Always,
    /// From the geoms where there is no `<inertial>`.
    WhereMissing,
}

/// The settings, those of MuJoCo where the file says nothing.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // one for each setting that is on or off
pub(crate) struct Compiler {
    /// Angles are in degrees, which is the format's default.
    pub(crate) degrees: bool,
    /// The axes of Euler angles, in lower case about moving axes, in upper case about fixed ones.
    pub(crate) euler_sequence: [u8; 3],
    /// A range makes a limit.
    pub(crate) auto_limits: bool,
    pub(crate) inertia_from_geoms: FromGeoms,
    /// The groups of geoms that inertia is taken from.
    pub(crate) inertia_groups: RangeInclusive<i64>,
    /// The least mass of a body \[kg\].
    pub(crate) least_mass: f64,
    /// The least principal moment of a body \[kg·m²\].
    pub(crate) least_moment: f64,
    /// Moments that break the triangle inequality become their mean.
    pub(crate) balance_inertia: bool,
    /// The mass that all bodies together are scaled to \[kg\]; zero or less for none.
    pub(crate) total_mass: f64,
    /// A free body without children has its frame where its centre of mass and principal axes are.
    pub(crate) align_free: bool,
    /// A primitive is fitted to the mesh's bounding box, not to its inertia.
    pub(crate) fit_bounds: bool,
    /// The folder of the mesh files, in that of the main file.
    pub(crate) mesh_folder: String,
    /// The folder of other files.
    pub(crate) asset_folder: String,
    /// Only the last part of a mesh file's name counts.
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
    /// An angle of the file \[rad\].
    pub(crate) fn angle(&self, angle: f64) -> f64 {
        if self.degrees { angle.to_radians() } else { angle }
    }
}

impl Reader<'_> {
    /// Reads the settings of the main file and of each model that it attaches.
    pub(crate) fn read_compilers(&mut self) {
        for model in 0..self.tree.models.len() {
            let compiler = self.read_compiler(self.tree.models[model].root);
            self.compilers.push(compiler);
        }
    }

    /// Reads all `<compiler>` elements of a file; what several of them say, the last one says.
    fn read_compiler(&mut self, root: Id) -> Compiler {
        let mut compiler = Compiler::default();
        let mut asset_folder = None;
        let mut mesh_folder = None;
        for node in self.tree.children(root, "compiler").collect::<Vec<_>>() {
            let element = self.plain(node);
            if let Some(unit) = self.word(&element, "angle", &["radian", "degree"]) {
                compiler.degrees = unit == "degree";
            }
            if self.word(&element, "coordinate", &["local", "global"]) == Some("global") {
                self.misplaced(
                    &element,
                    "coordinate=\"global\" has gone from the format: load and save the file with MuJoCo 2.3.3 or older",
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
                if let Some(value) = self.truth(&element, name) {
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
            self.read(&element, "settings");
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
            _ => self.misplaced(element, "eulerseq is three letters of x, y, z, X, Y, Z"),
        }
    }
}
