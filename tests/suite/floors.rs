//! The one-way rule: a file uses only floors below its own, and files do not use each other in a circle.

use crate::support::repository;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The floors from the bottom; those in one row may not use each other.
const FLOORS: [&[&str]; 25] = [
    &["math", "suggestion", "output_file"],
    &["error"],
    &["located", "saved"],
    &["geometry", "palette"],
    &["robot"],
    &["world"],
    &["options"],
    &["preference"],
    &["coordination"],
    &["control", "learning"],
    &["simulation"],
    &["arithmetic"],
    &["human"],
    &["policy"],
    &["team"],
    &["episode"],
    &["scenario"],
    &["quantities"],
    &["recording", "drawing"],
    &["rendering"],
    &["statistics", "table", "parallel", "columns", "zarr"],
    &["paper"],
    &["study", "fit", "regression"],
    &["report", "cluster"],
    &["cli"],
];

fn floor(module: &str) -> usize {
    FLOORS
        .iter()
        .position(|row| row.contains(&module))
        .unwrap_or_else(|| panic!("module `{module}` stands on no floor: add it to the list"))
}

/// The modules that a source text uses through `crate::…`, outside comments.
fn used(source: &str) -> Vec<String> {
    let code = source.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(|line| {
        line.match_indices("crate::").map(|(at, found)| {
            let rest = &line[at + found.len()..];
            rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
        })
    })
    .filter(|module| !module.is_empty())
    .collect()
}

fn offences(module: &str, source: &str) -> Vec<String> {
    used(source).into_iter().filter(|other| other != module && floor(other) >= floor(module)).collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => found.extend(sources(&path)),
            false => found.push(path),
        }
    }
    found
}

#[test]
fn every_file_uses_only_floors_below_its_own() {
    let src = repository("src");
    let mut looked_at = 0;
    for path in sources(&src) {
        let relative = path.strip_prefix(&src).expect("below src");
        let first = relative.components().next().expect("a name").as_os_str().to_string_lossy();
        let module = first.trim_end_matches(".rs");
        if ["lib", "main"].contains(&module) {
            continue;
        }
        let source = std::fs::read_to_string(&path).expect("text");
        let offences = offences(module, &source);
        assert!(offences.is_empty(), "{} uses {offences:?}, which is not below it", relative.display());
        looked_at += 1;
    }
    assert!(looked_at > 20, "only {looked_at} files were looked at");
}

#[test]
fn the_check_can_fail() {
    assert_eq!(offences("options", "use crate::geometry::Point;\nuse crate::episode::run;"), ["episode"]);
    assert_eq!(offences("recording", "fn f() { crate::drawing::map() }"), ["drawing"]);
    assert!(offences("options", "//! see crate::episode").is_empty());
}

/// A module by its path, as in `["options", "roadmap"]`; a folder's `mod.rs` is the module of the folder.
type Module = Vec<String>;

