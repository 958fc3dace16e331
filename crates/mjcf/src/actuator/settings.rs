//! The numbers of an actuator element: the shortcuts of MJCF, and `<general>`.

use core::f64::consts::PI;

use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Id;

/// The attributes of `<muscle>` for the third and further numbers of its gain.
const MUSCLE_CURVES: [&str; 7] = ["force", "scale", "lmin", "lmax", "vmax", "fpmax", "fvmax"];

/// The numbers of an actuator in MJCF.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) gain_kind: String,
    pub(super) gain: [f64; 10],
    pub(super) bias_kind: String,
    pub(super) bias: [f64; 10],
    pub(super) dynamics: String,
    pub(super) dynamics_numbers: [f64; 10],
    pub(super) inherit_range: f64,
    /// Set for a damper and for adhesion, whose control is not negative.
    pub(super) control_is_limited: bool,
    /// The words of `input`.
    pub(super) inputs: Option<String>,
    /// The bound of a motor's torque that `saturation` gives.
    pub(super) saturation: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        let mut first = [0.0; 10];
        first[0] = 1.0;
        Self {
            gain_kind: "fixed".into(),
            gain: first,
            bias_kind: "none".into(),
            bias: [0.0; 10],
            dynamics: "none".into(),
            dynamics_numbers: first,
            inherit_range: 0.0,
            control_is_limited: false,
            inputs: None,
            saturation: None,
        }
    }
}

