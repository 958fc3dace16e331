//! Random damage to valid files: each is refused or read, without a panic, and every robot that is read is a
//! tree.
//!
//! By default a few hundred seeded cases run. `PROPTEST_CASES=1000000 cargo test -p robot-dynamics-urdf
//! --test files mutations` runs that many from a random seed.

use std::path::PathBuf;
use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use robot_dynamics::model::Model;
use robot_dynamics::urdf::{LoadOptions, parse};

/// The robots of this repository, and one small file with every element that is read or reported.
static FILES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("robots").map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "urdf"));
    paths.sort();
    let read = |path| std::fs::read_to_string(path).expect("text");
    let mut files: Vec<String> = paths.into_iter().map(read).collect();
    assert!(files.len() >= 10);
    files.extend(vec![EVERYTHING.to_owned(); files.len()]);
    files
});

const EVERYTHING: &str = r#"<?xml version="1.0"?>
<robot name="all" xmlns:x="y">
  <link name="a"><visual/><x:foreign damping="1"/></link>
  <link name="b">
    <inertial>
      <origin xyz="1 2 3" quat_xyzw="0 0 1 1"/>
      <mass value="2.5"/><inertia ixx="0.3" ixy="0.01" ixz="0" iyy="0.4" iyz="-0.02" izz="0.5"/>
    </inertial>
  </link>
  <link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="j" type="revolute">
    <parent link="a"/><child link="b"/><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="1" effort="2" velocity="3"/>
    <dynamics damping="0.1" friction="0.2" armature="0.3" stiffness="0.4" rest="0.5"/>
    <safety_controller k_velocity="1"/>
  </joint>
  <joint name="k" type="prismatic">
    <parent link="b"/><child link="c"/><mimic joint="j" multiplier="2" offset="0.1"/>
  </joint>
  <transmission name="t"><actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
  <gazebo reference="j"><springStiffness>1</springStiffness></gazebo>
</robot>
"#;

/// Words that break numbers, names or structure when they replace another word.
const WORDS: &[&str] = &[
    "NaN",
    "inf",
    "-inf",
    "1e400",
    "1e30",
    "-1e30",
    "1e-320",
    "0",
    "-1",
    "",
    " ",
    "1 2",
    "a",
    "b",
    "c",
    "j",
    "k",
    "link",
    "joint",
    "inertial",
    "mimic",
    "fixed",
    "floating",
    "planar",
    "spherical",
    "continuous",
    "<",
    ">",
    "/>",
    "</robot>",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<!DOCTYPE",
    "<?",
    "&lt;",
    "&x;",
    "\"",
    "'",
    "=",
    "\u{feff}",
    "\0",
    "é",
    "xmlns:x=",
    "${m}",
];

