//! Calls of the machine's compilers, and the sizes that they report.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use super::driver;
use crate::generation::TracedPrograms;
use crate::program::Program;
use crate::{GenerateError, Request, Target};

/// Measurements of compiled functions.
pub(super) struct Measurements {
    /// The compiler and its options.
    pub(super) by: String,
    /// Bytes of the sine, where it is a function of its own.
    pub(super) sine: Option<usize>,
    functions: HashMap<String, Measurement>,
}

/// Measurements of one function.
#[derive(Clone, Copy, Default)]
pub(super) struct Measurement {
    /// Bytes of code, including parts.
    pub(super) code: Option<usize>,
    /// Bytes of stack, including callees.
    pub(super) stack: Option<usize>,
    /// Nanoseconds of a call.
    pub(super) time: Option<f64>,
}

impl Measurements {
    pub(super) fn of(&self, symbol: &str) -> Measurement {
        self.functions.get(symbol).copied().unwrap_or_default()
    }
}

/// Bytes by a function's name.
type Bytes = HashMap<String, usize>;

/// The output of a compiler and of the compiled driver.
struct Build {
    code: Bytes,
    stack: Bytes,
    /// The driver's output: for each function a line with its name and the time of a call.
    times: String,
}

/// Compiles the functions of a request with a driver that measures them, and runs the driver.
pub(super) fn compile(
    request: &Request,
    prepared: &TracedPrograms,
    folder: &Path,
) -> Result<Measurements, GenerateError> {
    let (compiler, mut options) = match request.target {
        Target::C => ("cc", vec!["-std=c99", "-O2", "-fno-math-errno"]),
        _ => ("rustc", vec!["--edition=2021", "-Copt-level=3", "-Ccodegen-units=1"]),
    };
    let version = run(folder, compiler, &["--version"])?.lines().next().unwrap_or_default().to_owned();
    if request.target == Target::C && !request.arithmetic.fused {
        options.push("-ffp-contract=off");
    }
    let by = format!("{version} ({})", options.join(" "));
    let build = match request.target {
        Target::C => build_c(request, prepared, folder, &options)?,
        _ => build_rust(request, prepared, folder, &options)?,
    };
    let functions = prepared.programs.iter().zip(&prepared.layouts).map(|(program, layout)| {
        let measured = build.measured(program, layout.parts.len());
        (program.symbol.clone(), measured)
    });
    let functions = functions.collect();
    Ok(Measurements { by, sine: build.code.get("sin_cos").copied(), functions })
}

fn write(folder: &Path, file: &str, text: &str) -> Result<(), GenerateError> {
    let path = folder.join(file);
    std::fs::write(&path, text).map_err(|cause| GenerateError::File { path, cause })
}

fn build_c(
    request: &Request,
    prepared: &TracedPrograms,
    folder: &Path,
    options: &[&str],
) -> Result<Build, GenerateError> {
    let TracedPrograms { name, programs, .. } = prepared;
    let compile = |arguments: &[&str]| run(folder, "cc", &[options, arguments].concat());
    let source = format!("{name}.c");
    let object = ["-c", &source, "-o", "measured.o"];
    // Compilers without `-fstack-usage` are called without it.
    let usage = match compile(&[&["-fstack-usage"][..], &object].concat()) {
        Ok(_) => {
            ["measured.su", &format!("{name}.su")].map(|file| std::fs::read_to_string(folder.join(file)).ok())
        }
        Err(_) => [None, None],
    };
    compile(&object)?;
    write(folder, "measured_driver.c", &driver::c(request, name, programs))?;
    compile(&["measured_driver.c", "measured.o", "-lm", "-o", "measured"])?;
    let [one, other] = usage;
    let prefix = format!("{name}_");
    let stack = one.or(other).map_or_else(HashMap::new, |text| usage_of(&text, &prefix));
    let names = move |symbol: &str| symbol.strip_prefix(&prefix).map(without_suffix);
    let symbols = run(folder, "nm", &["-S", "measured.o"]).unwrap_or_default();
    Ok(Build { code: sizes(&symbols, &names), stack, times: run(folder, "./measured", &[])? })
}

fn build_rust(
    request: &Request,
    prepared: &TracedPrograms,
    folder: &Path,
    options: &[&str],
) -> Result<Build, GenerateError> {
    let TracedPrograms { name, programs, .. } = prepared;
    let compile = |arguments: &[&str]| run(folder, "rustc", &[options, arguments].concat());
    compile(&["--crate-type=rlib", "--crate-name=measured", "--emit=obj,asm", "src/lib.rs"])?;
    write(folder, "measured_driver.rs", &driver::rust(request, name, programs))?;
    compile(&["measured_driver.rs", "-o", "measured_driver"])?;
    let assembly = std::fs::read_to_string(folder.join("measured.s")).unwrap_or_default();
    let stack = if cfg!(target_arch = "x86_64") { stack_of(&assembly) } else { HashMap::new() };
    let symbols = run(folder, "nm", &["-S", "measured.o"]).unwrap_or_default();
    Ok(Build { code: sizes(&symbols, &rust_name), stack, times: run(folder, "./measured_driver", &[])? })
}

