//! Locates the mesh files that a robot names, without opening them.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use robot_dynamics_description::{LinkShape, Shape};
use robot_dynamics_xml::excerpt;

use crate::element::Element;
use crate::reader::Reader;

/// The number of missing files that the note names.
const LISTED_FILES: usize = 3;

/// Locates the file of each mesh, starting from the robot's file at `path`. One note lists those that are
/// missing.
pub(crate) fn locate_meshes(
    reader: &mut Reader<'_>,
    robot: &Element<'_>,
    shapes: &mut [LinkShape],
    path: &Path,
) {
    let search = Search::from(path, &reader.options.package_path);
    let mut missing = BTreeSet::new();
    for shape in shapes {
        if let Shape::Mesh { name, file, .. } = &mut shape.shape {
            *file = search.find(name);
            if file.is_none() {
                missing.insert(name.clone());
            }
        }
    }
    if missing.is_empty() {
        return;
    }
    let names: Vec<String> = missing.iter().take(LISTED_FILES).map(|name| excerpt(name)).collect();
    let more = if missing.len() > LISTED_FILES {
        format!(" and {} more", missing.len() - LISTED_FILES)
    } else {
        String::new()
    };
    let message = format!(
        "mesh files were not found: {}{more}; package:// is searched in the folder of the robot's file and those \
         above it, in the package path (--package-path), and in ROS_PACKAGE_PATH",
        names.join(", ")
    );
    reader.report_ignored(robot.line, robot.place.clone(), message);
}

/// The folders to search.
struct Search {
    /// The folder of the robot's file and its ancestors.
    folders: Vec<PathBuf>,
    /// The folders in the options, and those of `ROS_PACKAGE_PATH`.
    packages: Vec<PathBuf>,
}

impl Search {
    fn from(path: &Path, given: &[PathBuf]) -> Self {
        let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        // The standard library cannot split a list of folders in WebAssembly.
        let listed = std::env::var_os("ROS_PACKAGE_PATH").filter(|_| !cfg!(target_family = "wasm"));
        Self {
            folders: folder.ancestors().map(Path::to_owned).collect(),
            packages: given
                .iter()
                .map(|folder| folder.canonicalize().unwrap_or_else(|_| folder.clone()))
                .chain(listed.iter().flat_map(std::env::split_paths).filter(|path| path.is_absolute()))
                .collect(),
        }
    }

    /// The file of `package://NAME/…` or `model://NAME/…` (in a folder NAME), of `file://…`, or of a relative
    /// path.
    fn find(&self, name: &str) -> Option<PathBuf> {
        let exists = |path: PathBuf| path.is_file().then_some(path);
        if let Some(rest) = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://")) {
            let (package, rest) = rest.split_once('/')?;
            let inside = |folder: &PathBuf| {
                let is_it = folder.file_name() == Some(OsStr::new(package));
                let within = is_it.then(|| exists(folder.join(rest))).flatten();
                within.or_else(|| exists(folder.join(package).join(rest)))
            };
            return self.packages.iter().chain(&self.folders).find_map(inside);
        }
        if let Some(path) = name.strip_prefix("file://") {
            return exists(path.into());
        }
        if name.contains("://") {
            return None;
        }
        exists(self.folders.first()?.join(name))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::Search;

    /// Names of all kinds are resolved in a temporary folder.
    #[test]
    fn meshes_are_found_from_the_robots_file() {
        let root = std::env::temp_dir().join(format!("meshes_are_found_{}", std::process::id()));
        let (urdf, meshes) = (root.join("arm_description/urdf"), root.join("arm_description/meshes"));
        fs::create_dir_all(&urdf).unwrap();
        fs::create_dir_all(&meshes).unwrap();
        let (robot, mesh) = (urdf.join("arm.urdf"), meshes.join("link.stl"));
        fs::write(&mesh, b"").unwrap();
        let search = Search::from(&robot, &[]);
        let found = |name: &str| search.find(name).and_then(|path| path.canonicalize().ok());
        let mesh = mesh.canonicalize().unwrap();
        assert_eq!(found("package://arm_description/meshes/link.stl"), Some(mesh.clone()));
        assert_eq!(found("../meshes/link.stl"), Some(mesh.clone()));
        assert_eq!(found(&format!("file://{}", mesh.display())), Some(mesh));
        for nowhere in
            ["package://other/meshes/link.stl", "link.stl", "https://host/link.stl", "package://arm"]
        {
            assert_eq!(found(nowhere), None, "{nowhere}");
        }
        // From another folder: by the folder that contains the packages, or by the package itself.
        let elsewhere = root.join("elsewhere/robot.urdf");
        for given in [root.clone(), root.join("arm_description"), root.join("elsewhere/../arm_description")] {
            let search = Search::from(&elsewhere, &[root.join("nowhere"), given]);
            let found = search
                .find("package://arm_description/meshes/link.stl")
                .map(|path| path.canonicalize().unwrap());
            assert_eq!(found, Some(meshes.join("link.stl").canonicalize().unwrap()));
        }
        assert_eq!(Search::from(&elsewhere, &[]).find("package://elsewhere/link.stl"), None);
        fs::remove_dir_all(&root).unwrap();
    }
}