#[derive(Clone, Debug)]
enum Damage {
    /// Overwrite a byte.
    Byte(usize, u8),
    /// Cut a piece out.
    Cut(usize, usize),
    /// Copy a piece elsewhere.
    Copy(usize, usize, usize),
    /// Replace the nth run of letters and digits, or of other characters.
    Word(usize, usize),
    /// Truncate.
    End(usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        1 => (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        1 => (any::<usize>(), 0..80_usize).prop_map(|(at, length)| Damage::Cut(at, length)),
        1 => (any::<usize>(), 0..200_usize, any::<usize>()).prop_map(|(at, length, to)| Damage::Copy(at, length, to)),
        8 => (any::<usize>(), 0..WORDS.len()).prop_map(|(nth, word)| Damage::Word(nth, word)),
        1 => any::<usize>().prop_map(Damage::End),
    ]
}

fn apply(text: &str, damage: &Damage) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let size = bytes.len().max(1);
    match *damage {
        Damage::Byte(at, byte) => {
            if let Some(target) = bytes.get_mut(at % size) {
                *target = byte;
            }
        }
        Damage::Cut(at, length) => {
            let start = (at % size).min(bytes.len());
            let end = (start + length).min(bytes.len());
            bytes.drain(start..end);
        }
        Damage::Copy(at, length, to) => {
            let start = (at % size).min(bytes.len());
            let piece = bytes[start..(start + length).min(bytes.len())].to_vec();
            let to = (to % size).min(bytes.len());
            bytes.splice(to..to, piece);
        }
        Damage::Word(nth, word) => {
            let is_inside = |letter: char| letter.is_alphanumeric() || "._-+".contains(letter);
            let pieces: Vec<&str> = text
                .split_inclusive(|letter| !is_inside(letter))
                .filter(|piece| piece.chars().filter(|&letter| is_inside(letter)).count() > 0)
                .collect();
            let Some(piece) = pieces.get(nth % pieces.len().max(1)) else { return text.to_owned() };
            let start = piece.as_ptr() as usize - text.as_ptr() as usize;
            let length = piece.trim_end_matches(|letter| !is_inside(letter)).len();
            bytes.splice(start..start + length, WORDS[word].bytes());
        }
        Damage::End(at) => bytes.truncate(at % size),
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Every robot that is read is a tree of finite numbers that compiles. A strict reading accepts no more
/// files.
fn check(text: &str) -> Result<(), TestCaseError> {
    // Repair does not change which files are refused, and leaves valid inertias unchanged.
    let repaired = parse(text, &LoadOptions::default().with_repaired_inertia());
    let Ok(robot) = parse(text, &LoadOptions::default()) else {
        prop_assert!(parse(text, &LoadOptions::default().with_strict()).is_err());
        prop_assert!(repaired.is_err());
        return Ok(());
    };
    let robot_again = parse(text, &LoadOptions::default()).expect("the same answer");
    prop_assert_eq!(&robot, &robot_again);
    let repaired = repaired.expect("what is read is also read with repairs");
    if repaired.report.counts.repaired == 0 {
        prop_assert_eq!(&robot, &repaired);
    }
    let description = &robot.description;
    prop_assert_eq!(description.links.len(), description.joints.len() + 1);
    for body in description.links.iter().filter_map(|link| link.mass_properties) {
        prop_assert!(body.mass() >= 0.0 && body.mass().is_finite());
        prop_assert!(body.center_of_mass().iter().all(|x| x.is_finite()));
        prop_assert!(body.inertia_about_center_of_mass().iter().all(|x| x.is_finite()));
    }
    for joint in &description.joints {
        let pose = joint.parent_from_joint;
        prop_assert!(pose.translation.iter().chain(pose.rotation.iter().flatten()).all(|x| x.is_finite()));
        prop_assert!(!joint.limits.lower.is_nan() && !joint.limits.upper.is_nan());
        prop_assert!(joint.limits.effort >= 0.0 && joint.limits.velocity >= 0.0);
        prop_assert!(joint.passive.damping.is_finite() && joint.passive.friction.is_finite());
    }
    // Robots with degrees of freedom that move no inertia compile, too.
    let compiled = Model::new(description.clone());
    prop_assert!(compiled.is_ok(), "{:?}", compiled.err());
    let warnings = robot.report.counts.warnings;
    let strict = parse(text, &LoadOptions::default().with_strict());
    prop_assert_eq!(strict.err().map_or(0, |error| error.errors().len() + error.unlisted()), warnings);
    Ok(())
}

fn config() -> ProptestConfig {
    let fresh = std::env::var_os("PROPTEST_CASES").is_some();
    ProptestConfig {
        rng_seed: if fresh { RngSeed::Random } else { RngSeed::Fixed(10) },
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn damaged_files_are_refused_or_read(file in any::<prop::sample::Index>(), damages in prop::collection::vec(damage(), 1..4)) {
        let mut text = file.get(&FILES).clone();
        for damage in &damages {
            text = apply(&text, damage);
        }
        check(&text)?;
    }

    #[test]
    fn bytes_are_refused_or_read(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn random_words_are_refused_or_read(words in prop::collection::vec(0..WORDS.len(), 0..60)) {
        let text: String = words.into_iter().map(|word| WORDS[word]).collect();
        check(&text)?;
        check(&format!("<robot name=\"r\">{text}</robot>"))?;
    }
}

#[test]
fn undamaged_files_are_read() {
    for text in FILES.iter() {
        parse(text, &LoadOptions::default()).expect("a valid file");
    }
}
