//! The summary of a run.

use std::fmt::Write;

use robot_dynamics::contact::ContactLaws;
use robot_dynamics::model::{Model, difference};
use robot_dynamics::simulation::{AdaptiveMethod, AdaptiveRecord, Effect, Method, Run};
use robot_dynamics::text::one_line;

use super::arguments::Arguments;
use super::files::WrittenFiles;
use super::ground::touching_links;
use super::hold::{Hold, driven};
use super::plan::RunPlan;
use super::recorder::Recorder;
use super::run::RunResult;
use crate::columns;
use crate::table::count;
use crate::table::{Table, short};

/// The data of a summary.
pub(crate) struct Summary<'a> {
    pub arguments: &'a Arguments,
    pub model: &'a Model,
    pub plan: &'a RunPlan,
    pub hold: Option<&'a Hold<'a>>,
    pub ran: &'a RunResult,
    pub recorder: &'a Recorder,
    /// Wall-clock time of the run \[s\].
    pub seconds: f64,
    pub written: &'a WrittenFiles,
}

/// Largest number of lines on limits that were reached.
const MAX_LIMITS: usize = 12;

/// Number of rows of the table over time.
const ROWS: usize = 6;

impl Summary<'_> {
    pub(crate) fn text(&self) -> String {
        let mut text = self.head();
        text += &self.energies();
        text += &self.joints();
        text += &self.limits_reached();
        if self.hold.is_some() {
            text += &self.torques();
        }
        if let Some(floor) = &self.plan.floor {
            text += &floor.report(self.model, &self.ran.run);
        }
        text += &self.ran.run.contact_laws.map_or_else(String::new, |laws| exhausted_substeps(&laws));
        text += &self.foot();
        text
    }

    fn conserves(&self) -> bool {
        self.hold.is_none() && self.plan.setup.conserves()
    }

    fn head(&self) -> String {
        let Self { arguments, model, .. } = self;
        let freedom = if model.nv() == 1 { "degree of freedom" } else { "degrees of freedom" };
        let mut text = format!(
            "{} ({}): {} {freedom}, {} kg\n",
            one_line(model.name()),
            one_line(&arguments.robot.shown().to_string()),
            model.nv(),
            short(model.mass())
        );
        let _ = writeln!(text, "  start   {}", one_line(&self.plan.start.chosen));
        let motors = match self.hold {
            Some(hold) => {
                let goal = if arguments.goal.is_empty() { "the initial pose" } else { "the goal" };
                let limits = model.coordinate_limits();
                let mut motors =
                    format!("motors hold {goal}: τ = g(q*) + Kp (q* − q) − Kd v, {}", hold.described);
                if limits.iter().any(|limits| limits.effort.is_finite()) {
                    motors += ", within the effort limits";
                }
                if driven(model).contains(&false) {
                    let falls = if self.plan.floor.is_some() { "" } else { " and falls" };
                    let _ = write!(motors, "; the floating base has no motors{falls}");
                }
                motors
            }
            None => self
                .plan
                .drive
                .as_ref()
                .map_or_else(|| "passive, no motor torque".into(), |drive| drive.described.clone()),
        };
        let _ = writeln!(text, "  forces  {}; {}", one_line(&motors), self.passive_forces());
        if let Some(loops) = &self.plan.loops {
            let names: Vec<&str> = loops.constraints().map(|(name, _)| name).collect();
            let _ = writeln!(text, "  loops   {}, closed in each step", one_line(&names.join(", ")));
        }
        if let Some(floor) = &self.plan.floor {
            let _ = writeln!(text, "  ground  {}", floor.described);
        }
        if let Some(links) = touching_links(&self.plan.setup) {
            let _ = writeln!(text, "  links   {links}");
        }
        let reason = if self.plan.setup.reason.is_empty() {
            String::new()
        } else {
            format!(": {}", one_line(&self.plan.setup.reason))
        };
        let _ = writeln!(text, "  method  {}{reason}", self.method());
        for (k, line) in self.plan.setup.left_out_lines().iter().enumerate() {
            let _ = writeln!(text, "  {:<7} {}", if k == 0 { "without" } else { "" }, one_line(line));
        }
        text
    }

    /// The effects besides motors and actuators.
    fn passive_forces(&self) -> String {
        if self.arguments.conservative {
            return "no damping, friction, limits, actuators or contact".into();
        }
        let robot = self.model.description();
        let has_fluid = robot.medium.acts() && !robot.fluid_shapes.is_empty();
        let losses =
            if has_fluid { "with damping, friction and a fluid" } else { "with damping and friction" };
        let words = [
            (Effect::Dissipation, losses),
            (Effect::Springs, "with springs and gravity compensation"),
            (Effect::Limits, "with position limits"),
        ];
        let acting: Vec<&str> = words
            .into_iter()
            .filter(|(effect, _)| self.plan.setup.acts(*effect))
            .map(|(_, words)| words)
            .collect();
        if acting.is_empty() { "no damping, friction or limits".into() } else { acting.join("; ") }
    }

    /// The integrator and its steps.
    fn method(&self) -> String {
        let (integrator, step, end) = (self.plan.setup.method(), self.arguments.dt, short(self.ran.run.time));
        let Some(AdaptiveRecord { method, statistics, quaternion_error, .. }) = &self.ran.adaptive else {
            return format!("{integrator}, {} of {step} s, {end} s", count(self.ran.run.steps, "step"));
        };
        let tolerance = self.arguments.adaptive_tolerance();
        let kind = if *method == AdaptiveMethod::Implicit { "implicit since damping is stiff, " } else { "" };
        let mut text = format!(
            "{integrator}, {kind}order {}, tolerance {tolerance:e}: {} of {} to {} s, {} rejected, {} evaluations, {end} s",
            method.order(),
            count(statistics.accepted, "step"),
            short(statistics.shortest),
            short(statistics.longest),
            statistics.rejected,
            statistics.evaluations
        );
        if self.model.nq() > self.model.nv() {
            let _ = write!(
                text,
                "; normalisation of quaternions corrected their length by up to {quaternion_error:.0e}"
            );
        }
        text
    }

    /// Energies over time, and the energy drift.
    fn energies(&self) -> String {
        let (energy_account, samples) = (&self.ran.run.energy_account, &self.recorder.samples);
        let error = if self.conserves() { ">E − E0 [J]" } else { ">residual [J]" };
        let mut table = Table::new(&[">t [s]", ">K [J]", ">V [J]", ">E [J]", error]);
        let last = samples.len().saturating_sub(1);
        let mut shown: Vec<usize> = (0..ROWS).map(|row| row * last / (ROWS - 1)).collect();
        shown.dedup();
        for sample in shown.into_iter().filter_map(|index| samples.get(index)) {
            table.row([
                short(sample.time),
                joule(sample.kinetic),
                joule(sample.potential),
                joule(sample.kinetic + sample.potential),
                if sample.error.is_finite() { format!("{:.1e}", sample.error) } else { "-".into() },
            ]);
        }
        let mut text = format!("\n{}", table.text());
        if samples.len() < 2 {
            text += "  no step was taken\n";
            return text;
        }
        let (scale, divisor) = self.recorder.energy_scale(energy_account, self.ran.failure.is_some());
        let relative = match energy_account.max_imbalance() {
            _ if !energy_account.start().is_finite() => f64::NAN,
            0.0 => 0.0,
            most => most / scale,
        };
        if self.conserves() {
            let _ = writeln!(text, "  energy drift, max |E − E0| / {divisor}: {relative:.2e}");
        } else {
            let losses = match self.ran.run.losses {
                Some(losses) => {
                    let mut text = format!(
                        "losses: damping {} J, friction {} J, stops {} J",
                        short(losses.damping),
                        short(losses.friction),
                        short(losses.stops)
                    );
                    if self.plan.floor.is_some() {
                        let (sliding, impacts) = (short(losses.sliding), short(losses.impacts));
                        let _ = write!(text, ", sliding {sliding} J, impacts {impacts} J");
                    }
                    if losses.corrections != 0.0 {
                        let corrections = short(losses.corrections);
                        let _ = write!(text, ", correction of initial penetration {corrections} J");
                    }
                    text
                }
                None => format!("losses: damping and friction {} J", short(energy_account.dissipated())),
            };
            let _ = writeln!(
                text,
                "  work of motors {} J; {losses}; residual, max |E − E0 − in + out| \
                 / {divisor}: {relative:.2e}",
                short(energy_account.work()),
            );
        }
        if relative > 1e-2 {
            let finer = match self.plan.setup.method() {
                Method::Adaptive => "--tolerance",
                _ => "--dt",
            };
            let _ = writeln!(text, "  the integrator's error dominates the motion: use a smaller {finer}");
        }
        text
    }

    /// The start, end and range of each entry of q, and its limits.
    fn joints(&self) -> String {
        let Self { model, ran: RunResult { run, .. }, recorder, .. } = self;
        let mut table = Table::new(&[
            "joint", "unit", ">start", ">end", ">min", ">max", ">lower", ">upper", ">speed", ">limit", "",
        ]);
        let names = columns::configuration(model);
        let (mut leaves, mut races) = (0, 0);
        for joint in model.joints() {
            for k in 0..joint.nq {
                let (i, is_plain) = (joint.q_index + k, joint.nq == joint.nv);
                let (column, extremes, limits) = (&names[i], &recorder.extremes[i], &joint.limits);
                let [lower, upper] = if is_plain { [limits.lower, limits.upper] } else { [f64::INFINITY; 2] };
                let mut speed = [String::from("-"), String::from("-")];
                let mut remarks = Vec::new();
                if let Some(time) = extremes.left_limits {
                    leaves += 1;
                    remarks.push(format!("outside its limits at {} s", short(time)));
                }
                if is_plain {
                    let peak = recorder.peak_speed[joint.v_index + k];
                    speed = [peak, limits.velocity].map(short);
                    if peak > limits.velocity {
                        races += 1;
                        remarks.push("above its speed limit".into());
                    }
                }
                table.row(
                    [column.name.clone(), column.unit.into()]
                        .into_iter()
                        .chain([self.plan.start.q[i], run.q[i], extremes.least, extremes.most].map(short))
                        .chain([lower, upper].map(short))
                        .chain(speed)
                        .chain([remarks.join(", ")]),
                );
            }
        }
        let mut text = format!("\n{}", table.text());
        if self.plan.setup.acts(Effect::Limits) {
            let _ = writeln!(
                text,
                "  {} exceeded the speed limit, which is not enforced; position limits are stops",
                count(races, "coordinate")
            );
        } else if leaves + races > 0 {
            let _ = writeln!(
                text,
                "  {} left the position limits, {} exceeded the speed limit (limits are not enforced)",
                count(leaves, "coordinate"),
                races
            );
        } else {
            text += "  no joint left its limits (limits are not enforced)\n";
        }
        text
    }

    /// The times when joints reached their limits.
    fn limits_reached(&self) -> String {
        let Run { events, ended_by_event, .. } = &self.ran.run;
        let mut text = String::new();
        for event in events.iter().take(MAX_LIMITS) {
            let _ = writeln!(text, "  {} at {:.9} s", one_line(&event.name), event.time);
        }
        if events.len() > MAX_LIMITS {
            let _ = writeln!(text, "  and {} more", events.len() - MAX_LIMITS);
        }
        if *ended_by_event {
            text += "  the run ended there (--stop-at-limits)\n";
        }
        text
    }

    /// The motors' peak torques and limits.
    fn torques(&self) -> String {
        let Self { model, ran: RunResult { run, .. }, hold, .. } = self;
        let Some(hold) = hold else { return String::new() };
        let mut table = Table::new(&["motor", "unit", ">peak", ">demand", ">limit", ">used", ""]);
        let (limits, is_driven) = (model.coordinate_limits(), driven(model));
        for (k, column) in columns::effort(model).into_iter().enumerate().filter(|(k, _)| is_driven[*k]) {
            let (peak, demand, limit) =
                (run.peak_torque[k], hold.controller.peak_demand()[k], limits[k].effort);
            // The share of an infinite limit, or of a limit of 0, is undefined.
            let has_share = limit.is_finite() && limit > 0.0;
            let used = if has_share { format!("{:.0} %", 100.0 * peak / limit) } else { "-".into() };
            let remark = match (hold.overloaded.contains(&k), demand > limit) {
                _ if limit == 0.0 => "no motor: the effort limit is 0",
                (true, _) => "cannot carry the weight at the goal",
                (_, true) => "at its limit",
                _ => "",
            };
            table.row([
                column.name,
                column.unit.into(),
                short(peak),
                short(demand),
                short(limit),
                used,
                remark.into(),
            ]);
        }
        let mut left = vec![0.0; model.nv()];
        difference(model, &run.q, &self.plan.goal, &mut left);
        let left = left.iter().zip(&is_driven).filter(|(_, driven)| **driven).map(|(x, _)| x.abs());
        let left = left.fold(0.0, f64::max);
        format!(
            "\n{}  largest distance of a motor from its goal at the end: {} rad or m\n",
            table.text(),
            short(left)
        )
    }

    fn foot(&self) -> String {
        let Self { ran: RunResult { run, .. }, seconds, .. } = self;
        let mut text = format!(
            "\n  {} s of wall time, {} steps/s\n",
            short(*seconds),
            (run.steps as f64 / seconds).round()
        );
        for (path, what) in &self.written.files {
            let _ = writeln!(text, "  wrote {} ({what})", one_line(&path.display().to_string()));
        }
        text
    }
}

/// Steps that used up their budget of substeps, with the energy error that they left.
fn exhausted_substeps(laws: &ContactLaws) -> String {
    if laws.unsettled == 0 {
        return String::new();
    }
    let (verb, steps) = (if laws.unsettled == 1 { "was" } else { "were" }, count(laws.unsettled, "step"));
    format!(
        "\n  {steps} {verb} divided until the budget of substeps was used up, with an energy error of up to {} J in a step; \
         a shorter --dt needs fewer substeps\n",
        short(laws.imbalance)
    )
}

/// An energy with microjoules, since drift shows in the last digits. Large energies have an exponent, and `-`
/// stands for values that are not finite.
fn joule(x: f64) -> String {
    if !x.is_finite() {
        return "-".into();
    }
    if x.abs() < 1e9 { format!("{x:.6}") } else { format!("{x:.6e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_budget_are_reported_with_their_energy_error() {
        let mut laws = ContactLaws::default();
        assert_eq!(exhausted_substeps(&laws), "");
        (laws.unsettled, laws.imbalance) = (3, 0.25);
        let said = exhausted_substeps(&laws);
        assert!(said.contains("3 steps") && said.contains("0.25 J"), "{said}");
    }
}
