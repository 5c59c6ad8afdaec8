//! Starts the program under mpirun with a time limit, and reads what it wrote.

#![allow(dead_code)] // each test program uses its own part
#![allow(clippy::unwrap_used)]

pub mod files;
pub mod results;

use std::fs::{self, File};
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Longest time for one run (s); on a quiet machine none takes a tenth of it.
const PATIENCE: u64 = 150;

/// What Open MPI needs to run as root, in containers, and with more ranks than cores.
pub const ENVIRONMENT: [(&str, &str); 6] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("OMPI_MCA_mpi_yield_when_idle", "1"),
    ("OMPI_MCA_btl_vader_single_copy_mechanism", "none"),
    ("OMP_NUM_THREADS", "1"),
];

/// What a run said and how it ended.
pub struct Output {
    /// Exit code of mpirun; none if a signal ended it.
    pub code: Option<i32>,
    /// Standard output of mpirun and all ranks.
    pub stdout: String,
    /// Standard error of mpirun and all ranks.
    pub stderr: String,
}

impl Output {
    /// The run, which must have ended well.
    pub fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.text());
        self
    }

    /// The only error message, which must have come with this exit code.
    pub fn only_error(&self, code: i32) -> &str {
        let first = self.stderr.find("error: ").unwrap_or_else(|| panic!("no error: {}", self.text()));
        assert_eq!(self.stderr.matches("error: ").count(), 1, "one message: {}", self.text());
        assert!(!self.stderr.contains("panicked"), "{}", self.text());
        assert_eq!(self.code, Some(code), "{}", self.text());
        let message = &self.stderr[first + "error: ".len()..];
        // What mpirun adds is between dashed lines.
        message.split("\n-----").next().unwrap_or(message).trim_end()
    }

    /// All of it, for messages.
    pub fn text(&self) -> String {
        format!("code {:?}\n--- stdout\n{}\n--- stderr\n{}", self.code, self.stdout, self.stderr)
    }
}

/// A run in progress; it is ended with all its ranks when dropped.
pub struct Running {
    child: Child,
    folder: PathBuf,
    begun: Instant,
    /// The runs of all tests take turns, so that none waits for the cores of another.
    _turn: MutexGuard<'static, ()>,
}

/// Held by the run in progress.
static TURN: Mutex<()> = Mutex::new(());

/// Locked while this program lives, so that another that is started meanwhile waits.
static PROGRAM: OnceLock<File> = OnceLock::new();

