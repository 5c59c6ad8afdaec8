//! The scalars of a case: how the flow gets them, what is written of them, and how they are continued.

use super::walls::FluidWalls;
use grains_case::{
    Case, Expression, Face, Fluid as CaseFluid, ParticleTransfer, Scalar as CaseScalar, ScalarBoundaryKind,
    ScalarBuoyancy,
};
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_fluid::{
    BoxFace, Buoyancy, Flow, Interior, ScalarBoundaries, ScalarCondition, ScalarSetup, ScalarValue, Side,
    SolidCondition, SolidConditions, SolidReaction,
};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// What is written of a scalar in the time series: mean over the fluid, extremes, content, and what of it is not accounted for.
const COLUMNS: [&str; 5] = ["mean", "min", "max", "content", "unaccounted"];

/// What is written of one that meets solids: rates at which it came out of particles and of walls in the last step, and at which it
/// reacted.
const OF_SOLIDS: [&str; 3] = ["from_particles", "from_walls", "reaction"];

/// Names of the arrays of a scalar, which are those of the whole run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarNames {
    /// Of its field, and the unit.
    pub field: &'static str,
    pub unit: &'static str,
    /// Of its values in a checkpoint, those before the last step, the cells that it changed, and the sum of its samples.
    pub value: &'static str,
    pub before: &'static str,
    pub free: &'static str,
    pub sum: &'static str,
}

impl ScalarNames {
    /// Those of all scalars of a case.
    pub fn of(fluid: &CaseFluid) -> Vec<Self> {
        let of_one = |scalar: &CaseScalar| {
            let name = &scalar.name;
            Self {
                field: interned(name.clone()),
                unit: scalar.units()[0],
                value: interned(format!("scalar_{name}")),
                before: interned(format!("scalar_{name}_before")),
                free: interned(format!("scalar_{name}_free")),
                sum: interned(format!("sum_scalar_{name}")),
            }
        };
        fluid.scalar.iter().map(of_one).collect()
    }
}

/// A text for the rest of the process, which has it once: files describe arrays by such names.
pub fn interned(text: String) -> &'static str {
    static TEXTS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    match texts.get(text.as_str()) {
        Some(known) => known,
        None => {
            let new: &'static str = text.leak();
            texts.insert(new);
            new
        }
    }
}

/// Lets the flow carry the scalars of a case; collective.
///
/// # Errors
/// A formula that has no value, with its key.
pub fn add(case: &Case, fluid: &CaseFluid, flow: &mut Flow, transport: &dyn Transport) -> Result<(), String> {
    for (k, scalar) in fluid.scalar.iter().enumerate() {
        let key = format!("fluid.scalar[{k}]");
        let about = |what: &str, e: String| case.about(&format!("{key}.{what}"), e);
        let boundaries =
            boundaries(scalar, fluid.density).map_err(|(i, e)| about(&format!("boundary[{i}]"), e))?;
        let gravity = case.gravity;
        let setup = ScalarSetup {
            name: scalar.name.clone(),
            diffusivity: scalar.diffusivity(fluid.density),
            scheme: scalar.advection,
            boundaries,
            solids: solids(case, fluid, scalar).map_err(|(what, e)| about(&what, e))?,
            buoyancy: scalar.buoyancy.map(|b| Buoyancy {
                expansion: b.expansion,
                reference: b.reference,
                gravity,
            }),
        };
        let initial = scalar.initial.compile().map_err(|e| about("initial", e.to_string()))?;
        let number = flow.add_scalar(setup, |at| initial.at(at, 0.0), transport);
        let mut field = flow.scalars.iter().flat_map(|scalars| scalars.all[number].value.own());
        if transport.any(field.any(|x| !x.is_finite())) {
            let message = "the formula has no value in some cells; it must have one in all of the domain";
            return Err(about("initial", message.into()));
        }
    }
    Ok(())
}

/// Conditions on the faces of the box, or the number of one with a fault.
fn boundaries(scalar: &CaseScalar, density: f64) -> Result<ScalarBoundaries, (usize, String)> {
    let mut boundaries = ScalarBoundaries::default();
    let capacity = scalar.capacity(density);
    for (i, given) in scalar.boundary.iter().enumerate() {
        let value =
            |expression: &Expression, factor: f64| value(expression, factor).map_err(|error| (i, error));
        let condition = match &given.kind {
            ScalarBoundaryKind::Insulated => ScalarCondition::Insulated,
            ScalarBoundaryKind::Value { value: given } => ScalarCondition::Value(value(given, 1.0)?),
            ScalarBoundaryKind::Flux { flux } => ScalarCondition::Flux(value(flux, 1.0 / capacity)?),
            ScalarBoundaryKind::Transfer { coefficient, ambient } => ScalarCondition::Transfer {
                coefficient: coefficient / capacity,
                ambient: value(ambient, 1.0)?,
            },
        };
        // Conditions on walls are those of solids.
        let Some(face) = given.face.map(box_face) else { continue };
        match given.part.outline() {
            Some(outline) => boundaries.patches.push((face, outline, condition)),
            None => {
                // A later one of the whole face leaves nothing of those before it.
                boundaries.patches.retain(|(other, ..)| *other != face);
                boundaries.faces[face.index()] = condition;
            }
        }
    }
    Ok(boundaries)
}

