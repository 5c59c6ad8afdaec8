//! The page of a run that goes on, served to browsers on this machine.
//!
//! | request | answer |
//! |---|---|
//! | `GET /TOKEN/` | the page |
//! | `GET /TOKEN/status` | how far the run is, and the version of its files |
//! | `GET /TOKEN/data` | description and block, made anew if the files have grown |
//! | `POST /TOKEN/stop` | asks the run to write a checkpoint and leave |
//!
//! Others on the machine do not know the token. A page from elsewhere knows it neither, and is refused by its `Origin`; a name that
//! was made to lead here is refused by its `Host`.

use crate::files::{RUN, STATUS, read_json};
use crate::page::{self, Kind};
use crate::{Contents, ReportError, contents};
use serde_json::json;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::time::{Duration, Instant};
use tiny_http::{Header, Method, Request, Response, Server};

/// What the server asks of the program.
pub trait Stop {
    /// Asks the run to write a checkpoint and leave.
    ///
    /// # Errors
    /// Why it cannot be asked.
    fn stop(&self) -> Result<(), String>;

    /// Whether the run goes on.
    fn is_running(&self) -> bool;
}

/// Names by which browsers of this machine reach it, also through a tunnel.
const HOSTS: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];
/// Shortest time between two readings of the files, and how much longer than a reading it is.
const PAUSE: (Duration, u32) = (Duration::from_secs(2), 10);

/// Serves the page of a directory on a port of the loopback interface until the process ends; 0 takes a free one. `tell` gets the
/// address.
///
/// # Errors
/// A directory of no run, or a port that is taken.
pub fn watch(
    directory: &Path,
    port: u16,
    run: &dyn Stop,
    tell: impl FnOnce(&str),
) -> Result<(), ReportError> {
    let refuse = |problem: String| ReportError::new(directory, problem);
    let mut page = Page { directory, run, token: token().map_err(|e| refuse(e.to_string()))?, kept: None };
    page.renew()?;
    let server = Server::http(("127.0.0.1", port))
        .map_err(|e| refuse(format!("cannot be served on port {port}: {e}; give another --port")))?;
    let address = server.server_addr().to_ip().ok_or_else(|| refuse("has no address".into()))?;
    tell(&format!("http://{address}/{}/", page.token));
    loop {
        // A browser that has gone away is no error.
        if let Ok(request) = server.recv() {
            page.answer(request);
        }
    }
}

struct Page<'a> {
    directory: &'a Path,
    run: &'a dyn Stop,
    token: String,
    kept: Option<Kept>,
}

/// What was read, from which version of the files, when, and how long it took.
struct Kept {
    contents: Contents,
    version: String,
    read: Instant,
    took: Duration,
}

