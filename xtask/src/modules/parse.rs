//! Items, imports and paths of a module from its tokens.

use super::structure::{Crate, Import, Item, Module, Visibility};
use crate::tokens::{Placed, Token, after_group, after_item, tokenize};

/// Adds the module of a file and all below it.
pub(super) fn module(
    this: &mut Crate,
    name: String,
    parent: Option<usize>,
    file: usize,
    is_public: bool,
) -> usize {
    let index = add(this, name, parent, file, is_public);
    let code = this.files[file].code.clone();
    items(this, index, &tokenize(&code), &code);
    index
}

fn add(this: &mut Crate, name: String, parent: Option<usize>, file: usize, is_public: bool) -> usize {
    let index = this.modules.len();
    this.modules.push(Module { name, parent, file, is_public, ..Module::default() });
    if let Some(parent) = parent {
        this.modules[parent].children.push(index);
    }
    index
}

fn mark(tokens: &[Placed], index: usize, byte: u8) -> bool {
    tokens.get(index).is_some_and(|placed| placed.token == Token::Mark(byte))
}

fn word<'a>(tokens: &[Placed<'a>], index: usize) -> Option<&'a str> {
    match tokens.get(index)?.token {
        Token::Word(word) => Some(word),
        _ => None,
    }
}

/// Reads the items of a module whose tokens these are.
fn items(this: &mut Crate, module: usize, tokens: &[Placed], code: &str) {
    let mut index = 0;
    while index < tokens.len() {
        let start = index;
        let (mut derives_error, mut paths) = (false, Vec::new());
        while mark(tokens, index, b'#') {
            let open = index + 1 + usize::from(mark(tokens, index + 1, b'!'));
            let end = after_group(tokens, open);
            let words = || (open..end).filter_map(|at| word(tokens, at));
            derives_error |= words().next() == Some("derive") && words().any(|word| word == "Error");
            if words().any(|word| word == "path") {
                let to = tokens.get(end).map_or(code.len(), |placed| placed.at);
                let attribute = &this.files[this.modules[module].file].text[tokens[open].at..to];
                paths.extend(
                    attribute
                        .split_once("path = \"")
                        .and_then(|(_, rest)| rest.split('"').next())
                        .map(str::to_owned),
                );
            }
            // Paths in attributes are not looked for: derive macros come from other crates.
            index = end;
        }
        let mut visibility = Visibility::Private;
        if word(tokens, index) == Some("pub") {
            visibility = Visibility::Public;
            index += 1;
            if mark(tokens, index, b'(') {
                visibility = Visibility::Restricted;
                index = after_group(tokens, index);
            }
        }
        let first = index;
        let mut qualifier = index;
        while let Some("const" | "unsafe" | "async" | "extern" | "default" | "safe") = word(tokens, qualifier)
        {
            qualifier += 1;
            if tokens.get(qualifier).is_some_and(|placed| placed.token == Token::Other) {
                qualifier += 1;
            }
        }
        let keyword = match word(tokens, qualifier) {
            Some("fn") => "fn",
            Some("trait") => "trait",
            Some("impl" | "mod" | "use") => word(tokens, qualifier).unwrap_or_default(),
            _ => word(tokens, first).unwrap_or_default(),
        };
        let is_public = visibility == Visibility::Public;
        match keyword {
            "mod" => index = child(this, module, tokens, first, is_public, &paths, code),
            "use" => {
                index = import(tokens, first, visibility, &mut this.modules[module].imports);
            }
            "macro_rules" if mark(tokens, first + 1, b'!') => {
                let name = word(tokens, first + 2).unwrap_or_default().to_owned();
                let at = tokens[first].at;
                let item = Item { name, keyword: "macro_rules", is_public: false, derives_error, at };
                this.modules[module].items.push(item);
                index = after_item(tokens, first);
                scan(&mut this.modules[module], &tokens[first + 3..index]);
            }
            "fn" | "struct" | "enum" | "trait" | "type" | "const" | "static" | "union" => {
                let mut at = if matches!(keyword, "fn" | "trait") { qualifier } else { first } + 1;
                if word(tokens, at) == Some("mut") {
                    at += 1;
                }
                let keyword = KEYWORDS.into_iter().find(|known| *known == keyword).unwrap_or_default();
                let name = word(tokens, at).unwrap_or_default().to_owned();
                let item = Item { name, keyword, is_public, derives_error, at: tokens[first].at };
                this.modules[module].items.push(item);
                index = if matches!(keyword, "const" | "static" | "type") {
                    after_statement(tokens, first)
                } else {
                    after_item(tokens, first)
                };
                scan(&mut this.modules[module], &tokens[at..index]);
            }
            _ => {
                // An implementation, a macro's call, or a mark that is left over.
                index = after_item(tokens, first).max(start + 1);
                let implements = (first..index)
                    .find(|&at| word(tokens, at) == Some("Error") && word(tokens, at + 1) == Some("for"));
                let of = implements.and_then(|at| word(tokens, at + 2)).map(str::to_owned);
                this.modules[module].errors.extend(of);
                let taken = &tokens[first.min(index)..index];
                if is_macro_with_types(taken) {
                    items(this, module, &taken[3..taken.len() - 1], code);
                } else {
                    scan(&mut this.modules[module], taken);
                }
            }
        }
    }
}

