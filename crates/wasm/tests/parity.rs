//! The native side of the comparison with WebAssembly: this build computes the checked-in values.

use std::fs;

/// The file with the values of the native build for the lab's tests.
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lab/lib/dynamics/native-values.tsv");

/// Robot files, and whether their root link floats, as in `lab/lib/dynamics/parity.test.ts`.
const ROBOTS: [(&str, bool); 3] = [
    (include_str!("../../../robots/two_r.urdf"), false),
    (include_str!("../../../robots/panda.urdf"), false),
    (include_str!("../../../robots/humanoid.urdf"), true),
];

/// Another machine's sine may differ in its last bit, which half a second of falling magnifies.
const TOLERANCE: f64 = 1e-12;

#[test]
fn checked_in_values_are_native_ones() {
    let robots = ROBOTS.map(|(text, floating)| wasm::robot_parity_values(text, floating));
    let values: Vec<String> = core::iter::once(wasm::parity_values())
        .chain(robots)
        .flat_map(|values| values.unwrap_or_else(|error| panic!("{error}")))
        .collect();
    if std::env::var_os("REGENERATE").is_some() {
        fs::write(GOLDEN, values.join("\n") + "\n").unwrap();
    }
    let golden = fs::read_to_string(GOLDEN).unwrap();
    assert_eq!(golden.lines().count(), values.len(), "run this test with REGENERATE=1 and review the change");
    for (expected, found) in golden.lines().zip(&values) {
        let (name, kind, expected) = fields(expected);
        let (found_name, _, found) = fields(found);
        assert_eq!((name, expected.len()), (found_name, found.len()));
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        for (e, f) in expected.iter().zip(&found) {
            if kind == "exact" {
                assert_eq!(e.to_bits(), f.to_bits(), "{name}: {e} and {f}");
            } else {
                assert!((e - f).abs() <= TOLERANCE * size, "{name}: {e} and {f}");
            }
        }
    }
}

fn fields(line: &str) -> (&str, &str, Vec<f64>) {
    let mut fields = line.split('\t');
    let mut next = || fields.next().expect("three fields");
    (next(), next(), next().split(' ').map(|number| number.parse().expect("a number")).collect())
}
