//! Values that suggest a wrong unit: no law forbids them, but no known robot has them.

use robot_dynamics::plausibility::Suspicion;
use serde::Serialize;

use crate::table::{Table, short_or_exponent};

/// Number of places that the text lists for one suspicion; JSON lists all.
const MAX_PLACES: usize = 3;

/// A suspicion with its verdict, as a JSON object.
#[derive(Serialize)]
pub(crate) struct Suspect<'a> {
    #[serde(flatten)]
    suspicion: &'a Suspicion,
    /// Distinguishes it from the verdicts of the checks.
    verdict: &'static str,
    /// The cause as text.
    reason: String,
}

impl<'a> Suspect<'a> {
    pub(crate) fn new(suspicion: &'a Suspicion) -> Self {
        Self { suspicion, verdict: "suspect", reason: suspicion.cause.to_string() }
    }
}

/// The section of the text output.
pub(crate) fn text(suspicions: &[Suspicion]) -> String {
    if suspicions.is_empty() {
        return "No value suggests a wrong unit.\n".into();
    }
    let mut table = Table::new(&["quantity", ">found", ">expected", "verdict", "where", "possible cause"]);
    for suspicion in suspicions {
        let expected = match suspicion.expected {
            (Some(low), Some(high)) => format!("{} … {}", short_or_exponent(low), short_or_exponent(high)),
            (Some(low), None) => format!("≥ {}", short_or_exponent(low)),
            (None, Some(high)) => format!("≤ {}", short_or_exponent(high)),
            (None, None) => String::new(),
        };
        table.row([
            suspicion.quantity.to_string(),
            short_or_exponent(suspicion.found),
            expected,
            "suspect".into(),
            places(suspicion),
            suspicion.cause.to_string(),
        ]);
    }
    format!("Values that suggest a wrong unit (--strict makes them errors):\n\n{}", table.text())
}

/// Names the place, such as `link "hand"`, or the worst of several.
fn places(suspicion: &Suspicion) -> String {
    let Suspicion { places, of, .. } = suspicion;
    if places.len() <= 1 {
        return places.concat();
    }
    let named = &places[..places.len().min(MAX_PLACES)];
    let more = if places.len() > MAX_PLACES { ", …" } else { "" };
    format!("{} of {of}: {}{more}", places.len(), named.join(", "))
}
