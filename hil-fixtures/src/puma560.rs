//! The tables of `data/puma560`: a PUMA 560 as others compute it. The README says what is in them.

use nalgebra::{Matrix3, Vector3};
use std::collections::HashMap;
use std::path::Path;
use tetrad_core::arm::puma560::Joints;
use tetrad_core::geometry::Pose;

/// A table with named columns.
#[derive(Clone, Debug)]
pub struct Table {
    columns: HashMap<String, usize>,
    rows: Vec<Vec<String>>,
}

/// One row of it.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    table: &'a Table,
    cells: &'a [String],
}

impl Table {
    /// Reads a file of comma-separated values, of which the first line has the columns' names.
    ///
    /// # Panics
    /// When it cannot be read or is empty; the methods of rows, when there is no such column or no number.
    #[must_use]
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let head = rows.next().unwrap_or_else(|| panic!("{}: empty", path.display()));
        let columns = head.into_iter().enumerate().map(|(i, name)| (name, i)).collect();
        Self { columns, rows: rows.collect() }
    }

    /// Its rows, in the file's order.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|cells| Row { table: self, cells })
    }
}

impl Row<'_> {
    /// A cell as it is written.
    #[must_use]
    pub fn text(&self, column: &str) -> &str {
        &self.cells[self.table.columns[column]]
    }

    /// A cell's number.
    #[must_use]
    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or_else(|_| panic!("{column}: {:?}", self.text(column)))
    }

    /// Six joints: the columns `q1` to `q6` behind a prefix, radians.
    #[must_use]
    pub fn joints(&self, prefix: &str) -> Joints<f64> {
        std::array::from_fn(|i| self.number(&format!("{prefix}q{}", i + 1)))
    }

    /// A rotation: the columns `11` to `33` behind a prefix.
    #[must_use]
    pub fn matrix(&self, prefix: &str) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.number(&format!("{prefix}{}{}", i + 1, j + 1)))
    }

    /// base_from_tool.
    #[must_use]
    pub fn pose(&self) -> Pose<f64> {
        let translation = Vector3::from_fn(|i, _| self.number(&format!("T{}4", i + 1)));
        Pose { rotation: self.matrix("T"), translation }
    }

    /// What to call it when something is wrong with it.
    #[must_use]
    pub fn name(&self) -> String {
        format!("row {} ({} {})", self.text("id"), self.text("kind"), self.text("tag"))
    }

    /// Whether it is of a kind.
    #[must_use]
    pub fn is(&self, kind: &str) -> bool {
        self.text("kind") == kind
    }

    /// Whether a factor of det J is 0, as exactly as it was computed.
    #[must_use]
    pub fn is_singular(&self) -> bool {
        self.is("singular") && !self.text("tag").contains("near")
            || self.is("named")
                && ["f_wrist", "f_elbow", "f_shoulder"].iter().any(|f| self.number(f).abs() < 1e-9)
    }
}
