//! Tokens of a RAPID file to its modules, routines and declarations ([`statements`](super::statements): what stands in routines).
//!
//! Only the frame of the language is read: what belongs to which routine, where a statement starts and ends, which blocks
//! it stands in. Expressions stay tokens. Several modules may stand in one file (`.prg`). Fails where a routine or module is
//! not closed and where a reserved word stands inside a statement (a missing `;`).

use super::lex::{Kind, Lexed, Token, Words};
use super::words;
use crate::error::{Error, Result};
use crate::script::Text;
use crate::script::alike::Passed;
use crate::script::lex::text_of;
use std::ops::Range;

/// Tokens by index.
pub type Span = Range<usize>;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    Const,
    Var,
    Pers,
    /// A parameter of a routine or the counter of a FOR loop.
    Bound,
}

/// A declaration of a name.
#[derive(Debug, Clone)]
pub struct Decl {
    /// Lower case.
    pub name: String,
    pub module: usize,
    pub routine: Option<usize>,
    pub storage: Storage,
    pub local: bool,
    /// Type in lower case.
    pub ty: String,
    pub value: Option<Span>,
    /// First token (`LOCAL`), the name's token, and the `;`.
    pub first: usize,
    pub at: usize,
    pub end: usize,
}

#[derive(Debug, Clone)]
pub struct Routine {
    /// Lower case.
    pub name: String,
    /// No function, no trap.
    pub procedure: bool,
    /// Run by an interrupt.
    pub is_trap: bool,
    /// Seen by its own module alone.
    pub local: bool,
}

/// One thing in the body of a routine.
#[derive(Debug, Clone)]
pub struct Item {
    pub routine: usize,
    pub module: usize,
    /// Tokens, without the `;`.
    pub span: Span,
    pub kind: ItemKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ItemKind {
    /// A routine or a handler of it starts.
    Start,
    /// IF, TEST: its condition.
    Branch,
    /// FOR, WHILE: its condition.
    Loop,
    /// ELSE, ELSEIF, CASE.
    Middle,
    /// ENDIF, ENDTEST; end of a compact IF.
    EndBranch,
    EndLoop,
    Label,
    /// GOTO, RETURN, EXIT, RAISE, RETRY, TRYNEXT: what stands after it is not reached from here.
    Leave,
    /// `CONNECT i WITH trap`.
    Connect,
    /// `name := ...`.
    Assign,
    /// An instruction or procedure call; `alone`: the one statement of a compact IF.
    Call {
        alone: bool,
    },
    /// A procedure called by a name that is computed.
    Late,
}

#[derive(Default)]
pub struct Parsed {
    pub tokens: Vec<Token>,
    pub comments: Vec<(usize, usize)>,
    /// Lines without tokens, like the statement before them.
    pub passed: Vec<Passed>,
    /// In lower case.
    pub words: Words,
    pub decls: Vec<Decl>,
    pub routines: Vec<Routine>,
    /// Names of the modules, lower case.
    pub modules: Vec<String>,
    pub items: Vec<Item>,
}

/// Reads the tokens of a file as modules.
///
/// `file = module {module}`
pub fn parse(text: &Text, lexed: Lexed) -> Result<Parsed> {
    let words = Words::of(text, &lexed.tokens, |bytes| text_of(bytes).to_lowercase());
    let out =
        Parsed { tokens: lexed.tokens, comments: lexed.comments, passed: lexed.passed, words, ..Parsed::default() };
    let mut p = Parser { text, out, i: 0, module: 0, modules: 0 };
    while p.i < p.out.tokens.len() {
        p.module()?;
    }
    if p.modules == 0 {
        return Err(text.bad(0, "no module", "`MODULE name` ... `ENDMODULE`"));
    }
    Ok(p.out)
}

pub(super) struct Parser<'a> {
    text: &'a Text,
    pub(super) out: Parsed,
    pub(super) i: usize,
    module: usize,
    modules: usize,
}

