//! Reads `<asset>/<mesh>`: meshes by name. A mesh file is opened if the inertia of a body comes from it.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use robot_dynamics_mesh::Triangles;
use robot_dynamics_xml::{Resource, excerpt, spellings};

use crate::builtin_mesh::builtin_mesh;
use crate::classes::MAIN;
use crate::element::Element;
use crate::mesh_mass::{MeshExtent, MeshInertia, extent};
use crate::path::stem;
use crate::reader::Reader;
use crate::settings::Compiler;
use crate::tree::Id;

impl Reader<'_> {
    /// Collects all meshes by name, which defaults to that of their file.
    pub(crate) fn read_meshes(&mut self) {
        let meshes: Vec<Id> =
            self.tree.in_sections("asset").filter(|&id| self.tree.nodes[id].name == "mesh").collect();
        for id in meshes {
            let element = self.raw_element(id);
            let own = self.text(&element, "name").filter(|name| !name.is_empty());
            let Some(name) = own.or_else(|| self.text(&element, "file").map(stem)) else {
                self.required_text(&element, "name", "NAME");
                continue;
            };
            let name = name.to_owned();
            self.meshes.named.entry(name).or_insert(id);
        }
    }

    /// The `<mesh>` of this name with its defaults.
    pub(crate) fn mesh_named(&mut self, name: &str) -> Option<Element> {
        let id = self.meshes.named.get(name).copied()?;
        Some(self.element(id, MAIN))
    }

    /// The mass properties of a mesh at density 1, or the reason of the failure. Each mesh is opened once.
    /// With `shell` the mass is in the surface, whatever the attribute `inertia` of the mesh is.
    pub(crate) fn mesh_extent(&mut self, name: &str, shell: bool) -> Rc<Result<MeshExtent, String>> {
        let Some(element) = self.mesh_named(name) else {
            return Rc::new(Err(format!("<mesh name={:?}/> is missing in <asset>", excerpt(name))));
        };
        if let Some(known) = self.meshes.extents.get(&(element.node, shell)) {
            return Rc::clone(known);
        }
        let extent = Rc::new(self.read_mesh(&element, shell));
        self.meshes.extents.insert((element.node, shell), Rc::clone(&extent));
        extent
    }

    /// The file of a mesh: its name, and its path if the folder is known.
    pub(crate) fn mesh_file(&self, element: &Element) -> Option<(String, Option<PathBuf>)> {
        let name = self.text(element, "file")?;
        let own = if self.compiler(element).strip_path {
            name.rsplit(['/', '\\']).next().unwrap_or(name)
        } else {
            name
        };
        Some((name.to_owned(), self.asset_path(element, own, |compiler| &compiler.mesh_folder)))
    }

    /// The path of an asset's file; `None` for a text. The folder of assets, by the settings of the model
    /// that names the file, starts from the folder of the model, or from that of the file that has the
    /// element.
    pub(crate) fn asset_path(
        &self,
        element: &Element,
        name: &str,
        own: fn(&Compiler) -> &String,
    ) -> Option<PathBuf> {
        let folder = self.meshes.folder.as_ref()?;
        let node = &self.tree.nodes[element.node];
        let model = &self.tree.models[node.model].folder;
        let beside = Path::new(&self.tree.files[node.file]).parent().unwrap_or(model);
        let assets = own(self.compiler(element)).replace('\\', "/");
        let around = [model.join(&assets), beside.join(&assets), beside.to_owned()];
        let candidates = around.iter().flat_map(|folder| spellings(name).map(|name| folder.join(name)));
        Some(folder.join(&folder.locate(candidates)))
    }

    fn read_mesh(&mut self, element: &Element, shell: bool) -> Result<MeshExtent, String> {
        let builtin = self.text(element, "builtin").filter(|&shape| shape != "none").map(str::to_owned);
        let words = ["convex", "exact", "shell", "legacy"];
        let inertia = match self.word(element, "inertia", &words) {
            _ if shell || builtin.as_deref() == Some("plate") => MeshInertia::Shell,
            Some("convex") => MeshInertia::Convex,
            Some("exact") => MeshInertia::Exact,
            Some("shell") => MeshInertia::Shell,
            _ => MeshInertia::Legacy,
        };
        let errors = self.errors.len();
        let scale = self.numbers::<3>(element, "scale").unwrap_or([1.0; 3]);
        let shift = self.numbers::<3>(element, "refpos").unwrap_or_default();
        let [w, x, y, z] = self.numbers::<4>(element, "refquat").unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let mut mesh = if let Some(shape) = builtin {
            builtin_mesh(&shape, &self.all_numbers(element, "params").unwrap_or_default())?
        } else if let Some((_, path)) = self.mesh_file(element) {
            let (Some(folder), Some(path)) = (&self.meshes.folder, path) else {
                return Err("a text has no folder; load the file instead".into());
            };
            folder.mesh(&path, self.text(element, "content_type"))?
        } else {
            self.written_mesh(element)?
        };
        let numbers = 3 * (mesh.points.len() + mesh.faces.len());
        if !self.charge(element.node, Resource::Numbers, numbers) {
            return Err("there are too many numbers in all meshes".into());
        }
        if self.errors.len() > errors {
            return Err("it has invalid numbers".into());
        }
        let quaternion = Quaternion::new(w, x, y, z);
        let turn = UnitQuaternion::try_new(quaternion, 0.0).ok_or("refquat is zero")?;
        let factors = Matrix3::from_diagonal(&Vector3::from(scale));
        for point in &mut mesh.points {
            *point = factors * (turn.inverse() * (*point - Vector3::from(shift)));
        }
        if scale.iter().product::<f64>() < 0.0 {
            // A reflection reverses the orientation of the faces.
            mesh.faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        let extent = extent(&mesh, inertia)?;
        if extent.open_edges > 0 {
            let count = extent.open_edges;
            let message =
                "its mass is that of the pyramids from the centre to the triangles; close the surface";
            self.warn(element, format!("the surface of the mesh is open at {count} edges: {message}"));
        }
        Ok(extent)
    }

    /// Reads a mesh from `vertex` and `face`.
    fn written_mesh(&mut self, element: &Element) -> Result<Triangles, String> {
        let points = self.all_numbers(element, "vertex").ok_or("it has neither file nor vertex")?;
        let corners = self.all_numbers(element, "face").unwrap_or_default();
        if !points.len().is_multiple_of(3) || !corners.len().is_multiple_of(3) {
            return Err("vertex and face need three numbers for each point and each triangle".into());
        }
        #[allow(clippy::cast_possible_truncation)] // the format's numbers are of single precision
        let single = |x: f64| f64::from(x as f32);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // out of range is refused below
        let index = |x: f64| if x >= 0.0 { x as usize } else { usize::MAX };
        let mesh = Triangles {
            points: points.chunks_exact(3).map(|x| Vector3::from_fn(|k, _| single(x[k]))).collect(),
            faces: corners
                .chunks_exact(3)
                .map(|face| [index(face[0]), index(face[1]), index(face[2])])
                .collect(),
        };
        robot_dynamics_mesh::check(&mesh)?;
        Ok(mesh)
    }
}
