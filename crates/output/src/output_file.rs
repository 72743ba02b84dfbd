//! Output files, which appear under their names complete or not at all, and replace others only with
//! `overwrite`.
//!
//! A file is written under another name in the same folder, and renamed when it is finished.
//! [`OutputFile::create`] takes a unique name and removes the file after a failure. [`OutputFile::resumable`]
//! takes `NAME.partial`, which remains after a crash and can be resumed or recovered. Its writer holds a lock
//! on it, so that a name has one writer.

mod error;

pub use error::OutputError;

use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::io::{BufReader, BufWriter, Error, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The rule for the output files of a command.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    overwrite: bool,
    inputs: Vec<PathBuf>,
}

impl Outputs {
    /// A rule that replaces existing files with `overwrite`, but never `inputs`.
    pub fn new(overwrite: bool, inputs: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { overwrite, inputs: inputs.into_iter().collect() }
    }

    /// The check that a file may be written. Call it before the work.
    ///
    /// # Errors
    /// [`OutputError::Refused`].
    pub fn check(&self, file: &Path) -> Result<(), OutputError> {
        let same = |input: &PathBuf| input == file || is_same(input, file);
        if self.inputs.iter().any(same) {
            return Err(OutputError::input(file));
        }
        existing(file, self.overwrite)?;
        nameable(file)?;
        unlocked(file)
    }

    /// The check that the folder of a file exists, for a file that is written after the work.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn check_folder(file: &Path) -> Result<(), OutputError> {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let found = folder.map_or(Ok(()), |folder| folder.metadata().map(drop));
        found.map_err(|source| OutputError::write(file, source))
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// [`OutputError`]; an existing file is then unchanged.
    pub fn write(&self, file: &Path, contents: impl AsRef<[u8]>) -> Result<(), OutputError> {
        self.begin(file, contents)?.finish()
    }

    /// Writes a whole file, which appears under its name only with [`OutputFile::finish`].
    ///
    /// # Errors
    /// As [`Outputs::write`].
    pub fn begin(&self, file: &Path, contents: impl AsRef<[u8]>) -> Result<OutputFile, OutputError> {
        let mut output = self.create(file)?;
        let written = output.write_all(contents.as_ref()).and_then(|()| output.flush());
        written.map_err(|source| OutputError::write(file, source))?;
        Ok(output)
    }

    /// As [`OutputFile::create`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn create(&self, file: &Path) -> Result<OutputFile, OutputError> {
        self.check(file)?;
        OutputFile::create(file, self.overwrite)
    }
}

/// An output file that is being written.
#[derive(Debug)]
pub struct OutputFile {
    file: PathBuf,
    partial: PathBuf,
    overwrite: bool,
    /// Whether an unfinished partial file is removed on drop.
    is_removed: bool,
    writer: BufWriter<File>,
}

