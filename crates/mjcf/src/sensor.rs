//! Reads `<sensor>`.

use robot_dynamics_description::{
    Disposition, RobotDescription, SensorDescription, SensorKind, SensorObject, Shape,
};

use crate::assembly::ElementTable;
use crate::body::Body;
use crate::element::Element;
use crate::joint::JointType;
use crate::names::Names;
use crate::reader::Reader;
use crate::tree::{Id, Tree};

/// The default magnetic field of MJCF.
pub(crate) const MAGNETIC: [f64; 3] = [0.0, -0.5, 0.0];

/// The bodies and names that sensors refer to.
struct SensorScope<'a> {
    bodies: &'a [Body],
    table: &'a ElementTable,
}

impl Reader<'_> {
    /// Reads all supported sensors, in the order of the file. The others are reported.
    pub(crate) fn sensors(&mut self, bodies: &[Body], table: &ElementTable, robot: &mut RobotDescription) {
        let mut names = Names::default();
        let all: Vec<Id> = self.tree.in_sections("sensor").collect();
        if all.is_empty() {
            return;
        }
        let field = self.magnetic_field();
        let scope = SensorScope { bodies, table };
        for (index, id) in all.into_iter().enumerate() {
            // `list_unread` reports the others.
            let Some(kind) = SensorKind::named(&self.tree.nodes[id].name) else { continue };
            let element = self.raw_element(id);
            let Some(object) = self.sensor_object(&element, kind, &scope, robot) else { continue };
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("sensor_{index}"), str::to_owned);
            let own = names.unique(&name);
            if written.is_some() && own != name {
                let message = format!("the sensor {name:?} already exists; give each its own name");
                self.refuse(&element, message);
            }
            let mut sensor = SensorDescription::new(own, kind, object);
            match kind {
                SensorKind::Magnetometer => sensor.field = field,
                SensorKind::Touch => sensor.zone = self.site_shape(&element, bodies),
                SensorKind::InsideSite => {
                    sensor.reference = self.site_frame(&element, table);
                    sensor.zone = self.site_shape(&element, bodies);
                    if sensor.reference.is_none() {
                        continue;
                    }
                }
                _ if self.text(&element, "refname").is_some() => {
                    sensor.reference =
                        self.frame_object(&element, ["reftype", "refname"], true, &scope, robot);
                    if sensor.reference.is_none() {
                        continue;
                    }
                }
                _ => {}
            }
            sensor.cutoff = self.magnitude(&element, "cutoff").unwrap_or(0.0);
            sensor.noise = self.magnitude(&element, "noise").unwrap_or(0.0);
            if self.number(&element, "delay").is_some_and(|delay| delay > 0.0) {
                self.report_unsupported(&element, "its delay is ignored");
            }
            self.report_read(&element, "a sensor");
            robot.sensors.push(sensor);
        }
    }

    /// Reads `<option magnetic>`; the last value counts.
    fn magnetic_field(&mut self) -> [f64; 3] {
        let mut field = MAGNETIC;
        for node in self.tree.children(Tree::ROOT, "option").collect::<Vec<_>>() {
            let element = self.raw_element(node);
            field = self.numbers::<3>(&element, "magnetic").unwrap_or(field);
        }
        field
    }

    fn report_unsupported(&mut self, element: &Element, why: impl Into<String>) {
        let (line, place) = (element.line, element.place.clone());
        self.push(line, place, Disposition::Ignored { physics: false }, why.into());
    }

    /// The object that the sensor is attached to; `None`, with an error or a note, if it is missing or not in
    /// the model.
    fn sensor_object(
        &mut self,
        element: &Element,
        kind: SensorKind,
        scope: &SensorScope<'_>,
        robot: &RobotDescription,
    ) -> Option<SensorObject> {
        let SensorScope { bodies, table } = *scope;
        match kind.name() {
            "clock" | "e_potential" | "e_kinetic" => Some(SensorObject::Robot),
            "accelerometer" | "velocimeter" | "gyro" | "magnetometer" | "force" | "torque" | "touch" => {
                self.site_frame(element, table)
            }
            "subtreecom" | "subtreelinvel" | "subtreeangmom" => {
                let body = self.body_named(element, "body", bodies)?;
                Some(table.links[body].as_str().into())
            }
            name if name.starts_with("joint") || name.starts_with("ball") => {
                let joint = self.required_text(element, "joint", "JOINT")?;
                let joint = self.joint_named(element, joint, table)?;
                let fits = match joint.motion {
                    JointType::Hinge | JointType::Slide => name.starts_with("joint"),
                    JointType::Ball => name.starts_with("ball"),
                    JointType::Free => false,
                };
                if !fits {
                    let message = format!(
                        "sensor not supported: joint {:?} is a {} joint",
                        joint.name,
                        joint.motion.word()
                    );
                    self.report_unsupported(element, message);
                }
                fits.then(|| joint.name.as_str().into())
            }
            name if name.starts_with("tendon") => {
                let has = |name: &str| robot.tendon_names().any(|tendon| tendon == name);
                self.tendon_or_actuator(element, "tendon", "TENDON", has)
            }
            name if name.starts_with("actuator") => {
                let has = |name: &str| robot.actuators.iter().any(|actuator| actuator.name == name);
                self.tendon_or_actuator(element, "actuator", "ACTUATOR", has)
            }
            _ => {
                let turns = matches!(
                    kind,
                    SensorKind::FrameQuaternion
                        | SensorKind::FrameXAxis
                        | SensorKind::FrameYAxis
                        | SensorKind::FrameZAxis
                );
                self.frame_object(element, ["objtype", "objname"], turns, scope, robot)
            }
        }
    }

    /// A tendon or an actuator. One that is in the file but not in the model gives a note instead of an
    /// error.
    fn tendon_or_actuator(
        &mut self,
        element: &Element,
        what: &'static str,
        example: &'static str,
        has: impl Fn(&str) -> bool,
    ) -> Option<SensorObject> {
        let name = self.required_text(element, what, example)?;
        if has(name) {
            return Some(name.into());
        }
        let tree = self.tree;
        if tree.in_sections(what).any(|id| tree.nodes[id].attribute("name") == Some(name)) {
            self.report_unsupported(
                element,
                format!("sensor not supported: {what} {name:?} is not in the model"),
            );
        } else {
            self.refuse_unknown_name(element, what, name);
        }
        None
    }

    /// The frame of the sensor's site.
    fn site_frame(&mut self, element: &Element, table: &ElementTable) -> Option<SensorObject> {
        let name = self.required_text(element, "site", "SITE")?;
        let found = table.site(name).map(|site| site.frame.as_str().into());
        if found.is_none() {
            self.refuse_unknown_name(element, "site", name);
        }
        found
    }

    /// The shape of the sensor's site.
    fn site_shape(&mut self, element: &Element, bodies: &[Body]) -> Option<Shape> {
        let name = self.text(element, "site")?;
        let site = bodies.iter().flat_map(|body| &body.sites).find(|site| site.name == name)?.element.clone();
        let [a, mut b, mut c] = self.overlay(&site, "size", [0.005; 3]);
        let words = ["sphere", "capsule", "ellipsoid", "cylinder", "box"];
        let form = self.word(&site, "type", &words).unwrap_or("sphere");
        if let Some([x, y, z, u, v, w]) = self.numbers::<6>(&site, "fromto") {
            let half = 0.5 * (u - x).hypot(v - y).hypot(w - z);
            if matches!(form, "capsule" | "cylinder") {
                b = half;
            } else {
                (b, c) = (a, half);
            }
        }
        Some(match form {
            "capsule" => Shape::Capsule { radius: a, length: 2.0 * b },
            "ellipsoid" => Shape::Ellipsoid { half_axes: [a, b, c] },
            "cylinder" => Shape::Cylinder { radius: a, length: 2.0 * b },
            "box" => Shape::Box { size: [2.0 * a, 2.0 * b, 2.0 * c] },
            _ => Shape::Sphere { radius: a },
        })
    }

    /// The object of `objtype` and `objname`, or of `reftype` and `refname`; `turns`: whether its orientation
    /// matters.
    fn frame_object(
        &mut self,
        element: &Element,
        [sort, name]: [&'static str; 2],
        turns: bool,
        SensorScope { bodies, table }: &SensorScope<'_>,
        robot: &RobotDescription,
    ) -> Option<SensorObject> {
        self.required_text(element, sort, "xbody");
        let name = self.required_text(element, name, "NAME")?;
        let sort = self.word(element, sort, &["body", "xbody", "geom", "site", "camera"])?;
        match sort {
            "body" | "xbody" => {
                let Some(body) = bodies.iter().position(|body| body.name == name) else {
                    self.refuse_unknown_name(element, "body", name);
                    return None;
                };
                let link = table.links[body].clone();
                if sort == "xbody" {
                    return Some(SensorObject::Named(link));
                }
                if turns {
                    let message =
                        "sensor not supported: the principal axes of a body are not unique; use xbody";
                    self.report_unsupported(element, message);
                    return None;
                }
                Some(SensorObject::CenterOfMass(link))
            }
            "geom" => {
                let is_geom = bodies.iter().flat_map(|body| &body.geoms).any(|geom| geom.name == name);
                let shape = robot.shapes.iter().find(|shape| shape.name == name);
                if !is_geom {
                    self.refuse_unknown_name(element, "geom", name);
                } else if shape.is_none_or(|shape| matches!(shape.shape, Shape::Mesh { .. })) {
                    let message =
                        "sensor not supported: in MuJoCo the frame of a mesh is that of its inertia";
                    self.report_unsupported(element, message);
                } else {
                    return Some(SensorObject::Shape(name.to_owned()));
                }
                None
            }
            "site" => {
                let found = table.site(name).map(|site| site.frame.as_str().into());
                if found.is_none() {
                    self.refuse_unknown_name(element, "site", name);
                }
                found
            }
            _ => {
                self.report_unsupported(element, "sensor not supported: cameras are not in the model");
                None
            }
        }
    }
}
