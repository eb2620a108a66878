//! Files that appear together or not at all.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::console;
use crate::exit::Failure;

/// Refuses outputs that exist (unless `force`), that are one another or the input, or that have no folder to be in.
/// Runs before any work.
pub fn check(input: &Path, outputs: &[&Path], force: bool) -> Result<(), Failure> {
    for (i, path) in outputs.iter().enumerate() {
        if same_file(path, input) {
            return Err(Failure::Usage(format!("{}: is the input itself", path.display())));
        }
        if outputs[..i].iter().any(|other| same_file(path, other)) {
            return Err(Failure::Usage(format!("{}: is given for two outputs", path.display())));
        }
        if path.is_dir() {
            return Err(Failure::output(path, "is a folder; a file name is needed"));
        }
        if path.exists() && !force {
            return Err(Failure::output(path, "exists already; --force overwrites it"));
        }
        let folder = folder_of(path);
        let existing = folder.ancestors().find(|a| a.as_os_str().is_empty() || a.exists());
        if existing.is_some_and(|a| !a.as_os_str().is_empty() && !a.is_dir()) {
            return Err(Failure::output(path, "its folder is a file"));
        }
    }
    Ok(())
}

/// Writes all files under temporary names in their folders, then renames them. On failure none of them is left.
pub fn write(files: &[(&Path, Vec<u8>)]) -> Result<(), Failure> {
    console::begin_writing()?;
    let mut folders = Vec::new();
    let written = stage(files, &mut folders).and_then(publish);
    if written.is_err() {
        for folder in folders.iter().rev() {
            // Only folders that this run made, and only while they are empty.
            let _ = fs::remove_dir(folder);
        }
    }
    written
}

fn stage<'a>(
    files: &'a [(&Path, Vec<u8>)],
    folders: &mut Vec<PathBuf>,
) -> Result<Vec<(&'a Path, NamedTempFile)>, Failure> {
    let mut staged = Vec::new();
    for (path, bytes) in files {
        let folder = folder_of(path);
        make_folder(&folder, folders).map_err(|e| Failure::output(&folder, e))?;
        let file = write_temporary(&folder, bytes).map_err(|e| Failure::output(path, e))?;
        staged.push((*path, file));
        if console::cancelled() {
            return Err(Failure::Cancelled);
        }
    }
    Ok(staged)
}

fn publish(staged: Vec<(&Path, NamedTempFile)>) -> Result<(), Failure> {
    let mut new = Vec::new();
    for (path, file) in staged {
        let existed = path.exists();
        if let Err(error) = file.persist(path) {
            for path in new {
                let _ = fs::remove_file(path);
            }
            return Err(Failure::output(path, error.error));
        }
        if !existed {
            new.push(path);
        }
    }
    Ok(())
}

fn write_temporary(folder: &Path, bytes: &[u8]) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".scanwright-");
    // Temporary files are private by default; outputs are ordinary files, subject to the user's mask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Makes `folder` and its missing parents, noting each.
fn make_folder(folder: &Path, made: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    if let Some(parent) = folder.parent().filter(|p| !p.as_os_str().is_empty()) {
        make_folder(parent, made)?;
    }
    fs::create_dir(folder)?;
    made.push(folder.to_owned());
    Ok(())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Whether two paths lead to one file, which need not exist.
fn same_file(a: &Path, b: &Path) -> bool {
    let resolve = |path: &Path| {
        let folder = fs::canonicalize(folder_of(path)).unwrap_or_else(|_| folder_of(path));
        fs::canonicalize(path).unwrap_or_else(|_| folder.join(path.file_name().unwrap_or_default()))
    };
    resolve(a) == resolve(b)
}