impl OutputFile {
    /// Begins a file under a unique name. If it is not finished, it is removed.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn create(file: &Path, overwrite: bool) -> Result<Self, OutputError> {
        unlocked(file)?;
        Self::under_own_name(file, overwrite)
    }

    fn under_own_name(file: &Path, overwrite: bool) -> Result<Self, OutputError> {
        let replaced = existing(file, overwrite)?;
        let write = |source| OutputError::write(file, source);
        let own = |n: u32| file.with_file_name(format!(".cocarry-{n}.tmp"));
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        for partial in (0..=u32::MAX).map(own) {
            match options.open(&partial) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(write(error)),
                Ok(opened) => {
                    let output = Self::new(file, partial, overwrite, opened);
                    output.take_permissions(replaced).map_err(write)?;
                    return Ok(output);
                }
            }
        }
        Err(write(ErrorKind::AlreadyExists.into()))
    }

    /// Opens or creates `NAME.partial` and locks it. Its contents stay; their length (bytes) is returned too.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn resumable(file: &Path, overwrite: bool) -> Result<(Self, u64), OutputError> {
        let partial = partial_name(file);
        let write = |source| OutputError::write(&partial, source);
        loop {
            existing(file, overwrite)?;
            existing(&partial, true)?;
            let mut options = OpenOptions::new();
            let opened = options.read(true).write(true).create(true).truncate(false).open(&partial);
            let opened = opened.map_err(write)?;
            match opened.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(OutputError::busy(&partial)),
                Err(TryLockError::Error(source)) => return Err(write(source)),
            }
            // the previous holder of the lock may just have renamed the file: then this is not the partial
            // file
            let metadata = opened.metadata().map_err(write)?;
            let is_partial = partial.symlink_metadata().is_ok_and(|named| is_one(&named, &metadata));
            if is_partial {
                let replaced = existing(file, overwrite)?;
                let mut output = Self::new(file, partial, overwrite, opened);
                output.is_removed = metadata.len() == 0;
                output.take_permissions(replaced).map_err(|source| OutputError::write(file, source))?;
                return Ok((output, metadata.len()));
            }
        }
    }

    /// As [`OutputFile::resumable`], from the beginning.
    ///
    /// # Errors
    /// [`OutputError`], also if the file exists and `overwrite` is not given.
    pub fn anew(file: &Path, overwrite: bool) -> Result<Self, OutputError> {
        let (mut output, length) = Self::resumable(file, overwrite)?;
        if length > 0 && !overwrite {
            return Err(OutputError::left_over(&output.partial));
        }
        output.cut(0).map_err(|source| OutputError::write(&output.partial, source))?;
        output.is_removed = true;
        Ok(output)
    }

    fn new(file: &Path, partial: PathBuf, overwrite: bool, opened: File) -> Self {
        Self { file: file.to_owned(), partial, overwrite, is_removed: true, writer: BufWriter::new(opened) }
    }

    fn take_permissions(&self, replaced: Option<Metadata>) -> Result<(), Error> {
        replaced.map_or(Ok(()), |replaced| self.as_file().set_permissions(replaced.permissions()))
    }

    /// The name of the file until it is finished.
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// The partial file.
    pub fn as_file(&self) -> &File {
        self.writer.get_ref()
    }

    /// Truncates the file to a length (bytes), and continues there.
    ///
    /// # Errors
    /// The system's.
    pub fn cut(&mut self, length: u64) -> Result<(), Error> {
        self.flush()?;
        self.as_file().set_len(length)?;
        self.writer.seek(SeekFrom::Start(length)).map(drop)
    }

    /// From now on the partial file stays if it is not finished.
    pub fn keep(&mut self) {
        self.is_removed = false;
    }

    /// Makes the final file from the complete partial one, which is then removed. `write` reads the partial
    /// file from its beginning, and writes the final one. After an error the partial file is as with
    /// [`OutputFile::keep`].
    ///
    /// # Errors
    /// [`OutputError`], also from `write`.
    pub fn finish_as(
        mut self,
        write: impl FnOnce(&mut BufReader<&File>, &mut Self) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let partial = self.partial.clone();
        let unread = |source| OutputError::write(&partial, source);
        self.writer.flush().and_then(|()| self.writer.rewind()).map_err(unread)?;
        let mut whole = Self::under_own_name(&self.file, self.overwrite)?;
        write(&mut BufReader::new(self.as_file()), &mut whole)?;
        whole.finish()?;
        self.is_removed = true;
        Ok(())
    }

    /// Renames the complete file.
    ///
    /// # Errors
    /// [`OutputError`], also if another file has the name meanwhile and may not be replaced.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let synced = self.writer.flush().and_then(|()| self.as_file().sync_all());
        synced.map_err(|source| OutputError::write(&self.partial, source))?;
        existing(&self.file, self.overwrite)?;
        let named = match self.overwrite {
            true => std::fs::rename(&self.partial, &self.file),
            false => link(&self.partial, &self.file),
        };
        match named {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(OutputError::exists(&self.file)),
            Err(source) => {
                // the file is complete and must stay
                self.is_removed = false;
                Err(OutputError::rename(&self.partial, &self.file, source))
            }
            Ok(()) => {
                self.is_removed = false;
                Ok(())
            }
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.writer.flush()
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> Result<u64, Error> {
        self.writer.seek(to)
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if self.is_removed {
            // if the removal fails, the first error is the one to report
            let _ = std::fs::remove_file(&self.partial);
        }
        // closing releases a lock only when no program that is being started has a copy of the file any more
        let _ = self.writer.flush();
        let _ = self.as_file().unlock();
    }
}

fn partial_name(file: &Path) -> PathBuf {
    let mut partial = file.as_os_str().to_owned();
    partial.push(".partial");
    PathBuf::from(partial)
}

/// The existing file of that name, if it may be replaced.
fn existing(file: &Path, overwrite: bool) -> Result<Option<Metadata>, OutputError> {
    // other problems with the name are reported when the file is created
    let Ok(found) = file.symlink_metadata() else { return Ok(None) };
    let kind = match found.file_type() {
        kind if kind.is_symlink() => "symbolic link",
        kind if kind.is_dir() => "directory",
        kind if kind.is_file() => "",
        _ => "special file",
    };
    match kind {
        "" if overwrite => Ok(Some(found)),
        "" => Err(OutputError::exists(file)),
        kind => Err(OutputError::not_a_file(file, kind)),
    }
}

/// An error if no file can have that name: it is too long.
fn nameable(file: &Path) -> Result<(), OutputError> {
    match file.symlink_metadata() {
        Err(source) if source.kind() == ErrorKind::InvalidFilename => Err(OutputError::no_name(file, source)),
        _ => Ok(()),
    }
}

