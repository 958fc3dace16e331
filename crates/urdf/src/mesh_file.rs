//! Locates the mesh files that a robot names, without opening them.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use robot_dynamics_description::{LinkShape, Shape};
use robot_dynamics_xml::{excerpt, spellings};

use crate::LoadOptions;
use crate::element::Element;
use crate::reader::Reader;

/// The number of missing files that the note names.
const LISTED_FILES: usize = 3;

/// Locates the file of each mesh, starting from the robot's file at `path`; `None` for a text. One note lists
/// those that are missing.
pub(crate) fn locate_meshes(
    reader: &mut Reader<'_>,
    robot: &Element<'_>,
    shapes: &mut [LinkShape],
    path: Option<&Path>,
) {
    let search = Search::from(path, &reader.options);
    let mut missing = BTreeSet::new();
    for shape in shapes {
        if let Shape::Mesh { name, file, .. } = &mut shape.shape {
            *file = search.find(name);
            if file.is_none() {
                missing.insert(name.clone());
            }
        }
    }
    note_missing_meshes(reader, robot, &missing, &search);
}

/// One note on the meshes without a file.
pub(crate) fn note_missing_meshes(
    reader: &mut Reader<'_>,
    robot: &Element<'_>,
    missing: &BTreeSet<String>,
    search: &Search,
) {
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
         above it, in the package path (--package-path), in ROS_PACKAGE_PATH, and in AMENT_PREFIX_PATH{}",
        names.join(", "),
        search.confinement()
    );
    reader.report_ignored(robot.line, robot.place.clone(), message);
}

/// The folders to search.
#[derive(Clone)]
pub(crate) struct Search {
    /// The folder of the robot's file and its ancestors; empty for a text.
    folders: Vec<PathBuf>,
    /// The folders in the options, those of `ROS_PACKAGE_PATH`, and the folder `share` of those of
    /// `AMENT_PREFIX_PATH`.
    packages: Vec<PathBuf>,
    /// Whether files outside the folder of the main file are not taken.
    confined: bool,
    /// The folder of the main file.
    root: Option<PathBuf>,
}

/// Variables with the folders that contain the models of Gazebo.
const GAZEBO_PATHS: [&str; 4] =
    ["SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH"];

/// The folders of a list in a variable.
fn absolute_folders(list: Option<&OsString>) -> Vec<PathBuf> {
    list.into_iter().flat_map(std::env::split_paths).filter(|path| path.is_absolute()).collect()
}

/// The folders of ROS 1 and ROS 2 that contain packages.
fn ros_folders(ros: Option<&OsString>, ament: Option<&OsString>) -> Vec<PathBuf> {
    let shares = absolute_folders(ament).into_iter().map(|prefix| prefix.join("share"));
    absolute_folders(ros).into_iter().chain(shares).collect()
}

impl Search {
    pub(crate) fn from(path: Option<&Path>, options: &LoadOptions) -> Self {
        let folder = path.map(|path| {
            let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
            folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
        });
        // The standard library cannot split a list of folders in WebAssembly.
        let variable = |name| std::env::var_os(name).filter(|_| !cfg!(target_family = "wasm"));
        Self {
            folders: folder.iter().flat_map(|folder| folder.ancestors()).map(Path::to_owned).collect(),
            packages: options
                .package_path
                .iter()
                .map(|folder| folder.canonicalize().unwrap_or_else(|_| folder.clone()))
                .chain(ros_folders(
                    variable("ROS_PACKAGE_PATH").as_ref(),
                    variable("AMENT_PREFIX_PATH").as_ref(),
                ))
                .chain(GAZEBO_PATHS.iter().flat_map(|name| absolute_folders(variable(name).as_ref())))
                .collect(),
            confined: options.confined,
            root: folder,
        }
    }

    /// The same search from another file, which was found by this one.
    pub(crate) fn beside(&self, path: &Path) -> Self {
        let folder = path.parent().map(|folder| folder.canonicalize().unwrap_or_else(|_| folder.to_owned()));
        let own = folder.iter().flat_map(|folder| folder.ancestors()).map(Path::to_owned);
        let mut folders: Vec<PathBuf> = own.collect();
        // The folders of the main file stay known for `model://`.
        let others = self.folders.iter().filter(|folder| !folders.contains(folder)).cloned();
        let others: Vec<PathBuf> = others.collect();
        folders.extend(others);
        Self { folders, ..self.clone() }
    }