const KEYWORDS: [&str; 8] = ["fn", "struct", "enum", "trait", "type", "const", "static", "union"];

/// Whether these tokens are a macro's call around definitions of types.
fn is_macro_with_types(tokens: &[Placed]) -> bool {
    mark(tokens, 1, b'!')
        && mark(tokens, 2, b'{')
        && (3..tokens.len()).any(|at| matches!(word(tokens, at), Some("struct" | "enum")))
}

/// The index after the `;` of a statement; its groups may hold others.
fn after_statement(tokens: &[Placed], start: usize) -> usize {
    let mut index = start;
    while index < tokens.len() {
        match tokens[index].token {
            Token::Mark(b'(' | b'[' | b'{') => index = after_group(tokens, index),
            Token::Mark(b';') => return index + 1,
            _ => index += 1,
        }
    }
    index
}

/// Adds a child module, of this file or another; the index after its declaration.
fn child(
    this: &mut Crate,
    module: usize,
    tokens: &[Placed],
    first: usize,
    is_public: bool,
    paths: &[String],
    code: &str,
) -> usize {
    let name = word(tokens, first + 1).unwrap_or_default().to_owned();
    let file = this.modules[module].file;
    if mark(tokens, first + 2, b'{') {
        let end = after_group(tokens, first + 2);
        let inner = add(this, name, Some(module), file, is_public);
        items(this, inner, &tokens[first + 3..end - 1], code);
        return end;
    }
    for file in files_of(this, module, &name, paths) {
        self::module(this, name.clone(), Some(module), file, is_public);
    }
    first + 3
}

/// The files of a child module: the usual one, and those of its `path` attributes.
fn files_of(this: &Crate, module: usize, name: &str, paths: &[String]) -> Vec<usize> {
    let folder = folder(this, module);
    let own = &this.files[this.modules[module].file].path;
    let beside = own.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut wanted = vec![format!("{folder}/{name}.rs"), format!("{folder}/{name}/mod.rs")];
    wanted.extend(paths.iter().map(|path| format!("{beside}/{path}")));
    (0..this.files.len()).filter(|&file| wanted.contains(&this.files[file].path)).collect()
}

/// The folder of a module's children.
fn folder(this: &Crate, module: usize) -> String {
    let mut inline = Vec::new();
    let mut at = module;
    while let Some(parent) = this.modules[at].parent
        && this.modules[parent].file == this.modules[at].file
    {
        inline.push(this.modules[at].name.clone());
        at = parent;
    }
    let path = this.files[this.modules[at].file].path.trim_end_matches(".rs");
    let is_folder = this.modules[at].parent.is_none() || path.ends_with("/mod");
    let base = if is_folder { path.rsplit_once('/').map_or("", |(base, _)| base) } else { path };
    let mut folder = base.to_owned();
    for name in inline.iter().rev() {
        folder = format!("{folder}/{name}");
    }
    folder
}

