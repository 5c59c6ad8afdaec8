//! What neighbours tell each other of their lists with each update of clones.

/// What a rank tells a neighbour of its lists in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Notice {
    /// Whether it rebuilds its lists in this step: new clones follow.
    pub(crate) rebuilds: bool,
    /// Step at which it means to rebuild them.
    pub(crate) plan: Option<u64>,
    /// Whether the receiver is asked to rebuild its own in the same step, to take over particles.
    pub(crate) asks: bool,
}

impl Notice {
    /// Numbers in a message.
    pub(crate) const LENGTH: usize = 2;

    pub(crate) fn write(&self, message: &mut [f64]) {
        message[0] = f64::from(u8::from(self.rebuilds) + 2 * u8::from(self.asks));
        message[1] = self.plan.map_or(-1.0, |step| step as f64);
    }

    pub(crate) fn read(message: &[f64]) -> Self {
        let flags = message[0] as u8;
        Self {
            rebuilds: flags & 1 != 0,
            asks: flags & 2 != 0,
            plan: (message[1] >= 0.0).then_some(message[1] as u64),
        }
    }
}
