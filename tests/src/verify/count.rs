//! What a check found, and how the results of `cargo test` are counted.

/// Lines shown of what a failed test printed.
const FAILURE_LINES: usize = 20;

/// Something that was not checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skip {
    /// Which check or test.
    pub name: String,
    /// What this machine lacks.
    pub why: String,
}

/// What a check, or all of them, found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// How many passed.
    pub passed: u32,
    /// How many failed.
    pub failed: u32,
    /// What was skipped, by name.
    pub skipped: Vec<Skip>,
    /// What a reader should see now: the end of the log of a failure, or figures.
    pub report: String,
}

impl Outcome {
    /// One check that passed.
    #[must_use]
    pub fn pass() -> Self {
        Self { passed: 1, ..Self::default() }
    }

    /// One check that failed, and what to show of it.
    #[must_use]
    pub fn fail(report: impl Into<String>) -> Self {
        Self { failed: 1, report: report.into(), ..Self::default() }
    }

    /// One check that could not run here.
    #[must_use]
    pub fn skip(name: &str, why: impl Into<String>) -> Self {
        Self { skipped: vec![Skip { name: name.into(), why: why.into() }], ..Self::default() }
    }

    /// The same with something to show.
    #[must_use]
    pub fn showing(mut self, report: impl Into<String>) -> Self {
        self.report = report.into();
        self
    }

    /// Adds the counts of `other`; reports are shown where they arise and not kept.
    pub fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped.extend(other.skipped);
    }

    /// The result in a word or two, for the line of the check.
    #[must_use]
    pub fn summary(&self) -> String {
        match (self.passed, self.failed, self.skipped.as_slice()) {
            (1, 0, []) => "ok".into(),
            (0, 1, []) => "FAILED".into(),
            (0, 0, [only]) => format!("skipped: {}", only.why),
            (_, 0, _) => format!("ok: {}", self.counts()),
            _ => format!("FAILED: {}", self.counts()),
        }
    }

    /// The plain count line.
    #[must_use]
    pub fn counts(&self) -> String {
        format!("{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped.len())
    }
}

/// Reads what `cargo test` printed, and the lines that skipped tests left in the skip log.
///
/// libtest counts a test that calls [`crate::skip`] as passed; here it is skipped, and so is an
/// ignored one. `succeeded` is cargo's exit code: a run that failed without a failed test (it did not
/// compile, or a test process died) counts one failure.
#[must_use]
pub(super) fn of_cargo_test(output: &str, skip_log: &str, succeeded: bool) -> Outcome {
    let mut outcome = Outcome::default();
    let mut failed = Vec::new();
    for line in output.lines() {
        if let Some(counts) = line.strip_prefix("test result: ") {
            outcome.passed += number_before(counts, " passed");
            outcome.failed += number_before(counts, " failed");
        } else if let Some(test) = line.strip_prefix("test ") {
            if let Some(name) = test.strip_suffix(" ... FAILED") {
                failed.push(name);
            } else if let Some((name, why)) = test.split_once(" ... ignored") {
                let why = why.strip_prefix(", ").unwrap_or("marked as ignored");
                outcome.skipped.push(Skip { name: name.into(), why: why.into() });
            }
        }
    }
    for line in skip_log.lines() {
        if let Some((name, why)) = line.strip_prefix("SKIPPED ").and_then(|rest| rest.split_once(": ")) {
            outcome.passed = outcome.passed.saturating_sub(1);
            outcome.skipped.push(Skip { name: name.into(), why: why.into() });
        }
    }
    if !succeeded && outcome.failed == 0 {
        outcome.failed = 1;
    }
    outcome.report = failed.iter().map(|name| said_by(name, output)).collect();
    outcome
}

/// What a failed test printed, shortened: what libtest kept of it, or, where it keeps nothing (`--nocapture`),
/// the panic and what came after it.
fn said_by(name: &str, output: &str) -> String {
    let kept = output.split_once(&format!("---- {name} stdout ----\n")).map(|(_, after)| after);
    let said = kept.or_else(|| {
        let panic = output.find(&format!("thread '{name}' "))?;
        output.get(panic..)
    });
    let is_of_it =
        |line: &&str| !line.starts_with("---- ") && !line.starts_with("test ") && *line != "failures:";
    let lines = said.unwrap_or_default().lines().take_while(is_of_it);
    let lines: String = lines.take(FAILURE_LINES).map(|line| format!("  {line}\n")).collect();
    format!("FAILED {name}\n{lines}")
}

/// The number in front of `label` in `ok. 3 passed; 0 failed; ...`, 0 where there is none.
fn number_before(counts: &str, label: &str) -> u32 {
    counts
        .split(label)
        .next()
        .and_then(|before| before.rsplit([' ', ';']).next())
        .and_then(|digits| digits.parse().ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = "\
running 3 tests
test a::b ... ok
test a::c ... FAILED
test d ... ignored, needs a camera

failures:

---- a::c stdout ----
assertion failed: left == right

failures:
    a::c

test result: FAILED. 12 passed; 1 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.00s
test result: ok. 5 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s
";

    #[test]
    fn every_cargo_test_is_counted() {
        let outcome = of_cargo_test(OUTPUT, "", false);
        assert_eq!((outcome.passed, outcome.failed), (17, 1));
        assert_eq!(outcome.skipped, [Skip { name: "d".into(), why: "needs a camera".into() }]);
        assert_eq!(outcome.report, "FAILED a::c\n  assertion failed: left == right\n  \n");
    }

    #[test]
    fn a_panic_is_shown_where_nothing_was_kept_of_a_test() {
        let output = "\
running 2 tests
thread 'a::b' (17) panicked at tests/a.rs:3:5:
assertion `left == right` failed
test a::b ... FAILED
test a::c ... ok

failures:
    a::b

test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s
";
        let shown = "FAILED a::b\n  thread 'a::b' (17) panicked at tests/a.rs:3:5:\n  assertion `left == right` failed\n";
        assert_eq!(of_cargo_test(output, "", false).report, shown);
    }

    #[test]
    fn a_test_that_skipped_itself_has_not_passed() {
        let log = "SKIPPED footage: no ../shared\nSKIPPED arm: none: at all\n";
        let outcome = of_cargo_test(OUTPUT, log, false);
        assert_eq!(outcome.passed, 15);
        assert_eq!(outcome.skipped.len(), 3);
        assert_eq!(outcome.skipped[2], Skip { name: "arm".into(), why: "none: at all".into() });
    }

    #[test]
    fn a_run_that_did_not_compile_is_a_failure() {
        assert_eq!(of_cargo_test("error: no such thing", "", false).failed, 1);
        assert_eq!(of_cargo_test("", "", true).failed, 0);
    }

    #[test]
    fn counts_and_summaries() {
        let mut total = Outcome::pass();
        assert_eq!(total.summary(), "ok");
        total.add(Outcome::skip("x", "no y"));
        assert_eq!(total.summary(), "ok: 1 passed, 0 failed, 1 skipped");
        total.add(Outcome::fail("z"));
        assert_eq!(total.counts(), "1 passed, 1 failed, 1 skipped");
        assert_eq!(Outcome::skip("x", "no y").summary(), "skipped: no y");
    }
}
