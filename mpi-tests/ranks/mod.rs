//! Tests whose body runs on several ranks: the test program starts itself under mpirun.

#![allow(dead_code)] // each test program uses its own part

use grains_comm::Job;
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time for one run (s); on a quiet machine none takes a tenth of it.
const PATIENCE: u64 = 150;
/// Names, in the environment of the ranks, the test they run.
const MARK: &str = "GRAINS_TEST_ON_RANKS";
/// What Open MPI needs to run as root, in containers, and with more ranks than cores.
const ENVIRONMENT: [(&str, &str); 6] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("OMPI_MCA_mpi_yield_when_idle", "1"),
    ("OMPI_MCA_btl_vader_single_copy_mechanism", "none"),
    ("OMP_NUM_THREADS", "1"),
];
/// Held by the run in progress: the runs of all tests take turns.
static TURN: Mutex<()> = Mutex::new(());

/// Runs `body` on each of these numbers of ranks; `test` is the name of the calling test.
///
/// A panic on any rank fails the test with everything the ranks said.
pub fn on_ranks(ranks: &[usize], test: &str, body: impl FnOnce(&Job)) {
    if std::env::var_os(MARK).is_some_and(|name| name == test) {
        let job = Job::start(|| false).expect("MPI starts");
        return body(&job);
    }
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    for &ranks in ranks {
        let (code, text) = run(ranks, test);
        let finished = text.matches("1 passed").count();
        assert!(code == Some(0) && finished == ranks, "{ranks} ranks, code {code:?}\n{text}");
        // What the ranks measured, shown by `--nocapture`.
        text.lines().filter(|line| line.starts_with("measured")).for_each(|line| println!("{line}"));
    }
}

/// Exit code and output of the test program on some ranks.
fn run(ranks: usize, test: &str) -> (Option<i32>, String) {
    let program = std::env::current_exe().expect("the test program has a path");
    let log = std::env::temp_dir().join(format!("{test}-{}-{ranks}.txt", std::process::id()));
    let file = std::fs::File::create(&log).expect("a file for the output");
    let mut child = Command::new("mpirun")
        .args(["--allow-run-as-root", "--oversubscribe", "-n", &ranks.to_string()])
        .arg(program)
        .args([test, "--exact", "--nocapture", "--test-threads=1"])
        .envs(ENVIRONMENT)
        .env(MARK, test)
        .stdin(Stdio::null())
        .stderr(file.try_clone().expect("the same file"))
        .stdout(file)
        .spawn()
        .expect("mpirun starts");
    let until = Instant::now() + Duration::from_secs(PATIENCE);
    let code = loop {
        match child.try_wait().expect("mpirun can be waited for") {
            Some(status) => break status.code(),
            None if Instant::now() > until => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    let text = String::from_utf8_lossy(&std::fs::read(&log).unwrap_or_default()).into_owned();
    let _ = std::fs::remove_file(&log);
    (code, text)
}
