//! What the program has assigned so far.

use std::collections::BTreeMap;

/// Parameters from here on are the control's.
const FIRST_SYSTEM: usize = 1000;
/// Local to a subprogram: a call leaves those of the caller as they are.
const LAST_LOCAL: usize = 30;
/// Most names kept; the values of others are not known.
const MAX_NAMES: usize = 1000;
/// Longest name.
const MAX_NAME_BYTES: usize = 64;
/// Nearest to a whole number that a parameter's number must be.
const NEARLY_WHOLE: f64 = 1e-4;

/// Global names that RS274/NGC sets itself, without their underscore.
const SYSTEM_NAMES: &str = "vmajor vminor line motion_mode plane ccomp metric imperial absolute incremental \
    inverse_time units_per_minute units_per_rev coord_system tool_offset retract_r_plane retract_old_z \
    spindle_rpm_mode spindle_css_mode ijk_absolute_mode lathe_diameter_mode lathe_radius_mode spindle_on \
    spindle_cw mist flood speed_override feed_override adaptive_feed feed_hold feed rpm x y z a b c u v w \
    abs_x abs_y abs_z abs_a abs_b abs_c abs_u abs_v abs_w current_tool current_pocket selected_tool \
    selected_pocket value value_returned task call_level remap_level";

/// A name without blanks, in lower case.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Name(Box<[u8]>);

impl Name {
    /// The name between `<` and `>`; `None` where it is too long to be kept.
    pub(super) fn new(written: &[u8]) -> Option<Self> {
        let name: Vec<u8> =
            written.iter().filter(|byte| !matches!(byte, b' ' | b'\t')).map(u8::to_ascii_lowercase).collect();
        (name.len() <= MAX_NAME_BYTES).then(|| Self(name.into()))
    }

    fn is_global(&self) -> bool {
        self.0.starts_with(b"_")
    }

    /// Set by the control: `#<_x>`, `#<_hal[…]>`, `#<_ini[…]>`.
    fn is_system(&self) -> bool {
        self.0.split_first().is_some_and(|(first, rest)| {
            *first == b'_'
                && (rest.contains(&b'[') || SYSTEM_NAMES.split(' ').any(|name| name.as_bytes() == rest))
        })
    }
}

/// Which parameter a text means.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Target {
    /// 1 to 999.
    Numbered(usize),
    /// By name.
    Named(Name),
    /// One of the control's own, or no number of a parameter at all.
    Beyond(f64),
    /// One of the control's own, by name.
    System,
    /// Which one is not known.
    Unseen,
}

impl Target {
    pub(super) fn of_number(number: f64) -> Self {
        let whole = number.round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        if (1.0..FIRST_SYSTEM as f64).contains(&whole) && (number - whole).abs() < NEARLY_WHOLE {
            Self::Numbered(whole as usize)
        } else if (number - whole).abs() < NEARLY_WHOLE {
            Self::Beyond(whole)
        } else {
            // Some controls cut, some round, some stop.
            Self::Unseen
        }
    }
}

/// What is known of a named parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Named {
    /// Whether it has been set for certain.
    is_certain: bool,
    value: Option<f64>,
}

/// What the program has assigned so far.
#[derive(Debug, Clone)]
pub(in crate::program) struct Parameters {
    /// By number; empty until one is set.
    numbered: Vec<Option<f64>>,
    named: BTreeMap<Name, Named>,
    /// Names may be missing from `named` that were set.
    names_lost: bool,
    /// The program has shown itself to be one for RS274/NGC.
    pub(super) is_rs274: bool,
    /// G66: something is called at every motion.
    pub(super) modal_call: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        let named = BTreeMap::new();
        Self { numbered: Vec::new(), named, names_lost: false, is_rs274: false, modal_call: false }
    }
}

impl Parameters {
    /// The value of a parameter, where it is known.
    pub(super) fn value(&self, target: &Target) -> Option<f64> {
        match target {
            Target::Numbered(number) => self.numbered.get(*number).copied().flatten(),
            Target::Named(name) => self.named.get(name)?.value,
            Target::Beyond(_) | Target::System | Target::Unseen => None,
        }
    }

    /// Whether a name has been set.
    pub(super) fn exists(&self, name: &Name) -> Option<bool> {
        match self.named.get(name) {
            Some(named) => named.is_certain.then_some(true),
            // A global name may have been set by a program before this one.
            None => (!name.is_global() && !self.names_lost).then_some(false),
        }
    }

    /// Sets a parameter; `applies` is `None` where it is not known whether it is set at all.
    pub(super) fn set(&mut self, target: Target, value: Option<f64>, applies: Option<bool>) {
        if applies == Some(false) {
            return;
        }
        let is_certain = applies == Some(true);
        match target {
            Target::Numbered(number) => {
                if self.numbered.is_empty() {
                    self.numbered.resize(FIRST_SYSTEM, None);
                }
                if let Some(slot) = self.numbered.get_mut(number) {
                    *slot = value.filter(|_| is_certain || *slot == value);
                }
            }
            Target::Named(name) if name.is_system() => {}
            Target::Named(name) => {
                if let Some(named) = self.named.get_mut(&name) {
                    named.value = value.filter(|_| is_certain || named.value == value);
                    named.is_certain |= is_certain;
                } else if self.named.len() < MAX_NAMES {
                    let value = value.filter(|_| is_certain);
                    self.named.insert(name, Named { is_certain, value });
                } else {
                    self.names_lost = true;
                }
            }
            Target::Beyond(_) | Target::System => {}
            Target::Unseen => {
                self.numbered.clear();
                self.named.values_mut().for_each(|named| named.value = None);
                self.names_lost = true;
            }
        }
    }

    /// Whether nothing can be forgotten.
    pub(super) fn is_empty(&self) -> bool {
        self.numbered.is_empty() && self.named.is_empty()
    }

    /// Behind a call whose subprogram has parameters of its own up to #30 and, with `own_names`, names of its own.
    pub(super) fn forget_global(&mut self, own_names: bool) {
        self.numbered.iter_mut().skip(LAST_LOCAL + 1).for_each(|value| *value = None);
        for (name, named) in &mut self.named {
            if name.is_global() || !own_names {
                named.value = None;
            }
        }
        self.names_lost |= !own_names;
    }

    /// Behind a call whose subprogram uses the caller's parameters.
    pub(super) fn forget_all(&mut self) {
        self.numbered.clear();
        self.named.values_mut().for_each(|named| named.value = None);
        self.names_lost = true;
    }
}
