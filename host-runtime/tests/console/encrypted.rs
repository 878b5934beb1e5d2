//! The console as it is served to other computers: over TLS, with a token.

use super::browser::{Browser, LONG, SPACE};
use super::driver::take_control;
use super::program::Program;
use super::turn;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const TOKEN: &str = "0123456789abcdef-of-the-tests";

/// A press or a reset that came to nothing on a busy computer is made again.
const AGAIN: Duration = Duration::from_secs(4);

/// The key and the certificate of a station, as an operator makes them.
fn keys_of_a_station(dir: &Path) -> [String; 2] {
    for made in [&["authority"][..], &["station", "arm"]] {
        let mut keys = Command::new(env!("CARGO_BIN_EXE_tetrad"));
        let made =
            keys.args(["keys", "--out", "."]).args(made).current_dir(dir).output().expect("the program");
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    }
    ["arm.key", "arm.pem"].map(|name| std::fs::read_to_string(dir.join(name)).expect("it was made"))
}

/// The page says so within a time.
fn says(browser: &Browser, what: &str, limit: Duration) -> bool {
    let began = Instant::now();
    while began.elapsed() < limit {
        if browser.text("#standing").contains(what) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

#[test]
fn over_tls_the_page_drives_as_it_does_in_clear() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::encrypted::over_tls_the_page_drives_as_it_does_in_clear")
    else {
        return;
    };
    let dir = tempfile::tempdir().expect("a directory");
    let [key, certificate] = keys_of_a_station(dir.path());
    let console = "token_file = \"token\"\ncertificate = \"arm.pem\"\nkey = \"arm.key\"\n";
    let program = Program::operator_with(
        console,
        &[("token", TOKEN), ("arm.key", key.as_str()), ("arm.pem", certificate.as_str())],
    );

    browser.go(&program.url("/drive"));
    browser.write("#token", TOKEN);
    browser.click("button[type=submit]");
    browser.until("location.protocol === 'https:' && location.pathname === '/'");
    let cookies = browser.cookies();
    let token = cookies.as_array().into_iter().flatten().find(|cookie| cookie["name"] == "tetrad_token");
    let token = token.unwrap_or_else(|| panic!("{cookies}"));
    assert_eq!([&token["secure"], &token["httpOnly"]], [true, true], "{token}");
    assert_eq!(token["sameSite"], "Strict", "{token}");

    take_control(&browser, &program.url("/drive"));
    let began = Instant::now();
    loop {
        browser.tap("r");
        let ready = says(&browser, "armed", AGAIN);
        browser.key_down(SPACE);
        if ready && says(&browser, "engaged", AGAIN) {
            break;
        }
        browser.key_up(SPACE);
        assert!(began.elapsed() < LONG, "the arm does not move:\n{}", browser.text("body"));
    }
    // pictures come over the same line
    browser.until(
        "[...document.querySelectorAll('.stamp')].some((stamp) => /\\d ms$/.test(stamp.innerText.trim()))",
    );
    browser.key_up(SPACE);
    assert!(says(&browser, "armed", LONG), "the stop:\n{}", browser.text("body"));
    assert!(program.end().moved());
}
