//! What ends a run, with the particle, step, place and likely cause.

use thiserror::Error;

/// A run that can no longer be trusted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepError {
    /// A particle left the box where the case declares no outlet.
    #[error(
        "particle {id} left the domain through {face} at {place} (velocity {velocity}): declare the face in domain.outlets if that is meant, else a wall leaks or is missing there, or the time step is too large"
    )]
    Lost {
        /// Identity.
        id: u64,
        /// Face name.
        face: String,
        /// Position.
        place: String,
        /// Velocity.
        velocity: String,
    },
    /// A state that is not a number.
    #[error(
        "particle {id} has a position or velocity that is not a number, last seen near {place}: the time step is too large or a contact is too stiff (see `grains-mpi check`)"
    )]
    NotANumber {
        /// Identity.
        id: u64,
        /// Last position.
        place: String,
    },
    /// Two bodies overlap too much.
    #[error(
        "particle {id} overlaps {other} by {overlap:.4e} m, {percent:.1} % of its inscribed radius, at {place}; the limit is {limit:.1} % (limits.overlap): the time step is too large, the stiffness too low for the impact speed, or bodies were placed into each other"
    )]
    Overlap {
        /// Identity.
        id: u64,
        /// The other body.
        other: String,
        /// Overlap (m).
        overlap: f64,
        /// Overlap over inscribed radius (%).
        percent: f64,
        /// Limit (%).
        limit: f64,
        /// Position.
        place: String,
    },
    /// A particle moved farther than it may between two builds of the lists.
    #[error(
        "particle {id} moved {distance:.4e} m since the neighbour lists were built, turning included, more than the {allowed:.4e} m in which nothing can be missed, at {place} (velocity {velocity}): the time step is too large"
    )]
    Jump {
        /// Identity.
        id: u64,
        /// Distance (m).
        distance: f64,
        /// Largest distance in which it can have passed through nothing (m).
        allowed: f64,
        /// Position.
        place: String,
        /// Velocity.
        velocity: String,
    },
    /// A particle went so far in a step that it may have passed through something.
    #[error(
        "particle {id} went {way:.4e} m past {other} in step {step}, turning included, more than the {allowed:.4e} m that both are thick by half: it may have passed through it unseen, at {place}; take a time.dt of at most {dt:.1e} s"
    )]
    Tunnelling {
        /// Identity.
        id: u64,
        /// The other body.
        other: String,
        /// Step.
        step: u64,
        /// Way of the one past the other (m).
        way: f64,
        /// Half thicknesses of both (m).
        allowed: f64,
        /// Time step that would do (s).
        dt: f64,
        /// Position.
        place: String,
    },
    /// A particle moved to a subdomain that is no neighbour of the one it was in.
    #[error(
        "particle {id} jumped over a whole subdomain to {place} (velocity {velocity}): the time step is too large"
    )]
    FarJump {
        /// Identity.
        id: u64,
        /// Position.
        place: String,
        /// Velocity.
        velocity: String,
    },
    /// A particle whose temperature the time step cannot follow.
    #[error(
        "particle {id} at {place} would go from {before:.4} K to {after:.4} K in one step, in which its contacts conduct {share:.3} of its heat capacity per kelvin: above 1 no temperature is bounded; lower time.dt, or give its material the heat_capacity (J/(kg K)) it has"
    )]
    Temperature {
        /// Identity.
        id: u64,
        /// Position.
        place: String,
        /// Temperature before (K).
        before: f64,
        /// And after the step (K).
        after: f64,
        /// Σ G Δt/(m c) (-).
        share: f64,
    },
    /// A load that the exact sums cannot hold.
    #[error(
        "particle {id} at {place} is under a force of {force:.4e} N, beyond any its contacts can exert within limits.overlap, or its bonds within a strain of about 0.8: the time step is too large"
    )]
    Load {
        /// Identity.
        id: u64,
        /// Position.
        place: String,
        /// Force (N).
        force: f64,
    },
    /// A wall under a load that bears more than the exact sums can hold.
    #[error(
        "the particles push wall `{wall}` with {force:.4e} N, beyond the {largest:.4e} N up to which their forces add up exactly: it hits them far harder than its load presses; let it begin nearer to the particles, or set max_speed or damping of its motion"
    )]
    WallLoad {
        /// Name of the wall.
        wall: String,
        /// Force (N).
        force: f64,
        /// Largest force (N).
        largest: f64,
    },
    /// A wall that its load has moved out of the box.
    #[error(
        "wall `{wall}` left the domain in step {step}, {way:.4e} m along its load from where the case puts it: nothing holds it there; lower the load, turn its axis round if it pulls, or set end of its motion"
    )]
    WallOutside {
        /// Name of the wall.
        wall: String,
        /// Step.
        step: u64,
        /// Way along the axis of its load (m).
        way: f64,
    },
    /// A bonded particle that is not there.
    #[error(
        "particle {id} at {place} is bonded to particle {partner}, which is nowhere near: the time step is too large for the bonds"
    )]
    BondLost {
        /// Identity.
        id: u64,
        /// The other.
        partner: u64,
        /// Position.
        place: String,
    },
    /// A bond that nothing can call a beam any more.
    #[error(
        "the bond of particles {id} and {other} at {place} is {length:.4e} m long, {first:.4e} m when it was made: it should have broken before (tensile_strength of [[bond]]), or the time step is too large for it"
    )]
    Overstretched {
        /// Identity.
        id: u64,
        /// The other.
        other: u64,
        /// Length (m).
        length: f64,
        /// Length when it was made (m).
        first: f64,
        /// Position.
        place: String,
    },
    /// A bond whose vibrations the time step does not resolve.
    #[error(
        "the bond of particles {id} and {other} vibrates with half a period of {time:.2e} s, fewer than 5 time steps: lower time.dt to {dt:.1e} s, or make the bond softer (radius or youngs_modulus of [[bond]])"
    )]
    StiffBond {
        /// Identity.
        id: u64,
        /// The other.
        other: u64,
        /// Half its shortest period (s).
        time: f64,
        /// Time step that would do (s).
        dt: f64,
    },
    /// A kind of bonds that joined nobody.
    #[error(
        "bond[{kind}] bonded nothing: no two particles that it may join, and that had no bond, were within {distance:.2e} m of each other (distance, between and at of [[bond]])"
    )]
    NothingBonded {
        /// Number of the kind.
        kind: usize,
        /// Largest gap (m).
        distance: f64,
    },
    /// A pair of a table that was not bonded.
    #[error(
        "bond[{kind}]: {missing} of the {pairs} pairs of its table were not bonded, the first of them particles {} and {}: both must be there, within its distance, and not both of prescribed motion", pair[0], pair[1]
    )]
    Unbonded {
        /// Number of the kind.
        kind: usize,
        /// Identities of the first.
        pair: [u64; 2],
        /// How many.
        missing: usize,
        /// Pairs of the table.
        pairs: usize,
    },
    /// The ledger of bonds does not close.
    #[error(
        "{made} ends of bonds were made, {there} are there, {broken} broke and {left} left with particles: the rest is unaccounted for"
    )]
    BondLedger {
        /// Made so far.
        made: u64,
        /// There now.
        there: u64,
        /// Broken so far.
        broken: u64,
        /// Left with particles so far.
        left: u64,
    },
    /// Liquid is unaccounted for.
    #[error(
        "{inserted:e} m3 of liquid came with particles, and {missing:e} m3 of it and of what walls gave are neither on particles nor in bridges, on walls or gone; {bridges} bridges are unaccounted for"
    )]
    Liquid {
        /// Missing (m³).
        missing: f64,
        /// Put on particles (m³).
        inserted: f64,
        /// Bridges that have formed and are neither there nor broken.
        bridges: i64,
    },
    /// The ledger does not close.
    #[error(
        "{inserted} particles were inserted, {inside} are inside and {left} left through outlets: {missing} are unaccounted for"
    )]
    Ledger {
        /// Inserted so far.
        inserted: u64,
        /// Inside now.
        inside: u64,
        /// Left so far.
        left: u64,
        /// Difference.
        missing: i64,
    },
    /// The distance of two bodies was not found.
    #[error("the distance of particle {id} and {other} at {place} was not found: {reason}")]
    Distance {
        /// Identity.
        id: u64,
        /// The other body.
        other: String,
        /// Position.
        place: String,
        /// What the narrow phase says.
        reason: String,
    },
    /// A collision of two ranks' particles that only one of them sees.
    #[error(
        "the collision of particle {id} with {other} at {place} is known to one rank only, so the order of collisions has no end: this is a bug, please report it with the case"
    )]
    Unmatched {
        /// Identity.
        id: u64,
        /// The other body.
        other: String,
        /// Position.
        place: String,
    },
}

/// A place or velocity for a message.
pub(crate) fn vector(v: &grains_geometry::Vec3) -> String {
    format!("({:.6e}, {:.6e}, {:.6e})", v.x, v.y, v.z)
}