impl Parser<'_> {
    pub(super) fn word(&self, i: usize) -> &str {
        self.out.words.at(i)
    }

    pub(super) fn kind(&self, i: usize) -> Option<Kind> {
        self.out.tokens.get(i).map(|t| t.kind)
    }

    pub(super) fn is_mark(&self, i: usize, mark: u8) -> bool {
        self.kind(i) == Some(Kind::Mark(mark))
    }

    /// Bad input at a token.
    pub(super) fn bad(&self, i: usize, expected: &str) -> Error {
        match self.out.tokens.get(i) {
            Some(t) => {
                let found = String::from_utf8_lossy(self.text.slice(t.start()..t.end())).into_owned();
                self.text.bad(t.start(), format!("`{found}`"), expected)
            }
            None => self.text.bad(self.text.bytes.len(), "the end of the file", expected),
        }
    }

    fn expect_mark(&mut self, mark: u8) -> Result<()> {
        if !self.is_mark(self.i, mark) {
            return Err(self.bad(self.i, &format!("`{}`", char::from(mark))));
        }
        self.i += 1;
        Ok(())
    }

    /// A name that is not reserved.
    ///
    /// `name = word`, not a reserved one
    fn name(&mut self, what: &str) -> Result<String> {
        if self.kind(self.i) != Some(Kind::Word) || words::is_reserved(self.word(self.i)) {
            return Err(self.bad(self.i, what));
        }
        self.i += 1;
        Ok(self.word(self.i - 1).to_string())
    }

    /// `module = "MODULE" name ["(" {token} ")"] {part} "ENDMODULE"`,
    /// `part = ["LOCAL"] record | ["LOCAL"] alias | ["LOCAL"] routine | declaration | placeholder`
    fn module(&mut self) -> Result<()> {
        if self.word(self.i) != "module" {
            return Err(self.bad(self.i, "`MODULE name`"));
        }
        self.i += 1;
        let name = self.name("the name of the module")?;
        self.out.modules.push(name);
        if self.is_mark(self.i, b'(') {
            while !self.is_mark(self.i, b')') {
                if self.i >= self.out.tokens.len() {
                    return Err(self.bad(self.i, "`)` after the attributes of the module"));
                }
                self.i += 1;
            }
            self.i += 1;
        }
        self.module = self.modules;
        self.modules += 1;
        loop {
            match self.word(self.i) {
                "endmodule" => {
                    self.i += 1;
                    return Ok(());
                }
                "record" => self.record()?,
                "alias" => self.until_semicolon()?,
                "local" if self.word(self.i + 1) == "record" => self.record()?,
                "local" if self.word(self.i + 1) == "alias" => self.until_semicolon()?,
                "proc" | "func" | "trap" => self.routine(false)?,
                "local" if matches!(self.word(self.i + 1), "proc" | "func" | "trap") => {
                    self.i += 1;
                    self.routine(true)?;
                }
                "local" | "task" | "const" | "var" | "pers" => self.declaration(None)?,
                _ if self.kind(self.i) == Some(Kind::Placeholder) => self.i += 1,
                _ => return Err(self.bad(self.i, "a declaration, a routine or `ENDMODULE`")),
            }
        }
    }

    /// `record = "RECORD" {token} "ENDRECORD"`
    fn record(&mut self) -> Result<()> {
        while self.word(self.i) != "endrecord" {
            if self.i >= self.out.tokens.len() {
                return Err(self.bad(self.i, "`ENDRECORD`"));
            }
            self.i += 1;
        }
        self.i += 1;
        Ok(())
    }

    /// `alias = "ALIAS" {token} ";"`
    fn until_semicolon(&mut self) -> Result<()> {
        self.i += 1;
        self.i = self.statement_end(self.i)? + 1;
        Ok(())
    }

    /// The `;` that ends the statement of which `i` is a token.
    ///
    /// `rest = {token} ";"`; none of the tokens is a word that begins a statement or a block
    pub(super) fn statement_end(&self, mut i: usize) -> Result<usize> {
        loop {
            match self.kind(i) {
                Some(Kind::Mark(b';')) => return Ok(i),
                // names of switches and fields may be anything
                Some(Kind::Word)
                    if words::is_statement_word(self.word(i))
                        && !self.is_mark(i - 1, b'\\')
                        && !self.is_mark(i - 1, b'.') =>
                {
                    return Err(self.bad(i, "`;` after the statement before it"));
                }
                Some(_) => i += 1,
                None => return Err(self.bad(i, "`;`")),
            }
        }
    }

    /// `declaration = ["LOCAL" | "TASK"] storage (type name {token} [":=" expression] | [type] placeholder {token}) ";"`,
    /// `storage = "CONST" | "VAR" | "PERS"`
    pub(super) fn declaration(&mut self, routine: Option<usize>) -> Result<()> {
        let first = self.i;
        let local = self.word(self.i) == "local";
        if local || self.word(self.i) == "task" {
            self.i += 1;
        }
        let storage = match self.word(self.i) {
            "const" => Storage::Const,
            "var" => Storage::Var,
            "pers" => Storage::Pers,
            _ => return Err(self.bad(self.i, "`CONST`, `VAR` or `PERS`")),
        };
        self.i += 1;
        if self.kind(self.i) == Some(Kind::Placeholder) {
            self.i = self.statement_end(self.i)? + 1;
            return Ok(());
        }
        let ty = self.name("a data type")?;
        let at = self.i;
        if self.kind(at) == Some(Kind::Placeholder) {
            self.i = self.statement_end(self.i)? + 1;
            return Ok(());
        }
        let name = self.name("the name of the data")?;
        let end = self.statement_end(self.i)?;
        let assign = (self.i..end).find(|&k| self.kind(k) == Some(Kind::Assign));
        let value = assign.map(|k| k + 1..end);
        self.i = end + 1;
        let module = self.module;
        self.out.decls.push(Decl { name, module, routine, storage, local, ty, value, first, at, end });
        Ok(())
    }

    pub(super) fn bind(&mut self, at: usize, ty: &str, routine: usize) {
        let name = self.word(at).to_string();
        let (module, ty) = (self.module, ty.to_string());
        self.out.decls.push(Decl {
            name,
            module,
            routine: Some(routine),
            storage: Storage::Bound,
            local: true,
            ty,
            value: None,
            first: at,
            at,
            end: at,
        });
    }

    pub(super) fn push(&mut self, routine: usize, span: Span, kind: ItemKind) {
        let module = self.module;
        self.out.items.push(Item { routine, module, span, kind });
    }

    /// `routine = ("PROC" name parameters | "FUNC" type name parameters | "TRAP" name) {statement} ("ENDPROC" | "ENDFUNC" | "ENDTRAP")`
    fn routine(&mut self, local: bool) -> Result<()> {
        let head = self.i;
        let kind = self.word(self.i).to_string();
        self.i += 1;
        if kind == "func" {
            self.name("the type of the function's value")?;
        }
        let name = self.name("the name of the routine")?;
        let id = self.out.routines.len();
        self.out.routines.push(Routine { name, procedure: kind == "proc", is_trap: kind == "trap", local });
        if kind != "trap" {
            self.parameters(id)?;
        }
        self.push(id, head..self.i, ItemKind::Start);
        let end = format!("end{kind}");
        while self.word(self.i) != end {
            self.statement(id, &end)?;
        }
        self.i += 1;
        Ok(())
    }

    /// `(INOUT jointtarget j \switch s, VAR num n{*} | PERS num m)`.
    ///
    /// `parameters = "(" [parameter {("," | "|" | "\") parameter}] ")"`,
    /// `parameter = {token} name ["{" {token} "}"]`
    fn parameters(&mut self, id: usize) -> Result<()> {
        self.expect_mark(b'(')?;
        let mut last: Option<usize> = None;
        loop {
            match self.kind(self.i) {
                Some(Kind::Word)
                    if words::is_statement_word(self.word(self.i))
                        && !matches!(self.word(self.i), "var" | "pers" | "inout") =>
                {
                    return Err(self.bad(self.i, "`)` after the parameters"));
                }
                Some(Kind::Word) => last = Some(self.i),
                Some(Kind::Mark(mark @ (b',' | b'|' | b')' | b'{' | b'\\'))) => {
                    if let Some(at) = last.take()
                        && !words::is_reserved(self.word(at))
                    {
                        let ty = self.word(at - 1).to_string();
                        self.bind(at, &ty, id);
                    }
                    if mark == b')' {
                        self.i += 1;
                        return Ok(());
                    }
                    if mark == b'{' {
                        while !self.is_mark(self.i, b'}') {
                            if self.i >= self.out.tokens.len() {
                                return Err(self.bad(self.i, "`}`"));
                            }
                            self.i += 1;
                        }
                    }
                }
                Some(_) => {}
                None => return Err(self.bad(self.i, "`)` after the parameters")),
            }
            self.i += 1;
        }
    }
}
