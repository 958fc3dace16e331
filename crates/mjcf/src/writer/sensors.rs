//! Writes `<sensor>`.

use robot_dynamics_description::{SensorDescription, SensorKind, SensorObject, Shape};
use robot_dynamics_xml::excerpt;

use super::MjcfWriter;
use crate::sensor::MAGNETIC;

impl MjcfWriter<'_> {
    /// Assigns sites to the sensors that need one, with the shapes of their zones.
    pub(super) fn plan_sensor_sites(&mut self) {
        for sensor in &self.robot.sensors {
            let Some(SensorObject::Named(name)) = site_of(sensor) else { continue };
            if self.link_index.contains_key(name.as_str()) {
                self.plan_link_site(name);
            }
            if let Some(zone) = &sensor.zone {
                let site = self.site_named(name);
                self.zones.entry(site).or_insert(zone);
            }
        }
    }

    /// The site of this frame or link.
    fn site_named(&self, name: &str) -> String {
        self.link_sites.get(name).cloned().unwrap_or_else(|| name.to_owned())
    }

    /// Writes the shape of a site that is the zone of a sensor.
    pub(super) fn write_site_shape(&mut self, site: &str) {
        let Some(zone) = self.zones.get(site) else { return };
        let (form, size) = match **zone {
            Shape::Sphere { radius } => ("sphere", vec![radius]),
            Shape::Capsule { radius, length } => ("capsule", vec![radius, 0.5 * length]),
            Shape::Cylinder { radius, length } => ("cylinder", vec![radius, 0.5 * length]),
            Shape::Ellipsoid { half_axes } => ("ellipsoid", half_axes.to_vec()),
            Shape::Box { size } => ("box", size.map(|edge| 0.5 * edge).to_vec()),
            _ => return,
        };
        self.xml.attribute("type", form).numbers("size", &size);
    }

    /// The magnetic field of the first magnetometer, because MJCF has a single field; `None` if it is the
    /// default.
    pub(super) fn magnetic_field(&self) -> Option<[f64; 3]> {
        let is_one = |sensor: &&SensorDescription| sensor.kind == SensorKind::Magnetometer;
        self.robot.sensors.iter().find(is_one).map(|sensor| sensor.field).filter(|field| *field != MAGNETIC)
    }

    pub(super) fn write_sensors(&mut self) {
        let robot = self.robot;
        if robot.sensors.is_empty() {
            return;
        }
        self.xml.start("sensor");
        for sensor in &robot.sensors {
            let place = format!("sensor {:?}", excerpt(&sensor.name));
            match self.sensor_attributes(sensor) {
                Err(reason) => self.add_note(&place, format!("omitted: {reason}")),
                Ok(attributes) => {
                    self.xml.start(sensor.kind.name()).attribute("name", &sensor.name);
                    for (name, text) in attributes {
                        self.xml.attribute(name, &text);
                    }
                    self.xml.unless("cutoff", sensor.cutoff, 0.0).unless("noise", sensor.noise, 0.0).end();
                }
            }
        }
        self.xml.end();
    }

    /// The attributes that give the object of a sensor, or the reason for which MJCF cannot represent it.
    fn sensor_attributes(
        &self,
        sensor: &SensorDescription,
    ) -> Result<Vec<(&'static str, String)>, &'static str> {
        let mut attributes = Vec::new();
        if let Some(object) = site_of(sensor) {
            let SensorObject::Named(name) = object else {
                return Err("in MJCF it needs a site; attach it to a frame");
            };
            let site = self.site_named(name);
            if sensor.kind == SensorKind::Touch && sensor.zone.is_none() {
                return Err("in MJCF a touch sensor needs a zone; give it one");
            }
            if sensor.zone.as_ref().is_some_and(|zone| self.zones.get(&site).copied() != Some(zone)) {
                return Err("another sensor has another zone on the same frame; give each its own frame");
            }
            attributes.push(("site", site));
        }
        if sensor.kind == SensorKind::Magnetometer
            && sensor.field != self.magnetic_field().unwrap_or(MAGNETIC)
        {
            return Err("MJCF has one magnetic field, that of the first magnetometer");
        }
        let name = match &sensor.object {
            SensorObject::Named(name) => name.clone(),
            _ => String::new(),
        };
        match sensor.kind.name() {
            kind if kind.starts_with("joint") || kind.starts_with("ball") => attributes.push(("joint", name)),
            kind if kind.starts_with("tendon") => {
                let tendon = self.robot.tendons.iter().find(|own| own.name == name);
                if tendon.is_none_or(|own| own.terms.iter().all(|(joint, _)| self.is_locked(joint))) {
                    return Err("no joint of its tendon moves");
                }
                attributes.push(("tendon", name));
            }
            kind if kind.starts_with("actuator") => {
                let mut written = self.written_actuators.iter();
                if !written.any(|&index| self.robot.actuators[index].name == name) {
                    return Err("its actuator is omitted");
                }
                attributes.push(("actuator", name));
            }
            kind if kind.starts_with("subtree") => attributes.push(("body", self.body_name(&name))),
            kind if kind.starts_with("frame") || kind == "insidesite" => {
                let (kind, name) = self.frame_object(&sensor.object)?;
                attributes.extend([("objtype", kind.to_owned()), ("objname", name)]);
                if let Some(reference) = sensor.reference.as_ref().filter(|_| kind != "insidesite") {
                    let (kind, name) = self.frame_object(reference)?;
                    attributes.extend([("reftype", kind.to_owned()), ("refname", name)]);
                }
            }
            _ => {}
        }
        Ok(attributes)
    }

    fn frame_object(&self, object: &SensorObject) -> Result<(&'static str, String), &'static str> {
        match object {
            SensorObject::Named(name) if self.link_index.contains_key(name.as_str()) => {
                Ok(("xbody", self.body_name(name)))
            }
            SensorObject::Named(name) => Ok(("site", name.clone())),
            SensorObject::CenterOfMass(name) => Ok(("body", self.body_name(name))),
            SensorObject::Shape(name) if self.shape_names.contains(name) => Ok(("geom", name.clone())),
            _ => Err("its shape is not in the file"),
        }
    }
}

/// The object of a sensor that MJCF attaches to a site.
fn site_of(sensor: &SensorDescription) -> Option<&SensorObject> {
    match sensor.kind {
        SensorKind::InsideSite => sensor.reference.as_ref(),
        SensorKind::Accelerometer
        | SensorKind::Velocimeter
        | SensorKind::Gyro
        | SensorKind::Magnetometer
        | SensorKind::Force
        | SensorKind::Torque
        | SensorKind::Touch => Some(&sensor.object),
        _ => None,
    }
}