/// An error if another process is writing the partial file of that name.
fn unlocked(file: &Path) -> Result<(), OutputError> {
    let partial = partial_name(file);
    // opening a FIFO would block
    let is_file = partial.symlink_metadata().is_ok_and(|found| found.is_file());
    let other = is_file.then(|| File::open(&partial).ok()).flatten();
    match other.map(|other| other.try_lock_shared()) {
        Some(Err(TryLockError::WouldBlock)) => Err(OutputError::busy(&partial)),
        _ => Ok(()),
    }
}

/// Renames a file to a name that does not exist.
fn link(partial: &Path, file: &Path) -> Result<(), Error> {
    match std::fs::hard_link(partial, file) {
        Ok(()) => std::fs::remove_file(partial),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(error),
        // not every file system supports links
        Err(_) => std::fs::rename(partial, file),
    }
}

fn is_same(a: &Path, b: &Path) -> bool {
    let metadata = |path: &Path| std::fs::metadata(path).ok();
    metadata(a).zip(metadata(b)).is_some_and(|(a, b)| is_one(&a, &b))
}

#[cfg(unix)]
fn is_one(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one(a: &Metadata, b: &Metadata) -> bool {
    (a.created().ok(), a.len()) == (b.created().ok(), b.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The sentence of a name that was refused.
    fn refusal<T>(result: Result<T, OutputError>) -> String {
        let error = result.err().expect("it is refused");
        assert!(error.is_refusal(), "{error}");
        error.to_string()
    }

    #[test]
    fn a_file_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        Outputs::default().write(&path, "one").unwrap();
        let again = Outputs::default().write(&path, "two");
        assert!(refusal(again).contains("exists already; "));
        let mut output = OutputFile::create(&path, true).unwrap();
        output.write_all(b"half of th").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        drop(output);
        assert_eq!(
            (std::fs::read(&path).unwrap(), names(folder.path())),
            (b"one".to_vec(), vec!["a.txt".to_owned()])
        );
        Outputs::new(true, []).write(&path, "two").unwrap();
        assert_eq!(
            (std::fs::read(&path).unwrap(), names(folder.path())),
            (b"two".to_vec(), vec!["a.txt".to_owned()])
        );
    }

    #[test]
    fn a_file_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let output = OutputFile::create(&path, false).unwrap();
        std::fs::write(&path, "mine").unwrap();
        assert!(refusal(output.finish()).contains("exists already; "));
        assert_eq!(
            (std::fs::read(&path).unwrap(), names(folder.path())),
            (b"mine".to_vec(), vec!["a.txt".to_owned()])
        );
    }

    #[test]
    fn inputs_folders_and_links_are_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("world.toml"), "mine").unwrap();
        std::fs::create_dir(path("folder")).unwrap();
        let outputs = Outputs::new(true, [path("folder/../world.toml")]);
        assert!(refusal(outputs.write(&path("world.toml"), "x")).contains("is an input of"));
        assert!(refusal(outputs.write(&path("folder"), "x")).contains("which is never replaced"));
        #[cfg(unix)]
        {
            use std::os::unix::fs::{PermissionsExt, symlink};
            std::fs::write(path("other"), "").unwrap();
            symlink(path("other"), path("link")).unwrap();
            assert!(refusal(outputs.write(&path("link"), "x")).contains("which is never replaced"));
            assert!(refusal(outputs.check(Path::new("/dev/null"))).contains("which is never replaced"));
            std::fs::write(path("private"), "").unwrap();
            std::fs::set_permissions(path("private"), PermissionsExt::from_mode(0o600)).unwrap();
            outputs.write(&path("private"), "x").unwrap();
            assert_eq!(path("private").metadata().unwrap().permissions().mode() & 0o777, 0o600);
        }
        assert_eq!(std::fs::read(path("world.toml")).unwrap(), b"mine");
    }

    #[test]
    fn a_name_has_one_writer() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let (mut first, length) = OutputFile::resumable(&path, false).unwrap();
        assert_eq!(length, 0);
        first.keep();
        first.write_all(b"row\n").unwrap();
        for overwrite in [false, true] {
            assert!(
                refusal(OutputFile::resumable(&path, overwrite)).contains("another process is writing it")
            );
            assert!(refusal(OutputFile::anew(&path, overwrite)).contains("another process is writing it"));
            assert!(refusal(OutputFile::create(&path, overwrite)).contains("another process is writing it"));
        }
        drop(first);
        assert_eq!(names(folder.path()), ["a.csv.partial"]);
        assert!(refusal(OutputFile::anew(&path, false)).contains("is unfinished"));
        let (again, length) = OutputFile::resumable(&path, false).unwrap();
        assert_eq!(length, 4);
        again.finish().unwrap();
        assert_eq!(
            (std::fs::read(&path).unwrap(), names(folder.path())),
            (b"row\n".to_vec(), vec!["a.csv".to_owned()])
        );
    }
}
