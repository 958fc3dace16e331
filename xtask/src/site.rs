//! `cargo xtask site`: the lab, the guide with search, and the references, as one folder of static files.

mod links;
mod pages;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cargo::{cargo, checked, target_folder};
use crate::layers::libraries;
use crate::manifest::Manifest;
use crate::root::root;
use crate::step::step;
use crate::{lab, python};

/// The tasks of `cargo xtask site`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Job {
    /// Build the whole site.
    Build,
    /// Build it and serve it; runs until it is stopped.
    Serve,
    /// Build the guide alone, for the tests.
    Guide,
}

/// The port on which it is served.
const PORT: &str = "8080";

/// Builds the site, or its guide alone, and checks its links.
pub(crate) fn run(job: Job) -> Result<(), String> {
    let site = target_folder().join(if job == Job::Guide { "guide/site" } else { "site" });
    let python = guide(&site)?;
    if job != Job::Guide {
        lab::run(lab::Job::Build)?;
        copy(&root().join("lab/dist/site"), &site.join("lab"))?;
        references()?;
        copy(&target_folder().join("doc"), &site.join("rust"))?;
    }
    println!("\n== site: links");
    links::check(&site, &pages::PARTS)?;
    println!("\nstatic site:  {}", site.display());
    match job {
        Job::Guide => Ok(()),
        Job::Build => {
            println!("to look at it: cargo xtask site --serve, or any server of static files");
            Ok(())
        }
        Job::Serve => {
            println!("open http://localhost:{PORT}; Ctrl-C ends it");
            let mut serve = Command::new(python);
            serve.args(["-m", "http.server", PORT, "--bind", "localhost", "--directory"]).arg(&site);
            step("site: serve", serve)
        }
    }
}

/// The guide with the Python reference, by the generator in an environment of its own; that environment's
/// Python.
fn guide(site: &Path) -> Result<PathBuf, String> {
    let (root, folder) = (root(), target_folder().join("guide"));
    let python = python::environment(&folder)?;
    let requirements = root.join("guide/requirements.txt");
    // This is quick if everything is installed.
    let mut install = Command::new(&python);
    install
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"])
        .arg(requirements);
    step("guide: generator", install)?;
    println!("\n== guide: pages");
    let built = folder.join("build");
    pages::write(&built.join("pages"))?;
    copy_into(&root.join("guide/reference"), &built.join("pages"))
        .map_err(|error| format!("guide/reference: {error}"))?;
    let mut build = Command::new(&python);
    // Every warning is an error, such as a dead reference or a page that no table of contents lists.
    build.args([
        "-m",
        "sphinx",
        "--fail-on-warning",
        "--keep-going",
        "--quiet",
        "--jobs",
        "auto",
        "--conf-dir",
        "guide",
    ]);
    build.arg("--doctree-dir").arg(built.join("trees")).arg(built.join("pages")).arg(built.join("site"));
    build.current_dir(&root).env("PYTHONDONTWRITEBYTECODE", "1");
    step("guide: site", build)?;
    copy(&built.join("site"), site)?;
    Ok(python)
}

/// The documentation of the libraries.
fn references() -> Result<(), String> {
    // Pages from earlier runs would appear in its search.
    step("site: earlier documentation", cargo(&["clean", "--doc"]))?;
    let mut docs = checked(&["doc", "--all-features", "--no-deps", "--locked"]);
    for library in libraries() {
        docs.arg("--package").arg(Manifest::read(library)?.package()?);
    }
    docs.env("RUSTDOCFLAGS", "-D warnings");
    step("site: Rust reference", docs)
}

/// A folder in another's place.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let _ = fs::remove_dir_all(to);
    copy_into(from, to).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))
}

fn copy_into(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_into(&entry.path(), &target)?;
        } else if entry.file_name() != ".lock" {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
