//! The rooms of `multibody`, its top-level modules: which uses which, and whether each uses only those before it.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::tidy::root;

/// The file that shows the graph, between these lines.
const SHOWN_IN: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- rooms: written by `cargo xtask rooms` -->\n";
const END: &str = "<!-- rooms: end -->";

/// A room and the rooms that its code names.
struct Room {
    name: String,
    uses: BTreeSet<usize>,
}

/// Writes the graph into the file that shows it.
pub(crate) fn write() -> Result<(), String> {
    let (_, wanted) = texts(&read()?)?;
    fs::write(root().join(SHOWN_IN), wanted).map_err(|error| format!("{SHOWN_IN}: {error}"))
}

/// Adds what is broken: an arrow to a later room, and a graph that is not shown as it is.
pub(crate) fn check(broken: &mut Vec<String>) -> Result<(), String> {
    let rooms = read()?;
    for (at, room) in rooms.iter().enumerate() {
        for &other in room.uses.range(at + 1..) {
            broken.push(format!(
                "crates/multibody: `{}` uses `{}`, which comes after it in lib.rs",
                room.name, rooms[other].name
            ));
        }
    }
    let (found, wanted) = texts(&rooms)?;
    if found != wanted {
        broken.push(format!("{SHOWN_IN} shows another graph of rooms: `cargo xtask rooms` writes it"));
    }
    Ok(())
}

/// The file as it is, and with the graph of these rooms.
fn texts(rooms: &[Room]) -> Result<(String, String), String> {
    let found = fs::read_to_string(root().join(SHOWN_IN)).map_err(|error| format!("{SHOWN_IN}: {error}"))?;
    let (before, rest) =
        found.split_once(BEGIN).ok_or_else(|| format!("{SHOWN_IN}: there is no line {BEGIN}"))?;
    let (_, after) = rest.split_once(END).ok_or_else(|| format!("{SHOWN_IN}: there is no line {END}"))?;
    let wanted = format!("{before}{BEGIN}{}{END}{after}", table(rooms));
    Ok((found, wanted))
}

fn table(rooms: &[Room]) -> String {
    let mut table = String::from("| room | uses |\n| --- | --- |\n");
    for room in rooms {
        let uses: Vec<&str> = room.uses.iter().map(|&at| rooms[at].name.as_str()).collect();
        let _ = writeln!(table, "| `{}` | {} |", room.name, uses.join(", "));
    }
    table
}

/// The rooms in the order of `lib.rs`.
fn read() -> Result<Vec<Room>, String> {
    let source = root().join("crates/multibody/src");
    let library = code(&source.join("lib.rs"));
    let names: Vec<String> = library
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .map(str::to_owned)
        .collect();
    let exports = exports(&library, &names);
    let mut rooms = Vec::new();
    for name in &names {
        let mut room = Room { name: name.clone(), uses: BTreeSet::new() };
        let mut pending = vec![source.join(format!("{name}.rs")), source.join(name)];
        while let Some(path) = pending.pop() {
            if path.is_dir() {
                let entries = fs::read_dir(&path).map_err(|error| format!("{}: {error}", path.display()))?;
                pending.extend(entries.flatten().map(|entry| entry.path()));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = code(&path);
                room.uses.extend(named(&text).filter_map(|used| {
                    names
                        .iter()
                        .position(|name| *name == used)
                        .or_else(|| exports.iter().find(|(export, _)| *export == used).map(|(_, room)| *room))
                }));
            }
        }
        let own = rooms.len();
        room.uses.remove(&own);
        rooms.push(room);
    }
    Ok(rooms)
}

/// A file's code: no comments, no unit tests.
fn code(path: &Path) -> String {
    // A room need not have both a file and a folder.
    let Ok(text) = fs::read_to_string(path) else { return String::new() };
    let lines = text.lines().take_while(|line| line.trim() != "#[cfg(test)]");
    lines.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// What `lib.rs` re-exports, and from which room.
fn exports(library: &str, names: &[String]) -> Vec<(String, usize)> {
    let mut exports = Vec::new();
    for statement in library.split(';') {
        let Some((_, path)) = statement.split_once("pub use ") else { continue };
        let mut words = words(path);
        let Some(room) = words.next().and_then(|first| names.iter().position(|name| *name == first)) else {
            continue;
        };
        exports.extend(words.map(|word| (word.to_owned(), room)));
    }
    exports
}

/// What stands right after `crate::`, or in its braces.
fn named(text: &str) -> impl Iterator<Item = &str> {
    text.split("crate::").skip(1).flat_map(|rest| {
        let list = rest.strip_prefix('{').and_then(|list| list.split_once("};")).map(|(list, _)| list);
        match list {
            // Of `a::{b, c}` in a list, too, the first word is a room; b and c are none.
            Some(list) => words(list).collect::<Vec<_>>(),
            None => words(rest).take(1).collect(),
        }
    })
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}
