//! Public names: what a user of a crate sees.

use std::collections::{BTreeMap, BTreeSet};

use crate::manifest::{Manifest, Workspace};
use crate::modules::{Crate, Target, Visibility, resolve_name};

/// The facade's folder.
const FACADE: &str = "robot-dynamics";

/// Keywords of types.
const TYPES: [&str; 5] = ["struct", "enum", "union", "trait", "type"];

/// The names of the facade.
#[derive(Default)]
pub(super) struct Facade {
    /// At its root: modules, types, functions, constants, crates.
    pub(super) root: BTreeSet<String>,
    /// Public items and modules that can be reached from the root, each counted once.
    pub(super) total: usize,
}

/// The public interface of a crate.
pub(super) struct CrateApi {
    /// Its folder.
    pub(super) folder: String,
    /// Names at its root.
    pub(super) root: usize,
    /// Items that a user can name, each once.
    pub(super) items: usize,
    /// Error types among them.
    pub(super) errors: Vec<String>,
}

/// An item with its crate.
type Owned = (usize, usize, usize);

/// All crates, with the names by which each one's code calls the others.
struct World<'a> {
    crates: &'a [Crate],
    externals: Vec<BTreeMap<String, usize>>,
}

/// The meaning of a public name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Named {
    Item(Owned),
    Module(usize, usize),
    /// A name of another crate, or one that a macro makes.
    Unknown,
}

/// The facade's names.
pub(super) fn facade(crates: &[Crate]) -> Result<Facade, String> {
    let world = World::new(crates)?;
    let Some(at) = crates.iter().position(|one| one.folder == FACADE) else { return Ok(Facade::default()) };
    let Some(root) = crates[at].library() else { return Ok(Facade::default()) };
    let names = world.names(at, root, 0);
    let mut seen = BTreeSet::new();
    world.collect(at, root, &mut seen);
    Ok(Facade { root: names.into_keys().collect(), total: seen.len() })
}

/// The interface of a library; nothing for a program.
pub(super) fn of(one: &Crate) -> Option<CrateApi> {
    let root = one.library()?;
    let crates = std::slice::from_ref(one);
    let world = World { crates, externals: vec![BTreeMap::new()] };
    let names = world.names(0, root, 0);
    let mut seen = BTreeSet::new();
    world.collect(0, root, &mut seen);
    let mut errors: Vec<String> = Vec::new();
    let implements = |name: &str| {
        name.ends_with("Error")
            || one.modules.iter().any(|module| module.errors.iter().any(|error| error == name))
    };
    let mut items = 0;
    for named in &seen {
        let Named::Item((_, module, item)) = *named else { continue };
        items += 1;
        let item = &one.modules[module].items[item];
        let is_type = matches!(item.keyword, "struct" | "enum");
        if is_type && (item.derives_error || implements(&item.name)) {
            errors.push(item.name.clone());
        }
    }
    errors.sort();
    Some(CrateApi { folder: one.folder.clone(), root: names.len(), items, errors })
}

impl<'a> World<'a> {
    fn new(crates: &'a [Crate]) -> Result<Self, String> {
        let workspace = Workspace::read()?;
        let mut externals = Vec::new();
        for one in crates {
            let mut names = BTreeMap::new();
            for dependency in workspace.dependencies(&Manifest::read(&one.folder)?) {
                if let Some(at) =
                    crates.iter().position(|other| Some(&other.folder) == dependency.folder.as_ref())
                {
                    names.insert(dependency.key.replace('-', "_"), at);
                }
            }
            externals.push(names);
        }
        Ok(Self { crates, externals })
    }

    /// The public names of a module.
    fn names(&self, at: usize, module: usize, depth: usize) -> BTreeMap<String, Named> {
        let (one, mut names) = (&self.crates[at], BTreeMap::new());
        if depth > 3 {
            return names;
        }
        let scope = &one.modules[module];
        for &child in scope.children.iter().filter(|&&child| one.modules[child].is_public) {
            names.insert(one.modules[child].name.clone(), Named::Module(at, child));
        }
        for (index, item) in scope.items.iter().enumerate().filter(|(_, item)| item.is_public) {
            names.insert(item.name.clone(), Named::Item((at, module, index)));
        }
        for import in scope.imports.iter().filter(|import| import.visibility == Visibility::Public) {
            let named = self.resolve(at, module, &import.path, depth);
            match (&import.name, named) {
                (Some(name), named) => {
                    names.insert(name.clone(), named);
                }
                (None, Named::Module(other, globbed)) if (other, globbed) != (at, module) => {
                    for (name, named) in self.names(other, globbed, depth + 1) {
                        names.entry(name).or_insert(named);
                    }
                }
                (None, _) => {}
            }
        }
        names
    }

    fn resolve(&self, at: usize, module: usize, path: &[String], depth: usize) -> Named {
        let start = (at, module);
        let one = &self.crates[at];
        let Some((first, rest)) = path.split_first() else { return Named::Unknown };
        let (mut named, mut rest) = match first.as_str() {
            "crate" => (one.library().map_or(Named::Unknown, |root| Named::Module(at, root)), rest),
            "self" => (Named::Module(at, module), rest),
            "super" => {
                (one.modules[module].parent.map_or(Named::Unknown, |parent| Named::Module(at, parent)), rest)
            }
            _ => (Named::Module(at, module), path),
        };
        // Another crate's name is found only if the module has none such.
        if rest.len() == path.len()
            && resolve_name(one, module, first, path.len() == 1)
                .is_none_or(|target| is_itself(one, module, target))
            && let Some(&other) = self.externals[at].get(first)
            && let Some(root) = self.crates[other].library()
        {
            (named, rest) = (Named::Module(other, root), &path[1..]);
        }
        while let Some((name, after)) = rest.split_first() {
            let Named::Module(at, module) = named else { return named };
            let target = resolve_name(&self.crates[at], module, name, after.is_empty());
            named = match target {
                Some(Target::Module(next)) => Named::Module(at, next),
                Some(Target::Item(module, item)) => Named::Item((at, module, item)),
                // Perhaps through a glob or a re-export of another crate.
                None if (at, module) != start => {
                    self.names(at, module, depth + 1).get(name).copied().unwrap_or(Named::Unknown)
                }
                Some(Target::Made(_)) | None => Named::Unknown,
            };
            rest = after;
        }
        named
    }

    /// Adds a module's public items and modules, and those below it.
    fn collect(&self, at: usize, module: usize, seen: &mut BTreeSet<Named>) {
        for named in self.names(at, module, 0).into_values() {
            if seen.insert(named)
                && let Named::Module(at, module) = named
            {
                self.collect(at, module, seen);
            }
        }
    }
}

/// Whether a name in a module led to nothing but that module's own import of another crate.
fn is_itself(one: &Crate, module: usize, target: Target) -> bool {
    target == Target::Module(module) && one.modules[module].parent.is_none()
}

/// The type names that are defined in more than one place, tests not counted, with the files.
pub(super) fn repeated_types(crates: &[Crate]) -> Vec<(String, Vec<String>)> {
    let mut places: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for one in crates {
        for module in &one.modules {
            for item in module.items.iter().filter(|item| TYPES.contains(&item.keyword)) {
                places.entry(&item.name).or_default().insert(&one.files[module.file].path);
            }
        }
    }
    let mut repeated: Vec<(String, Vec<String>)> = places
        .into_iter()
        .filter(|(_, files)| files.len() > 1)
        .map(|(name, files)| (name.to_owned(), files.into_iter().map(str::to_owned).collect()))
        .collect();
    repeated.sort_by_key(|(_, files)| std::cmp::Reverse(files.len()));
    repeated
}