impl Reader<'_> {
    /// The numbers of the actuator over the defaults of its class; `None` for a kind that is not supported.
    pub(super) fn settings(&mut self, element: &Element) -> Option<Settings> {
        let mut settings = Settings::default();
        let nodes: Vec<Id> = element.defaults.iter().copied().chain([element.node]).collect();
        for node in nodes {
            let one = self.raw_element(node);
            let name = self.tree.nodes[node].name.as_str();
            if !self.set(&one, name, &mut settings) && node == element.node {
                return None; // reported by `list_unread`
            }
        }
        Some(settings)
    }

    /// Sets the numbers of one element; `false` for a kind that is not supported.
    fn set(&mut self, one: &Element, kind: &str, settings: &mut Settings) -> bool {
        settings.begin(kind);
        if let Some(words) = self.text(one, "input") {
            settings.inputs = Some(words.split_whitespace().collect::<Vec<_>>().join(" "));
        }
        match kind {
            "general" | "actuator" => {
                for (attribute, text) in [
                    ("gaintype", &mut settings.gain_kind),
                    ("biastype", &mut settings.bias_kind),
                    ("dyntype", &mut settings.dynamics),
                ] {
                    if let Some(word) = self.text(one, attribute) {
                        word.trim().clone_into(text);
                    }
                }
                settings.gain = self.overlay(one, "gainprm", settings.gain);
                settings.bias = self.overlay(one, "biasprm", settings.bias);
                settings.dynamics_numbers = self.overlay(one, "dynprm", settings.dynamics_numbers);
            }
            "motor" => {
                settings.gain[0] = 1.0;
                settings.kinds("fixed", "none", "none");
            }
            "position" | "intvelocity" => {
                let stiffness = self.number(one, "kp").unwrap_or(settings.gain[0]);
                (settings.gain[0], settings.bias[1]) = (stiffness, -stiffness);
                if let Some(damping) = self.magnitude(one, "kv") {
                    settings.bias[2] = -damping;
                }
                if let Some(ratio) = self.magnitude(one, "dampratio") {
                    settings.bias[2] = ratio;
                }
                if let Some(time) = self.magnitude(one, "timeconst") {
                    settings.dynamics_numbers[0] = time;
                    settings.dynamics = if time == 0.0 { "none" } else { "filterexact" }.into();
                }
                settings.inherit_range = self.number(one, "inheritrange").unwrap_or(settings.inherit_range);
                let dynamics =
                    if kind == "position" { settings.dynamics.clone() } else { "integrator".into() };
                settings.kinds("fixed", "affine", &dynamics);
            }
            "velocity" => {
                let damping = self.number(one, "kv").unwrap_or(settings.gain[0]);
                settings.bias = [0.0; 10];
                (settings.gain[0], settings.bias[2]) = (damping, -damping);
                settings.kinds("fixed", "affine", "none");
            }
            "damper" => {
                let inherited = if settings.gain_kind == "affine" { -settings.gain[2] } else { 0.0 };
                let damping = self.magnitude(one, "kv").unwrap_or(inherited);
                settings.gain = [0.0; 10];
                settings.gain[2] = -damping;
                settings.control_is_limited = true;
                settings.kinds("affine", "none", "none");
            }
            "cylinder" => {
                settings.dynamics_numbers[0] =
                    self.number(one, "timeconst").unwrap_or(settings.dynamics_numbers[0]);
                let [a, b, c] = self.numbers::<3>(one, "bias").unwrap_or([
                    settings.bias[0],
                    settings.bias[1],
                    settings.bias[2],
                ]);
                settings.bias[..3].copy_from_slice(&[a, b, c]);
                settings.gain[0] = self.number(one, "area").unwrap_or(settings.gain[0]);
                if let Some(diameter) = self.magnitude(one, "diameter") {
                    settings.gain[0] = PI / 4.0 * diameter * diameter;
                }
                settings.kinds("fixed", "affine", "filter");
            }
            "pid" => self.set_pid(one, settings),
            "dcmotor" => self.set_motor(one, settings),
            "orientation" => settings.kinds("so3", "so3", "none"),
            "adhesion" => {
                settings.gain[0] = self.number(one, "gain").unwrap_or(settings.gain[0]);
                settings.control_is_limited = true;
                settings.kinds("fixed", "none", "none");
            }
            "muscle" => self.set_muscle(one, settings),
            _ => return false,
        }
        true
    }

    /// The numbers of `<pid>`.
    fn set_pid(&mut self, one: &Element, settings: &mut Settings) {
        settings.bias[1] = -self.number(one, "kp").unwrap_or(-settings.bias[1]);
        if let Some(damping) = self.magnitude(one, "kv") {
            settings.bias[2] = -damping;
        }
        if let Some(ratio) = self.magnitude(one, "dampratio") {
            settings.bias[2] = ratio;
        }
        settings.gain[0] = self.number(one, "ki").unwrap_or(settings.gain[0]);
        if let Some(limit) = self.number(one, "imax") {
            settings.dynamics_numbers[0] = limit;
        }
        let slew = self.magnitude(one, "slewmax").unwrap_or(settings.dynamics_numbers[1]);
        settings.dynamics_numbers[1] = slew;
        settings.inherit_range = self.number(one, "inheritrange").unwrap_or(settings.inherit_range);
        let has_state = settings.gain[0] != 0.0 || settings.dynamics_numbers[1] != 0.0;
        settings.kinds("pid", "affine", if has_state { "pid" } else { "none" });
    }

    /// The numbers of `<dcmotor>`, in the order of MuJoCo. The gain has R, K, α, the reference temperature,
    /// and the gains and the voltage of the controller. The dynamics have the time constant and the rate of
    /// the current, the thermal resistance, capacity and ambient temperature, σ₀, σ₁, and the rate and the
    /// integral of the controller. The bias has the cogging and the three other numbers of the friction.
    fn set_motor(&mut self, one: &Element, settings: &mut Settings) {
        let Settings { gain, bias, dynamics_numbers: dynamics, .. } = settings;
        let [torque_constant, back_emf] = self.overlay(one, "motorconst", [gain[1], 0.0]);
        let mut resistance = self.number(one, "resistance").unwrap_or(gain[0]);
        let [voltage, stall, speed] = self.overlay(one, "nominal", [0.0; 3]);
        let back_emf = if voltage > 0.0 && back_emf <= 0.0 && speed > 0.0 {
            let [viscous, ..] = self.overlay(one, "damping", [0.0; 3]);
            back_emf_at_no_load([voltage, stall, speed], viscous, resistance)
        } else {
            back_emf
        };
        let constant = match (torque_constant > 0.0, back_emf > 0.0) {
            (true, true) => (torque_constant * back_emf).sqrt(),
            (true, false) => torque_constant,
            _ => back_emf,
        };
        if resistance == 0.0 && voltage > 0.0 && stall > 0.0 {
            resistance = constant * voltage / stall;
        }
        (gain[0], gain[1]) = (resistance, constant);
        let controller = [gain[4], gain[5], gain[6], dynamics[7], dynamics[8], gain[7]];
        let controller = self.overlay(one, "controller", controller);
        [gain[4], gain[5], gain[6], dynamics[7], dynamics[8], gain[7]] = controller;
        let cogging = self.overlay(one, "cogging", [bias[0], bias[1], bias[2]]);
        bias[..3].copy_from_slice(&cogging);
        let [inductance, time] = self.overlay(one, "inductance", [0.0, dynamics[0]]);
        dynamics[0] = if inductance > 0.0 { inductance / resistance } else { time };
        let thermal = [dynamics[2], dynamics[3], 0.0, gain[2], gain[3], dynamics[4]];
        let [mut warm, mut capacity, time, coefficient, reference, ambient] =
            self.overlay(one, "thermal", thermal);
        if time > 0.0 && warm > 0.0 && capacity == 0.0 {
            capacity = time / warm;
        } else if time > 0.0 && capacity > 0.0 && warm == 0.0 {
            warm = time / capacity;
        }
        [dynamics[2], dynamics[3], gain[2], gain[3], dynamics[4]] =
            [warm, capacity, coefficient, reference, ambient];
        let lugre = self.overlay(one, "lugre", [dynamics[5], dynamics[6], bias[3], bias[4], bias[5]]);
        [dynamics[5], dynamics[6], bias[3], bias[4], bias[5]] = lugre;
        dynamics[1] = self.overlay(one, "saturation", [0.0, 0.0, dynamics[1]])[2];
        if let Some([torque, current, _]) =
            self.text(one, "saturation").is_some().then(|| self.overlay(one, "saturation", [0.0; 3]))
        {
            let most = if torque > 0.0 { torque } else { constant * current };
            settings.saturation = Some(if most > 0.0 { most } else { f64::INFINITY });
        }
        settings.kinds("dcmotor", "dcmotor", "dcmotor");
    }

    /// The numbers of `<muscle>`. Numbers of the class that are still those of other actuators get a muscle's
    /// defaults.
    fn set_muscle(&mut self, one: &Element, settings: &mut Settings) {
        const GAIN: [(f64, f64); 9] = [
            (1.0, 0.75),
            (0.0, 1.05),
            (0.0, -1.0),
            (0.0, 200.0),
            (0.0, 0.5),
            (0.0, 1.6),
            (0.0, 1.5),
            (0.0, 1.3),
            (0.0, 1.2),
        ];
        let Settings { gain, bias, dynamics_numbers, .. } = settings;
        for (number, (general, muscle)) in gain.iter_mut().zip(GAIN) {
            if *number == general {
                *number = muscle;
            }
        }
        for (number, (general, muscle)) in dynamics_numbers.iter_mut().zip([(1.0, 0.01), (0.0, 0.04)]) {
            if *number == general {
                *number = muscle;
            }
        }
        // A negative number stands for a missing one.
        let set = |number: &mut f64, value: Option<f64>| {
            if let Some(value) = value.filter(|&value| value >= 0.0 || value.is_nan()) {
                *number = value;
            }
        };
        let [rise, fall, width, ..] = dynamics_numbers;
        let [a, b] = self.overlay(one, "timeconst", [-1.0; 2]);
        set(rise, Some(a));
        set(fall, Some(b));
        set(width, self.magnitude(one, "tausmooth"));
        let [lower, upper, curves @ ..] = gain;
        let [a, b] = self.overlay(one, "range", [-1.0; 2]);
        set(lower, Some(a));
        set(upper, Some(b));
        for (number, name) in curves.iter_mut().zip(MUSCLE_CURVES) {
            set(number, self.number(one, name));
        }
        bias[..9].copy_from_slice(&gain[..9]);
        settings.kinds("muscle", "muscle", "muscle");
    }
}

