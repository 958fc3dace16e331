//! Attaching parts of the same file and of other files. Cycles, and files outside the folder, are refused.

use robot_dynamics::description::RobotDescription;
use robot_dynamics_mjcf::{Disposition, Finding, LoadError, LoadOptions, MjcfError, Robot, parse};

use crate::faults::variant;
use crate::includes::Folder;

pub(crate) const LEG: &str = "<mujoco model='leg'><default><joint damping='0.5'/><default class='c'><geom size='0.1'/></default></default>\
    <worldbody><body name='leg' childclass='c'><joint name='hip'/><geom/></body></worldbody>\
    <actuator><motor name='m' joint='hip'/></actuator></mujoco>";

/// A file that names the leg, with this text in its world.
pub(crate) fn with_leg(attach: &str) -> String {
    format!(
        "<mujoco><asset><model name='leg' file='leg.xml'/></asset><worldbody>{attach}</worldbody></mujoco>"
    )
}

fn load(main: &str) -> Result<Robot, LoadError> {
    Folder::with("attach", &[("main.xml", main), ("leg.xml", LEG)]).load("main.xml")
}

fn links(robot: &RobotDescription) -> Vec<&str> {
    robot.links.iter().map(|link| link.name.as_str()).collect()
}

/// The file and the reason of a refused model.
fn refused(outcome: Result<Robot, LoadError>) -> (String, String) {
    let error = outcome.expect_err("a model that is refused");
    match error.errors() {
        [MjcfError::Attach { file, reason, .. }] => (file.clone(), reason.clone()),
        _ => panic!("{error}"),
    }
}

#[test]
fn classes_names_and_actuators_get_the_prefix() {
    let robot =
        load(&with_leg("<attach model='leg' prefix='a_'/><attach model='leg' body='leg' prefix='b_'/>"));
    let robot = robot.expect("a robot").description;
    assert_eq!(links(&robot), ["world", "a_leg", "b_leg"]);
    assert!(robot.joints.iter().all(|joint| joint.passive.damping == 0.5));
    let actuators: Vec<&str> = robot.actuators.iter().map(|actuator| actuator.name.as_str()).collect();
    assert_eq!(actuators, ["a_m", "b_m"]);
}

/// Classes with equal names stay separate, even with an empty prefix.
#[test]
fn an_empty_prefix_keeps_classes_apart() {
    let text = with_leg(
        "<body name='own'><joint name='j' class='c'/><geom class='c'/></body><attach model='leg' prefix=''/>",
    )
    .replace(
        "<asset>",
        "<default><joint damping='3'/><default class='c'><geom size='0.2'/></default></default><asset>",
    );
    let robot = load(&text).expect("a robot").description;
    assert_eq!(robot.joints.iter().map(|joint| joint.passive.damping).collect::<Vec<_>>(), [3.0, 0.5]);
    let masses: Vec<f64> = robot.links.iter().filter_map(|link| Some(link.mass_properties?.mass())).collect();
    assert!((masses[0] / masses[1] - 8.0).abs() < 1e-12, "{masses:?}"); // (0.2/0.1)³
}

#[test]
fn a_model_finds_its_files_from_its_own_folder() {
    let folder = Folder::with(
        "attach-folders",
        &[
            (
                "main.xml",
                "<mujoco><asset><model file='parts/a.xml'/></asset><worldbody><attach model='a' prefix='x_'/></worldbody></mujoco>",
            ),
            (
                "parts/a.xml",
                "<mujoco model='a'><include file='b.xml'/><asset><model name='c' file='more/c.xml'/></asset>\
              <worldbody><attach model='c' prefix='y_'/></worldbody></mujoco>",
            ),
            ("parts/b.xml", "<mujoco><worldbody><body name='b'/></worldbody></mujoco>"),
            ("parts/more/c.xml", "<mujoco><include file='d.xml'/></mujoco>"),
            ("parts/more/d.xml", "<mujoco><worldbody><body name='d'/></worldbody></mujoco>"),
        ],
    );
    let robot = folder.load("main.xml").expect("a robot");
    assert_eq!(links(&robot.description), ["world", "x_b", "x_y_d"]);
}

#[test]
fn cycles_of_models_are_refused() {
    let attach = |file: &str| {
        format!(
            "<mujoco><asset><model name='k' file='{file}'/></asset><worldbody><attach model='k' prefix='p'/></worldbody></mujoco>"
        )
    };
    let files = [
        ("main.xml", attach("a.xml")),
        ("a.xml", attach("b.xml")),
        ("b.xml", attach("./x/../a.xml")),
        ("self.xml", attach("self.xml")),
    ];
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = Folder::with("attach-circle", &files);
    for (main, again) in [("main.xml", "./x/../a.xml"), ("self.xml", "self.xml")] {
        let error = folder.load(main).expect_err("a circle");
        let is_it = |error: &MjcfError| matches!(error, MjcfError::Attach { file, .. } if file == again);
        assert!(error.errors().iter().any(is_it), "{main}: {error}");
    }
}

