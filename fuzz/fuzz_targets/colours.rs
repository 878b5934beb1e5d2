//! Any text as colours.toml: refused with a message that names the file, or colours that come back
//! the same when they are written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tetrad::colours::Colours;

fuzz_target!(|text: &str| {
    match Colours::parse(text, "left.toml") {
        Ok(colours) => {
            let again = Colours::parse(&colours.to_toml(), "left.toml");
            assert_eq!(again.as_ref(), Ok(&colours), "{text}");
        }
        Err(refused) => assert!(refused.to_string().contains("left.toml"), "{refused}"),
    }
});
