//! Standard output and standard error, with a reader that may leave early.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

use multibody::text::{json, lines, one_line};

use crate::failure::{Context, Failure};

/// Prints lines, whose names have been written by [`one_line`]. A reader that has seen enough (`head`, for one) is no
/// failure; a full disk is.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    print_as_it_is(&lines(text))
}

/// Prints lines of JSON.
pub(crate) fn print_json(text: &str) -> Result<(), Failure> {
    print_as_it_is(&json(text))
}

/// Prints text for another program: a script, a manual page.
pub(crate) fn print_as_it_is(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to standard output"),
    }
}

/// Prints text on standard error, where it is in nobody's way.
#[allow(clippy::unnecessary_wraps)] // as `print`
pub(crate) fn print_error(text: &str) -> Result<(), Failure> {
    eprint!("{}", lines(text));
    Ok(())
}

/// Tells one line on standard error.
pub(crate) fn tell(text: impl Display) {
    eprintln!("{}", one_line(&text.to_string()));
}
