//! Writes XML text, element by element.

use core::fmt::Write as _;
use std::path::{Component, Path};

/// The largest indentation. Without a limit the size of a chain would grow with the square of its length.
const INDENT_LIMIT: usize = 40;

/// A writer of XML text. It escapes all values, and writes numbers with as many digits as are needed to read
/// back the same.
///
/// ```
/// let mut xml = robot_dynamics_xml::Writer::new();
/// xml.start("robot").attribute("name", "a \"b\" & c");
/// xml.start("origin").numbers("xyz", &[0.1, 1.0, -2e-9]);
/// xml.end();
/// xml.end();
/// let text = "<robot name=\"a &quot;b&quot; &amp; c\">\n  <origin xyz=\"0.1 1 -2e-9\"/>\n</robot>\n";
/// assert_eq!(xml.finish(), text);
/// ```
#[derive(Debug, Default)]
pub struct Writer {
    text: String,
    open: Vec<&'static str>,
    /// Whether the last element accepts attributes.
    is_open: bool,
}

impl Writer {
    /// A writer without text.
    pub fn new() -> Self {
        Self::default()
    }

    /// Begins an element inside the innermost open element.
    ///
    /// ```
    /// let mut xml = robot_dynamics_xml::Writer::new();
    /// xml.start("robot").start("link").attribute("name", "arm");
    /// assert_eq!(xml.finish(), "<robot>\n  <link name=\"arm\"/>\n</robot>\n");
    /// ```
    pub fn start(&mut self, name: &'static str) -> &mut Self {
        self.close_tag();
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        self.open.push(name);
        self.is_open = true;
        self
    }

    /// Adds an attribute to the element that was begun last.
    ///
    /// ```
    /// let mut xml = robot_dynamics_xml::Writer::new();
    /// xml.start("link").attribute("name", "two\nlines");
    /// assert_eq!(xml.finish(), "<link name=\"two&#10;lines\"/>\n");
    /// ```
    pub fn attribute(&mut self, name: &str, value: &str) -> &mut Self {
        self.text.push(' ');
        self.text.push_str(name);
        self.text.push_str("=\"");
        for letter in value.chars() {
            match letter {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '"' => self.text.push_str("&quot;"),
                // Readers would replace each by a blank.
                '\t' | '\n' | '\r' => {
                    let _ = write!(self.text, "&#{};", u32::from(letter));
                }
                letter => self.text.push(letter),
            }
        }
        self.text.push('"');
        self
    }

    /// Adds an attribute with numbers.
    ///
    /// ```
    /// let mut xml = robot_dynamics_xml::Writer::new();
    /// xml.start("axis").numbers("xyz", &[0.0, -0.0, 1e-17]);
    /// assert_eq!(xml.finish(), "<axis xyz=\"0 0 1e-17\"/>\n");
    /// ```
    pub fn numbers(&mut self, name: &str, values: &[f64]) -> &mut Self {
        let words: Vec<String> = values.iter().map(|&value| number(value)).collect();
        self.attribute(name, &words.join(" "))
    }

    /// Adds an attribute with one number, unless it has its default value.
    ///
    /// ```
    /// let mut xml = robot_dynamics_xml::Writer::new();
    /// xml.start("joint").unless("damping", 0.0, 0.0).unless("armature", 0.1, 0.0);
    /// assert_eq!(xml.finish(), "<joint armature=\"0.1\"/>\n");
    /// ```
    #[allow(clippy::float_cmp)] // an omitted value is read back exactly as the default
    pub fn unless(&mut self, name: &str, value: f64, default: f64) -> &mut Self {
        if value == default { self } else { self.numbers(name, &[value]) }
    }

    /// Ends the innermost open element.
    ///
    /// ```
    /// let mut xml = robot_dynamics_xml::Writer::new();
    /// xml.start("robot");
    /// xml.start("link");
    /// xml.end();
    /// xml.start("joint");
    /// assert_eq!(xml.finish(), "<robot>\n  <link/>\n  <joint/>\n</robot>\n");
    /// ```
    pub fn end(&mut self) -> &mut Self {
        let Some(name) = self.open.pop() else { return self };
        if self.is_open {
            self.text.push_str("/>\n");
            self.is_open = false;
        } else {
            self.indent();
            let _ = writeln!(self.text, "</{name}>");
        }
        self
    }

    /// Ends all elements and returns the text.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }

    fn close_tag(&mut self) {
        if self.is_open {
            self.text.push_str(">\n");
            self.is_open = false;
        }
    }

    fn indent(&mut self) {
        self.text.extend(core::iter::repeat_n("  ", self.open.len().min(INDENT_LIMIT)));
    }
}

/// A number as text that reads back the same; −0 is written as 0.
fn number(value: f64) -> String {
    let text = format!("{:?}", value + 0.0);
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// Whether a text can be a name in a robot file: it is not blank, and has no control characters except white
/// space.
///
/// ```
/// assert!(robot_dynamics_xml::is_name("left \"arm\""));
/// assert!(!robot_dynamics_xml::is_name(" ") && !robot_dynamics_xml::is_name("a\u{1}"));
/// ```
pub fn is_name(text: &str) -> bool {
    let is_letter = |letter: char| match letter {
        '\t' | '\n' | '\r' => true,
        '\u{fffe}' | '\u{ffff}' => false,
        letter => !letter.is_control(),
    };
    !text.trim().is_empty() && text.chars().all(is_letter)
}

/// The relative path from a folder to a file, with `/` as separator on every system; the full path
/// without a relative one.
///
/// ```
/// use std::path::Path;
/// let file = Path::new("/robots/arm/meshes/hand.stl");
/// assert_eq!(robot_dynamics_xml::way_from(Path::new("/robots/arm/urdf"), file), "../meshes/hand.stl");
/// ```
pub fn way_from(folder: &Path, file: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let (folder, file) = (whole(folder), whole(file));
    let parts: (Vec<Component<'_>>, Vec<Component<'_>>) =
        (folder.components().collect(), file.components().collect());
    let shared = parts.0.iter().zip(&parts.1).take_while(|(a, b)| a == b).count();
    let named = |part: &Component<'_>| match part {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    };
    let down: Option<Vec<String>> = parts.1[shared..].iter().map(named).collect();
    match down.filter(|_| shared > 0) {
        Some(down) => vec!["..".to_owned(); parts.0.len() - shared]
            .into_iter()
            .chain(down)
            .collect::<Vec<_>>()
            .join("/"),
        None => file.to_string_lossy().into_owned(),
    }
}
