//! What looks like a wrong unit: no law is broken, but no robot is known to be like this.

use multibody::plausibility::Suspicion;
use serde::Serialize;

use super::shown;
use crate::table::Table;

/// How many places of one suspicion the text names; the JSON names all.
const NAMED: usize = 3;

/// A suspicion with its verdict, as JSON has it.
#[derive(Serialize)]
pub(crate) struct Suspect<'a> {
    #[serde(flatten)]
    suspicion: &'a Suspicion,
    /// Beside the verdicts of the laws.
    verdict: &'static str,
    /// The cause in words.
    reason: String,
}

impl<'a> Suspect<'a> {
    pub(crate) fn new(suspicion: &'a Suspicion) -> Self {
        Self { suspicion, verdict: "suspect", reason: suspicion.cause.to_string() }
    }
}

/// The section of the text.
pub(crate) fn text(suspicions: &[Suspicion]) -> String {
    if suspicions.is_empty() {
        return "No number looks like a wrong unit.\n".into();
    }
    let mut table = Table::new(&["what looks wrong", ">found", ">expected", "verdict", "where", "perhaps"]);
    for suspicion in suspicions {
        let expected = match suspicion.expected {
            (Some(low), Some(high)) => format!("{} … {}", shown(low), shown(high)),
            (Some(low), None) => format!("≥ {}", shown(low)),
            (None, Some(high)) => format!("≤ {}", shown(high)),
            (None, None) => String::new(),
        };
        table.row([
            suspicion.quantity.to_string(),
            shown(suspicion.found),
            expected,
            "suspect".into(),
            places(suspicion),
            suspicion.cause.to_string(),
        ]);
    }
    format!(
        "Numbers that look like wrong units; no law is broken, --strict makes them a failure:\n\n{}",
        table.text()
    )
}

/// `link "hand"`, or the worst of many.
fn places(suspicion: &Suspicion) -> String {
    let Suspicion { places, of, .. } = suspicion;
    if places.len() <= 1 {
        return places.concat();
    }
    let named = &places[..places.len().min(NAMED)];
    let more = if places.len() > NAMED { ", …" } else { "" };
    format!("{} of {of}: {}{more}", places.len(), named.join(", "))
}
