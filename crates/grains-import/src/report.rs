//! What became of each line, and what changed on the way.

use std::fmt;

/// A command of a script: its file, its first line there (from 1), and its text on one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The file as the user named it.
    pub file: String,
    /// Line of the file, from 1.
    pub line: usize,
    /// The command.
    pub text: String,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.text)
    }
}

/// What became of a command.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The case has it.
    Translated,
    /// The case has it, but for something.
    Partly(String),
    /// The case needs no such word.
    Unneeded(&'static str),
    /// The case does not have it.
    Untranslated(String),
}

/// What became of all commands, and every change of a definition.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The commands in the order in which they were read.
    pub commands: Vec<(Source, Outcome)>,
    /// Definitions that differ, and what was taken.
    pub remarks: Vec<String>,
}

impl Report {
    /// Adds a remark unless it has been made.
    pub fn remark(&mut self, remark: impl Into<String>) {
        let remark = remark.into();
        if !self.remarks.contains(&remark) {
            self.remarks.push(remark);
        }
    }

    /// Numbers of commands that are translated (wholly or partly), not needed, and untranslated.
    pub fn counts(&self) -> [usize; 3] {
        let count = |is: fn(&Outcome) -> bool| self.commands.iter().filter(|(_, o)| is(o)).count();
        [
            count(|o| matches!(o, Outcome::Translated | Outcome::Partly(_))),
            count(|o| matches!(o, Outcome::Unneeded(_))),
            count(|o| matches!(o, Outcome::Untranslated(_))),
        ]
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [translated, unneeded, untranslated] = self.counts();
        writeln!(
            f,
            "{} commands: {translated} translated, {unneeded} without a counterpart that is needed, {untranslated} not translated",
            self.commands.len()
        )?;
        let section = |f: &mut fmt::Formatter<'_>, title: &str, lines: Vec<String>| match lines.is_empty() {
            true => Ok(()),
            false => writeln!(f, "\n{title}\n  {}", lines.join("\n  ")),
        };
        let of = |pick: fn(&Outcome) -> Option<&str>| {
            let picked = self.commands.iter().filter_map(|(source, outcome)| Some((source, pick(outcome)?)));
            picked.map(|(source, reason)| format!("{source}\n      {reason}")).collect()
        };
        let untranslated = of(|o| if let Outcome::Untranslated(why) = o { Some(why) } else { None });
        section(f, "Not translated:", untranslated)?;
        let partly = of(|o| if let Outcome::Partly(but) = o { Some(but) } else { None });
        section(f, "Translated, but:", partly)?;
        section(f, "Definitions that differ, and what was taken:", self.remarks.clone())
    }
}
