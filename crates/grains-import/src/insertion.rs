//! Insertions of a script: templates, distributions, `insert/…` and `pour`.

use crate::particles::Superquadric;
use crate::regions::{Region, RegionForm};
use crate::report::{Outcome, Source};
use crate::scene::{Form, InsertPlan, Template};
use crate::script::{Answer, Effect, Script};
use crate::units::{ACCELERATION, DENSITY, LENGTH, MASS, MASS_RATE, RATE, TIME, VELOCITY};
use grains_case::{Place, Window, default_spacing, lattice_sites};
use grains_geometry::Vec3;
use std::fs;

/// Share of a region that random places fill at once; beyond it they are too many for it.
const LOOSE: f64 = 0.3;

/// Words of all `insert/…` beside those of each.
struct Common {
    mixture: Vec<(Template, f64)>,
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
    /// Largest radius around a particle (m).
    radius: f64,
    /// Means over the particles: volume (m³) and mass (kg).
    volume: f64,
    mass: f64,
    /// Largest number of particles.
    limit: Option<u64>,
    /// Particles per second.
    rate: Option<f64>,
    /// Time (s) between insertions; none for one insertion.
    every: Option<f64>,
    start: f64,
    keeps_inside: bool,
}

impl Script {
    /// `fix particletemplate/…`.
    pub(crate) fn template(&mut self, id: &str, style: &str, words: &[String], source: &Source) -> Answer {
        let kind = self.number_behind(words, "atom_type")?.or(self.number_behind(words, "type")?);
        let constant = |key: &str| {
            let behind = Self::behind(words, key).ok_or_else(|| format!("{key} is missing"))?;
            match behind {
                [style, rest @ ..] if style == "constant" => Ok(rest),
                _ => Err(format!("{key} that is not constant: give diameter = {{ kind = … }} in the case")),
            }
        };
        let first = |rest: &[String]| self.number(rest.first().map_or("", String::as_str));
        let density = self.units.si(first(constant("density")?)?, DENSITY);
        let form = match style {
            "particletemplate/sphere" => Form::Sphere(self.units.si(first(constant("radius")?)?, LENGTH)),
            "particletemplate/superquadric" => {
                let semi_axes = self.units.vector(self.vector(constant("shape")?, 0)?, LENGTH);
                let exponents = constant("blockiness").or_else(|_| constant("roundness"));
                let blockiness = match exponents {
                    Ok([n1, n2, ..]) => [self.number(n1)?, self.number(n2)?],
                    _ => [2.0; 2],
                };
                Form::Superquadric(Superquadric { semi_axes, blockiness })
            }
            "particletemplate/multisphere" => Form::Spheres(self.spheres(words)?),
            "particletemplate/multiplespheres" => {
                return Err(
                    "spheres that are inserted together and move apart: insert them as spheres".into()
                );
            }
            other => return Err(format!("{other} has no counterpart")),
        };
        let kind = kind.unwrap_or(1.0) as usize;
        let template =
            Template { name: id.to_owned(), kind, density, form, source: source.clone() }.checked()?;
        self.templates.insert(id.to_owned(), template);
        Ok(Outcome::Translated)
    }

    /// Spheres of a rigid body: numbers x y z r, from the command or a file.
    fn spheres(&self, words: &[String]) -> Result<Vec<([f64; 3], f64)>, String> {
        let count = self.number_behind(words, "nspheres")?.ok_or("nspheres is missing")? as usize;
        let behind = Self::behind(words, "spheres").ok_or("spheres are missing")?;
        let (numbers, scale) = match behind {
            [word, name, rest @ ..] if word == "file" => {
                let path = self.file(name);
                let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
                let numbers = text
                    .split_whitespace()
                    .map(|w| w.parse::<f64>().map_err(|_| format!("`{w}` is no number")));
                (numbers.collect::<Result<Vec<_>, _>>()?, self.number_behind(rest, "scale")?.unwrap_or(1.0))
            }
            words => (
                self.numbers(words.get(..count.saturating_mul(4)).ok_or("spheres have four numbers each")?)?,
                1.0,
            ),
        };
        if numbers.len() < count.saturating_mul(4) {
            return Err(format!("{count} spheres are announced, and {} numbers are there", numbers.len()));
        }
        let scale = self.units.si(scale, LENGTH);
        let spheres = numbers.chunks_exact(4).take(count);
        Ok(spheres.map(|s| ([s[0], s[1], s[2]].map(|x| x * scale), s[3] * scale)).collect())
    }

