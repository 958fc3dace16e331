//! Checks that no link of the site is dead and that pages fetch nothing from other sites.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Checks every page of the site but those of `rust`, whose links rustdoc checks. Links into parts that were
/// not built are accepted: the tests build the guide alone.
pub(super) fn check(site: &Path, parts: &[&str]) -> Result<(), String> {
    let mut pages = Vec::new();
    gather(site, site, &mut pages)?;
    let absent: Vec<String> =
        parts.iter().filter(|part| !site.join(part).exists()).map(|part| format!("{part}/")).collect();
    let (mut broken, mut links, mut anchors) = (Vec::new(), 0, BTreeMap::new());
    for page in &pages {
        let text = read(page)?;
        let shown = page.strip_prefix(site).unwrap_or(page).display().to_string();
        for Reference { target, fetched } in references(&text) {
            if is_elsewhere(&target) {
                if fetched && !target.starts_with("data:") {
                    broken.push(format!("{shown} fetches {target}"));
                }
                continue;
            }
            links += 1;
            if let Err(why) = follow(site, page, &target, &absent, &mut anchors) {
                broken.push(format!("{shown}: {target}: {why}"));
            }
        }
    }
    if broken.is_empty() {
        println!("{} pages, {links} links, none dead", pages.len());
        Ok(())
    } else {
        broken.dedup();
        Err(format!("{} of {links} links are dead or lead outside:\n  {}", broken.len(), broken.join("\n  ")))
    }
}

/// The HTML files of the guide and of the lab.
fn gather(site: &Path, folder: &Path, pages: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let inside = path.strip_prefix(site).unwrap_or(&path);
        if path.is_dir() {
            if !["rust", "files"].iter().any(|other| inside == Path::new(other)) {
                gather(site, &path, pages)?;
            }
        } else if path.extension().is_some_and(|end| end == "html") {
            pages.push(path);
        }
    }
    Ok(())
}

/// The target of an attribute, and whether the browser fetches it when it opens the page.
#[derive(Debug, PartialEq)]
struct Reference {
    target: String,
    fetched: bool,
}

fn references(page: &str) -> Vec<Reference> {
    let mut found = Vec::new();
    for tag in tags(page) {
        let name = tag.split([' ', '\n', '\t']).next().unwrap_or_default();
        for attribute in ["href", "src"] {
            if let Some(value) = value(tag, attribute) {
                let fetched = attribute == "src" || (name == "link" && value_is(tag, "rel", "stylesheet"));
                found.push(Reference { target: value.replace("&amp;", "&"), fetched });
            }
        }
    }
    found
}

/// The insides of all tags; scripts and styles are passed over.
fn tags(page: &str) -> Vec<&str> {
    let (mut tags, mut rest) = (Vec::new(), page);
    while let Some(open) = rest.find('<') {
        rest = &rest[open + 1..];
        if let Some(comment) = rest.strip_prefix("!--") {
            rest = comment.split_once("-->").map_or("", |(_, after)| after);
            continue;
        }
        if !rest.starts_with(|letter: char| letter.is_ascii_alphabetic()) {
            continue;
        }
        let Some(close) = rest.find('>') else { break };
        let tag = &rest[..close];
        tags.push(tag);
        rest = &rest[close + 1..];
        for text in ["script", "style"] {
            if tag.split([' ', '\n']).next() == Some(text) {
                rest = rest.split_once(&format!("</{text}")).map_or("", |(_, after)| after);
            }
        }
    }
    tags
}

/// The value of an attribute, with quotes or without.
fn value<'a>(tag: &'a str, attribute: &str) -> Option<&'a str> {
    let sign = format!("{attribute}=");
    let at = tag.match_indices(&sign).find(|(at, _)| tag[..*at].ends_with([' ', '\n', '\t', '"']))?.0;
    let rest = &tag[at + sign.len()..];
    match rest.chars().next() {
        Some(quote @ ('"' | '\'')) => rest[1..].split(quote).next(),
        _ => rest.split([' ', '\n', '\t']).next(),
    }
}

