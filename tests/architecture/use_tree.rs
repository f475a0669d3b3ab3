//! The tree of a `use` declaration as single paths.

use crate::lexer::{Kind, Token};

/// What a `use` binds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Binding {
    Name(String),
    /// `as _`
    Nothing,
    /// `*`
    All,
}

/// One leaf of a `use` declaration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Use {
    pub(crate) path: Vec<String>,
    pub(crate) binding: Binding,
    /// Has a visibility of its own: a re-export.
    pub(crate) public: bool,
}

/// The leaves of the tree that begins at `at`, and where it ends.
pub(crate) fn leaves(tokens: &[Token], at: usize, public: bool) -> (Vec<Use>, usize) {
    let mut reader = Reader { tokens, at, public, leaves: Vec::new() };
    reader.tree(&[]);
    (reader.leaves, reader.at)
}

struct Reader<'a> {
    tokens: &'a [Token],
    at: usize,
    public: bool,
    leaves: Vec<Use>,
}

impl Reader<'_> {
    fn skip(&mut self, word: &str) -> bool {
        let found = self.tokens.get(self.at).is_some_and(|token| token.is(word));
        self.at += usize::from(found);
        found
    }

    fn name(&mut self) -> Option<String> {
        let token = self.tokens.get(self.at).filter(|token| token.kind == Kind::Name)?;
        self.at += 1;
        Some(token.text.clone())
    }

    fn tree(&mut self, prefix: &[String]) {
        let mut path = prefix.to_vec();
        if self.skip("::") {
            path.push(String::new()); // from an outside crate, whatever stands in scope
        }
        loop {
            if self.skip("*") {
                return self.leaf(path, Binding::All);
            }
            if self.skip("{") {
                while !self.skip("}") && self.at < self.tokens.len() {
                    self.tree(&path);
                    self.skip(",");
                }
                return;
            }
            let Some(name) = self.name() else {
                self.at += 1;
                return;
            };
            if name != "self" || path.is_empty() {
                path.push(name);
            }
            if !self.skip("::") {
                break;
            }
        }
        let binding = match self.skip("as").then(|| self.name()).flatten() {
            Some(name) if name == "_" => Binding::Nothing,
            Some(name) => Binding::Name(name),
            None => path.last().map_or(Binding::Nothing, |last| Binding::Name(last.clone())),
        };
        self.leaf(path, binding);
    }

    fn leaf(&mut self, path: Vec<String>, binding: Binding) {
        self.leaves.push(Use { path, binding, public: self.public });
    }
}
