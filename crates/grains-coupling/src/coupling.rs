//! All particles of a rank and the arrays of the fluid.

use crate::drag::Flow;
use crate::{
    Coefficient, CouplingError, DragLaw, DragLink, Fluid, GridAxis, Kernel, Layout, ShapeFactors,
    ShapeProfile, Site, Stencil, TransferLink,
};
use grains_dem::{Body, Catalogue, Particles};
use grains_fluid::MixtureModel;
use grains_geometry::Vec3;

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

    /// Faces normal to an axis on which a particle acts: also those on a boundary of the domain, which bears the drag of its half
    /// cell, but beside walls, which may close them.
    fn faces_of_force(&self, axis: usize) -> Site {
        if self.open.is_some() { Site::InnerFaces(axis) } else { Site::Faces(axis) }
    }

    /// Mean of a field under a kernel, over what is open: Σ w o f/Σ w o; where nothing is, over all.
    #[inline]
    pub fn mean(&self, stencil: &Stencil, site: Site, field: &[f64]) -> f64 {
        let layout = self.layout(site);
        if let Some(open) = self.open(site) {
            let [share, sum] = stencil.open_sums(site, layout, open, field);
            if share > 0.0 {
                return sum / share;
            }
        }
        stencil.interpolate(site, layout, field)
    }

    /// Shares an amount among what is open under a kernel: f += w o/(Σ w o) · amount; where nothing is, among all.
    #[inline]
    pub fn share(&self, stencil: &Stencil, site: Site, amount: f64, field: &mut [f64]) {
        let layout = self.layout(site);
        if let Some(open) = self.open(site) {
            let share = stencil.interpolate(site, layout, open);
            if share > 0.0 {
                stencil.for_each(site, layout, |at, w| field[at] += amount / share * w * open[at]);
                return;
            }
        }
        stencil.deposit(site, layout, amount, field);
    }

    /// Void fraction of what is open under a kernel, from that of whole cells, Σ w ψ/Σ w V.
    #[inline]
    fn void_fraction(&self, stencil: &Stencil, void_fraction: &[f64]) -> f64 {
        let of_cells = |field: &[f64]| stencil.interpolate(Site::Cells, &self.cells, field);
        match self.open.as_ref().map(|open| of_cells(&open.cells)) {
            Some(open) if open > 0.0 => of_cells(void_fraction) / open,
            _ => of_cells(void_fraction),
        }
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
        let mut stencil = Stencil::default();
        for body in bodies {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            grid.share(&stencil, Site::Cells, sign * self.volume(body), solid);
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
        mut passings: Option<&mut Vec<[f64; 2]>>,
    ) -> Result<(), CouplingError> {
        assert_eq!(particles.cargo.len(), particles.owned, "coupled particles carry their links");
        let mut stencil = Stencil::default();
        if let Some(passings) = &mut passings {
            passings.clear();
        }
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            let diameter = self.equivalent_diameter(body);
            stencil.place(&self.kernel, &grid.axes, &body.position, diameter)?;
            let slip = velocity_at(&stencil, grid, fluid) - body.velocity;
            let void_fraction = grid.void_fraction(&stencil, fluid.void_fraction);
            if let Some(passings) = &mut passings {
                let void_fraction = void_fraction.clamp(self.min_void_fraction, 1.0);
                let reynolds = self.fluid.reynolds(diameter, void_fraction, slip.norm());
                passings.push([reynolds, void_fraction]);
            }
            let mut link = DragLink::read(&particles.cargo[i]);
            link.linearise(&self.drag(particles, i, &slip, void_fraction), &slip);
            let (coefficient, explicit) = link.fluid_terms(&particles.half_velocity[i], time_step);
            for a in 0..3 {
                let site = grid.faces_of_force(a);
                grid.share(&stencil, site, coefficient, drag.coefficient[a]);
                grid.share(&stencil, site, explicit[a], drag.explicit[a]);
            }
            particles.cargo[i] = link.write();
        }
        Ok(())
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
        assert_eq!(particles.cargo.len(), particles.owned, "coupled particles carry their links");
        let mut stencil = Stencil::default();
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            let velocity = velocity_at(&stencil, grid, fluid);
            let mut link = DragLink::read(&particles.cargo[i]);
            link.set_fluid_velocity(&velocity, &particles.half_velocity[i], time_step);
            let volume = self.volume(body);
            link.pressure = buoyancy(self.fluid.density, volume, &self.gravity);
            if self.model == MixtureModel::A {
                let gradient = gradient_at(&stencil, grid, fluid);
                link.pressure += gradient * -volume;
            }
            particles.cargo[i] = link.write();
        }
        Ok(())
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
        let mut stencil = Stencil::default();
        for (body, link) in particles.bodies[..particles.owned].iter().zip(links) {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            grid.share(&stencil, Site::Cells, link.coefficient, coefficient);
            grid.share(&stencil, Site::Cells, link.coefficient * link.value, explicit);
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
        let mut stencil = Stencil::default();
        for (i, body) in bodies.iter().enumerate() {
            stencil.place(&self.kernel, &grid.axes, &body.position, self.equivalent_diameter(body))?;
            visit(i, grid.mean(&stencil, Site::Cells, scalar));
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

/// Buoyancy −ρ V g (N) of a volume V (m³) in a fluid of density ρ (kg/m³) under gravity g (m/s²), the force of the
/// hydrostatic pressure, in both models.
pub fn buoyancy(fluid_density: f64, volume: f64, gravity: &Vec3) -> Vec3 {
    gravity * (-fluid_density * volume)
}

/// Velocity of the fluid at a particle (m/s): next to a boundary that of the flow within.
#[inline]
fn velocity_at(stencil: &Stencil, grid: &Grid, fluid: &FluidFields) -> Vec3 {
    Vec3::from_fn(|a, _| grid.mean(stencil, Site::InnerFaces(a), fluid.velocity[a]))
}

/// Pressure gradient at a particle (Pa/m).
#[inline]
fn gradient_at(stencil: &Stencil, grid: &Grid, fluid: &FluidFields) -> Vec3 {
    Vec3::from_fn(|a, _| grid.mean(stencil, grid.faces_of_force(a), fluid.pressure_gradient[a]))
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