    /// `fix particledistribution/discrete`.
    pub(crate) fn distribution(&mut self, id: &str, style: &str, words: &[String]) -> Answer {
        let [_, count, rest @ ..] = words else { return Err("number of templates is missing".into()) };
        let count = self.number(count)? as usize;
        let is_by_mass = !style.ends_with("numberbased");
        let mut shares = Vec::new();
        for pair in rest.chunks_exact(2).take(count) {
            let template = self.templates.get(&pair[0]);
            let template =
                template.ok_or_else(|| format!("template {} is unknown or was not translated", pair[0]))?;
            let weight = self.number(&pair[1])?;
            let share = if is_by_mass { weight / template.mass() } else { weight };
            shares.push((template.clone(), share));
        }
        let whole: f64 = shares.iter().map(|(_, share)| share).sum();
        if whole <= 0.0 {
            return Err("the weights are all 0".into());
        }
        shares.iter_mut().for_each(|(_, share)| *share /= whole);
        shares.retain(|(_, share)| *share > 0.0);
        if is_by_mass && shares.len() > 1 {
            self.report.remark(format!("{id}: weights of particledistribution/discrete are shares of the mass, shares of a case are of the number"));
        }
        self.distributions.insert(id.to_owned(), shares);
        Ok(Outcome::Translated)
    }

    fn common(&self, words: &[String]) -> Result<Common, String> {
        let name = Self::behind(words, "distributiontemplate").and_then(|w| w.first());
        let name = name.ok_or("distributiontemplate is missing")?;
        let mixture = self.distributions.get(name);
        let mixture =
            mixture.ok_or_else(|| format!("distribution {name} is unknown or was not translated"))?.clone();
        let mean = |of: fn(&Template) -> f64| mixture.iter().map(|(t, share)| share * of(t)).sum::<f64>();
        let (volume, mass) = (mean(|t| t.form.volume()), mean(Template::mass));
        let constant = |key: &str, dimension| match Self::behind(words, key) {
            None => Ok([0.0; 3]),
            Some(rest) => Ok::<_, String>(self.units.vector(self.vector(rest, 1)?, dimension)),
        };
        let si = |key: &str, dimension| {
            let value = self.number_behind(words, key)?;
            Ok::<_, String>(value.map(|value| self.units.si(value, dimension)))
        };
        let word = |key: &str| Self::behind(words, key).and_then(|w| w.first()).map(String::as_str);
        let unless_infinite =
            |key: &str| if word(key) == Some("INF") { Ok(None) } else { self.number_behind(words, key) };
        let count = unless_infinite("nparticles")?.map(|n| n as u64);
        let of_mass = unless_infinite("mass")?.map(|m| (self.units.si(m, MASS) / mass + 1e-9) as u64);
        let per_second = si("particlerate", RATE)?.or(si("massrate", MASS_RATE)?.map(|rate| rate / mass));
        let every = match (word("insert_every"), word("insert_every_time")) {
            (Some("once"), _) => None,
            (Some(steps), _) => Some(self.number(steps)? * self.step_length()?),
            (None, Some(time)) => Some(self.units.si(self.number(time)?, TIME)),
            (None, None) => None,
        };
        let start = match self.number_behind(words, "start")? {
            Some(step) => self.time + (step - self.step as f64).max(0.0) * self.step_length()?,
            None => self.time,
        };
        Ok(Common {
            velocity: constant("vel", VELOCITY)?,
            angular_velocity: constant("omega", RATE)?,
            radius: mixture.iter().map(|(t, _)| t.form.bounding_radius()).fold(0.0, f64::max),
            volume,
            mass,
            limit: count.or(of_mass),
            rate: per_second,
            every,
            start,
            keeps_inside: word("all_in") == Some("yes"),
            mixture,
        })
    }

