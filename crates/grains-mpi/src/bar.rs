//! The one line that a terminal shows of a run in progress; a log file gets lines instead.

use grains_simulation::{Simulation, duration};
use std::fs::File;
use std::io::{IsTerminal, Write};
use std::os::unix::process::parent_id;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use terminal_size::{Width, terminal_size_of};

/// Time between two drawings.
const INTERVAL: Duration = Duration::from_millis(200);

/// Characters of the bar itself.
const LENGTH: usize = 20;

/// Characters of a line on a terminal that does not tell how wide it is.
const USUAL_WIDTH: u16 = 80;

/// Whether the line is on the terminal, and must go before anything else is written.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// The line of a run.
pub struct Bar {
    terminal: File,
    drawn: Option<Instant>,
}

impl Bar {
    /// That of this process, if what it tells goes to a terminal.
    ///
    /// Open MPI gives every rank a terminal of its own, whatever becomes of their words: where those of mpirun go decides.
    pub fn on_terminal() -> Option<Self> {
        let is_rank =
            ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"].iter().any(|name| std::env::var(name).is_ok());
        let process = if is_rank { parent_id().to_string() } else { "self".into() };
        let path = format!("/proc/{process}/fd/1");
        // Only a terminal is opened: a pipe would be kept open with it, or be waited for.
        let target = std::fs::read_link(&path).ok()?;
        let is_device = target.starts_with("/dev/pts") || target.starts_with("/dev/tty");
        let terminal = is_device.then(|| File::options().write(true).open(path).ok()).flatten()?;
        terminal.is_terminal().then_some(Self { terminal, drawn: None })
    }

    /// Whether it is time to draw it anew.
    pub fn is_due(&self) -> bool {
        self.drawn.is_none_or(|drawn| drawn.elapsed() >= INTERVAL)
    }

    /// Draws it for the present state.
    pub fn draw(&mut self, simulation: &Simulation) {
        self.drawn = Some(Instant::now());
        let width = terminal_size_of(&self.terminal).map_or(USUAL_WIDTH, |(Width(width), _)| width);
        let line: String = line(simulation).chars().take(usize::from(width).saturating_sub(1)).collect();
        IS_SHOWN.store(true, Ordering::Relaxed);
        // A terminal that is gone is no error.
        let _ = write!(std::io::stdout(), "\r\x1b[K{line}").and_then(|()| std::io::stdout().flush());
    }
}

/// Takes the line away, to be called before anything else is written.
pub fn clear() {
    if IS_SHOWN.swap(false, Ordering::Relaxed) {
        let _ = write!(std::io::stdout(), "\r\x1b[K").and_then(|()| std::io::stdout().flush());
    }
}

/// How far a run is: a bar, the time, the rate, the time left, and the numbers that matter.
fn line(simulation: &Simulation) -> String {
    let (time, end) = (simulation.time(), simulation.case().time.end);
    let share = (time / end).clamp(0.0, 1.0);
    let full = (share * LENGTH as f64) as usize;
    let bar: String = (0..LENGTH).map(|k| if k < full { '█' } else { '░' }).collect();
    let (done, seconds) = (simulation.steps_done() as f64, simulation.seconds());
    let begin = simulation.begin();
    let left = match time > begin {
        true => duration((end - time) * seconds / (time - begin)),
        false => "-".into(),
    };
    let mut line = format!(
        "{bar} {:3.0} %  {time:.4} of {end} s  left {left}  {:.0} steps/s",
        100.0 * share,
        done / seconds
    );
    if let Some(progress) = simulation.progress() {
        let totals = &progress.totals;
        if totals.particles > 0 {
            let overlap = 100.0 * totals.max_overlap;
            line += &format!(
                "  {} particles  {:.2} m/s  overlap {overlap:.2} %",
                totals.particles, totals.max_speed
            );
        }
        if let Some(fluid) = &progress.fluid {
            line += &format!("  CFL {:.2}  drop {:.3e} Pa", fluid.cfl, fluid.pressure_drop);
        }
    }
    line
}
