//! All particles of a rank and the arrays of the fluid.

use crate::drag::Flow;
use crate::{
    Coefficient, CouplingError, DragLaw, DragLink, Fluid, GridAxis, Kernel, Layout, ShapeFactors,
    ShapeProfile, Site, SiteWeights, Stencil, TransferLink,
};
use grains_dem::{Body, Catalogue, Particles};
use grains_fluid::MixtureModel;
use grains_geometry::Vec3;
use multiversion::multiversion;

/// The cells of one rank with their halo, and where fields on them lie.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cells along x, y, z.
    pub axes: [GridAxis; 3],
    /// Layout of cell fields.
    pub cells: Layout,
    /// Layouts of the fields on faces normal to x, y, z.
    pub faces: [Layout; 3],
    /// What walls leave open, if some bound the fluid.
    pub open: Option<OpenShares>,
}

/// Open shares of cells and faces (-), in arrays like those of the fields: particles act on the fluid where there is some.
#[derive(Clone, Debug)]
pub struct OpenShares {
    /// Of the cells' volumes.
    pub cells: Vec<f64>,
    /// Of the areas of faces normal to x, y, z.
    pub faces: [Vec<f64>; 3],
}

impl Grid {
    fn layout(&self, site: Site) -> &Layout {
        match site {
            Site::Cells => &self.cells,
            Site::Faces(axis) | Site::InnerFaces(axis) => &self.faces[axis],
        }
    }

    fn open(&self, site: Site) -> Option<&[f64]> {
        let open = self.open.as_ref()?;
        Some(match site {
            Site::Cells => &open.cells,
            Site::Faces(axis) | Site::InnerFaces(axis) => &open.faces[axis],
        })
    }

    /// Finds the weights of a particle at a site, of what is open; where nothing is, of all.
    #[inline(always)]
    pub fn weigh(&self, stencil: &mut Stencil, site: Site, weights: &mut SiteWeights) {
        stencil.weigh(site, self.layout(site), weights);
        if let Some(open) = self.open(site) {
            weights.restrict(open);
        }
    }

    /// Makes the weights of the inner faces normal to an axis those on which a particle acts and which press on it: also the faces on a
    /// boundary of the domain, which bears the drag of its half cell, but beside walls, which may close them. Tells whether they are others.
    #[inline(always)]
    fn add_boundary_faces(&self, stencil: &mut Stencil, axis: usize, faces: &mut SiteWeights) -> bool {
        let has_more = self.open.is_none() && stencil.has_boundary_faces(axis);
        if has_more {
            self.weigh(stencil, Site::Faces(axis), faces);
        }
        has_more
    }

    /// Void fraction of what is open under a kernel, from that of whole cells, Σ w ψ/Σ w V.
    #[inline(always)]
    fn void_fraction(&self, stencil: &mut Stencil, cells: &mut SiteWeights, void_fraction: &[f64]) -> f64 {
        stencil.weigh(Site::Cells, &self.cells, cells);
        let (whole, open) = match &self.open {
            Some(open) => cells.means([void_fraction, &open.cells]).into(),
            None => (cells.means([void_fraction])[0], 1.0),
        };
        if open > 0.0 { whole / open } else { whole }
    }
}

