//! The methods by the names that the command gives them.

use tristrip::{FaceTriangulation, Method, Patches, Ties};

const TRIANGULATIONS: [(FaceTriangulation, &str); 3] = [
    (FaceTriangulation::Static, "static"),
    (FaceTriangulation::Whole, "whole"),
    (FaceTriangulation::Partial, "partial"),
];
const TIES: [(Ties, &str); 5] = [
    (Ties::Arbitrary, "arbitrary"),
    (Ties::LookAhead, "look-ahead"),
    (Ties::Alternate, "alternate"),
    (Ties::Random, "random"),
    (Ties::Sequential, "sequential"),
];
const PATCHES: [(Patches, &str); 2] = [(Patches::Rows, "rows"), (Patches::Full, "full")];
const CUTOFFS: [u32; 5] = [5, 10, 15, 20, 25];

/// A method with its name: `stripe-local whole sequential`.
#[derive(Debug, Clone)]
pub struct Named {
    /// As on the command line, options after it; `stripe` is the global algorithm as its authors recommend it.
    pub name: String,
    /// The method.
    pub method: Method,
}

/// STRIPE's local algorithm as it is by default, by its name among the variants.
const LOCAL: (&str, Method) = (
    "stripe-local whole sequential",
    Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Sequential },
);

/// Lists one method for each family.
pub fn main_methods() -> Vec<Named> {
    let named = |name: &str, method| Named { name: name.into(), method };
    vec![
        named("sequential", Method::Sequential),
        named("auto", Method::Auto),
        named("input", Method::Input),
        named("sgi", Method::Sgi),
        named("stripe", Method::STRIPE),
        named(LOCAL.0, LOCAL.1),
    ]
}

/// Lists every method with every option: 4 and the 15 and 10 of STRIPE.
pub fn all_methods() -> Vec<Named> {
    let mut methods = main_methods();
    for (triangulation, when) in TRIANGULATIONS {
        for (ties, rule) in TIES {
            let method = Method::StripeLocal { triangulation, ties };
            if method != LOCAL.1 {
                methods.push(Named { name: format!("stripe-local {when} {rule}"), method });
            }
        }
    }
    for (patches, how) in PATCHES {
        for cutoff in CUTOFFS {
            let method = Method::StripeGlobal { patches, cutoff };
            if method != Method::STRIPE {
                methods.push(Named { name: format!("stripe-global {how} {cutoff}"), method });
            }
        }
    }
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_variant_comes_once() {
        let methods = all_methods();
        assert_eq!(methods.len(), 4 + 15 + 10);
        assert_eq!(methods.iter().map(|m| m.method).collect::<HashSet<_>>().len(), methods.len());
        assert_eq!(methods.iter().map(|m| &m.name).collect::<HashSet<_>>().len(), methods.len());
    }
}
