//! Setters of options structs with public fields.

/// Declares methods that set a public field and return the options. `with_x(x: T) as Some` sets an
/// optional field to `Some(value)`.
///
/// ```
/// struct Options {
///     seed: u64,
///     cost: Option<u32>,
/// }
///
/// impl Options {
///     tristrip::setters! {
///         /// Sets the seed of the random numbers.
///         with_seed(seed: u64);
///
///         /// Sets a limit for the cost.
///         with_cost(cost: u32) as Some;
///     }
/// }
///
/// let options = Options { seed: 0, cost: None }.with_seed(7).with_cost(3);
/// assert_eq!((options.seed, options.cost), (7, Some(3)));
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! setters {
    ($($(#[$attribute:meta])* $name:ident($field:ident: $type:ty) $(as $wrap:ident)?;)*) => {
        $(
            $(#[$attribute])*
            #[must_use]
            pub fn $name(mut self, $field: $type) -> Self {
                self.$field = $crate::setters!(@value $field $($wrap)?);
                self
            }
        )*
    };
    (@value $value:ident) => { $value };
    (@value $value:ident $wrap:ident) => { $wrap($value) };
}
