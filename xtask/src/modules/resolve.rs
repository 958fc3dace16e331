//! Paths to the files that define what they name.

use std::collections::BTreeMap;

use super::structure::{Crate, Item, Use, Visibility};

/// The target of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A module.
    Module(usize),
    /// An item, by its module and its index there.
    Item(usize, usize),
    /// A name of a module that no visible item has: a macro defines it.
    Made(usize),
}

/// Deepest chain of re-exports that is followed.
const DEEPEST: usize = 12;

/// The target of a name in a module; an item before a module of the same name if `prefer_item`.
pub(crate) fn resolve_name(this: &Crate, module: usize, name: &str, prefer_item: bool) -> Option<Target> {
    name_in(this, module, name, prefer_item, 0)
}

fn name_in(this: &Crate, module: usize, name: &str, prefer_item: bool, depth: usize) -> Option<Target> {
    if depth > DEEPEST {
        return None;
    }
    let scope = &this.modules[module];
    let child = this.child(module, name).map(Target::Module);
    let item = || scope.items.iter().position(|item| item.name == name).map(|at| Target::Item(module, at));
    if !prefer_item && child.is_some() {
        return child;
    }
    if let Some(item) = item() {
        return Some(item);
    }
    let mut found = child;
    for import in &scope.imports {
        // A `use a::a` names its own module on the way: the module is found first.
        if import.name.as_deref() == Some(name)
            && let Some(target) = path_in(this, module, &import.path, prefer_item, depth + 1)
        {
            if matches!(target, Target::Item(..)) == prefer_item {
                return Some(target);
            }
            found = found.or(Some(target));
        }
    }
    if found.is_some() {
        return found;
    }
    for import in scope.imports.iter().filter(|import| import.name.is_none()) {
        if let Some(Target::Module(globbed)) = path_in(this, module, &import.path, false, depth + 1)
            && globbed != module
            && let Some(target) = name_in(this, globbed, name, prefer_item, depth + 1)
        {
            return Some(target);
        }
    }
    None
}

fn path_in(this: &Crate, module: usize, path: &[String], prefer_item: bool, depth: usize) -> Option<Target> {
    let (first, mut rest) = path.split_first()?;
    let mut at = match first.as_str() {
        "crate" => root(this, module),
        "self" => module,
        "super" => this.modules[module].parent?,
        "::" | "Self" => return None,
        name => match name_in(this, module, name, prefer_item && rest.is_empty(), depth + 1)? {
            Target::Module(next) => next,
            target => return Some(target),
        },
    };
    while let Some((name, after)) = rest.split_first() {
        rest = after;
        if name == "super" {
            at = this.modules[at].parent?;
            continue;
        }
        match name_in(this, at, name, prefer_item && rest.is_empty(), depth + 1) {
            Some(Target::Module(next)) => at = next,
            Some(target) => return Some(target),
            None => return if leads_outside(this, at, name) { None } else { Some(Target::Made(at)) },
        }
    }
    Some(Target::Module(at))
}

/// Whether a name of a module is imported from another crate.
fn leads_outside(this: &Crate, module: usize, name: &str) -> bool {
    this.modules[module].imports.iter().any(|import| import.name.as_deref() == Some(name))
}

fn root(this: &Crate, mut module: usize) -> usize {
    while let Some(parent) = this.modules[module].parent {
        module = parent;
    }
    module
}

/// The uses between files: one for each pair, with all its paths.
pub(super) fn uses(this: &Crate) -> Vec<Use> {
    let mut found: BTreeMap<(usize, usize), Use> = BTreeMap::new();
    for (index, module) in this.modules.iter().enumerate() {
        let from = module.file;
        let mut add = |target: Option<Target>, path: String, at: usize| {
            let to = match target {
                Some(Target::Item(module, _) | Target::Made(module)) => this.modules[module].file,
                Some(Target::Module(_)) | None => return,
            };
            if to != from {
                let used = found.entry((from, to)).or_insert(Use { from, to, paths: Vec::new(), at });
                if !used.paths.contains(&path) {
                    used.paths.push(path);
                }
            }
        };
        for import in &module.imports {
            let target = path_in(this, index, &import.path, true, 0);
            // A re-export alone is not a use, nor is a glob: the names that the file has of them are.
            let is_used = match &import.name {
                None => false,
                Some(name) => import.visibility == Visibility::Private || module.names.contains_key(name),
            };
            if is_used {
                add(target, import.path.join("::"), import.at);
            }
        }
        if module.imports.iter().any(|import| import.name.is_none()) {
            for (name, &at) in &module.names {
                add(name_in(this, index, name, true, 0), name.clone(), at);
            }
        }
        for (path, at) in &module.paths {
            add(path_in(this, index, path, true, 0), path.join("::"), *at);
        }
        for (name, &at) in &module.macros {
            if module.items.iter().any(|item| item.name == *name) {
                continue;
            }
            let target = name_in(this, index, name, true, 0).or_else(|| macro_named(this, name));
            add(target, format!("{name}!"), at);
        }
    }
    found.into_values().collect()
}

/// A macro that is visible by textual scope.
fn macro_named(this: &Crate, name: &str) -> Option<Target> {
    this.modules.iter().enumerate().find_map(|(module, scope)| {
        let is_it = |item: &Item| item.keyword == "macro_rules" && item.name == name;
        scope.items.iter().position(is_it).map(|at| Target::Item(module, at))
    })
}
