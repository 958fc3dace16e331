//! The plot of a run: joint coordinates, energies, and the energy error on a logarithmic axis. If the method
//! separates them, energy losses and ground forces follow.

mod panel;

use std::io::Write;
use std::path::{Path, PathBuf};

use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend, Text, WHITE,
};
use plotters::style::{FontStyle, register_font};
use robot_dynamics::model::{Joint, Model};

use self::panel::{Axis, Corners, Line, Panel};
use super::csv::OptionalColumns;
use super::recorder::Recorder;
use crate::columns;
use crate::failure::Failure;
use crate::output_file::OutputFile;

/// The embedded font, as the machine may have none. See fonts/README.md.
const FONT: &[u8] = include_bytes!("../../fonts/DejaVuSans-subset.ttf");

const WIDTH: u32 = 1200;
const PANEL: u32 = 400;
const TITLE: u32 = 40;

/// The data of a plot.
pub(crate) struct Plot<'a> {
    pub model: &'a Model,
    pub recorder: &'a Recorder,
    pub columns: OptionalColumns<'a>,
    pub caption: &'a str,
    /// The divisor of the energy error \[J\].
    pub scale: f64,
    /// Whether E is constant without error.
    pub conserves: bool,
    /// Whether the motion diverged, so that its last values may be clipped.
    pub diverged: bool,
}

/// Parses a path with the extension of a supported format.
pub(crate) fn path(text: &str) -> Result<PathBuf, String> {
    match format(Path::new(text)) {
        Some(_) => Ok(text.into()),
        None => Err("the name must end in .svg or .png".into()),
    }
}

enum Format {
    Svg,
    Png,
}

fn format(path: &Path) -> Option<Format> {
    match path.extension()?.to_str()? {
        "svg" => Some(Format::Svg),
        "png" => Some(Format::Png),
        _ => None,
    }
}

/// Pixels of three bytes, in rows from the top.
fn write_png(file: &mut OutputFile, (width, height): (u32, u32), pixels: &[u8]) -> std::io::Result<()> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    Ok(writer.finish()?)
}

impl Plot<'_> {
    /// Draws into `file`, in the format of `path`.
    pub(crate) fn draw(&self, file: &mut OutputFile, path: &Path) -> Result<(), Failure> {
        if register_font("sans-serif", FontStyle::Normal, FONT).is_err() {
            return Err(Failure::new("cannot read the embedded font"));
        }
        let panels = self.panels();
        let size = (WIDTH, TITLE + panels.iter().map(|panel| panel.height(PANEL)).sum::<u32>());
        if let Some(Format::Png) = format(path) {
            let mut pixels = vec![0; 3 * size.0 as usize * size.1 as usize];
            let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
            self.paint(&panels, &area, Corners::Open)?;
            drop(area);
            write_png(file, size, &pixels).map_err(Failure::new)
        } else {
            let mut text = String::new();
            let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
            self.paint(&panels, &area, Corners::Joined)?;
            drop(area);
            file.write_all(text.as_bytes()).map_err(Failure::new)
        }
    }

    fn paint<B: DrawingBackend>(
        &self,
        panels: &[Panel],
        area: &DrawingArea<B, plotters::coord::Shift>,
        corners: Corners,
    ) -> Result<(), Failure> {
        area.fill(&WHITE).map_err(Failure::new)?;
        let (head, mut rest) = area.split_vertically(TITLE);
        head.draw(&Text::new(self.caption, (24, 14), ("sans-serif", 20))).map_err(Failure::new)?;
        for panel in panels {
            let (top, below) = rest.split_vertically(panel.height(PANEL));
            panel.draw(&top, corners).map_err(Failure::new)?;
            rest = below;
        }
        area.present().map_err(Failure::new)
    }

    fn panels(&self) -> Vec<Panel> {
        let samples = &self.recorder.samples;
        let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
        let line = |name: String, values: Vec<f64>| Line { name, values };
        let error = samples.iter().map(|sample| sample.worst_error / self.scale).collect();
        let error_name = if self.conserves {
            "Energy drift |E − E₀| / |E₀|"
        } else {
            "Energy residual |E − E₀ − in + out| / energy moved"
        };
        let mut panels = vec![
            self.coordinates(&times),
            Panel {
                name: "Energy [J]".into(),
                axis: Axis::Linear,
                lines: vec![
                    line("K, kinetic".into(), samples.iter().map(|s| s.kinetic).collect()),
                    line("V, potential".into(), samples.iter().map(|s| s.potential).collect()),
                    line("E = K + V".into(), samples.iter().map(|s| s.kinetic + s.potential).collect()),
                ],
                times: times.clone(),
                diverged: self.diverged,
            },
            Panel {
                name: error_name.into(),
                axis: Axis::Logarithmic,
                lines: vec![line("energy error".into(), error)],
                times: times.clone(),
                diverged: self.diverged,
            },
        ];
        let losses = self.columns.losses().iter().enumerate();
        let taken = losses
            .map(|(k, cause)| line((*cause).into(), samples.iter().map(|sample| sample.losses[k]).collect()));
        let links = self.columns.touching.iter().enumerate();
        let forces = links
            .map(|(k, link)| line(link.clone(), samples.iter().map(|sample| sample.contact[k]).collect()))
            .filter(|line| line.values.iter().any(|force| *force > 0.0));
        for (name, lines) in [
            ("Energy losses [J]", taken.collect::<Vec<_>>()),
            ("Ground force on each link [N]", forces.collect()),
        ] {
            if !lines.is_empty() {
                let (times, diverged) = (times.clone(), self.diverged);
                panels.push(Panel { name: name.into(), axis: Axis::Linear, lines, times, diverged });
            }
        }
        panels
    }

    /// The joints' plain coordinates, or all of q for a robot without them.
    ///
    /// A floating base in free fall moves hundreds of metres in ten seconds, and angles would not show beside
    /// it.
    fn coordinates(&self, times: &[f64]) -> Panel {
        let columns = columns::configuration(self.model);
        let joints = self.model.joints().iter();
        let plain: Vec<usize> = joints.filter(|j| j.nq == j.nv).flat_map(Joint::q).collect();
        let shown = if plain.is_empty() { (0..columns.len()).collect() } else { plain };
        let mut units: Vec<&str> = shown.iter().map(|&i| columns[i].unit).collect();
        units.sort_unstable_by(|a, b| b.cmp(a));
        units.dedup();
        let line = |i: usize| {
            let Some(column) = columns.get(i) else { unreachable!("{i} is an entry of q") };
            let unit = if units.len() > 1 { format!(" [{}]", column.unit) } else { String::new() };
            let values = self.recorder.samples.iter().map(|sample| sample.q[i]).collect();
            Line { name: format!("{}{unit}", column.name), values }
        };
        Panel {
            name: format!("Joint coordinates [{}]", units.join(", ")),
            axis: Axis::Linear,
            lines: shown.iter().map(|&i| line(i)).collect(),
            times: times.to_vec(),
            diverged: self.diverged,
        }
    }
}
