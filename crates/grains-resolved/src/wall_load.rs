//! Force and torque of the flow on walls.

use crate::body::{others, unit};
use crate::{RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;

/// Force and torque of the flow on a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowOnWall {
    /// Number of the wall.
    pub wall: u64,
    /// Force (N).
    pub force: Vec3,
    /// Torque about the origin of the world frame (N m).
    pub torque: Vec3,
}

/// Where stresses on a wall are found.
pub(crate) struct Stresses<'a> {
    pub flow: &'a Flow,
    pub subgrid: &'a Subgrid,
    /// The body that holds a velocity of a component.
    pub holder: &'a dyn Fn(usize, usize) -> Option<u32>,
    /// Number of the first wall among the bodies.
    pub first_wall: usize,
}

impl FlowOnWall {
    /// Adds what goes into the control volume about the velocity of a component at a place in a wall, an arm (m) from its centre, from
    /// those outside, through each face: pressure with that of the mean gradient, viscous stress, and momentum beyond that of rigid
    /// motion, which the fluid inside keeps.
    ///
    /// It is what the force on the fluid inside takes out again: nothing but the flow at the surface counts, whatever lies behind.
    /// Nothing goes from one wall into another that it meets.
    pub(crate) fn add(
        &mut self,
        wall: &RigidBody,
        (component, place): (usize, usize),
        arm: &Vec3,
        stresses: &Stresses,
    ) {
        let subgrid = stresses.subgrid;
        for axis in (0..3).filter(|&a| subgrid.active[a]) {
            for side in [-1.0, 1.0] {
                let Some(beside) = subgrid.beside(component, place, axis, side) else { continue };
                if (stresses.holder)(component, beside).is_some_and(|b| b as usize >= stresses.first_wall) {
                    continue;
                }
                let arm = arm + unit(axis) * (0.5 * side * subgrid.spacing[axis]);
                let force =
                    unit(component) * stresses.through(wall, component, [place, beside], (axis, side), &arm);
                self.force += force;
                self.torque += (wall.center + arm).cross(&force);
            }
        }
    }

    /// Adds up those of all ranks; collective.
    pub(crate) fn gather(on_walls: &mut [Self], transport: &dyn Transport) {
        let mut sums: Vec<f64> = on_walls
            .iter()
            .flat_map(|on_wall| on_wall.force.iter().chain(&on_wall.torque).copied())
            .collect();
        transport.sum(&mut sums);
        for (on_wall, sums) in on_walls.iter_mut().zip(sums.chunks_exact(6)) {
            [on_wall.force, on_wall.torque] = [0, 3].map(|k| Vec3::from_column_slice(&sums[k..k + 3]));
        }
    }
}

impl Stresses<'_> {
    /// Force (N) along a component on the inner of two control volumes through the face between them, at an arm (m).
    fn through(
        &self,
        wall: &RigidBody,
        component: usize,
        [inside, outside]: [usize; 2],
        (axis, side): (usize, f64),
        arm: &Vec3,
    ) -> f64 {
        let (flow, spacing, strides) = (self.flow, self.subgrid.spacing, self.subgrid.layout.strides());
        let area = self.subgrid.cell_volume() / spacing[axis];
        let u = flow.state.velocity.component(component);
        let viscous = self.viscous(wall, component, [inside, outside], (axis, side));
        let mean = 0.5 * (u[inside] + u[outside]);
        let upper = inside.max(outside);
        let (across, pressure) = match axis == component {
            true => (mean, flow.state.pressure.data()[upper] - flow.state.force[axis] * arm[axis]),
            false => {
                let (v, below) = (flow.state.velocity.component(axis), upper - strides[axis]);
                (0.5 * (v[below] + v[below + strides[component]]), 0.0)
            }
        };
        let rigid = wall.component_at(axis, arm) * wall.component_at(component, arm);
        area * (viscous - side * (pressure + flow.setup.density * (across * mean - rigid)))
    }

    /// Viscous stress (Pa) along a component on the inner of two control volumes through the face between them.
    fn viscous(
        &self,
        wall: &RigidBody,
        component: usize,
        [inside, outside]: [usize; 2],
        (axis, side): (usize, f64),
    ) -> f64 {
        let (flow, spacing, strides) = (self.flow, self.subgrid.spacing, self.subgrid.layout.strides());
        let u = flow.state.velocity.component(component);
        let slope = (u[outside] - u[inside]) / spacing[axis];
        let lower = inside.min(outside);
        match flow.viscosity_of_stress(component, axis, lower) {
            // Beside a rigid surface the other half of the stress, of n·∂u/∂x, is that of its turning.
            None => flow.setup.viscosity * (slope + side * turning(wall, axis, &unit(component))),
            Some(viscosity) if axis == component => 2.0 * viscosity * slope,
            Some(viscosity) => {
                let v = flow.state.velocity.component(axis);
                let across = (v[lower + strides[component]] - v[lower]) / spacing[component];
                viscosity * (slope + side * across)
            }
        }
    }
}

/// What turns with a wall at a distance along an arm (m) moves faster by, along a component (m/s).
pub(crate) fn turning(wall: &RigidBody, component: usize, arm: &Vec3) -> f64 {
    let [b, c] = others(component);
    wall.spin[b] * arm[c] - wall.spin[c] * arm[b]
}