/// The words and signs of a source text up to its tests, without comments and literals; `::` is one sign.
fn tokens(source: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let quoted = |quote: char| {
            let mut escaped = false;
            let end = rest[1..].find(|c| {
                let ends = c == quote && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            2 + end.expect("a quote that ends")
        };
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let is_letter = rest[1..].starts_with('\\') || rest.chars().nth(2) == Some('\'');
        let (length, is_kept) = match first {
            '/' if rest.starts_with("//") => (rest.find('\n').unwrap_or(rest.len()), false),
            'r' if rest.starts_with("r#\"") => (rest.find("\"#").expect("a quote that ends") + 2, false),
            '"' => (quoted('"'), false),
            '\'' if is_letter => (quoted('\''), false),
            ':' if rest.starts_with("::") => (2, true),
            _ if word > 0 => (word, true),
            _ => (first.len_utf8(), !first.is_whitespace()),
        };
        if is_kept {
            tokens.push(rest[..length].to_owned());
        }
        rest = &rest[length..];
    }
    let tests = ["#", "[", "cfg", "(", "test", ")", "]", "mod"];
    let end = tokens.windows(tests.len()).position(|window| window == tests);
    tokens.truncate(end.unwrap_or(tokens.len()));
    tokens
}

/// The paths in a `use` after `prefix`, each with the name that it brings in; and how many tokens they take.
fn use_tree(tokens: &[String], prefix: &[String], paths: &mut Vec<(Module, String)>) -> usize {
    let mut path = prefix.to_vec();
    let mut at = 0;
    loop {
        match tokens[at].as_str() {
            "{" => {
                at += 1;
                while tokens[at] != "}" {
                    at += use_tree(&tokens[at..], &path, paths);
                    at += usize::from(tokens[at] == ",");
                }
                return at + 1;
            }
            "::" => {}
            "as" => {
                let last = paths.last_mut().expect("a name before `as`");
                last.1 = tokens[at + 1].clone();
                return at + 2;
            }
            word => {
                if word != "self" || path.is_empty() {
                    path.push(word.to_owned());
                }
                if tokens[at + 1] != "::" {
                    paths.push((path.clone(), path[path.len() - 1].clone()));
                    if tokens[at + 1] != "as" {
                        return at + 1;
                    }
                }
            }
        }
        at += 1;
    }
}

/// What a file names: with `use`, and in paths.
#[derive(Default)]
struct Named {
    imports: Vec<(Module, String)>,
    /// All paths but those that are only re-exported.
    uses: Vec<Module>,
}

impl Named {
    fn of(source: &str, children: &BTreeSet<String>) -> Self {
        let tokens = tokens(source);
        let mut named = Self::default();
        let mut at = 0;
        while at < tokens.len() {
            let is_use = tokens[at] == "use" && tokens.get(at + 1).is_some_and(|next| next != "<");
            if tokens[at..].starts_with(&["pub", "(", "in"].map(String::from)) {
                at += tokens[at..].iter().position(|token| token == ")").expect("a bracket that closes");
            } else if is_use {
                let is_public = at > 0 && ["pub", ")"].contains(&tokens[at - 1].as_str());
                let mut paths = Vec::new();
                at += use_tree(&tokens[at + 1..], &[], &mut paths);
                if !is_public {
                    named.uses.extend(paths.iter().map(|(path, _)| path.clone()));
                }
                named.imports.append(&mut paths);
            } else if ["crate", "super", "self"].contains(&tokens[at].as_str())
                || children.contains(&tokens[at])
            {
                let mut path = vec![tokens[at].clone()];
                while tokens.get(at + 1).is_some_and(|next| next == "::") && tokens[at + 2] != "<" {
                    path.push(tokens[at + 2].clone());
                    at += 2;
                }
                if path.len() > 1 {
                    named.uses.push(path);
                }
            }
            at += 1;
        }
        named
    }
}

/// Which files use which, by the paths in them; a name that a file re-exports belongs to the file that has it.
struct Files(BTreeMap<Module, Named>);

impl Files {
    fn new(sources: &BTreeMap<Module, String>) -> Self {
        let children = |module: &Module| -> BTreeSet<String> {
            let below =
                sources.keys().filter(|other| other.len() == module.len() + 1 && other.starts_with(module));
            below.map(|other| other[module.len()].clone()).collect()
        };
        Self(
            sources
                .iter()
                .map(|(module, source)| (module.clone(), Named::of(source, &children(module))))
                .collect(),
        )
    }

    /// A path as seen from the root; none into other crates.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Module> {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let (from, skipped) = match path[0].as_str() {
            "crate" => (0, 1),
            "self" => (module.len(), 1),
            "super" => (module.len().checked_sub(supers)?, supers),
            first => {
                let child = [module, &[first.to_owned()]].concat();
                (self.0.contains_key(&child).then_some(module.len())?, 0)
            }
        };
        Some([&module[..from], &path[skipped..]].concat())
    }

    /// The file that has what a path names.
    fn owner(&self, path: &[String], depth: usize) -> Option<Module> {
        let length = (1..=path.len()).rev().find(|&n| self.0.contains_key(&path[..n]))?;
        let (module, rest) = path.split_at(length);
        let import = rest
            .first()
            .filter(|_| depth < 8)
            .and_then(|name| self.0[module].imports.iter().find(|(_, brought_in)| brought_in == name));
        match import {
            None => Some(module.to_vec()),
            Some((found, _)) => {
                let found = [&self.absolute(module, found)?, &rest[1..]].concat();
                self.owner(&found, depth + 1)
            }
        }
    }

    fn used_by(&self, module: &Module) -> BTreeSet<Module> {
        let uses = self.0[module].uses.iter().filter_map(|path| self.absolute(module, path));
        uses.filter_map(|path| self.owner(&path, 0)).filter(|other| other != module).collect()
    }

    /// The sets of files that all lead to each other.
    fn circles(&self) -> Vec<Vec<String>> {
        let used: BTreeMap<&Module, BTreeSet<Module>> =
            self.0.keys().map(|module| (module, self.used_by(module))).collect();
        let reached = |from: &Module| {
            let mut reached = BTreeSet::new();
            let mut next: Vec<&Module> = used[from].iter().collect();
            while let Some(module) = next.pop() {
                if reached.insert(module.clone()) {
                    next.extend(&used[module]);
                }
            }
            reached
        };
        let reached: BTreeMap<&Module, BTreeSet<Module>> = self.0.keys().map(|m| (m, reached(m))).collect();
        let circle = |module: &Module| -> Vec<String> {
            let others = reached[module].iter().filter(|other| reached[other].contains(module));
            others.map(|module| module.join("::")).collect()
        };
        let circles: BTreeSet<Vec<String>> =
            self.0.keys().map(circle).filter(|circle| !circle.is_empty()).collect();
        circles.into_iter().collect()
    }
}