/// Adds the names of a `use` that begins at `first`; the index after its `;`.
fn import(tokens: &[Placed], first: usize, visibility: Visibility, imports: &mut Vec<Import>) -> usize {
    let end = after_statement(tokens, first);
    let mut prefix = Vec::new();
    let mut index = first + 1;
    tree(tokens, &mut index, &mut prefix, visibility, imports);
    end
}

/// Reads a tree of a `use`: `a::{b, c as d, e::*}`.
fn tree(
    tokens: &[Placed],
    index: &mut usize,
    prefix: &mut Vec<String>,
    visibility: Visibility,
    imports: &mut Vec<Import>,
) {
    let depth = prefix.len();
    let at = tokens.get(*index).map_or(0, |placed| placed.at);
    if tokens.get(*index).is_some_and(|placed| placed.token == Token::Path) {
        // `::name` is another crate's.
        prefix.push("::".to_owned());
        *index += 1;
    }
    loop {
        match tokens.get(*index).map(|placed| placed.token) {
            Some(Token::Mark(b'$')) => *index += 1,
            Some(Token::Word(name)) => {
                *index += 1;
                if tokens.get(*index).is_some_and(|placed| placed.token == Token::Path) {
                    prefix.push(name.to_owned());
                    *index += 1;
                    continue;
                }
                let mut path = prefix.clone();
                if name != "self" || path.is_empty() {
                    path.push(name.to_owned());
                }
                let mut alias = path.last().cloned();
                if word(tokens, *index) == Some("as") {
                    alias = word(tokens, *index + 1).map(str::to_owned);
                    *index += 2;
                }
                imports.push(Import { path, name: alias, visibility, at });
            }
            Some(Token::Mark(b'*')) => {
                *index += 1;
                imports.push(Import { path: prefix.clone(), name: None, visibility, at });
            }
            Some(Token::Mark(b'{')) => {
                *index += 1;
                while *index < tokens.len() && !mark(tokens, *index, b'}') {
                    let before = *index;
                    tree(tokens, index, prefix, visibility, imports);
                    if mark(tokens, *index, b',') || *index == before {
                        *index += 1;
                    }
                }
                *index += 1;
            }
            _ => {}
        }
        break;
    }
    prefix.truncate(depth);
}

/// Adds the paths and names of an item's code.
fn scan(module: &mut Module, tokens: &[Placed]) {
    let mut index = 0;
    while index < tokens.len() {
        let Some(first) = word(tokens, index) else {
            index += 1;
            continue;
        };
        let before = index.checked_sub(1).map(|before| tokens[before].token);
        match first {
            "pub" if mark(tokens, index + 1, b'(') => {
                index = after_group(tokens, index + 1);
                continue;
            }
            "use" => {
                // In a function; `use<…>` in a type is not one.
                if mark(tokens, index + 1, b'<') {
                    index += 1;
                } else {
                    index = import(tokens, index, Visibility::Private, &mut module.imports);
                }
                continue;
            }
            _ => {}
        }
        if matches!(before, Some(Token::Path))
            || (before == Some(Token::Mark(b'.')) && !is_range(tokens, index))
        {
            index += 1;
            continue;
        }
        let at = tokens[index].at;
        let mut path = vec![first.to_owned()];
        index += 1;
        while tokens.get(index).is_some_and(|placed| placed.token == Token::Path)
            && let Some(next) = word(tokens, index + 1)
        {
            path.push(next.to_owned());
            index += 2;
        }
        if path.len() > 1 {
            module.paths.push((path, at));
        } else if mark(tokens, index, b'!') && !mark(tokens, index + 1, b'=') {
            module.macros.entry(first.to_owned()).or_insert(at);
        } else {
            // A function counts where it is called: a variable may have its name.
            let is_call = mark(tokens, index, b'(') && before != Some(Token::Word("fn"));
            if is_call || first.starts_with(char::is_uppercase) {
                module.names.entry(first.to_owned()).or_insert(at);
            }
        }
    }
}

/// Whether the dot before a word is the second of `..`.
fn is_range(tokens: &[Placed], index: usize) -> bool {
    index >= 2 && tokens[index - 2].token == Token::Mark(b'.')
}
