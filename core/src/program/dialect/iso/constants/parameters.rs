//! The values that the program has assigned so far.

use std::collections::BTreeMap;

/// From this number on, parameters belong to the control.
const FIRST_SYSTEM: usize = 1000;
/// Parameters up to this number are local to a subprogram. A call leaves those of the caller unchanged.
const LAST_LOCAL: usize = 30;
/// The most names that are kept. The values of other names are not known.
const MAX_NAMES: usize = 1000;
/// The longest name.
const MAX_NAME_BYTES: usize = 64;
/// The largest distance of a parameter's number from a whole number.
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
    /// The name between `<` and `>`; `None` if it is too long to be kept.
    pub(super) fn new(written: &[u8]) -> Option<Self> {
        let name: Vec<u8> =
            written.iter().filter(|byte| !matches!(byte, b' ' | b'\t')).map(u8::to_ascii_lowercase).collect();
        (name.len() <= MAX_NAME_BYTES).then(|| Self(name.into()))
    }

    fn is_global(&self) -> bool {
        self.0.starts_with(b"_")
    }

    /// The control sets it: `#<_x>`, `#<_hal[…]>`, `#<_ini[…]>`.
    fn is_system(&self) -> bool {
        self.0.split_first().is_some_and(|(first, rest)| {
            *first == b'_'
                && (rest.contains(&b'[') || SYSTEM_NAMES.split(' ').any(|name| name.as_bytes() == rest))
        })
    }
}

/// The parameter that a text means.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Target {
    /// A number from 1 to 999.
    Numbered(usize),
    /// A name.
    Named(Name),
    /// A parameter of the control, or not the number of a parameter at all.
    Beyond(f64),
    /// A parameter of the control, by name.
    System,
    /// It is not known which parameter.
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
            // Some controls cut the number, some round it, some stop.
            Self::Unseen
        }
    }
}

/// The state of a named parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Named {
    /// Whether it is certain that the parameter has been set.
    is_certain: bool,
    value: Option<f64>,
}

/// The values that the program has assigned so far.
#[derive(Debug, Clone)]
pub(in crate::program) struct Parameters {
    /// Values by number; empty until one is set.
    numbered: Vec<Option<f64>>,
    named: BTreeMap<Name, Named>,
    /// `named` may lack names that were set.
    names_lost: bool,
    /// The text has shown that the program is for RS274/NGC.
    pub(super) is_rs274: bool,
    /// G66: the program calls something at every motion.
    pub(super) modal_call: bool,
    /// The parameters of the callers of the present subprogram.
    callers: Vec<Locals>,
}

/// The parameters that belong to one level of calls.
#[derive(Debug, Clone)]
struct Locals {
    numbered: Vec<Option<f64>>,
    named: BTreeMap<Name, Named>,
    names_lost: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        let named = BTreeMap::new();
        let callers = Vec::new();
        Self { numbered: Vec::new(), named, names_lost: false, is_rs274: false, modal_call: false, callers }
    }
}

impl Parameters {
    /// The value of a parameter, if it is known.
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
            // A program before this one may have set a global name.
            None => (!name.is_global() && !self.names_lost).then_some(false),
        }
    }

    /// Sets a parameter; `applies` is `None` if it is not known whether the assignment takes place.
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

    /// Whether there is nothing to forget.
    pub(super) fn is_empty(&self) -> bool {
        self.numbered.is_empty() && self.named.is_empty()
    }

    /// After a call whose subprogram has its own parameters up to #30 and, with `own_names`, its own names.
    pub(super) fn forget_global(&mut self, own_names: bool) {
        self.numbered.iter_mut().skip(LAST_LOCAL + 1).for_each(|value| *value = None);
        for (name, named) in &mut self.named {
            if name.is_global() || !own_names {
                named.value = None;
            }
        }
        self.names_lost |= !own_names;
    }

    /// After a call whose subprogram uses the caller's parameters.
    pub(super) fn forget_all(&mut self) {
        self.numbered.clear();
        self.named.values_mut().for_each(|named| named.value = None);
        self.names_lost = true;
    }

    /// A subprogram of RS274/NGC begins. Its parameters up to #30 are the arguments, and 0 after them. Its names that
    /// do not begin with an underscore are its own.
    pub(in crate::program) fn enter(&mut self, arguments: &[Option<f64>]) {
        self.is_rs274 = true;
        if self.numbered.is_empty() {
            self.numbered.resize(FIRST_SYSTEM, None);
        }
        let mut locals = Locals { numbered: Vec::new(), named: BTreeMap::new(), names_lost: self.names_lost };
        for (slot, value) in self.numbered.iter_mut().skip(1).take(LAST_LOCAL).enumerate() {
            locals.numbered.push(*value);
            *value = arguments.get(slot).copied().unwrap_or(Some(0.0));
        }
        let (global, local) =
            std::mem::take(&mut self.named).into_iter().partition(|(name, _)| name.is_global());
        (self.named, locals.named) = (global, local);
        self.names_lost = false;
        self.callers.push(locals);
    }

    /// It ends. The parameters of its caller hold again.
    pub(in crate::program) fn leave(&mut self) {
        let Some(locals) = self.callers.pop() else { return };
        self.numbered.resize(FIRST_SYSTEM, None);
        for (value, before) in self.numbered.iter_mut().skip(1).zip(locals.numbered) {
            *value = before;
        }
        self.named.retain(|name, _| name.is_global());
        self.named.extend(locals.named);
        self.names_lost |= locals.names_lost;
    }
}
