//! Every row of the table is right.

#[test]
fn every_law_is_right() {
    let rows = grains_verification::all();
    println!("{}", grains_verification::heading());
    rows.iter().for_each(|row| println!("{row}"));
    let wrong: Vec<String> = rows.iter().filter(|row| !row.is_right()).map(ToString::to_string).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(rows.len() > 60);
}
