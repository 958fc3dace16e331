//! Names of links and joints: unique ones, from the names of prims.

use std::collections::{HashMap, HashSet};

use crate::prim::Scene;

/// Names for the prims: that for people, or the shortest end of the path that no other prim of the list has.
pub(crate) fn unique_names(scene: &Scene, prims: &[usize], taken: &mut HashSet<String>) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for &prim in prims {
        *counts.entry(scene.prims[prim].shown_name()).or_default() += 1;
    }
    let mut names = Vec::with_capacity(prims.len());
    for &prim in prims {
        let prim = &scene.prims[prim];
        let shown = prim.shown_name();
        let is_single = counts.get(shown) == Some(&1) && !taken.contains(shown);
        let name = if is_single { shown.to_owned() } else { prim.path.trim_start_matches('/').to_owned() };
        names.push(unique(taken, name));
    }
    names
}

/// The name, with underscores until no other has it.
pub(crate) fn unique(taken: &mut HashSet<String>, mut name: String) -> String {
    while name.is_empty() || taken.contains(&name) {
        name.push('_');
    }
    taken.insert(name.clone());
    name
}
