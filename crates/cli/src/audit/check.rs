//! One line of an audit.

use serde::{Serialize, Serializer};

use crate::table::short;

/// What was checked, and what came of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Check {
    /// A short name that stays the same.
    #[serde(rename = "check")]
    pub name: &'static str,
    /// The law, readable.
    pub law: String,
    #[serde(serialize_with = "finite_or_null")]
    pub found: f64,
    /// How `found` must compare with `allowed`.
    relation: &'static str,
    #[serde(serialize_with = "finite_or_null")]
    pub allowed: f64,
    pub verdict: Verdict,
    /// Where the worst was found.
    #[serde(rename = "where")]
    pub place: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Verdict {
    Ok,
    Short,
}

impl Verdict {
    pub(crate) fn shown(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Short => "FALLS SHORT",
        }
    }
}

impl Check {
    /// A check of one number; NaN is never enough.
    pub(crate) fn new(
        name: &'static str,
        law: impl Into<String>,
        (found, allowed): (f64, f64),
        place: impl Into<String>,
    ) -> Self {
        let verdict = if found <= allowed { Verdict::Ok } else { Verdict::Short };
        Self { name, law: law.into(), found, relation: "<=", allowed, verdict, place: place.into() }
    }
}

/// A number in the table: of usual size as it is, all else by its power of ten.
pub(crate) fn shown(x: f64) -> String {
    match x {
        x if x.is_nan() => "NaN".into(),
        x if x.is_infinite() => "∞".into(),
        x if x == 0.0 || (0.01..10_000.0).contains(&x.abs()) => short(x),
        x => format!("{x:.1e}"),
    }
}

/// The worst of many comparisons of a defect with what rounding allows there.
pub(crate) struct Worst {
    name: &'static str,
    law: &'static str,
    found: f64,
    allowed: f64,
    ratio: f64,
    place: String,
}

impl Worst {
    pub(crate) fn of(name: &'static str, law: &'static str) -> Self {
        Self { name, law, found: 0.0, allowed: 0.0, ratio: -1.0, place: String::new() }
    }

    /// Takes note of a defect at a state.
    pub(crate) fn see(&mut self, found: f64, allowed: f64, state: usize) {
        // A defect of zero is fine whatever is allowed; NaN is worse than anything.
        let ratio = match found / allowed {
            _ if found == 0.0 => 0.0,
            ratio if ratio.is_nan() => f64::INFINITY,
            ratio => ratio,
        };
        if ratio > self.ratio {
            (self.found, self.allowed, self.ratio) = (found, allowed, ratio);
            self.place = format!("state {state}");
        }
    }

    pub(crate) fn check(self) -> Check {
        Check::new(self.name, self.law, (self.found, self.allowed), self.place)
    }
}

/// JSON has no number for what is not finite.
#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn finite_or_null<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if x.is_finite() { serializer.serialize_f64(*x) } else { serializer.serialize_none() }
}
