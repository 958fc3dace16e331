//! The measurements, from their JSON lines.

use std::path::Path;

use serde_json::Value;

/// An error in the measurements.
pub(crate) type Trouble = Box<dyn std::error::Error>;

/// The five files.
pub(crate) struct Records {
    /// Output of `measure_scaling`, with the machine in the first line.
    scaling: Vec<Value>,
    /// Output of `peers/run.py`.
    peers: Vec<Value>,
    /// Output of `peers/history.py`.
    steps: Vec<Value>,
    /// Output of `measure_pullbacks`.
    pullbacks: Vec<Value>,
    /// Output of `peers/generated.py`.
    generated: Vec<Value>,
}

/// A route of an algorithm.
#[derive(Clone, Copy)]
pub(crate) struct Route {
    pub(crate) form: &'static str,
    pub(crate) number: &'static str,
    /// The route by name; without one, the last recorded, which is the machine's best.
    pub(crate) instructions: Option<&'static str>,
}

impl Route {
    pub(crate) const ONE: Self =
        Self { form: "one state", number: "f64", instructions: Some("AVX2 and FMA") };
    pub(crate) const PORTABLE: Self = Self { instructions: Some("portable"), ..Self::ONE };
    pub(crate) const DOUBLES: Self = Self { form: "batch", number: "f64", instructions: None };
    pub(crate) const SINGLES: Self = Self { number: "f32", ..Self::DOUBLES };
}

/// One line of `peers/run.py`.
#[derive(Clone, Copy)]
pub(crate) struct Ratio {
    pub(crate) ours: f64,
    pub(crate) theirs: f64,
    pub(crate) ratio: f64,
    pub(crate) spread: [f64; 2],
    /// By the smallest times.
    pub(crate) of_least: f64,
}

/// Operations of one evaluation.
#[derive(Clone, Copy)]
pub(crate) struct Operations {
    pub(crate) arithmetic: f64,
    pub(crate) instructions: f64,
    pub(crate) sines: f64,
}

fn read(path: &Path) -> Result<Vec<Value>, Trouble> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let line = |(i, line): (usize, &str)| {
        serde_json::from_str(line)
            .map_err(|error| format!("{}, line {}: {error}", path.display(), i + 1).into())
    };
    text.lines().enumerate().map(line).collect()
}

impl Records {
    pub(crate) fn read(folder: &Path) -> Result<Self, Trouble> {
        let read = |name| read(&folder.join(name));
        Ok(Self {
            scaling: read("scaling.jsonl")?,
            peers: read("peers.jsonl")?,
            steps: read("steps.jsonl")?,
            pullbacks: read("pullbacks.jsonl")?,
            generated: read("generated.jsonl")?,
        })
    }

    /// A robot's calls: their names, nanoseconds, and as multiples of them the pullback, that with
    /// parameters, and the Jacobians.
    pub(crate) fn pullbacks(&self, robot: &str) -> Vec<(&str, f64, [Option<f64>; 3])> {
        let ratios = |line: &Value| ["pullback", "parameters", "jacobians"].map(|key| line[key].as_f64());
        let own = self.pullbacks.iter().filter(|line| line["robot"] == robot);
        own.filter_map(|line| Some((line["call"].as_str()?, line["ns"].as_f64()?, ratios(line)))).collect()
    }

    /// A program in the comparison of generated code: nanoseconds per state, and the ratio to the first
    /// program, with its range.
    pub(crate) fn generated(&self, robot: &str, algorithm: &str, side: &str) -> Result<[f64; 4], Trouble> {
        let is_it =
            |line: &&Value| line["robot"] == robot && line["algorithm"] == algorithm && line["side"] == side;
        let what = || format!("no {algorithm} of {robot} by {side}");
        let line = self.generated.iter().find(is_it).ok_or_else(what)?;
        let number = |value: &Value| value.as_f64().ok_or_else(what);
        Ok([
            number(&line["ns"])?,
            number(&line["ratio"])?,
            number(&line["spread"][0])?,
            number(&line["spread"][1])?,
        ])
    }

    /// A text or number of a file's first line.
    pub(crate) fn machine(&self, file: &str) -> &Value {
        let lines = match file {
            "scaling" => &self.scaling,
            "peers" => &self.peers,
            _ => &self.steps,
        };
        &lines[0]["machine"]
    }

