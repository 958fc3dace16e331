//! Structure-aware changes of SDF and SRDF files: each file is read or refused, without a panic, in bounded
//! time, and every robot that is read compiles.
//!
//! By default 400 files of each kind are made from fixed seeds. `MUTANTS=100000 cargo test -p robot-dynamics
//! --test mutants` makes that many.

use std::fmt::Write as _;
use std::time::Instant;

use robot_dynamics::model::Model;
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{FileSet, LoadOptions, load_description_from_files, load_description_from_text};

const ARM: &str = include_str!("../../../testdata/sdf/arm.sdf");
const HAND: &str = include_str!("../../../testdata/sdf/hand/hand.sdf");
const CONFIG: &str = include_str!("../../../testdata/sdf/hand/model.config");
const PANDA: &str = include_str!("../../../robots/panda.urdf");

/// Every element of SDF that is read and not in the other files.
const PARTS: &str = "<sdf version='1.12'><world name='w'><gravity>0 0 -9</gravity><model name='m'><self_collide>1</self_collide>\
    <link name='a'><self_collide>0</self_collide><inertial auto='true'><density>500</density></inertial>\
    <collision name='c'><pose>0 0 1 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry>\
    <surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision>\
    <visual name='v'><pose relative_to='f'>0 0 1 0 0 0</pose><geometry><plane><normal>0 1 0</normal><size>1 1</size></plane></geometry></visual></link>\
    <link name='b'><gravity>false</gravity><velocity_decay><linear>0</linear></velocity_decay></link><link name='c'/><link name='d'/>\
    <model name='n' merge='true'><static>true</static><link name='e'/></model>\
    <frame name='f' attached_to='a'><pose rotation_format='quat_xyzw'>0 0 0 0 0 0 1</pose></frame>\
    <joint name='j' type='revolute2'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz><limit><lower>-1</lower>\
    <upper>1</upper><effort>9</effort></limit></axis><axis2><mimic joint='k' axis='axis'><multiplier>2</multiplier></mimic></axis2></joint>\
    <joint name='k' type='revolute'><pose>0 1 0 0 0 0</pose><parent>b</parent><child>c</child><axis><dynamics><damping>1</damping></dynamics></axis></joint>\
    <joint name='l' type='ball'><parent>c</parent><child>d</child></joint>\
    <joint name='o' type='revolute'><parent>a</parent><child>d</child><axis><xyz>0 1 0</xyz></axis></joint>\
    <joint name='w' type='fixed'><parent>world</parent><child>f</child></joint></model></world></sdf>";

const SRDF: &str = "<robot name='panda'><virtual_joint name='base' type='planar' parent_frame='ground' child_link='panda_link0'/>\
    <group name='arm'><chain base_link='panda_link0' tip_link='panda_link8'/></group><group name='one'><link name='panda_link1'/></group>\
    <group name='all'><group name='arm'/><group name='one'/><joint name='panda_joint2'/></group>\
    <group_state name='home' group='arm'><joint name='panda_joint1' value='1'/><joint name='base' value='1 2 3'/></group_state>\
    <end_effector name='hand' group='one' parent_link='panda_link8' parent_group='arm'/><passive_joint name='panda_joint3'/>\
    <disable_collisions link1='panda_link0' link2='panda_link1' reason='Adjacent'/><disable_default_collisions link='panda_link2'/>\
    <enable_collisions link1='panda_link2' link2='panda_link4'/><rotor_params><joint name='panda_joint4' mass='1' gear_ratio='2'/></rotor_params></robot>";

const WORDS: [&str; 22] = [
    "",
    "0",
    "-1",
    "1e30",
    "1e-320",
    "nan",
    "inf",
    "true",
    "world",
    "__model__",
    "0 0 0",
    "1 2 3 4 5 6",
    "0 0 0 0 0 0 0",
    "::",
    "a::b",
    "fixed",
    "ball",
    "floating",
    "universal",
    "1.4",
    "\u{e9}",
    "\"<&",
];

/// An element, or text.
#[derive(Clone)]
enum Part {
    Text(String),
    Element { tag: String, attributes: Vec<(String, String)>, parts: Vec<Part> },
}

