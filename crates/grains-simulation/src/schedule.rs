//! When a simulation writes what.

use grains_case::Case;
use grains_dem::Origin;

/// Steps at which something is written every `interval` (s): those nearest to its multiples, so that the events of
/// intervals that are multiples of each other coincide.
#[derive(Clone, Copy)]
pub(crate) struct Events {
    /// Steps between two of them, not whole in general; infinite for never.
    every: f64,
    /// The step at which time would be zero: zero until the time step changes.
    zero: f64,
}

impl Events {
    fn new(interval: f64, dt: f64, origin: &Origin) -> Self {
        let zero = origin.step as f64 - origin.time / dt;
        Self { every: if interval > 0.0 { (interval / dt).max(1.0) } else { f64::INFINITY }, zero }
    }

    /// Step of the event with a number; halves fall to the same side, however their intervals are rounded.
    fn at(self, number: f64) -> u64 {
        (self.zero + number * self.every - 1e-4).round() as u64
    }

    /// The first event after a step.
    pub(crate) fn next(self, step: u64) -> u64 {
        let number = ((step as f64 - self.zero) / self.every).floor();
        [0.0, 1.0, 2.0]
            .map(|n| self.at(number + n))
            .into_iter()
            .find(|&event| event > step)
            .unwrap_or(u64::MAX)
    }

    pub(crate) fn is_due(self, step: u64) -> bool {
        step == 0 && self.every.is_finite() || step > 0 && self.next(step - 1) == step
    }
}

/// When files are written, and the last step.
pub(crate) struct Schedule {
    pub(crate) particles: Events,
    pub(crate) series: Events,
    pub(crate) checkpoint: Events,
    pub(crate) surfaces: Events,
    pub(crate) fluid: Events,
    /// A step that the fluid's steps end at because its user wants to look at it.
    pub(crate) pause: u64,
    /// The last step.
    pub(crate) end: u64,
}

impl Schedule {
    pub(crate) fn new(case: &Case, dt: f64, origin: &Origin) -> Self {
        let (every, out) = (|seconds| Events::new(seconds, dt, origin), &case.output);
        Self {
            particles: every(out.particles),
            series: every(out.series),
            checkpoint: every(out.checkpoint),
            surfaces: every(out.surfaces),
            fluid: every(case.fluid.as_ref().map_or(0.0, |f| f.output.interval.unwrap_or(out.particles))),
            pause: 0,
            end: every(case.time.end).at(1.0),
        }
    }

    /// Only the end is due.
    pub(crate) fn without_files(case: &Case, dt: f64, origin: &Origin) -> Self {
        let never = Events::new(0.0, dt, origin);
        let [particles, series, checkpoint, surfaces, fluid] = [never; 5];
        Self { particles, series, checkpoint, surfaces, fluid, ..Self::new(case, dt, origin) }
    }

    /// Whether something is written at a step.
    pub(crate) fn is_due(&self, step: u64) -> bool {
        self.events().iter().any(|events| events.is_due(step))
    }

    fn events(&self) -> [Events; 5] {
        [self.particles, self.series, self.checkpoint, self.surfaces, self.fluid]
    }

    /// The next step after `step` at which something is written or ends.
    pub(crate) fn next(&self, step: u64) -> u64 {
        let ends = [self.pause, self.end].into_iter().filter(|&end| end > step);
        self.events().into_iter().map(|events| events.next(step)).chain(ends).fold(u64::MAX, u64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::{Events, Schedule};
    use grains_dem::Origin;

    #[test]
    fn events_of_commensurate_intervals_coincide_and_keep_to_their_times() {
        for dt in [7e-6, 2.5e-6, 1e-4, 3.3e-4, 9.1e-6] {
            let every = |seconds| Events::new(seconds, dt, &Origin::default());
            let end = every(10.0).at(1.0);
            let [series, particles, checkpoint] = [0.002, 0.1, 1.0].map(every);
            let (surfaces, fluid) = (every(0.0), every(0.3));
            let schedule = Schedule { particles, series, checkpoint, surfaces, fluid, pause: 0, end };
            let (mut step, mut rows) = (0, 0);
            while step < end {
                let next = schedule.next(step);
                rows += 1;
                assert!(
                    (next as f64 * dt - 0.002 * f64::from(rows)).abs() <= 0.501 * dt,
                    "{dt} row {rows}: {next}"
                );
                assert!(series.is_due(next));
                assert_eq!(particles.is_due(next), rows % 50 == 0, "{dt} row {rows}");
                assert_eq!(checkpoint.is_due(next), rows % 500 == 0, "{dt} row {rows}");
                assert_eq!(fluid.is_due(next), rows % 150 == 0, "{dt} row {rows}");
                assert!(!surfaces.is_due(next));
                step = next;
            }
            assert_eq!(rows, 5000, "{dt}");
        }
    }

    #[test]
    fn events_keep_to_their_times_when_the_time_step_changes() {
        let origin = Origin { step: 1000, time: 0.1 };
        for dt in [3e-5, 2.5e-4, 1e-4 / 7.0] {
            let events = Events::new(0.004, dt, &origin);
            let mut step = origin.step;
            for number in 26..100 {
                step = events.next(step);
                assert!(
                    (origin.time_of(step, dt) - 0.004 * f64::from(number)).abs() <= 0.501 * dt,
                    "{dt} {number}"
                );
                assert!(events.is_due(step) && !events.is_due(step + 1));
            }
        }
    }

    #[test]
    fn intervals_below_a_step_come_at_every_step() {
        let events = Events::new(1e-9, 1e-6, &Origin::default());
        assert_eq!([0, 1, 2].map(|step| events.next(step)), [1, 2, 3]);
        assert!(events.is_due(0) && events.is_due(7));
    }
}
