//! Numbers and formulas of position and time.
//!
//! Formulas are evaluated by [`exmex`], whose unary operators bind before all others, −x^2 being (−x)^2, and whose
//! functions of two numbers cannot be nested. They are therefore rewritten before ([`explicit`]), which also finds mistakes.

mod explicit;

use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{E, PI};

use crate::diagnostic::unknown;
use explicit::{explicit, number};

/// A number, or a formula in x, y, z (m) and t (s) such as "0.5 * (1 - (y/0.01)^2)".
///
/// Signs are those of mathematics, -x^2 = -(x^2), and powers go from left to right, 2^3^2 = 64: put parentheses. There are
/// also pi, e, abs, sign, sqrt, cbrt, exp, ln, log10, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh,
/// floor, ceil, step (0 below 0, else 1) and of two numbers min(a, b), max(a, b), atan2(a, b).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Expression {
    /// The same everywhere and always.
    Number(f64),
    /// A formula in x, y, z and t.
    Formula(String),
}

impl Default for Expression {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl Expression {
    /// The expression ready to be evaluated; those of a checked case compile.
    ///
    /// # Errors
    /// What is wrong with the formula.
    pub fn compile(&self) -> Result<Formula, FormulaError> {
        match self {
            Self::Number(value) => Ok(Formula(Kind::Constant(*value))),
            Self::Formula(text) => Formula::parse(text),
        }
    }
}

/// A number or formula ready to be evaluated, from any thread.
#[derive(Clone, Debug)]
pub struct Formula(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Constant(f64),
    /// With the places of its variables in [`VARIABLES`].
    Compiled(Box<FlatEx<f64, Operators, Number>>, Vec<usize>),
}

/// Variables of a formula.
const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];

/// A formula that cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormulaError {
    /// No formula at all.
    #[error("empty; write a number or a formula in x, y, z and t")]
    Empty,
    /// A character that means nothing.
    #[error("`{0}` means nothing in a formula; there are numbers, names, + - * / ^ ( ) and the comma")]
    Character(char),
    /// Two operands without an operator between them.
    #[error("`{0}` and `{1}` stand side by side; write * to multiply")]
    SideBySide(String, String),
    /// An operator without its operands.
    #[error("something is missing before `{0}`")]
    MissingBefore(String),
    /// An operator without its last operand.
    #[error("something is missing at the end")]
    MissingAtEnd,
    /// A function without its parentheses.
    #[error("`{0}` is a function; put what it is of in parentheses, {0}(x)")]
    BareFunction(String),
    /// A name that stands for nothing.
    #[error("{}", unknown("name", .0, &known_names()))]
    UnknownName(String),
    /// A comma that separates nothing.
    #[error("a comma stands between the two numbers of {} only; decimals have a point", functions_of_two())]
    Comma,
    /// A function of two numbers that got one.
    #[error("`{0}` is of two numbers, {0}(x, y)")]
    OneNumber(String),
    /// A parenthesis too many.
    #[error("a parenthesis `)` too many")]
    NotOpened,
    /// A parenthesis too few.
    #[error("a parenthesis `)` is missing")]
    NotClosed,
    /// Anything else, as the library puts it.
    #[error("not understood: {0}")]
    Other(String),
}

impl Formula {
    /// Parses a formula.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        let explicit = explicit(text)?;
        let compiled = FlatEx::parse(&explicit).map_err(|e| FormulaError::Other(e.msg().to_owned()))?;
        let place = |name: &String| VARIABLES.iter().position(|v| v == name);
        let places: Vec<usize> = compiled.var_names().iter().filter_map(place).collect();
        Ok(Self(Kind::Compiled(Box::new(compiled), places)))
    }

    /// Value at a position (m) and time (s); NaN or infinite where the formula has no value.
    ///
    /// Formulas of up to 32 numbers and variables do not allocate.
    pub fn at(&self, position: [f64; 3], time: f64) -> f64 {
        match &self.0 {
            Kind::Constant(value) => *value,
            Kind::Compiled(compiled, places) => {
                let [x, y, z] = position;
                let all = [x, y, z, time];
                let mut values = [0.0; VARIABLES.len()];
                places.iter().zip(&mut values).for_each(|(&place, value)| *value = all[place]);
                compiled.eval(&values[..places.len()]).unwrap_or(f64::NAN)
            }
        }
    }

    /// Whether the value depends on the place.
    pub fn is_local(&self) -> bool {
        matches!(&self.0, Kind::Compiled(_, places) if places.iter().any(|place| *place < 3))
    }

    /// Whether the value depends on time.
    pub fn is_unsteady(&self) -> bool {
        matches!(&self.0, Kind::Compiled(_, places) if places.contains(&3))
    }
}

