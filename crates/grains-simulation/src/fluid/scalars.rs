//! The scalars of a case: how the flow gets them, what is written of them, and how they are continued.

use grains_case::{
    Case, Expression, Face, Fluid as CaseFluid, Scalar as CaseScalar, ScalarBoundaryKind, ScalarBuoyancy,
};
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_fluid::{
    BoxFace, Buoyancy, Flow, ScalarBoundaries, ScalarCondition, ScalarSetup, ScalarValue, Side,
};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// What is written of a scalar in the time series: mean over the fluid, extremes, content, and what of it is not accounted for.
const COLUMNS: [&str; 5] = ["mean", "min", "max", "content", "unaccounted"];

/// Names of the arrays of a scalar, which are those of the whole run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarNames {
    /// Of its field, and the unit.
    pub field: &'static str,
    pub unit: &'static str,
    /// Of its values in a checkpoint, those before the last step, and the sum of its samples.
    pub value: &'static str,
    pub before: &'static str,
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
                sum: interned(format!("sum_scalar_{name}")),
            }
        };
        fluid.scalar.iter().map(of_one).collect()
    }
}

/// A text for the rest of the process, which has it once: files describe arrays by such names.
fn interned(text: String) -> &'static str {
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
        let face = box_face(given.face);
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
        COLUMNS.into_iter().zip(units).map(|(what, unit)| (format!("{}_{what}", scalar.name), unit))
    })
}

/// Values of these columns; collective.
pub fn row(fluid: &CaseFluid, flow: &Flow, transport: &MpiTransport) -> Vec<f64> {
    let Some(scalars) = &flow.scalars else { return Vec::new() };
    let mut row = Vec::new();
    for (number, (scalar, given)) in scalars.all.iter().zip(&fluid.scalar).enumerate() {
        let content = scalars.content(number);
        let mut sums = [content, content - scalar.entered - scalar.produced, scalars.volume()];
        transport.sum(&mut sums);
        let mut ends =
            scalar.value.own().fold([f64::NEG_INFINITY; 2], |[low, high], x| [low.max(-x), high.max(x)]);
        transport.max(&mut ends);
        let capacity = given.capacity(fluid.density);
        row.extend([sums[0] / sums[2], -ends[0], ends[1], capacity * sums[0], capacity * sums[1]]);
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
