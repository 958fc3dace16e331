//! The run-time compiler with its cache.

use std::ffi::OsString;
use std::path::Path;

use super::cache;
use super::ffi::nvrtc::{Image, Nvrtc};

/// The environment variable for the path of the compiler's library.
const VARIABLE: &str = "ROBOT_DYNAMICS_NVRTC";

/// Names of the library, newest first after that of an installed toolkit.
const NAMES: &[&str] = if cfg!(windows) {
    &["nvrtc64_130_0.dll", "nvrtc64_120_0.dll", "nvrtc64_112_0.dll"]
} else {
    &["libnvrtc.so", "libnvrtc.so.13", "libnvrtc.so.12", "libnvrtc.so.11.2"]
};

/// Code of a compilation for one architecture.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Target {
    option: String,
    image: Image,
}

/// The run-time compiler for one architecture.
pub(super) struct Compiler {
    nvrtc: Nvrtc,
    target: Target,
}

impl Compiler {
    /// Finds the compiler: at this path, at that of the environment variable, or in the system's search path.
    /// `capability` is the compute capability of the card, 90 for 9.0.
    ///
    /// # Errors
    /// A text that says what is missing.
    pub(super) fn find(path: Option<&Path>, capability: i32) -> Result<Self, String> {
        let given = path.map(|path| path.as_os_str().to_owned());
        let given = given.or_else(|| std::env::var_os(VARIABLE).filter(|path| !path.is_empty()));
        let names: Vec<OsString> = match given {
            Some(path) => vec![path],
            None => NAMES.iter().map(OsString::from).collect(),
        };
        let mut causes = Vec::new();
        for name in &names {
            match Nvrtc::load(name) {
                Ok(nvrtc) => {
                    let target = target(nvrtc.architectures(), capability)
                        .ok_or_else(|| format!("NVRTC has no code for compute capability {capability}"))?;
                    return Ok(Self { nvrtc, target });
                }
                Err(cause) => causes.push(cause),
            }
        }
        let names: Vec<_> = names.iter().map(|name| name.to_string_lossy()).collect();
        Err(format!(
            "the run-time compiler's library was not found as {} ({}); set {VARIABLE} to its path",
            names.join(", "),
            causes.last().map_or("", String::as_str)
        ))
    }

    /// Compiles a text, or returns the code of an earlier compilation of the same text.
    ///
    /// # Errors
    /// The message of the compiler.
    pub(super) fn compile(&self, text: &str) -> Result<Vec<u8>, String> {
        self.compile_with_cache(text, cache::folder().as_deref())
    }

    fn compile_with_cache(&self, text: &str, folder: Option<&Path>) -> Result<Vec<u8>, String> {
        let options = [self.target.option.clone()];
        let [major, minor] = self.nvrtc.version();
        let key = format!("NVRTC {major}.{minor} {}\n{text}", options.join(" ")).into_bytes();
        if let Some(code) = folder.and_then(|folder| cache::load(folder, &key)) {
            return Ok(code);
        }
        let code = self.nvrtc.compile(text, &options, self.target.image)?;
        if let Some(folder) = folder {
            cache::store(folder, &key, &code);
        }
        Ok(code)
    }
}

/// Machine code if the compiler knows the card; otherwise code of the closest older architecture, which the
/// driver compiles.
fn target(architectures: &[i32], capability: i32) -> Option<Target> {
    if architectures.contains(&capability) {
        return Some(Target { option: format!("--gpu-architecture=sm_{capability}"), image: Image::Cubin });
    }
    let older = architectures.iter().copied().filter(|&known| known < capability).max()?;
    Some(Target { option: format!("--gpu-architecture=compute_{older}"), image: Image::Ptx })
}

#[cfg(test)]
mod tests {
    use robot_dynamics::description::pendulum;
    use robot_dynamics::model::Model;
    use robot_dynamics_generate::{Function, Request, Target as Language, generate};

    use super::*;

    /// Needs no card. `ROBOT_DYNAMICS_NVRTC` names the library if the system does not find it.
    #[test]
    fn generated_kernels_compile_and_are_kept_where_the_compiler_is_installed() {
        let compiler = match Compiler::find(None, 90) {
            Ok(compiler) => compiler,
            Err(cause) => return println!("left out: {cause}"),
        };
        let model = Model::new(pendulum(2.0, 0.5)).unwrap();
        let functions = vec![Function::Rk4Step, Function::ForwardDynamicsPullback];
        let generated =
            generate(&model, &Request::new(Language::Cuda, functions).with_name("robot")).unwrap();
        let text = &generated.file("robot.cu").unwrap().text;
        let folder = std::env::temp_dir().join(format!("robot-dynamics-compiler-{}", std::process::id()));
        let code = compiler.compile_with_cache(text, Some(&folder)).unwrap();
        assert!(code.starts_with(b"\x7fELF"), "machine code");
        assert!(code.windows(14).any(|bytes| bytes == b"robot_rk4_step"), "the name of a kernel");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        assert_eq!(compiler.compile_with_cache(text, Some(&folder)).unwrap(), code);
        let error = compiler.compile_with_cache("no program", Some(&folder)).unwrap_err();
        assert!(error.contains("error") && error.contains("robot.cu"), "{error}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn unknown_cards_get_code_that_the_driver_compiles() {
        let known = [75, 80, 90];
        let of = |capability| target(&known, capability).map(|target| (target.option, target.image));
        assert_eq!(of(90), Some(("--gpu-architecture=sm_90".into(), Image::Cubin)));
        assert_eq!(of(89), Some(("--gpu-architecture=compute_80".into(), Image::Ptx)));
        assert_eq!(of(61), None);
    }

    #[test]
    fn a_missing_compiler_is_an_error_with_the_path() {
        let path = std::env::temp_dir().join("no-such-nvrtc.so");
        let error = Compiler::find(Some(&path), 90).err().unwrap();
        assert!(error.contains("no-such-nvrtc.so") && error.contains(VARIABLE), "{error}");
    }
}
