//! Source text to tokens: comments are gone, and what stands in a literal is no code.

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An identifier or a keyword.
    Name,
    /// Punctuation; `::`, `..` and `...` are one mark each.
    Mark,
    /// A string, with its content as text.
    Text,
    /// A number, a character or a lifetime, without text.
    Other,
}

/// A token and the line where it begins.
#[derive(Debug, Clone)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) text: String,
    pub(crate) line: usize,
}

impl Token {
    /// Whether this is the word or mark `text`.
    pub(crate) fn is(&self, text: &str) -> bool {
        matches!(self.kind, Kind::Name | Kind::Mark) && self.text == text
    }
}

/// The tokens of `source`.
pub(crate) fn tokens(source: &str) -> Vec<Token> {
    let mut lexer = Lexer { text: source.chars().collect(), at: 0, line: 1, tokens: Vec::new() };
    while lexer.at < lexer.text.len() {
        lexer.step();
    }
    lexer.tokens
}

/// The end (exclusive) of the group that opens at `open`: behind its closing bracket.
pub(crate) fn group_end(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match depth_change(token) {
            1 => depth += 1,
            -1 if depth <= 1 => return at + 1,
            -1 => depth -= 1,
            _ => {}
        }
    }
    tokens.len()
}

/// 1 at an opening bracket, −1 at a closing one, else 0.
pub(crate) fn depth_change(token: &Token) -> i32 {
    match (token.kind, token.text.as_str()) {
        (Kind::Mark, "(" | "[" | "{") => 1,
        (Kind::Mark, ")" | "]" | "}") => -1,
        _ => 0,
    }
}

struct Lexer {
    text: Vec<char>,
    at: usize,
    line: usize,
    tokens: Vec<Token>,
}

impl Lexer {
    fn peek(&self, ahead: usize) -> char {
        self.text.get(self.at + ahead).copied().unwrap_or('\0')
    }

    fn advance(&mut self, count: usize) {
        for _ in 0..count {
            if self.peek(0) == '\n' {
                self.line += 1;
            }
            self.at += 1;
        }
    }

    fn take_while(&mut self, keep: impl Fn(char) -> bool) -> String {
        let begin = self.at;
        while self.at < self.text.len() && keep(self.peek(0)) {
            self.advance(1);
        }
        self.text[begin..self.at].iter().collect()
    }

    fn push(&mut self, kind: Kind, text: impl Into<String>, line: usize) {
        self.tokens.push(Token { kind, text: text.into(), line });
    }

    fn step(&mut self) {
        let line = self.line;
        match (self.peek(0), self.peek(1)) {
            (c, _) if c.is_whitespace() => self.advance(1),
            ('/', '/') => {
                self.take_while(|c| c != '\n');
            }
            ('/', '*') => self.block_comment(),
            ('"', _) => self.string(),
            ('\'', _) => self.quote(),
            (c, _) if c.is_ascii_digit() => self.number(),
            (c, _) if is_word(c) => self.word(),
            ('.', '.') if matches!(self.peek(2), '.' | '=') => self.mark(3, line),
            (':', ':') | ('.', '.') => self.mark(2, line),
            _ => self.mark(1, line),
        }
    }

    fn mark(&mut self, length: usize, line: usize) {
        let text: String = self.text[self.at..self.at + length].iter().collect();
        self.advance(length);
        self.push(Kind::Mark, text, line);
    }

    fn block_comment(&mut self) {
        let mut depth = 0_usize;
        while self.at < self.text.len() {
            match (self.peek(0), self.peek(1)) {
                ('/', '*') => {
                    depth += 1;
                    self.advance(2);
                }
                ('*', '/') => {
                    depth -= 1;
                    self.advance(2);
                    if depth == 0 {
                        return;
                    }
                }
                _ => self.advance(1),
            }
        }
    }

    /// A string with escapes, from its opening quote.
    fn string(&mut self) {
        let (line, begin) = (self.line, self.at + 1);
        self.advance(1);
        while self.at < self.text.len() && self.peek(0) != '"' {
            self.advance(if self.peek(0) == '\\' { 2 } else { 1 });
        }
        let text: String = self.text[begin..self.at.min(self.text.len())].iter().collect();
        self.advance(1);
        self.push(Kind::Text, text, line);
    }

    /// A raw string, from its hashes or its opening quote.
    fn raw_string(&mut self) {
        let line = self.line;
        let hashes = self.take_while(|c| c == '#').len();
        self.advance(1);
        let begin = self.at;
        let ends = |lexer: &Self| lexer.peek(0) == '"' && (1..=hashes).all(|n| lexer.peek(n) == '#');
        while self.at < self.text.len() && !ends(self) {
            self.advance(1);
        }
        let text: String = self.text[begin..self.at].iter().collect();
        self.advance(1 + hashes);
        self.push(Kind::Text, text, line);
    }

    /// A character or a lifetime.
    fn quote(&mut self) {
        let line = self.line;
        if self.peek(1) == '\\' {
            self.advance(3);
            self.take_while(|c| c != '\'');
            self.advance(1);
        } else if self.peek(2) == '\'' {
            self.advance(3);
        } else {
            self.advance(1);
            self.take_while(is_word);
        }
        self.push(Kind::Other, "", line);
    }

    fn number(&mut self) {
        let line = self.line;
        self.take_while(is_word);
        if self.peek(0) == '.' && self.peek(1).is_ascii_digit() {
            self.advance(1);
            self.take_while(is_word);
        }
        self.push(Kind::Other, "", line);
    }

    /// A name, or the literal that it is the prefix of.
    fn word(&mut self) {
        let line = self.line;
        let name = self.take_while(is_word);
        match (name.as_str(), self.peek(0), self.peek(1)) {
            ("r" | "br" | "cr", '"', _) | ("r" | "br" | "cr", '#', '"' | '#') => self.raw_string(),
            ("b" | "c", '"', _) => self.string(),
            ("b", '\'', _) => self.quote(),
            ("r", '#', c) if is_word(c) => {
                self.advance(1);
                let raw = self.take_while(is_word);
                self.push(Kind::Name, raw, line);
            }
            _ => self.push(Kind::Name, name, line),
        }
    }
}

fn is_word(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}
