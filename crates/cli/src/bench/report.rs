//! The results as tables.

use robot_dynamics::quantity::Quantity;
use robot_dynamics::text::one_line;

use super::batch::Work;
use super::entry::{Entry, Precision, SCALING_WORK, Task, Time};
use super::machine::IS_DEBUG;
use super::results::Results;
use super::{batch, single_states};
use crate::table::{Table, count};

/// Three significant digits, with spaces between thousands: 25.3, 190, 12 300.
fn three(x: f64) -> String {
    let decimals = match x {
        x if x < 9.995 => 2,
        x if x < 99.95 => 1,
        _ => 0,
    };
    if decimals > 0 {
        return format!("{x:.decimals$}");
    }
    let mut scale = 1.0;
    while x / scale >= 999.5 {
        scale *= 10.0;
    }
    let digits = format!("{:.0}", (x / scale).round() * scale);
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

fn percent(fraction: f64) -> String {
    format!("{:.0} %", 100.0 * fraction)
}

/// The time and its spread, or a mark for a missing time.
fn cells(entry: Option<&Entry>) -> [String; 2] {
    match entry.map(|entry| (entry.time(), &entry.trouble)) {
        // The range of one round is zero and says nothing.
        Some((Some(time), None)) if time.rounds == 1 => [three(time.median), String::new()],
        Some((Some(time), None)) => [three(time.median), percent(time.spread())],
        Some((_, Some(_))) => ["none".into(), String::new()],
        _ => ["-".into(), String::new()],
    }
}

impl Results<'_> {
    fn entry(&self, what: Task) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.what == what)
    }

    fn time(&self, what: Task) -> Option<Time> {
        self.entry(what).filter(|entry| entry.trouble.is_none()).and_then(Entry::time)
    }

    /// The largest number of threads.
    fn all(&self) -> usize {
        self.threads.last().copied().unwrap_or(1)
    }

    fn head(&self) -> String {
        let Self { model, file, machine, states, seed, rounds, .. } = self;
        let slow = if IS_DEBUG { " (slower than a release build)" } else { "" };
        let mut head = Table::new(&["", ""]);
        let runs = count(machine.threads, "thread");
        head.row(["machine".into(), format!("{}, {runs}, {}", machine.processor, machine.system)]);
        let build = format!("version {}, {} build{slow}", machine.version, machine.build);
        head.row(["program".into(), build]);
        head.row(["one state".into(), format!("on {}", machine.single_instructions)]);
        if machine.lanes_f64 > 0 {
            let lanes = format!("{} lanes of f64, {} of f32", machine.lanes_f64, machine.lanes_f32);
            head.row(["batches".into(), format!("on {}, {lanes}", machine.batch_instructions)]);
        }
        head.row(["native".into(), model.native().summary()]);
        let times = format!("{states} at random, seed {seed}; medians of {}", count(*rounds, "round"));
        head.row(["states".into(), format!("{times}; ± is half their range")]);
        if let Some(load) = machine.load_before {
            head.row(["load".into(), format!("{load:.1} busy threads in the minute before")]);
        }
        head.row(["tip".into(), self.tip.clone()]);
        let text = head.text();
        // The head of this table is empty.
        let rows = text.split_once('\n').map_or("", |(_, rows)| rows);
        let degrees = if model.nv() == 1 { "degree of freedom" } else { "degrees of freedom" };
        let robot = format!("{} ({file}): {} {degrees}", model.name(), model.nv());
        format!("{}\n{rows}", one_line(&robot))
    }

    fn singles(&self) -> String {
        let mut table = Table::new(&["one state at a time, one thread", ">ns", ">±", ">states/s"]);
        for quantity in single_states::QUANTITIES {
            let what = Task::Single(quantity);
            let [ns, spread] = cells(self.entry(what));
            let rate = self.time(what).map_or_else(String::new, |time| three(time.per_second()));
            table.row([quantity.title().into(), ns, spread, rate]);
        }
        table.text()
    }

    /// Rows of one kind of work, on one thread and on all threads.
    fn work(&self, title: &str, unit: &str, rows: &[(&str, Work, Option<Quantity>)]) -> String {
        let (one, all) = (1, self.all());
        let on_all = if all == 1 { String::new() } else { format!(">ns, {all} threads") };
        let rate = format!(">million {unit}/s");
        let gain = if rows.iter().any(|row| row.2.is_some()) { ">gain" } else { "" };
        let mut head = vec![title, "", ">ns, 1 thread", ">±"];
        if all > 1 {
            head.extend([on_all.as_str(), ">±"]);
        }
        head.extend([rate.as_str(), gain]);
        let mut table = Table::new(&head);
        for &(name, work, alone) in rows {
            for precision in Precision::ALL {
                let what = |threads| Task::Batch { work, precision, threads };
                let mut row = vec![name.to_owned(), precision.key().into()];
                row.extend(cells(self.entry(what(one))));
                if all > 1 {
                    row.extend(cells(self.entry(what(all))));
                }
                let rate = self.time(what(all)).map(|time| three(time.per_second() / 1e6));
                let alone = alone.and_then(|quantity| self.time(Task::Single(quantity)));
                let gain = alone.zip(self.time(what(one))).map(|(alone, batch)| alone.median / batch.median);
                row.push(rate.unwrap_or_default());
                row.push(gain.map_or_else(String::new, |gain| format!("{gain:.1} ×")));
                table.row(row);
            }
        }
        table.text()
    }

    fn scaling(&self) -> String {
        let mut table = Table::new(&[
            "forward dynamics of a batch, f64",
            ">million states/s",
            ">±",
            ">speed-up",
            ">per thread",
        ]);
        let what = |threads| Task::Batch { work: SCALING_WORK, precision: Precision::Double, threads };
        let alone = self.time(what(1));
        for &threads in &self.threads {
            let mut row = vec![count(threads, "thread")];
            match self.time(what(threads)).zip(alone) {
                Some((time, alone)) => {
                    let gain = alone.median / time.median;
                    row.extend([three(time.per_second() / 1e6), percent(time.spread())]);
                    row.extend([format!("{gain:.2}"), percent(gain / threads as f64)]);
                }
                None => row.extend(["-".into(), String::new(), String::new(), String::new()]),
            }
            table.row(row);
        }
        table.text()
    }

    /// The reasons for missing results, one for each quantity.
    fn troubles(&self) -> String {
        let mut told = Vec::new();
        let mut text = String::new();
        for entry in &self.entries {
            let name = match entry.what {
                Task::Single(quantity) => quantity.title().to_owned(),
                Task::Batch { work, precision, .. } => {
                    let name = match work {
                        Work::Compute(quantity) => quantity.title(),
                        Work::Rollout(integrator) => integrator.name(),
                    };
                    format!("{name} of {}", precision.key())
                }
            };
            if let Some(trouble) = &entry.trouble
                && !told.contains(&name)
            {
                text.extend(["\nnone: ", name.as_str(), ": ", trouble.as_str(), "\n"]);
                told.push(name);
            }
        }
        text
    }
}