    /// Smallest nanoseconds of a fused multiply-add on `lanes` numbers.
    pub(crate) fn peak(&self, lanes: usize) -> Result<f64, Trouble> {
        let key = format!("fma_{lanes}_lane{}_ns", if lanes == 1 { "" } else { "s" });
        self.machine("scaling")["peak"][&key].as_f64().ok_or_else(|| format!("no {key} was measured").into())
    }

    /// The robots of a kind with their degrees of freedom, in the order of the file.
    pub(crate) fn robots(&self, is_chain: bool) -> Vec<(String, f64)> {
        let mut robots: Vec<(String, f64)> = Vec::new();
        for line in &self.scaling {
            let (Some(name), Some(nv)) = (line["robot"].as_str(), line["nv"].as_f64()) else { continue };
            if name.starts_with("chain_") == is_chain && !robots.iter().any(|(known, _)| known == name) {
                robots.push((name.to_owned(), nv));
            }
        }
        robots
    }

    /// The smallest nanoseconds per state.
    pub(crate) fn time(&self, robot: &str, algorithm: &str, route: Route) -> Result<f64, Trouble> {
        let is_it = |line: &&Value| {
            line["robot"] == robot
                && line["algorithm"] == algorithm
                && line["form"] == route.form
                && line["number"] == route.number
                && route.instructions.is_none_or(|name| line["instructions"] == name)
        };
        let found = self.scaling.iter().rfind(is_it).and_then(|line| line["least_ns"].as_f64());
        found.ok_or_else(|| format!("no time of {algorithm} of {robot}, {}", route.form).into())
    }

    /// Operations of the recursions, or of a program for that robot alone.
    pub(crate) fn operations(
        &self,
        robot: &str,
        algorithm: &str,
        which: &str,
    ) -> Result<Operations, Trouble> {
        let is_it = |line: &&Value| {
            line["robot"] == robot && line["algorithm"] == algorithm && line[which].is_object()
        };
        let counts = self.scaling.iter().find(is_it).map(|line| &line[which]);
        let counts = counts.ok_or_else(|| format!("no operations of {algorithm} of {robot}"))?;
        let number =
            |key: &str| counts[key].as_f64().ok_or_else(|| format!("no {key} of {algorithm} of {robot}"));
        Ok(Operations {
            arithmetic: number("arithmetic")?,
            instructions: number("instructions")?,
            sines: number("sines")?,
        })
    }

    /// This library beside a peer.
    pub(crate) fn ratio(&self, robot: &str, algorithm: &str, peer: &str) -> Result<Ratio, Trouble> {
        let is_it =
            |line: &&Value| line["robot"] == robot && line["algorithm"] == algorithm && line["peer"] == peer;
        let what = || format!("no {algorithm} of {robot} beside {peer}");
        let line = self.peers.iter().find(is_it).ok_or_else(what)?;
        let number = |value: &Value| value.as_f64().ok_or_else(what);
        Ok(Ratio {
            ours: number(&line["ours_ns"])?,
            theirs: number(&line["peer_ns"])?,
            ratio: number(&line["ratio"])?,
            spread: [number(&line["spread"][0])?, number(&line["spread"][1])?],
            of_least: number(&line["peer_min_ns"])? / number(&line["ours_min_ns"])?,
        })
    }

    /// Commits in the order of time, with their descriptions.
    pub(crate) fn steps(&self) -> Vec<(String, String)> {
        let mut steps: Vec<(String, String)> = Vec::new();
        for line in &self.steps {
            if let (Some(commit), Some(step)) = (line["commit"].as_str(), line["step"].as_str())
                && !steps.iter().any(|(known, _)| known == commit)
            {
                steps.push((commit.to_owned(), step.to_owned()));
            }
        }
        steps
    }

    /// The smallest nanoseconds per state at a commit.
    pub(crate) fn step_time(&self, robot: &str, algorithm: &str, commit: &str) -> Result<f64, Trouble> {
        let is_it = |line: &&Value| {
            line["robot"] == robot && line["algorithm"] == algorithm && line["commit"] == commit
        };
        let found = self.steps.iter().find(is_it).and_then(|line| line["least_ns"].as_f64());
        found.ok_or_else(|| format!("no {algorithm} of {robot} as of {commit}").into())
    }
}