/// A function of one number with its name.
type Function = (&'static str, fn(f64) -> f64);

const FUNCTIONS: [Function; 19] = [
    ("abs", f64::abs),
    ("sign", |x| if x == 0.0 { 0.0 } else { x.signum() }),
    ("sqrt", f64::sqrt),
    ("cbrt", libm::cbrt),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log10", libm::log10),
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("atan", libm::atan),
    ("sinh", libm::sinh),
    ("cosh", libm::cosh),
    ("tanh", libm::tanh),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("step", |x| if x < 0.0 { 0.0 } else { 1.0 }),
];

/// A function of two numbers with its name.
type Function2 = (&'static str, fn(f64, f64) -> f64);

const FUNCTIONS_OF_TWO: [Function2; 3] = [("min", f64::min), ("max", f64::max), ("atan2", libm::atan2)];

const CONSTANTS: [(&str, f64); 2] = [("pi", PI), ("e", E)];

/// Multiplies by a sign: binds more than `/` and less than `^`.
const SIGN: &str = "~";

/// The operators of formulas.
#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<f64> for Operators {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let binary = |apply: fn(f64, f64) -> f64, prio, is_commutative| BinOp { apply, prio, is_commutative };
        let mut all = vec![
            Operator::make_bin_unary("+", binary(|a, b| a + b, 0, true), |a| a),
            Operator::make_bin_unary("-", binary(|a, b| a - b, 1, false), |a| -a),
            Operator::make_bin("*", binary(|a, b| a * b, 2, true)),
            Operator::make_bin("/", binary(|a, b| a / b, 3, false)),
            Operator::make_bin(SIGN, binary(|a, b| a * b, 4, false)),
            Operator::make_bin("^", binary(libm::pow, 5, false)),
        ];
        all.extend(FUNCTIONS.map(|(name, f)| Operator::make_unary(name, f)));
        all.extend(FUNCTIONS_OF_TWO.map(|(name, f)| Operator::make_bin(name, binary(f, 0, false))));
        all.extend(CONSTANTS.map(|(name, value)| Operator::make_constant(name, value)));
        all
    }
}

/// The numbers of formulas, exponents included.
#[derive(Clone, Debug)]
struct Number;

impl MatchLiteral for Number {
    fn is_literal(text: &str) -> Option<&str> {
        number(text)
    }
}

fn is_function(name: &str) -> bool {
    FUNCTIONS.iter().any(|f| f.0 == name) || takes_two(name)
}

fn takes_two(name: &str) -> bool {
    FUNCTIONS_OF_TWO.iter().any(|f| f.0 == name)
}

fn functions_of_two() -> String {
    FUNCTIONS_OF_TWO.map(|f| f.0).join(", ")
}