impl Settings {
    /// Resets the numbers that this kind of actuator does not inherit from another kind. The numbers of a
    /// controller have other meanings than those of other actuators.
    fn begin(&mut self, kind: &str) {
        let own = match kind {
            "pid" | "dcmotor" => kind,
            "orientation" => "so3",
            _ => "",
        };
        let is_other = !own.is_empty() || matches!(self.gain_kind.as_str(), "pid" | "dcmotor" | "so3");
        if matches!(kind, "general" | "actuator") || self.gain_kind == own || !is_other {
            return;
        }
        *self = Self { inherit_range: self.inherit_range, ..Self::default() };
        if !own.is_empty() {
            (self.gain, self.bias, self.dynamics_numbers) = Default::default();
            self.bias[1] = if own == "pid" { -1.0 } else { 0.0 };
        }
    }

    fn kinds(&mut self, gain: &str, bias: &str, dynamics: &str) {
        gain.clone_into(&mut self.gain_kind);
        bias.clone_into(&mut self.bias_kind);
        dynamics.clone_into(&mut self.dynamics);
    }
}

/// K = V/ω₀ of a motor without friction. With viscous friction B it is the larger root of
/// K² ω₀ − K V + R B ω₀ = 0, or with R = K V/τ₀ the root that is not zero.
fn back_emf_at_no_load([voltage, stall, speed]: [f64; 3], viscous: f64, resistance: f64) -> f64 {
    let free = voltage / speed;
    if viscous <= 0.0 {
        return free;
    }
    if resistance > 0.0 {
        let square = voltage * voltage - 4.0 * resistance * viscous * speed * speed;
        return if square > 0.0 { (voltage + square.sqrt()) / (2.0 * speed) } else { free };
    }
    let loaded = free - voltage * viscous / stall;
    if stall > 0.0 && loaded > 0.0 { loaded } else { free }
}
