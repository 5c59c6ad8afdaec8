//! What the numbers of a checkpoint are in another case.

use crate::changes::{self, Change};
use grains_dem::Kind;
use toml::Table;

/// What the numbers of shapes, materials and walls in a checkpoint are in the case.
pub struct Numbering {
    /// By the number in the checkpoint; none where the case has no shape of that name.
    pub shapes: Vec<Option<u16>>,
    /// The same of materials.
    pub materials: Vec<Option<u16>>,
    /// Walls of another form have none.
    walls: Vec<Option<u16>>,
    has_same_walls: bool,
}

impl Numbering {
    /// That between two cases, whose walls differ by `changes`.
    pub fn new(before: &Table, now: &Table, changes: &[Change]) -> Self {
        let of = |section: &str| -> Vec<Option<u16>> {
            let names = changes::names(now, section);
            let place = |name: &String| names.iter().position(|n| n == name).map(|k| k as u16);
            changes::names(before, section).iter().map(place).collect()
        };
        // Neither when a wall is there, nor how it moves and wears, nor what it is of changes where particles touch it.
        let is_formed_otherwise = |name: &str| {
            let of_wall = |change: &&Change| change.is_within(&["wall", name]);
            let other = ["motion", "from", "until", "material", "wear"];
            changes.iter().filter(of_wall).any(|c| c.key.get(2).is_none_or(|key| !other.contains(&&**key)))
        };
        let names = changes::names(before, "wall");
        let walls = of("wall").into_iter().zip(&names);
        let walls: Vec<_> =
            walls.map(|(number, name)| number.filter(|_| !is_formed_otherwise(name))).collect();
        let has_same_walls = walls.iter().enumerate().all(|(k, number)| *number == Some(k as u16));
        Self { shapes: of("shape"), materials: of("material"), walls, has_same_walls }
    }

    /// The shape and material in the case of those in the checkpoint.
    pub fn kind(&self, old: Kind) -> Option<Kind> {
        let of = |list: &[Option<u16>], number: u16| list.get(usize::from(number)).copied().flatten();
        Some(Kind { shape: of(&self.shapes, old.shape)?, material: of(&self.materials, old.material)? })
    }

    /// The wall in the case of one in the checkpoint.
    pub fn wall(&self, old: u16) -> Option<u16> {
        self.walls.get(usize::from(old)).copied().flatten()
    }

    /// How many walls the checkpoint has.
    pub fn walls(&self) -> usize {
        self.walls.len()
    }

    /// Whether all walls have their numbers and forms.
    pub fn keeps_walls(&self) -> bool {
        self.has_same_walls
    }
}
