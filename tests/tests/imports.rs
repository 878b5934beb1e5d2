//! Promise: in core a module uses only modules before it on the path. No circles, no sideways reach.
//!
//! The order is that of the `mod` lines in `lib.rs`, `vision/mod.rs` and so on. Where the path has
//! stages inside a module (vision, hand, arm), that module comes after them; any other module and what
//! is below it are one stage.

use std::collections::HashMap;
use std::fs;
use tetrad_tests::repository;
use tetrad_tests::source::{code_only, without_tests};

/// The path as designed; what the code puts between these stages is its own affair.
const PATH: [&str; 17] = [
    "geometry",
    "vision::frame",
    "vision::colour",
    "vision::search",
    "vision::edges",
    "vision::centre",
    "vision::occlusion",
    "vision::validation",
    "vision::tracker",
    "hand::affine",
    "hand::orientation",
    "hand::motion",
    "wire",
    "arm::puma560",
    "arm::teleop",
    "arm::governor",
    "arm::port",
];

/// The code of a crate, test modules left out: module path ("" is `lib.rs`) to text.
struct Crate {
    code: HashMap<String, String>,
    groups: Vec<String>,
    /// Modules in the order of the path, each after its children.
    order: Vec<String>,
}

impl Crate {
    /// Follows the `mod` lines from `lib.rs` on; `read` gives a file's text by its path under `src`.
    fn load(read: &dyn Fn(&str) -> Option<String>) -> Self {
        let mut loaded = Self { code: HashMap::new(), groups: vec![String::new()], order: Vec::new() };
        loaded.add("", "lib.rs", read);
        loaded
    }

    fn add(&mut self, module: &str, file: &str, read: &dyn Fn(&str) -> Option<String>) {
        let text = read(file).unwrap_or_else(|| panic!("core/src/{file}: cannot be read"));
        let code = without_tests(&code_only(&text));
        for child in declared_modules(&code) {
            let path = if module.is_empty() { child.clone() } else { format!("{module}::{child}") };
            let base = path.replace("::", "/");
            let folder = format!("{base}/mod.rs");
            let file = if read(&folder).is_some() { folder } else { format!("{base}.rs") };
            if PATH.iter().any(|stage| stage.starts_with(&format!("{path}::"))) {
                self.groups.push(path.clone());
            }
            self.add(&path, &file, read);
        }
        self.code.insert(module.to_owned(), code);
        self.order.push(module.to_owned());
    }

    /// The stage that a path (module or item in one) belongs to.
    fn stage(&self, path: &str) -> String {
        let mut stage = String::new();
        for segment in path.split("::").filter(|segment| !segment.is_empty()) {
            let next = if stage.is_empty() { segment.to_owned() } else { format!("{stage}::{segment}") };
            if !self.code.contains_key(&next) || !self.groups.contains(&stage) {
                break;
            }
            stage = next;
        }
        stage
    }

    fn rank(&self, stage: &str) -> usize {
        self.order.iter().position(|module| module == stage).unwrap_or(usize::MAX)
    }

    /// Every import that points along the path instead of back, as `user -> used`.
    fn wrong_imports(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        for module in &self.order {
            let own = self.stage(module);
            for used in used_paths(module, &self.code[module]) {
                let stage = self.stage(&used);
                let re_export_of_a_child = self.groups.contains(&own) && stage.starts_with(&own);
                if stage != own && !re_export_of_a_child && self.rank(&stage) > self.rank(&own) {
                    wrong.push(format!("{own} -> {used}"));
                }
            }
        }
        wrong
    }
}

/// The names in `mod name;` lines, in order.
fn declared_modules(code: &str) -> Vec<String> {
    let words: Vec<&str> = code.split_whitespace().collect();
    let pairs = words.windows(2).filter(|pair| pair[0] == "mod");
    pairs.filter_map(|pair| pair[1].strip_suffix(';')).map(str::to_owned).collect()
}

/// Every `crate::...`, `super::...` and `self::...` path in `code`, made absolute; groups in braces
/// are written out.
fn used_paths(module: &str, code: &str) -> Vec<String> {
    let mut used = Vec::new();
    for (at, _) in code.match_indices("::") {
        let before = &code[..at];
        let word_start = before.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |i| i + 1);
        // Only the first word of a path: super::super is walked from its first super.
        if before[..word_start].ends_with("::") {
            continue;
        }
        let mut parents: Vec<&str> = module.split("::").filter(|segment| !segment.is_empty()).collect();
        match &before[word_start..] {
            "crate" => parents.clear(),
            "super" => drop(parents.pop()),
            "self" => {}
            _ => continue,
        }
        let mut tree = &code[at + 2..];
        while let Some(rest) = tree.strip_prefix("super::") {
            parents.pop();
            tree = rest;
        }
        expand(&parents.join("::"), &mut tree, &mut used);
    }
    used
}

