//! The text of a scene file as its instances, one by one, and the rest: so that a scene of a million plants takes the
//! memory of those plants, and not that of a tree of all that is written about them, which is fifty times the text.
//!
//! The cuts lie where toml's own lexer and grammar have the end of an expression: before a `[[instance]]` and before
//! the next header that is none of its tables, or at the commas of a top-level `instance = [...]`. What lies between
//! two cuts is a document of its own. If all of these are sound, then so is the text, as expressions of TOML know of
//! each other only by the tables that they name; if the text is sound, then so are all of them.

use std::borrow::Cow;
use std::collections::TryReserveError;

use toml_parser::Source;
use toml_parser::lexer::{Lexer, Token, TokenKind};

use super::MAX_INSTANCES;

/// The key that is cut out.
const KEY: &str = "instance";

/// A text and where its parts lie.
#[derive(Default)]
pub(super) struct Parts<'a> {
    text: &'a str,
    /// Starts of the pieces of the rest: in the rest, in the text; rising.
    pieces: Vec<[u32; 2]>,
    /// Start and end of instances in the text, [`MAX_INSTANCES`] and one more at most.
    ranges: Vec<[u32; 2]>,
    /// Whether instances are elements of an array.
    is_array: bool,
    /// Start of the first `[[instance]]`; there is none in a sound text that has an array of them.
    pub first_table: Option<usize>,
    /// Number of instances.
    pub count: usize,
    /// Size of the rest.
    pub rest_size: Size,
    /// Size of the largest instance, by each measure.
    pub most: Size,
}

/// What the tree of a document grows with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Size {
    /// Words and signs of TOML.
    pub tokens: usize,
    /// Bytes of text.
    pub bytes: usize,
}

impl Size {
    /// Of a whole text.
    pub(super) fn of(text: &str) -> Size {
        Size { tokens: Source::new(text).lex().count(), bytes: text.len() }
    }

    /// Whether it is as large as another one, or larger.
    pub(super) fn is_room_for(self, other: Size) -> bool {
        other.tokens <= self.tokens && other.bytes <= self.bytes
    }

    fn max(self, other: Size) -> Size {
        Size { tokens: self.tokens.max(other.tokens), bytes: self.bytes.max(other.bytes) }
    }
}

/// A text that holds an instance, as `instance = [...]` or `[[instance]]` with its tables.
pub(super) struct InstanceText<'a> {
    /// A document.
    pub text: Cow<'a, str>,
    /// Where it lies in the whole text.
    start: usize,
    /// Bytes of the document before that.
    prefix: usize,
}

impl InstanceText<'_> {
    /// The byte of the whole text that a byte of this document is.
    pub(super) fn place(&self, at: usize) -> usize {
        self.start + at.saturating_sub(self.prefix).min(self.text.len() - self.prefix)
    }
}

impl<'a> Parts<'a> {
    /// Cuts a text of less than 4 GiB. A text that is no TOML is cut too, somehow: some part of it is no TOML then.
    ///
    /// # Errors
    /// Where there is no memory for the places of so many instances.
    pub(super) fn of(text: &'a str) -> Result<Parts<'a>, TryReserveError> {
        assert!(u32::try_from(text.len()).is_ok(), "a scene file is smaller");
        Cutter::new(text).cut()
    }

    /// Everything but the instances; of an `instance = [...]` the brackets stay.
    pub(super) fn rest(&self) -> Cow<'a, str> {
        let ends =
            self.pieces.iter().skip(1).map(|[in_rest, _]| *in_rest as usize).chain([self.rest_size.bytes]);
        let mut pieces = self.pieces.iter().zip(ends).map(|(&[in_rest, in_text], end)| {
            let start = in_text as usize;
            &self.text[start..start + (end - in_rest as usize)]
        });
        match self.pieces.len() {
            1 => Cow::Borrowed(pieces.next().unwrap_or_default()),
            _ => Cow::Owned(pieces.collect()),
        }
    }

    /// The byte of the text that a byte of the rest is.
    pub(super) fn place(&self, at: usize) -> usize {
        let piece = self.pieces.partition_point(|[start, _]| *start as usize <= at).saturating_sub(1);
        let [in_rest, in_text] = self.pieces[piece].map(|place| place as usize);
        in_text + (at - in_rest)
    }

    /// The instances; behind a last comma, or between brackets without any, an empty array.
    pub(super) fn instances(&self) -> impl Iterator<Item = InstanceText<'a>> {
        const BEFORE: &str = "instance=[";
        let (text, is_array) = (self.text, self.is_array);
        self.ranges.iter().map(move |&[start, end]| {
            let (start, body) = (start as usize, &text[start as usize..end as usize]);
            match is_array {
                true => InstanceText {
                    text: Cow::Owned([BEFORE, body, "]"].concat()),
                    start,
                    prefix: BEFORE.len(),
                },
                false => InstanceText { text: Cow::Borrowed(body), start, prefix: 0 },
            }
        })
    }
}

/// Where the expressions of a document start and end.
struct Cutter<'a> {
    lexer: Lexer<'a>,
    next: Option<Token>,
    /// Of the part so far.
    tokens: usize,
    /// Where the part starts, and whether it is an instance.
    start: usize,
    is_instance: bool,
    parts: Parts<'a>,
}

/// What a header opens.
#[derive(PartialEq)]
enum Header {
    Instance,
    /// A table of an instance, or what can be none: an error, which is told where its instance is read.
    OfInstance,
    Other,
}

