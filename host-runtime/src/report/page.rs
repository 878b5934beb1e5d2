//! The page: headlines first, then every section with its plots and tables.

use super::figure::Figure;
use super::svg::{self, escape};
use super::{Cell, Report, Section, Table, plot};
use std::fmt::Write as _;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Tables with more rows than that are folded away.
const FOLDED: usize = 16;

/// Whether figures and tables are in files beside the page too, whose names then stand in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Files {
    Beside,
    None,
}

impl Files {
    /// The name of one, behind a caption.
    fn name(self, name: &str, ending: &str) -> String {
        match self {
            Self::Beside => format!(" ({name}.{ending})"),
            Self::None => String::new(),
        }
    }
}

/// The whole page.
pub(super) fn html(report: &Report, files: Files) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
        title = escape(&report.title)
    );
    let _ = writeln!(page, "<p class=\"about\">{}</p>\n<div id=\"headlines\">", escape(&report.lead));
    push_table(&mut page, &report.headlines, false, files);
    page.push_str("</div>\n");
    for line in &report.about {
        let _ = writeln!(page, "<p class=\"about\">{}</p>", escape(line));
    }
    page.push_str("<nav>\n");
    for Section { id, title, .. } in &report.sections {
        let _ = writeln!(page, "<a href=\"#{id}\">{}</a>", escape(title));
    }
    page.push_str("</nav>\n");
    for section in &report.sections {
        let (id, title, text) = (section.id, escape(&section.title), escape(&section.text));
        let _ = writeln!(page, "<section id=\"{id}\">\n<h2>{title}</h2>\n<p>{text}</p>");
        for figure in &section.figures {
            push_figure(&mut page, figure, files);
        }
        for table in &section.tables {
            push_table(&mut page, table, table.rows.len() > FOLDED, files);
        }
        page.push_str("</section>\n");
    }
    let library = plot::script();
    let _ = writeln!(page, "<script>{library}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>");
    page
}

fn push_figure(page: &mut String, figure: &Figure, files: Files) {
    let alone = if figure.panels.len() == 1 { " class=\"alone\"" } else { "" };
    let _ = writeln!(page, "<figure{alone}>\n<div class=\"plots\">");
    for panel in &figure.panels {
        let json = plot::json(panel);
        let _ = writeln!(page, "<div class=\"plot\"><script type=\"application/json\">{json}</script></div>");
    }
    let (still, caption, name) = (svg::draw(figure), escape(&figure.caption), files.name(figure.name, "svg"));
    let _ = writeln!(
        page,
        "</div>\n<div class=\"still\">{still}</div>\n<figcaption>{caption}{name}</figcaption>\n</figure>"
    );
}

fn push_table(page: &mut String, table: &Table, folded: bool, files: Files) {
    let caption = format!("{}{}", table.caption, files.name(table.name, "csv"));
    let caption = escape(&caption);
    if folded {
        let _ = writeln!(page, "<details><summary>{caption}</summary>");
    }
    page.push_str("<div class=\"table\"><table>\n");
    if !folded {
        let _ = writeln!(page, "<caption>{caption}</caption>");
    }
    page.push_str("<thead><tr>");
    let numeric = |column: usize| {
        table.rows.first().is_some_and(|row| matches!(row.get(column), Some(Cell::Number(..))))
    };
    let class = |number: bool| if number { " class=\"n\"" } else { "" };
    for (index, column) in table.columns.iter().enumerate() {
        let _ = write!(page, "<th{}>{}</th>", class(numeric(index)), escape(column));
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        page.push_str("<tr>");
        for (cell, column) in row.iter().zip(&table.columns) {
            let number = matches!(cell, Cell::Number(..));
            // on a narrow window a row of the first table is a list, and needs the column's name
            let (class, name) = (class(number), escape(column));
            let _ = write!(page, "<td{class} data-column=\"{name}\">{}</td>", escape(&cell.text()));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table></div>\n");
    if folded {
        page.push_str("</details>\n");
    }
}