    /// Whether there is a regular file at a path that may be read.
    pub(crate) fn allows(&self, path: &Path) -> bool {
        path.is_file() && self.is_inside(path)
    }

    fn is_inside(&self, path: &Path) -> bool {
        let inside = |path: PathBuf| self.root.as_ref().is_some_and(|root| path.starts_with(root));
        !self.confined || path.canonicalize().is_ok_and(inside)
    }

    /// The end of the message on missing files, if reading is confined.
    pub(crate) fn confinement(&self) -> String {
        match self.root.as_ref().filter(|_| self.confined) {
            Some(root) => format!("; reading is confined to the folder {}", root.display()),
            None => String::new(),
        }
    }

    /// The file of `package://NAME/…` or `model://NAME/…` (in a folder NAME), of `file://…`, or of a relative
    /// path.
    pub(crate) fn find(&self, name: &str) -> Option<PathBuf> {
        self.search(name, &|path| path.is_file())
    }

    /// As [`find`](Self::find), also for a folder.
    pub(crate) fn find_entry(&self, name: &str) -> Option<PathBuf> {
        self.search(name, &|path| path.is_file() || path.is_dir())
    }

    fn search(&self, name: &str, is_wanted: &dyn Fn(&Path) -> bool) -> Option<PathBuf> {
        let exists = |path: PathBuf| (is_wanted(&path) && self.is_inside(&path)).then_some(path);
        if let Some(rest) = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://")) {
            let (package, rest) = rest.split_once('/').unwrap_or((rest, ""));
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
        let folder = self.folders.first()?;
        spellings(name).find_map(|name| exists(folder.join(name)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::Search;
    use crate::LoadOptions;

    /// Names of all kinds are resolved in a temporary folder.
    #[test]
    fn meshes_are_found_from_the_robots_file() {
        let root = std::env::temp_dir().join(format!("meshes_are_found_{}", std::process::id()));
        let (urdf, meshes) = (root.join("arm_description/urdf"), root.join("arm_description/meshes"));
        fs::create_dir_all(&urdf).unwrap();
        fs::create_dir_all(&meshes).unwrap();
        let (robot, mesh) = (urdf.join("arm.urdf"), meshes.join("link.stl"));
        fs::write(&mesh, b"").unwrap();
        let search = Search::from(Some(&robot), &LoadOptions::default());
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
            let options =
                LoadOptions::default().with_package_path(root.join("nowhere")).with_package_path(given);
            let search = Search::from(Some(&elsewhere), &options);
            let found = search
                .find("package://arm_description/meshes/link.stl")
                .map(|path| path.canonicalize().unwrap());
            assert_eq!(found, Some(meshes.join("link.stl").canonicalize().unwrap()));
        }
        assert_eq!(
            Search::from(Some(&elsewhere), &LoadOptions::default()).find("package://elsewhere/link.stl"),
            None
        );
        assert!(search.find("..\\meshes\\link.stl").is_some());
        // A text has only the package path.
        let text = Search::from(None, &LoadOptions::default().with_package_path(&root));
        assert!(text.find("package://arm_description/meshes/link.stl").is_some());
        assert_eq!(text.find("../meshes/link.stl"), None);
        // ROS 2 has packages in the folder `share` of each prefix.
        let share = root.join("install/share/arm_description/meshes");
        fs::create_dir_all(&share).unwrap();
        fs::write(share.join("hand.stl"), b"").unwrap();
        let packages = super::ros_folders(None, Some(&root.join("install").into_os_string()));
        let ament = Search { packages, ..Search::from(Some(&elsewhere), &LoadOptions::default()) };
        assert_eq!(ament.find("package://arm_description/meshes/hand.stl"), Some(share.join("hand.stl")));
        // A file outside the folder of the robot is not taken if reading is confined.
        let confined = Search { confined: true, ..search };
        assert_eq!(confined.find("../meshes/link.stl"), None);
        assert!(confined.confinement().contains("arm_description/urdf"));
        fs::remove_dir_all(&root).unwrap();
    }
}