fn known_names() -> Vec<&'static str> {
    let functions = FUNCTIONS.iter().map(|f| f.0).chain(FUNCTIONS_OF_TWO.iter().map(|f| f.0));
    VARIABLES.into_iter().chain(CONSTANTS.iter().map(|c| c.0)).chain(functions).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let formula = Formula::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        formula.at([2.0, 3.0, 5.0], 7.0)
    }

    #[test]
    fn formulas_mean_what_they_do_on_paper() {
        let cases = [
            ("-x^2", -4.0),
            ("exp(-x^2)", (-4.0_f64).exp()),
            ("3*-x^2", -12.0),
            ("12/-x^2", -3.0),
            ("12/-x*3", -18.0),
            ("1--x^2", 5.0),
            ("-(-x)^2 - -1", -3.0),
            ("x^-2", 0.25),
            ("--x", 2.0),
            ("+x - +y", -1.0),
            ("(-x)^2", 4.0),
            ("2^3^2", 64.0),
            ("z - y - x", 0.0),
            ("1 - y + z", 3.0),
            ("z/x*4", 10.0),
            ("12/2/3", 2.0),
            ("2*z/x", 5.0),
            ("1.5e-3*2E+3 - .5 + 2.", 4.5),
            ("1e-3-e", 1e-3 - E),
            ("max(-x, min(y, -t)) + 2*atan2(0, -1)", -2.0 + 2.0 * PI),
            ("-sin(pi*x/4)*-x", 2.0),
            ("x^-max(1, min(x, (y)))*max(x, y)", 0.75),
            ("max(max(x, y), max(-(z), max(t, 1)))", 7.0),
            ("step(x - 2)*step(-y) + sign(-z) + sign(0)", -1.0),
            ("\tt\n + (((x)))", 9.0),
            ("0.5", 0.5),
        ];
        for (text, expected) in cases {
            assert!((value(text) - expected).abs() <= 1e-14 * expected.abs(), "{text} = {}", value(text));
        }
    }

    #[test]
    fn few_variables_stand_in_their_places() {
        assert_eq!(
            [value("z"), value("t - y"), value("y*t - z"), value("x + y + z + t")],
            [5.0, 4.0, 16.0, 17.0]
        );
        let is_unsteady = |text: &str| Formula::parse(text).expect("formula").is_unsteady();
        assert!(is_unsteady("1 - t") && !is_unsteady("1 - tan(x)"));
        assert_eq!(Expression::Number(4.0).compile().expect("number").at([0.0; 3], 0.0), 4.0);
    }

    #[test]
    fn mistakes_are_named() {
        let cases = [
            ("", "empty"),
            ("  ", "empty"),
            ("x +", "missing at the end"),
            ("* x", "missing before `*`"),
            ("sin()", "missing before `)`"),
            ("max(, 2)", "missing before `,`"),
            ("x +* y", "missing before `*`"),
            ("2x", "`2` and `x` stand side by side; write *"),
            ("x(1 - y)", "`x` and `(` stand side by side"),
            ("(x)(y)", "`)` and `(` stand side by side"),
            ("1.2.3", "`1.2` and `.3` stand side by side"),
            ("1e", "`1` and `e` stand side by side"),
            ("sin x", "`sin` is a function"),
            ("1 + sin", "`sin` is a function"),
            ("X^2", "unknown name; did you mean `x`? (known names: `x`, `y`, `z`, `t`, `pi`"),
            ("sine(x)", "did you mean `sin`?"),
            ("u_1", "unknown name"),
            ("x & y", "`&` means nothing"),
            ("½ * x", "`½` means nothing"),
            ("x * {y}", "`{` means nothing"),
            ("(x", "`)` is missing"),
            ("x)", "`)` too many"),
            ("x, y", "between the two numbers of min, max, atan2 only"),
            ("0,5", "decimals have a point"),
            ("max(x, y, z)", "a comma stands"),
            ("max(x, (y, z))", "a comma stands"),
            ("sin(x, y)", "a comma stands"),
            ("max(x)", "`max` is of two numbers"),
        ];
        for (text, expected) in cases {
            let message = Formula::parse(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    /// Every text of a few characters that formulas are made of parses or is refused.
    #[test]
    fn no_short_text_panics() {
        const ALPHABET: [&str; 12] = ["x", "2", ".", "-", "+", "*", "^", "(", ")", ",", "sin", "max"];
        let count = ALPHABET.len();
        for code in 0..count.pow(5) {
            let text: Vec<&str> = (0..5).map(|k| ALPHABET[code / count.pow(k) % count]).collect();
            for text in [text.concat(), text.join(" ")] {
                if let Ok(formula) = Formula::parse(&text) {
                    formula.at([0.5; 3], 0.0);
                }
            }
        }
    }
}
