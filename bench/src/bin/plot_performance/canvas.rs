//! Lines, marks and text on a picture, in pixels.

use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, IntoFont, PathElement, RGBColor, Rectangle, SVGBackend, Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, ShapeStyle};

use crate::records::Trouble;

pub(crate) const BLUE: RGBColor = RGBColor(31, 90, 180);
pub(crate) const ORANGE: RGBColor = RGBColor(205, 85, 10);
pub(crate) const GREEN: RGBColor = RGBColor(20, 130, 95);
pub(crate) const VIOLET: RGBColor = RGBColor(130, 70, 160);
pub(crate) const BROWN: RGBColor = RGBColor(135, 95, 45);
pub(crate) const ROSE: RGBColor = RGBColor(190, 40, 90);
pub(crate) const INK: RGBColor = RGBColor(45, 45, 45);
pub(crate) const GREY: RGBColor = RGBColor(115, 115, 115);
pub(crate) const LIGHT: RGBColor = RGBColor(222, 222, 222);

/// The anchor of a text.
#[derive(Clone, Copy)]
pub(crate) enum Hold {
    Left,
    Center,
    Right,
}

/// A picture under construction.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// A picture of this size, drawn by `paint`, as SVG.
pub(crate) fn svg(
    size: (u32, u32),
    paint: impl FnOnce(&Canvas<'_>) -> Result<(), Trouble>,
) -> Result<String, Trouble> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE).map_err(|error| error.to_string())?;
        let canvas = Canvas { area };
        paint(&canvas)?;
        canvas.area.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

/// To the nearest pixel.
#[allow(clippy::cast_possible_truncation)] // pictures are some thousand pixels wide
fn pixel((x, y): (f64, f64)) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

impl Canvas<'_> {
    pub(crate) fn line(&self, points: &[(f64, f64)], color: RGBColor, width: u32) -> Result<(), Trouble> {
        let points: Vec<(i32, i32)> = points.iter().copied().map(pixel).collect();
        let line = PathElement::new(points, ShapeStyle::from(color).stroke_width(width));
        self.area.draw(&line).map_err(|error| error.to_string().into())
    }

    /// A straight line in dashes.
    pub(crate) fn dashes(&self, from: (f64, f64), to: (f64, f64), color: RGBColor) -> Result<(), Trouble> {
        let (dash, gap) = (6.0, 5.0);
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        let at = |s: f64| (from.0 + dx * s / length, from.1 + dy * s / length);
        let mut start = 0.0;
        while start < length {
            self.line(&[at(start), at((start + dash).min(length))], color, 1)?;
            start += dash + gap;
        }
        Ok(())
    }

    pub(crate) fn dot(
        &self,
        at: (f64, f64),
        radius: u32,
        color: RGBColor,
        filled: bool,
    ) -> Result<(), Trouble> {
        let inside = Circle::new(pixel(at), radius, if filled { color } else { WHITE }.filled());
        self.area.draw(&inside).map_err(|error| error.to_string())?;
        let rim = Circle::new(pixel(at), radius, ShapeStyle::from(color).stroke_width(2));
        self.area.draw(&rim).map_err(|error| error.to_string().into())
    }

    pub(crate) fn bar(&self, from: (f64, f64), to: (f64, f64), color: RGBColor) -> Result<(), Trouble> {
        let bar = Rectangle::new([pixel(from), pixel(to)], color.filled());
        self.area.draw(&bar).map_err(|error| error.to_string().into())
    }

    /// Text whose middle height is at `at`.
    pub(crate) fn text(
        &self,
        text: &str,
        at: (f64, f64),
        hold: Hold,
        size: u32,
        color: RGBColor,
    ) -> Result<(), Trouble> {
        self.write(text, at, hold, size, color, FontTransform::None)
    }

    /// Vertical text, read upwards.
    pub(crate) fn upright(&self, text: &str, at: (f64, f64), size: u32) -> Result<(), Trouble> {
        self.write(text, at, Hold::Center, size, INK, FontTransform::Rotate270)
    }

    fn write(
        &self,
        text: &str,
        at: (f64, f64),
        hold: Hold,
        size: u32,
        color: RGBColor,
        turn: FontTransform,
    ) -> Result<(), Trouble> {
        let held = match hold {
            Hold::Left => HPos::Left,
            Hold::Center => HPos::Center,
            Hold::Right => HPos::Right,
        };
        let font = ("sans-serif", size).into_font().transform(turn).color(&color);
        let style = font.pos(Pos::new(held, VPos::Center));
        self.area.draw(&Text::new(text, pixel(at), style)).map_err(|error| error.to_string().into())
    }
}
