//! Remedies for what is no TOML, or no table of particles, but is usual elsewhere.

/// What a text is that is no TOML at all, judged by its first line with words, and what to do.
pub(crate) fn other_format(text: &str) -> Option<&'static str> {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next()?;
    let word = first.split_whitespace().next()?;
    let of_lammps = [
        "units",
        "atom_style",
        "boundary",
        "newton",
        "dimension",
        "ITEM:",
        "pair_style",
        "variable",
        "include",
    ];
    if first.starts_with('{') {
        Some("JSON, not TOML: write key = value lines and [section] headings, as `grains-mpi new silo` does")
    } else if first == "---" || first.starts_with("%YAML") || first.ends_with(':') && !first.contains('=') {
        Some("YAML, not TOML: write [section] headings and key = value lines, as `grains-mpi new silo` does")
    } else if first.starts_with('<') {
        Some("XML, not TOML: write [section] headings and key = value lines, as `grains-mpi new silo` does")
    } else if word == "solid" {
        Some("a mesh (STL), not TOML: name it in a case, as path of a [[wall]] of kind \"mesh\"")
    } else if word == "FoamFile" || first.starts_with("/*") {
        Some("a dictionary of OpenFOAM, not TOML: `grains-mpi new silo` writes a case to begin with")
    } else if of_lammps.contains(&word) && !first.contains('=') {
        Some("a script or dump of LAMMPS or LIGGGHTS, not TOML: `grains-mpi import FILE` makes a case of it")
    } else if word.contains(',') && !first.contains(['=', '[']) {
        Some(
            "a table (CSV), not TOML: name it in a case, as insert.place = { kind = \"file\", path = \"...\" }",
        )
    } else {
        None
    }
}

/// What to write instead, judged by the line at which the text is not understood.
pub(crate) fn remedy_of_syntax(line: &str, message: &str) -> &'static str {
    let before_comment = line.split('#').next().unwrap_or(line);
    let value = before_comment.split_once('=').map_or("", |(_, value)| value.trim());
    let is_digit = |c: char| c.is_ascii_digit();
    let numeral = value.trim_start_matches(['-', '+', '[']).trim_end_matches(']');
    if message.contains("duplicate key") {
        "; a key and a [section] are given once: remove one, or write [[section]] for each entry of a list"
    } else if line.contains(['“', '”', '„', '‘', '’']) {
        "; texts stand in straight quotes, \"like this\""
    } else if before_comment.contains(['\u{a0}', '\u{2212}', '\u{2013}']) {
        "; a blank or minus of a word processor: type it anew, as in -5e-3"
    } else if before_comment.contains("//") || before_comment.contains('%') {
        "; comments begin with #"
    } else if value.contains("True") || value.contains("False") {
        "; truth values are true and false, in small letters"
    } else if !before_comment.contains('=') && before_comment.contains(':') {
        "; a value follows its key after =, as in radius = 0.005"
    } else if value.ends_with(';') {
        "; a line ends without a semicolon"
    } else if value.starts_with('(') || value.starts_with('[') && !value.contains(',') {
        "; a vector stands in brackets with commas, as in [0.1, 0.1, 0.2]"
    } else if !value.starts_with('[')
        && numeral.split_once(',').is_some_and(|(a, b)| a.ends_with(is_digit) && b.starts_with(is_digit))
    {
        "; decimals have a point, as in 0.005"
    } else if numeral.starts_with('.') || numeral.ends_with('.') {
        "; digits stand on both sides of the point, as in 0.5 and 1.0"
    } else if numeral.starts_with('0') && numeral.len() > 1 && numeral.chars().all(is_digit) {
        "; whole numbers begin with no 0"
    } else if numeral.starts_with(is_digit) {
        "; a number stands alone, without unit and arithmetic, its exponent after e: 5e-3"
    } else if value.starts_with('{') && !value.ends_with('}') {
        "; a table in braces stands on one line, or closes with }"
    } else if value.starts_with(char::is_alphabetic) {
        "; texts stand in quotes, as in \"sphere\""
    } else {
        ""
    }
}

/// What to do about a column of a table of particles that has no meaning.
pub(crate) fn remedy_of_column(name: &str, header: &[&str]) -> Option<String> {
    let lower = name.to_lowercase();
    let remedy = if name.is_empty() {
        "the header is empty; begin the file with a line such as x,y,z".into()
    } else if name.trim().parse::<f64>().is_ok() {
        "a number where the header should be; begin the file with a line such as x,y,z".into()
    } else if header.len() == 1 && name.contains([';', '\t', ' ']) {
        "columns are separated by commas, and decimals have a point".into()
    } else if name.contains(['(', '[']) {
        "names of columns stand without units; lengths are in m, velocities in m/s".into()
    } else if ["id", "ids", "type", "index", "number"].contains(&lower.as_str()) {
        "particles are numbered by the program; remove this column".into()
    } else if ["d", "dp", "diameter"].contains(&lower.as_str()) {
        "give `radius` (m), half the diameter, instead".into()
    } else if ["r", "rp"].contains(&lower.as_str()) {
        "name it `radius` (m)".into()
    } else {
        return None;
    };
    Some(remedy)
}
