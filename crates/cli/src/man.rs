//! `dynamics man`: the command's manual pages.

use std::path::PathBuf;
use std::process::ExitCode;

use clap_mangen::Man;

use multibody::text::one_line;
use robot_dynamics::output::write_files;

use crate::failure::{Failure, Outcome};
use crate::interruption;
use crate::output::{print, print_as_it_is};

/// Print a manual page, or write all of them into a folder.
///
/// Without options the page of the whole command, as man reads it: dynamics man | man -l -
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The page of this subcommand instead.
    #[arg(value_name = "SUBCOMMAND", conflicts_with = "output")]
    subcommand: Option<String>,
    /// Write a page for the command and one for each subcommand here: dynamics.1, dynamics-simulate.1, …
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, command: clap::Command) -> Outcome {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    if let Some(folder) = &arguments.output {
        let shown = folder.display();
        if folder.exists() && !folder.is_dir() {
            return Err(Failure::new(format!("cannot make the folder {shown}: a file has its name")));
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
            Failure::new(format!("there is no subcommand `{name}`; there are {}", names.join(", ")))
        })?,
    };
    print_as_it_is(&page(chosen)?)?;
    Ok(ExitCode::SUCCESS)
}

/// A page in the language of man.
fn page(command: &clap::Command) -> Result<String, Failure> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    String::from_utf8(page).map_err(Failure::new)
}
