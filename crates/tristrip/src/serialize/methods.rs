//! Methods as text: the name, then the parameters that differ from the defaults.

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};

use crate::stripify::{Method, TunnelOptions};

/// Returns the parameters of a method, named like the flags.
fn parameters(method: Method) -> Vec<(&'static str, String)> {
    match method {
        Method::StripeLocal { triangulation, ties } => {
            vec![("triangulation", triangulation.to_string()), ("ties", ties.to_string())]
        }
        Method::StripeGlobal { patches, cutoff, ties } => {
            vec![("patches", patches.to_string()), ("cutoff", cutoff.to_string()), ("ties", ties.to_string())]
        }
        Method::QuadRows { cutoff } => vec![("cutoff", cutoff.to_string())],
        Method::Sgi { last_tie } => vec![("last-tie", last_tie.to_string())],
        Method::Tunnel { length } => vec![("length", length.to_string())],
        Method::Eta { tunnels, acceptance, localization } => {
            let [acceptance, localization] = [acceptance.to_string(), localization.to_string()];
            let own = [("acceptance", acceptance), ("localization", localization)];
            tunnel_parameters(tunnels).into_iter().chain(own).collect()
        }
        Method::GuidedTunnels(tunnels) => tunnel_parameters(tunnels).into(),
        _ => Vec::new(),
    }
}

fn tunnel_parameters(tunnels: TunnelOptions) -> [(&'static str, String); 3] {
    [
        ("length", tunnels.length.to_string()),
        ("threshold", tunnels.threshold.to_string()),
        ("start", tunnels.start.to_string()),
    ]
}

/// Returns a method with another value of a parameter, or `None` if the parameter or the value does
/// not exist.
fn with_parameter(method: Method, name: &str, value: &str) -> Option<Method> {
    Some(match (method, name) {
        (Method::StripeLocal { ties, .. }, "triangulation") => {
            Method::StripeLocal { triangulation: value.parse().ok()?, ties }
        }
        (Method::StripeLocal { triangulation, .. }, "ties") => {
            Method::StripeLocal { triangulation, ties: value.parse().ok()? }
        }
        (Method::StripeGlobal { cutoff, ties, .. }, "patches") => {
            Method::StripeGlobal { patches: value.parse().ok()?, cutoff, ties }
        }
        (Method::StripeGlobal { patches, ties, .. }, "cutoff") => {
            Method::StripeGlobal { patches, cutoff: value.parse().ok()?, ties }
        }
        (Method::StripeGlobal { patches, cutoff, .. }, "ties") => {
            Method::StripeGlobal { patches, cutoff, ties: value.parse().ok()? }
        }
        (Method::QuadRows { .. }, "cutoff") => Method::QuadRows { cutoff: value.parse().ok()? },
        (Method::Sgi { .. }, "last-tie") => Method::Sgi { last_tie: value.parse().ok()? },
        (Method::Tunnel { .. }, "length") => Method::Tunnel { length: value.parse().ok()? },
        (Method::Eta { tunnels, localization, .. }, "acceptance") => {
            Method::Eta { tunnels, acceptance: value.parse().ok()?, localization }
        }
        (Method::Eta { tunnels, acceptance, .. }, "localization") => {
            Method::Eta { tunnels, acceptance, localization: value.parse().ok()? }
        }
        (Method::Eta { tunnels, acceptance, localization }, _) => {
            Method::Eta { tunnels: tunnels_with(tunnels, name, value)?, acceptance, localization }
        }
        (Method::GuidedTunnels(tunnels), _) => Method::GuidedTunnels(tunnels_with(tunnels, name, value)?),
        _ => return None,
    })
}

fn tunnels_with(tunnels: TunnelOptions, name: &str, value: &str) -> Option<TunnelOptions> {
    match name {
        "length" => Some(tunnels.with_length(value.parse().ok()?)),
        "threshold" => Some(tunnels.with_threshold(value.parse().ok()?)),
        "start" => Some(tunnels.with_start(value.parse().ok()?)),
        _ => None,
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut text = self.name().to_owned();
        let usual: Method = text.parse().map_err(S::Error::custom)?;
        for ((name, value), (_, usual)) in parameters(*self).into_iter().zip(parameters(usual)) {
            if value != usual {
                text = format!("{text} {name}={value}");
            }
        }
        to.serialize_str(&text)
    }
}

impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = <std::borrow::Cow<'de, str>>::deserialize(from)?;
        let mut words = text.split(' ');
        let method = words.next().unwrap_or_default().parse().map_err(D::Error::custom)?;
        words.try_fold(method, |method, word| {
            let parameter =
                word.split_once('=').and_then(|(name, value)| with_parameter(method, name, value));
            parameter
                .ok_or_else(|| D::Error::custom(format!("found `{word}`, expected a parameter of {method}")))
        })
    }
}
