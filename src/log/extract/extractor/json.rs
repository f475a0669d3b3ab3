//! JSON payloads: the text is parsed once; values that are not wanted are skipped without being built.

use crate::log::extract::extractor::index::position;
use crate::log::extract::extractor::json_literals::quoted_literals;
use crate::log::extract::extractor::request_tree::{Element, ElementCheck, Pick, Wish};
use crate::log::extract::extractor::slice::elements;
use crate::log::extract::extractor::taken::Taken;
use crate::log::value::Raw;
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// A compiled walk over a JSON value.
#[derive(Debug, Clone, Default)]
pub(crate) struct JsonProgram {
    take: Vec<usize>,
    /// The wanted values if this value is an object.
    fields: Vec<(String, JsonProgram)>,
    checks: Vec<ElementCheck>,
    /// The wanted values if this value is an array.
    picks: Vec<(Pick, JsonProgram)>,
}

impl JsonProgram {
    pub(crate) fn compile(wish: &Wish) -> Self {
        let (merged, checks) = wish.on_message();
        Self {
            take: wish.take.clone(),
            fields: merged.fields.iter().map(|(name, wish)| (name.clone(), Self::compile(wish))).collect(),
            checks,
            picks: wish.elements.iter().map(|Element { pick, wish }| (pick.clone(), Self::compile(wish))).collect(),
        }
    }

    pub(crate) fn run(&self, payload: &[u8], taken: &mut Taken<'_>) -> Option<()> {
        self.run_strictly(payload, taken).or_else(|| {
            // no JSON has NaN, but many writers do
            let quoted = quoted_literals(payload)?;
            taken.lists.iter_mut().for_each(Vec::clear);
            self.run_strictly(&quoted, taken)
        })
    }

    fn run_strictly(&self, payload: &[u8], taken: &mut Taken<'_>) -> Option<()> {
        let mut parser = serde_json::Deserializer::from_slice(payload);
        Seed { program: self, taken }.deserialize(&mut parser).ok()
    }
}

/// One place of the value, and the wanted values there.
struct Seed<'p, 't, 'a> {
    program: &'p JsonProgram,
    taken: &'t mut Taken<'a>,
}

impl Seed<'_, '_, '_> {
    fn take(&mut self, value: &Raw<'static>) {
        for slot in &self.program.take {
            self.taken.set(*slot, value.clone());
        }
    }
}

impl<'de> DeserializeSeed<'de> for Seed<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Seed<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any JSON value")
    }

    fn visit_bool<E>(mut self, value: bool) -> Result<(), E> {
        self.take(&Raw::Integer(i64::from(value)));
        Ok(())
    }

    fn visit_i64<E>(mut self, value: i64) -> Result<(), E> {
        self.take(&Raw::Integer(value));
        Ok(())
    }

    fn visit_u64<E>(mut self, value: u64) -> Result<(), E> {
        self.take(&Raw::unsigned(value));
        Ok(())
    }

    fn visit_f64<E>(mut self, value: f64) -> Result<(), E> {
        self.take(&Raw::Number(value));
        Ok(())
    }

    fn visit_str<E>(mut self, value: &str) -> Result<(), E> {
        if !self.program.take.is_empty() {
            self.take(&Raw::Text(Cow::Owned(value.to_owned())));
        }
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { program, taken } = self;
        while let Some(field) = map.next_key_seed(Key(program))? {
            match field {
                Some(program) => map.next_value_seed(Seed { program, taken: &mut *taken })?,
                None => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        for check in &program.checks {
            if !taken.get(check.tested).passes(&check.test) {
                taken.clear(&check.slots);
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        let Self { program, taken } = self;
        match &program.picks[..] {
            [] => {
                while sequence.next_element::<IgnoredAny>()?.is_some() {}
                Ok(())
            }
            [(pick, program)] if !pick.counts_from_the_end() => one_pick(pick, program, sequence, taken),
            _ => {
                // several picks, or one counted from the end: rare, so the values may be built
                let mut values: Vec<serde_json::Value> = Vec::new();
                while let Some(value) = sequence.next_element()? {
                    values.push(value);
                }
                for (pick, program) in &program.picks {
                    let pick = match pick {
                        Pick::Index(index) => match position(*index, values.len()) {
                            Some(index) => Pick::Index(index as i64),
                            None => continue,
                        },
                        Pick::Each { first, last, slots } => {
                            let wanted = elements(*first, *last, values.len());
                            if wanted.is_empty() {
                                continue;
                            }
                            Pick::Each { first: wanted.start as i64, last: wanted.end as i64 - 1, slots: slots.clone() }
                        }
                        pick => pick.clone(),
                    };
                    let mut values = serde::de::value::SeqDeserializer::new(values.iter());
                    one_pick(&pick, program, &mut values, taken).map_err(A::Error::custom)?;
                }
                Ok(())
            }
        }
    }
}

/// Fills the slots of one pick from an array.
fn one_pick<'de, A: SeqAccess<'de>>(pick: &Pick, program: &JsonProgram, mut sequence: A, taken: &mut Taken<'_>) -> Result<(), A::Error> {
    let wanted = match pick {
        Pick::Index(index) => u64::try_from(*index).ok(),
        Pick::At { register } => taken.register(*register),
        Pick::First { .. } | Pick::Find { .. } | Pick::Each { .. } => None,
    };
    let mut index = 0;
    let mut done = false;
    loop {
        let more = match pick {
            _ if done => sequence.next_element::<IgnoredAny>()?.is_some(),
            Pick::Find { test, register } => match sequence.next_element::<serde_json::Value>()? {
                Some(value) => {
                    done = match &value {
                        serde_json::Value::String(text) => test.text(text.as_bytes()),
                        serde_json::Value::Bool(value) => test.number(f64::from(u8::from(*value))),
                        value => value.as_f64().is_some_and(|value| test.number(value)),
                    };
                    if done {
                        taken.set(*register, Raw::Integer(index as i64));
                    }
                    true
                }
                None => false,
            },
            Pick::First { test, tested, slots } => {
                let more = sequence.next_element_seed(Seed { program, taken: &mut *taken })?.is_some();
                done = more && taken.get(*tested).passes(test);
                if more && !done {
                    taken.clear(slots);
                }
                more
            }
            Pick::Each { first, last, slots } if index as i64 >= *first && (*last == -1 || index as i64 <= *last) => {
                let more = sequence.next_element_seed(Seed { program, taken: &mut *taken })?.is_some();
                if more {
                    taken.keep(slots);
                }
                more
            }
            Pick::Index(_) | Pick::At { .. } if wanted == Some(index) => {
                done = true;
                sequence.next_element_seed(Seed { program, taken: &mut *taken })?.is_some()
            }
            Pick::Index(_) | Pick::At { .. } | Pick::Each { .. } => sequence.next_element::<IgnoredAny>()?.is_some(),
        };
        if !more {
            return Ok(());
        }
        index += 1;
    }
}

/// Looks a key up among the wanted fields.
struct Key<'p>(&'p JsonProgram);

impl<'p, 'de> DeserializeSeed<'de> for Key<'p> {
    type Value = Option<&'p JsonProgram>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'p> Visitor<'_> for Key<'p> {
    type Value = Option<&'p JsonProgram>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E>(self, key: &str) -> Result<Self::Value, E> {
        Ok(self.0.fields.iter().find(|(name, _)| name == key).map(|(_, program)| program))
    }
}
