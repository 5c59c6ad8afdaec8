//! What is meant by a command line that is not understood.

use crate::Cli;
use clap::CommandFactory;
use grains_case::closest;

/// What to write instead of some words, the program's name left out.
pub fn remedy(words: &[String]) -> Option<String> {
    const GOES_ON: [&str; 4] = ["restart", "continue", "resume", "latest"];
    const RANKS: [&str; 5] = ["-n", "-np", "--np", "--ranks", "-c"];
    let command = Cli::command();
    let commands: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
    let is_case = |word: &&String| word.ends_with(".toml");
    let case = words.iter().find(is_case).map_or("case.toml", String::as_str);
    let Some(first) = words.first() else {
        return Some("name a case: `grains-mpi new silo` writes one to begin with".into());
    };
    let runs = first == "run" || !commands.contains(&first.as_str());
    let bare = |word: &str| word.trim_start_matches('-').to_owned();
    let slip = words.iter().find(|word| GOES_ON.contains(&bare(word).as_str()) && *word != "--restart");
    if let Some(slip) = slip.filter(|_| runs && !words.iter().any(|word| word == "--restart")) {
        return Some(format!("`{slip}`: a run goes on by `grains-mpi {case} --restart latest`"));
    }
    if let Some(slip) = words.iter().find(|word| runs && RANKS.contains(&word.as_str())) {
        return Some(format!(
            "`{slip}`: the number of ranks is given to mpirun, as in `mpirun -n 4 grains-mpi {case}`"
        ));
    }
    let cases: Vec<&String> = words.iter().filter(is_case).collect();
    if let ([_, other, ..], true) = (&cases[..], runs || first == "check") {
        return Some(format!("`{other}`: one case at a time; `grains-mpi sweep` runs many of one case"));
    }
    let is_word = !first.starts_with('-') && !is_case(&first) && !std::path::Path::new(first).exists();
    if is_word && !commands.contains(&first.as_str()) && words.len() > 1 {
        let meant = closest(first, commands.iter().copied());
        let meant =
            meant.map_or("`grains-mpi --help` lists them".into(), |near| format!("did you mean `{near}`?"));
        return Some(format!("`{first}` is no command; {meant}"));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::remedy;

    /// Words, and what is answered.
    const SLIPS: &[(&str, &str)] = &[
        ("", "`grains-mpi new silo` writes one"),
        ("chek a.toml", "did you mean `check`?"),
        ("rnu a.toml", "`rnu` is no command"),
        ("shema x", "did you mean `schema`?"),
        ("simulate a.toml", "`grains-mpi --help` lists them"),
        ("restart a.toml", "`grains-mpi a.toml --restart latest`"),
        ("a.toml restart", "`grains-mpi a.toml --restart latest`"),
        ("a.toml latest", "`grains-mpi a.toml --restart latest`"),
        ("a.toml --resume", "`grains-mpi a.toml --restart latest`"),
        ("run a.toml --continue", "`grains-mpi a.toml --restart latest`"),
        ("a.toml -n 4", "`mpirun -n 4 grains-mpi a.toml`"),
        ("a.toml --ranks 4", "`mpirun -n 4 grains-mpi a.toml`"),
        ("run a.toml -np 2", "`mpirun -n 4 grains-mpi a.toml`"),
        ("a.toml b.toml", "`b.toml`: one case at a time"),
        ("check a.toml b.toml", "`b.toml`: one case at a time"),
    ];

    #[test]
    fn slips_of_the_command_line_are_answered_with_what_to_write() {
        for (words, answer) in SLIPS {
            let words: Vec<String> = words.split_whitespace().map(String::from).collect();
            assert!(!crate::understands(
                [vec!["grains-mpi".into()], words.clone()].concat().iter().map(std::ffi::OsString::from)
            ));
            let said = remedy(&words).unwrap_or_default();
            println!("| `{}` | {said} |", words.join(" "));
            assert!(said.contains(answer), "{words:?}: {said}");
        }
        assert_eq!(remedy(&["check".into(), "a.toml".into(), "--rank".into()]), None);
    }
}