/// Writes out one use tree: `a::b`, `a::{b, c::d}`, `*`.
fn expand(prefix: &str, tree: &mut &str, used: &mut Vec<String>) {
    *tree = tree.trim_start();
    if let Some(mut rest) = tree.strip_prefix('{') {
        loop {
            expand(prefix, &mut rest, used);
            rest = rest.trim_start();
            match rest.strip_prefix(',') {
                Some(next) if !next.trim_start().starts_with('}') => rest = next,
                _ => break,
            }
        }
        rest = rest.trim_start_matches([',', ' ', '\n']);
        *tree = rest.strip_prefix('}').unwrap_or(rest);
        return;
    }
    let end = tree.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(tree.len());
    let (name, rest) = tree.split_at(end);
    let path = match (prefix, name) {
        (_, "" | "self") => prefix.to_owned(),
        ("", name) => name.to_owned(),
        (prefix, name) => format!("{prefix}::{name}"),
    };
    *tree = rest.strip_prefix('*').unwrap_or(rest);
    if let Some(rest) = tree.strip_prefix("::") {
        *tree = rest;
        expand(&path, tree, used);
        return;
    }
    if let Some(rest) = tree.trim_start().strip_prefix("as ") {
        *tree = rest.trim_start().trim_start_matches(|c: char| c.is_alphanumeric() || c == '_');
    }
    used.push(path);
}

fn core() -> Crate {
    let source = repository().join("core/src");
    Crate::load(&|file| fs::read_to_string(source.join(file)).ok())
}

#[test]
fn core_imports_point_back_along_the_path() {
    let wrong = core().wrong_imports();
    assert!(wrong.is_empty(), "a module uses only modules before it:\n{}", wrong.join("\n"));
}

#[test]
fn the_modules_stand_in_the_order_of_the_path() {
    let core = core();
    let ranks: Vec<(usize, &str)> =
        PATH.iter().filter(|stage| core.code.contains_key(**stage)).map(|s| (core.rank(s), *s)).collect();
    assert!(ranks.len() >= 10, "the path has lost its stages: {ranks:?}");
    assert!(ranks.is_sorted(), "reorder the mod lines: {ranks:?}");
}

fn made_up(files: &[(&str, &str)]) -> Vec<String> {
    let files: HashMap<&str, &str> = files.iter().copied().collect();
    Crate::load(&|file| files.get(file).map(|text| (*text).to_owned())).wrong_imports()
}

const LIB: (&str, &str) = ("lib.rs", "pub mod base;\n\npub mod vision;\n\npub mod wire;");
const VISION: (&str, &str) = ("vision/mod.rs", "pub mod frame;\n\npub mod colour;\npub use colour::Eq;");
const EMPTY: [(&str, &str); 3] = [("base.rs", ""), ("wire.rs", ""), ("vision/frame.rs", "")];

#[test]
fn a_right_import_is_let_through() {
    let colour = "use super::frame::{self, F};\nuse crate::base::{A, B as C};\n
        // use crate::wire::X;\npub(super) fn f() { let _ = crate::base::k::<u8>(); }
        #[cfg(test)]\nmod tests { use crate::wire::W; }";
    let files = [LIB, VISION, EMPTY[0], EMPTY[1], EMPTY[2], ("vision/colour.rs", colour)];
    assert_eq!(made_up(&files), Vec::<String>::new());
}

#[test]
fn a_wrong_import_is_caught_however_it_is_written() {
    let ways = [
        ("use crate::wire::W;", "wire::W"),
        ("use super::super::wire;", "wire"),
        ("use crate::{base::A, wire::{V, W}};", "wire::V"),
        ("fn f() -> crate::wire::W { }", "wire::W"),
        ("use super::{frame::F, Eq};", "vision::Eq"),
        ("use crate::{\n    base,\n    wire,\n};", "wire"),
        ("use crate::Anything;", "Anything"),
    ];
    for (way, target) in ways {
        let files = [LIB, VISION, EMPTY[0], EMPTY[1], EMPTY[2], ("vision/colour.rs", way)];
        let wrong = made_up(&files);
        assert!(wrong.contains(&format!("vision::colour -> {target}")), "{way}: {wrong:?}");
    }
}

#[test]
fn a_stage_may_be_split_into_files_below_it() {
    let files = [
        LIB,
        VISION,
        ("base.rs", "mod part;\nuse part::P;\nuse self::part::Q;"),
        ("base/part.rs", "use super::A;"),
        EMPTY[1],
        EMPTY[2],
        ("vision/colour.rs", ""),
    ];
    assert_eq!(made_up(&files), Vec::<String>::new());
    let files =
        files.map(|(file, text)| (file, if file == "base/part.rs" { "use crate::wire::W;" } else { text }));
    assert_eq!(made_up(&files), ["base -> wire::W"]);
}
