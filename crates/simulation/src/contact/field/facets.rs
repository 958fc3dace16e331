//! The triangles of a height field, and its faces: connected triangles in one plane.

use core::ops::RangeInclusive;

use nalgebra::Vector3;

/// The distance of a corner from a plane that counts as rounding, as a fraction of the field's size.
const IN_PLANE: f64 = 1e-12;

/// A face's plane { x : n·x = d }, n up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: Vector3<f64>,
    pub(super) offset: f64,
}

impl Plane {
    /// The height of a point above the plane.
    pub(super) fn gap(&self, at: &Vector3<f64>) -> f64 {
        self.normal.dot(at) - self.offset
    }
}

/// The surface in the field's frame. Triangle 2k lies in cell k along x, triangle 2k + 1 along y; cells are
/// counted row by row.
#[derive(Debug)]
pub(super) struct Facets {
    rows: usize,
    columns: usize,
    half_size: [f64; 2],
    heights: Vec<f64>,
    /// The plane of each triangle, in `planes`.
    pub(super) of: Vec<usize>,
    pub(super) planes: Vec<Plane>,
    pub(super) highest: f64,
    /// Distances below are rounding.
    pub(super) rounding: f64,
}

impl Facets {
    /// The numbers are checked.
    pub(super) fn new([rows, columns]: [usize; 2], half_size: [f64; 2], heights: Vec<f64>) -> Self {
        let highest = heights.iter().fold(f64::NEG_INFINITY, |most, height| most.max(*height));
        let size = heights.iter().fold(half_size[0].max(half_size[1]), |size, height| size.max(height.abs()));
        let triangles = 2 * (rows - 1) * (columns - 1);
        let mut facets = Self {
            rows,
            columns,
            half_size,
            heights,
            of: vec![usize::MAX; triangles],
            planes: Vec::new(),
            highest,
            rounding: IN_PLANE * size,
        };
        let mut open = Vec::new();
        for first in 0..triangles {
            if facets.of[first] != usize::MAX {
                continue;
            }
            let [a, b, c] = facets.corners(first);
            let normal = (b - a).cross(&(c - a)).normalize();
            let plane = Plane { normal, offset: normal.dot(&a) };
            let number = facets.planes.len();
            facets.planes.push(plane);
            facets.of[first] = number;
            open.push(first);
            while let Some(triangle) = open.pop() {
                for next in facets.neighbors(triangle).into_iter().flatten() {
                    let is_in = |corner: &Vector3<f64>| plane.gap(corner).abs() <= facets.rounding;
                    if facets.of[next] == usize::MAX && facets.corners(next).iter().all(is_in) {
                        facets.of[next] = number;
                        open.push(next);
                    }
                }
            }
        }
        facets
    }

    /// A point of the grid.
    fn node(&self, row: usize, column: usize) -> Vector3<f64> {
        let along = |at: usize, count: usize| 2.0 * at as f64 / (count - 1) as f64 - 1.0;
        let [x, y] = self.half_size;
        let height = self.heights[row * self.columns + column];
        Vector3::new(x * along(column, self.columns), y * along(row, self.rows), height)
    }

    fn cell_of(&self, triangle: usize) -> (usize, usize) {
        let cell = triangle / 2;
        (cell / (self.columns - 1), cell % (self.columns - 1))
    }

    /// The corners of a triangle, in order about z.
    pub(super) fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        let (row, column) = self.cell_of(triangle);
        let [first, last] = [self.node(row, column), self.node(row + 1, column + 1)];
        if triangle.is_multiple_of(2) {
            [first, self.node(row, column + 1), last]
        } else {
            [first, last, self.node(row + 1, column)]
        }
    }

    pub(super) fn plane(&self, triangle: usize) -> &Plane {
        &self.planes[self.of[triangle]]
    }

    /// The triangle across each of its edges.
    fn neighbors(&self, triangle: usize) -> [Option<usize>; 3] {
        let (row, column) = self.cell_of(triangle);
        let beside = triangle ^ 1;
        let width = self.columns - 1;
        if triangle.is_multiple_of(2) {
            let below = (row > 0).then(|| 2 * ((row - 1) * width + column) + 1);
            let right = (column + 1 < width).then(|| triangle + 3);
            [Some(beside), below, right]
        } else {
            let above = (row + 2 < self.rows).then(|| 2 * ((row + 1) * width + column));
            let left = (column > 0).then(|| triangle - 3);
            [Some(beside), above, left]
        }
    }

    /// The position in cells from the corner of least x and y.
    fn cells(&self, at: &Vector3<f64>) -> [f64; 2] {
        let of = |x: f64, half: f64, count: usize| (x + half) / (2.0 * half) * (count - 1) as f64;
        [of(at.x, self.half_size[0], self.columns), of(at.y, self.half_size[1], self.rows)]
    }

    /// The triangle above or below that point.
    pub(super) fn under(&self, at: &Vector3<f64>) -> Option<usize> {
        let [x, y] = self.cells(at);
        let (column, s) = cell(x, self.columns - 1)?;
        let (row, t) = cell(y, self.rows - 1)?;
        Some(2 * (row * (self.columns - 1) + column) + usize::from(s < t))
    }

    /// The triangle under that point, and those across its edges where the surface bends up: there, all these
    /// planes bound the free space. Each face occurs once.
    pub(super) fn around(&self, at: &Vector3<f64>) -> [Option<usize>; 4] {
        let Some(own) = self.under(at) else { return [None; 4] };
        let mut found = [Some(own), None, None, None];
        let plane = self.plane(own);
        for (k, next) in self.neighbors(own).into_iter().enumerate() {
            let Some(next) = next.filter(|&next| {
                let is_known = found.iter().flatten().any(|&other| self.of[other] == self.of[next]);
                !is_known && self.corners(next).iter().any(|corner| plane.gap(corner) > self.rounding)
            }) else {
                continue;
            };
            found[k + 1] = Some(next);
        }
        found
    }

    /// The triangles of all cells within this distance of the point along x and y.
    pub(super) fn within(&self, at: &Vector3<f64>, reach: f64) -> impl Iterator<Item = usize> + use<> {
        let far = Vector3::new(reach, reach, 0.0);
        let ([x0, y0], [x1, y1]) = (self.cells(&(at - far)), self.cells(&(at + far)));
        let width = self.columns - 1;
        let (columns, rows) = (range(x0, x1, width), range(y0, y1, self.rows - 1));
        let cells = rows.flat_map(move |row| columns.clone().map(move |column| row * width + column));
        cells.flat_map(|cell| [2 * cell, 2 * cell + 1])
    }
}

/// The cell of a position, out of `count`, and the position in the cell.
fn cell(at: f64, count: usize) -> Option<(usize, f64)> {
    if !(0.0..=count as f64).contains(&at) {
        return None;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least 0, and no more than a count
    let cell = (at as usize).min(count - 1);
    Some((cell, at - cell as f64))
}

/// The cells from one position to another, out of `count`.
#[allow(clippy::reversed_empty_ranges)] // an empty range
fn range(from: f64, to: f64, count: usize) -> RangeInclusive<usize> {
    if !(to >= 0.0 && from <= count as f64) {
        return 1..=0;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturating
    let [first, last] = [from, to].map(|at| (at.max(0.0) as usize).min(count - 1));
    first..=last
}
