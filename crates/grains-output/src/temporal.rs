//! What all files of snapshots have in common: begun, continued, appended to, described by an XDMF file.

use crate::digests::Digests;
use crate::error::{FileError, Identity, Shared};
use crate::metadata::{GROUP, Metadata, write_metadata};
use crate::parallel_file::ParallelFile;
use crate::watch::Watch;
use crate::xdmf::{Description, name_of};
use hdf5::File;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::CommunicatorCollectives;
use std::path::Path;

const UNFIT: &str = "cannot be continued (move it aside, or run without --restart)";

/// What kinds of such files differ in.
pub(crate) trait Layout {
    /// The open arrays of a file.
    type Arrays;
    /// Where a step lies in them.
    type Place;
    /// One rank's share of a step.
    type Step<'a>;

    /// Creates all arrays of a new file, without rows; all ranks take part.
    fn create(&self, file: &File, compress: bool) -> hdf5::Result<Self::Arrays>;
    /// Writes what a new file holds besides its steps; all ranks take part.
    fn begin(&self, _shared: &Shared, _file: &File) -> hdf5::Result<()> {
        Ok(())
    }
    /// Opens the arrays of a file that must hold just these fields.
    fn open(&self, file: &File) -> hdf5::Result<Self::Arrays>;
    /// The steps of a file that one rank alone has opened; refuses what this run cannot continue.
    fn places(&self, file: &File) -> hdf5::Result<Vec<Self::Place>>;
    /// Forgets all steps but the first ones.
    fn cut(&self, arrays: &Self::Arrays, kept: &[Self::Place]) -> hdf5::Result<()>;
    /// Time (s) of a step of the file.
    fn time(place: &Self::Place) -> f64;
    /// Time (s) of a step to come.
    fn time_of(step: &Self::Step<'_>) -> f64;
    /// Whether this rank's share of a step is as long as it must be.
    fn fits(&self, step: &Self::Step<'_>) -> Result<(), String>;
    /// Names of the arrays that have checksums.
    fn arrays(&self) -> Vec<String>;
    /// Checksum of where and when a step is.
    fn digest(&self, place: &Self::Place) -> u64;
    /// Writes a step after others, and returns where and this rank's part of the checksums of its arrays; all ranks
    /// take part.
    fn write(
        &self,
        shared: &Shared,
        arrays: &Self::Arrays,
        before: &[Self::Place],
        step: &Self::Step<'_>,
    ) -> Result<(Self::Place, Vec<u64>), FileError>;
    /// Lets readers see the steps; all ranks take part.
    fn publish(&self, arrays: &Self::Arrays, steps: usize) -> hdf5::Result<()>;
    /// The XDMF grids of the step of a number; `file` is the name of the data as XML wants it.
    fn description(&self, file: &str, step: usize, place: &Self::Place) -> String;
}

/// The arrays come first: the file closes only when nothing in it is open any more.
struct Opened<A> {
    arrays: A,
    /// None in a file of a version without.
    digests: Option<Digests>,
    file: ParallelFile,
}

/// A growing file of snapshots; all calls are collective.
///
/// It is complete after each [`Temporal::append`], so that a run may be killed at any time.
pub(crate) struct Temporal<L: Layout> {
    /// The file and the ranks.
    pub shared: Shared,
    /// What the file holds.
    pub layout: L,
    /// Open for all ranks; none after a failed write.
    opened: Option<Opened<L::Arrays>>,
    /// What the open file is known by, on rank 0.
    identity: Option<Identity>,
    steps: Vec<L::Place>,
    /// The XDMF file beside it, on rank 0, from the first step on.
    description: Option<Description>,
}

impl<L: Layout> Temporal<L> {
    /// Creates a file; one of that name is lost.
    ///
    /// # Errors
    /// A file that cannot be created.
    pub fn create(
        path: &Path,
        communicator: &SimpleCommunicator,
        layout: L,
        compress: bool,
        metadata: &Metadata,
    ) -> Result<Self, FileError> {
        let shared = Shared::new(path, communicator);
        shared.create_empty()?;
        shared.has_room()?;
        let _watch = Watch::over(&shared);
        let file = shared.all("cannot be created", ParallelFile::create(path, &shared.communicator))?;
        let arrays = shared.written(layout.create(&file, compress))?;
        shared.written(layout.begin(&shared, &file))?;
        shared.written(write_metadata(&file, GROUP, metadata))?;
        let digests = Digests::create(&file, &layout.arrays(), metadata);
        let digests = shared.written(digests)?;
        shared.written(file.flush())?;
        let opened = Some(Opened { arrays, digests: Some(digests), file });
        let identity = Identity::of(path);
        Ok(Self { shared, layout, opened, identity, steps: Vec::new(), description: None })
    }

    /// Continues a file, forgetting every step after `time` (s).
    ///
    /// A step at `time` itself stays until it is appended again.
    ///
    /// # Errors
    /// A file that cannot be opened, or that holds something else.
    pub fn resume(
        path: &Path,
        communicator: &SimpleCommunicator,
        layout: L,
        time: f64,
    ) -> Result<Self, FileError> {
        let shared = Shared::new(path, communicator);
        // Each rank alone first: a file that is no HDF5 must not stop the ranks at different calls.
        let found = File::open(path).and_then(|file| layout.places(&file));
        let steps = shared.all(UNFIT, found)?;
        let mut file = Self { shared, layout, opened: None, identity: None, steps, description: None };
        let is_kept = |place: &&L::Place| {
            let at = L::time(place);
            at <= time || is_same_time(at, time)
        };
        file.keep(file.steps.iter().take_while(is_kept).count())?;
        file.describe()?;
        Ok(file)
    }

    /// Writes metadata of a continued run into the group `grains-mpi/restart-<n>`.
    ///
    /// # Errors
    /// A full disk.
    pub fn record_restart(&self, metadata: &Metadata) -> Result<(), FileError> {
        let file = &self.opened()?.file;
        let _watch = Watch::over(&self.shared);
        let written = (|| {
            let before = file.group(GROUP)?.member_names()?.len();
            write_metadata(file, &format!("{GROUP}/restart-{}", before + 1), metadata)?;
            file.flush()
        })();
        self.shared.written(written)
    }

    /// Whether the last step is that at `time` (s).
    pub fn holds(&self, time: f64) -> bool {
        self.steps.last().is_some_and(|last| is_same_time(L::time(last), time))
    }

    /// Appends a step; one at the same time or later, left from an earlier run, is replaced.
    ///
    /// # Errors
    /// A full disk, a file that cannot be written, or fields whose lengths do not fit.
    pub fn append(&mut self, step: &L::Step<'_>) -> Result<(), FileError> {
        self.shared.agree(self.layout.fits(step))?;
        self.shared.first(|| Identity::require(self.identity, &self.shared.path))?;
        self.shared.has_room()?;
        let _watch = Watch::over(&self.shared);
        let outcome = self.append_fitting(step);
        if outcome.is_err() {
            self.opened = None;
        }
        outcome
    }

    fn append_fitting(&mut self, step: &L::Step<'_>) -> Result<(), FileError> {
        let now = L::time_of(step);
        let is_before = |place: &L::Place| L::time(place) < now && !is_same_time(L::time(place), now);
        let kept = self.steps.iter().rposition(is_before).map_or(0, |last| last + 1);
        if kept < self.steps.len() {
            self.keep(kept)?;
        }
        let Opened { file, arrays, digests } = self.opened()?;
        let (place, own) = self.layout.write(&self.shared, arrays, &self.steps, step)?;
        if let Some(digests) = digests {
            let mut row = vec![0_u64; own.len() + 1];
            self.shared.communicator.all_reduce_into(&own[..], &mut row[1..], SystemOperation::sum());
            row[0] = self.layout.digest(&place);
            let at = self.steps.len();
            self.shared.written(digests.resize(at + 1))?;
            self.shared.written(if self.shared.is_first() { digests.write(at, &row) } else { Ok(()) })?;
        }
        self.shared.written(self.layout.publish(arrays, self.steps.len() + 1))?;
        self.shared.written(file.flush())?;
        self.steps.push(place);
        self.describe()
    }

    /// Brings the XDMF file up to date: by the last step, or all if steps were forgotten.
    fn describe(&mut self) -> Result<(), FileError> {
        let Self { shared, layout, steps, description, .. } = self;
        let file = name_of(&shared.path);
        let text = |step: usize| layout.description(&file, step, &steps[step]);
        shared.first(|| {
            match description {
                Some(description) => description.append(&text(steps.len() - 1))?,
                None => *description = Some(Description::create(&shared.path, (0..steps.len()).map(text))?),
            }
            Ok(())
        })
    }

    /// Keeps the first `kept` steps and opens the file for all ranks.
    ///
    /// Rank 0 alone cuts it: HDF5 1.10 spoils compressed chunks that shrink in a file open for many ranks.
    fn keep(&mut self, kept: usize) -> Result<(), FileError> {
        self.opened = None;
        self.shared.communicator.barrier();
        if kept < self.steps.len() {
            self.steps.truncate(kept);
            self.description = None;
            let cut = || {
                let file = File::open_rw(&self.shared.path)?;
                self.layout.cut(&self.layout.open(&file)?, &self.steps)?;
                Digests::open(&file)?.map_or(Ok(()), |digests| digests.resize(kept))?;
                file.close()
            };
            let outcome = if self.shared.is_first() { cut() } else { Ok(()) };
            self.shared.all(UNFIT, outcome)?;
        }
        let file = ParallelFile::open(&self.shared.path, &self.shared.communicator);
        let file = self.shared.all(UNFIT, file)?;
        let arrays = self.shared.all(UNFIT, self.layout.open(&file))?;
        let digests = self.shared.all(UNFIT, Digests::open(&file))?;
        self.opened = Some(Opened { arrays, digests, file });
        self.identity = Identity::of(&self.shared.path);
        Ok(())
    }

    fn opened(&self) -> Result<&Opened<L::Arrays>, FileError> {
        let closed = || FileError::new(&self.shared.path, "is closed after an earlier error");
        self.opened.as_ref().ok_or_else(closed)
    }
}

fn is_same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}
