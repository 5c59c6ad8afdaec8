//! `report.html`: what it says of a run, what a real browser draws of it, and how `watch` serves it while the run goes on.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::{last_step, snapshots};
use common::{ENVIRONMENT, case, folder, replaced, run, run_case, skipped, start};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A browser that can be driven by its command line.
fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(|name| {
        let asked = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        asked.is_ok_and(|status| status.success())
    })
}

/// What a browser shows of a page at a state: its document, and a picture of so many pixels.
fn shown(browser: &str, page: &Path, hash: &str, size: [u32; 2]) -> (String, Picture) {
    // Browsers hang now and then, whatever they show.
    let found = (0..3).find_map(|attempt| try_to_show(browser, page, hash, (size, attempt)));
    found.expect("the browser hangs")
}

fn try_to_show(
    browser: &str,
    page: &Path,
    hash: &str,
    ([width, height], attempt): ([u32; 2], usize),
) -> Option<(String, Picture)> {
    let home = page.parent().unwrap();
    let [picture, document] = ["picture.png", "document.html"].map(|name| home.join(name));
    let _ = fs::remove_file(&picture);
    let mut child = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
        .args(["--disable-quic", "--no-first-run", "--disable-background-networking", "--hide-scrollbars"])
        .args(["--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--dump-dom"])
        .arg(format!("--user-data-dir={}", home.join(format!("browser-{attempt}")).display()))
        .arg(format!("--window-size={width},{height}"))
        .arg(format!("--screenshot={}", picture.display()))
        .arg("--virtual-time-budget=4000")
        .arg(format!("file://{}{hash}", page.display()))
        .stdout(File::create(&document).unwrap())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(40) {
            // With all the processes that it has started.
            let _ = Command::new("kill").args(["-9", "--", &format!("-{}", child.id())]).status();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let text = fs::read_to_string(&document).unwrap();
    (picture.exists() && text.contains("data-state=")).then(|| (text, Picture::read(&picture)))
}

/// A picture of 8 bits per channel.
struct Picture {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let channels = info.color_type.samples();
        let pixels = bytes[..info.buffer_size()].chunks(channels).map(|p| [p[0], p[1], p[2]]).collect();
        Self { width: info.width as usize, pixels }
    }

    /// Share of the pixels with a colour of their own: neither paper nor ink nor grey.
    fn coloured(&self) -> f64 {
        let is_coloured = |p: &&[u8; 3]| p.iter().max().unwrap() - p.iter().min().unwrap() > 40;
        self.pixels.iter().filter(is_coloured).count() as f64 / self.pixels.len() as f64
    }

    /// Share of the pixels that differ from those of another.
    fn difference(&self, other: &Self) -> f64 {
        assert_eq!((self.width, self.pixels.len()), (other.width, other.pixels.len()));
        let differs = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).any(|(x, y)| x.abs_diff(*y) > 24);
        let count = self.pixels.iter().zip(&other.pixels).filter(|pair| differs(*pair)).count();
        count as f64 / self.pixels.len() as f64
    }
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// A run leaves a record and a page that stands alone; a browser draws its bodies on wide and narrow screens, and they move with the
/// time.
#[test]
fn the_page_of_a_run_shows_it_in_a_browser() {
    let home = folder("report");
    let output = run_case(2, &home, &case("gravel.toml"), &[]).succeeded();
    assert!(output.stdout.contains("report in results/report.html"), "{}", output.text());
    let results = home.join("results");
    let record = json(&results.join("run.json"));
    let part = &record["parts"][0];
    assert_eq!(part["state"], "finished");
    assert_eq!(part["machine"]["ranks"], 2);
    let (predicted, measured) = (&part["predicted"]["memory_bytes"], &part["memory_bytes"]["all"]);
    assert!(predicted.as_f64().unwrap() > 1e7 && measured.as_f64().unwrap() > 1e7, "{record:#}");
    assert_eq!(part["particles"]["inside"], 200);
    let text = fs::read_to_string(results.join("report.html")).unwrap();
    assert!(text.len() < 1_000_000, "{} bytes", text.len());
    // Made anew it is the same: all of it comes from the files.
    run(1, &home, &["report", "results"]).succeeded();
    assert_eq!(fs::read_to_string(results.join("report.html")).unwrap(), text);

    let Some(browser) = browser() else {
        skipped("the_page_of_a_run_shows_it_in_a_browser", "no chromium: the page is not drawn");
        return;
    };
    let page = results.join("report.html").canonicalize().unwrap();
    let (document, first) = shown(browser, &page, "#frame=0&walls=0.3", [900, 700]);
    let body = document.split("<body").nth(1).unwrap().split('>').next().unwrap();
    assert!(body.contains("data-state=\"ready\"") && body.contains("data-errors=\"\""), "{body}");
    assert!(body.contains("data-frame=\"0\""), "{body}");
    let (_, last) = shown(browser, &page, "#frame=2&walls=0.3", [900, 700]);
    assert!(first.coloured() > 0.01 && last.coloured() > 0.01, "{} {}", first.coloured(), last.coloured());
    let moved = first.difference(&last);
    assert!((0.003..0.5).contains(&moved), "{moved} of the pixels differ");
    let (_, narrow) = shown(browser, &page, "#frame=2", [500, 700]);
    assert!(narrow.coloured() > 0.01, "{}", narrow.coloured());
}

