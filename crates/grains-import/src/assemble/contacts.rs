//! Contact laws of a case.

use super::Assembly;
use super::particles::Grain;
use super::walls::is_same;
use crate::case_text::Section;
use crate::laws::{Bodies, Elastic, PairLaw, contact, shown};
use crate::liggghts_law::Style;
use crate::report::Source;
use crate::scene::{Laws, WallLaw};
use grains_case::Rolling;
use toml::Table;

impl Assembly<'_> {
    /// Adds the contacts; returns the materials whose elastic constants they take.
    pub(super) fn contacts(
        &mut self,
        grains: &[Grain],
        walls: &[(WallLaw, String)],
        sections: &mut Vec<Section>,
    ) -> Result<Vec<String>, String> {
        let mut elastic = Vec::new();
        let mut note = |law: &PairLaw, between: &[String; 2]| {
            if let Elastic::Hertz { of_materials: true, .. } = law.elastic {
                elastic.extend(between.clone());
            }
        };
        self.report.remark("friction: here at most μ times the elastic force, there μ times the normal force with its dashpot, or with the dashpot left out of what slides");
        for (i, a) in grains.iter().enumerate() {
            for b in &grains[i..] {
                let between = [a.name.clone(), b.name.clone()];
                let bodies: [Bodies; 3] = std::array::from_fn(|k| Bodies::pair(a.sizes()[k], b.sizes()[k]));
                let (law, source) = self.pair_law([a.kind, b.kind], &bodies, &between)?;
                note(&law, &between);
                sections.push(self.contact(&law, between, &bodies[0])?.from([&source]));
            }
            for (law, name) in walls {
                let between = [a.name.clone(), name.clone()];
                let bodies = a.sizes().map(Bodies::at_wall);
                let source = self.scene.walls.iter().find(|wall| is_same(&wall.law, law));
                let law = match law {
                    WallLaw::Law(law) => law.clone(),
                    WallLaw::Style(kind, style) => {
                        self.of_style(style, [a.kind, *kind], &bodies, &between, true)?
                    }
                };
                note(&law, &between);
                let source = source.and_then(|wall| wall.sources.first()).cloned();
                sections.push(self.contact(&law, between, &bodies[0])?.from(source.as_ref()));
            }
        }
        Ok(elastic)
    }

    fn contact(&mut self, law: &PairLaw, between: [String; 2], bodies: &Bodies) -> Result<Section, String> {
        let contact = contact(law, between, bodies, self.report);
        let mut table = Table::try_from(&contact).map_err(|e| e.to_string())?;
        if contact.rolling_friction == 0.0 || contact.rolling == Rolling::default() {
            table.remove("rolling");
        }
        Section::new("[[contact]]", &table)
    }

    fn pair_law(
        &mut self,
        kinds: [usize; 2],
        bodies: &[Bodies; 3],
        between: &[String; 2],
    ) -> Result<(PairLaw, Source), String> {
        match &self.scene.laws {
            Laws::None => Err("the script has no law of contacts: no pair_style was translated".into()),
            Laws::Style(style, source) => {
                Ok((self.of_style(&style.clone(), kinds, bodies, between, false)?, source.clone()))
            }
            Laws::Coefficients(laws) => {
                let [low, high] = [kinds[0].min(kinds[1]), kinds[0].max(kinds[1])];
                let holds = |[one, other]: [[usize; 2]; 2]| {
                    let is_in = |kind: usize, range: [usize; 2]| range[0] <= kind && kind <= range[1];
                    (is_in(low, one) && is_in(high, other)) || (is_in(high, one) && is_in(low, other))
                };
                let found = laws.iter().rev().find(|(ranges, ..)| holds(*ranges));
                let (_, law, source) = found.ok_or_else(|| {
                    format!("no pair_coeff for types {low} and {high}: LAMMPS mixes those of both; add `pair_coeff {low} {high} …`")
                })?;
                Ok((law.clone(), source.clone()))
            }
        }
    }

    fn of_style(
        &mut self,
        style: &Style,
        kinds: [usize; 2],
        bodies: &[Bodies; 3],
        between: &[String; 2],
        is_wall: bool,
    ) -> Result<PairLaw, String> {
        let law = style.law(self.properties, self.units, kinds, &bodies[0], is_wall)?;
        if let Some(rule) = style.depends_on_size() {
            let stiffness = |bodies: &Bodies| {
                let law = style.law(self.properties, self.units, kinds, bodies, is_wall)?;
                Ok::<_, String>(match law.elastic {
                    Elastic::Linear { stiffness } => stiffness,
                    Elastic::Hertz { modulus, .. } => modulus,
                })
            };
            let [typical, min, max] =
                [stiffness(&bodies[0])?, stiffness(&bodies[1])?, stiffness(&bodies[2])?];
            let range = match (max / min - 1.0).abs() < 1e-6 {
                true => String::new(),
                false => format!(", there from {} to {} N/m", shown(min), shown(max)),
            };
            self.report.remark(format!(
                "{} on {}: {rule}; here normal_stiffness is {} N/m for all of them{range}",
                between[0],
                between[1],
                shown(typical)
            ));
        }
        Ok(law)
    }
}
