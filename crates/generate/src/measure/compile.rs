//! The machine's compilers, and what they tell of what they made.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use super::driver;
use crate::request::Prepared;
use crate::{GenerateError, Request, Target};

/// What is known of compiled functions.
pub(super) struct Compiled {
    /// The compiler, and how it was called.
    pub(super) by: String,
    /// Bytes of the sine, where it is a function of its own.
    pub(super) sine: Option<usize>,
    functions: HashMap<String, Measured>,
}

/// What is known of one.
#[derive(Clone, Copy, Default)]
pub(super) struct Measured {
    /// Bytes, with its parts.
    pub(super) code: Option<usize>,
    /// Bytes, with what it calls.
    pub(super) stack: Option<usize>,
    /// Nanoseconds of a call.
    pub(super) time: Option<f64>,
}

impl Compiled {
    pub(super) fn of(&self, symbol: &str) -> Measured {
        self.functions.get(symbol).copied().unwrap_or_default()
    }
}

/// Bytes by a function's name.
type Bytes = HashMap<String, usize>;

pub(super) fn compile(
    request: &Request,
    prepared: &Prepared,
    folder: &Path,
) -> Result<Compiled, GenerateError> {
    let Prepared { name, programs, layouts } = prepared;
    let run = |program: &str, arguments: &[&str]| run(folder, program, arguments);
    let (compiler, options) = match request.target {
        Target::C => ("cc", vec!["-std=c99", "-O2", "-fno-math-errno"]),
        _ => ("rustc", vec!["--edition=2021", "-Copt-level=3", "-Ccodegen-units=1"]),
    };
    let version = run(compiler, &["--version"])?.lines().next().unwrap_or_default().to_owned();
    let mut options = options;
    if request.target == Target::C && !request.arithmetic.fused {
        options.push("-ffp-contract=off");
    }
    let by = format!("{version} ({})", options.join(" "));
    let write = |file: &str, text: &str| {
        let path = folder.join(file);
        std::fs::write(&path, text).map_err(|cause| GenerateError::File { path, cause })
    };
    let (code, stack, times) = if request.target == Target::C {
        let source = format!("{name}.c");
        // What does not know `-fstack-usage` is asked without.
        let object = ["-c", &source, "-o", "measured.o"];
        let with_usage = run(compiler, &[&options[..], &["-fstack-usage"], &object].concat());
        let usage = match with_usage {
            Ok(_) => ["measured.su", &format!("{name}.su")]
                .map(|file| std::fs::read_to_string(folder.join(file)).ok()),
            Err(_) => [None, None],
        };
        run(compiler, &[&options[..], &object].concat())?;
        write("measured_driver.c", &driver::c(request, name, programs))?;
        run(
            compiler,
            &[&options[..], &["measured_driver.c", "measured.o", "-lm", "-o", "measured"]].concat(),
        )?;
        let [one, other] = usage;
        let stack = one.or(other).map_or_else(HashMap::new, |text| usage_of(&text, &format!("{name}_")));
        let prefix = format!("{name}_");
        let names = move |symbol: &str| symbol.strip_prefix(&prefix).map(unspecialised);
        (sizes(&run("nm", &["-S", "measured.o"]).unwrap_or_default(), &names), stack, run("./measured", &[])?)
    } else {
        let library = ["--crate-type=rlib", "--crate-name=measured", "--emit=obj,asm", "src/lib.rs"];
        run(compiler, &[&options[..], &library].concat())?;
        write("measured_driver.rs", &driver::rust(request, name, programs))?;
        run(compiler, &[&options[..], &["measured_driver.rs", "-o", "measured_driver"]].concat())?;
        let text = std::fs::read_to_string(folder.join("measured.s")).unwrap_or_default();
        let stack = if cfg!(target_arch = "x86_64") { stack_of(&text) } else { HashMap::new() };
        (
            sizes(&run("nm", &["-S", "measured.o"]).unwrap_or_default(), &rust_name),
            stack,
            run("./measured_driver", &[])?,
        )
    };
    let functions = programs.iter().zip(layouts).map(|(program, layout)| {
        let (symbol, parts) = (&program.symbol, layout.parts.len());
        let names = || {
            let of_parts = (0..parts).filter(move |_| parts > 1).map(move |part| format!("{symbol}_{part}"));
            std::iter::once(symbol.clone()).chain(of_parts)
        };
        let own = names().map(|name| code.get(&name).copied()).sum();
        // Parts are called one after the other, and each may call a sine.
        let called = names().skip(1).filter_map(|name| stack.get(&name)).max().copied().unwrap_or(0);
        let sine = stack.get("sin_cos").copied().unwrap_or(0);
        let deep =
            stack.get(symbol).map(|own| own + called + if program.counts().sines > 0 { sine } else { 0 });
        let time = times.lines().find_map(|line| line.strip_prefix(symbol)?.strip_prefix(' ')?.parse().ok());
        (symbol.clone(), Measured { code: own, stack: deep, time })
    });
    let functions = functions.collect();
    Ok(Compiled { by, sine: code.get("sin_cos").copied(), functions })
}

/// What a program prints.
///
/// # Errors
/// [`GenerateError::Compiler`] where it is missing or fails.
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
fn sizes(told: &str, name: &dyn Fn(&str) -> Option<String>) -> Bytes {
    let size = |line: &str| {
        let [_, size, kind, symbol] = line.split_whitespace().collect::<Vec<_>>()[..] else { return None };
        let is_code = matches!(kind, "t" | "T");
        let name = name(symbol).filter(|_| is_code)?;
        Some((name, usize::from_str_radix(size, 16).ok()?))
    };
    told.lines().filter_map(size).collect()
}

/// A function's name without what GCC adds where it leaves out arguments, `.constprop.0` and the like.
fn unspecialised(name: &str) -> String {
    name.split('.').next().unwrap_or(name).to_owned()
}

/// Bytes of stack by `-fstack-usage`: place and name, bytes, kind, between tabs.
fn usage_of(told: &str, prefix: &str) -> Bytes {
    let usage = |line: &str| {
        let mut fields = line.split('\t');
        let name = fields.next()?.rsplit(':').next()?.strip_prefix(prefix)?;
        Some((unspecialised(name), fields.next()?.parse().ok()?))
    };
    told.lines().filter_map(usage).collect()
}

/// The last word of a path of Rust's, written with lengths before the words and a hash after.
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

/// Bytes of stack by x86-64's instructions: words that are pushed, and what the stack pointer is lowered by; and the return address.
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
            // 128 is written as −128 added, which is shorter.
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
        let told = format!("0000000000000010 0000000000002af3 T {mangled}\n0000000000000000 r .LC0\n");
        assert_eq!(sizes(&told, &rust_name)["inverse_dynamics"], 0x2af3);
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