/// Fields of the fluid that act on particles, halo filled.
#[derive(Clone, Copy, Debug)]
pub struct FluidFields<'a> {
    /// Interstitial velocity on the faces normal to x, y, z (m/s); those on a boundary of the domain are not read.
    pub velocity: [&'a [f64]; 3],
    /// Void fraction in the cells (-), of whole cells.
    pub void_fraction: &'a [f64],
    /// Pressure gradient, without its hydrostatic part, on the faces normal to x, y, z (Pa/m); on a boundary of the domain
    /// the one that balances the drag there.
    pub pressure_gradient: [&'a [f64]; 3],
}

/// What particles do to the fluid, on the faces normal to x, y, z, before the halo is added; amounts, not densities.
#[derive(Debug)]
pub struct DragFields<'a> {
    /// Sum of the coefficients K (N s/m).
    pub coefficient: [&'a mut [f64]; 3],
    /// Explicit forces K v̂ − unpaid/Δt (N).
    pub explicit: [&'a mut [f64]; 3],
}

/// How particles and fluid act on each other.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// How particles are spread over cells.
    pub kernel: Kernel,
    /// Drag law.
    pub law: DragLaw,
    /// Who feels the pressure gradient.
    pub model: MixtureModel,
    /// The fluid.
    pub fluid: Fluid,
    /// Gravity (m/s²).
    pub gravity: Vec3,
    /// Drag is found for a void fraction of at least this (-).
    pub min_void_fraction: f64,
    /// Volume and outline of each shape of the catalogue, and one over its bounding radius (1/m).
    profiles: Vec<(ShapeProfile, f64)>,
}

impl Coupling {
    /// Measures the shapes of a catalogue; see [`ShapeProfile::new`] for the time it takes and errors.
    pub fn new(
        kernel: Kernel,
        law: DragLaw,
        model: MixtureModel,
        fluid: Fluid,
        gravity: Vec3,
        catalogue: &Catalogue,
    ) -> Result<Self, CouplingError> {
        let measured = |shape| Ok((ShapeProfile::new(shape)?, 1.0 / shape.bounding_radius));
        let profiles = catalogue.shapes.iter().map(measured).collect::<Result<_, CouplingError>>()?;
        Ok(Self { kernel, law, model, fluid, gravity, min_void_fraction: 0.2, profiles })
    }

    /// Outline of a shape of the catalogue.
    pub fn profile(&self, shape: u16) -> &ShapeProfile {
        &self.profiles[shape as usize].0
    }

    /// Diameter (m) of the sphere of a particle's volume.
    #[inline]
    pub fn equivalent_diameter(&self, body: &Body) -> f64 {
        let (profile, per_radius) = &self.profiles[body.kind.shape as usize];
        profile.equivalent_diameter * (body.radius * per_radius)
    }

    /// Volume (m³) of a particle.
    #[inline]
    pub fn volume(&self, body: &Body) -> f64 {
        let (profile, per_radius) = &self.profiles[body.kind.shape as usize];
        profile.volume * (body.radius * per_radius).powi(3)
    }

    /// Area (m²) of the surface of a particle: that of the sphere of its volume over the sphericity.
    #[inline]
    pub fn area(&self, body: &Body) -> f64 {
        let diameter = self.equivalent_diameter(body);
        std::f64::consts::PI * diameter * diameter / self.profile(body.kind.shape).sphericity
    }

    /// Adds the volume of all owned particles to the cells (m³ per cell), before the halo is added.
    ///
    /// Errors: a particle whose kernel leaves the halo.
    pub fn deposit_volume(
        &self,
        particles: &Particles,
        grid: &Grid,
        solid: &mut [f64],
    ) -> Result<(), CouplingError> {
        self.deposit_volumes(particles.bodies[..particles.owned].iter(), 1.0, grid, solid)
    }

    /// Adds the volume of some bodies, times a sign, to the cells (m³ per cell), before the halo is added.
    ///
    /// Errors: a body whose kernel leaves the halo.
    pub fn deposit_volumes<'a>(
        &self,
        bodies: impl Iterator<Item = &'a Body>,
        sign: f64,
        grid: &Grid,
        solid: &mut [f64],
    ) -> Result<(), CouplingError> {
        let (mut stencil, mut cells) = (Stencil::default(), SiteWeights::default());
        for body in bodies {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            grid.weigh(&mut stencil, Site::Cells, &mut cells);
            cells.share([sign * self.volume(body)], [solid]);
        }
        Ok(())
    }

    /// Finds the drag of all owned particles at the fluid's old velocity, and adds what the fluid's new one needs to
    /// know of it, before the halo is added. `time_step` is that of the fluid (s). `passings` gets the Reynolds number and the void
    /// fraction of each particle.
    ///
    /// Errors: a particle whose kernel leaves the halo.
    pub fn deposit_drag(
        &self,
        particles: &mut Particles,
        (grid, fluid): (&Grid, &FluidFields),
        drag: &mut DragFields,
        time_step: f64,
        passings: Option<&mut Vec<[f64; 2]>>,
    ) -> Result<(), CouplingError> {
        deposit_drag(self, particles, (grid, fluid), drag, (time_step, passings))
    }

    /// Gives all owned particles the fluid's new velocity, pressure gradient and buoyancy. They must not have moved since
    /// [`Coupling::deposit_drag`].
    ///
    /// Errors: a particle whose kernel leaves the halo.
    pub fn set_fluid_velocities(
        &self,
        particles: &mut Particles,
        (grid, fluid): (&Grid, &FluidFields),
        time_step: f64,
    ) -> Result<(), CouplingError> {
        set_fluid_velocities(self, particles, (grid, fluid), time_step)
    }

    /// Adds what all owned particles exchange with a scalar of the fluid, before the halo is added: to the coefficients K (m³/s) and to
    /// K φ of the values φ at which nothing is exchanged. `links` has both of each particle.
    ///
    /// Errors: a particle whose kernel leaves the halo.
    pub fn deposit_transfer(
        &self,
        particles: &Particles,
        grid: &Grid,
        links: &[TransferLink],
        [coefficient, explicit]: [&mut [f64]; 2],
    ) -> Result<(), CouplingError> {
        let (mut stencil, mut cells) = (Stencil::default(), SiteWeights::default());
        for (body, link) in particles.bodies[..particles.owned].iter().zip(links) {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            grid.weigh(&mut stencil, Site::Cells, &mut cells);
            cells.share([link.coefficient, link.coefficient * link.value], [coefficient, explicit]);
        }
        Ok(())
    }

    /// Calls `visit` with the number of every body and the mean of a scalar of the fluid under its kernel, halo filled. What cells got by
    /// [`Coupling::deposit_transfer`] at these values is the sum of K (φ − mean) of the particles.
    ///
    /// Errors: a particle whose kernel leaves the halo.
    pub fn for_each_mean(
        &self,
        bodies: &[Body],
        grid: &Grid,
        scalar: &[f64],
        mut visit: impl FnMut(usize, f64),
    ) -> Result<(), CouplingError> {
        let (mut stencil, mut cells) = (Stencil::default(), SiteWeights::default());
        for (i, body) in bodies.iter().enumerate() {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            grid.weigh(&mut stencil, Site::Cells, &mut cells);
            visit(i, cells.means([scalar])[0]);
        }
        Ok(())
    }

    /// Drag coefficient of an owned particle at a slip u − v (m/s) and void fraction, that of the model chosen.
    pub fn drag(&self, particles: &Particles, i: usize, slip: &Vec3, void_fraction: f64) -> Coefficient {
        let body = &particles.bodies[i];
        let void_fraction = void_fraction.clamp(self.min_void_fraction, 1.0);
        let diameter = self.equivalent_diameter(body);
        let speed = slip.norm();
        let reynolds = self.fluid.reynolds(diameter, void_fraction, speed);
        let shape = if self.law.depends_on_shape() {
            let profile = self.profile(body.kind.shape);
            match particles.frames.get(i) {
                Some(frame) if speed > 0.0 => profile.factors(&frame.tr_mul(&(slip / speed))),
                Some(_) => ShapeFactors::any_orientation(profile.sphericity),
                None => ShapeFactors::SPHERE,
            }
        } else {
            ShapeFactors::SPHERE
        };
        let flow = Flow { reynolds, void_fraction, shape };
        let drag = self.law.growing_coefficient(&self.fluid, diameter, &flow);
        Coefficient { value: drag.value * self.model.drag_factor(void_fraction), ..drag }
    }
}

