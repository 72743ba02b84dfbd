//! The files of the page: of a folder, or within the program.

#[cfg(not(feature = "page"))]
use anyhow::Context;
use anyhow::anyhow;
use cocarry::located;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The built page: names and contents. `build.rs` writes the list.
#[cfg(feature = "page")]
const BUILT: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page.rs"));

/// Where the page is in a clone of the project.
const IN_CLONE: &str = "viewer/dist/page";
/// The page itself.
const INDEX: &str = "index.html";
/// The largest file that is served, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The files that are served.
#[derive(Debug)]
pub(crate) enum Pages {
    /// Those of a folder, by its real path.
    Folder(PathBuf),
    /// Those within the program.
    #[allow(dead_code, reason = "the feature `page` brings them")]
    Built(&'static [(&'static str, &'static [u8])]),
}

/// A file and its MIME type.
#[derive(Debug, PartialEq)]
pub(crate) struct Served {
    pub mime: &'static str,
    pub bytes: Cow<'static, [u8]>,
}

impl Pages {
    /// The page in a folder, or within the program, or as a clone of the project has it.
    pub fn find(folder: Option<&Path>) -> anyhow::Result<Self> {
        if let Some(folder) = folder {
            let has_page = folder.join(INDEX).is_file();
            return match folder.canonicalize() {
                Ok(real) if has_page => Ok(Self::Folder(real)),
                Ok(_) => Err(anyhow!(
                    "--page {}: has no {INDEX}; give the folder that `crates/web/build` writes, {IN_CLONE}",
                    folder.display()
                )),
                Err(error) => Err(anyhow!(error).context(format!("--page {}", folder.display()))),
            };
        }
        #[cfg(feature = "page")]
        return Ok(Self::Built(BUILT));
        #[cfg(not(feature = "page"))]
        match Path::new(IN_CLONE).join(INDEX).is_file() {
            true => Ok(Self::Folder(Path::new(IN_CLONE).canonicalize().context(IN_CLONE)?)),
            false => Err(anyhow!(
                "this program was built without the page. In a clone of the project, `crates/web/build` makes it in \
                 {IN_CLONE}; then `cocarry demo --page {IN_CLONE}` serves it, and a program built with `--features page` \
                 has it within"
            )),
        }
    }

    /// The file at the path of a request; `None` if there is none. A path has no escapes, no hidden names and no
    /// way out of the folder: the names of a page's files need none.
    pub fn get(&self, path: &str) -> Option<Served> {
        let path = path.split(['?', '#']).next()?.strip_prefix('/')?;
        let name = if path.is_empty() { INDEX } else { path };
        let is_plain = |part: &str| {
            let is_name = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            !part.is_empty() && !part.starts_with('.') && part.chars().all(is_name)
        };
        if !name.split('/').all(is_plain) {
            return None;
        }
        let bytes = match self {
            Self::Built(files) => Cow::Borrowed(files.iter().find(|(file, _)| *file == name)?.1),
            Self::Folder(folder) => Cow::Owned(read(folder, name)?),
        };
        Some(Served { mime: mime(name), bytes })
    }
}

/// A regular file that is really in the folder.
fn read(folder: &Path, name: &str) -> Option<Vec<u8>> {
    let real = folder.join(name).canonicalize().ok()?;
    if !real.starts_with(folder) || !real.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    located::open(&real).ok()?.take(MAX_BYTES).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// The MIME type of a file, by its extension.
fn mime(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "gif" => "image/gif",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "toml" | "txt" | "md" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILT: Pages =
        Pages::Built(&[("index.html", b"page"), ("cocarry.wasm", b"module"), (".secret", b"no")]);

    #[test]
    fn a_page_has_its_files_with_their_types() {
        let types = ["/", "/index.html?world=1", "/cocarry.wasm"].map(|path| BUILT.get(path).unwrap().mime);
        assert_eq!(types, ["text/html; charset=utf-8", "text/html; charset=utf-8", "application/wasm"]);
        assert_eq!(*BUILT.get("/cocarry.wasm").unwrap().bytes, *b"module");
    }

    #[test]
    fn nothing_else_has_a_path() {
        for path in [
            "",
            "index.html",
            "//index.html",
            "/../index.html",
            "/%2e%2e/x",
            "/.secret",
            "/a\\b",
            "/a\0",
            "/other",
        ] {
            assert_eq!(BUILT.get(path), None, "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_out_of_the_folder_is_not_followed() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret.txt"), "secret").unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("index.html"), "page").unwrap();
        std::os::unix::fs::symlink(outside.path().join("secret.txt"), folder.path().join("a.txt")).unwrap();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        let pages = Pages::find(Some(folder.path())).unwrap();
        assert_eq!(*pages.get("/").unwrap().bytes, *b"page");
        assert_eq!(pages.get("/a.txt"), None);
        assert_eq!(pages.get("/sub"), None);
    }
}
