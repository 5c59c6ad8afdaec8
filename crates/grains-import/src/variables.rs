//! Variables of a script, and arithmetic.

use std::cell::Cell;
use std::collections::BTreeMap;

/// A variable that holds words, or a formula.
#[derive(Clone, Debug)]
enum Variable {
    Text(String),
    Formula(String),
}

/// The variables of a script, and what keywords of the run are worth.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    table: BTreeMap<String, Variable>,
    /// Names that the user gave, which `index` and `string` do not change.
    given: Vec<String>,
    /// Steps done and length of a step in units of the script, once it is set.
    pub clock: (u64, Option<f64>),
    /// Formulas evaluated for the text or formula at hand.
    evaluated: Cell<u32>,
}

impl Variables {
    /// Sets a variable before the script does.
    pub fn give(&mut self, name: &str, value: &str) {
        self.table.insert(name.to_owned(), Variable::Text(value.to_owned()));
        self.given.push(name.to_owned());
    }

    /// Defines a variable by the words behind `variable`.
    ///
    /// # Errors
    /// Styles that have no value here.
    pub fn define(&mut self, words: &[String]) -> Result<(), String> {
        let [name, style, values @ ..] = words else { return Err("name and style are missing".into()) };
        let is_kept = self.given.contains(name) && style != "equal";
        let value = match style.as_str() {
            "delete" => {
                self.table.remove(name);
                return Ok(());
            }
            _ if is_kept => return Ok(()),
            "equal" => Variable::Formula(values.concat()),
            "string" => Variable::Text(values.join(" ")),
            "index" => Variable::Text(values.first().cloned().unwrap_or_default()),
            "getenv" | "file" | "python" | "internal" | "timer" | "format" => {
                return Err(format!(
                    "a variable of style {style} has no value before the run; give --var {name}=VALUE"
                ));
            }
            "loop" | "uloop" | "universe" | "world" => {
                self.table.insert(name.clone(), Variable::Text("1".into()));
                return Err(format!("loops are not followed: {name} is 1"));
            }
            // Per atom: of use to output alone.
            _ => return Err(format!("a variable of style {style} has a value per particle")),
        };
        self.table.insert(name.clone(), value);
        Ok(())
    }

    /// The text with `$x`, `${name}` and `$(formula)` replaced by their values.
    ///
    /// # Errors
    /// Unknown names and formulas without a value.
    pub fn substitute(&self, text: &str) -> Result<String, String> {
        self.evaluated.set(0);
        self.substitute_at(text, 0)
    }

    /// The same of a text that stands so many formulas deep in others.
    fn substitute_at(&self, text: &str, depth: usize) -> Result<String, String> {
        let mut out = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('$') {
            out.push_str(before);
            let (value, left) = match after.chars().next() {
                Some('{') => {
                    let (name, left) = after[1..].split_once('}').ok_or("`${` is not closed")?;
                    (self.text(name, depth)?, left)
                }
                Some('(') => {
                    let end = closing(after).ok_or("`$(` is not closed")?;
                    let formula = &after[1..end];
                    let formula = formula.split(":%").next().unwrap_or(formula);
                    (number(self.value_at(formula, depth + 1)?), &after[end + 1..])
                }
                Some(name) => (self.text(name.encode_utf8(&mut [0; 4]), depth)?, &after[name.len_utf8()..]),
                None => (String::from("$"), after),
            };
            out.push_str(&value);
            check_length(text, &out)?;
            rest = left;
        }
        out.push_str(rest);
        Ok(out)
    }

    fn text(&self, name: &str, depth: usize) -> Result<String, String> {
        match self.table.get(name) {
            Some(Variable::Text(text)) => Ok(text.clone()),
            Some(Variable::Formula(formula)) => Ok(number(self.value_at(formula, depth + 1)?)),
            None => Err(format!("there is no variable {name}; give --var {name}=VALUE")),
        }
    }

    /// The value of a formula.
    ///
    /// # Errors
    /// Names whose values only a run has, and what is no formula.
    pub fn value(&self, formula: &str) -> Result<f64, String> {
        self.evaluated.set(0);
        self.value_at(formula, 0)
    }

    fn value_at(&self, formula: &str, depth: usize) -> Result<f64, String> {
        if let Ok(value) = formula.trim().parse::<f64>() {
            return Ok(value);
        }
        self.evaluated.set(self.evaluated.get() + 1);
        if self.evaluated.get() > MOST_EVALUATIONS {
            return Err(format!(
                "`{}` needs more than {MOST_EVALUATIONS} formulas of other variables; give some by --var",
                shortened(formula)
            ));
        }
        let plain = self.plain(formula, depth)?;
        check_nesting(formula, &plain)?;
        exmex::eval_str::<f64>(&plain).map_err(|error| format!("`{formula}` is no formula: {error}"))
    }