/// A run that fails says why in its record and on its page; a case may do without the page.
#[test]
fn a_run_that_fails_leaves_a_page_that_says_why() {
    let home = folder("report_failed");
    let text = replaced(&case("gravel.toml"), "[output]", "[limits]\noverlap = 1e-7\n\n[output]");
    let output = run_case(2, &home, &text, &[]);
    let error = output.only_error(3);
    let part = &json(&home.join("results/run.json"))["parts"][0];
    assert_eq!((part["state"].as_str(), part["error"].as_str()), (Some("failed"), Some(error)));
    let page = fs::read_to_string(home.join("results/report.html")).unwrap();
    assert!(page.contains("limits.overlap"), "the page says why");
    let text = replaced(&case("gravel.toml"), "[output]", "[output]\nreport = false");
    let text = replaced(&text, "end = 0.02", "end = 0.001");
    run_case(1, &home, &text, &[]).succeeded();
    assert!(home.join("results/run.json").exists() && !home.join("results/report.html").exists());
}

/// `grains-mpi watch`, ended when dropped.
struct Watch {
    child: Child,
    address: String,
    port: u16,
    token: String,
}

impl Watch {
    fn of(home: &Path, results: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_grains-mpi"))
            .args(["watch", results])
            .current_dir(home)
            .envs(ENVIRONMENT)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.split_whitespace().find(|word| word.starts_with("http://127.0.0.1:")).unwrap();
        let (host, token) = address["http://".len()..].split_once('/').unwrap();
        let port = host.rsplit_once(':').unwrap().1.parse().unwrap();
        Self { child, address: host.into(), port, token: token.trim_end_matches('/').into() }
    }

    /// Code and text of the answer to a request with some headers.
    fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let host = headers.iter().any(|(name, _)| *name == "Host");
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: 0\r\n");
        if !host {
            text += &format!("Host: {}\r\n", self.address);
        }
        headers.iter().for_each(|(name, value)| text += &format!("{name}: {value}\r\n"));
        stream.write_all(format!("{text}\r\n").as_bytes()).unwrap();
        // It comes in chunks, which may end within a character.
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let answer = String::from_utf8_lossy(&bytes);
        let code = answer.split(' ').nth(1).unwrap().parse().unwrap();
        (code, answer.into_owned())
    }

    fn get(&self, what: &str) -> (u16, String) {
        self.ask("GET", &format!("/{}/{what}", self.token), &[])
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A page that is read all the time disturbs no run, also not one that continues the files; it stops the run when it is asked to by
/// its own page, and by no other.
#[test]
fn a_run_is_watched_while_it_writes_and_stopped_from_its_page_alone() {
    let home = folder("report_watched");
    let text = replaced(&case("gravel.toml"), "end = 0.02", "end = 20");
    let text = replaced(&text, "particles = 0.01", "particles = 0.0002");
    fs::write(home.join("case.toml"), text).unwrap();
    let results: PathBuf = home.join("results");
    let mut running = start(2, &home, &["case.toml"], 0);
    running.wait_until("written anything", || last_step(&results) > 0);
    let watch = Watch::of(&home, "results");
    let (code, page) = watch.get("");
    assert!(code == 200 && page.contains("id=\"live-stop\"") && page.contains(">true</script>"), "{code}");
    let written = || snapshots_if_readable(&results);
    let (begun, mut seen) = (written(), 0);
    // However fast it writes, it is read at several of its states.
    while seen < 3 || written() < begun + 8 {
        let (code, status) = watch.get("status");
        assert!(code == 200 && status.contains("\"is_running\":true"), "{status}");
        let (code, data) = watch.get("data");
        assert!(code == 200, "{data}");
        seen += usize::from(data.contains("\"times\":["));
    }
    assert!(seen > 0);
    let stop = format!("/{}/stop", watch.token);
    let refused = [
        watch.ask("POST", "/stop", &[]).0,
        watch.ask("GET", &stop, &[]).0,
        watch.ask("POST", &stop, &[("Origin", "http://example.org")]).0,
        watch.ask("POST", &stop, &[("Host", "example.org")]).0,
    ];
    assert_eq!(refused, [404, 404, 403, 403]);
    let (code, answer) = watch.ask("POST", &stop, &[("Origin", &format!("http://{}", watch.address))]);
    assert_eq!(code, 200, "{answer}");
    let ended = running.wait().succeeded();
    assert!(ended.stdout.contains("continue with --restart latest"), "{}", ended.text());
    assert_eq!(json(&results.join("run.json"))["parts"][0]["stopped_by"], "request");
    // What continues cuts its files, which takes them for itself.
    let before = snapshots(&results.join("particles.vtkhdf")).0.len();
    let mut running = start(2, &home, &["case.toml", "--restart", "latest"], 0);
    while snapshots_if_readable(&results) < before + 3 {
        let _ = watch.get("data");
        running.wait_until("gone on", || true);
    }
    assert_eq!(watch.ask("POST", &stop, &[]).0, 200);
    running.wait().succeeded();
    let record = json(&results.join("run.json"));
    let from = |k: usize| record["parts"][k]["from_step"].as_u64();
    assert!(
        from(0) == Some(0) && from(1) > Some(0) && record["parts"].as_array().unwrap().len() == 2,
        "{record:#}"
    );
}

/// Number of snapshots; 0 while the file is being opened.
fn snapshots_if_readable(results: &Path) -> usize {
    let text = fs::read_to_string(results.join("particles.xdmf")).unwrap_or_default();
    text.matches("<Time ").count()
}
