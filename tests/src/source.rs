//! Rust source with what is not code blanked out, for the checks that read the code as text.

/// `text` with comments, string and character literals replaced by spaces: line and column of what
/// is left stay where they were.
///
/// Enough of Rust's lexical rules for this workspace: nested block comments, raw and byte strings,
/// and lifetimes told from character literals.
#[must_use]
pub fn code_only(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let blank = skipped_length(rest, code.chars().next_back());
        let (piece, after) = rest.split_at(if blank > 0 { blank } else { first.len_utf8() });
        if blank > 0 {
            code.extend(piece.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        } else {
            code.push_str(piece);
        }
        rest = after;
    }
    code
}

/// How many bytes at the start of `rest` are a comment or a literal; `before` is the character in
/// front of them.
fn skipped_length(rest: &str, before: Option<char>) -> usize {
    if rest.starts_with("//") {
        return rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return block_comment_length(rest);
    }
    if let Some(body) = rest.strip_prefix('"') {
        return 1 + string_length(body);
    }
    if rest.starts_with('\'') {
        return character_length(rest);
    }
    // r"..", r#".."#, br"..": not the end of a name such as `for`.
    let in_name = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
    if !in_name {
        let raw = rest.strip_prefix("br").or_else(|| rest.strip_prefix('r'));
        if let Some(raw) = raw {
            let hashes = raw.len() - raw.trim_start_matches('#').len();
            if raw[hashes..].starts_with('"') {
                let close = format!("\"{}", "#".repeat(hashes));
                let opened = rest.len() - raw.len() + hashes + 1;
                let body = &rest[opened..];
                return opened + body.find(&close).map_or(body.len(), |at| at + close.len());
            }
        }
    }
    0
}

fn block_comment_length(rest: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < rest.len() {
        if rest[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += rest[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    rest.len()
}

/// The length of a string's body and closing quote.
fn string_length(body: &str) -> usize {
    let mut escaped = false;
    for (at, c) in body.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    body.len()
}

/// The length of a character literal, or 0 where the quote starts a lifetime.
fn character_length(rest: &str) -> usize {
    let mut chars = rest.char_indices().skip(1);
    match chars.next() {
        Some((_, '\\')) => {
            // The character after the backslash may itself be a quote.
            chars.next();
            chars.find(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1)
        }
        Some(_) => match chars.next() {
            Some((at, '\'')) => at + 1,
            _ => 0,
        },
        None => 0,
    }
}

/// `code` (see [`code_only`]) without its `#[cfg(test)]` items.
#[must_use]
pub fn without_tests(code: &str) -> String {
    let mut kept = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        let (before, item) = rest.split_at(at);
        kept.push_str(before);
        rest = &item[item_length(item)..];
    }
    kept.push_str(rest);
    kept
}

/// The length of an item: to its `;`, or to the brace that closes its first one.
fn item_length(item: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in item.char_indices() {
        match c {
            ';' if depth == 0 => return at + 1,
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return at + 1;
                }
            }
            _ => {}
        }
    }
    item.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_are_blanked_and_columns_kept() {
        let text = "let a = \"// no\"; // yes\nlet b = '\"'; /* a /* b */ c */ let c: &'a str = r#\"x\"y\"#;";
        let code = code_only(text);
        assert_eq!(code.len(), text.len());
        assert_eq!(code.lines().count(), 2);
        assert_eq!(
            code.split_whitespace().collect::<Vec<_>>().join(" "),
            "let a = ; let b = ; let c: &'a str = ;"
        );
        assert_eq!(code.find("let c"), text.find("let c"));
    }

    #[test]
    fn escapes_do_not_end_a_literal_early() {
        let code = code_only(r#"a('\'', "\"", '\\', 'x') + unsafe_name"#);
        assert_eq!(code.split_whitespace().collect::<String>(), "a(,,,)+unsafe_name");
        assert!(code_only(r#""\\" unsafe"#).contains("unsafe"));
    }

    #[test]
    fn test_modules_are_dropped_whole() {
        let code =
            "use a;\n#[cfg(test)]\nmod tests { fn f() { if x { } } }\nuse b;\n#[cfg(test)]\nmod t;\nuse c;";
        let kept = without_tests(code);
        assert_eq!(kept.split_whitespace().collect::<String>(), "usea;useb;usec;");
    }
}
