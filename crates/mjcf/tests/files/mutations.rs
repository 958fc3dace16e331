//! Random changes to valid files: each is read or refused, and neither the reader nor the compiler of models
//! panics.

use robot_dynamics::mjcf::{LoadOptions, load, parse};
use robot_dynamics::model::Model;
use robot_dynamics::number::SplitMix64;

use crate::golden::root;

/// The files that load without other files.
fn texts() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for folder in ["testdata/mjcf", "robots"] {
        for entry in std::fs::read_dir(root().join(folder)).expect("the folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|extension| extension == "xml") {
                let text = std::fs::read_to_string(&path).expect("a text");
                found.push((path.display().to_string(), text));
            }
        }
    }
    found.sort();
    found
}

fn below(random: &mut SplitMix64, count: usize) -> usize {
    usize::try_from(random.next_u64() % count.max(1) as u64).expect("an index")
}

const WORDS: [&str; 24] = [
    "0",
    "-1",
    "1e30",
    "nan",
    "inf",
    "",
    "true",
    "auto",
    "free",
    "ball",
    "slide",
    "mesh",
    "box",
    "world",
    "<body>",
    "</body>",
    "<joint/>",
    "<freejoint/>",
    "0 0 0",
    "1 2 3 4 5 6 7",
    "\"",
    "'",
    "&amp;",
    "<!--",
];

/// One change: a span of the text is removed, doubled, or replaced by a word.
fn changed(text: &str, random: &mut SplitMix64) -> String {
    let letters: Vec<char> = text.chars().collect();
    // Changes between quotes and spaces keep most files well-formed.
    let ends: Vec<usize> =
        (0..letters.len()).filter(|&at| matches!(letters[at], '"' | ' ' | '<' | '>' | '=')).collect();
    let from = ends[below(random, ends.len())] + 1;
    let length = match below(random, 3) {
        0 => 1,
        1 => ends.iter().find(|&&end| end > from).map_or(1, |end| end - from),
        _ => below(random, 60),
    };
    let to = (from + length).min(letters.len());
    let (before, span, after) = (&letters[..from.min(to)], &letters[from.min(to)..to], &letters[to..]);
    let middle: Vec<char> = match below(random, 3) {
        0 => Vec::new(),
        1 => span.iter().chain(span).copied().collect(),
        _ => WORDS[below(random, WORDS.len())].chars().collect(),
    };
    before.iter().chain(&middle).chain(after).collect()
}

#[test]
fn changed_files_are_read_or_refused() {
    let texts = texts();
    let (mut read, mut refused) = (0, 0);
    for (at, (name, text)) in texts.iter().enumerate() {
        for seed in 0..150 {
            let mut random = SplitMix64::new(1000 * at as u64 + seed);
            let mut file = changed(text, &mut random);
            for _ in 0..below(&mut random, 4) {
                file = changed(&file, &mut random);
            }
            let outcome = std::panic::catch_unwind(|| match parse(&file, &LoadOptions::default()) {
                Ok(robot) => {
                    let _ = Model::new(robot.description);
                    true
                }
                Err(error) => {
                    assert!(!error.errors().is_empty());
                    let _ = error.to_string();
                    false
                }
            });
            let Ok(is_read) = outcome else { panic!("seed {seed} of {name} panics:\n{file}") };
            read += usize::from(is_read);
            refused += usize::from(!is_read);
        }
    }
    assert!(read > 200 && refused > 200, "{read} read, {refused} refused");
}

/// Mesh files that are truncated, changed or extended.
#[test]
fn changed_mesh_files_are_read_or_refused() {
    let folder = std::env::temp_dir().join(format!("mjcf-mesh-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut random = SplitMix64::new(5);
    for mesh in ["wedge.stl", "wedge_text.stl", "star.obj", "bar.msh"] {
        let bytes = std::fs::read(root().join("testdata/mjcf/meshes").join(mesh)).expect("a mesh");
        let extension = mesh.rsplit('.').next().expect("an ending");
        let file = format!("m.{extension}");
        let text = format!(
            "<mujoco><asset><mesh name='m' file='{file}'/></asset><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        std::fs::write(folder.join("robot.xml"), text).expect("a file");
        for _ in 0..150 {
            let mut changed = bytes.clone();
            match below(&mut random, 3) {
                0 => changed.truncate(below(&mut random, bytes.len())),
                1 => changed.extend(std::iter::repeat_n(
                    below(&mut random, 256).to_le_bytes()[0],
                    below(&mut random, 100),
                )),
                _ => {
                    for _ in 0..=below(&mut random, 5) {
                        let at = below(&mut random, changed.len());
                        changed[at] = below(&mut random, 256).to_le_bytes()[0];
                    }
                }
            }
            std::fs::write(folder.join(&file), &changed).expect("a file");
            if let Ok(robot) = load(folder.join("robot.xml"), &LoadOptions::default()) {
                let body = robot.description.links[1].mass_properties.expect("a body");
                assert!(body.mass().is_finite() && body.mass() > 0.0, "{mesh}: {body:?}");
            }
        }
        // The unchanged file loads.
        std::fs::write(folder.join(&file), &bytes).expect("a file");
        load(folder.join("robot.xml"), &LoadOptions::default())
            .unwrap_or_else(|error| panic!("{mesh}: {error}"));
    }
    std::fs::remove_dir_all(folder).expect("the folder");
}
