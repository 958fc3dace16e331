//! WGSL, parsed and validated by naga, which browsers and wgpu use.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use robot_dynamics_generate::{Arithmetic, GenerateError, Precision, Request, Target, generate};

use crate::robots;

/// The shader of every function, in several parts if it is long, is valid, with one entry point and a buffer
/// for each argument and result.
#[test]
fn every_shader_is_valid() {
    let model = robots::named("ur5.urdf");
    let functions = robots::with_derivatives(&model);
    for arithmetic in [Arithmetic::new(Precision::Single).with_fused(), Arithmetic::new(Precision::Single)] {
        let request =
            Request::new(Target::Wgsl, functions.clone()).with_arithmetic(arithmetic).with_name("robot");
        let generated = generate(&model, &request).unwrap();
        let shaders: Vec<_> = generated.files.iter().filter(|file| file.name.starts_with("robot_")).collect();
        assert_eq!(shaders.len(), functions.len());
        for shader in shaders {
            let module = naga::front::wgsl::parse_str(&shader.text)
                .unwrap_or_else(|error| panic!("{}: {}", shader.name, error.emit_to_string(&shader.text)));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            let valid = validator.validate(&module);
            assert!(valid.is_ok(), "{}: {valid:?}", shader.name);
            assert_eq!(module.entry_points[0].name, "main");
            let buffers =
                module.global_variables.iter().filter(|(_, buffer)| buffer.binding.is_some()).count();
            assert!((2..=8).contains(&buffers), "{}: {buffers} buffers, a device has 8", shader.name);
        }
        let golden = &generated.file("golden.json").unwrap().text;
        assert!(golden.contains("\"inverse_dynamics\"") && golden.contains("\"-> tau\""), "{golden}");
    }
}

/// WGSL has no doubles.
#[test]
fn double_precision_is_rejected() {
    let request = Request::new(Target::Wgsl, vec![robot_dynamics_generate::Function::Gravity]);
    let error = generate(&robots::named("two_r.urdf"), &request).unwrap_err();
    assert!(matches!(error, GenerateError::NotInTarget { target: "WGSL", .. }), "{error}");
}
