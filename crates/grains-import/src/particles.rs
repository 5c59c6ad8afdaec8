//! Particles of a data file or of a frame of a dump, in SI units, and the table that a case reads.

use grains_geometry::Shape;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// A superellipsoid ((x/a)^n₂ + (y/b)^n₂)^(n₁/n₂) + (z/c)^n₁ = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Superquadric {
    /// Half lengths a, b, c (m).
    pub semi_axes: [f64; 3],
    /// Exponents n₁ and n₂ (-), 2 for an ellipsoid.
    pub blockiness: [f64; 2],
}

impl Superquadric {
    /// Its volume (m³), if it is one.
    pub fn volume(&self) -> Option<f64> {
        let shape = Shape::superellipsoid(self.semi_axes.into(), self.eps(), 0.01).ok()?;
        Some(shape.volume)
    }

    /// Exponents of the meridian and of the x-y section as a case has them (-), 2/n₁ and 2/n₂.
    pub fn eps(&self) -> [f64; 2] {
        self.blockiness.map(|n| 2.0 / n)
    }
}

/// Volumes of forms, each computed once.
#[derive(Default)]
pub struct Volumes(Vec<(Superquadric, Option<f64>)>);

impl Volumes {
    /// The volume of a form (m³), if it has one.
    pub fn of(&mut self, shape: Superquadric) -> Option<f64> {
        if let Some((_, volume)) = self.0.iter().find(|(known, _)| *known == shape) {
            return *volume;
        }
        self.0.push((shape, shape.volume()));
        self.0.last().and_then(|(_, volume)| *volume)
    }
}

/// A particle.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle {
    /// Its number in the file.
    pub id: u64,
    /// Its type, from 1.
    pub kind: usize,
    /// Centre (m).
    pub position: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Angular velocity (rad/s).
    pub angular_velocity: [f64; 3],
    /// Radius (m), if the file gives one; of other shapes that of a sphere around them.
    pub radius: Option<f64>,
    /// Density (kg/m³), if the file gives it or a mass.
    pub density: Option<f64>,
    /// Its form, if it is no sphere.
    pub shape: Option<Superquadric>,
    /// Quaternion (w, x, y, z), if the file gives one.
    pub orientation: Option<[f64; 4]>,
}

/// Refuses sizes (m) and densities (kg/m³) that no body has.
///
/// # Errors
/// The first that is not above 0.
pub fn check_sizes(sizes: impl IntoIterator<Item = f64>, density: Option<f64>) -> Result<(), String> {
    let is_real = |x: f64| x > 0.0 && x.is_finite();
    if let Some(size) = sizes.into_iter().find(|size| !is_real(*size)) {
        return Err(format!("a size of {size:e} m: sizes must be above 0"));
    }
    match density.filter(|density| !is_real(*density)) {
        Some(density) => Err(format!("a density of {density:e} kg/m3: densities must be above 0")),
        None => Ok(()),
    }
}

impl Particle {
    /// Refuses sizes and densities that no particle has.
    ///
    /// # Errors
    /// The first that is not above 0, with the number of the particle.
    pub fn check(&self) -> Result<(), String> {
        let sizes = self.radius.into_iter().chain(self.shape.into_iter().flat_map(|shape| shape.semi_axes));
        check_sizes(sizes, self.density).map_err(|e| format!("atom {} has {e}", self.id))
    }

    /// A sphere at rest at the origin that nothing is known of but its number and type.
    pub fn new(id: u64, kind: usize) -> Self {
        Self {
            id,
            kind,
            position: [0.0; 3],
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            radius: None,
            density: None,
            shape: None,
            orientation: None,
        }
    }
}

/// What a table says of each particle beside place and motion.
pub struct Names {
    /// Names of the materials by type and density.
    pub materials: BTreeMap<(usize, u64), String>,
    /// Names of the forms that are no spheres.
    pub shapes: Vec<(Superquadric, String)>,
    /// Name of the sphere, and its radius (m).
    pub sphere: (String, f64),
}

/// A density (kg/m³) as a key: equal to nine digits or not.
pub fn density_key(density: f64) -> u64 {
    format!("{density:.8e}").parse::<f64>().unwrap_or(density).to_bits()
}

impl Names {
    /// The name of the form of a particle.
    pub fn shape(&self, particle: &Particle) -> &str {
        let wanted = particle.shape;
        let found = self.shapes.iter().find(|(shape, _)| Some(*shape) == wanted);
        found.map_or(self.sphere.0.as_str(), |(_, name)| name)
    }

    /// The name of the material of a particle.
    pub fn material(&self, particle: &Particle) -> Option<&str> {
        let key = (particle.kind, density_key(particle.density?));
        self.materials.get(&key).map(String::as_str)
    }
}

/// Writes the table that `place = { kind = "file" }` of a case reads; `names` adds forms and materials.
///
/// # Errors
/// Those of writing.
pub fn write_csv(out: &mut impl Write, particles: &[Particle], names: Option<&Names>) -> io::Result<()> {
    let has_radii = particles.iter().all(|p| p.shape.is_none() && p.radius.is_some());
    let turns = particles.iter().any(|p| p.orientation.is_some());
    let unit =
        names.filter(|_| !has_radii && particles.iter().any(|p| p.shape.is_none())).map(|n| n.sphere.1);
    let mut header = vec!["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"];
    header.extend(has_radii.then_some("radius"));
    header.extend(unit.map(|_| "scale"));
    header.extend(turns.then_some(["qw", "qx", "qy", "qz"]).into_iter().flatten());
    header.extend(names.map(|_| ["shape", "material"]).into_iter().flatten());
    writeln!(out, "{}", header.join(","))?;
    for p in particles {
        let kinematics = [p.position, p.velocity, p.angular_velocity].concat();
        let mut fields: Vec<String> = kinematics.iter().map(f64::to_string).collect();
        if has_radii {
            fields.extend(p.radius.map(|r| r.to_string()));
        }
        if let Some(unit) = unit {
            let scale = if p.shape.is_some() { 1.0 } else { p.radius.unwrap_or(unit) / unit };
            fields.push(scale.to_string());
        }
        if turns {
            fields.extend(p.orientation.unwrap_or([1.0, 0.0, 0.0, 0.0]).map(|q| q.to_string()));
        }
        if let Some(names) = names {
            fields.push(names.shape(p).to_owned());
            fields.push(names.material(p).unwrap_or_default().to_owned());
        }
        writeln!(out, "{}", fields.join(","))?;
    }
    Ok(())
}
