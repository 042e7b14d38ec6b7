//! Enums that list their own variants.

/// Declares an enum with `ALL`, the list of its variants in order. A new variant cannot be missing from the list.
macro_rules! listed {
    (
        $(#[$attribute:meta])*
        $visible:vis enum $name:ident { $($(#[$of_variant:meta])* $variant:ident,)* }
    ) => {
        $(#[$attribute])*
        $visible enum $name {
            $($(#[$of_variant])* $variant,)*
        }

        impl $name {
            /// All of them, in order.
            pub const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];
        }
    };
}

pub(crate) use listed;
