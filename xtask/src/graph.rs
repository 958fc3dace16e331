//! The graphs of crates and of their top-level modules: layering, cycles, and the drawing in ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;

use crate::files::{self, SourceFile};
use crate::layers::{LAYERS, LEAVES, ORDERED, OWNED};
use crate::manifest::{Manifest, Workspace};
use crate::modules::{Crate, Use, components};
use crate::root::root;

/// The file that shows the graphs, between these lines.
const SHOWN_IN: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- graph: written by `cargo xtask graph` -->\n";
const END: &str = "<!-- graph: end -->";

/// A top-level module, and those that its code uses, by their places in `lib.rs`.
struct TopModule {
    name: String,
    uses: BTreeSet<usize>,
}

/// All crates with sources.
pub(crate) fn crates(sources: &[SourceFile]) -> Result<Vec<Crate>, String> {
    let folders = files::crate_folders()?;
    // Two threads halve the time.
    let (one, other) = folders.split_at(folders.partition_point(|folder| folder.as_str() < "mjcf"));
    let read = |folders: &[String]| {
        folders.iter().filter_map(|folder| Crate::read(folder, sources)).collect::<Vec<_>>()
    };
    let mut all = std::thread::scope(|scope| {
        let beside = scope.spawn(|| read(one));
        let rest = read(other);
        let mut all = beside.join().unwrap_or_default();
        all.extend(rest);
        all
    });
    all.sort_by(|one, other| one.folder.cmp(&other.folder));
    Ok(all)
}

/// Writes the graphs into the file that shows them.
pub(crate) fn write() -> Result<(), String> {
    let (_, wanted) = texts(&crates(&files::all()?)?)?;
    fs::write(root().join(SHOWN_IN), wanted).map_err(|error| format!("{SHOWN_IN}: {error}"))
}

/// Adds breaches: dependencies of crates, modules that use later ones, graphs that are not shown as they are.
pub(crate) fn check(crates: &[Crate], broken: &mut Vec<String>) -> Result<(), String> {
    check_dependencies(broken)?;
    for one in crates.iter().filter(|one| ORDERED.contains(&one.folder.as_str())) {
        let modules = top_modules(one);
        for (at, module) in modules.iter().enumerate() {
            for &other in module.uses.range(at + 1..) {
                broken.push(format!(
                    "crates/{}: `{}` uses `{}`, which comes after it in lib.rs",
                    one.folder, module.name, modules[other].name
                ));
            }
        }
    }
    let (found, wanted) = texts(crates)?;
    if found != wanted {
        broken.push(format!("{SHOWN_IN} shows other graphs: `cargo xtask graph` writes them"));
    }
    Ok(())
}

/// The files of each crate that lie in cycles, with the number of files in the cycle, and a line that shows
/// each cycle.
pub(crate) fn cycles(crates: &[Crate]) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for one in crates {
        let uses = one.uses();
        let edges = edges(&uses);
        for component in components(one.files.len(), &edges) {
            let ring = shortest_cycle(&component, &edges);
            let shown = ring.iter().map(|&(from, to)| {
                let used = uses.iter().find(|used| (used.from, used.to) == (from, to));
                let path = used.and_then(|used| used.paths.first()).map_or("", String::as_str);
                format!("{} uses `{path}`", below_source(&one.files[from].path))
            });
            let shown = shown.collect::<Vec<_>>().join(", ");
            let paths = component.iter().map(|&file| one.files[file].path.clone()).collect();
            found.push((paths, shown));
        }
    }
    found
}

/// Prints each cycle whose files are below that path: every use inside it, with all the names used.
pub(crate) fn list_cycles(below: &str) -> Result<(), String> {
    for one in &crates(&files::all()?)? {
        let uses = one.uses();
        for component in components(one.files.len(), &edges(&uses)) {
            if !component.iter().any(|&file| one.files[file].path.starts_with(below)) {
                continue;
            }
            println!("crates/{}: {} files use each other", one.folder, component.len());
            let inside = |file: usize| component.contains(&file);
            for used in uses.iter().filter(|used| inside(used.from) && inside(used.to)) {
                let (from, to) = (&one.files[used.from].path, &one.files[used.to].path);
                let names = used.paths.join(", ");
                println!("  {} uses {}: {names}", below_source(from), below_source(to));
            }
        }
    }
    Ok(())
}

/// The uses as pairs of files.
fn edges(uses: &[Use]) -> Vec<(usize, usize)> {
    uses.iter().map(|used| (used.from, used.to)).collect()
}

fn below_source(path: &str) -> &str {
    path.split_once("/src/").map_or(path, |(_, below)| below)
}

/// The edges of a shortest cycle of a component.
fn shortest_cycle(component: &[usize], edges: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let inside: Vec<(usize, usize)> = edges
        .iter()
        .copied()
        .filter(|(from, to)| component.contains(from) && component.contains(to))
        .collect();
    let mut best: Vec<(usize, usize)> = Vec::new();
    for &start in component {
        // Breadth first from `start` back to it.
        let mut before: BTreeMap<usize, usize> = BTreeMap::new();
        let mut frontier = vec![start];
        while !frontier.is_empty() && !before.contains_key(&start) {
            let mut next = Vec::new();
            for &(from, to) in inside.iter().filter(|(from, _)| frontier.contains(from)) {
                if let std::collections::btree_map::Entry::Vacant(free) = before.entry(to) {
                    free.insert(from);
                    next.push(to);
                }
            }
            frontier = next;
        }
        let (mut ring, mut at) = (Vec::new(), start);
        while let Some(&from) = before.get(&at) {
            ring.push((from, at));
            at = from;
            if at == start {
                break;
            }
        }
        ring.reverse();
        if best.is_empty() || ring.len() < best.len() {
            best = ring;
        }
        if best.len() == 2 {
            break;
        }
    }
    best
}