/// See [`Coupling::deposit_drag`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn deposit_drag(
    coupling: &Coupling,
    particles: &mut Particles,
    (grid, fluid): (&Grid, &FluidFields),
    drag: &mut DragFields,
    (time_step, mut passings): (f64, Option<&mut Vec<[f64; 2]>>),
) -> Result<(), CouplingError> {
    assert_eq!(particles.cargo.len(), particles.owned, "coupled particles carry their links");
    let mut stencil = Stencil::default();
    let (mut cells, mut faces) = (SiteWeights::default(), <[SiteWeights; 3]>::default());
    if let Some(passings) = &mut passings {
        passings.clear();
    }
    for i in 0..particles.owned {
        let body = &particles.bodies[i];
        let diameter = coupling.equivalent_diameter(body);
        stencil.place(&coupling.kernel, &grid.axes, &body.position, diameter)?;
        let velocity = Vec3::from_fn(|a, _| {
            grid.weigh(&mut stencil, Site::InnerFaces(a), &mut faces[a]);
            faces[a].means([fluid.velocity[a]])[0]
        });
        let slip = velocity - body.velocity;
        let void_fraction = grid.void_fraction(&mut stencil, &mut cells, fluid.void_fraction);
        if let Some(passings) = &mut passings {
            let void_fraction = void_fraction.clamp(coupling.min_void_fraction, 1.0);
            let reynolds = coupling.fluid.reynolds(diameter, void_fraction, slip.norm());
            passings.push([reynolds, void_fraction]);
        }
        let mut link = DragLink::read(&particles.cargo[i]);
        link.linearise(&coupling.drag(particles, i, &slip, void_fraction), &slip);
        let (coefficient, explicit) = link.fluid_terms(&particles.half_velocity[i], time_step);
        for (a, faces) in faces.iter_mut().enumerate() {
            grid.add_boundary_faces(&mut stencil, a, faces);
            faces.share([coefficient, explicit[a]], [drag.coefficient[a], drag.explicit[a]]);
        }
        particles.cargo[i] = link.write();
    }
    Ok(())
}

