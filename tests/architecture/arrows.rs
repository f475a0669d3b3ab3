//! Which file takes what from which.

use crate::resolve::{Target, look_up, resolve};
use crate::tree::Tree;
use crate::use_tree::{Binding, Use};
use std::collections::{BTreeMap, BTreeSet};

/// The names that the first file takes from the second.
pub(crate) type Ties = BTreeMap<(String, String), BTreeSet<String>>;

/// The ties between the package's files, and what could not be resolved.
#[derive(Debug, Default)]
pub(crate) struct Arrows {
    pub(crate) ties: Ties,
    pub(crate) faults: Vec<String>,
}

/// Resolves all that the files import and name.
pub(crate) fn arrows(tree: &Tree) -> Arrows {
    let mut drawer = Drawer { tree, arrows: Arrows::default() };
    for (module, here) in tree.modules.iter().enumerate() {
        for import in &here.scope.uses {
            drawer.import(module, import);
        }
        for path in &here.scope.paths {
            for target in drawer.resolved(module, path) {
                drawer.tie(module, &target);
            }
        }
    }
    drawer.arrows
}

struct Drawer<'a> {
    tree: &'a Tree,
    arrows: Arrows,
}

impl Drawer<'_> {
    fn resolved(&mut self, module: usize, path: &[String]) -> Vec<Target> {
        let targets = resolve(self.tree, module, path);
        if targets.is_empty() {
            let fault = format!("{}: there is no {}", self.tree.modules[module].file, path.join("::"));
            self.arrows.faults.push(fault);
        }
        targets
    }

    fn import(&mut self, module: usize, import: &Use) {
        let names = &self.tree.modules[module].scope.names;
        let targets = self.resolved(module, &import.path);
        let has_module = targets.iter().any(|target| matches!(target, Target::Module(_)));
        let used = matches!(&import.binding, Binding::Name(name) if names.contains(name));
        for target in targets {
            match target {
                Target::Module(from) if import.binding == Binding::All => self.glob(module, from),
                Target::Item { module: from, .. } => {
                    // a front door that shows what lies behind it does not use it
                    let shown = import.public && self.tree.within(from, module);
                    if used || !shown && !has_module {
                        self.tie(module, &target);
                    }
                }
                Target::Module(_) | Target::Outside => {}
            }
        }
    }

    /// What the code of `module` names of all that `from` holds.
    fn glob(&mut self, module: usize, from: usize) {
        for name in &self.tree.modules[module].scope.names {
            if self.tree.modules[module].scope.items.contains_key(name) {
                continue;
            }
            for target in look_up(self.tree, from, name) {
                self.tie(module, &target);
            }
        }
    }

    fn tie(&mut self, module: usize, target: &Target) {
        let Target::Item { module: from, name, .. } = target else { return };
        let (here, there) = (&self.tree.modules[module].file, &self.tree.modules[*from].file);
        if here != there {
            self.arrows.ties.entry((here.clone(), there.clone())).or_default().insert(name.clone());
        }
    }
}