fn check_dependencies(broken: &mut Vec<String>) -> Result<(), String> {
    let workspace = Workspace::read()?;
    for folder in files::crate_folders()? {
        let allowed = LAYERS.iter().find(|(layer, _)| *layer == folder).map(|(_, allowed)| *allowed);
        if allowed.is_none() && !LEAVES.contains(&folder.as_str()) {
            broken.push(format!("crates/{folder} has no line in xtask/src/layers.rs"));
        }
        for dependency in workspace.dependencies(&Manifest::read(&folder)?) {
            let name = dependency.name();
            if allowed.is_some_and(|allowed| !allowed.contains(&name)) {
                broken.push(format!("crates/{folder} must not depend on {name}"));
            }
            if let Some((_, owner)) = OWNED.iter().find(|(owned, _)| *owned == name)
                && *owner != folder
            {
                broken.push(format!("only crates/{owner} may depend on {name}; crates/{folder} names it"));
            }
        }
    }
    Ok(())
}

/// The file as it is, and with the graphs of these crates.
fn texts(crates: &[Crate]) -> Result<(String, String), String> {
    let found = fs::read_to_string(root().join(SHOWN_IN)).map_err(|error| format!("{SHOWN_IN}: {error}"))?;
    let (before, rest) =
        found.split_once(BEGIN).ok_or_else(|| format!("{SHOWN_IN}: there is no line {BEGIN}"))?;
    let (_, after) = rest.split_once(END).ok_or_else(|| format!("{SHOWN_IN}: there is no line {END}"))?;
    let drawn = format!("{}\n{}", crate_graph()?, module_table(crates));
    let wanted = format!("{before}{BEGIN}{drawn}{END}{after}");
    Ok((found, wanted))
}

/// The crates and their dependencies on each other, drawn by Mermaid. An arrow that others imply is left out.
fn crate_graph() -> Result<String, String> {
    let workspace = Workspace::read()?;
    let folders = files::crate_folders()?;
    let mut uses: Vec<BTreeSet<usize>> = Vec::new();
    for folder in &folders {
        let dependencies = workspace.dependencies(&Manifest::read(folder)?);
        let own = dependencies.iter().filter(|dependency| dependency.folder.is_some());
        uses.push(
            own.filter_map(|dependency| folders.iter().position(|folder| *folder == dependency.name()))
                .collect(),
        );
    }
    let mut drawn = String::from("```mermaid\ngraph TD\n");
    for (at, folder) in folders.iter().enumerate() {
        let direct = &uses[at];
        let implied = |to: usize| direct.iter().any(|&other| other != to && reaches(&uses, other, to));
        let shown: Vec<&str> =
            direct.iter().filter(|&&to| !implied(to)).map(|&to| folders[to].as_str()).collect();
        if !shown.is_empty() {
            let _ = writeln!(drawn, "    {folder} --> {}", shown.join(" & "));
        }
    }
    drawn.push_str("```\n");
    Ok(drawn)
}

fn reaches(uses: &[BTreeSet<usize>], from: usize, to: usize) -> bool {
    uses[from].iter().any(|&next| next == to || reaches(uses, next, to))
}

/// A table of the top-level modules of crates whose modules have an order.
fn module_table(crates: &[Crate]) -> String {
    let mut table = String::from("| crate | module | uses |\n| --- | --- | --- |\n");
    for folder in ORDERED {
        let Some(one) = crates.iter().find(|one| one.folder == *folder) else { continue };
        let modules = top_modules(one);
        for (at, module) in modules.iter().enumerate() {
            let uses: Vec<String> = module.uses.iter().map(|&at| format!("`{}`", modules[at].name)).collect();
            let name = if at == 0 { format!("`{folder}`") } else { String::new() };
            let _ = writeln!(table, "| {name} | `{}` | {} |", module.name, uses.join(", "));
        }
    }
    table
}

/// The top-level modules of a library in the order of `lib.rs`, and which uses which.
fn top_modules(one: &Crate) -> Vec<TopModule> {
    let Some(library) = one.library() else { return Vec::new() };
    let root_file = one.modules[library].file;
    let mut names: Vec<String> = Vec::new();
    let mut place: BTreeMap<usize, usize> = BTreeMap::new();
    for &child in one.modules[library].children.iter().filter(|&&child| one.modules[child].file != root_file)
    {
        let name = &one.modules[child].name;
        let at = names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name.clone());
            names.len() - 1
        });
        let mut pending = vec![child];
        while let Some(module) = pending.pop() {
            place.insert(one.modules[module].file, at);
            pending.extend(&one.modules[module].children);
        }
    }
    let mut modules: Vec<TopModule> =
        names.into_iter().map(|name| TopModule { name, uses: BTreeSet::new() }).collect();
    for used in one.uses() {
        if let (Some(&from), Some(&to)) = (place.get(&used.from), place.get(&used.to))
            && from != to
        {
            modules[from].uses.insert(to);
        }
    }
    modules
}

#[cfg(test)]
mod tests {
    use super::{reaches, shortest_cycle};

    #[test]
    fn a_shortest_cycle_is_shown() {
        let edges = [(0, 1), (1, 2), (2, 3), (3, 0), (2, 1)];
        assert_eq!(shortest_cycle(&[0, 1, 2, 3], &edges), [(1, 2), (2, 1)]);
    }

    #[test]
    fn implied_arrows_are_found() {
        let uses = [vec![1, 2], vec![2], vec![]].map(|uses| uses.into_iter().collect());
        assert!(reaches(&uses, 0, 2) && !reaches(&uses, 2, 0));
    }
}
