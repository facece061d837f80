//! Counters, each declared once by name, unit and meaning.
//!
//! [`counters!`] makes the struct, its documentation, sum and difference from a declaration. Reports, tables,
//! `explain` and the stream's file read [`Counter`]s from it. A new counter takes one line in its declaration and one
//! that counts.

/// The description of a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counter {
    /// Its name, both of the struct's field and in files.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it counts.
    pub about: &'static str,
}

/// Whether two names are equal; usable in constants, unlike `==`.
pub(crate) const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let (mut at, mut same) = (0, a.len() == b.len());
    while same && at < a.len() {
        same = a[at] == b[at];
        at += 1;
    }
    same
}

/// Declares a struct of `u64` counters: `counters! { pub struct Counts { hits: "accesses", "the line was there"; } }`.
///
/// The fields of `peaks { ... }` after the struct are maxima: a sum takes the larger one, a difference takes the later
/// one.
macro_rules! counters {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $($field:ident: $unit:literal, $about:literal;)+
        }
        $(peaks { $($peak:ident: $peak_unit:literal, $peak_about:literal;)+ })?
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        $visibility struct $name {
            $(#[doc = concat!("In ", $unit, ": ", $about, ".")] pub $field: u64,)+
            $($(#[doc = concat!("In ", $peak_unit, ": ", $peak_about, ".")] pub $peak: u64,)+)?
        }

        #[allow(dead_code, reason = "not every group of counters is read by all that a declaration offers")]
        impl $name {
            /// The counters, in the order of their declaration.
            pub(crate) const DECLARED: &'static [$crate::counters::Counter] = &[
                $($crate::counters::Counter { name: stringify!($field), unit: $unit, about: $about },)+
                $($($crate::counters::Counter {
                    name: stringify!($peak), unit: $peak_unit, about: $peak_about,
                },)+)?
            ];

            /// The number of summed counters: maxima come after them.
            pub(crate) const SUMMED: usize = [$(stringify!($field)),+].len();

            /// The index of the counter `name`. An unknown name is a compile error if this is evaluated in a constant.
            pub(crate) const fn place(name: &str) -> usize {
                let mut place = 0;
                while !$crate::counters::is_same(Self::DECLARED[place].name, name) {
                    place += 1;
                }
                place
            }

            /// The values, in the order of [`Self::DECLARED`].
            pub(crate) fn values(&self) -> [u64; Self::DECLARED.len()] {
                [$(self.$field,)+ $($(self.$peak,)+)?]
            }

            /// The counters with these values, in the order of [`Self::DECLARED`].
            pub(crate) fn from_values([$($field,)+ $($($peak,)+)?]: [u64; Self::DECLARED.len()]) -> Self {
                Self { $($field,)+ $($($peak,)+)? }
            }
        }

        impl std::ops::AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)+
                $($(self.$peak = self.$peak.max(other.$peak);)+)?
            }
        }

        impl std::ops::Sub for $name {
            type Output = Self;

            fn sub(self, earlier: Self) -> Self {
                Self { $($field: self.$field - earlier.$field,)+ $($($peak: self.$peak,)+)? }
            }
        }

        impl std::iter::Sum for $name {
            fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
                let mut sum = Self::default();
                all.for_each(|one| sum += one);
                sum
            }
        }
    };
}
pub(crate) use counters;

#[cfg(test)]
mod tests {
    counters! {
        /// Two counters and a peak.
        struct Counts {
            hits: "accesses", "the line was there";
            misses: "accesses", "the line was fetched";
        }
        peaks {
            longest: "cycles", "the longest wait";
        }
    }

    #[test]
    fn a_declaration_gives_names_sum_and_difference() {
        let names: Vec<_> = Counts::DECLARED.iter().map(|counter| (counter.name, counter.unit)).collect();
        assert_eq!(names, [("hits", "accesses"), ("misses", "accesses"), ("longest", "cycles")]);
        let [early, late] = [[1, 2, 9], [5, 7, 3]].map(Counts::from_values);
        assert_eq!([early, late].into_iter().sum::<Counts>().values(), [6, 9, 9]);
        assert_eq!((late - early).values(), [4, 5, 3]);
        const MISSES: usize = Counts::place("misses");
        assert_eq!((MISSES, Counts::SUMMED), (1, 2));
        assert_eq!(serde_json::to_string(&early).unwrap(), r#"{"hits":1,"misses":2,"longest":9}"#);
    }
}
