//! From a path to what it names: front doors are followed to the file that defines the item.

use crate::scan::Defines;
use crate::tree::Tree;
use crate::use_tree::Binding;

/// The library's name in its programs.
const LIBRARY: &str = "pivot_cal";

/// What a path names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    Module(usize),
    Item {
        module: usize,
        name: String,
        defines: Defines,
    },
    /// Something of another crate.
    Outside,
}

/// All that `path` names in `module`: a module and a function may share a name. Nothing if there is no such thing.
pub(crate) fn resolve(tree: &Tree, module: usize, path: &[String]) -> Vec<Target> {
    Resolver { tree, asked: Vec::new() }.path(module, path)
}

/// All that `name` names as seen from within `module`; nothing if that is none of the package's business.
pub(crate) fn look_up(tree: &Tree, module: usize, name: &str) -> Vec<Target> {
    Resolver { tree, asked: Vec::new() }.name(module, name)
}

struct Resolver<'a> {
    tree: &'a Tree,
    /// What is being looked up already: a circle of re-exports leads nowhere.
    asked: Vec<(usize, String)>,
}

impl Resolver<'_> {
    fn path(&mut self, module: usize, path: &[String]) -> Vec<Target> {
        let mut here = self.first(module, &path[0]);
        for name in &path[1..] {
            let mut next = Vec::new();
            for target in here {
                for found in self.next(target, name) {
                    if !next.contains(&found) {
                        next.push(found);
                    }
                }
            }
            here = next;
        }
        here
    }

    fn first(&mut self, module: usize, name: &str) -> Vec<Target> {
        match name {
            "crate" => vec![Target::Module(self.tree.root(module))],
            "self" => vec![Target::Module(module)],
            "super" => self.parent(module),
            "" => vec![Target::Outside],
            _ => match (self.name(module, name), self.tree.library()) {
                (found, _) if !found.is_empty() => found,
                (_, Some(library)) if name == LIBRARY => vec![Target::Module(library)],
                _ => vec![Target::Outside],
            },
        }
    }

    fn next(&mut self, target: Target, name: &str) -> Vec<Target> {
        match target {
            Target::Module(module) if name == "super" => self.parent(module),
            Target::Module(module) => self.name(module, name),
            // a variant, an associated item
            Target::Item { defines: Defines::Type, .. } | Target::Outside => vec![target],
            Target::Item { .. } => Vec::new(),
        }
    }

    fn parent(&self, module: usize) -> Vec<Target> {
        self.tree.modules[module].parent.into_iter().map(Target::Module).collect()
    }

    fn name(&mut self, module: usize, name: &str) -> Vec<Target> {
        let here = &self.tree.modules[module];
        let mut found: Vec<Target> = here.children.get(name).copied().map(Target::Module).into_iter().collect();
        for &defines in here.scope.items.get(name).into_iter().flatten() {
            found.push(Target::Item { module, name: name.to_owned(), defines });
        }
        let question = (module, name.to_owned());
        if self.asked.contains(&question) {
            return found;
        }
        self.asked.push(question);
        let named = |binding: &Binding| matches!(binding, Binding::Name(bound) if bound == name);
        for import in here.scope.uses.iter().filter(|import| named(&import.binding)) {
            found.extend(self.path(module, &import.path));
        }
        let globs = here.scope.uses.iter().filter(|import| import.binding == Binding::All);
        for import in globs {
            if !found.is_empty() {
                break; // a name of its own goes before one of a glob
            }
            for target in self.path(module, &import.path) {
                found.extend(self.next(target, name));
            }
        }
        self.asked.pop();
        found
    }
}
