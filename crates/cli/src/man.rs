//! `dynamics man`: manual pages.

use std::path::PathBuf;
use std::process::ExitCode;

use clap_mangen::Man;
use robot_dynamics::output::write_files;
use robot_dynamics::text::one_line;

use crate::failure::{CommandResult, Failure};
use crate::interruption;
use crate::output::{print, print_as_it_is};

/// Print a manual page, or write all of them to a folder.
///
/// Without options, the page of the whole command: dynamics man | man -l -
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Subcommand whose page is printed.
    #[arg(value_name = "SUBCOMMAND", conflicts_with = "output")]
    subcommand: Option<String>,
    /// Folder for all pages: dynamics.1, dynamics-simulate.1, …
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, command: clap::Command) -> CommandResult {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    if let Some(folder) = &arguments.output {
        let shown = folder.display();
        if folder.exists() && !folder.is_dir() {
            return Err(Failure::new(format!(
                "cannot create the folder {shown}: a file of that name exists"
            )));
        }
        let commands = std::iter::once(&command).chain(command.get_subcommands());
        let pages: Vec<_> = commands
            .map(|command| Ok((folder.join(Man::new(command.clone()).get_filename()), page(command)?)))
            .collect::<Result<_, Failure>>()?;
        interruption::while_writing(|| write_files(&pages).map_err(Failure::new))?;
        print(&format!("wrote {} pages to {}\n", pages.len(), one_line(&shown.to_string())))?;
        return Ok(ExitCode::SUCCESS);
    }
    let chosen = match &arguments.subcommand {
        None => &command,
        Some(name) => command.find_subcommand(name).ok_or_else(|| {
            let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            Failure::new(format!("unknown subcommand `{name}`; known: {}", names.join(", ")))
        })?,
    };
    print_as_it_is(&page(chosen)?)?;
    Ok(ExitCode::SUCCESS)
}

/// A page in roff.
fn page(command: &clap::Command) -> Result<String, Failure> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    String::from_utf8(page).map_err(Failure::new)
}
