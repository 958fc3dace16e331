//! The tables of the page, between lines `<!-- table NAME -->` and `<!-- end -->`.

use serde_json::Value;

use crate::floor::{JUDGED, least, round};
use crate::panel::shown;
use crate::peers::{Aim, BATCH, PEER, SINGLE};
use crate::records::{Records, Route, Trouble};
use crate::steps::FOLLOWED;

/// The page with tables from the measurements.
pub(crate) fn filled(page: &str, records: &Records) -> Result<String, Trouble> {
    let mut text = String::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        text += line;
        text.push('\n');
        if let Some(name) = line.strip_prefix("<!-- table ").and_then(|rest| rest.strip_suffix(" -->")) {
            text += &table(name, records)?;
            let end = lines.by_ref().find(|line| *line == "<!-- end -->");
            text += end.ok_or_else(|| format!("the table {name} has no end"))?;
            text.push('\n');
        }
    }
    Ok(text)
}

fn table(name: &str, records: &Records) -> Result<String, Trouble> {
    let rows = match name {
        "machine" => machine(records),
        "peers" => beside(records, &SINGLE)?,
        "batches" => beside(records, &BATCH)?,
        "threads" => threads(records)?,
        "steps" => steps(records)?,
        "routes" => routes(records)?,
        "growth" => growth(records)?,
        "operations" => operations(records)?,
        "floor" => floor(records)?,
        "pullbacks" => pullbacks(records)?,
        "generated" => generated(
            records,
            "",
            &["generated C", "generated Rust", "ours", "CppADCodeGen", "CasADi", "pinocchio native"],
        )?,
        "generated lanes" => {
            generated(records, "_batch_f64", &["generated lanes", "ours", "pinocchio native"])?
        }
        other => return Err(format!("the page asks for a table {other:?}").into()),
    };
    let mut lines: Vec<String> = rows.iter().map(|row| format!("| {} |\n", row.join(" | "))).collect();
    // Names are left-aligned, numbers right-aligned.
    let rule = "| --- |".to_owned() + &" ---: |".repeat(rows[0].len() - 1) + "\n";
    lines.insert(1, rule);
    Ok(lines.concat())
}

type Rows = Vec<Vec<String>>;

fn head(cells: &[&str]) -> Rows {
    vec![cells.iter().map(|&cell| cell.to_owned()).collect()]
}

/// Nanoseconds to three digits.
fn ns(x: f64) -> String {
    shown(round(x))
}

fn machine(records: &Records) -> Rows {
    let mut rows = head(&["machine", ""]);
    let scaling = records.machine("scaling");
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    rows.push(vec![
        "processor".into(),
        format!("{}, {} cores", text(&scaling["processor"]), scaling["cores"]),
    ]);
    rows.push(vec!["compiler".into(), text(&scaling["rustc"])]);
    rows.push(vec!["of the peer".into(), text(&records.machine("peers")["clang"])]);
    let peak = |lanes| records.peak(lanes).map_or_else(|_| "?".into(), |ns| format!("{ns:.3}"));
    rows.push(vec![
        "ns per fused multiply-add of 1, 4, 8 numbers".into(),
        format!("{}, {}, {}", peak(1), peak(4), peak(8)),
    ]);
    rows
}

/// This library beside Pinocchio: times, ratios, their geometric mean and the target.
fn beside(records: &Records, aims: &[Aim]) -> Result<Rows, Trouble> {
    let mut rows =
        head(&["", "Panda: ours", "theirs", "ratio", "Talos: ours", "theirs", "ratio", "mean", "aimed at"]);
    for Aim { algorithm, label, aim } in aims {
        let mut row = vec![(*label).to_owned()];
        let mut product = 1.0;
        for robot in ["panda", "talos"] {
            let found = records.ratio(robot, algorithm, PEER)?;
            let [low, high] = found.spread;
            row.extend([ns(found.ours), ns(found.theirs)]);
            row.push(format!("{:.2} ({low:.2} to {high:.2})", found.ratio));
            product *= found.ratio;
        }
        let mean = product.sqrt();
        row.push(format!("{mean:.2}"));
        row.push(aim.map_or_else(
            || "–".into(),
            |aim| {
                let verdict = if mean < aim { "missed" } else { "met" };
                format!("{}, {verdict}", shown(aim))
            },
        ));
        rows.push(row);
    }
    Ok(rows)
}

