//! Results of a task, and their certificate.

use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use robot_dynamics_certified::Certificate;
use serde_json::Value;

use crate::failure::{CommandResult, Context, Failure};
use crate::output::{print, print_json, print_line};
use crate::output_file::{OutputFile, finish_all};

/// Options of all tasks.
#[derive(clap::Args)]
pub(super) struct Results {
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Write a certificate that a separate program can check; `-` for standard output.
    #[arg(long, value_name = "FILE.json")]
    certificate: Option<PathBuf>,
}

impl Results {
    /// Prints the results and writes the certificate, if there is one. The exit code tells whether the claim
    /// is proven.
    pub(super) fn finish<E: Display>(
        &self,
        is_proven: bool,
        text: &str,
        json: &Value,
        certificate: impl FnOnce() -> Option<Result<Certificate, E>>,
    ) -> CommandResult {
        let mut is_text_wanted = true;
        if let Some(path) = &self.certificate {
            if let Some(certificate) = certificate() {
                let certificate = certificate.context("--certificate")?;
                let mut output = OutputFile::create(path)?;
                is_text_wanted = !output.is_standard_output();
                writeln!(output, "{certificate}").context(path.display())?;
                finish_all(&mut [&mut output]).context(path.display())?;
            } else {
                print_line(format_args!("note: no certificate is written, since the claim is not proven"));
            }
        }
        if is_text_wanted {
            if self.json {
                print_json(&(serde_json::to_string(json).map_err(Failure::new)? + "\n"))?;
            } else {
                print(text)?;
            }
        }
        Ok(if is_proven { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}
