//! `tetrad evaluate`: every file is there and can be read, the page needs nothing but itself, and the same
//! seed gives the same tables. Scenes are cut to a few frames: what the figures are is not judged here.

mod common;

use common::tetrad;
use std::collections::BTreeMap;
use std::fs;
use tetrad::evaluate::{Evaluation, Plan, broken_promises};
use tetrad::report::Report;

/// All experiments, with three frames a scene.
fn report() -> Report {
    let evaluation = Evaluation::new(Plan { most_frames: Some(3), ..Plan::new(3, true) });
    evaluation.run(&|| ()).expect("every scene can be tracked")
}

/// The files of a report by name.
fn files(report: &Report) -> BTreeMap<String, String> {
    let dir = tempfile::tempdir().unwrap();
    report.write(dir.path()).unwrap();
    let entries = fs::read_dir(dir.path()).unwrap().map(Result::unwrap);
    entries
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap()))
        .collect()
}

/// The fields of a line; quotes as RFC 4180 has them.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields.last_mut().unwrap().push(c),
        }
    }
    assert!(!quoted, "{line}");
    fields
}

#[test]
fn every_file_is_there_and_the_same_seed_gives_the_same_tables() {
    let (whole, again) = (report(), files(&report()));
    let first = files(&whole);
    for figure in ["1", "2", "5", "6", "7", "8", "9"] {
        assert!(first.contains_key(&format!("figure-{figure}.svg")), "figure {figure}");
    }
    for table in [
        "headlines",
        "static",
        "dynamic",
        "paths",
        "drift",
        "conditions",
        "backdrops",
        "uncertainty",
        "smoothing",
        "delays",
    ] {
        let csv = &first[&format!("{table}.csv")];
        let mut lines = csv.lines().map(fields);
        let columns = lines.next().unwrap().len();
        let mut rows = 0;
        for row in lines {
            assert_eq!(row.len(), columns, "{table}: {row:?}");
            rows += 1;
        }
        assert!(rows > 0 && columns > 1, "{table}");
    }
    let tables = first.iter().filter(|(name, _)| name.ends_with(".csv") && *name != "delays.csv");
    for (name, text) in tables {
        assert_eq!(again[name], *text, "{name}");
    }
    // three frames do not reach the return
    let mut headlines = first["headlines.csv"].lines().map(fields);
    let back = headlines.find(|row| row[0].starts_with("Back at the start")).unwrap();
    assert!(back[2].starts_with("not measured") && back[4] == "NOT held", "{back:?}");
    assert!(broken_promises(&whole).iter().any(|what| what.starts_with("Back at the start")));
    for (name, svg) in first.iter().filter(|(name, _)| name.ends_with(".svg")) {
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && !svg.contains("NaN"), "{name}");
    }
    check_page(&first["index.html"], &first);
}

/// The page has every table and figure, and refers to nothing outside itself.
fn check_page(page: &str, files: &BTreeMap<String, String>) {
    assert!(page.contains("plotly.js v"), "the plotting library is in the page");
    // what is inside a script is no markup
    let mut markup = String::new();
    for part in page.split("</script>") {
        markup.push_str(part.split_once("<script").map_or(part, |(before, _)| before));
    }
    assert!(!markup.contains(" src="), "nothing is loaded");
    for reference in markup.split(" href=\"").skip(1) {
        let id = reference.strip_prefix('#').and_then(|id| id.split('"').next());
        let id = id.unwrap_or_else(|| panic!("a reference out of the page: {}", &reference[..40]));
        assert!(markup.contains(&format!("<section id=\"{id}\"")), "{id}");
    }
    for outside in ["url(", "@import", "<link"] {
        assert!(!markup.contains(outside), "{outside}");
    }
    assert!(!page.contains("<script src") && !page.contains("<script type=\"module\""));
    for name in files.keys().filter(|name| *name != "index.html") {
        assert!(markup.contains(name.as_str()), "{name} is not named on the page");
    }
}

#[test]
fn a_place_that_cannot_be_written_is_named_before_anything_is_run() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("taken"), "").unwrap();
    tetrad(dir.path(), "evaluate --quick --out taken").refused(2, &["taken"]);
    fs::create_dir_all(dir.path().join("out/index.html")).unwrap();
    tetrad(dir.path(), "evaluate --quick --out out").refused(1, &["index.html"]);
    // a directory that is there and takes no file, whoever asks
    tetrad(dir.path(), "evaluate --quick --out /proc/self").refused(1, &["/proc/self/index.html"]);
}