    fn region_behind(&self, words: &[String]) -> Result<&Region, String> {
        let name = Self::behind(words, "region").and_then(|w| w.first()).ok_or("the region is missing")?;
        self.region(name)
    }

    /// `fix insert/pack`: fills a region up.
    pub(crate) fn insert_pack(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let common = self.common(words)?;
        let region = self.region_behind(words)?.clone();
        let volume = region.volume(if common.keeps_inside { common.radius } else { 0.0 });
        let batch = match (
            self.number_behind(words, "particles_in_region")?,
            self.number_behind(words, "volumefraction_region")?,
            self.number_behind(words, "mass_in_region")?,
        ) {
            (Some(count), ..) => count,
            (_, Some(fraction), _) => fraction * volume / common.volume,
            (.., Some(mass)) => self.units.si(mass, MASS) / common.mass,
            _ => return Err("particles_in_region, volumefraction_region or mass_in_region is missing".into()),
        };
        let batch = (batch + 1e-9).floor().max(1.0) as u64;
        if common.every.is_some() {
            self.report.remark(format!("{id}: insert/pack fills its region up to {batch} particles at each insertion; here each batch has as many, and waits for room"));
        }
        let place = self.place(id, &region, &common, batch)?;
        Ok((Outcome::Translated, self.insert(id, source, common, batch, place)))
    }

    /// `fix insert/rate/region`.
    pub(crate) fn insert_rate(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let common = self.common(words)?;
        let region = self.region_behind(words)?.clone();
        let (rate, every) = (common.rate.ok_or("particlerate or massrate is missing")?, common.every);
        let batch = (rate * every.ok_or("insert_every is missing")?).round().max(1.0);
        let common = Common { every: Some(batch / rate), ..common };
        let place = self.place(id, &region, &common, batch as u64)?;
        Ok((Outcome::Translated, self.insert(id, source, common, batch as u64, place)))
    }

    /// `fix insert/stream`: a stream through a face.
    pub(crate) fn insert_stream(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let common = self.common(words)?;
        let name = Self::behind(words, "insertion_face")
            .and_then(|w| w.first())
            .ok_or("insertion_face is missing")?;
        let mesh =
            self.meshes.get(name).ok_or_else(|| format!("mesh {name} is unknown or was not translated"))?;
        let rate = common.rate.ok_or("particlerate or massrate is missing")?;
        let triangles = mesh.placed.triangles()?;
        let (lower, upper) = triangles.extents();
        let velocity = Vec3::from(common.velocity);
        let normal = triangles.triangles.first().map(|_| {
            let [a, b, c] = triangles.corners(0);
            let normal = (b - a).cross(&(c - a)).normalize();
            let is_along = normal.dot(&velocity) > 0.0;
            if is_along { normal } else { -normal }
        });
        let normal = normal.ok_or("the insertion face has no triangle")?;
        let speed = normal.dot(&velocity);
        if speed < 1e-3 {
            return Err("the velocity does not lead through the insertion face".into());
        }
        let extrusion = self.number_behind(words, "extrude_length")?.map(|x| self.units.si(x, LENGTH));
        let depth = match (extrusion, common.every) {
            (Some(depth), _) => depth,
            (None, Some(every)) => every * speed,
            (None, None) => return Err("extrude_length or insert_every is missing".into()),
        };
        let back = -normal * depth;
        let corners = [lower, upper, lower + back, upper + back];
        let along = |axis: usize| corners.iter().map(move |c| c[axis]);
        let block = RegionForm::Block {
            lower: std::array::from_fn(|a| along(a).fold(f64::INFINITY, f64::min)),
            upper: std::array::from_fn(|a| along(a).fold(f64::NEG_INFINITY, f64::max)),
        };
        let region = Region { form: block, is_inside: true, open: Vec::new(), moves: false };
        let batch = (rate * depth / speed).round().max(1.0);
        let common = Common { every: Some(batch / rate), ..common };
        self.report.remark(format!("{id}: the particles of insert/stream start in a box around the face and its extrusion, where they are free to move at once; there they come through the face with their velocity"));
        let place = self.place(id, &region, &common, batch as u64)?;
        Ok((Outcome::Translated, self.insert(id, source, common, batch as u64, place)))
    }

