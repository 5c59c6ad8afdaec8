//! Rigid bodies and walls in a flow that the grid resolves (Rakotonirina 2016, ch. 7; Wachs et al. 2009; errata R16-42 to R16-47).
//!
//! ```text
//!  ρ (∂u/∂t + u·∇u) = −∇p + μ ∇²u + f,   ∇·u = 0      in the whole box                     (7.1, 7.5)
//!  u = U + ω × r                                      in the bodies                        (7.4)
//!  (m − m_f) (dU/dt − g) = ΣF_c − ∫f                  and the like for ω                   (7.2, 7.3)
//! ```
//!
//! f is the force of the bodies on the fluid, the multiplier of the constraint (−λ of the thesis); set directly, it acts inside them only.
//!
//! # Flow of one step
//!
//! ```text
//! (particles)  the granular phase goes through the step with the flow's last force and torque ([`Surroundings::add_loads`])
//! place        ghosts of bodies on all ranks they reach into (`body_ghosts`); which velocities are inside, and where the surface
//!              is from them ([`grains_geometry::Shape::closest_surface`])
//!              (`nodes`), and how they follow the flow, eight side by side (`near_surface`)
//! contacts     f is told what contacts do to the fluid inside (`contact_force`)
//! (fluid)      predictor with γ fⁿ, projection: u^{n+1/2}, pⁿ⁺¹                              (7.9 to 7.11)
//! release      fⁿ is taken back where no body is any more
//! move_bodies  new U, ω of every body: one system of 6 x 6 with all that its velocities impose
//! impose       velocities inside get their values, fⁿ⁺¹ = γ fⁿ + ρ (uⁿ⁺¹ − u^{n+1/2})/Δt    (7.12, 7.13)
//! correct      particles take over U, ω and the force that led to them ([`Surroundings::correct`])
//! ```
//!
//! With γ = 1 a steady flow does not depend on Δt: f no longer changes, and u^{n+1/2} = uⁿ⁺¹ meets constraint and
//! continuity alike.
//!
//! # The velocity inside
//!
//! Deep inside, velocities are those of the body. Those next to the surface are *extrapolated* from the flow: along the normal through a
//! velocity at depth d the one relative to the body is a polynomial that is 0 on the surface and takes the flow at the points t,
//! 2 t and, in a cubic, 3 t; s = Σ|n_a| Δx_a is the distance of the planes between which a cell fits, t = 0.8 s for a cubic and s
//! for a parabola ([`Extrapolation`]):
//!
//! ```text
//!  body |  fluid                  w(−d) = Σ b_k w(k t),   with b_k such that w = y, y², y³ come out exactly when w(k t) is
//!   o---|--o---o---o              interpolated multilinearly from the grid (so that this is no error either);
//!  −d   0  t  2 t 3 t             |w| is at most 1.5 times the largest of the samples
//! ```
//!
//! Where another surface hides the last point, that surface takes its place: a passage has a profile through both its walls.
//! Otherwise the polynomial is of a lower degree. Differences of velocities across the surface then are those of a smooth flow:
//! drag converges with the third power of the cell width along cubics and the second along parabolas, where imposing the body's
//! velocity on all nodes inside is of first order. Cubics need boundary layers of several cells; parabolas are steadier, and what
//! free bodies use by default. Cubics are left where forces would alternate from step to step: they settle up to ν Δt/Δx² = 2
//! ([`MAX_DIFFUSION_NUMBER`]). No radius is calibrated. Weights are bounded, and what they take from other extrapolated velocities, so that close
//! bodies cannot feed each other.
//!
//! Nothing flows by the extrapolated velocities: they run against the flow outside, which would have to carry as much more. In
//! ∇·u = 0 velocities inside are those of the body ([`grains_fluid::Immersed::extrapolated`]), so that the fluid between bodies
//! carries what enters, however narrow the gaps, and none comes out of a body. (With them drag is off half as much, but in
//! pockets between touching bodies continuity and constraint contradict each other, and pressure and f grow without end.)
//!
//! # Multipliers
//!
//! [`Method::Multiplier`] is the method of the thesis: multipliers at velocities deep inside and at points of the surface
//! ([`surface_points`]), interpolated multilinearly or by parabolas that reach outwards. Those deep inside are eliminated, the others are
//! found by conjugate gradients, from those of the last step, in a number of iterations that does not grow with resolution: by the products of
//! rows that share velocities (`overlaps`), and through the grid at borders of ranks and deep in other bodies (`shared_places`). It is of order
//! 1.3, and bodies cost about twice as much; cases/array-sphere compares. On no boundary of the box are there points, where a wall rules.
//!
//! # Bodies of any density
//!
//! ```text
//! (m − m_f)(Uⁿ⁺¹ − Uⁿ) + C m_f (ΔUⁿ⁺¹ − ΔUⁿ) = −J + Eⁿ⁺¹ − Eⁿ + K,   ΔUⁿ⁺¹ = Uⁿ⁺¹ − Uⁿ − K_c/m
//! ```
//!
//! J is the impulse on the fluid, linear in Uⁿ⁺¹ with about m_f for its slope, so that bodies as heavy as the fluid are as
//! good as others. E is the momentum of the fluid inside beyond rigid motion: it jumps when nodes come and go, and f with it,
//! but not their difference. C adds the displaced fluid's inertia and, explicitly, the force it takes: without it bodies
//! lighter than half the fluid swing, since pressure answers a step later. C is 1 for bodies as heavy as the fluid and grows to 7
//! for lighter ones; beside multipliers it is 3 more. What is left to the next step is *carried over*
//! ([`Action`]): fluid + (m − m_f) U less what is carried over is kept to rounding.
//!
//! # Contacts
//!
//! K, the impulse of all but the flow, has a part K_c of contacts. These may be faster than the fluid's step, so that nothing of them
//! is taken from the step before: C acts on what the flow changes alone, ΔU, and the fluid inside is told before it is predicted
//! how contacts move it (`contact_force`). A body on a spring of frequency ω (rad/s) with damping ζ = 0.05 comes to rest at any ω Δt,
//! whatever mass the fluid outside adds (tests/resolved/contacts.rs).
//!
//! # Bodies of prescribed motion
//!
//! Their velocities are imposed on the fluid, of a body that turns those at its own places ([`BodyMotion::imposed`]). The flow's
//! force on one is what the fluid got, less what that inside it keeps ([`Action::on_prescribed`]):
//!
//! ```text
//! F Δt = −J + Eⁿ⁺¹ − Eⁿ + m_f (Uⁿ⁺¹ − Uⁿ)
//! ```
//!
//! As velocities come into a body and leave it, forces jitter, by an amount that goes with Δx²/Δt.
//!
//! # Walls
//!
//! A wall is a body of prescribed motion to the fluid: a closed surface, solid on one side ([`FluidWall`]), known by its signed
//! distance ([`grains_geometry::ClosedSurface`]). All velocities in it are imposed, by the same interface stencils; where bodies
//! overlap it, it keeps what it holds. Four things differ, since walls may fill most of the box:
//!
//! * Faces that it cuts carry the flow of their open part (`cut_faces`): then steady flow along walls that follow no grid line is of
//!   second order, and as much flows through any section.
//! * The flow's force on it is that of the stresses on the control volumes in it, at its surface alone ([`FlowOnWall`]): what is solid
//!   behind the surface, and the ends of the box there, do not count.
//! * Faces of outlets that lie in it have its velocity: left free, their flows in and out of the box through the wall alternate from step to
//!   step.
//! * Where walls move, cells in them have no sources, since the ends of the box do not move with them.
//!
//! Velocities in walls that stay are found once.
//!
//! # Viscosity that varies
//!
//! Stresses on walls are those of the whole 2 μ D with the viscosity of the place. Between velocities that bodies hold nothing acts on
//! the fluid; there the viscosity is that of a thin fluid ([`grains_fluid::SolidStresses`]): that of fluid
//! at rest would tie velocities next to a surface to those of the body so stiffly that forces would not settle.
//!
//! # Many ranks
//!
//! Every rank imposes its own velocities; sums over a body go back the way its ghosts came. Results on other numbers of ranks
//! differ by rounding.

