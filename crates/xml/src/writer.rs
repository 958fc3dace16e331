//! XML text, element by element.

use core::fmt::Write as _;
use std::path::{Component, Path};

/// Deeper elements are indented no further: the text of a chain would else grow as its length squared.
const DEEPEST: usize = 40;

/// XML under construction: every value escaped, every number with as many digits as it needs to be read back the same.
///
/// ```
/// let mut xml = robot_xml::Writer::new();
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
    /// Whether the last element may still take attributes.
    is_open: bool,
}

impl Writer {
    /// An empty text.
    pub fn new() -> Self {
        Self::default()
    }

    /// Begins an element in the last one that has not ended.
    ///
    /// ```
    /// let mut xml = robot_xml::Writer::new();
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

    /// An attribute of the element that was begun last.
    ///
    /// ```
    /// let mut xml = robot_xml::Writer::new();
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
                // A reader would make a blank of each.
                '\t' | '\n' | '\r' => {
                    let _ = write!(self.text, "&#{};", u32::from(letter));
                }
                letter => self.text.push(letter),
            }
        }
        self.text.push('"');
        self
    }

    /// An attribute of numbers.
    ///
    /// ```
    /// let mut xml = robot_xml::Writer::new();
    /// xml.start("axis").numbers("xyz", &[0.0, -0.0, 1e-17]);
    /// assert_eq!(xml.finish(), "<axis xyz=\"0 0 1e-17\"/>\n");
    /// ```
    pub fn numbers(&mut self, name: &str, values: &[f64]) -> &mut Self {
        let words: Vec<String> = values.iter().map(|&value| number(value)).collect();
        self.attribute(name, &words.join(" "))
    }

    /// An attribute of one number, left out where it has the value that stands for it.
    ///
    /// ```
    /// let mut xml = robot_xml::Writer::new();
    /// xml.start("joint").unless("damping", 0.0, 0.0).unless("armature", 0.1, 0.0);
    /// assert_eq!(xml.finish(), "<joint armature=\"0.1\"/>\n");
    /// ```
    #[allow(clippy::float_cmp)] // what is left out is read back as this very value
    pub fn unless(&mut self, name: &str, value: f64, default: f64) -> &mut Self {
        if value == default { self } else { self.numbers(name, &[value]) }
    }

    /// Ends the element that was begun last and has not ended.
    ///
    /// ```
    /// let mut xml = robot_xml::Writer::new();
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

    /// The text, all elements ended.
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
        self.text.extend(core::iter::repeat_n("  ", self.open.len().min(DEEPEST)));
    }
}

/// A number as text that is read back the same; −0 as 0.
fn number(value: f64) -> String {
    let text = format!("{:?}", value + 0.0);
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// Whether XML can hold the text, and a robot file take it as a name: not blank, no control characters but white space.
///
/// ```
/// assert!(robot_xml::is_name("left \"arm\""));
/// assert!(!robot_xml::is_name(" ") && !robot_xml::is_name("a\u{1}"));
/// ```
pub fn is_name(text: &str) -> bool {
    let is_letter = |letter: char| match letter {
        '\t' | '\n' | '\r' => true,
        '\u{fffe}' | '\u{ffff}' => false,
        letter => !letter.is_control(),
    };
    !text.trim().is_empty() && text.chars().all(is_letter)
}

/// The way to a file from a folder, with `/` between its parts on every system; its full path where none leads there.
///
/// ```
/// use std::path::Path;
/// let file = Path::new("/robots/arm/meshes/hand.stl");
/// assert_eq!(robot_xml::way_from(Path::new("/robots/arm/urdf"), file), "../meshes/hand.stl");
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
