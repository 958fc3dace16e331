//! Draws the pictures of `docs/performance.md` and fills its tables from the measurements in
//! `docs/performance/`.
//!
//! `cargo run --release -p bench --bin plot_performance`

mod canvas;
mod floor;
mod panel;
mod peers;
mod records;
mod scaling;
mod steps;
mod tables;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use records::Records;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let docs = docs();
    let records = Records::read(&docs.join("performance"))?;
    let images = docs.join("images");
    for (name, text) in [
        ("performance-scaling.svg", scaling::draw(&records)?),
        ("performance-floor.svg", floor::draw(&records)?),
        ("performance-steps.svg", steps::draw(&records)?),
        ("performance-peers.svg", peers::draw(&records)?),
    ] {
        std::fs::write(images.join(name), text)?;
    }
    let page = docs.join("performance.md");
    let text = std::fs::read_to_string(&page)?;
    std::fs::write(page, tables::filled(&text, &records)?)?;
    Ok(())
}

/// `docs` of the repository.
fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("this package lies in the root").join("docs")
}

#[cfg(test)]
mod tests {
    /// The tables of the page agree with the measurements, number by number.
    #[test]
    fn the_page_holds_what_was_measured() {
        let records = super::Records::read(&super::docs().join("performance")).expect("measurements");
        let page = std::fs::read_to_string(super::docs().join("performance.md")).expect("the page");
        let filled = super::tables::filled(&page, &records).expect("tables");
        for (found, expected) in page.lines().zip(filled.lines()) {
            assert_eq!(found, expected, "run `cargo run -p bench --bin plot_performance`");
        }
        assert_eq!(page, filled);
    }
}
