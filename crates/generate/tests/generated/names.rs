//! Names of a robot's file are data in generated code: it compiles with any name, including keywords of the
//! language.
#![allow(clippy::case_sensitive_file_extension_comparisons)] // this crate made the names

use robot_dynamics::description::{RobotDescription, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, GeneratedFiles, Precision, Request, Target, generate};

use crate::folder::Folder;

/// Keywords of Rust, reserved and contextual ones, names of crates and lints, and names that have a meaning
/// for Cargo.
const RUST: &str = "as async await break const continue crate dyn else enum extern false fn for gen if impl in let loop match \
    mod move mut pub ref return self Self static struct super trait true type unsafe use where while abstract become box do \
    final macro override priv try typeof unsized virtual yield auto default macro_rules raw safe union alloc core proc_macro \
    std test lib main build golden robot check number u8 f64 usize bool str Option Vec Some derive cfg include rustc crate_ _ __";
/// Keywords of C up to C23, of C++ up to C++26 and of CUDA, headers of C, and predefined macros.
const C: &str = "auto break case char const continue default do double else enum extern float for goto if inline int long \
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while _Alignas \
    _Alignof _Atomic _BitInt _Bool _Complex _Decimal128 _Generic _Imaginary _Noreturn _Static_assert _Thread_local alignas \
    alignof and and_eq asm atomic_cancel bitand bitor bool catch char8_t char16_t class compl concept const_cast consteval \
    constexpr constinit co_await co_return co_yield decltype delete dynamic_cast explicit export false friend mutable \
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public reflexpr reinterpret_cast requires \
    static_assert static_cast template this thread_local throw true try typeid typename typeof typeof_unqual using virtual \
    wchar_t xor xor_eq __global__ __device__ __host__ __shared__ __constant__ blockIdx threadIdx dim3 linux unix math stdio \
    stdlib string stdint errno limits complex time signal main test NAN INFINITY __LINE__ _ __";
/// Keywords of WGSL, including reserved ones.
const WGSL: &str = "alias break case const const_assert continue continuing default diagnostic discard else enable false fn \
    for if let loop override requires return struct switch true var while NULL Self abstract active alignas alignof as asm \
    asm_fragment async attribute auto await become binding_array cast catch class co_await co_return co_yield coherent \
    column_major common compile compile_fragment concept const_cast consteval constexpr constinit crate debugger decltype \
    delete demote demote_to_helper do dynamic_cast enum explicit export extends extern external fallthrough filter final \
    finally friend from fxgroup get goto groupshared highp impl implements import inline instanceof interface layout lowp \
    macro macro_rules match mediump meta mod module move mut mutable namespace new nil noexcept noinline nointerpolation \
    noperspective null nullptr of operator package packoffset partition pass patch pixelfragment precise precision premerge \
    private protected pub public readonly ref regardless register reinterpret_cast require resource restrict self set shared \
    sizeof smooth snorm static static_assert static_cast std subroutine super target template this thread_local throw trait \
    try type typedef typeid typename typeof union unless unorm unsafe unsized use using varying virtual volatile wgsl where \
    with writeonly yield f32 i32 u32 vec2 array main _ __";

/// Texts that begin or end a comment, a line, a string or an escape in some language, change the direction of
/// text, or are empty.
const HOSTILE: [&str; 24] = [
    "*/ int x = 1; /*",
    "/* ",
    "//",
    "\n#error a\n",
    "\r\nlet a;",
    "\u{2028}x",
    "\u{2029}x",
    "\u{85}x",
    "\u{b}x\u{c}x",
    "\u{202e}\u{2066}x",
    "\u{feff}x",
    "\u{0}",
    "\u{1b}[2J",
    "\u{9b}1m",
    "\u{7f}",
    "end\\",
    "end??/",
    "\"\"\"",
    "'\"`",
    "${HOME} $(x)",
    "<script>[a](b)```",
    "%d {} {0}",
    "a|b",
    "",
];

fn robot(name: &str, joint: &str, link: &str) -> Model {
    let mut robot: RobotDescription = pendulum(2.0, 0.5);
    robot.name = name.into();
    robot.joints[0].name = joint.into();
    robot.frames.clear();
    link.clone_into(&mut robot.joints[0].child);
    link.clone_into(&mut robot.links[1].name);
    Model::new(robot).unwrap()
}

fn request(target: Target) -> Request {
    let precision = if target == Target::Wgsl { Precision::Single } else { Precision::Double };
    Request::new(target, vec![Function::Gravity]).with_arithmetic(Arithmetic::new(precision))
}

/// The code for a robot in a folder of its own, and its name there.
fn code(group: &str, target: Target, model: &Model, request: &Request, number: usize) -> (Folder, String) {
    let generated = generate(model, request).unwrap();
    let ending = match target {
        Target::Rust => ".rs",
        Target::Cuda => ".cu",
        _ => ".c",
    };
    let is_code = |name: &str| {
        name.ends_with(ending)
            && !name.starts_with("test_")
            && !name.starts_with("tests/")
            && name != "src/lib.rs"
    };
    let file = generated.files.iter().map(|file| file.name.as_str()).find(|name| is_code(name)).unwrap();
    let name = file.trim_start_matches("src/").trim_end_matches(ending).to_owned();
    (Folder::of(&format!("names_{group}_{number}"), &generated), name)
}

