//! Compares this project's column in docs/faults.md with the result of loading each file of testdata/faults.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use robot_dynamics::model::Model;
use robot_dynamics::urdf::{Disposition, LoadOptions, Severity};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A row of the page.
struct Row {
    /// Whether the file is read with a floating base.
    freed: bool,
    /// The last cell.
    ours: String,
}

/// The rows of the page by the names of their files.
fn rows() -> BTreeMap<String, Row> {
    let page = std::fs::read_to_string(repository().join("docs/faults.md")).unwrap();
    let mut rows = BTreeMap::new();
    for line in page.lines().filter(|line| line.starts_with("| [")) {
        let (title, rest) = line.split_once("](../testdata/faults/").expect("a row names its file");
        let (file, cells) = rest.split_once(".urdf)").unwrap();
        let cells = cells.strip_suffix(" |").unwrap();
        let ours = cells.rsplit(" | ").next().unwrap().replace("\\|", "|").replace("\\<", "<");
        let row = Row { freed: title.ends_with(", root freed"), ours };
        assert!(rows.insert(file.to_owned(), row).is_none(), "{file} has two rows");
    }
    rows
}

/// The result of loading a file: its highest severity (`None` without findings), the messages of that
/// severity, and the model.
struct Outcome {
    severity: Option<Severity>,
    messages: Vec<String>,
    model: Option<Model>,
}

fn outcome(path: &Path, freed: bool) -> Outcome {
    let options = if freed { LoadOptions::default().with_floating_base() } else { LoadOptions::default() };
    let refused = |messages| Outcome { severity: Some(Severity::Error), messages, model: None };
    let robot = match robot_dynamics::urdf::load(path, &options) {
        Ok(robot) => robot,
        Err(error) => return refused(error.errors().iter().map(ToString::to_string).collect()),
    };
    let model = match Model::new(robot.description) {
        Ok(model) => model,
        Err(error) => return refused(vec![error.to_string()]),
    };
    let told = || robot.report.findings.iter().filter(|finding| finding.disposition() != Disposition::Read);
    let severity = told().map(robot_dynamics::urdf::Finding::severity).max();
    let messages = told()
        .filter(|finding| Some(finding.severity()) == severity)
        .map(|finding| finding.message().to_owned())
        .collect();
    Outcome { severity, messages, model: Some(model) }
}

/// The difference between the row and the result, if there is one.
fn disagreement(row: &Row, outcome: &Outcome) -> Option<String> {
    let Some(model) = &outcome.model else {
        let words = row.ours.strip_prefix("**error**: ");
        let told = words.is_some_and(|words| outcome.messages.iter().any(|message| message.contains(words)));
        return (!told).then(|| "it is refused".to_owned());
    };
    let Some((taken, told)) = row.ours.split_once("; ") else {
        return Some("it is loaded".to_owned());
    };
    let nv = model.nv();
    let as_taken = if let Some(mass) = taken.strip_prefix("M = ") {
        let mass: f64 = mass.parse().unwrap();
        // The page has four digits.
        nv == 1 && (model.mass_matrix(&[0.0]).unwrap()[(0, 0)] - mass).abs() <= 1e-3 * mass.abs()
    } else {
        taken == if nv == 0 { "nothing moves".to_owned() } else { format!("nv = {nv}") }
    };
    if !as_taken {
        let mass = if nv == 1 { model.mass_matrix(&[0.0]).unwrap()[(0, 0)] } else { f64::NAN };
        return Some(format!("it is loaded with nv = {nv}, M = {mass}"));
    }
    let agrees = match outcome.severity {
        None => told == "nothing to say",
        Some(severity) => told
            .strip_prefix(&format!("**{severity}**: "))
            .is_some_and(|words| outcome.messages.iter().any(|message| message.contains(words))),
    };
    (!agrees).then(|| format!("its gravest findings are {:?}", outcome.severity))
}

#[test]
fn every_fault_is_treated_as_the_page_says() {
    let rows = rows();
    let mut files: Vec<PathBuf> = std::fs::read_dir(repository().join("testdata/faults"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() >= 100 && files.len() == rows.len(), "{} files, {} rows", files.len(), rows.len());
    let mut wrong = Vec::new();
    for path in &files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let row = rows.get(name).unwrap_or_else(|| panic!("{name} has no row"));
        let outcome = outcome(path, row.freed);
        if let Some(what) = disagreement(row, &outcome) {
            wrong.push(format!("{name}: {what}\n  page:  {}\n  found: {:?}", row.ours, outcome.messages));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} rows are stale; run `python3 bench/robots/faults.py`:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
