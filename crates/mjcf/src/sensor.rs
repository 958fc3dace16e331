//! `<sensor>`: what is measured where.

use multibody::{RobotDescription, SensorDescription, SensorKind, SensorObject, Shape, Treatment};

use crate::assemble::Places;
use crate::body::Body;
use crate::joint::Motion;
use crate::names::Names;
use crate::reader::{Element, Reader};
use crate::tree::{Id, Tree};

/// The field that a file has which states none.
pub(crate) const MAGNETIC: [f64; 3] = [0.0, -0.5, 0.0];

/// Where a sensor's names are looked for.
struct Around<'a> {
    bodies: &'a [Body],
    places: &'a Places,
}

impl Reader<'_> {
    /// All sensors that are answered, in the file's order; the others are named in the report.
    pub(crate) fn sensors(&mut self, bodies: &[Body], places: &Places, robot: &mut RobotDescription) {
        let mut names = Names::default();
        let all: Vec<Id> = self.tree.in_sections("sensor").collect();
        if all.is_empty() {
            return;
        }
        let field = self.magnetic_field();
        let around = Around { bodies, places };
        for (index, id) in all.into_iter().enumerate() {
            // The account of what is not read names the others.
            let Some(kind) = SensorKind::named(&self.tree.nodes[id].name) else { continue };
            let element = self.plain(id);
            let Some(object) = self.sensor_object(&element, kind, &around, robot) else { continue };
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = written.map_or_else(|| format!("sensor_{index}"), str::to_owned);
            let own = names.free(&name);
            if written.is_some() && own != name {
                let message = format!("there is a sensor {name:?} already; give each its own name");
                self.misplaced(&element, message);
            }
            let mut sensor = SensorDescription::new(own, kind, object);
            match kind {
                SensorKind::Magnetometer => sensor.field = field,
                SensorKind::Touch => sensor.zone = self.site_shape(&element, bodies),
                SensorKind::InsideSite => {
                    sensor.reference = self.site_frame(&element, places);
                    sensor.zone = self.site_shape(&element, bodies);
                    if sensor.reference.is_none() {
                        continue;
                    }
                }
                _ if self.text(&element, "refname").is_some() => {
                    sensor.reference =
                        self.frame_object(&element, ["reftype", "refname"], true, &around, robot);
                    if sensor.reference.is_none() {
                        continue;
                    }
                }
                _ => {}
            }
            sensor.cutoff = self.magnitude(&element, "cutoff").unwrap_or(0.0);
            sensor.noise = self.magnitude(&element, "noise").unwrap_or(0.0);
            if self.number(&element, "delay").is_some_and(|delay| delay > 0.0) {
                self.not_answered(&element, "its delay is left out: it shows the present");
            }
            self.read(&element, "a sensor");
            robot.sensors.push(sensor);
        }
    }

    /// `<option magnetic>`; what several of them say, the last one says.
    fn magnetic_field(&mut self) -> [f64; 3] {
        let mut field = MAGNETIC;
        for node in self.tree.children(Tree::ROOT, "option").collect::<Vec<_>>() {
            let element = self.plain(node);
            field = self.numbers::<3>(&element, "magnetic").unwrap_or(field);
        }
        field
    }

    fn not_answered(&mut self, element: &Element, why: impl Into<String>) {
        let (line, place) = (element.line, element.place.clone());
        self.push(line, place, Treatment::Ignored { physics: false }, why.into());
    }

    /// The object that the sensor is on; `None`, with an error or a note, where it is missing or not in the model.
    fn sensor_object(
        &mut self,
        element: &Element,
        kind: SensorKind,
        around: &Around<'_>,
        robot: &RobotDescription,
    ) -> Option<SensorObject> {
        let Around { bodies, places } = *around;
        match kind.name() {
            "clock" | "e_potential" | "e_kinetic" => Some(SensorObject::Robot),
            "accelerometer" | "velocimeter" | "gyro" | "magnetometer" | "force" | "torque" | "touch" => {
                self.site_frame(element, places)
            }
            "subtreecom" | "subtreelinvel" | "subtreeangmom" => {
                let body = self.body_named(element, "body", bodies)?;
                Some(places.links[body].as_str().into())
            }
            name if name.starts_with("joint") || name.starts_with("ball") => {
                let joint = self.required_text(element, "joint", "JOINT")?;
                let joint = self.joint_named(element, joint, places)?;
                let fits = match joint.motion {
                    Motion::Hinge | Motion::Slide => name.starts_with("joint"),
                    Motion::Ball => name.starts_with("ball"),
                    Motion::Free => false,
                };
                if !fits {
                    let message =
                        format!("not answered: joint {:?} is a {} joint", joint.name, joint.motion.word());
                    self.not_answered(element, message);
                }
                fits.then(|| joint.name.as_str().into())
            }
            name if name.starts_with("tendon") => {
                let has = |name: &str| robot.tendons.iter().any(|tendon| tendon.name == name);
                self.beside_tree(element, "tendon", "TENDON", has)
            }
            name if name.starts_with("actuator") => {
                let has = |name: &str| robot.actuators.iter().any(|actuator| actuator.name == name);
                self.beside_tree(element, "actuator", "ACTUATOR", has)
            }
            _ => {
                let turns = matches!(
                    kind,
                    SensorKind::FrameQuaternion
                        | SensorKind::FrameXAxis
                        | SensorKind::FrameYAxis
                        | SensorKind::FrameZAxis
                );
                self.frame_object(element, ["objtype", "objname"], turns, around, robot)
            }
        }
    }

    /// A tendon or an actuator, which the file may have and the model not.
    fn beside_tree(
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
            self.not_answered(element, format!("not answered: {what} {name:?} is not in the model"));
        } else {
            self.unknown_name(element, what, name);
        }
        None
    }

    /// The frame of the sensor's site.
    fn site_frame(&mut self, element: &Element, places: &Places) -> Option<SensorObject> {
        let name = self.required_text(element, "site", "SITE")?;
        let found = places.site(name).map(|site| site.frame.as_str().into());
        if found.is_none() {
            self.unknown_name(element, "site", name);
        }
        found
    }

    /// The form of the sensor's site.
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

    /// The object that `objtype` and `objname` name, or `reftype` and `refname`; `turns`: whether its axes count.
    fn frame_object(
        &mut self,
        element: &Element,
        [sort, name]: [&'static str; 2],
        turns: bool,
        Around { bodies, places }: &Around<'_>,
        robot: &RobotDescription,
    ) -> Option<SensorObject> {
        self.required_text(element, sort, "xbody");
        let name = self.required_text(element, name, "NAME")?;
        let sort = self.word(element, sort, &["body", "xbody", "geom", "site", "camera"])?;
        match sort {
            "body" | "xbody" => {
                let Some(body) = bodies.iter().position(|body| body.name == name) else {
                    self.unknown_name(element, "body", name);
                    return None;
                };
                let link = places.links[body].clone();
                if sort == "xbody" {
                    return Some(SensorObject::Named(link));
                }
                if turns {
                    let message = "not answered: the principal axes of a body are not unique; use xbody";
                    self.not_answered(element, message);
                    return None;
                }
                Some(SensorObject::CenterOfMass(link))
            }
            "geom" => {
                let is_geom = bodies.iter().flat_map(|body| &body.geoms).any(|geom| geom.name == name);
                let shape = robot.shapes.iter().find(|shape| shape.name == name);
                if !is_geom {
                    self.unknown_name(element, "geom", name);
                } else if shape.is_none_or(|shape| matches!(shape.shape, Shape::Mesh { .. })) {
                    let message = "not answered: the frame of a mesh in MuJoCo is that of its inertia";
                    self.not_answered(element, message);
                } else {
                    return Some(SensorObject::Shape(name.to_owned()));
                }
                None
            }
            "site" => {
                let found = places.site(name).map(|site| site.frame.as_str().into());
                if found.is_none() {
                    self.unknown_name(element, "site", name);
                }
                found
            }
            _ => {
                self.not_answered(element, "not answered: cameras are not in the model");
                None
            }
        }
    }
}