impl Page<'_> {
    fn answer(&mut self, request: Request) {
        let (code, kind, text) = self.response(&request);
        let header = |name: &str, value: &str| Header::from_bytes(name.as_bytes(), value.as_bytes());
        let mut response = Response::from_string(text).with_status_code(code);
        for (name, value) in
            [("Content-Type", kind), ("Cache-Control", "no-store"), ("Referrer-Policy", "no-referrer")]
        {
            if let Ok(header) = header(name, value) {
                response.add_header(header);
            }
        }
        let _ = request.respond(response);
    }

    /// Code, kind and text of an answer.
    fn response(&mut self, request: &Request) -> (u16, &'static str, String) {
        const TEXT: &str = "text/plain; charset=utf-8";
        const JSON: &str = "application/json";
        let header = |name: &'static str| {
            request.headers().iter().find(|h| h.field.equiv(name)).map(|h| h.value.as_str().to_string())
        };
        if !header("Host").is_some_and(|host| is_here(&host)) {
            return (403, TEXT, "only browsers of this machine are answered\n".into());
        }
        let path = request.url().split('?').next().unwrap_or_default();
        let Some(asked) = path.strip_prefix('/').and_then(|p| p.strip_prefix(self.token.as_str())) else {
            return (404, TEXT, "the address lacks the token that `grains-mpi watch` printed\n".into());
        };
        match (request.method(), asked) {
            (Method::Get, "/") => match self.renew() {
                Ok(contents) => (200, "text/html; charset=utf-8", page::text(contents, Kind::Live)),
                Err(error) => (500, TEXT, format!("{error}\n")),
            },
            (Method::Get, "/status") => (200, JSON, self.status()),
            (Method::Get, "/data") => match self.renew() {
                Ok(contents) => {
                    let text = page::description(contents);
                    (200, JSON, format!("{{\"description\":{text},\"block\":\"{}\"}}", contents.block))
                }
                Err(error) => (500, TEXT, format!("{error}\n")),
            },
            (Method::Post, "/stop") => match header("Origin") {
                Some(origin) if !origin.strip_prefix("http://").is_some_and(is_here) => {
                    (403, TEXT, "a page from elsewhere cannot stop a run\n".into())
                }
                _ => match self.run.stop() {
                    Ok(()) => (200, TEXT, "asked to write a checkpoint and leave\n".into()),
                    Err(problem) => (409, TEXT, problem + "\n"),
                },
            },
            _ => (404, TEXT, "there is nothing here\n".into()),
        }
    }

    fn status(&self) -> String {
        let version = self.kept.as_ref().map(|kept| kept.version.as_str());
        let is_new = version != Some(self.version().as_str());
        json!({
            "status": read_json(&self.directory.join(STATUS)),
            "is_running": self.run.is_running(),
            "is_new": is_new,
            "version": version,
        })
        .to_string()
    }

    /// Reads the files if they have grown and it has not just been done.
    fn renew(&mut self) -> Result<&Contents, ReportError> {
        let version = self.version();
        let is_due =
            |kept: &Kept| kept.version != version && kept.read.elapsed() > PAUSE.0.max(kept.took * PAUSE.1);
        if self.kept.as_ref().is_none_or(is_due) {
            let begun = Instant::now();
            let mut contents = contents(self.directory)?;
            // A file in the middle of a step may be unreadable: what was read before stays until the next time.
            if let Some(kept) = self.kept.take().filter(|_| contents.description["scene"].is_null()) {
                contents = kept.contents;
            }
            self.kept = Some(Kept { contents, version, read: begun, took: begun.elapsed() });
        }
        match &self.kept {
            Some(kept) => Ok(&kept.contents),
            None => Err(ReportError::new(self.directory, "could not be read")),
        }
    }

    /// What changes when the files of the page do.
    fn version(&self) -> String {
        let of = |name: &str| {
            let metadata = fs::metadata(self.directory.join(name)).ok()?;
            let changed = metadata.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
            Some(format!("{}-{}", metadata.len(), changed.as_millis()))
        };
        let files =
            ["series.csv", "particles.vtkhdf", "fluid.vtkhdf", RUN].map(|name| of(name).unwrap_or_default());
        format!("{} {}", files.join(" "), self.run.is_running())
    }
}

/// Whether a host, with or without a port, is this machine.
fn is_here(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.chars().all(|c| c.is_ascii_digit()) => name,
        _ => host,
    };
    HOSTS.contains(&name)
}

/// A number that nobody guesses.
fn token() -> std::io::Result<String> {
    let mut bytes = [0_u8; 16];
    fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_this_machine_are_here() {
        for host in ["127.0.0.1:8020", "localhost", "localhost:9000", "[::1]:8020"] {
            assert!(is_here(host), "{host}");
        }
        for host in ["example.org", "127.0.0.1.example.org:80", "localhost.example.org", "", ":80"] {
            assert!(!is_here(host), "{host}");
        }
    }

    #[test]
    fn tokens_are_long_and_differ() {
        let [a, b] = [(); 2].map(|()| token().unwrap_or_default());
        assert!(a.len() == 32 && a != b);
    }
}
