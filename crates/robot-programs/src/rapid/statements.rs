//! Statements of a RAPID routine: blocks, branches and loops, jumps, assignments, calls.
//!
//! A compact IF (`IF condition statement;`) is a branch with one statement in it. Fails where a block's head is not whole, and at
//! reserved words that begin no statement.

use super::lex::Kind;
use super::read::{ItemKind, Parser};
use super::words;
use crate::error::Result;

impl Parser<'_> {
    /// First of the words after `i`; a `;` before it is refused.
    ///
    /// `head = {token} stop`
    fn until(&self, mut i: usize, stops: &[&str], expected: &str) -> Result<usize> {
        loop {
            match self.kind(i) {
                Some(Kind::Word) if stops.contains(&self.word(i)) => return Ok(i),
                Some(Kind::Mark(b';')) | None => return Err(self.bad(i, expected)),
                Some(_) => i += 1,
            }
        }
    }

    /// The head of a handler: `ERROR (numbers)`, `UNDO`, `BACKWARD`.
    ///
    /// `handler = ("ERROR" | "UNDO" | "BACKWARD") ["(" {token} ")"]`
    fn handler(&mut self, id: usize) -> Result<()> {
        let i = self.i;
        self.i += 1;
        if self.is_mark(self.i, b'(') {
            while !self.is_mark(self.i, b')') {
                if self.i >= self.out.tokens.len() {
                    return Err(self.bad(self.i, "`)`"));
                }
                self.i += 1;
            }
            self.i += 1;
        }
        self.push(id, i..self.i, ItemKind::Start);
        Ok(())
    }

    /// A statement, or the head or the end of a block; `end`: what ends the routine.
    ///
    /// `statement = declaration | handler | condition | block | simple`,
    /// `block = ("WHILE" | "FOR") {token} "DO" | "ENDWHILE" | "ENDFOR" | "ELSEIF" {token} "THEN" | "ELSE" | "ENDIF"`,
    /// `block = "TEST" {token} | ("CASE" | "DEFAULT") {token} ":" | "ENDTEST"`
    pub(super) fn statement(&mut self, id: usize, end: &str) -> Result<()> {
        let i = self.i;
        let word = self.word(i).to_string();
        match word.as_str() {
            "const" | "var" | "pers" | "local" | "task" => self.declaration(Some(id))?,
            "error" | "undo" | "backward" => self.handler(id)?,
            "if" => self.condition(id)?,
            "elseif" => {
                let then = self.until(i + 1, &["then"], "`THEN`")?;
                self.push(id, i + 1..then, ItemKind::Middle);
                self.i = then + 1;
            }
            "else" => {
                self.push(id, i..i, ItemKind::Middle);
                self.i += 1;
            }
            "while" | "for" => {
                let body = self.until(i + 1, &["do"], "`DO`")?;
                if word == "for" && self.kind(i + 1) == Some(Kind::Word) {
                    self.bind(i + 1, "num", id);
                }
                self.push(id, i + 1..body, ItemKind::Loop);
                self.i = body + 1;
            }
            "test" => {
                let body = self.until(i + 1, &["case", "default", "endtest"], "`CASE`")?;
                self.push(id, i + 1..body, ItemKind::Branch);
                self.i = body;
            }
            "case" | "default" => {
                let colon = (i + 1..self.out.tokens.len())
                    .find(|&k| self.is_mark(k, b':') || self.is_mark(k, b';'))
                    .filter(|&k| self.is_mark(k, b':'));
                let Some(colon) = colon else { return Err(self.bad(i, "`:` after the values of the case")) };
                self.push(id, i + 1..colon, ItemKind::Middle);
                self.i = colon + 1;
            }
            "endif" | "endtest" => {
                self.push(id, i..i, ItemKind::EndBranch);
                self.i += 1;
            }
            "endwhile" | "endfor" => {
                self.push(id, i..i, ItemKind::EndLoop);
                self.i += 1;
            }
            _ => self.simple(id, end, false)?,
        }
        Ok(())
    }

    /// `IF condition THEN`, or `IF condition statement;`.
    ///
    /// `condition = "IF" expression ("THEN" | simple)`
    fn condition(&mut self, id: usize) -> Result<()> {
        let first = self.i + 1;
        let mut depth = 0usize;
        let mut operand = true;
        let mut k = first;
        loop {
            let word = self.word(k);
            match self.kind(k) {
                Some(Kind::Word) if word == "then" => {
                    self.push(id, first..k, ItemKind::Branch);
                    self.i = k + 1;
                    return Ok(());
                }
                Some(Kind::Word) if depth == 0 && words::is_operator(word) => operand = true,
                Some(Kind::Word) if depth == 0 && word == "not" => operand = true,
                Some(Kind::Word) if depth == 0 && !operand && !self.is_mark(k - 1, b'.') => break,
                Some(Kind::Mark(b'(' | b'[' | b'{')) => depth += 1,
                Some(Kind::Mark(b')' | b']' | b'}')) => {
                    depth = depth.saturating_sub(1);
                    operand = false;
                }
                Some(Kind::Mark(b';')) | None => return Err(self.bad(k, "`THEN` or a statement after the condition")),
                // `IF a %name%;`
                Some(Kind::Mark(b'%')) if depth == 0 && !operand => break,
                Some(Kind::Mark(b'.')) => {}
                Some(Kind::Mark(_)) if depth == 0 => operand = true,
                Some(_) if depth == 0 => operand = false,
                Some(_) => {}
            }
            k += 1;
        }
        self.push(id, first..k, ItemKind::Branch);
        self.i = k;
        self.simple(id, "", true)?;
        self.push(id, self.i..self.i, ItemKind::EndBranch);
        Ok(())
    }

    /// A statement that is no block; `alone`: the one statement of a compact IF.
    ///
    /// `simple = placeholder [";"] | ";" | name ":" | (leave | connect | assignment | call | late) ";"`,
    /// `leave = ("GOTO" | "RETURN" | "EXIT" | "RAISE" | "RETRY" | "TRYNEXT") {token}`,
    /// `connect = "CONNECT" {token} "WITH" {token}`,
    /// `call = name {token}`, `late = "%" {token}`
    fn simple(&mut self, id: usize, end: &str, alone: bool) -> Result<()> {
        let i = self.i;
        let word = self.word(i).to_string();
        let kind = match self.kind(i) {
            Some(Kind::Placeholder) => {
                self.i += 1;
                if self.is_mark(self.i, b';') {
                    self.i += 1;
                }
                return Ok(());
            }
            Some(Kind::Mark(b';')) => {
                self.i += 1;
                return Ok(());
            }
            Some(Kind::Mark(b'%')) => ItemKind::Late,
            Some(Kind::Word) => match word.as_str() {
                "goto" | "return" | "exit" | "raise" | "retry" | "trynext" => ItemKind::Leave,
                "connect" => ItemKind::Connect,
                _ if words::is_reserved(&word) => {
                    let expected = if end.is_empty() {
                        "a statement".into()
                    } else {
                        format!("a statement or `{}`", end.to_uppercase())
                    };
                    return Err(self.bad(i, &expected));
                }
                _ if self.is_mark(i + 1, b':') => {
                    self.push(id, i..i + 1, ItemKind::Label);
                    self.i += 2;
                    return Ok(());
                }
                _ if self.assigns(i) => ItemKind::Assign,
                _ => ItemKind::Call { alone },
            },
            _ => return Err(self.bad(i, "a statement")),
        };
        let end = match kind {
            ItemKind::Connect => {
                let with = self.until(i + 1, &["with"], "`WITH`")?;
                self.statement_end(with + 1)?
            }
            _ => self.statement_end(i + 1)?,
        };
        self.push(id, i..end, kind);
        self.i = end + 1;
        Ok(())
    }

    /// Whether the statement at `i` is `name{..}.field := ...`.
    ///
    /// `assignment = name {"{" {token} "}" | "." field} ":=" ...`
    fn assigns(&self, i: usize) -> bool {
        let mut k = i + 1;
        loop {
            match self.kind(k) {
                Some(Kind::Assign) => return true,
                Some(Kind::Mark(b'{')) => {
                    while !self.is_mark(k, b'}') {
                        if matches!(self.kind(k), None | Some(Kind::Mark(b';'))) {
                            return false;
                        }
                        k += 1;
                    }
                    k += 1;
                }
                Some(Kind::Mark(b'.')) => k += 2,
                _ => return false,
            }
        }
    }
}