/// Conditions on resolved particles and on walls, or the key of one with a fault.
fn solids(case: &Case, fluid: &CaseFluid, scalar: &CaseScalar) -> Result<SolidConditions, (String, String)> {
    let capacity = scalar.capacity(fluid.density);
    let mut solids = SolidConditions::default();
    if let Some(given) = scalar.particles.as_ref().filter(|_| fluid.resolved.is_some()) {
        solids.bodies = on_bodies(given, capacity).map_err(|(what, e)| (format!("particles.{what}"), e))?;
        if let (Some(Expression::Number(value)), Some(_)) = (&given.value, given.inside) {
            solids.no_film = Some(*value);
        }
    }
    let walls = FluidWalls::new(case).map_err(|e| ("boundary".to_string(), e))?;
    for wall in walls.all() {
        let name = &case.walls[wall.number].name;
        let mut of_wall = scalar.boundary.iter().enumerate().rev();
        let given = of_wall.find(|(_, boundary)| boundary.wall.as_ref() == Some(name));
        let condition = match given {
            None => SolidCondition::default(),
            Some((i, boundary)) => {
                on_wall(&boundary.kind, capacity).map_err(|e| (format!("boundary[{i}]"), e))?
            }
        };
        solids.walls.push(condition);
    }
    Ok(solids)
}

/// What holds on resolved particles, of which a volume of fluid holds `capacity` per unit.
fn on_bodies(given: &ParticleTransfer, capacity: f64) -> Result<SolidCondition, (&'static str, String)> {
    if let Some(expression) = given.value.as_ref().filter(|_| given.inside.is_none()) {
        return Ok(SolidCondition::Value(value(expression, 1.0).map_err(|e| ("value", e))?));
    }
    if let Some(expression) = &given.flux {
        return Ok(SolidCondition::Flux(value(expression, 1.0 / capacity).map_err(|e| ("flux", e))?));
    }
    if given.uniform {
        return Ok(SolidCondition::OfSolid);
    }
    let Some(inside) = given.inside else { return Ok(SolidCondition::default()) };
    let heat = inside.conductivity.zip(inside.volumetric_heat_capacity);
    let (diffusivity, ratio) = match heat {
        Some((conductivity, of_volume)) => (conductivity / of_volume, of_volume / capacity),
        None => (inside.diffusivity.unwrap_or_default(), inside.partition.unwrap_or(1.0)),
    };
    let reaction = given.reaction.map(|given| SolidReaction { rate: given.rate, order: given.order });
    Ok(SolidCondition::Interior(Interior { capacity: ratio, diffusivity, reaction }))
}

/// What holds on a wall.
fn on_wall(kind: &ScalarBoundaryKind, capacity: f64) -> Result<SolidCondition, String> {
    Ok(match kind {
        ScalarBoundaryKind::Insulated => SolidCondition::default(),
        ScalarBoundaryKind::Value { value: given } => SolidCondition::Value(value(given, 1.0)?),
        ScalarBoundaryKind::Flux { flux } => SolidCondition::Flux(value(flux, 1.0 / capacity)?),
        ScalarBoundaryKind::Transfer { coefficient, ambient } => {
            SolidCondition::Transfer { coefficient: coefficient / capacity, ambient: value(ambient, 1.0)? }
        }
    })
}

fn value(expression: &Expression, factor: f64) -> Result<ScalarValue, String> {
    Ok(match expression {
        Expression::Number(value) => ScalarValue::Uniform(factor * value),
        Expression::Formula(_) => {
            let formula = expression.compile().map_err(|e| e.to_string())?;
            ScalarValue::Function(Arc::new(move |at, time| factor * formula.at(at, time)))
        }
    })
}

fn box_face(face: Face) -> BoxFace {
    BoxFace { axis: face.axis(), side: if face.is_upper() { Side::High } else { Side::Low } }
}