    /// The formula with values for names.
    fn plain(&self, formula: &str, depth: usize) -> Result<String, String> {
        if depth > 50 {
            return Err(format!("`{}` refers to itself", shortened(formula)));
        }
        let mut out = String::new();
        let formula = self.substitute_at(formula, depth)?;
        let mut rest = formula.as_str();
        while let Some(first) = rest.chars().next() {
            let word = match first {
                '0'..='9' | '.' => of_number(rest),
                _ => rest.len() - rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_').len(),
            };
            let (token, left) = rest.split_at(word.max(first.len_utf8()));
            rest = left;
            match token {
                "log" => out.push_str("log10"),
                "PI" => out.push_str(&format!("({})", std::f64::consts::PI)),
                "step" | "elapsed" => out.push_str(&self.clock.0.to_string()),
                "dt" => {
                    let dt = self.clock.1.ok_or("dt is used before the timestep is set")?;
                    out.push_str(&format!("({dt})"));
                }
                "sqrt" | "exp" | "ln" | "abs" | "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "ceil"
                | "floor" | "round" | "atan2" => out.push_str(token),
                _ if first.is_ascii_digit() || first == '.' => {
                    let value: f64 = token.parse().map_err(|_| format!("`{token}` is no number"))?;
                    out.push_str(&value.to_string());
                }
                _ if first.is_alphabetic() => {
                    let unknown = || format!("`{token}` has a value in a run only");
                    match self.table.get(token.strip_prefix("v_").ok_or_else(unknown)?) {
                        Some(Variable::Formula(inner)) => {
                            out.push_str(&format!("({})", self.plain(inner, depth + 1)?));
                        }
                        Some(Variable::Text(text)) => {
                            out.push_str(&format!("({})", self.plain(text, depth + 1)?));
                        }
                        None => return Err(format!("there is no variable {}", &token[2..])),
                    }
                }
                _ => out.push_str(token),
            }
            check_length(&formula, &out)?;
        }
        Ok(out)
    }
}

/// Formulas that one formula may need: more are of variables that need each other twice.
const MOST_EVALUATIONS: u32 = 1000;

/// Characters of a command or formula with the values of its variables: more are of variables that double each other.
const LONGEST: usize = 10_000;

fn check_length(text: &str, replaced: &str) -> Result<(), String> {
    match replaced.len() <= LONGEST {
        true => Ok(()),
        false => Err(format!(
            "`{}` has more than {LONGEST} characters with the values of its variables; give some by --var",
            shortened(text)
        )),
    }
}

/// Parentheses in each other of a formula.
const DEEPEST: usize = 200;

fn check_nesting(formula: &str, plain: &str) -> Result<(), String> {
    let mut depth = 0_usize;
    for c in plain.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return Err(format!(
                "`{}` has more than {DEEPEST} parentheses in each other",
                shortened(formula)
            ));
        }
    }
    Ok(())
}

fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}

/// Length of the number at the beginning of a text.
fn of_number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
            at += 1;
        }
        at
    };
    let mantissa = digits(0);
    if !matches!(bytes.get(mantissa), Some(b'e' | b'E')) {
        return mantissa;
    }
    let sign = usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    match bytes.get(mantissa + 1 + sign) {
        Some(b) if b.is_ascii_digit() => digits(mantissa + 1 + sign),
        _ => mantissa,
    }
}

/// Place of the parenthesis that closes the first one.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0;
    text.char_indices().find_map(|(at, c)| {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        (depth == 0).then_some(at)
    })
}

/// A number as LAMMPS writes it: with fifteen digits, so that 1/1e-5 is 100000.
fn number(value: f64) -> String {
    let value: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    match value.abs() {
        0.0 | 1e-4..1e15 => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn formulas_have_the_values_of_a_script() {
        let mut variables = Variables { clock: (100, Some(1e-5)), ..Variables::default() };
        for line in ["d equal 2.e-3", "r equal ${d}/2", "x index bed silo", "n equal 1.0/dt"] {
            variables.define(&words(line)).unwrap();
        }
        assert_eq!(variables.value("v_r*2^2").unwrap(), 4e-3);
        assert_eq!(variables.value("-(1+3)*log(100)").unwrap(), -8.0);
        assert!((variables.value("2*PI*step*dt").unwrap() - 6.283185307179586e-3).abs() < 1e-17);
        assert_eq!(variables.substitute("dump.$x $r ${n} $(v_d*1e3:%g)").unwrap(), "dump.bed 0.001 100000 2");
        assert!(variables.value("ke/atoms").unwrap_err().contains("in a run only"));
        assert!(variables.substitute("${none}").unwrap_err().contains("--var none=VALUE"));
        variables.define(&words("a equal v_a+1")).unwrap();
        assert!(variables.value("v_a").unwrap_err().contains("itself"));
    }

    #[test]
    fn variables_that_refer_to_or_double_each_other_end_in_an_error() {
        let mut variables = Variables::default();
        variables.define(&words("a equal ${a}")).unwrap();
        variables.define(&words("b equal $(v_c)")).unwrap();
        variables.define(&words("c equal ${b}+1")).unwrap();
        for text in ["${a}", "$(v_b)", "${c}"] {
            assert!(variables.substitute(text).unwrap_err().contains("itself"), "{text}");
        }
        variables.define(&words("x0 equal 1+1")).unwrap();
        for k in 1..40 {
            variables.define(&words(&format!("x{k} equal v_x{0}+v_x{0}", k - 1))).unwrap();
        }
        assert_eq!(variables.value("v_x3").unwrap(), 16.0);
        assert!(variables.value("v_x39").unwrap_err().contains("more than 10000 characters"));
        variables.define(&words("y0 equal 1+1")).unwrap();
        for k in 1..40 {
            variables.define(&words(&format!("y{k} equal ${{y{0}}}+${{y{0}}}", k - 1))).unwrap();
        }
        assert_eq!(variables.value("v_y3").unwrap(), 16.0);
        assert!(variables.value("v_y39").unwrap_err().contains("formulas of other variables"));
        let deep = format!("{}1{}", "(".repeat(4000), ")".repeat(4000));
        assert!(variables.value(&deep).unwrap_err().contains("parentheses in each other"));
    }

    #[test]
    fn what_the_user_gave_stays() {
        let mut variables = Variables::default();
        variables.give("style", "hertz");
        variables.define(&words("style index hooke")).unwrap();
        assert_eq!(variables.substitute("${style}").unwrap(), "hertz");
    }
}
