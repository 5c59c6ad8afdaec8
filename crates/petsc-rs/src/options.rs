//! Options of PETSc as text.

use crate::PetscError;

/// Solver options: those of the case, over which `.petscrc`, `$PETSC_OPTIONS` and the command line win.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Name (with its dash) and value of those of the case.
    pub(crate) case: Vec<(String, Option<String>)>,
    /// Words of the command line.
    pub(crate) command_line: Vec<String>,
}

impl Options {
    /// Options from a text such as `-ksp_rtol 1e-9 -ksp_monitor`; values with spaces stand in quotes.
    ///
    /// Errors if a value stands without a name or a quote is left open.
    pub fn parse(text: &str) -> Result<Self, PetscError> {
        let wrong = |reason: String| PetscError::OptionSyntax { text: text.trim().into(), reason };
        let mut case: Vec<(String, Option<String>)> = Vec::new();
        for word in shlex::split(text).ok_or_else(|| wrong("a quote is left open".into()))? {
            if is_name(&word) {
                case.push((word, None));
                continue;
            }
            match case.last_mut() {
                Some((_, value @ None)) => *value = Some(word),
                Some((name, _)) => return Err(wrong(format!("`{word}` follows the value of {name}"))),
                None => return Err(wrong(format!("`{word}` is not the name of an option"))),
            }
        }
        Ok(Self { case, command_line: Vec::new() })
    }

    /// Adds what follows `--` on a command line.
    pub fn with_command_line(mut self, arguments: impl IntoIterator<Item = String>) -> Self {
        self.command_line.extend(arguments.into_iter().skip_while(|word| word != "--").skip(1));
        self
    }

    /// Names of all options, with their dash.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let line = self.command_line.iter().filter(|word| is_name(word)).map(String::as_str);
        self.case.iter().map(|(name, _)| name.as_str()).chain(line)
    }
}

/// A dash and a letter, or two dashes: `-1e-3` is a value.
fn is_name(word: &str) -> bool {
    let rest = word.strip_prefix('-').unwrap_or("");
    rest.strip_prefix('-').unwrap_or(rest).starts_with(|c: char| c.is_ascii_alphabetic())
}

/// Options most used with the solvers here, for suggestions.
const KNOWN: [&str; 34] = [
    "-ksp_type",
    "-ksp_rtol",
    "-ksp_atol",
    "-ksp_divtol",
    "-ksp_max_it",
    "-ksp_norm_type",
    "-ksp_monitor",
    "-ksp_monitor_true_residual",
    "-ksp_converged_reason",
    "-ksp_view",
    "-ksp_error_if_not_converged",
    "-ksp_initial_guess_nonzero",
    "-pc_type",
    "-pc_mg_levels",
    "-pc_mg_type",
    "-pc_mg_cycle_type",
    "-pc_mg_multiplicative_cycles",
    "-pc_mg_log",
    "-pc_gamg_type",
    "-pc_gamg_threshold",
    "-pc_gamg_agg_nsmooths",
    "-pc_hypre_type",
    "-pc_factor_levels",
    "-mg_levels_ksp_type",
    "-mg_levels_ksp_max_it",
    "-mg_levels_pc_type",
    "-mg_levels_pc_sor_its",
    "-mg_levels_pc_sor_omega",
    "-mg_coarse_ksp_type",
    "-mg_coarse_pc_type",
    "-mg_coarse_redundant_pc_type",
    "-sub_pc_type",
    "-options_left",
    "-log_view",
];

/// The well-known option that a name most resembles, as an end of a sentence.
pub(crate) fn suggestion(name: &str) -> String {
    let nearest = KNOWN.iter().min_by_key(|known| strsim::damerau_levenshtein(known, name));
    match nearest {
        Some(known) if *known != name && strsim::damerau_levenshtein(known, name) <= 3 => {
            format!(" (did you mean {known}?)")
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_values_and_quotes_are_told_apart() {
        let options = Options::parse("-ksp_rtol 1e-9 -shift -1e-3\n -ksp_monitor -f \"a b\"").unwrap();
        let value = |k: usize| options.case[k].1.as_deref();
        assert_eq!(options.names().collect::<Vec<_>>(), ["-ksp_rtol", "-shift", "-ksp_monitor", "-f"]);
        assert_eq!(
            [value(0), value(1), value(2), value(3)],
            [Some("1e-9"), Some("-1e-3"), None, Some("a b")]
        );
        let line = ["run", "a.toml", "--", "-ksp_view"].map(String::from);
        assert_eq!(Options::default().with_command_line(line).command_line, ["-ksp_view"]);
    }

    #[test]
    fn words_out_of_place_are_refused() {
        for (text, reason) in [("1e-9", "not the name"), ("-a 1 2", "follows the value"), ("-a \"b", "quote")]
        {
            let message = Options::parse(text).unwrap_err().to_string();
            assert!(message.contains(reason) && message.contains("-name value"), "{message}");
        }
    }

    #[test]
    fn a_slip_of_the_pen_is_recognised() {
        assert_eq!(suggestion("-ksp_rtoll"), " (did you mean -ksp_rtol?)");
        assert_eq!(suggestion("-something_else"), "");
    }
}