#[test]
fn missing_models_and_those_outside_a_confined_folder_are_refused() {
    let outside = std::env::temp_dir().join(format!("mjcf-outside-model-{}.xml", std::process::id()));
    std::fs::write(&outside, LEG).expect("a file");
    let name = outside.file_name().expect("a name").to_string_lossy().into_owned();
    for file in [format!("../{name}"), format!("x/../../{name}"), outside.display().to_string()] {
        let main = format!("<mujoco><asset><model file='{file}'/></asset></mujoco>");
        load(&main).expect("a robot");
        let folder = Folder::with("attach-confined", &[("main.xml", &main)]);
        let confined = LoadOptions::default().with_confined();
        let (named, reason) = refused(robot_dynamics_mjcf::load(folder.path().join("main.xml"), &confined));
        assert_eq!(named, file);
        assert!(reason.contains("to which reading is confined"), "{reason}");
    }
    std::fs::remove_file(outside).expect("the file");
    assert_eq!(refused(load("<mujoco><asset><model file='none.xml'/></asset></mujoco>")).0, "none.xml");
    assert_eq!(refused(load("<mujoco><asset><model/></asset></mujoco>")).0, "");
    assert_eq!(refused(parse(&with_leg(""), &LoadOptions::default())).0, "leg.xml");
    let folder = Folder::with("attach-urdf", &[("main.xml", &with_leg("")), ("leg.xml", "<robot/>")]);
    assert_eq!(refused(folder.load("main.xml")).0, "leg.xml");
}

/// Attachments that are refused, and the variant of the error.
#[rustfmt::skip]
pub(crate) const REFUSED: &[(&str, &str)] = &[
    ("<attach model='leg'/>", "MissingAttribute"),
    ("<attach prefix='a'/>", "Misplaced"),
    ("<attach model='arm' prefix='a'/>", "UnknownName"),
    ("<attach model='leg' body='arm' prefix='a'/>", "UnknownName"),
    ("<attach model='leg' frame='leg' prefix='a'/>", "UnknownName"),
    ("<attach model='leg' body='leg' frame='f' prefix='a'/>", "Misplaced"),
    ("<attach body='later' prefix='a'/><body name='later'/>", "UnknownName"),
    ("<body name='own'><attach body='own' prefix='a'/></body>", "Misplaced"),
    ("<body name='aleg'/><attach model='leg' body='leg' prefix='a'/>", "Misplaced"),
];

#[test]
fn invalid_attachments_are_refused() {
    for (attach, name) in REFUSED {
        let refused = load(&with_leg(attach)).expect_err("a refusal");
        let names: Vec<String> = refused.errors().iter().map(variant).collect();
        assert_eq!(names, [*name], "{attach}: {refused}");
    }
}

/// Each of forty models attaches the next one twice, which would give 2⁴⁰ legs. The file is refused before
/// they are created.
#[test]
fn exponential_growth_is_refused() {
    let mut files: Vec<(String, String)> = (0..40)
        .map(|k| {
            let (this, next) = (format!("f{k}.xml"), k + 1);
            let twice = "<attach model='n' prefix='a'/><attach model='n' prefix='b'/>";
            (this, format!("<mujoco><asset><model name='n' file='f{next}.xml'/></asset><worldbody>{twice}</worldbody></mujoco>"))
        })
        .collect();
    files.push(("f40.xml".into(), LEG.into()));
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let error = Folder::with("attach-doubling", &files).load("f0.xml").expect_err("too many");
    let is_told = |error: &MjcfError| matches!(error, MjcfError::TooMany { .. });
    assert!(error.errors().iter().any(is_told), "{error}");
}

#[test]
fn options_of_attached_models_are_ignored() {
    let leg = LEG.replace("<default>", "<option gravity='0 0 -1'/><deformable/><default>");
    let main = with_leg("<attach model='leg' prefix='a'/>");
    let folder = Folder::with("attach-options", &[("main.xml", &main), ("leg.xml", &leg)]);
    let robot = folder.load("main.xml").expect("a robot");
    assert_eq!(robot.description.gravity, [0.0, 0.0, -9.81]);
    let found: Vec<_> = robot.report.findings.iter().map(|f| (f.place(), f.disposition())).collect();
    let [note, warning] = [false, true].map(|physics| Disposition::Ignored { physics });
    assert!(found.contains(&("leg.xml: option", note)), "{}", robot.report);
    assert!(found.contains(&("leg.xml: deformable", warning)), "{}", robot.report);
    let merge = main.replace("<asset>", "<compiler conflict='merge'/><asset>");
    let folder = Folder::with("attach-merge", &[("main.xml", &merge), ("leg.xml", &leg)]);
    let robot = folder.load("main.xml").expect("a robot");
    let places: Vec<&str> =
        robot.report.warnings().map(robot_dynamics::description::Finding::place).collect();
    assert!(places.contains(&"leg.xml: option"), "{}", robot.report);
}

