//! Cuts away what is compiled for unit tests only.

use crate::lexer::{Token, depth_change, group_end};

/// The tokens of a file without its tests.
#[derive(Debug, Default)]
pub(crate) struct Cut {
    pub(crate) tokens: Vec<Token>,
    /// Modules declared by `#[cfg(test)] mod name;`.
    pub(crate) test_modules: Vec<String>,
    /// Lines that are cut away.
    pub(crate) test_lines: usize,
}

/// Leaves out every item under `#[cfg(test)]`.
pub(crate) fn without_tests(tokens: &[Token]) -> Cut {
    let mut cut = Cut::default();
    let mut at = 0;
    while at < tokens.len() {
        let Some(behind) = test_attribute(tokens, at) else {
            cut.tokens.push(tokens[at].clone());
            at += 1;
            continue;
        };
        let begin = head(tokens, behind);
        let end = item_end(tokens, begin);
        if let [keyword, name, mark, ..] = &tokens[begin.min(end)..]
            && keyword.is("mod")
            && mark.is(";")
        {
            cut.test_modules.push(name.text.clone());
        }
        cut.test_lines += tokens[end - 1].line - tokens[at].line + 1;
        at = end;
    }
    cut
}

/// Behind the attribute at `at`, if it is a `#[cfg(test)]`, be it one condition of an `all(…)`.
fn test_attribute(tokens: &[Token], at: usize) -> Option<usize> {
    let inside = ["#", "[", "cfg", "("];
    if !inside.iter().enumerate().all(|(n, word)| tokens.get(at + n).is_some_and(|token| token.is(word))) {
        return None;
    }
    let end = group_end(tokens, at + 1);
    let condition = &tokens[at + 4..end];
    let all = condition.first()?.is("all") && !condition.iter().any(|token| token.is("not") || token.is("any"));
    let test = condition.first()?.is("test") || all && condition.iter().any(|token| token.is("test"));
    test.then_some(end)
}

/// The first token of an item behind further attributes and its visibility.
fn head(tokens: &[Token], mut at: usize) -> usize {
    let is = |at: usize, word: &str| tokens.get(at).is_some_and(|token| token.is(word));
    while is(at, "#") {
        at = group_end(tokens, at + 1);
    }
    if is(at, "pub") {
        at += 1;
        if is(at, "(") {
            at = group_end(tokens, at);
        }
    }
    at
}

/// Behind the item, statement, field or arm that begins at `at`.
fn item_end(tokens: &[Token], at: usize) -> usize {
    let Some(first) = tokens.get(at) else { return tokens.len() };
    let is = |word: &str| first.is(word);
    let next = |words: &[&str]| words.iter().any(|word| tokens.get(at + 1).is_some_and(|token| token.is(word)));
    let function = next(&["fn", "unsafe", "async", "extern"]);
    let plain = is("use") || is("static") || is("type") || is("let") || is("const") && !function;
    let blocks = ["fn", "const", "unsafe", "async", "extern", "mod", "struct", "enum", "union", "trait", "impl"];
    let block = !plain && (blocks.iter().any(|word| is(word)) || is("macro_rules"));
    let mut depth = 0;
    for (here, token) in tokens.iter().enumerate().skip(at) {
        depth += depth_change(token);
        if depth < 0 {
            return here;
        }
        let ends = token.is(";") || !plain && token.is("}") || !plain && !block && token.is(",");
        if depth == 0 && ends {
            return here + 1;
        }
    }
    tokens.len()
}