#[test]
fn files_do_not_use_each_other_in_a_circle() {
    let src = repository("src");
    let module = |path: &Path| -> Option<Module> {
        let relative = path.strip_prefix(&src).expect("below src").with_extension("");
        let mut module: Module = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        module.pop_if(|last| last == "mod");
        (!["lib", "main"].contains(&&*module[0])).then_some(module)
    };
    let read = |path: &PathBuf| std::fs::read_to_string(path).expect("text");
    let sources: BTreeMap<Module, String> =
        sources(&src).iter().filter_map(|path| Some((module(path)?, read(path)))).collect();
    assert!(sources.len() > 200, "only {} files were looked at", sources.len());
    assert_eq!(Files::new(&sources).circles(), Vec::<Vec<String>>::new());
}

#[test]
fn the_check_for_circles_can_fail() {
    let circles = |sources: &[(&str, &str)]| {
        let module = |name: &str| name.split("::").map(str::to_owned).collect::<Module>();
        Files::new(&sources.iter().map(|(name, text)| (module(name), (*text).to_owned())).collect()).circles()
    };
    let one_way = [("a", "pub use b::B;"), ("a::b", "pub struct B;"), ("a::c", "use super::B;")];
    assert!(circles(&one_way).is_empty());
    let through_a_re_export =
        [("a", "pub use b::B; pub use c::C;"), ("a::b", "use super::{C};"), ("a::c", "use super::B;")];
    assert_eq!(circles(&through_a_re_export), [["a::b", "a::c"]]);
    let in_a_path = [("a", "pub struct A; fn f() { b::g() }"), ("a::b", "fn g(_: &super::A) {}")];
    assert_eq!(circles(&in_a_path), [["a", "a::b"]]);
    let nested =
        [("a", "use crate::b::{x::{self, Y}, Z as W};"), ("b", ""), ("b::x", "fn f() { crate::a::g() }")];
    assert_eq!(circles(&nested), [["a", "b::x"]]);
    let in_a_test =
        [("a", "use crate::b::B;"), ("b", "// crate::a\n#[cfg(test)]\nmod tests { use crate::a::A; }")];
    assert!(circles(&in_a_test).is_empty());
}
