//! Particles of a case: materials, forms, tables and insertions.

use super::Assembly;
use crate::case_text::Section;
use crate::laws::Body;
use crate::particles::{Names, Particle, Volumes, density_key};
use crate::report::Source;
use crate::scene::{Form, InsertPlan};
use grains_case::{Component, GluedPart, Insert, ParticleMotion, Place, ShapeKind, SizeDistribution};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A material of particles.
pub(super) struct Grain {
    pub(super) name: String,
    pub(super) kind: usize,
    pub(super) density: f64,
    pub(super) bodies: Vec<(Body, f64)>,
    pub(super) sources: Vec<Source>,
}

impl Grain {
    /// The mean of its bodies by number, and the smallest and largest.
    pub(super) fn sizes(&self) -> [Body; 3] {
        let whole: f64 = self.bodies.iter().map(|(_, share)| share).sum();
        let mean =
            |of: fn(&Body) -> f64| self.bodies.iter().map(|(b, share)| share * of(b)).sum::<f64>() / whole;
        let radius = mean(|b| b.radius);
        let by_radius = |a: &&(Body, f64), b: &&(Body, f64)| a.0.radius.total_cmp(&b.0.radius);
        let typical = Body { radius, mass: 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * self.density };
        let min = self.bodies.iter().min_by(by_radius).map_or(typical, |(b, _)| *b);
        let max = self.bodies.iter().max_by(by_radius).map_or(typical, |(b, _)| *b);
        [typical, min, max]
    }
}

