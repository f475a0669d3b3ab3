//! One value for each gear.

use crate::control::Gear;
use core::ops::{Index, IndexMut};

/// A value for forward gear and one for reverse, asked for by the gear itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PerGear<T> {
    /// The value for [`Gear::Forward`].
    pub forward: T,
    /// The value for [`Gear::Reverse`].
    pub reverse: T,
}

impl<T> PerGear<T> {
    /// What `value` returns for each gear, forward first.
    pub fn from_fn(mut value: impl FnMut(Gear) -> T) -> Self {
        let forward = value(Gear::Forward);
        Self { forward, reverse: value(Gear::Reverse) }
    }

    /// The same for values that may be missing: forward first, the first error ends it.
    ///
    /// # Errors
    /// What `value` returns.
    pub fn try_from_fn<E>(mut value: impl FnMut(Gear) -> Result<T, E>) -> Result<Self, E> {
        let forward = value(Gear::Forward)?;
        Ok(Self { forward, reverse: value(Gear::Reverse)? })
    }

    /// The values after `change`, forward first.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerGear<U> {
        let forward = change(self.forward);
        PerGear { forward, reverse: change(self.reverse) }
    }

    /// The same value by reference.
    pub fn as_ref(&self) -> PerGear<&T> {
        PerGear { forward: &self.forward, reverse: &self.reverse }
    }

    /// Each gear with its value, forward first.
    pub fn iter(&self) -> impl Iterator<Item = (Gear, &T)> {
        [(Gear::Forward, &self.forward), (Gear::Reverse, &self.reverse)].into_iter()
    }

    /// The values, forward first.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        [&self.forward, &self.reverse].into_iter()
    }
}

impl<T> Index<Gear> for PerGear<T> {
    type Output = T;

    fn index(&self, gear: Gear) -> &T {
        match gear {
            Gear::Forward => &self.forward,
            Gear::Reverse => &self.reverse,
        }
    }
}

impl<T> IndexMut<Gear> for PerGear<T> {
    fn index_mut(&mut self, gear: Gear) -> &mut T {
        match gear {
            Gear::Forward => &mut self.forward,
            Gear::Reverse => &mut self.reverse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gear_has_its_own_value_and_forward_comes_first() {
        let mut asked = Vec::new();
        let mut signs = PerGear::from_fn(|gear| {
            asked.push(gear);
            gear.sign()
        });
        assert_eq!(asked, Gear::ALL);
        assert_eq!((signs[Gear::Forward], signs[Gear::Reverse]), (1.0, -1.0));
        signs[Gear::Reverse] = 5.0;
        assert_eq!(signs.map(|s| 2.0 * s), PerGear { forward: 2.0, reverse: 10.0 });
        assert!(signs.iter().eq([(Gear::Forward, &1.0), (Gear::Reverse, &5.0)]));
    }

    #[test]
    fn the_first_error_ends_it() {
        let only_forward = |gear| if gear == Gear::Forward { Ok(1) } else { Err(gear) };
        assert_eq!(PerGear::try_from_fn(only_forward), Err(Gear::Reverse));
    }
}
