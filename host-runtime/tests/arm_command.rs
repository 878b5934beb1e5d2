//! `tetrad arm fk | ik` as a script uses it, against published kinematics of the same arm.

mod common;

use common::{command, tetrad_with_input};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::PathBuf;
use std::process::Stdio;

const POSE: [&str; 12] = ["x", "y", "z", "r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];

/// The same numbers in the tables that are compared with.
const ORACLE: [&str; 12] =
    ["T14", "T24", "T34", "T11", "T12", "T13", "T21", "T22", "T23", "T31", "T32", "T33"];

const JOINTS: [&str; 6] = ["q1", "q2", "q3", "q4", "q5", "q6"];

/// A row by the names of its columns.
type Row = HashMap<String, String>;

fn rows(text: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {row:?}"))
}

fn numbers<const N: usize>(row: &Row, columns: [&str; N]) -> [f64; N] {
    columns.map(|column| number(row, column))
}

fn largest_difference<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The largest difference of angles, whole turns aside.
fn turned(a: [f64; 6], b: [f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).sin().atan2((a - b).cos()).abs()).fold(0.0, f64::max)
}

/// cases.csv of the repository, and of the whole set if it is there.
fn oracles(test: &str) -> Vec<Vec<Row>> {
    let mut files: Vec<PathBuf> = vec![tetrad_fixtures::golden::data("puma560/cases.csv")];
    match tetrad_tests::shared() {
        Some(shared) => files.push(shared.join("data/puma560/cases.csv")),
        None => tetrad_tests::skip(
            &format!("{test} (all rows)"),
            "no shared data; name its folder in TETRAD_SHARED",
        ),
    }
    files.iter().map(|file| rows(&std::fs::read_to_string(file).expect("the table is there"))).collect()
}

/// The table of some columns of these rows, under other names.
fn table<const N: usize>(rows: &[Row], columns: [&str; N], names: [&str; N]) -> String {
    let mut text = format!("case,{}\n", names.join(","));
    for row in rows {
        let _ = writeln!(text, "{},{}", row["id"], columns.map(|column| row[column].as_str()).join(","));
    }
    text
}

#[test]
fn every_solution_of_every_reachable_pose_leads_back_to_it() {
    for oracle in oracles("every_solution_of_every_reachable_pose_leads_back_to_it") {
        let cases: HashMap<&str, &Row> = oracle.iter().map(|row| (row["id"].as_str(), row)).collect();
        let poses = table(&oracle, ORACLE, POSE);
        let solved = tetrad_with_input("arm ik --tool none", poses.as_bytes()).done().stdout;
        let header = "case,solution,shoulder,elbow,wrist,q1,q2,q3,q4,q5,q6,in_range,reason";
        assert_eq!(solved.lines().next(), Some(header));
        let placed = tetrad_with_input("arm fk --tool none", solved.as_bytes()).done().stdout;
        let placed = rows(&placed);

        let mut solutions: HashMap<&str, Vec<&Row>> = HashMap::new();
        for row in &placed {
            solutions.entry(&row["case"]).or_default().push(row);
        }
        let mut reachable = 0;
        for (case, expected) in &cases {
            let found = &solutions[case];
            if expected["kind"] == "unreachable" {
                assert_eq!(found.len(), 1, "{expected:?}");
                assert!(found[0]["reason"].starts_with("out of reach: "), "{found:?}");
                let empty = ["solution", "shoulder", "q1", "in_range", "x", "r33"];
                assert!(empty.iter().all(|column| found[0][*column].is_empty()), "{found:?}");
                continue;
            }
            reachable += 1;
            for (place, solution) in (1..).zip(found) {
                let off = largest_difference(numbers(solution, POSE), numbers(expected, ORACLE));
                assert!(off < 1e-9, "case {case} solution {place}: {off}");
                assert_eq!((&solution["solution"], solution["reason"].as_str()), (&format!("{place}"), ""));
                if expected["kind"] == "random" {
                    assert_eq!(found.len(), 8, "case {case}");
                    let branch = branch(solution);
                    let angles = JOINTS.map(|joint| format!("{branch}_{joint}"));
                    let oracle = numbers(expected, std::array::from_fn(|joint| angles[joint].as_str()));
                    assert!(turned(numbers(solution, JOINTS), oracle) < 1e-9, "case {case} {branch}");
                    let in_range = expected[&format!("{branch}_inlim")].as_str();
                    let agrees =
                        matches!((solution["in_range"].as_str(), in_range), ("true", "1") | ("false", "0"));
                    assert!(agrees, "case {case} {branch}: {} {in_range}", solution["in_range"]);
                }
            }
        }
        assert!(reachable > 50 && reachable < cases.len(), "{reachable} of {}", cases.len());
    }
}