pub(super) fn text(results: &Results<'_>) -> String {
    let compute: Vec<_> = batch::QUANTITIES
        .into_iter()
        .map(|quantity| (quantity.title(), Work::Compute(quantity), Some(quantity)))
        .collect();
    let rollouts: Vec<_> = batch::ROLLOUTS
        .into_iter()
        .map(|integrator| (integrator.name(), Work::Rollout(integrator), None))
        .collect();
    if compute.is_empty() {
        let note = "batches: not in this build; use cargo run --release --features batch -- bench\n";
        return [results.head(), results.singles(), note.into()].join("\n") + &results.troubles();
    }
    let gain = "gain: time of one state at a time over time in a batch, both on one thread";
    let parts = [
        results.head(),
        results.singles(),
        results.work("per state of a batch", "states", &compute) + "  " + gain + "\n",
        results.work("per step of a rollout", "steps", &rollouts),
        results.scaling(),
    ];
    parts.join("\n") + &results.troubles()
}

#[cfg(test)]
mod tests {
    use super::three;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0714, "0.07"),
            (1.5, "1.50"),
            (9.996, "10.0"),
            (25.34, "25.3"),
            (99.96, "100"),
            (189.6, "190"),
            (1234.0, "1 230"),
            (12345.0, "12 300"),
            (9999.0, "10 000"),
            (1_234_567.0, "1 230 000"),
        ];
        for (x, shown) in cases {
            assert_eq!(three(x), shown);
        }
    }
}