/// Names and units of the columns of the scalars in the time series.
pub fn columns(fluid: &CaseFluid) -> impl Iterator<Item = (String, &'static str)> + '_ {
    fluid.scalar.iter().flat_map(|scalar| {
        let [unit, content] = scalar.units();
        let units = [unit, unit, unit, content, content];
        let of_flow = if unit == "K" { "W" } else { "1/s" };
        let of_solids =
            OF_SOLIDS.into_iter().filter(|_| fluid.resolved.is_some()).map(move |what| (what, of_flow));
        let columns = COLUMNS.into_iter().zip(units).chain(of_solids);
        columns.map(|(what, unit)| (format!("{}_{what}", scalar.name), unit))
    })
}

/// Values of these columns; collective.
pub fn row(fluid: &CaseFluid, flow: &Flow, transport: &MpiTransport) -> Vec<f64> {
    let Some(scalars) = &flow.scalars else { return Vec::new() };
    let mut row = Vec::new();
    for (number, (scalar, given)) in scalars.all.iter().zip(&fluid.scalar).enumerate() {
        let ([content, of_unit], [least, largest]) = scalars.sums(number);
        let bodies = scalars.solids.as_ref().map_or(0, |solids| solids.bodies);
        let part = |values: &[f64], of_bodies: bool| {
            let (bodies, walls) = values.split_at(bodies.min(values.len()));
            if of_bodies { bodies.iter().sum::<f64>() } else { walls.iter().sum() }
        };
        let mut sums = [
            content,
            scalars.kept(number) - scalar.entered - scalar.produced,
            of_unit,
            part(&scalar.gained, true),
            part(&scalar.gained, false),
            part(&scalar.reacted, true),
        ];
        transport.sum(&mut sums);
        let mut ends = [-least, largest];
        transport.max(&mut ends);
        let capacity = given.capacity(fluid.density);
        row.extend([sums[0] / sums[2], -ends[0], ends[1], capacity * sums[0], capacity * sums[1]]);
        if fluid.resolved.is_some() {
            let rate = if scalar.gained_over > 0.0 { capacity / scalar.gained_over } else { 0.0 };
            row.extend(sums[3..].iter().map(|sum| sum * rate));
        }
    }
    row
}

/// What of a scalar has come in and was produced, for a state from which it goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Account {
    pub name: String,
    pub entered: f64,
    pub produced: f64,
}

/// Accounts of the scalars on this rank, and their last step (s).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accounts {
    pub of: Vec<Account>,
    pub last_dt: f64,
}

impl Accounts {
    /// Those of a flow.
    pub fn new(flow: &Flow) -> Self {
        let Some(scalars) = &flow.scalars else { return Self::default() };
        let account = |scalar: &grains_fluid::Scalar| Account {
            name: scalar.setup.name.clone(),
            entered: scalar.entered,
            produced: scalar.produced,
        };
        Self { of: scalars.all.iter().map(account).collect(), last_dt: scalars.last_dt }
    }

    /// Sums over all ranks; collective.
    pub fn summed(mut self, transport: &dyn Transport) -> Self {
        let mut sums: Vec<f64> = self.of.iter().flat_map(|a| [a.entered, a.produced]).collect();
        transport.sum(&mut sums);
        for (account, sums) in self.of.iter_mut().zip(sums.chunks_exact(2)) {
            (account.entered, account.produced) = (sums[0], sums[1]);
        }
        self
    }

    /// As a text: the step, then name and two numbers of each.
    pub fn text(&self) -> String {
        let bits = |x: f64| format!("{:x}", x.to_bits());
        let accounts = self.of.iter().map(|a| format!("{} {} {}", bits(a.entered), bits(a.produced), a.name));
        std::iter::once(bits(self.last_dt)).chain(accounts).collect::<Vec<_>>().join("\n")
    }

    /// Back from a text.
    pub fn parse(text: &str) -> Option<Self> {
        let real = |word: &str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
        let mut lines = text.lines();
        let last_dt = real(lines.next()?)?;
        let account = |line: &str| {
            let mut words = line.splitn(3, ' ');
            let [entered, produced] = [real(words.next()?)?, real(words.next()?)?];
            Some(Account { name: words.next()?.to_string(), entered, produced })
        };
        Some(Self { of: lines.map(account).collect::<Option<_>>()?, last_dt })
    }
}

/// Largest Σ |β (φ − φ₀)| over the values that scalars are given (-): the share of gravity that moves the fluid.
pub fn largest_buoyancy(case: &Case, fluid: &CaseFluid) -> f64 {
    let of_scalar = |scalar: &CaseScalar| {
        let of =
            |b: &ScalarBuoyancy| b.expansion.abs() * scalar.largest_difference(&case.domain, b.reference);
        scalar.buoyancy.as_ref().map_or(0.0, of)
    };
    fluid.scalar.iter().map(of_scalar).sum()
}
