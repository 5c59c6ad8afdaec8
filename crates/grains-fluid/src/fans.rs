//! Fans: pressure inlets whose pressure depends on the flow they let in.
//!
//! After the projection of a step with the old rise p₀ a fan lets in the flow Q*. A rise of 1 Pa, all else at rest, would drive
//! a flow w through the box in this step, of a potential ψ that is 1 on the inlet and 0 on outlets:
//!
//! ```text
//! ∇·(c ∇ψ) = 0,     w = −γ ∇ψ/m,     G = ∫ w dA over the inlet
//! ```
//!
//! The rise p of the end of the step solves p = rise(Q* + G (p − p₀)), whatever the slope of the curve, and (p − p₀) w and
//! (p − p₀) ψ are added to velocity and pressure. Of several fans each sees what the others drive through it. In one phase w
//! is computed once and grows with Δt/ρ; among particles it is computed in every step.

use crate::boundary::{BoundaryData, FanCurve};
use crate::flow::Flow;
use crate::projection::{Correction, divergence};
use crate::{Boundaries, Centre, Condition, Faces, Field, Layout, StepError};
use grains_domain::Transport;

/// Sweeps over fans that see one another.
const SWEEPS: usize = 50;

/// The fans of a flow.
pub(crate) struct Fans {
    fans: Vec<Fan>,
    /// 0 in all own cells, if there are fans.
    still: Option<Field<Centre>>,
    /// Whether the responses are those of the present coefficients.
    are_known: bool,
}

/// A fan, and what a rise of 1 Pa does to the flow: over Δt/ρ in one phase.
struct Fan {
    /// Number of its condition.
    condition: usize,
    curve: FanCurve,
    velocity: Faces,
    potential: Field<Centre>,
    /// Flow that it drives into the box through each fan.
    gains: Vec<f64>,
}

impl Fans {
    pub fn new(boundaries: &Boundaries, layout: Layout) -> Self {
        let fan = |(condition, given): (usize, &Condition)| match given {
            Condition::PressureInlet { fan: Some(curve), .. } => Some(Fan {
                condition,
                curve: curve.clone(),
                velocity: Faces::new(layout),
                potential: Field::new(layout),
                gains: Vec::new(),
            }),
            _ => None,
        };
        let mut fans: Vec<Fan> = boundaries.conditions().enumerate().filter_map(fan).collect();
        let count = fans.len();
        fans.iter_mut().for_each(|fan| fan.gains = vec![0.0; count]);
        Self { still: (count > 0).then(|| Field::new(layout)), fans, are_known: false }
    }

    /// Rises (Pa) without flow.
    pub fn at_rest(&self) -> Vec<f64> {
        self.fans.iter().map(|fan| fan.curve.rise(0.0)).collect()
    }

    /// The rise (Pa) that a condition has of all of them, 0 of those without a fan.
    pub fn rise(&self, rises: &[f64], condition: usize) -> f64 {
        let mut fans = self.fans.iter().zip(rises);
        fans.find(|(fan, _)| fan.condition == condition).map_or(0.0, |(_, rise)| *rise)
    }

    /// The rises that balance the curves at the end of a step, from those before and the flows with these; Δt/ρ in one phase.
    fn balance(&self, before: &mut [f64], flows: &[f64], per_rise: f64) -> Vec<f64> {
        let mut changes = vec![0.0; self.fans.len()];
        for _ in 0..if self.fans.len() > 1 { SWEEPS } else { 1 } {
            for (k, fan) in self.fans.iter().enumerate() {
                let others = self.fans.iter().zip(&changes).enumerate().filter(|(j, _)| *j != k);
                let of_others: f64 = others.map(|(_, (fan, change))| fan.gains[k] * change * per_rise).sum();
                let gain = (fan.gains[k] * per_rise).max(0.0);
                changes[k] = fan.curve.balance(flows[k] + of_others, before[k], gain) - before[k];
            }
        }
        before.iter_mut().zip(&changes).for_each(|(rise, change)| *rise += change);
        changes
    }
}

impl Flow {
    /// Brings the fans to their curves after the projection of a step of `dt` (s); collective if there are fans.
    pub(crate) fn balance_fans(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        if self.fans.fans.is_empty() {
            return Ok(());
        }
        if !self.fans.are_known || self.mixture.is_some() {
            self.find_responses(transport)?;
        }
        let per_rise = if self.mixture.is_some() { 1.0 } else { dt / self.setup.density };
        let flows = self.flows_of_fans(&self.state.velocity, transport);
        let changes = self.fans.balance(&mut self.state.fans, &flows, per_rise);
        for (fan, change) in self.fans.fans.iter().zip(changes) {
            self.state.velocity.add(change * per_rise, &fan.velocity);
            let pressure = self.state.pressure.data_mut().iter_mut();
            pressure.zip(fan.potential.data()).for_each(|(p, unit)| *p += change * unit);
        }
        Ok(())
    }

    /// Flows into the box (m³/s) through the fans by some velocities; collective.
    fn flows_of_fans(&self, velocity: &Faces, transport: &dyn Transport) -> Vec<f64> {
        let open = self.mixture.as_ref().map(|mixture| mixture.open_faces());
        let inflow = |condition: usize| {
            let faces = self.boundary_data.iter();
            faces.map(|face| face.inflow_of(&self.local, condition, velocity, open)).sum()
        };
        let mut flows: Vec<f64> = self.fans.fans.iter().map(|fan| inflow(fan.condition)).collect();
        transport.sum(&mut flows);
        flows
    }

    /// What rises of 1 Pa do; collective.
    fn find_responses(&mut self, transport: &dyn Transport) -> Result<(), StepError> {
        let mut fans = std::mem::take(&mut self.fans.fans);
        let found = fans.iter_mut().try_for_each(|fan| self.find_response(fan, transport));
        self.fans.fans = fans;
        found?;
        for k in 0..self.fans.fans.len() {
            let gains = self.flows_of_fans(&self.fans.fans[k].velocity, transport);
            self.fans.fans[k].gains = gains;
        }
        self.fans.are_known = true;
        Ok(())
    }

    fn find_response(&mut self, fan: &mut Fan, transport: &dyn Transport) -> Result<(), StepError> {
        // What the rise drives through the face alone is the source of the potential.
        if let Some(mut still) = self.fans.still.take() {
            self.drive(fan.condition, &mut still, &mut fan.velocity, false);
            let porous =
                self.mixture.as_ref().map(|mixture| (mixture.open_faces().components(), still.data()));
            divergence(&self.local, &fan.velocity, porous, &mut self.rhs);
            self.fans.still = Some(still);
        }
        let step = self.state.step;
        let solved = self.solver.solve(&self.rhs, &mut fan.potential, transport);
        solved.map_err(|source| StepError::Pressure { step, source })?;
        self.halo.fill_to(1, &mut [fan.potential.data_mut()], transport);
        self.drive(fan.condition, &mut fan.potential, &mut fan.velocity, true);
        Ok(())
    }

    /// The velocity that a potential drives which is 1 on a condition and 0 on other outlets: on all faces, or on these alone.
    fn drive(&self, condition: usize, potential: &mut Field<Centre>, velocity: &mut Faces, all: bool) {
        self.boundary_data.iter().for_each(|face: &BoundaryData| face.fill_unit(potential, condition));
        velocity.fill(0.0);
        let correction = Correction {
            local: &self.local,
            potential: potential.data(),
            coefficients: self.mixture.as_ref(),
            scale: 1.0,
            viscosity: 0.0,
        };
        if all {
            correction.velocity(velocity);
        }
        correction.outlets(&self.boundary_data, velocity);
    }
}
