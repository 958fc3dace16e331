//! Writes the JavaScript bindings and the type declarations of a WebAssembly file: `lab-builder IN.wasm
//! OUT_DIR NAME`.

use std::path::PathBuf;
use std::process::ExitCode;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(Into::into).collect();
    let [input, output, name] = paths.as_slice() else {
        eprintln!("usage: lab-builder IN.wasm OUT_DIR NAME");
        return ExitCode::FAILURE;
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(input).out_name(&name.to_string_lossy()).typescript(true);
    bindgen.remove_name_section(true).remove_producers_section(true);
    // The page passes the module's address, so that one build works for a site, a single file and Node.
    let target = bindgen.web(true).map(|bindgen| bindgen.omit_default_module_path(true));
    match target.and_then(|bindgen| bindgen.generate(output)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lab-builder: {}: {error:?}", input.display());
            ExitCode::FAILURE
        }
    }
}