/// Checks library and test with the compiler, without code generation.
fn assert_rust_compiles(folder: &Folder, name: &str) {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let strict = ["--edition", "2021", "-D", "warnings", "--emit", "metadata", "--crate-name", name];
    let library = format!("lib{name}.rmeta");
    folder.run(&rustc, &[&strict[..], &["--crate-type", "rlib", "src/lib.rs", "-o", &library]].concat());
    let strict = ["--edition", "2021", "-D", "warnings", "--emit", "metadata", "--test", "--extern"];
    let own = format!("{name}={library}");
    folder.run(&rustc, &[&strict[..], &[&own, "tests/golden.rs", "-o", "golden.rmeta"]].concat());
}

fn assert_shaders_are_valid(generated: &GeneratedFiles) {
    for shader in generated.files.iter().filter(|file| file.name.ends_with(".wgsl")) {
        let module = naga::front::wgsl::parse_str(&shader.text);
        let module = module.unwrap_or_else(|error| panic!("{}: {error}\n{}", shader.name, shader.text));
        assert_eq!(module.entry_points.len(), 1, "{}", shader.text);
    }
}

#[test]
fn every_word_of_rust_can_be_a_robots_name() {
    for (number, word) in RUST.split_whitespace().enumerate() {
        let model = robot(word, word, word);
        let (folder, name) = code("rust", Target::Rust, &model, &request(Target::Rust), number);
        assert_rust_compiles(&folder, &name);
    }
}

/// The folder is also searched for system headers.
#[test]
fn every_word_of_c_can_be_a_robots_name() {
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I.", "-fsyntax-only"];
    for (number, word) in C.split_whitespace().enumerate() {
        let model = robot(word, word, word);
        let (folder, name) = code("c", Target::C, &model, &request(Target::C), number);
        let files = [format!("{name}.c"), format!("test_{name}.c")];
        folder.run("cc", &[&strict[..], &files.each_ref().map(String::as_str)].concat());
        // The other two targets of the C family use the same names.
        for target in [Target::Cuda, Target::Casadi] {
            let own = generate(&model, &request(target)).unwrap();
            let main = if target == Target::Cuda { "cu" } else { "c" };
            assert!(own.file(&format!("{name}.{main}")).is_some(), "{word}");
        }
    }
}

#[test]
fn every_word_of_wgsl_can_be_a_robots_name() {
    for word in WGSL.split_whitespace() {
        assert_shaders_are_valid(&generate(&robot(word, word, word), &request(Target::Wgsl)).unwrap());
    }
}

/// A replaced name is noted in each file's head and in the result.
#[test]
fn another_name_is_noted() {
    let generated = generate(&robot("fn", "hinge", "rod"), &request(Target::Rust)).unwrap();
    let note = generated.renamed.clone().unwrap();
    for name in ["src/robot_fn.rs", "REPORT.md"] {
        assert!(generated.file(name).unwrap().text.contains(&note), "{name}");
    }
    assert_eq!(generate(&robot("fn", "hinge", "rod"), &request(Target::C)).unwrap().renamed, None);
}

/// Names are text in comments, strings, documentation, tables and rules of every target.
#[test]
fn hostile_names_are_text_in_every_file() {
    let python = "import ast, sys\nfor name in sys.argv[1:]: ast.parse(open(name, encoding='utf-8').read())";
    for (number, hostile) in HOSTILE.into_iter().enumerate() {
        let model = robot(hostile, &format!("j{hostile}"), &format!("l{hostile}"));
        let of = |target| {
            let frame = format!("frame_pose:l{hostile}");
            let mut request = request(target).with_name("own");
            request.functions.push(frame.parse().unwrap());
            request.command = Some(format!("dynamics generate {hostile}"));
            request
        };
        for target in Target::ALL {
            for file in &generate(&model, &of(target)).unwrap().files {
                let is_odd = |letter: &char| {
                    (letter.is_control() && !matches!(letter, '\n' | '\t'))
                        || matches!(letter, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
                };
                assert_eq!(file.text.chars().find(is_odd), None, "{}: {hostile:?}", file.name);
            }
        }
        let (folder, name) = code("hostile_rust", Target::Rust, &model, &of(Target::Rust), number);
        assert_rust_compiles(&folder, &name);
        folder.run("cargo", &["read-manifest", "--offline"]);
        let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only"];
        let (folder, _) = code("hostile_c", Target::C, &model, &of(Target::C), number);
        folder.run("cc", &[&strict[..], &["own.c", "test_own.c"]].concat());
        assert!(folder.run("make", &["-n"]).contains("own.c test_own.c -lm"), "{hostile:?}");
        let (folder, _) = code("hostile_casadi", Target::Casadi, &model, &of(Target::Casadi), number);
        folder.run("cc", &[&strict[..], &["own.c"]].concat());
        folder.run("python3", &["-c", python, "test_own.py"]);
        assert_shaders_are_valid(&generate(&model, &of(Target::Wgsl)).unwrap());
        let golden = generate(&model, &of(Target::Wgsl)).unwrap();
        folder.run(
            "python3",
            &["-c", "import json, sys; json.loads(sys.argv[1])", &golden.file("golden.json").unwrap().text],
        );
        // The kernels' text is not compiled here; the number of comment delimiters is compared instead.
        let kernels = generate(&model, &of(Target::Cuda)).unwrap();
        for file in kernels.files.iter().filter(|file| file.name.ends_with(".cu")) {
            assert_eq!(file.text.matches("/*").count(), file.text.matches("*/").count(), "{hostile:?}");
        }
    }
}
