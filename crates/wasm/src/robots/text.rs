//! Names from files, for the page.

use robot_dynamics::text::one_line;
use wasm_bindgen::prelude::wasm_bindgen;

/// A name from the file, on one line, for the page.
pub(crate) fn shown(name: &str) -> String {
    one_line(name).into_owned()
}

/// Any text on one line with invisible characters escaped, for names of files from the user.
#[wasm_bindgen(js_name = oneLine)]
pub fn one_line_text(text: &str) -> String {
    shown(text)
}