/// The oracle's name for how the arm stands.
fn branch(solution: &Row) -> String {
    let first = |column: &str| solution[column].chars().next().unwrap_or_default();
    format!("{}{}{}", first("shoulder"), first("elbow"), first("wrist"))
}

#[test]
fn the_pose_of_every_row_of_joints_is_the_published_one() {
    for oracle in oracles("the_pose_of_every_row_of_joints_is_the_published_one") {
        let oracle: Vec<Row> = oracle.into_iter().filter(|row| !row["q1"].is_empty()).collect();
        let placed =
            tetrad_with_input("arm fk --tool none", table(&oracle, JOINTS, JOINTS).as_bytes()).done();
        let placed = rows(&placed.stdout);
        assert_eq!(placed.len(), oracle.len());
        for (row, expected) in placed.iter().zip(&oracle) {
            assert_eq!(row["case"], expected["id"]);
            let off = largest_difference(numbers(row, POSE), numbers(expected, ORACLE));
            assert!(off < 1e-12, "row {}: {off}", row["case"]);
        }
    }
}

const HOME: &str = "q1,q2,q3,q4,q5,q6\n0,0.7853981633974483,-3.141592653589793,0,0.7853981633974483,0\n";

#[test]
fn the_tool_is_the_flange_unless_another_is_asked_for() {
    let x = |arguments: &str| {
        let ran = tetrad_with_input(arguments, HOME.as_bytes()).done();
        number(&rows(&ran.stdout)[0], "x")
    };
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("tetrad.toml");
    std::fs::write(&config, "[arm]\ntool_mm = [0, 0, 100]\n").unwrap();
    let config = config.display();
    let bare = x("arm fk --tool none");
    assert!((x("arm fk") - bare - 0.05625).abs() < 1e-12);
    assert!((x("arm fk --tool flange") - bare - 0.05625).abs() < 1e-12);
    assert!((x(&format!("arm fk --config {config}")) - bare - 0.1).abs() < 1e-12);
    assert!((x(&format!("arm fk --tool none --config {config}")) - bare).abs() < 1e-12);
}

#[test]
fn other_columns_and_their_order_are_kept_by_fk() {
    let input =
        "\u{feff}note, q6 ,q5,q4,q3,q2,q1,t\r\n\"a, \"\"b\"\"\",0,0,0,0,0,0,0.10\r\n\r\nc,,, ,,,,\r\n";
    let ran = tetrad_with_input("arm fk --tool none", input.as_bytes()).done();
    let expected = "note, q6 ,q5,q4,q3,q2,q1,t,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33\n\
                    \"a, \"\"b\"\"\",0,0,0,0,0,0,0.10,0.4521,-0.15005,1.10363,1,0,0,0,1,0,0,0,1\n\
                    c,,, ,,,,,,,,,,,,,,,,\n";
    assert_eq!(ran.stdout, expected);
}

#[test]
fn a_pose_without_a_solution_in_range_says_so() {
    let poses = tetrad_with_input("arm fk", HOME.as_bytes()).done().stdout;
    let count = |arguments: &str| rows(&tetrad_with_input(arguments, poses.as_bytes()).done().stdout).len();
    assert_eq!(count("arm ik"), 8);
    assert!((1..8).contains(&count("arm ik --in-range")));
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("tetrad.toml");
    std::fs::write(
        &config,
        "[arm]\nmin_deg = [100, -45, -225, -110, -100, -266]\nmax_deg = [101, 225, 45, 170, 100, 266]\n",
    )
    .unwrap();
    let arguments = format!("arm ik --in-range --config {}", config.display());
    let ran = tetrad_with_input(&arguments, poses.as_bytes()).done();
    assert_eq!(ran.stdout.lines().nth(1), Some("1,,,,,,,,,,,,every solution has a joint out of its range"));
}

