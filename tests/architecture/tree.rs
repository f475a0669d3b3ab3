//! The files of a package as a tree of modules.

use crate::scan::{Scan, Scope, scan};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The text of each file by its path, which begins with `src/`.
pub(crate) type Texts = BTreeMap<String, String>;

/// A module.
#[derive(Debug)]
pub(crate) struct Module {
    pub(crate) file: String,
    /// The module that declares it; none for the root of a crate.
    pub(crate) parent: Option<usize>,
    pub(crate) children: BTreeMap<String, usize>,
    pub(crate) scope: Scope,
}

/// All modules of the package's crates.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) modules: Vec<Module>,
    /// Lines of each file without its tests.
    pub(crate) lines: BTreeMap<String, usize>,
    /// What could not be read as it should.
    pub(crate) faults: Vec<String>,
    test_folders: BTreeSet<String>,
}

/// Rooms that are a crate of their own within `src`, with the crate's name.
const CRATES: [(&str, &str); 2] = [("control", "pivot_control"), ("library", "pivot_library")];

/// Reads every `.rs` file in `folder/src`. A room that is a crate of its own is read as a module of the library.
pub(crate) fn texts(folder: &Path) -> Texts {
    let mut texts = all_texts(folder);
    for (room, name) in CRATES {
        let (root, inside) = (format!("src/{room}/lib.rs"), format!("src/{room}/"));
        texts.retain(|path, _| !path.starts_with(&format!("{inside}tests/")));
        let files: Vec<String> = texts.keys().filter(|path| path.starts_with(&inside)).cloned().collect();
        for file in files {
            let text = texts.remove(&file).unwrap().replace("crate::", &format!("crate::{room}::"));
            texts.insert(if file == root { format!("src/{room}.rs") } else { file }, text);
        }
        let library = texts.get_mut("src/lib.rs").unwrap();
        *library = library.replace(&format!("pub use {name} as {room};"), &format!("pub mod {room};"));
    }
    texts
}

fn all_texts(folder: &Path) -> Texts {
    let mut texts = Texts::new();
    let mut folders = vec![folder.join("src")];
    while let Some(inside) = folders.pop() {
        for entry in std::fs::read_dir(&inside).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let parts = path.strip_prefix(folder).unwrap().iter();
                let name = parts.map(|part| part.to_str().unwrap()).collect::<Vec<_>>().join("/");
                texts.insert(name, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    texts
}

/// Follows the modules from the root of the library and of each program.
pub(crate) fn tree(texts: &Texts) -> Tree {
    let mut tree = Tree::default();
    for root in texts.keys().filter(|path| is_root(path)) {
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
        tree.add_file(texts, root, folder, None);
    }
    let test = |path: &str| tree.test_folders.iter().any(|name| in_module(path, name));
    let lost = texts.keys().filter(|path| !tree.lines.contains_key(*path) && !test(path));
    let lost: Vec<_> = lost.map(|path| format!("{path} is declared by no module")).collect();
    tree.faults.extend(lost);
    tree
}

impl Tree {
    /// The library's root.
    pub(crate) fn library(&self) -> Option<usize> {
        self.modules.iter().position(|module| module.file == "src/lib.rs" && module.parent.is_none())
    }

    /// The root of the crate that holds `module`.
    pub(crate) fn root(&self, module: usize) -> usize {
        self.modules[module].parent.map_or(module, |parent| self.root(parent))
    }

    /// Whether `module` is `outer` or lies within it.
    pub(crate) fn within(&self, module: usize, outer: usize) -> bool {
        module == outer || self.modules[module].parent.is_some_and(|parent| self.within(parent, outer))
    }

    fn add_file(&mut self, texts: &Texts, file: &str, folder: &str, parent: Option<usize>) -> usize {
        let Scan { scope, test_modules, lines } = scan(&texts[file]);
        self.lines.insert(file.to_owned(), lines);
        self.test_folders.extend(test_modules.iter().map(|name| format!("{folder}/{name}")));
        self.add(texts, file, folder, parent, scope)
    }

    fn add(&mut self, texts: &Texts, file: &str, folder: &str, parent: Option<usize>, mut scope: Scope) -> usize {
        let index = self.modules.len();
        let (inner, files) = (std::mem::take(&mut scope.inner), scope.files.clone());
        self.modules.push(Module { file: file.to_owned(), parent, children: BTreeMap::new(), scope });
        for (name, scope) in inner {
            let child = self.add(texts, file, &format!("{folder}/{name}"), Some(index), scope);
            self.modules[index].children.insert(name, child);
        }
        for name in files {
            let below = format!("{folder}/{name}");
            let places = [format!("{below}.rs"), format!("{below}/mod.rs")];
            match places.iter().find(|place| texts.contains_key(*place)) {
                Some(place) => {
                    let child = self.add_file(texts, place, &below, Some(index));
                    self.modules[index].children.insert(name, child);
                }
                None => self.faults.push(format!("{file} declares `mod {name};`, which has no file")),
            }
        }
        index
    }
}

/// Whether the file is the root of a crate: the library, the program, or one of the folder `bin`.
fn is_root(path: &str) -> bool {
    let bin = path.strip_prefix("src/bin/").is_some_and(|rest| !rest.contains('/') || rest.ends_with("/main.rs"));
    path == "src/lib.rs" || path == "src/main.rs" || bin
}

/// Whether the file is that of the module `name` (a path without `.rs`) or lies in its folder.
fn in_module(path: &str, name: &str) -> bool {
    path.strip_prefix(name).is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
}
