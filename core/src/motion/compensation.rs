//! Codes of radius compensation, and the modes of the arcs on its path. The path itself follows from the motions.

use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::ToolLength;
use super::radius::Radius;
use super::{RadiusCompensation, RadiusRegister, RadiusRule};
use crate::program::{Address, Code};

/// G2.
const CLOCKWISE: Code = Code::G(20);
/// G90.1 and G91.1.
const ABSOLUTE_CENTRES: Code = Code::G(901);
const INCREMENTAL_CENTRES: Code = Code::G(911);
/// M0 and M1.
const STOPS: [Code; 2] = [Code::M(0), Code::M(10)];
/// G52.
const LOCAL_ZERO: Code = Code::G(520);
/// G39 makes an arc around a corner, and G45 to G48 move by offsets.
const BY_OFFSETS: [Code; 5] = [Code::G(390), Code::G(450), Code::G(460), Code::G(470), Code::G(480)];

impl Interpreter {
    /// G40, G41, G42 and similar codes. Compensation that is on already cannot be switched on by another radius.
    pub(super) fn compensate_radius(&mut self, on: bool, beside_mm: Option<f64>, rule: RadiusRule) {
        if self.options.cutcom_at_centre && self.rules.is_of_points {
            return;
        }
        let is_on = self.modal.compensation != Some(false);
        if on && !is_on {
            self.modal.radius.number = self.modal.radius.number.saturating_add(1);
        }
        if is_on && !on && self.modal.radius.beside_mm.is_none() {
            self.stand_beside();
        }
        self.modal.radius.beside_mm = beside_mm.filter(|_| on && !is_on && self.options.as_it_runs);
        self.modal.radius.rule = rule;
        self.modal.compensation = Some(on);
    }

    /// G41 and G42 by a register: how far left of the path a tool of its radius runs \[mm\]. `None` if the block
    /// names no register, or if its radius is not stated.
    pub(super) fn register_beside_mm(&self, left: bool) -> Option<f64> {
        let offsets = &self.options.radius_offsets.by_register_mm;
        let radius_mm =
            offsets.get(&self.radius_register()?).copied().filter(|_| !self.modal.writes_radii)?;
        Some(if left { radius_mm } else { -radius_mm })
    }

    /// A block after which the path by a radius is not certain any more: it names another register, and controls differ in
    /// the corner from which its radius counts. Or it stops, or shifts all zeros, and controls differ in whether they
    /// look at the motion after it.
    pub(super) fn note_radius_change(&mut self) {
        if self.modal.compensation != Some(true) || self.modal.radius.beside_mm.is_none() {
            return;
        }
        let switches_on = |index| {
            matches!(
                self.meaning(index),
                Meaning::CompensationByRegister { .. } | Meaning::CompensationByDiameter { .. }
            )
        };
        if (0..self.block.g_count).any(switches_on) {
            return;
        }
        let takes_h = || {
            let mut registers = self.options.radius_offsets.by_register_mm.keys();
            registers.any(|register| matches!(register, RadiusRegister::H(_)))
        };
        let names_register = self.block.has(Address::D) || (self.block.has(Address::H) && takes_h());
        let interrupts = self.modal.radius.rule == RadiusRule::Common
            && (self.block.m_codes().iter().any(|code| STOPS.contains(code))
                || self.block.g_codes().contains(&LOCAL_ZERO));
        let moves_by_offsets = self.block.g_codes().iter().any(|code| BY_OFFSETS.contains(code));
        if names_register || interrupts || moves_by_offsets {
            self.modal.radius.beside_mm = None;
        }
    }

    /// As this control runs a path by a register.
    pub(super) fn radius_rule(&self) -> RadiusRule {
        if self.is_rs274 { RadiusRule::Rs274 } else { RadiusRule::Common }
    }

    fn radius_register(&self) -> Option<RadiusRegister> {
        if self.block.has(Address::L) {
            return None;
        }
        match (self.block.has(Address::D), self.block.has(Address::H)) {
            (true, _) => self.number_of(Address::D).map(RadiusRegister::D),
            (false, true) => self.number_of(Address::H).map(RadiusRegister::H),
            (false, false) => None,
        }
    }

    /// Whether H of the block is a register of a radius, as the caller states, and no tool length.
    pub(super) fn names_radius_by_h(&self) -> bool {
        let is_on = |index| matches!(self.meaning(index), Meaning::CompensationByRegister { .. });
        let Some(register @ RadiusRegister::H(_)) = self.radius_register() else { return false };
        self.options.radius_offsets.by_register_mm.contains_key(&register)
            && (0..self.block.g_count).any(is_on)
    }

    /// The tool is beside the programmed place, by a radius that is not known.
    fn stand_beside(&mut self) {
        let across = self.modal.plane.filter(|_| self.modal.tool_length == Some(ToolLength::Plain));
        for slot in (0..3).filter(|slot| across != Some(*slot)) {
            if let Some(at) = self.position.axes.get_mut(usize::from(slot)) {
                *at = None;
            }
        }
    }

    /// How far left of the path a tool runs whose diameter is the D of this block \[mm\]. A negative diameter changes
    /// the side. `None` if D is missing or not known, if the unit may change in this block, and with L, the edge of a
    /// turning tool.
    pub(super) fn diameter_beside_mm(&self, left: bool) -> Option<f64> {
        let changes_unit =
            (0..self.block.g_count).any(|index| matches!(self.meaning(index), Meaning::Units(_)));
        if changes_unit || self.block.has(Address::L) {
            return None;
        }
        let radius_mm = 0.5 * self.block.value(Address::D)? * self.modal.mm_per_unit?;
        Some(if left { radius_mm } else { -radius_mm })
    }

    /// The direction of arcs, by G2 or G3.
    pub(super) fn note_arc(&mut self, index: usize) {
        self.modal.radius.is_clockwise = self.block.g_codes().get(index).map(|code| *code == CLOCKWISE);
    }

    /// The place from which the centres of arcs count.
    pub(super) fn note_centres(&mut self, index: usize) {
        match self.block.g_codes().get(index) {
            Some(&ABSOLUTE_CENTRES) => self.modal.radius.absolute_centres = Some(true),
            Some(&INCREMENTAL_CENTRES) => self.modal.radius.absolute_centres = Some(false),
            _ => {}
        }
    }

    /// The compensation of a motion.
    #[inline]
    pub(super) fn radius_compensation(&self) -> Option<RadiusCompensation> {
        if self.modal.compensation == Some(false) {
            return None;
        }
        let Radius { number, beside_mm, rule, is_clockwise, absolute_centres } = self.modal.radius;
        Some(RadiusCompensation { number, beside_mm, rule, is_clockwise, absolute_centres })
    }

    /// Whether the program has compensated the cutter's radius so far.
    #[must_use]
    pub fn has_compensated_radius(&self) -> bool {
        self.modal.radius.number > 0
    }
}
