//! Standard output and standard error, with a reader that may leave early.

use std::io::{ErrorKind, Write};

use crate::failure::{Context, Failure};

/// Prints text. A reader that has seen enough (`head`, for one) is no failure; a full disk is.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to standard output"),
    }
}

/// Prints text on standard error, where it is in nobody's way.
#[allow(clippy::unnecessary_wraps)] // as `print`
pub(crate) fn print_error(text: &str) -> Result<(), Failure> {
    eprint!("{text}");
    Ok(())
}