/// See [`Coupling::set_fluid_velocities`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn set_fluid_velocities(
    coupling: &Coupling,
    particles: &mut Particles,
    (grid, fluid): (&Grid, &FluidFields),
    time_step: f64,
) -> Result<(), CouplingError> {
    assert_eq!(particles.cargo.len(), particles.owned, "coupled particles carry their links");
    let (mut stencil, mut faces) = (Stencil::default(), SiteWeights::default());
    for i in 0..particles.owned {
        let body = &particles.bodies[i];
        stencil.place(&coupling.kernel, &grid.axes, &body.position, coupling.equivalent_diameter(body))?;
        let (mut velocity, mut gradient) = (Vec3::zeros(), Vec3::zeros());
        for a in 0..3 {
            grid.weigh(&mut stencil, Site::InnerFaces(a), &mut faces);
            [velocity[a], gradient[a]] = faces.means([fluid.velocity[a], fluid.pressure_gradient[a]]);
            if grid.add_boundary_faces(&mut stencil, a, &mut faces) {
                [gradient[a]] = faces.means([fluid.pressure_gradient[a]]);
            }
        }
        let mut link = DragLink::read(&particles.cargo[i]);
        link.set_fluid_velocity(&velocity, &particles.half_velocity[i], time_step);
        let volume = coupling.volume(body);
        link.pressure = buoyancy(coupling.fluid.density, volume, &coupling.gravity);
        if coupling.model == MixtureModel::A {
            link.pressure -= gradient * volume;
        }
        particles.cargo[i] = link.write();
    }
    Ok(())
}

/// Buoyancy −ρ V g (N) of a volume V (m³) in a fluid of density ρ (kg/m³) under gravity g (m/s²), the force of the
/// hydrostatic pressure, in both models.
pub fn buoyancy(fluid_density: f64, volume: f64, gravity: &Vec3) -> Vec3 {
    gravity * (-fluid_density * volume)
}

/// Void fractions ψ = o − solid/V in the place of the solid volumes (m³), of the cells (i, j, k) of `cells` ranges; o is the open
/// share of the cell, 1 without walls.
///
/// Errors: a void fraction ψ/o below the limit, with the place of the cell.
pub fn void_fractions(
    grid: &Grid,
    cells: [std::ops::Range<usize>; 3],
    limit: f64,
    solid: &mut [f64],
) -> Result<(), CouplingError> {
    let nodes = [0, 1, 2].map(|a| grid.axes[a].nodes());
    let width = |a: usize, i: usize| nodes[a][i + 1] - nodes[a][i];
    let [xs, ys, zs] = cells;
    for k in zs {
        for j in ys.clone() {
            let row = grid.cells.offset + j * grid.cells.stride[0] + k * grid.cells.stride[1];
            let section = width(1, j) * width(2, k);
            for i in xs.clone() {
                let value = &mut solid[row + i];
                let open = grid.open.as_ref().map_or(1.0, |open| open.cells[row + i]);
                *value = open - *value / (width(0, i) * section);
                if *value < limit * open || value.is_nan() {
                    let middle = |a: usize, c: usize| 0.5 * (nodes[a][c] + nodes[a][c + 1]);
                    let [x, y, z] = [middle(0, i), middle(1, j), middle(2, k)];
                    let place = format!("({x:.4e}, {y:.4e}, {z:.4e}) m");
                    let void_fraction = if open > 0.0 { *value / open } else { *value };
                    return Err(CouplingError::Jammed { void_fraction, limit, place });
                }
            }
        }
    }
    Ok(())
}
