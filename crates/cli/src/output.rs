//! Standard output and standard error. A closed pipe is not an error.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

use robot_dynamics::text::{json, lines, one_line};

use crate::failure::{Context, Failure};

/// Prints lines whose names were escaped by [`one_line`]. A closed pipe, such as that of `head`, is not an
/// error; a full disk is.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    print_as_it_is(&lines(text))
}

/// Prints lines of JSON.
pub(crate) fn print_json(text: &str) -> Result<(), Failure> {
    print_as_it_is(&json(text))
}

/// Prints a script or a manual page unchanged.
pub(crate) fn print_as_it_is(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to standard output"),
    }
}

/// Prints text on standard error, while standard output has data.
#[allow(clippy::unnecessary_wraps)] // same signature as `print`
pub(crate) fn print_error(text: &str) -> Result<(), Failure> {
    eprint!("{}", lines(text));
    Ok(())
}

/// Prints one line on standard error.
pub(crate) fn print_line(text: impl Display) {
    eprintln!("{}", one_line(&text.to_string()));
}