#[test]
fn what_is_wrong_is_named_by_line_and_column_after_the_rows_before_it() {
    let fk = |input: &str, words: &[&str]| tetrad_with_input("arm fk", input.as_bytes()).refused(2, words);
    fk("", &["nothing came on standard input", "q1,q2,q3,q4,q5,q6"]);
    fk("q1,q2,q3,q4,q5\n", &["line 1", "no column q6", "q1, q2"]);
    fk("q1;q2;q3;q4;q5;q6\n", &["no column q1", "commas"]);
    fk("q1,q2,q3,q4,q5,q6,q1\n", &["line 1", "two columns are called q1"]);
    fk("q1,q2,q3,q4,q5,q6,x\n", &["line 1", "there is a column x already"]);
    let ran =
        fk(&format!("{HOME}1,2,x,4,5,6\n1,2,3,4,5,6\n"), &["line 3, column q3: 'x' is no finite number"]);
    assert_eq!(ran.stdout.lines().count(), 2);
    fk(&format!("{HOME}1,2,3,4,NaN,6\n"), &["line 3, column q5: 'NaN'"]);
    fk(&format!("{HOME}1,2,3,4,,6\n"), &["line 3, column q5: ''"]);
    fk(&format!("{HOME}1,2,3,4,5,inf\n"), &["line 3, column q6: 'inf'"]);
    fk(&format!("{HOME}1,2,3,4,5\n"), &["line 3: 5 fields, but the header has 6"]);
    let beyond = ["line 3, column q2: '1e308'", "radians, from -1000 to 1000"];
    fk(&format!("{HOME}0,1e308,1e308,0,0,0\n"), &beyond);
    fk(&format!("{HOME}0,0,0,0,0,-1000.5\n"), &["line 3, column q6: '-1000.5'"]);
    assert!(
        !tetrad_with_input("arm fk", format!("{HOME}1000,-1000,1000,0,0,0\n").as_bytes())
            .done()
            .stdout
            .contains("NaN")
    );
    tetrad_with_input("arm fk", b"q1,q2,q3,q4,q5,q6\n0,0,0,0,0,\xff\n").refused(2, &["line 2", "UTF-8"]);

    let ik = |rows: &str, words: &[&str]| {
        let input = format!("case,{}\na,0.5,0,0.5,1,0,0,0,1,0,0,0,1\n{rows}", POSE.join(","));
        let ran = tetrad_with_input("arm ik", input.as_bytes()).refused(2, words);
        assert!(
            ran.stdout.lines().count() > 1 && ran.stdout.lines().skip(1).all(|row| row.starts_with("a,"))
        );
    };
    ik("b,0.5,0,0.5,1,0,0,0,1,0,0,0,-1\n", &["line 3", "right-handed", "r11 to r33"]);
    ik("b,0.5,0,0.5,1.2,0,0,0,1,0,0,0,1\n", &["line 3", "orthonormal"]);
    ik("b,0.5,nan,0.5,1,0,0,0,1,0,0,0,1\n", &["line 3, column y: 'nan'"]);
    ik("b,0.5,0,-1e308,1,0,0,0,1,0,0,0,1\n", &["line 3, column z: '-1e308'", "metres"]);
    ik("b,0.5,0,0.5,1e308,0,0,0,1,0,0,0,1\n", &["line 3", "orthonormal"]);
    ik("b,,,,,,,,,,,,\n", &["line 3", "the pose is empty"]);
}

#[test]
fn settings_that_are_wrong_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("tetrad.toml");
    std::fs::write(&config, "[arm]\nforearm_m = 0.4\n").unwrap();
    let arguments = format!("arm fk --config {}", config.display());
    tetrad_with_input(&arguments, HOME.as_bytes()).refused(2, &["tetrad.toml", "forearm_m", "line 2"]);
    tetrad_with_input("arm fk --config nowhere.toml", b"").refused(2, &["cannot read nowhere.toml"]);
}

#[test]
fn rows_are_answered_as_they_come() {
    let mut program =
        command("arm fk").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the program starts");
    let mut input = program.stdin.take().expect("a pipe");
    let mut answers = BufReader::new(program.stdout.take().expect("a pipe")).lines();
    let mut ask = |line: &str| {
        writeln!(input, "{line}").expect("it reads");
        answers.next().expect("an answer").expect("text")
    };
    // each answer is waited for before the next line is sent
    assert!(ask("q1,q2,q3,q4,q5,q6").ends_with("r33"));
    for angle in ["0.1", "0.2", "0.3"] {
        assert!(ask(&format!("{angle},0,0,0,0,0")).starts_with(&format!("{angle},0,0,0,0,0,0.")));
    }
    drop(input);
    assert!(program.wait().expect("it ends").success());
}