/// The parts of a well-formed text with attributes in any quotes, without comments.
fn parts(text: &mut &str) -> Vec<Part> {
    let mut found = Vec::new();
    loop {
        let at = text.find('<').unwrap_or(text.len());
        let (before, rest) = text.split_at(at);
        if !before.trim().is_empty() {
            found.push(Part::Text(before.trim().to_owned()));
        }
        if rest.is_empty() || rest.starts_with("</") {
            *text = &rest[rest.find('>').map_or(0, |end| end + 1)..];
            return found;
        }
        let end = rest.find('>').expect("an end");
        let inside = rest[1..end].trim_end_matches('/');
        let (tag, mut words) = inside.split_once(' ').unwrap_or((inside, ""));
        let mut attributes = Vec::new();
        while let Some((name, value)) = words.split_once('=') {
            let quote = &value[..1];
            let (value, others) = value[1..].split_once(quote).expect("a value");
            attributes.push((name.trim().to_owned(), value.to_owned()));
            words = others;
        }
        *text = &rest[end + 1..];
        let parts = if rest[..end].ends_with('/') { Vec::new() } else { parts(text) };
        found.push(Part::Element { tag: tag.to_owned(), attributes, parts });
    }
}

fn written(parts: &[Part], text: &mut String) {
    let escaped = |value: &str| value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    for part in parts {
        match part {
            Part::Text(words) => text.push_str(&escaped(words)),
            Part::Element { tag, attributes, parts } => {
                write!(text, "<{tag}").expect("to a string");
                for (name, value) in attributes {
                    write!(text, " {name}=\"{}\"", escaped(value)).expect("to a string");
                }
                text.push('>');
                written(parts, text);
                write!(text, "</{tag}>").expect("to a string");
            }
        }
    }
}

fn below(random: &mut SplitMix64, count: usize) -> usize {
    usize::try_from(random.next_u64() % count.max(1) as u64).expect("an index")
}

/// All elements with their parts, in the order of the file.
fn elements<'a>(parts: &'a [Part], found: &mut Vec<&'a Part>) {
    for part in parts {
        if let Part::Element { parts, .. } = part {
            found.push(part);
            elements(parts, found);
        }
    }
}

/// Changes the nth element.
fn at_element(parts: &mut Vec<Part>, nth: &mut usize, change: &mut dyn FnMut(&mut Vec<Part>, usize)) -> bool {
    for index in 0..parts.len() {
        if matches!(parts[index], Part::Text(_)) {
            continue;
        }
        if *nth == 0 {
            change(parts, index);
            return true;
        }
        *nth -= 1;
        if let Part::Element { parts, .. } = &mut parts[index]
            && at_element(parts, nth, change)
        {
            return true;
        }
    }
    false
}

/// One change: an element is removed, copied, moved, renamed, or a value of it replaced.
fn change(file: &mut Vec<Part>, random: &mut SplitMix64) {
    let copies: Vec<Part> = {
        let mut found = Vec::new();
        elements(file, &mut found);
        found.into_iter().cloned().collect()
    };
    let values: Vec<String> = copies
        .iter()
        .flat_map(|part| match part {
            Part::Element { attributes, parts, .. } => {
                let own = attributes.iter().map(|(_, value)| value.clone());
                let texts = parts.iter().filter_map(|part| match part {
                    Part::Text(text) => Some(text.clone()),
                    Part::Element { .. } => None,
                });
                own.chain(texts).collect::<Vec<_>>()
            }
            Part::Text(_) => Vec::new(),
        })
        .collect();
    let mut nth = below(random, copies.len());
    let (kind, other) = (below(random, 8), copies[below(random, copies.len())].clone());
    let value = if below(random, 2) == 0 {
        WORDS[below(random, WORDS.len())].to_owned()
    } else {
        values.get(below(random, values.len())).cloned().unwrap_or_default()
    };
    let choice = below(random, 1000);
    at_element(file, &mut nth, &mut |parts, index| match (kind, &mut parts[index]) {
        (0, _) => {
            parts.remove(index);
        }
        (1, _) => {
            let copy = parts[index].clone();
            parts.insert(index, copy);
        }
        (2, Part::Element { parts, .. }) => parts.push(other.clone()),
        (3, Part::Element { tag, .. }) => {
            if let Part::Element { tag: new, .. } = &other {
                tag.clone_from(new);
            }
        }
        (_, Part::Element { attributes, parts, .. }) => {
            let count = attributes.len() + 1;
            match attributes.get_mut(choice % count) {
                Some((_, old)) => old.clone_from(&value),
                None => match parts.iter_mut().find(|part| matches!(part, Part::Text(_))) {
                    Some(part) => *part = Part::Text(value.clone()),
                    None => parts.push(Part::Text(value.clone())),
                },
            }
        }
        _ => {}
    });
}