fn value_is(tag: &str, attribute: &str, expected: &str) -> bool {
    value(tag, attribute).is_some_and(|value| value.split(' ').any(|word| word == expected))
}

fn is_elsewhere(target: &str) -> bool {
    target.starts_with("//") || target.split(['/', '#', '?']).next().is_some_and(|start| start.contains(':'))
}

/// Whether the file is there, and the place in it.
fn follow(
    site: &Path,
    page: &Path,
    target: &str,
    absent: &[String],
    anchors: &mut BTreeMap<PathBuf, BTreeSet<String>>,
) -> Result<(), String> {
    let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = path.split('?').next().unwrap_or_default();
    let folder = page.parent().unwrap_or(site);
    let mut file = match (path, path.strip_prefix('/')) {
        ("", _) => page.to_owned(),
        (_, Some(from_root)) => site.join(from_root),
        _ => folder.join(path),
    };
    if file.is_dir() {
        file = file.join("index.html");
    }
    let inside = file.strip_prefix(site).unwrap_or(&file).display().to_string();
    if absent.iter().any(|part| inside.starts_with(part)) {
        return Ok(());
    }
    if !file.is_file() {
        return Err("there is no such file".into());
    }
    // The lab's addresses are its own.
    if anchor.is_empty() || inside.starts_with("lab/") || file.extension().is_none_or(|end| end != "html") {
        return Ok(());
    }
    if !anchors.contains_key(&file) {
        let text = read(&file)?;
        let names = tags(&text).into_iter().flat_map(|tag| [value(tag, "id"), value(tag, "name")]);
        anchors.insert(file.clone(), names.flatten().map(ToOwned::to_owned).collect());
    }
    if anchors[&file].contains(&decoded(anchor)) {
        Ok(())
    } else {
        Err("there is no such place in it".into())
    }
}

/// An anchor without percent signs.
fn decoded(anchor: &str) -> String {
    let (mut bytes, mut rest) = (Vec::new(), anchor.as_bytes());
    while let Some((first, after)) = rest.split_first() {
        let code = (*first == b'%').then(|| anchor_byte(after)).flatten();
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn anchor_byte(after: &[u8]) -> Option<u8> {
    u8::from_str_radix(std::str::from_utf8(after.get(..2)?).ok()?, 16).ok()
}

fn read(path: &Path) -> Result<String, String> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{Reference, check, references};

    #[test]
    fn references_are_found_with_and_without_quotes_and_not_in_scripts() {
        let page = "<a class=x href=\"a.html?b=1&amp;c#d\">a</a><script src=s.js>'<a href=\"no\">'</script>\
                    <!-- <a href='no'> --><link rel=stylesheet href='x.css'><a href=https://example.org>";
        let expected =
            [("a.html?b=1&c#d", false), ("s.js", true), ("x.css", true), ("https://example.org", false)];
        let expected = expected.map(|(target, fetched)| Reference { target: target.into(), fetched });
        assert_eq!(references(page), expected);
    }

    #[test]
    fn a_dead_link_a_missing_place_and_what_is_fetched_are_told() {
        let site = std::env::temp_dir().join(format!("links-{}", std::process::id()));
        fs::create_dir_all(&site).unwrap();
        let write = |name: &str, text: &str| fs::write(site.join(name), text).unwrap();
        write("b.html", "<h1 id='here'>b</h1>");
        write("a.html", "<a href='b.html#here'><a href='lab/x.html'><a href='https://example.org'>");
        assert_eq!(check(&site, &["lab"]), Ok(()));
        write(
            "a.html",
            "<a href='b.html#gone'><a href='c.html'><script src='https://example.org/x.js'></script>",
        );
        let told = check(&site, &["lab"]).unwrap_err();
        for word in ["b.html#gone", "c.html", "fetches https://example.org/x.js"] {
            assert!(told.contains(word), "{told}");
        }
        assert!(told.starts_with("3 of"), "{told}");
        fs::remove_dir_all(&site).unwrap();
    }
}
