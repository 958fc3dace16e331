//! The meshes of a file by name, and the extents of those that were opened.

use std::collections::HashMap;
use std::rc::Rc;

use crate::folder::Folder;
use crate::mesh_mass::MeshExtent;
use crate::tree::Id;

/// The meshes of the file.
#[derive(Default)]
pub(crate) struct Meshes {
    /// The folder of the main file; `None` for a text.
    pub(crate) folder: Option<Folder>,
    pub(crate) named: HashMap<String, Id>,
    pub(crate) extents: HashMap<(Id, bool), Rc<Result<MeshExtent, String>>>,
}
