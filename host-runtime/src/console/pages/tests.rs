use super::*;
use std::collections::HashMap;

/// The custom properties of a block of the style.
fn colours(block: &str) -> HashMap<&str, [f64; 3]> {
    let channel = |hex: &str, at: usize| {
        let value = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
        if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let declarations = block.split([';', '{', '}']).filter_map(|line| line.trim().split_once(": #"));
    declarations
        .filter(|(name, _)| name.starts_with("--"))
        .map(|(name, hex)| (name, [0, 2, 4].map(|at| channel(hex, at))))
        .collect()
}

/// WCAG 2.2: relative luminance, and the ratio of two.
fn contrast(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let light = |[r, g, b]: &[f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05;
    light(a).max(light(b)) / light(a).min(light(b))
}

/// What is written in which colour on which ground, and the least contrast: 4.5 for text, 3 for what is drawn
/// (WCAG AA, 1.4.3 and 1.4.11).
const PAIRS: [(&str, &str, f64); 27] = [
    ("--text", "--back", 4.5),
    ("--text", "--panel", 4.5),
    ("--soft", "--back", 4.5),
    ("--soft", "--panel", 4.5),
    ("--link", "--back", 4.5),
    ("--link", "--panel", 4.5),
    ("--warn", "--panel", 4.5),
    ("--warn", "--back", 4.5),
    ("--go", "--panel", 4.5),
    ("--white", "--stop", 4.5),
    ("--stop", "--white", 4.5),
    ("--on-ball", "--red", 4.5),
    ("--on-ball", "--green", 4.5),
    ("--on-ball", "--blue", 4.5),
    ("--on-ball", "--yellow", 4.5),
    // the stamp of an old picture, over black
    ("--white", "--black", 4.5),
    // ghosts and edges of the scene
    ("--link", "--panel", 3.0),
    ("--warn", "--panel", 3.0),
    ("--text", "--panel", 3.0),
    ("--text", "--arm", 3.0),
    // the box in which the tool may be, and the ticks of a bar
    ("--edge", "--panel", 3.0),
    // curves of a scan
    ("--plot-red", "--panel", 3.0),
    ("--plot-green", "--panel", 3.0),
    ("--plot-blue", "--panel", 3.0),
    ("--plot-orange", "--panel", 3.0),
    // a bar's frame and its filling
    ("--soft", "--panel", 3.0),
    ("--link", "--panel", 3.0),
];

#[test]
fn what_is_written_can_be_read_in_the_light_and_in_the_dark() {
    let style = include_str!("../page/style.css");
    let (light, rest) = style.split_once("@media (prefers-color-scheme: dark) {").unwrap();
    let (dark, _) = rest.split_once("\n}").unwrap();
    let mut colours_now = colours(light);
    colours_now.extend([("--white", [1.0; 3]), ("--black", [0.0; 3])]);
    assert!(colours_now.len() > 12, "{colours_now:?}");
    for scheme in ["light", "dark"] {
        if scheme == "dark" {
            let dark = colours(dark);
            assert!(dark.len() > 8, "{dark:?}");
            colours_now.extend(dark);
        }
        for (ink, ground, least) in PAIRS {
            let ratio = contrast(&colours_now[ink], &colours_now[ground]);
            assert!(ratio >= least, "{ink} on {ground}, {scheme}: {ratio:.2} is below {least}");
        }
    }
}

/// What is written is as legible as the test above has it: it is never faded, on no page and in no state. Pictures may
/// be, where they are old.
#[test]
fn nothing_that_is_written_is_faded() {
    let styles: Vec<&Page> = PAGES.iter().filter(|page| page.path.ends_with(".css")).collect();
    assert!(styles.len() >= 4);
    for Page { path, content, .. } in styles {
        for rule in content.split('}') {
            let Some((selectors, declarations)) = rule.rsplit_once('{') else { continue };
            let fades =
                declarations.split(';').filter_map(|one| one.trim().split_once(':')).any(|(name, value)| {
                    let value = value.trim();
                    match name.trim() {
                        "opacity" => value != "1",
                        "filter" => value.contains("opacity"),
                        _ => false,
                    }
                });
            for selector in selectors.split(',').filter(|_| fades) {
                assert!(selector.trim().ends_with(" canvas"), "{path}: {selector} is faded");
            }
        }
    }
    // nor by a script
    for page in PAGES.iter().filter(|page| page.path.ends_with(".js")) {
        assert!(!page.content.contains(".opacity"), "{}", page.path);
    }
}

/// Whoever needs it finds it first, by keyboard too, on every page that has a link to the arm.
#[test]
fn stop_is_the_first_that_the_keyboard_reaches() {
    let with_live: Vec<&Page> = PAGES.iter().filter(|page| page.content.contains("id=\"link\"")).collect();
    assert!(with_live.len() >= 3);
    for page in with_live {
        let body = page.content.split_once("<body").unwrap().1;
        let reached = ["<a ", "<button", "<input", "<select", "<textarea", "<summary", "tabindex"];
        let first = reached.iter().filter_map(|mark| body.find(mark)).min().unwrap();
        assert!(body[first..].starts_with("<button id=\"stop\" "), "{}", page.path);
        assert!(!body.contains("tabindex=\"1\"") && !body.contains("autofocus"), "{}", page.path);
    }
}

/// Nothing that takes control to be of use looks as if it were before the page knows whether it has any: a press would
/// go nowhere.
#[test]
fn what_takes_control_is_disabled_until_the_page_knows_of_it() {
    for path in ["/drive", "/slave"] {
        let page = PAGES.iter().find(|page| page.path == path).unwrap();
        for id in ["take", "give", "reset", "hold", "hold-home", "less", "more"] {
            let button = page.content.split_once(&format!("<button id=\"{id}\"")).expect(id).1;
            assert!(button.split('>').next().unwrap().ends_with(" disabled"), "{path}: {id}");
        }
    }
}

/// A reader of the screen finds the page's name, and is told what changes: of a list's roles a status is none.
#[test]
fn every_page_has_one_name_and_no_list_is_a_status() {
    let signing_in = include_str!("../page/sign-in.html");
    let of_pages = PAGES.iter().filter(|page| page.kind == HTML).map(|page| (page.path, page.content));
    let all: Vec<_> = of_pages.chain([("/sign-in", signing_in)]).collect();
    assert!(all.len() >= 6);
    for (path, content) in all {
        assert_eq!(content.matches("<h1").count(), 1, "{path}");
        for list in ["<ul", "<ol", "<dl"] {
            for rest in content.split(list).skip(1) {
                let attributes = rest.split('>').next().unwrap();
                assert!(!attributes.contains("role="), "{path}: {list}{attributes}>");
            }
        }
    }
}

/// Names of elements that scripts look for are in the page that loads them.
#[test]
fn scripts_find_their_elements() {
    let of = |path: &str| PAGES.iter().find(|page| page.path == path).unwrap().content;
    for (page, scripts) in [
        ("/", &["/index.js"][..]),
        ("/setup", &["/setup.js", "/setup-view.js"]),
        ("/drive", &["/drive.js", "/controls.js"]),
        ("/slave", &["/slave.js", "/controls.js"]),
        ("/replay", &["/replay.js"]),
    ] {
        for script in scripts {
            for rest in of(script).split("find(\"").skip(1) {
                let id = rest.split('"').next().unwrap();
                // the one that a page may be without
                if id != "homed" {
                    assert!(of(page).contains(&format!("id=\"{id}\"")), "{id} of {script} is not in {page}");
                }
            }
        }
    }
}