impl Assembly<'_> {
    /// The materials of particles: types, and several of one type whose densities differ.
    pub(super) fn grains(&self) -> Result<Vec<Grain>, String> {
        let mut found: BTreeMap<(usize, u64), Grain> = BTreeMap::new();
        let mut add = |kind: usize, density: f64, radius: f64, share: f64, source: Option<&Source>| {
            let grain = found.entry((kind, density_key(density))).or_insert_with(|| Grain {
                name: String::new(),
                kind,
                density,
                bodies: Vec::new(),
                sources: Vec::new(),
            });
            let mass = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * density;
            grain.bodies.push((Body { radius, mass }, share));
            grain.sources.extend(source.filter(|s| !grain.sources.contains(s)).cloned());
        };
        for insert in &self.scene.inserts {
            for (template, share) in &insert.mixture {
                match template.form {
                    Form::SphereRange([low, high]) => {
                        for radius in [low, 0.5 * (low + high), high] {
                            add(template.kind, template.density, radius, share / 3.0, Some(&template.source));
                        }
                    }
                    _ => {
                        let radius = (template.form.volume() * 0.75 / std::f64::consts::PI).cbrt();
                        add(template.kind, template.density, radius, *share, Some(&template.source));
                    }
                }
            }
        }
        let mut volumes = Volumes::default();
        for particle in &self.scene.start {
            let id = particle.id;
            let density = particle.density.ok_or_else(|| {
                format!("particle {id} has no density: dump `density` or `mass` with it, or give the script that reads its data")
            })?;
            let volume = particle.shape.and_then(|shape| volumes.of(shape));
            let of_volume = volume.map(|v| (v * 0.75 / std::f64::consts::PI).cbrt());
            let radius = of_volume.or(particle.radius).ok_or_else(|| {
                format!("particle {id} has no size: dump `radius`, or shapex shapey shapez, with it")
            })?;
            add(particle.kind, density, radius, 1.0, self.scene.start_source.as_ref());
        }
        let mut grains: Vec<Grain> = found.into_values().collect();
        if grains.is_empty() {
            return Err("the script has no particles: no data, and no insertion that was translated".into());
        }
        const MAX: usize = 64;
        if grains.len() > MAX {
            return Err(format!(
                "{} pairs of type and density, each of which is a material: more than {MAX}",
                grains.len()
            ));
        }
        let kinds: Vec<usize> = grains.iter().map(|g| g.kind).collect();
        for (index, grain) in grains.iter_mut().enumerate() {
            let is_alone = kinds.iter().filter(|k| **k == grain.kind).count() == 1;
            let number = 1 + kinds[..index].iter().filter(|k| **k == grain.kind).count();
            let kind = grain.kind;
            grain.name = if is_alone { format!("type{kind}") } else { format!("type{kind}-{number}") };
        }
        Ok(grains)
    }

    pub(super) fn names(&self, grains: &[Grain]) -> Names {
        let mut shapes = Vec::new();
        for particle in &self.scene.start {
            if let Some(shape) = particle.shape
                && !shapes.iter().any(|(other, _)| *other == shape)
            {
                shapes.push((shape, format!("body{}", shapes.len() + 1)));
            }
        }
        let of_start = self.scene.start.iter().filter(|p| p.shape.is_none()).find_map(|p| p.radius);
        let of_template =
            self.scene.inserts.iter().flat_map(|i| &i.mixture).find_map(|(t, _)| match t.form {
                Form::Sphere(radius) | Form::SphereRange([_, radius]) => Some(radius),
                _ => None,
            });
        let materials = grains.iter().map(|g| ((g.kind, density_key(g.density)), g.name.clone())).collect();
        let radius = of_start.or(of_template).unwrap_or(0.0);
        Names { materials, shapes, sphere: ("sphere".to_owned(), radius) }
    }

    pub(super) fn shapes(&self, names: &Names, sections: &mut Vec<Section>) -> Result<(), String> {
        let mut push = |name: &str, kind: &ShapeKind, source: Option<&Source>| {
            let section = Section::new("[[shape]]", kind)?.with("name", Some(name)).from(source);
            sections.push(section);
            Ok::<_, String>(())
        };
        if names.sphere.1 > 0.0 {
            push(&names.sphere.0, &ShapeKind::Sphere { radius: names.sphere.1 }, None)?;
        }
        for (shape, name) in &names.shapes {
            let kind = ShapeKind::Superellipsoid {
                semi_axes: shape.semi_axes,
                eps: shape.eps(),
                surface_vertices: None,
            };
            push(name, &kind, self.scene.start_source.as_ref())?;
        }
        let mut written: Vec<&str> = Vec::new();
        for (template, _) in self.scene.inserts.iter().flat_map(|i| &i.mixture) {
            if written.contains(&template.name.as_str()) {
                continue;
            }
            let kind = match &template.form {
                Form::Sphere(_) | Form::SphereRange(_) => continue,
                Form::Superquadric(shape) => ShapeKind::Superellipsoid {
                    semi_axes: shape.semi_axes,
                    eps: shape.eps(),
                    surface_vertices: None,
                },
                Form::Spheres(spheres) => {
                    let part = |(at, radius): &([f64; 3], f64)| GluedPart {
                        at: *at,
                        orientation: [1.0, 0.0, 0.0, 0.0],
                        kind: ShapeKind::Sphere { radius: *radius },
                    };
                    ShapeKind::Glued { parts: spheres.iter().map(part).collect() }
                }
            };
            push(&template.name, &kind, Some(&template.source))?;
            written.push(&template.name);
        }
        Ok(())
    }

    pub(super) fn inserts(
        &mut self,
        grains: &[Grain],
        names: &Names,
        sections: &mut Vec<Section>,
    ) -> Result<Vec<(PathBuf, Vec<Particle>)>, String> {
        let mut tables = Vec::new();
        let is_frozen = |p: &Particle| self.scene.frozen.contains(&p.kind);
        let (fixed, free): (Vec<Particle>, Vec<Particle>) =
            self.scene.start.iter().cloned().partition(is_frozen);
        for (name, particles, motion) in
            [("start", free, None), ("frozen", fixed, Some(ParticleMotion::Fixed))]
        {
            if particles.is_empty() {
                continue;
            }
            let path = PathBuf::from(if name == "start" {
                "particles.csv".into()
            } else {
                format!("particles-{name}.csv")
            });
            let mut kinds: Vec<Component<String>> = Vec::new();
            for particle in &particles {
                let (shape, material) = (names.shape(particle), names.material(particle).unwrap_or_default());
                if !kinds.iter().any(|c| c.shape == shape && c.material == material) {
                    kinds.push(component(shape, material, 1.0));
                }
            }
            let insert = Insert { motion, ..insertion(name, kinds, Place::File { path: path.clone() }) };
            let section = Section::new("[[insert]]", &insert)?.from(self.scene.start_source.as_ref());
            sections.push(section);
            tables.push((path, particles));
        }
        for plan in &self.scene.inserts {
            let insert = self.insert(plan, grains, names)?;
            let templates = plan.mixture.iter().map(|(template, _)| &template.source);
            sections.push(Section::new("[[insert]]", &insert)?.from([&plan.source]).from(templates));
        }
        Ok(tables)
    }

    fn insert(&self, plan: &InsertPlan, grains: &[Grain], names: &Names) -> Result<Insert<String>, String> {
        let kinds = plan.mixture.iter().map(|(template, share)| {
            let is_it = |g: &&Grain| g.kind == template.kind && g.density == template.density;
            let material = grains.iter().find(is_it).map_or("", |g| g.name.as_str());
            let share = if plan.mixture.len() == 1 { 1.0 } else { *share };
            match template.form {
                Form::Sphere(radius) => Component {
                    diameter: Some(SizeDistribution::Constant { value: 2.0 * radius }),
                    ..component(&names.sphere.0, material, share)
                },
                Form::SphereRange([low, high]) => Component {
                    diameter: Some(SizeDistribution::Uniform {
                        by: grains_case::Basis::Number,
                        min: 2.0 * low,
                        max: 2.0 * high,
                    }),
                    ..component(&names.sphere.0, material, share)
                },
                _ => component(&template.name, material, share),
            }
        });
        let end = self.end();
        let count = plan.count(end);
        let has_batches = plan.batch < count;
        Ok(Insert {
            count: Some(count),
            batch: has_batches.then_some(plan.batch),
            interval: if has_batches { plan.interval } else { 0.0 },
            start: plan.start,
            velocity: plan.velocity,
            angular_velocity: plan.angular_velocity,
            ..insertion(&plan.name, kinds.collect(), plan.place.clone())
        })
    }
}

fn component(shape: &str, material: &str, share: f64) -> Component<String> {
    Component {
        shape: shape.to_owned(),
        material: material.to_owned(),
        share,
        scale: SizeDistribution::default(),
        diameter: None,
    }
}

fn insertion(name: &str, particles: Vec<Component<String>>, place: Place) -> Insert<String> {
    Insert {
        name: name.to_owned(),
        particles,
        count: None,
        place,
        orientation: None,
        motion: None,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        temperature: None,
        start: 0.0,
        interval: 0.0,
        batch: None,
    }
}
