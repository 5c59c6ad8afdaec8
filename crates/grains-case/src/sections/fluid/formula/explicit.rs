//! Formulas read token by token, and rewritten so that [`exmex`] takes them as they are meant.

use super::{FormulaError, is_function, known_names, takes_two};

/// The number a text begins with: 2, 2.5, .5 or 2.5e-3.
pub(super) fn number(text: &str) -> Option<&str> {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let whole = digits(0);
    let fraction = if text[whole..].starts_with('.') { 1 + digits(whole + 1) } else { 0 };
    let mut length = whole + fraction;
    if whole == 0 && fraction < 2 {
        return None;
    }
    if text[length..].starts_with(['e', 'E']) {
        let sign = usize::from(text[length + 1..].starts_with(['+', '-']));
        let exponent = digits(length + 1 + sign);
        length += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    Some(&text[..length])
}

/// The name or number, or the single character, a text begins with.
fn token(text: &str) -> Result<&str, FormulaError> {
    let Some(first) = text.chars().next() else { return Err(FormulaError::Empty) };
    let is_in_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    match (first, number(text)) {
        (_, Some(number)) => Ok(number),
        (c, _) if c.is_ascii_alphabetic() => {
            Ok(&text[..text.find(|c: char| !is_in_name(c)).unwrap_or(text.len())])
        }
        (c, _) if "+-*/^(),".contains(c) => Ok(&text[..1]),
        (c, _) => Err(FormulaError::Character(c)),
    }
}

/// Rewrites a formula so that [`exmex`] takes it as it is meant: signs become factors, "-x^2" is "-1 ~ x^2", and functions
/// of two numbers stand between them, "max(a, b)" is "((a) max (b))".
#[derive(Default)]
struct Explicit<'t> {
    text: String,
    last: &'t str,
    follows_operand: bool,
    /// What every open parenthesis belongs to.
    open: Vec<Open<'t>>,
}

enum Open<'t> {
    /// Nothing, or a function of one number.
    Plain,
    /// The first number of this function of two.
    First(&'t str),
    /// The second number of one.
    Second,
}

/// The formula with every operation explicit, after a look at every pair of neighbours.
pub(super) fn explicit(text: &str) -> Result<String, FormulaError> {
    let mut explicit = Explicit::default();
    let mut rest = text.trim();
    loop {
        let token = token(rest)?;
        explicit.push(token)?;
        rest = rest[token.len()..].trim_start();
        if rest.is_empty() {
            return explicit.finish();
        }
    }
}

impl<'t> Explicit<'t> {
    fn push(&mut self, token: &'t str) -> Result<(), FormulaError> {
        let is_name = token.starts_with(|c: char| c.is_ascii_alphabetic());
        let is_operand = is_name || token.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        if is_function(self.last) && token != "(" {
            return Err(FormulaError::BareFunction(self.last.to_owned()));
        }
        if self.follows_operand && (is_operand || token == "(") {
            return Err(FormulaError::SideBySide(self.last.to_owned(), token.to_owned()));
        }
        if !self.follows_operand && ["*", "/", "^", ",", ")"].contains(&token) {
            return Err(FormulaError::MissingBefore(token.to_owned()));
        }
        if is_name && !known_names().contains(&token) {
            return Err(FormulaError::UnknownName(token.to_owned()));
        }
        match token {
            "-" if !self.follows_operand && self.last != "^" => self.text += "-1 ~",
            "(" => self.open(),
            "," => self.separate()?,
            ")" => self.close()?,
            // Stands between its numbers, once they are known.
            name if takes_two(name) => {}
            _ => self.text += token,
        }
        self.text.push(' ');
        self.follows_operand = token == ")" || is_operand && !is_function(token);
        self.last = token;
        Ok(())
    }

    fn open(&mut self) {
        let takes_two = takes_two(self.last);
        self.text += if takes_two { "( (" } else { "(" };
        self.open.push(if takes_two { Open::First(self.last) } else { Open::Plain });
    }

    fn separate(&mut self) -> Result<(), FormulaError> {
        let Some(Open::First(name)) = self.open.pop() else { return Err(FormulaError::Comma) };
        self.text += &format!(") {name} (");
        self.open.push(Open::Second);
        Ok(())
    }

    fn close(&mut self) -> Result<(), FormulaError> {
        self.text += match self.open.pop() {
            Some(Open::Plain) => ")",
            Some(Open::Second) => ") )",
            Some(Open::First(name)) => return Err(FormulaError::OneNumber(name.to_owned())),
            None => return Err(FormulaError::NotOpened),
        };
        Ok(())
    }

    fn finish(self) -> Result<String, FormulaError> {
        match self.last {
            name if is_function(name) => Err(FormulaError::BareFunction(name.to_owned())),
            _ if !self.follows_operand => Err(FormulaError::MissingAtEnd),
            _ if !self.open.is_empty() => Err(FormulaError::NotClosed),
            _ => Ok(self.text),
        }
    }
}