impl Build {
    /// The measurements of a function with so many parts.
    fn measured(&self, program: &Program, parts: usize) -> Measurement {
        let symbol = &program.symbol;
        let names = || {
            let of_parts = (0..parts).filter(move |_| parts > 1).map(move |part| format!("{symbol}_{part}"));
            std::iter::once(symbol.clone()).chain(of_parts)
        };
        let code = names().map(|name| self.code.get(&name).copied()).sum();
        // Parts are called one after the other, and each may call a sine.
        let called = names().skip(1).filter_map(|name| self.stack.get(&name)).max().copied().unwrap_or(0);
        let has_sine = program.counts().sines > 0;
        let sine = if has_sine { self.stack.get("sin_cos").copied().unwrap_or(0) } else { 0 };
        let stack = self.stack.get(symbol).map(|own| own + called + sine);
        let of_line = |line: &str| line.strip_prefix(symbol.as_str())?.strip_prefix(' ')?.parse().ok();
        Measurement { code, stack, time: self.times.lines().find_map(of_line) }
    }
}

/// The output of a program.
///
/// # Errors
/// [`GenerateError::Compiler`] if it is missing or fails.
fn run(folder: &Path, program: &str, arguments: &[&str]) -> Result<String, GenerateError> {
    let failed = |what: String| GenerateError::Compiler { program: program.into(), what };
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.map_err(|cause| failed(cause.to_string()))?;
    if !output.status.success() {
        return Err(failed(String::from_utf8_lossy(&output.stderr).chars().take(2000).collect()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Bytes of functions by `nm -S`: address, size, kind, name.
fn sizes(text: &str, name: &dyn Fn(&str) -> Option<String>) -> Bytes {
    let size = |line: &str| {
        let [_, size, kind, symbol] = line.split_whitespace().collect::<Vec<_>>()[..] else { return None };
        let is_code = matches!(kind, "t" | "T");
        let name = name(symbol).filter(|_| is_code)?;
        Some((name, usize::from_str_radix(size, 16).ok()?))
    };
    text.lines().filter_map(size).collect()
}

/// A function's name without the suffix that GCC adds when it specializes arguments, `.constprop.0` for
/// example.
fn without_suffix(name: &str) -> String {
    name.split('.').next().unwrap_or(name).to_owned()
}

/// Bytes of stack by `-fstack-usage`: location and name, bytes, kind, separated by tabs.
fn usage_of(text: &str, prefix: &str) -> Bytes {
    let usage = |line: &str| {
        let mut fields = line.split('\t');
        let name = fields.next()?.rsplit(':').next()?.strip_prefix(prefix)?;
        Some((without_suffix(name), fields.next()?.parse().ok()?))
    };
    text.lines().filter_map(usage).collect()
}

/// The last identifier of a mangled path of Rust, in which lengths precede identifiers and a hash follows.
fn rust_name(symbol: &str) -> Option<String> {
    let mut rest = symbol.strip_prefix("_ZN")?;
    let (mut last, mut before) = (None, None);
    while let Some(digits) = rest.find(|c: char| !c.is_ascii_digit()).filter(|&digits| digits > 0) {
        let length: usize = rest[..digits].parse().ok()?;
        before = last;
        last = Some(rest.get(digits..digits + length)?);
        rest = &rest[digits + length..];
    }
    before.map(str::to_owned)
}

/// Bytes of stack by x86-64's instructions: pushed words, decrements of the stack pointer, and the return
/// address.
fn stack_of(assembly: &str) -> Bytes {
    let (mut bytes, mut here) = (HashMap::new(), None);
    for line in assembly.lines() {
        if let Some(name) = line.strip_suffix(':').and_then(rust_name) {
            bytes.insert(name.clone(), 8);
            here = Some(name);
        }
        let Some(own) = here.as_ref().and_then(|name| bytes.get_mut(name)) else { continue };
        let words: Vec<&str> = line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        let number = |text: &str| text.strip_prefix('$').and_then(|x| x.parse::<isize>().ok());
        match words[..] {
            ["pushq", _] => *own += 8,
            ["subq", by, "%rsp"] => *own += number(by).map_or(0, isize::unsigned_abs),
            // A decrement by 128 is encoded as an addition of −128, which is shorter.
            ["addq", by, "%rsp"] => *own += number(by).filter(|by| *by < 0).map_or(0, isize::unsigned_abs),
            _ => {}
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_sizes_and_stacks_are_read() {
        let mangled = "_ZN8measured5panda16inverse_dynamics17h9e326e2ccf06df80E";
        assert_eq!(rust_name(mangled).as_deref(), Some("inverse_dynamics"));
        let text = format!("0000000000000010 0000000000002af3 T {mangled}\n0000000000000000 r .LC0\n");
        assert_eq!(sizes(&text, &rust_name)["inverse_dynamics"], 0x2af3);
        let usage = "arm.c:37:26:arm_sin_cos\t8\tstatic\narm.c:99:6:arm_gravity\t736\tstatic\n";
        assert_eq!(usage_of(usage, "arm_")["gravity"], 736);
        assert_eq!(usage_of("arm.c:9:6:arm_gravity_0.constprop\t16\tstatic\n", "arm_")["gravity_0"], 16);
        let code = format!(
            "{mangled}:\n\tpushq\t%rbx\n\tsubq\t$488, %rsp\n\taddq\t$488, %rsp\n\tpopq\t%rbx\n\tretq\n"
        );
        assert_eq!(stack_of(&code)["inverse_dynamics"], 8 + 8 + 488);
        assert_eq!(stack_of(&code.replace("subq\t$488", "addq\t$-128"))["inverse_dynamics"], 8 + 8 + 128);
    }
}