fn threads(records: &Records) -> Result<Rows, Trouble> {
    let mut rows = head(&["8192 states at once", "Panda", "Talos"]);
    for (algorithm, label, _) in &JUDGED[..2] {
        let mut row = vec![(*label).to_owned()];
        for robot in ["panda", "talos"] {
            let found =
                records.ratio(robot, &format!("{algorithm}_batch_f64_threads"), "ours, one thread")?;
            row.push(format!("{:.2}", found.of_least));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn steps(records: &Records) -> Result<Rows, Trouble> {
    let steps = records.steps();
    let mut first = vec!["ns per state".to_owned()];
    first.extend(steps.iter().map(|(commit, step)| format!("{step} (`{commit}`)")));
    let mut rows = vec![first];
    for (robot, shown) in [("panda", "Panda"), ("talos", "Talos")] {
        for (algorithm, label, _) in FOLLOWED {
            let mut row = vec![format!("{shown}, {label}")];
            for (commit, _) in &steps {
                row.push(ns(records.step_time(robot, algorithm, commit)?));
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The same code by every route.
fn routes(records: &Records) -> Result<Rows, Trouble> {
    let lanes = |number, instructions| Route { number, instructions: Some(instructions), ..Route::DOUBLES };
    let columns = [
        ("one state: portable", Route::PORTABLE),
        ("AVX2", Route::ONE),
        ("batch f64: portable", lanes("f64", "portable")),
        ("AVX2, 4", lanes("f64", "AVX2 and FMA")),
        ("AVX-512, 8", lanes("f64", "AVX-512")),
        ("batch f32: AVX2, 8", lanes("f32", "AVX2 and FMA")),
        ("AVX-512, 16", lanes("f32", "AVX-512")),
    ];
    let mut first = vec!["ns per state".to_owned()];
    first.extend(columns.iter().map(|(label, _)| (*label).to_owned()));
    let mut rows = vec![first];
    for (robot, shown) in [("panda", "Panda"), ("talos", "Talos")] {
        for (algorithm, label, _) in JUDGED {
            let mut row = vec![format!("{shown}, {label}")];
            for (_, route) in columns {
                row.push(ns(records.time(robot, algorithm, route)?));
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The cost of doubling a chain, as a power of its length, and the cost of a link.
fn growth(records: &Records) -> Result<Rows, Trouble> {
    let chains = records.robots(true);
    let mut first = vec!["ns per state".to_owned()];
    first.extend(chains.iter().map(|(_, nv)| format!("{nv} links")));
    first.push("from 32 to 250".into());
    let mut rows = vec![first];
    for (form, route) in [("one state", Route::ONE), ("batch f64", Route::DOUBLES)] {
        for (algorithm, label, _) in JUDGED {
            let mut row = vec![format!("{form}, {label}")];
            for (robot, _) in &chains {
                row.push(ns(records.time(robot, algorithm, route)?));
            }
            let (short, long) = ("chain_32", "chain_250");
            let ratio = records.time(long, algorithm, route)? / records.time(short, algorithm, route)?;
            row.push(format!("n^{:.2}", ratio.ln() / (250.0_f64 / 32.0).ln()));
            rows.push(row);
        }
    }
    Ok(rows)
}

fn operations(records: &Records) -> Result<Rows, Trouble> {
    let mut rows =
        head(&["", "operations done", "instructions", "left to a program for this robot", "sin and cos"]);
    for (robot, shown) in [("panda", "Panda"), ("talos", "Talos")] {
        for (algorithm, label, _) in JUDGED {
            let done = records.operations(robot, algorithm, "done")?;
            let left = records.operations(robot, algorithm, "left")?;
            let counts = [done.arithmetic, done.instructions, left.arithmetic, left.sines];
            let mut row = vec![format!("{shown}, {label}")];
            row.extend(counts.map(crate::panel::shown));
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Times relative to the least time of their operations.
fn floor(records: &Records) -> Result<Rows, Trouble> {
    let mut rows = head(&[
        "ns per state: measured / least for the operations done / left",
        "one state f64",
        "batch f64",
        "batch f32",
    ]);
    for (robot, shown) in [("panda", "Panda"), ("talos", "Talos")] {
        for (algorithm, label, _) in JUDGED {
            let mut row = vec![format!("{shown}, {label}")];
            for route in [Route::ONE, Route::DOUBLES, Route::SINGLES] {
                let time = records.time(robot, algorithm, route)?;
                let done = least(records, records.operations(robot, algorithm, "done")?, route)?;
                let left = least(records, records.operations(robot, algorithm, "left")?, route)?;
                row.push(format!("{} / {} / {}: {:.1} ×", ns(time), ns(done), ns(left), time / done));
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Generated code: nanoseconds of the first program, and the ratios of the others.
fn generated(records: &Records, form: &str, sides: &[&str]) -> Result<Rows, Trouble> {
    let shown_as = |side: &str| match side {
        "ours" => "the library".to_owned(),
        "pinocchio native" => "Pinocchio".to_owned(),
        other => other.to_owned(),
    };
    let mut rows =
        vec![core::iter::once(String::new()).chain(sides.iter().map(|side| shown_as(side))).collect()];
    for (robot, name) in [("panda", "Panda"), ("talos", "Talos")] {
        for (algorithm, label, _) in &JUDGED[..3] {
            let mut row: Vec<String> = vec![format!("{name}, {label}")];
            for (k, side) in sides.iter().enumerate() {
                let [time, ratio, low, high] =
                    records.generated(robot, &format!("{algorithm}{form}"), side)?;
                let times = format!("{ratio:.2} × ({low:.2} to {high:.2})");
                row.push(if k == 0 { ns(time) } else { times });
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Pullbacks and Jacobians as multiples of their primal call.
fn pullbacks(records: &Records) -> Result<Rows, Trouble> {
    let robots = [("panda", "Panda"), ("talos", "Talos")];
    let mut first = vec![String::new()];
    for (_, shown) in robots {
        first.push(format!("{shown}: the call, ns"));
        first.extend(["pullback", "with parameters", "Jacobians"].map(String::from));
    }
    let mut rows = vec![first];
    for (call, ..) in records.pullbacks(robots[0].0) {
        let mut row = vec![call.to_owned()];
        for (robot, _) in robots {
            let all = records.pullbacks(robot);
            let own = all.iter().find(|(name, ..)| *name == call);
            let (_, primal, ratios) = own.ok_or_else(|| format!("no {call} of {robot}"))?;
            row.push(ns(*primal));
            row.extend(ratios.map(|ratio| ratio.map_or("–".into(), |ratio| format!("{ratio:.2} ×"))));
        }
        rows.push(row);
    }
    Ok(rows)
}