/// An empty folder for a test.
pub fn folder(name: &str) -> PathBuf {
    PROGRAM.get_or_init(|| {
        let file = File::create(Path::new(env!("CARGO_TARGET_TMPDIR")).join("tests.lock")).unwrap();
        file.lock().unwrap();
        file
    });
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The text of a case of these tests.
pub fn case(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases").join(name);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A text with one passage replaced, which must be there once.
pub fn replaced(text: &str, old: &str, new: &str) -> String {
    assert_eq!(text.matches(old).count(), 1, "`{old}` is in the case once");
    text.replace(old, new)
}

/// What is written of a case at every `every`th of its `steps` steps.
pub fn often(name: &str, (steps, every): (u32, u32)) -> String {
    let text = case(name);
    let dt: f64 = key(&text, "dt").parse().unwrap();
    let interval = format!("{:e}", dt * f64::from(every));
    let end = format!("{:e}", dt * f64::from(steps));
    let text = replaced(&text, &format!("\nend = {}\n", key(&text, "end")), &format!("\nend = {end}\n"));
    // The checkpoints are those of stops alone.
    let values = [("particles", &*interval), ("series", &interval), ("checkpoint", "1e3")];
    let (before, output) = text.split_once("\n[output]\n").unwrap();
    let output = values.iter().fold(format!("\n{output}"), |text, (name, value)| {
        let old = format!("\n{name} = {}\n", key(&text, name));
        replaced(&text, &old, &format!("\n{name} = {value}\n"))
    });
    format!("{before}\n[output]{output}")
}

/// Random numbers in [0, 1), the same in each run of the tests (SplitMix64, Steele, Lea & Flood 2014).
pub struct Draw(pub u64);

impl Draw {
    /// The next number.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 * (-53_f64).exp2()
    }

    /// One of a number of things.
    pub fn of(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

/// Value of the first key of a name in a case.
pub fn key(text: &str, name: &str) -> String {
    let line = text.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap();
    line.split_once(" = ").unwrap().1.to_string()
}

/// Starts the program on a number of ranks in a folder.
///
/// When mpirun ends a job, because of a signal or an exit code other than 0, it waits `grace` (s) between
/// SIGCONT, SIGTERM and SIGKILL to the ranks that are left, or have not been seen to leave; 1 by default.
pub fn start(ranks: usize, folder: &Path, arguments: &[&str], grace: u32) -> Running {
    start_with(ranks, folder, arguments, (grace, &[]))
}

/// The same with further variables of the environment.
pub fn start_with(
    ranks: usize,
    folder: &Path,
    arguments: &[&str],
    (grace, environment): (u32, &[(&str, String)]),
) -> Running {
    // A test that failed while it held the turn left nothing behind.
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let file = |name: &str| File::create(folder.join(name)).unwrap();
    let child = Command::new("mpirun")
        .args(["--allow-run-as-root", "--oversubscribe", "-n", &ranks.to_string()])
        .arg(env!("CARGO_BIN_EXE_grains-mpi"))
        .args(arguments)
        .envs(ENVIRONMENT)
        .envs(environment.iter().map(|(name, value)| (name, value)))
        .env("OMPI_MCA_odls_base_sigkill_timeout", grace.to_string())
        .current_dir(folder)
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(file("stdout.txt"))
        .stderr(file("stderr.txt"))
        .spawn()
        .expect("mpirun starts");
    Running { child, folder: folder.to_path_buf(), begun: Instant::now(), _turn: turn }
}

/// Runs the program to its end.
pub fn run(ranks: usize, folder: &Path, arguments: &[&str]) -> Output {
    start(ranks, folder, arguments, 0).wait()
}

/// Runs the program to its end without mpirun, while others may run too.
pub fn run_alone(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_grains-mpi"));
    let done = command.args(arguments).envs(ENVIRONMENT).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Output { code: done.status.code(), stdout: text(&done.stdout), stderr: text(&done.stderr) }
}

/// Writes a case into the folder and runs it as if each node had a number of ranks, which then lie in the grid of ranks as bricks.
pub fn run_case_on_nodes(ranks: usize, per_node: usize, folder: &Path, case: &str) -> Output {
    fs::write(folder.join("case.toml"), case).unwrap();
    let environment = [("GRAINS_RANKS_PER_NODE", per_node.to_string())];
    start_with(ranks, folder, &["case.toml"], (0, &environment)).wait()
}

/// Writes a case into the folder and runs it, with further arguments.
pub fn run_case(ranks: usize, folder: &Path, case: &str, arguments: &[&str]) -> Output {
    fs::write(folder.join("case.toml"), case).unwrap();
    run(ranks, folder, &[&["case.toml"], arguments].concat())
}

impl Running {
    /// Waits for the end; a run that takes too long is ended, and fails the test.
    pub fn wait(self) -> Output {
        self.wait_at_most(PATIENCE)
    }

    /// The same for a run that may take longer (s).
    pub fn wait_at_most(mut self, patience: u64) -> Output {
        match self.end_within(patience) {
            Some(status) => self.output(status.code()),
            None => panic!("the run did not end in {patience} s:\n{}", self.output(None).text()),
        }
    }

    /// Waits for mpirun once its ranks are gone, and ends it if it stays: that of Open MPI 4.1 may, if a rank is killed while it says
    /// that it is done.
    pub fn wait_for_launcher(mut self) {
        if self.end_within(20).is_none() {
            println!("mpirun outlived its ranks:\n{}", self.output(None).text());
            signal("KILL", &[self.mpirun()]);
            self.wait();
        }
    }

    /// Waits until something holds; the run must still be going on then.
    pub fn wait_until(&mut self, what: &str, mut holds: impl FnMut() -> bool) {
        while !holds() {
            let is_late = self.begun.elapsed().as_secs() > PATIENCE;
            let has_ended = self.child.try_wait().unwrap().is_some();
            assert!(!is_late && !has_ended, "never {what}:\n{}", self.output(None).text());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Whether it has come to an end.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Process of mpirun.
    pub fn mpirun(&self) -> u32 {
        self.child.id()
    }

    /// Processes of the ranks.
    pub fn ranks(&self) -> Vec<u32> {
        let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
        let processes = entries.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok());
        processes.filter(|&p| parent(p) == Some(self.child.id())).collect()
    }

    fn end_within(&mut self, seconds: u64) -> Option<ExitStatus> {
        let until = Instant::now() + Duration::from_secs(seconds);
        while Instant::now() < until {
            if let Some(status) = self.child.try_wait().unwrap() {
                return Some(status);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        None
    }

    fn output(&self, code: Option<i32>) -> Output {
        let text = |name: &str| {
            String::from_utf8_lossy(&fs::read(self.folder.join(name)).unwrap_or_default()).into_owned()
        };
        Output { code, stdout: text("stdout.txt"), stderr: text("stderr.txt") }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if self.child.try_wait().is_ok_and(|status| status.is_some()) {
            return;
        }
        // Each rank leads a process group of its own.
        let ranks = self.ranks();
        signal("KILL", &[&ranks[..], &[self.child.id()]].concat());
        let _ = self.child.wait();
    }
}

/// Sends a signal to processes; those that have ended meanwhile do not matter.
pub fn signal(name: &str, processes: &[u32]) {
    let list: Vec<String> = processes.iter().map(u32::to_string).collect();
    let command = format!("kill -s {name} {}", list.join(" "));
    let _ = Command::new("sh").args(["-c", &command]).stderr(Stdio::null()).status();
}

fn parent(process: u32) -> Option<u32> {
    let status = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program, in brackets, may hold spaces.
    status.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
}

/// Says on the terminal that something is not tested here; unlike `eprintln!` also when the test passes.
pub fn skipped(test: &str, reason: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {reason}");
}

/// A Python that can read the files back: `$GRAINS_PYTHON` or `python3`, if it has vtk and h5py.
pub fn python() -> Option<String> {
    static FOUND: OnceLock<Option<String>> = OnceLock::new();
    FOUND
        .get_or_init(|| python_with("import h5py, numpy; from vtkmodules.vtkIOHDF import vtkHDFReader"))
        .clone()
}

/// `$GRAINS_PYTHON` or `python3`, if it can do some imports.
pub fn python_with(imports: &str) -> Option<String> {
    let candidates = [std::env::var("GRAINS_PYTHON").unwrap_or_default(), "python3".into()];
    candidates.into_iter().filter(|p| !p.is_empty()).find(|python| {
        let probe = Command::new(python).args(["-c", imports]).stderr(Stdio::null()).status();
        probe.is_ok_and(|status| status.success())
    })
}