/// A tendon is copied if one of its joints is attached. Other elements with missing references are omitted
/// and reported.
#[test]
fn elements_with_missing_references_are_omitted() {
    let leg = LEG.replace("<geom/></body>", "<geom/><body name='foot'><joint name='toe'/><geom/></body></body>").replace(
        "<actuator>",
        "<equality><joint joint1='toe' joint2='hip'/></equality><tendon><fixed name='t'><joint joint='hip' coef='1'/>\
         <joint joint='toe' coef='2'/></fixed></tendon><actuator>",
    );
    let main = with_leg(
        "<body name='a'><joint name='hip'/><geom size='1'/></body><attach model='leg' body='foot' prefix='p_'/>",
    );
    let robot = Folder::with("attach-more", &[("main.xml", &main), ("leg.xml", &leg)])
        .load("main.xml")
        .expect("a robot");
    let terms = vec![("hip".to_owned(), 1.0), ("p_toe".to_owned(), 2.0)];
    assert_eq!(robot.description.tendons[0].terms, terms);
    assert!(robot.description.equalities.is_empty() && robot.description.actuators.is_empty());
    let is_ignored = |finding: &&Finding| finding.disposition() == Disposition::Ignored { physics: false };
    let places: Vec<&str> = robot.report.findings.iter().filter(is_ignored).map(Finding::place).collect();
    assert_eq!(places, ["leg.xml: joint", "leg.xml: motor \"m\""]);
}

/// Pairs and exclusions are copied if one of their two objects is attached and the other exists under its own
/// name. The expected results are those of `MuJoCo` 4.0.0.
#[test]
fn pairs_get_the_prefix() {
    let leg = "<mujoco model='leg'><default><pair condim='4' friction='0.3'/>\
        <default class='c'><geom size='0.1'/><pair friction='0.7'/></default></default>\
        <worldbody><body name='leg' childclass='c'><joint name='hip'/><geom name='shank'/>\
        <body name='foot' pos='0 0 -0.5'><joint name='toe'/><geom name='sole'/></body></body></worldbody>\
        <contact><pair name='p' class='c' geom1='shank' geom2='sole'/><exclude body1='leg' body2='foot'/></contact></mujoco>";
    let other = "<body name='leg'><freejoint/><geom name='shank' size='1'/></body><attach model='leg' body='foot' prefix='a_'/>";
    let cases: [(&str, &[[&str; 5]]); 4] = [
        ("<attach model='leg' prefix='a_'/>", &[["a_p", "a_shank", "a_sole", "a_leg", "a_foot"]]),
        (
            "<attach model='leg' body='leg' prefix='a_'/><attach model='leg' body='leg' prefix='b_'/>",
            &[
                ["a_p", "a_shank", "a_sole", "a_leg", "a_foot"],
                ["b_p", "b_shank", "b_sole", "b_leg", "b_foot"],
            ],
        ),
        ("<attach model='leg' body='foot' prefix='a_'/>", &[]),
        (other, &[["a_p", "shank", "a_sole", "leg", "a_foot"]]),
    ];
    for (attach, expected) in cases {
        let main = with_leg(attach);
        let folder = Folder::with("attach-pairs", &[("main.xml", &main), ("leg.xml", leg)]);
        let robot = folder.load("main.xml").expect("a robot").description;
        let names: Vec<[&str; 5]> = robot
            .contact_pairs
            .iter()
            .zip(&robot.contact_exclusions)
            .map(|(pair, (one, two))| {
                [&pair.name, &pair.shapes[0], &pair.shapes[1], one, two].map(String::as_str)
            })
            .collect();
        assert_eq!(names, expected, "{attach}");
        assert_eq!(robot.contact_exclusions.len(), expected.len(), "{attach}");
        let is_of_class = |pair: &robot_dynamics::description::ContactPairDescription| {
            pair.condim == 4 && pair.friction[..2] == [0.7, 1.0]
        };
        assert!(robot.contact_pairs.iter().all(is_of_class), "{attach}");
    }
}

/// Meshes, materials and height fields are found under the prefix, also those that are named after their
/// file.
#[test]
fn assets_get_the_prefix() {
    let leg = LEG.replace(
        "<worldbody>",
        "<asset><hfield file='hill.png' size='1 1 1 1'/><material name='red' rgba='1 0 0 1'/><texture name='red'/></asset><worldbody>\
         <geom type='hfield' hfield='hill' material='red'/>",
    );
    let main = with_leg("<attach model='leg' prefix='p_'/><attach model='leg' prefix='q_'/>");
    let folder = Folder::with("attach-assets", &[("main.xml", &main), ("leg.xml", &leg)]);
    let robot = folder.load("main.xml").expect("a robot");
    assert_eq!(robot.report.warnings().count(), 0, "{}", robot.report);
    let is_hill = |shape: &&robot_dynamics::description::LinkShape| {
        matches!(shape.shape, robot_dynamics::description::Shape::HeightField { .. })
    };
    let hills: Vec<_> = robot.description.shapes.iter().filter(is_hill).map(|shape| shape.color).collect();
    assert_eq!(hills, [Some([1.0, 0.0, 0.0, 1.0]); 2]);
}
