//! Commands of a script: continued lines, comments and quoted words.

/// Commands with the number of their first line (from 1): lines that end in `&` are joined, comments dropped.
pub fn commands(text: &str) -> Vec<(usize, String)> {
    let mut commands = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let mut command = line.trim_end().to_owned();
        while command.ends_with('&') {
            command.pop();
            let Some((_, next)) = lines.next() else { break };
            command.push(' ');
            command.push_str(next.trim());
        }
        let command = without_comment(&command).split_whitespace().collect::<Vec<_>>().join(" ");
        if !command.is_empty() {
            commands.push((index + 1, command));
        }
    }
    commands
}

fn without_comment(line: &str) -> &str {
    let mut quote = None;
    for (at, c) in line.char_indices() {
        match (quote, c) {
            (None, '#') => return &line[..at],
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
    }
    line
}

/// Words of a command; quoted ones may have blanks and lose their quotes.
pub fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = command.trim_start();
    while let Some(first) = rest.chars().next() {
        let (word, after) = match first {
            '"' | '\'' => rest[1..].split_once(first).unwrap_or((&rest[1..], "")),
            _ => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
        };
        words.push(word.to_owned());
        rest = after.trim_start();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_joined_and_comments_dropped() {
        let text = "# nothing\nfix a all &   \n  nve/sphere # moves\n\nprint \"# of atoms\" &\n";
        let wanted = [(2, "fix a all nve/sphere".to_owned()), (5, "print \"# of atoms\"".to_owned())];
        assert_eq!(commands(text), wanted);
        assert_eq!(words("print \"# of atoms\" 'a b' c"), ["print", "# of atoms", "a b", "c"]);
    }
}