mod balance;
mod body;
mod body_ghosts;
mod cell_stencil;
#[cfg(test)]
mod classification;
mod constraints;
mod contact_force;
mod cut_faces;
mod direct;
#[cfg(test)]
mod elimination;
mod error;
mod extrapolation;
mod interface_stencil;
mod motion;
mod multiplier;
mod near_surface;
mod node;
mod nodes;
mod overlaps;
mod point_stencil;
mod points;
mod profile;
mod resolved;
mod shared_places;
mod solid;
mod solid_cells;
mod solid_mask;
#[cfg(test)]
mod spectrum;
mod subgrid;
mod uzawa;
mod wall;
mod wall_load;
mod wall_nodes;

pub use balance::{Action, BodyMotion};
pub use body::{Form, RigidBody};
pub use constraints::Interpolation;
pub use error::{ConstraintError, SetupError};
pub use extrapolation::{Extrapolation, MAX_DIFFUSION_NUMBER};
pub use motion::{FlowLink, Surroundings, bodies};
pub use multiplier::MultiplierMethod;
pub use points::{SurfacePoint, surface_points};
pub use resolved::{Forcing, Method, Resolved};
pub use subgrid::Subgrid;
pub use wall::{FluidWall, SolidSide};
pub use wall_load::FlowOnWall;
