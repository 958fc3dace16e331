//! The attributes of `<pid>` and `<dcmotor>` for actuators with several inputs, states, a motor or
//! cogging.

use robot_dynamics_description::{Activation, ActuatorDescription, Affine, ElectricMotor, IntegralAction};

type Range = [f64; 2];

const UNBOUNDED: Range = [f64::NEG_INFINITY, f64::INFINITY];
const NO_FORM: &str = "MJCF has no controller with these inputs and gains";

/// A controller of MJCF.
pub(super) struct Controller {
    pub(super) element: &'static str,
    /// The words of `input`.
    pub(super) inputs: String,
    pub(super) ranges: Vec<(&'static str, Range)>,
    pub(super) numbers: Vec<(&'static str, Vec<f64>)>,
}

impl Controller {
    /// The controller of an actuator and of those that add to it. `None` stands for an actuator alone, and
    /// the error is the reason if MJCF cannot represent it.
    pub(super) fn new<'a>(
        first: &'a ActuatorDescription,
        others: impl Iterator<Item = &'a ActuatorDescription>,
    ) -> Result<Option<Self>, &'static str> {
        let others: Vec<&ActuatorDescription> = others.collect();
        let has_rate_limit = matches!(first.activation, Activation::RateLimit { .. });
        let is_alone = others.is_empty() && first.cogging.is_none() && first.motor.is_none();
        if is_alone && first.integral.is_none() && !has_rate_limit {
            return Ok(None);
        }
        let is_plain = |own: &ActuatorDescription| {
            own.muscle.is_none()
                && (own.activation == Activation::None || has_rate_limit && own.adds_to.is_none())
                && own.gain == Affine::constant(own.gain.constant)
        };
        let is_input = |own: &&ActuatorDescription| {
            own.bias == Affine::default()
                && own.cogging.is_none()
                && own.integral.is_none()
                && own.motor.is_none()
                && own.at_terminals == (first.motor.is_some() && own.name.ends_with("_voltage"))
                && own.force_range == UNBOUNDED
        };
        let all = core::iter::once(first).chain(others.iter().copied());
        if first.bias.constant != 0.0 || !all.clone().all(is_plain) || !others.iter().all(is_input) {
            return Err(NO_FORM);
        }
        let mut inputs = vec![first_input(first).ok_or(NO_FORM)?];
        let needs_position = first.integral.is_some() || has_rate_limit;
        if needs_position && inputs != ["pos"] {
            return Err(NO_FORM);
        }
        for other in &others {
            let word = other.name.strip_prefix(&first.name).and_then(|end| end.strip_prefix('_'));
            let word = ["vel", "ff", "voltage"].into_iter().find(|known| Some(*known) == word);
            inputs.push(word.ok_or(NO_FORM)?);
        }
        let parts: Vec<(&'static str, &ActuatorDescription)> = inputs.into_iter().zip(all).collect();
        let is_ordered = parts.windows(2).all(|pair| rank(pair[0].0) < rank(pair[1].0));
        let bias = first.bias;
        let fits = |&(word, own): &(&str, &ActuatorDescription)| match word {
            "pos" => own.gain.constant == -bias.length,
            "vel" => own.gain.constant == -bias.velocity,
            "ff" => own.gain.constant == 1.0,
            "none" => others.is_empty(),
            _ => own.gain.constant > 0.0,
        };
        if !is_ordered || !parts.iter().all(fits) {
            return Err(NO_FORM);
        }
        let is_motor = first.cogging.is_some()
            || first.motor.is_some()
            || parts.iter().any(|(word, _)| *word == "voltage");
        if is_motor { Self::motor(first, &parts).map(Some) } else { Self::pid(first, &parts).map(Some) }
    }

    fn pid(
        first: &ActuatorDescription,
        parts: &[(&'static str, &ActuatorDescription)],
    ) -> Result<Self, &'static str> {
        let Affine { length, velocity, .. } = first.bias;
        if velocity > 0.0 {
            return Err("MJCF reads the negative damping of a servo as a damping ratio");
        }
        let range = |word: &str| match word {
            "pos" => "ctrlrange",
            "vel" => "velrange",
            _ => "ffrange",
        };
        let mut ranges: Vec<_> = parts.iter().map(|(word, own)| (range(word), own.control_range)).collect();
        ranges.push(("forcerange", first.force_range));
        let mut numbers = vec![("kp", vec![0.0 - length]), ("kv", vec![0.0 - velocity])];
        if let Some(IntegralAction { gain, limit }) = first.integral {
            numbers.push(("ki", vec![gain]));
            numbers.push(("imax", vec![or_zero(limit)]));
        }
        if let Activation::RateLimit { rate } = first.activation {
            numbers.push(("slewmax", vec![rate]));
        }
        Ok(Self { element: "pid", inputs: words(parts), ranges, numbers })
    }

    /// The voltage has the gain K/R. Without other inputs the damping is K²/R; with them, R is any number.
    fn motor(
        first: &ActuatorDescription,
        parts: &[(&'static str, &ActuatorDescription)],
    ) -> Result<Self, &'static str> {
        let Affine { length, velocity, .. } = first.bias;
        let of_voltage = parts.iter().find(|(word, _)| *word == "voltage").map(|(_, own)| own.gain.constant);
        let is_controlled = parts.iter().any(|(word, _)| !["voltage", "none"].contains(word));
        let [lower, upper] = first.force_range;
        if lower != -upper || parts.iter().any(|(_, own)| own.control_range != first.control_range) {
            return Err("a <dcmotor> has one range of its inputs, and a force with opposite bounds");
        }
        if first.motor.is_some_and(|motor| motor.current_limit.is_finite()) {
            return Err("a <dcmotor> has no limit of the current that its controller requests");
        }
        let (constant, resistance) = match of_voltage {
            _ if first.motor.is_some() => {
                first.motor.map_or((1.0, 1.0), |motor| (motor.constant, motor.resistance))
            }
            Some(gain) if !is_controlled && velocity < 0.0 && length == 0.0 => {
                (-velocity / gain, -velocity / gain / gain)
            }
            Some(gain) if is_controlled => (gain, 1.0),
            None => (1.0, 1.0),
            Some(_) => return Err(NO_FORM),
        };
        if of_voltage.is_some_and(|gain| (gain * resistance - constant).abs() > 1e-12 * constant) {
            return Err(NO_FORM);
        }
        let mut numbers = vec![("motorconst", vec![constant]), ("resistance", vec![resistance])];
        if is_controlled {
            let IntegralAction { gain, limit } =
                first.integral.unwrap_or(IntegralAction { gain: 0.0, limit: f64::INFINITY });
            let rate = if let Activation::RateLimit { rate } = first.activation { rate } else { 0.0 };
            let voltage = first.motor.map_or(0.0, |motor| or_zero(motor.voltage_limit));
            let gains = vec![0.0 - length, gain, 0.0 - velocity, rate, or_zero(limit), voltage];
            numbers.push(("controller", gains));
        }
        let rate = first.motor.and_then(|motor| motor.current).map_or(0.0, |own| or_zero(own.rate_limit));
        if upper.is_finite() || rate > 0.0 {
            numbers.push(("saturation", vec![or_zero(upper), 0.0, rate]));
        }
        numbers.extend(first.motor.iter().flat_map(numbers_of));
        if let Some(cogging) = first.cogging {
            numbers.push(("cogging", vec![cogging.amplitude, cogging.poles, cogging.phase]));
        }
        let has_input = parts.iter().any(|(word, _)| *word != "none");
        let ranges = Vec::from_iter(has_input.then_some(("ctrlrange", first.control_range)));
        Ok(Self { element: "dcmotor", inputs: words(parts), ranges, numbers })
    }
}

/// The numbers of a motor with a current, a temperature and friction.
fn numbers_of(motor: &ElectricMotor) -> Vec<(&'static str, Vec<f64>)> {
    let mut numbers = Vec::new();
    if let Some(current) = &motor.current {
        numbers.push(("inductance", vec![0.0, current.time_constant]));
    }
    if let Some(own) = &motor.winding {
        let all = vec![own.resistance, own.capacity, 0.0, own.coefficient, own.reference, own.ambient];
        numbers.push(("thermal", all));
    }
    if let Some(own) = &motor.friction {
        let all = [own.stiffness, own.damping, own.coulomb, own.static_friction, own.stribeck_velocity];
        numbers.push(("lugre", all.to_vec()));
    }
    numbers
}

/// A limit, or 0 in place of infinity.
fn or_zero(limit: f64) -> f64 {
    if limit.is_finite() { limit } else { 0.0 }
}

/// The input with this gain.
fn first_input(first: &ActuatorDescription) -> Option<&'static str> {
    let (gain, Affine { length, velocity, .. }) = (first.gain.constant, first.bias);
    let needs_position = first.integral.is_some() || matches!(first.activation, Activation::RateLimit { .. });
    if first.motor.is_some() && first.at_terminals {
        Some(if gain == 0.0 { "none" } else { "voltage" })
    } else if needs_position || gain == -length && length != 0.0 {
        Some("pos")
    } else if first.cogging.is_some() && length == 0.0 && velocity < 0.0 && gain > 0.0 {
        Some("voltage")
    } else if gain == -velocity && velocity != 0.0 {
        Some("vel")
    } else {
        (gain == 1.0).then_some("ff")
    }
}

fn rank(word: &str) -> Option<usize> {
    ["none", "pos", "vel", "ff", "voltage"].into_iter().position(|known| known == word)
}

fn words(parts: &[(&'static str, &ActuatorDescription)]) -> String {
    parts.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(" ")
}
