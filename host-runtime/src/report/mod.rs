//! A report out of plain numbers: tables as CSV, figures as SVG, and all of it as one HTML page.
//!
//! | what | file | becomes |
//! |---|---|---|
//! | rows of numbers | `table` | `NAME.csv`, a table of the page |
//! | curves and points | `figure` | `NAME.svg` (`svg`), an interactive plot of the page (`plot`) |
//! | headlines, sections | `page` | `index.html` |
//!
//! The page needs nothing but itself: styles, script and the plotting library are inside it. Where no
//! script runs, and on paper, the SVG pictures stand in the place of the plots.

mod figure;
pub mod ink;
mod page;
mod plot;
mod svg;
mod table;

pub use figure::{Axis, Figure, Look, Panel, Series, Shape};
pub(crate) use plot::script as plotly_script;
pub use table::{Cell, Table};

use crate::output::OutputError;
use std::path::Path;

/// The page's file.
pub const PAGE: &str = "index.html";

/// The headlines' file.
pub const HEADLINES: &str = "headlines.csv";

/// A whole report.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Above the page.
    pub title: String,
    /// Under the title: what this is, and how it is run again.
    pub lead: String,
    /// Under the first table: what its figures mean, a paragraph each.
    pub about: Vec<String>,
    /// The table a reader sees first.
    pub headlines: Table,
    /// The rest, in order.
    pub sections: Vec<Section>,
}

/// One experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its place in the page's address, a plain word.
    pub id: &'static str,
    /// What it is about.
    pub title: String,
    /// What is shown and how it was got.
    pub text: String,
    /// Numbers.
    pub tables: Vec<Table>,
    /// Pictures.
    pub figures: Vec<Figure>,
}

impl Report {
    /// Makes sure that a report can be written into `dir`, and removes the page and the headlines of an
    /// earlier one.
    ///
    /// # Errors
    /// [`OutputError`] naming the file.
    pub fn claim(dir: &Path) -> Result<(), OutputError> {
        for name in [PAGE, HEADLINES] {
            write(dir, name, "")?;
            let path = dir.join(name);
            std::fs::remove_file(&path).map_err(|cause| OutputError { path, cause })?;
        }
        Ok(())
    }

    /// The page alone, without files beside it.
    #[must_use]
    pub fn page(&self) -> String {
        page::html(self, page::Files::None)
    }

    /// Its plots for a page of somebody else, JSON: a list of sections with their `title` and `text`, and
    /// `panels` as plotly.js takes them.
    #[must_use]
    pub fn plots(&self) -> String {
        let sections = self.sections.iter().map(|section| {
            let panels = section.figures.iter().flat_map(|figure| &figure.panels).map(plot::json);
            let panels: Vec<String> = panels.collect();
            let [title, text] =
                [&section.title, &section.text].map(|text| serde_json::Value::from(text.as_str()));
            format!("{{\"title\":{title},\"text\":{text},\"panels\":[{}]}}", panels.join(","))
        });
        format!("[{}]", sections.collect::<Vec<_>>().join(","))
    }

    /// Writes every file of the report into `dir`.
    ///
    /// # Errors
    /// [`OutputError`] naming the file.
    pub fn write(&self, dir: &Path) -> Result<(), OutputError> {
        let tables = self.sections.iter().flat_map(|section| &section.tables);
        for table in std::iter::once(&self.headlines).chain(tables) {
            write(dir, &format!("{}.csv", table.name), &table.csv())?;
        }
        for figure in self.sections.iter().flat_map(|section| &section.figures) {
            write(dir, &format!("{}.svg", figure.name), &svg::draw(figure))?;
        }
        write(dir, PAGE, &page::html(self, page::Files::Beside))
    }
}

fn write(dir: &Path, name: &str, text: &str) -> Result<(), OutputError> {
    let path = dir.join(name);
    std::fs::write(&path, text).map_err(|cause| OutputError { path, cause })
}
