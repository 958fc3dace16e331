//! Reads `<compiler>`: the settings that the rest of the file depends on.

use crate::element::Element;
use crate::reader::Reader;
use crate::settings::{Compiler, InertiaSource};
use crate::tree::Id;

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
                    "false" => InertiaSource::Never,
                    "true" => InertiaSource::Always,
                    _ => InertiaSource::WhereMissing,
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
