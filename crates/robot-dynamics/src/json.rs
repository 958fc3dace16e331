//! States and results as lines of JSON, in the format of `dynamics compute`.
//!
//! ```
//! use robot_dynamics::json::{Object, StateLine, Value};
//! let state = StateLine::parse(br#"{"q":[0.1],"v":[2]}"#)?;
//! assert_eq!((state.v, state.a), (vec![2.0], None));
//! let answer = Object(vec![("gravity".into(), Value::Numbers(vec![9.81]))]);
//! assert_eq!(answer.to_line(), r#"{"gravity":[9.81]}"#);
//! # Ok::<(), String>(())
//! ```

use std::borrow::Cow;

use serde::{Deserialize, Serialize, Serializer};

/// A state in a line of JSON, with optional accelerations and forces.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct StateLine {
    /// nq numbers.
    pub q: Vec<f64>,
    /// nv numbers.
    pub v: Vec<f64>,
    /// Accelerations, nv numbers.
    pub a: Option<Vec<f64>>,
    /// Forces, nv numbers.
    pub tau: Option<Vec<f64>>,
}

impl StateLine {
    /// Reads `{"q":[..],"v":[..],"a":[..],"tau":[..]}`. The lengths of the lists are not checked.
    ///
    /// # Errors
    /// A message with the expected form and the column of the fault.
    pub fn parse(line: &[u8]) -> Result<Self, String> {
        let wanted = "expected {\"q\":[..],\"v\":[..]} with \"a\" and \"tau\" optional";
        let line = line.trim_ascii();
        if line.first() != Some(&b'{') {
            return Err(format!("{wanted}; the line is not a JSON object"));
        }
        serde_json::from_slice(line)
            .map_err(|error| format!("{wanted}: {}", error.to_string().replace("line 1 column", "column")))
    }
}

/// A JSON object that keeps the order of its members.
#[derive(Clone, Debug, PartialEq)]
pub struct Object(pub Vec<(Cow<'static, str>, Value)>);

/// A value in an [`Object`]. Numbers that are not finite are written as `null`, because JSON cannot represent
/// them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A count.
    Count(usize),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A matrix, row by row.
    Rows(Vec<Vec<f64>>),
    /// A text.
    Text(String),
    /// A list of texts.
    Texts(Vec<String>),
    /// Another object.
    Object(Object),
}

impl Object {
    /// The object as one line, without a line break.
    #[allow(clippy::missing_panics_doc)]
    pub fn to_line(&self) -> String {
        serde_json::to_string(self).expect("texts, numbers and lists of these")
    }
}

impl Serialize for Object {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}
