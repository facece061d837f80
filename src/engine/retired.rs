//! Refuses fidelity levels that older files and command lines name, with a message that names their replacements.

use serde::de::{Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, Visitor};

/// The message for a config or command line that names the level `Functional`.
pub(crate) const FUNCTIONAL: &str = "the level Functional is gone: Event is exact for about the same time, \
     Profile is faster; use Event or Profile";

/// Wraps a deserializer of an enum of levels, its visitor or its enum access, and refuses `Functional`.
pub(crate) struct WithoutRetired<T>(pub T);

impl<'de, D: Deserializer<'de>> Deserializer<'de> for WithoutRetired<D> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_enum(name, variants, WithoutRetired(visitor))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

impl<'de, V: Visitor<'de>> Visitor<'de> for WithoutRetired<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.expecting(f)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<V::Value, A::Error> {
        self.0.visit_enum(WithoutRetired(access))
    }
}

impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for WithoutRetired<A> {
    type Error = A::Error;
    type Variant = A::Variant;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, A::Variant), A::Error> {
        let (Name(name), variant) = self.0.variant::<Name>()?;
        if name == "Functional" {
            return Err(A::Error::custom(FUNCTIONAL));
        }
        Ok((seed.deserialize(name.into_deserializer())?, variant))
    }
}

/// The name of a variant.
struct Name(String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct NameVisitor;

        impl Visitor<'_> for NameVisitor {
            type Value = Name;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a level")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Name, E> {
                Ok(Name(name.to_owned()))
            }
        }

        from.deserialize_identifier(NameVisitor)
    }
}
