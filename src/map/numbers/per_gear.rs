//! One value for each gear.

use crate::control::Gear;
use core::ops::{Index, IndexMut};

/// A value for forward gear and one for reverse, looked up by gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct PerGear<T> {
    /// The value for [`Gear::Forward`].
    pub forward: T,
    /// The value for [`Gear::Reverse`].
    pub reverse: T,
}

impl<T> PerGear<T> {
    /// The result of `value` for each gear, forward first.
    pub(crate) fn from_fn(mut value: impl FnMut(Gear) -> T) -> Self {
        let forward = value(Gear::Forward);
        Self { forward, reverse: value(Gear::Reverse) }
    }

    /// The same for values that may be missing: forward first; it ends at the first error.
    ///
    /// # Errors
    /// The errors of `value`.
    pub(crate) fn try_from_fn<E>(mut value: impl FnMut(Gear) -> Result<T, E>) -> Result<Self, E> {
        let forward = value(Gear::Forward)?;
        Ok(Self { forward, reverse: value(Gear::Reverse)? })
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
        assert_eq!(signs, PerGear { forward: 1.0, reverse: 5.0 });
    }

    #[test]
    fn the_first_error_ends_it() {
        let only_forward = |gear| if gear == Gear::Forward { Ok(1) } else { Err(gear) };
        assert_eq!(PerGear::try_from_fn(only_forward), Err(Gear::Reverse));
    }
}