impl<'a> Cutter<'a> {
    fn new(text: &'a str) -> Cutter<'a> {
        let mut lexer = Source::new(text).lex();
        let next = lexer.next();
        let parts = Parts { text, ..Parts::default() };
        Cutter { lexer, next, tokens: 0, start: 0, is_instance: false, parts }
    }

    fn cut(mut self) -> Result<Parts<'a>, TryReserveError> {
        let mut is_root = true;
        while let Some(token) = self.next {
            match token.kind() {
                TokenKind::Whitespace | TokenKind::Newline | TokenKind::Comment | TokenKind::Eof => {
                    self.step();
                }
                TokenKind::LeftSquareBracket => {
                    is_root = false;
                    self.header(token.span().start())?;
                }
                _ => {
                    if is_root && self.is_array_of_instances() {
                        self.elements()?;
                    }
                    self.expression();
                }
            }
        }
        self.end(self.parts.text.len())?;
        Ok(self.parts)
    }

    /// The next token is taken.
    fn step(&mut self) -> Option<TokenKind> {
        let token = self.next?;
        self.next = self.lexer.next();
        self.tokens += 1;
        Some(token.kind())
    }

    fn step_if(&mut self, kind: TokenKind) -> bool {
        let is = self.next.is_some_and(|token| token.kind() == kind);
        if is {
            self.step();
        }
        is
    }

    /// Ends a part and starts another.
    fn end(&mut self, at: usize) -> Result<(), TryReserveError> {
        if self.is_instance {
            return self.instance(at, true);
        }
        let Parts { pieces, rest_size, .. } = &mut self.parts;
        if at > self.start || pieces.is_empty() {
            pieces.try_reserve(1)?;
            pieces.push([rest_size.bytes as u32, self.start as u32]);
            rest_size.bytes += at - self.start;
            rest_size.tokens += self.tokens;
        }
        (self.start, self.tokens) = (at, 0);
        Ok(())
    }

    /// An instance that ends here.
    fn instance(&mut self, at: usize, is_full: bool) -> Result<(), TryReserveError> {
        self.parts.count += usize::from(is_full);
        // One too many is kept, which is an error: there are too many, or one without text is not the last.
        if self.parts.ranges.len() <= MAX_INSTANCES {
            self.parts.ranges.try_reserve(1)?;
            self.parts.ranges.push([self.start as u32, at as u32]);
        }
        self.parts.most = self.parts.most.max(Size { tokens: self.tokens, bytes: at - self.start });
        (self.start, self.tokens) = (at, 0);
        Ok(())
    }

    /// `[table]` or `[[table]]`, with its line.
    fn header(&mut self, start: usize) -> Result<(), TryReserveError> {
        let tokens = self.tokens;
        let kind = self.opened();
        if kind == Header::Instance || kind == Header::Other && self.is_instance {
            let of_header = self.tokens - tokens;
            self.tokens = tokens;
            self.end(start)?;
            self.tokens = of_header;
            self.is_instance = kind == Header::Instance;
            if self.is_instance {
                self.parts.first_table.get_or_insert(start);
            }
        }
        while !matches!(self.step(), None | Some(TokenKind::Newline)) {}
        Ok(())
    }

    fn opened(&mut self) -> Header {
        self.step();
        let is_array = self.step_if(TokenKind::LeftSquareBracket);
        self.step_if(TokenKind::Whitespace);
        if !self.is_key() {
            return Header::Other;
        }
        self.step();
        self.step_if(TokenKind::Whitespace);
        let closes = is_array && self.step_if(TokenKind::RightSquareBracket);
        match closes && self.step_if(TokenKind::RightSquareBracket) {
            true => Header::Instance,
            false => Header::OfInstance,
        }
    }

    /// Whether the next token is the key, however it is written.
    fn is_key(&self) -> bool {
        let Some(token) = self.next else { return false };
        let of_a_line = [TokenKind::Atom, TokenKind::BasicString, TokenKind::LiteralString];
        let mut key = Cow::Borrowed("");
        if let Some(raw) =
            Source::new(self.parts.text).get(token).filter(|_| of_a_line.contains(&token.kind()))
        {
            raw.decode_key(&mut key, &mut ());
        }
        key == KEY
    }

    /// Takes `instance = [`, or what of it is there: it stays in the rest.
    fn is_array_of_instances(&mut self) -> bool {
        let is_key = self.is_key();
        is_key && {
            self.step();
            self.step_if(TokenKind::Whitespace);
            self.step_if(TokenKind::Equals) && {
                self.step_if(TokenKind::Whitespace);
                self.step_if(TokenKind::LeftSquareBracket)
            }
        }
    }

    /// The elements of an array, from behind its bracket to its end, which is left to the rest.
    fn elements(&mut self) -> Result<(), TryReserveError> {
        let Some(first) = self.next else { return Ok(()) };
        self.end(first.span().start())?;
        self.parts.is_array = true;
        let (mut depth, mut is_full) = (0_usize, false);
        while let Some(token) = self.next {
            match token.kind() {
                TokenKind::Eof => break,
                TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket if depth == 0 => break,
                TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => depth -= 1,
                TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => {
                    depth += 1;
                    is_full = true;
                }
                TokenKind::Whitespace | TokenKind::Newline | TokenKind::Comment => {}
                TokenKind::Comma if depth == 0 => {
                    self.step();
                    self.instance(token.span().end(), is_full)?;
                    is_full = false;
                    continue;
                }
                _ => is_full = true,
            }
            self.step();
        }
        let end = self.next.map_or(self.parts.text.len(), |token| token.span().start());
        self.instance(end, is_full)
    }

    /// To the end of a line that is within no bracket.
    fn expression(&mut self) {
        let mut depth = 0_usize;
        while let Some(kind) = self.step() {
            match kind {
                TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => depth += 1,
                TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => {
                    depth = depth.saturating_sub(1)
                }
                TokenKind::Newline if depth == 0 => break,
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests;