fn count() -> u64 {
    std::env::var("MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(400)
}

/// Makes files from an original, and returns how many of them are read.
fn read_mutants(original: &str, read: impl Fn(&str) -> bool) -> u64 {
    let mut rest = original;
    let original = parts(&mut rest);
    let (mut is_read, start) = (0, Instant::now());
    let mut slowest = (0.0, String::new());
    for seed in 0..count() {
        let mut random = SplitMix64::new(seed);
        let mut file = original.clone();
        for _ in 0..=below(&mut random, 4) {
            if !file.is_empty() {
                change(&mut file, &mut random);
            }
        }
        let mut text = String::new();
        written(&file, &mut text);
        let before = Instant::now();
        let outcome = std::panic::catch_unwind(core::panic::AssertUnwindSafe(|| read(&text)));
        let seconds = before.elapsed().as_secs_f64();
        if seconds > slowest.0 {
            slowest = (seconds, text.clone());
        }
        is_read += u64::from(outcome.unwrap_or_else(|_| panic!("seed {seed} panics:\n{text}")));
    }
    // A file of 5 kB is read in about a millisecond. Each may take a thousand times as long on a loaded
    // machine.
    assert!(slowest.0 < 5.0, "{} s for\n{}", slowest.0, slowest.1);
    println!(
        "{is_read} of {} read, {:.1} s, slowest {:.4} s",
        count(),
        start.elapsed().as_secs_f64(),
        slowest.0
    );
    is_read
}

fn compiles(
    loaded: Result<robot_dynamics::LoadedDescription, robot_dynamics::FileError>,
    text: &str,
) -> bool {
    match loaded {
        Ok(loaded) => {
            let compiled = Model::new(loaded.description);
            assert!(compiled.is_ok(), "{:?}\n{text}", compiled.err());
            true
        }
        Err(error) => {
            assert!(!error.messages().is_empty() && !error.to_string().is_empty());
            false
        }
    }
}

#[test]
fn changed_sdf_files_are_read_or_refused() {
    for original in [ARM, PARTS] {
        let read = read_mutants(original, |text| {
            let files =
                FileSet::new([("arm.sdf", text), ("hand/hand.sdf", HAND), ("hand/model.config", CONFIG)]);
            compiles(load_description_from_files(&files, "arm.sdf", &LoadOptions::default()), text)
        });
        assert!(read > count() / 20 && read < count(), "{read}");
    }
    let read = read_mutants(HAND, |text| {
        let files = FileSet::new([("arm.sdf", ARM), ("hand/hand.sdf", text), ("hand/model.config", CONFIG)]);
        compiles(load_description_from_files(&files, "arm.sdf", &LoadOptions::default()), text)
    });
    assert!(read > count() / 20 && read < count(), "{read}");
}

#[test]
fn changed_srdf_files_are_read_or_refused() {
    let read = read_mutants(SRDF, |text| {
        let options = LoadOptions::default().with_srdf_text(text);
        compiles(load_description_from_text(PANDA, &options), text)
    });
    assert!(read > count() / 20 && read < count(), "{read}");
}

#[test]
fn originals_are_read() {
    let files = FileSet::new([("arm.sdf", ARM), ("hand/hand.sdf", HAND), ("hand/model.config", CONFIG)]);
    assert!(compiles(load_description_from_files(&files, "arm.sdf", &LoadOptions::default()), ARM));
    let parts = load_description_from_text(PARTS, &LoadOptions::default());
    let parts = parts.unwrap_or_else(|error| panic!("{error}"));
    assert!(compiles(Ok(parts), PARTS));
    let options = LoadOptions::default().with_srdf_text(SRDF);
    assert!(compiles(load_description_from_text(PANDA, &options), SRDF));
}
