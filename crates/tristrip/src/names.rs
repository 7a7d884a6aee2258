//! Names of enumeration values: one table defines the name and one-line help of each value,
//! `Display` and `FromStr`.

/// Gives the values of an enumeration the names used on the command line and in JSON. The first
/// argument is the path used in the documentation examples.
macro_rules! names {
    ($path:literal, $type:ident, $what:literal, $($value:ident => $name:literal, $summary:literal);+ $(;)?) => {
        impl $type {
            /// All values.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$value),+];

            /// Returns the name of the value, as used by the command line and JSON.
            ///
            /// ```
            #[doc = concat!("use ", $path, ";")]
            #[doc = concat!("let names: Vec<&str> = ", stringify!($type), "::ALL.iter().map(|value| value.name()).collect();")]
            #[doc = concat!("assert_eq!(names, [", $("\"", $name, "\", ",)+ "]);")]
            #[doc = concat!("assert_eq!(names[0].parse::<", stringify!($type), ">()?, ", stringify!($type), "::ALL[0]);")]
            /// # Ok::<(), tristrip::Error>(())
            /// ```
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name),+
                }
            }

            /// Returns the one-line summary of the value, as shown in the command's help.
            ///
            /// ```
            #[doc = concat!("use ", $path, ";")]
            #[doc = concat!("let lines: Vec<&str> = ", stringify!($type), "::ALL.iter().map(|value| value.summary()).collect();")]
            #[doc = concat!("assert_eq!(lines, [", $("\"", $summary, "\", ",)+ "]);")]
            /// ```
            pub const fn summary(self) -> &'static str {
                match self {
                    $(Self::$value => $summary),+
                }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::error::Error;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                let value = Self::ALL.into_iter().find(|value| value.name() == name);
                value.ok_or_else(|| $crate::error::Error::Parameter {
                    name: $what,
                    found: format!("`{name}`"),
                    expected: $crate::names::one_of!($($name)+),
                })
            }
        }
    };
}

/// Lists names for error messages: `one of: a, b, c`.
macro_rules! one_of {
    ($first:literal $($name:literal)*) => {
        concat!("one of: ", $first $(, ", ", $name)*)
    };
}
pub(crate) use {names, one_of};