    /// `fix pour` of LAMMPS.
    pub(crate) fn pour(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let [count, kind, _seed, rest @ ..] = words else {
            return Err("number and type of particles are missing".into());
        };
        let region = self.region_behind(rest)?.clone();
        let radii = match Self::behind(rest, "diam") {
            Some([style, size, ..]) if style == "one" => [0.5 * self.length(size)?; 2],
            Some([style, low, high, ..]) if style == "range" => {
                [0.5 * self.length(low)?, 0.5 * self.length(high)?]
            }
            Some([low, high, ..]) if low != "poly" => [0.5 * self.length(low)?, 0.5 * self.length(high)?],
            Some(_) => return Err("diam poly: give diameter = { kind = \"table\" } in the case".into()),
            None => [self.units.si(0.5, LENGTH); 2],
        };
        let density = match Self::behind(rest, "dens") {
            Some([low, high, ..]) if low == high => self.number(low)?,
            Some(_) => return Err("densities that differ: a material has one".into()),
            None => 1.0,
        };
        let form = if radii[0] == radii[1] { Form::Sphere(radii[0]) } else { Form::SphereRange(radii) };
        let template = Template {
            name: id.to_owned(),
            kind: self.number(kind)? as usize,
            density: self.units.si(density, DENSITY),
            form,
            source: source.clone(),
        }
        .checked()?;
        let fraction = match Self::behind(rest, "vol") {
            Some(words) => self.number(words.first().map_or("", String::as_str))?,
            None => 0.25,
        };
        let limit = self.number(count)? as u64;
        let batch = (fraction * region.volume(0.0) / template.form.volume()).floor().max(1.0) as u64;
        let batch = batch.min(limit);
        let gravity =
            self.scene.gravity.as_ref().map_or(self.units.si(1.0, ACCELERATION), |(g, _)| {
                g.iter().map(|x| x * x).sum::<f64>().sqrt()
            });
        let height = match &region.form {
            RegionForm::Block { lower, upper } => upper[2] - lower[2],
            RegionForm::Cone { ends, .. } => ends[1] - ends[0],
            RegionForm::Sphere { radius, .. } => 2.0 * radius,
            RegionForm::Plane { .. } => return Err("a half space holds no insertion".into()),
        };
        let mut velocity = [0.0; 3];
        if let Some([x_low, x_high, y_low, y_high, z, ..]) = Self::behind(rest, "vel") {
            let mean = |a: &String, b: &String| Ok::<_, String>(0.5 * (self.number(a)? + self.number(b)?));
            velocity =
                self.units.vector([mean(x_low, x_high)?, mean(y_low, y_high)?, self.number(z)?], VELOCITY);
        }
        // The time in which a batch has left the region.
        let fall =
            ((velocity[2] * velocity[2] + 2.0 * gravity * height).sqrt() - velocity[2].abs()) / gravity;
        let common = Common {
            radius: radii[1],
            volume: template.form.volume(),
            mass: template.mass(),
            mixture: vec![(template, 1.0)],
            velocity,
            angular_velocity: [0.0; 3],
            limit: Some(limit),
            rate: None,
            every: (batch < limit).then_some(fall),
            start: self.time,
            keeps_inside: true,
        };
        self.report.remark(format!("{id}: fix pour inserts when the last batch has fallen out of the region; here every {} s, and batches wait for room", crate::laws::shown(fall)));
        let place = self.place(id, &region, &common, batch)?;
        Ok((Outcome::Translated, self.insert(id, source, common, batch, place)))
    }

