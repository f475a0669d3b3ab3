//! What one file says: its modules, its items, what it imports and what it names.

use crate::cut::without_tests;
use crate::lexer::{Kind, Token, depth_change, group_end, tokens};
use crate::use_tree::{Use, leaves};
use std::collections::{BTreeMap, BTreeSet};

/// What an item defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Defines {
    Type,
    Value,
}

/// A module as it is written, be it a file or a `mod name { … }` within one.
#[derive(Debug, Default)]
pub(crate) struct Scope {
    pub(crate) items: BTreeMap<String, BTreeSet<Defines>>,
    /// Modules in files of their own.
    pub(crate) files: Vec<String>,
    /// Modules within this one.
    pub(crate) inner: Vec<(String, Scope)>,
    pub(crate) uses: Vec<Use>,
    /// Paths of two names and more that stand in code.
    pub(crate) paths: BTreeSet<Vec<String>>,
    /// Single names that stand in code.
    pub(crate) names: BTreeSet<String>,
}

/// A file without its tests.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    pub(crate) scope: Scope,
    /// Modules in files of their own that are tests.
    pub(crate) test_modules: Vec<String>,
    /// Lines that are no test.
    pub(crate) lines: usize,
}

/// Reads a file.
pub(crate) fn scan(source: &str) -> Scan {
    let cut = without_tests(&tokens(source));
    let lines = source.lines().count() - cut.test_lines;
    Scan { scope: scope(&cut.tokens), test_modules: cut.test_modules, lines }
}

fn scope(tokens: &[Token]) -> Scope {
    let mut reader = Reader { tokens, at: 0, depth: 0, scope: Scope::default() };
    while reader.at < tokens.len() {
        reader.step();
    }
    assert_eq!(reader.depth, 0, "brackets do not match");
    reader.scope
}

struct Reader<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: i32,
    scope: Scope,
}

impl Reader<'_> {
    fn is(&self, at: usize, word: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(word))
    }

    fn name(&self, at: usize) -> Option<String> {
        self.tokens.get(at).filter(|token| token.kind == Kind::Name).map(|token| token.text.clone())
    }

    fn step(&mut self) {
        let token = &self.tokens[self.at];
        self.depth += depth_change(token);
        match (token.kind, token.text.as_str()) {
            (Kind::Mark, "#") if self.is(self.at + 1, "[") => self.attribute(),
            (Kind::Name, "pub") => self.visibility(),
            (Kind::Name, "use") if !self.is(self.at + 1, "<") => self.imports(false),
            (Kind::Name, "mod") if self.depth == 0 => self.module(),
            (Kind::Name, "fn") if self.depth > 0 => self.at += if self.name(self.at + 1).is_some() { 2 } else { 1 },
            (Kind::Name, keyword) => match self.defines(keyword) {
                Some((defines, name)) => {
                    self.at += if keyword == "macro_rules" { 3 } else { 2 };
                    self.scope.items.entry(name).or_default().insert(defines);
                }
                None => self.path(),
            },
            _ => self.at += 1,
        }
    }

    /// Notes paths that an attribute holds as strings; the rest of it is read as code.
    fn attribute(&mut self) {
        let end = group_end(self.tokens, self.at + 1);
        for token in self.tokens[self.at..end].iter().filter(|token| token.kind == Kind::Text) {
            let path: Vec<String> = token.text.split("::").map(str::to_owned).collect();
            let word = |name: &String| !name.is_empty() && name.chars().all(|c| c == '_' || c.is_alphanumeric());
            if path.len() > 1 && path.iter().all(word) {
                self.scope.paths.insert(path);
            }
        }
        self.at += 1;
    }

    fn visibility(&mut self) {
        self.at += 1;
        let limited = ["crate", "super", "self", "in"].iter().any(|word| self.is(self.at + 1, word));
        if self.is(self.at, "(") && limited {
            self.at = group_end(self.tokens, self.at);
        }
        if self.is(self.at, "use") {
            self.imports(true);
        }
    }

    fn imports(&mut self, public: bool) {
        let (leaves, end) = leaves(self.tokens, self.at + 1, public);
        self.scope.uses.extend(leaves);
        self.at = end;
    }

    fn module(&mut self) {
        let Some(name) = self.name(self.at + 1) else {
            self.at += 1;
            return;
        };
        let open = self.at + 2;
        if self.is(open, "{") {
            let end = group_end(self.tokens, open);
            self.scope.inner.push((name, scope(&self.tokens[open + 1..end - 1])));
            self.at = end;
        } else {
            self.scope.files.push(name);
            self.at = open;
        }
    }

    /// What the keyword here defines at the top of the module, and its name.
    fn defines(&self, keyword: &str) -> Option<(Defines, String)> {
        let behind = |word: &str| self.at > 0 && self.tokens[self.at - 1].is(word);
        if self.depth != 0 || behind("*") || behind("<") || behind(",") {
            return None; // `*const T`, `<const N: usize>`
        }
        let defines = match keyword {
            "struct" | "enum" | "union" | "trait" | "type" => Defines::Type,
            "fn" | "const" | "static" | "macro_rules" => Defines::Value,
            _ => return None,
        };
        let name = self.name(self.at + if keyword == "macro_rules" { 2 } else { 1 })?;
        let modifier = ["fn", "unsafe", "async", "extern", "mut", "_"].contains(&name.as_str());
        (!modifier).then_some((defines, name))
    }

    /// A name in code, with those that follow it behind `::`.
    fn path(&mut self) {
        let first = self.at == 0 || !(self.tokens[self.at - 1].is(".") || self.tokens[self.at - 1].is("::"));
        let mut path: Vec<String> = self.name(self.at).into_iter().collect();
        self.at += 1;
        while self.is(self.at, "::")
            && let Some(name) = self.name(self.at + 1)
        {
            path.push(name);
            self.at += 2;
        }
        if first && path.len() > 1 {
            self.scope.paths.insert(path);
        } else if first && !self.is(self.at, ":") {
            self.scope.names.extend(path);
        }
    }
}