    /// Places of a batch in a region: random ones if they are loose enough, else a lattice, else random ones that wait.
    fn place(&mut self, id: &str, region: &Region, common: &Common, batch: u64) -> Result<Place, String> {
        let margin = if common.keeps_inside { common.radius } else { 0.0 };
        let (window, is_whole) = region.window(margin)?;
        let window = self.within_box(window, common.radius)?;
        if !is_whole {
            self.report.remark(format!("{id}: the region is round, and places of a case lie in boxes and discs: taken is the largest box inside"));
        }
        let retry = common.every;
        let Window::Box { lower, upper } = &window else {
            return Ok(Place::Window { window, attempts: 1000, retry });
        };
        let (mut lower, mut upper) = (lower.map(|x| x - common.radius), upper.map(|x| x + common.radius));
        if let Some(([low, high], _)) = &self.scene.corners {
            lower = std::array::from_fn(|a| lower[a].max(low[a]));
            upper = std::array::from_fn(|a| upper[a].min(high[a]));
        }
        let room: f64 = (0..3).map(|a| upper[a] - lower[a]).product();
        let fill = batch as f64 * common.volume / room;
        if fill <= LOOSE {
            return Ok(Place::Window { window, attempts: 1000, retry });
        }
        let is_there = |noise: f64| {
            let sites = lattice_sites(lower, upper, default_spacing(common.radius, noise));
            sites.iter().product::<u64>() >= batch
        };
        if retry.is_none()
            && let Some(noise) = [0.1, 0.05, 0.02, 0.0].into_iter().find(|noise| is_there(*noise))
        {
            self.report.remark(format!("{id}: {batch} particles fill {} of their box, too much for random places; they start on a lattice", crate::laws::shown(fill)));
            let spacing = Some(default_spacing(common.radius, noise));
            return Ok(Place::Lattice { lower, upper, spacing, noise });
        }
        let wait = retry.unwrap_or(0.01);
        self.report.remark(format!("{id}: {batch} particles fill {} of their box, too much for random places at once; they wait for room", crate::laws::shown(fill)));
        Ok(Place::Window { window, attempts: 1000, retry: Some(wait) })
    }

    /// A window cut to where whole particles are inside the box of the script.
    fn within_box(&self, window: Window, radius: f64) -> Result<Window, String> {
        let (Window::Box { mut lower, mut upper }, Some(([low, high], _))) =
            (window.clone(), &self.scene.corners)
        else {
            return Ok(window);
        };
        for axis in 0..3 {
            let margin = if self.scene.periodic()[axis] { 0.0 } else { radius };
            lower[axis] = lower[axis].max(low[axis] + margin);
            upper[axis] = upper[axis].min(high[axis] - margin);
            if lower[axis] > upper[axis] {
                return Err("no place for a whole particle in the region and the box".into());
            }
        }
        Ok(Window::Box { lower, upper })
    }

    fn insert(&mut self, id: &str, source: &Source, common: Common, batch: u64, place: Place) -> Effect {
        self.scene.inserts.push(InsertPlan {
            name: id.to_owned(),
            source: source.clone(),
            mixture: common.mixture,
            limit: common.limit,
            batch,
            interval: common.every.unwrap_or(0.0),
            start: common.start,
            until: None,
            place,
            velocity: common.velocity,
            angular_velocity: common.angular_velocity,
        });
        Effect::Insert(self.scene.inserts.len() - 1)
    }
}
