//! What the caller should know although the program was compensated.

use crate::motion::Unfollowable;

/// What the caller should know although the program was compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum WarningKind {
    /// A stated contact point does not lie on the tool; its offset was kept.
    ContactOffTool,
    /// The contact is not stated: the tip is used as the contact.
    ContactUnknown,
    /// The contact is not determined at an end of a motion: the tip is used as the contact.
    ContactOpen,
    /// Contacts were assumed from the feed direction.
    ContactAssumed,
    /// No contact is known at the ends of a motion: it is neither checked nor changed.
    NoContact,
    /// The contact runs across the tool's end within the motion: neither checked nor changed.
    ContactSwings,
    /// A motion that cannot be followed: neither checked nor changed.
    NotFollowed,
    /// A motion under a work offset that is not known, or with a shifted zero: neither checked nor changed.
    WorkOffsetChanged,
    /// A rotary axis without a travel limit turns by half a turn or more: neither checked nor changed.
    MayRollOver,
    /// An arc that turns rotary axes: neither checked nor changed.
    ArcWithRotary,
    /// A block over tolerance was not divided, because its parts would need too high a feed.
    FeedTooHigh,
    /// A block over tolerance was not divided, because the contacts of its parts would differ from its
    /// own.
    ContactUnsettled,
    /// Divided blocks with an exact stop.
    ExactStop,
    /// Divided blocks that are shorter than the control's block time.
    ShortBlocks,
    /// The positions of linear axes were not compared with their travel.
    TravelNotChecked,
    /// The program's unit differs from the caller's.
    UnitDisagrees,
    /// Divided blocks got no F word because the program has no feed.
    NoFeed,
    /// Nothing in the program could be checked.
    NothingChecked,
    /// The seed correction leaves more than the tolerance.
    ToleranceNotReached,
    /// A call or a code with an unknown effect: positions and modes are unknown after it.
    EffectUnknown,
    /// Blocks after the program's end.
    TextAfterEnd,
    /// Axis words without a decimal point in a program that writes decimal points elsewhere.
    WordsWithoutPoint,
    /// A stated contact point off the nominal cutter: the cutter's nearest point was used.
    NearestContact,
    /// The whole flat of the cutter touches: the tip moves by the length difference only.
    FlatContact,
    /// The whole flat nearly touches: the contact side depends on the last digits of the normal.
    NearlyFlatContact,
    /// A motion at feed without a contact at its end: it moves by the length difference only.
    NoContactAtEnd,
    /// A rapid before all five axes are known: left unchanged.
    PositionUnknown,
    /// No contact was found in the whole program.
    NoContactKept,
    /// A cut by a tool that neither the request nor the tool table describes: left unchanged.
    ToolUnknown,
    /// The request states a tool, but the table's tool is used for each section.
    StatedToolUnused,
    /// `CUTTER/` states another cutter.
    CutterDiffers,
    /// A sample of the surface that no motion cuts.
    Uncut,
    /// A cutter that reaches beyond the nominal cutter.
    LargerCutter,
    /// Posted again inside the pole cone.
    HeldAtPole,
    /// Posted again under tool-centre-point control.
    ControlCalibrated,
    /// Loops and calls were written out, and assignments were left out.
    WrittenOut,
    /// Files beside the main program that no call reaches.
    FileNotCalled,
}

impl WarningKind {
    /// The name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ContactOffTool | Self::NearestContact => "contact_off_tool",
            Self::ContactUnknown => "contact_unknown",
            Self::ContactOpen => "contact_open",
            Self::ContactAssumed => "contact_assumed",
            Self::NoContact | Self::NoContactAtEnd => "no_contact",
            Self::ContactSwings => "contact_swings",
            Self::NotFollowed => "not_followed",
            Self::WorkOffsetChanged => "work_offset_changed",
            Self::MayRollOver => "may_roll_over",
            Self::ArcWithRotary => "arc_with_rotary",
            Self::FeedTooHigh => "feed_too_high",
            Self::ContactUnsettled => "contact_unsettled",
            Self::ExactStop => "exact_stop",
            Self::ShortBlocks => "short_blocks",
            Self::TravelNotChecked => "travel_not_checked",
            Self::UnitDisagrees => "unit_disagrees",
            Self::NoFeed => "no_feed",
            Self::NothingChecked | Self::NoContactKept => "nothing_checked",
            Self::ToleranceNotReached => "tolerance_not_reached",
            Self::EffectUnknown => "effect_unknown",
            Self::TextAfterEnd => "text_after_end",
            Self::WordsWithoutPoint => "words_without_point",
            Self::FlatContact => "flat_contact",
            Self::NearlyFlatContact => "nearly_flat_contact",
            Self::PositionUnknown => "position_unknown",
            Self::ToolUnknown => "tool_unknown",
            Self::StatedToolUnused => "stated_tool_unused",
            Self::CutterDiffers => "cutter_differs",
            Self::Uncut => "uncut",
            Self::LargerCutter => "larger_cutter",
            Self::HeldAtPole => "pole_hold",
            Self::ControlCalibrated => "control_calibrated",
            Self::WrittenOut => "written_out",
            Self::FileNotCalled => "file_not_called",
        }
    }

    /// The warning in words.
    #[must_use]
    #[expect(clippy::too_many_lines, reason = "one row for each warning")]
    pub const fn text(self) -> &'static str {
        match self {
            Self::ContactOffTool => {
                "the stated contact point does not lie on the tool; its offset from the tip is kept"
            }
            Self::ContactUnknown => {
                "nothing states where the cutter touches, so the tip is used as the contact. The tip keeps its line. The motion of the contact round the cutter is not corrected. State the contact by U V W words, by normals (columns nx ny nz, or nine values in GOTO), or by the part's surface. contact=feed-plane assumes a contact from the feed"
            }
            Self::ContactOpen => {
                "the contact is not determined here, so the tip is used: the normal lies along the tool axis, or the tool plunges, is fed across its axis, or pivots about its tip"
            }
            Self::ContactAssumed => {
                "the contacts of these motions are assumed from the feed; if contact points, normals or the part's surface are known, give them"
            }
            Self::NoContact => {
                "no contact is known at an end of this motion; it is neither checked nor changed"
            }
            Self::ContactSwings => {
                "the contact swings round the tool's end within this motion, for example where the lead changes sign. It has no line to follow. The motion is neither checked nor changed"
            }
            Self::NotFollowed => "this motion cannot be followed; it is neither checked nor changed",
            Self::WorkOffsetChanged => {
                "the work offset in force is not known: the program calls an offset that is not stated, shifts its zero itself (G92, G52, G10, TRANS, a probing cycle), or has a call or an unknown code that may shift it (M98, G65). The motion is neither checked nor changed. State the offset in `work_offsets_mm`, in the request or in the machine's profile. Set a shift at the control instead of in the program. Replace a call by the blocks that it runs, and remove an unknown code that the machine does not need. The report lists the lines in `resolved.work_offsets`"
            }
            Self::MayRollOver => {
                "a rotary axis without a travel limit turns by half a turn or more in one block. Some controls turn it the other way round, so the motion is neither checked nor changed. State a travel in the machine's profile, or divide the turn"
            }
            Self::ArcWithRotary => "an arc that turns rotary axes cannot be checked; it is left unchanged",
            Self::FeedTooHigh => {
                "the block is over the tolerance but was not divided: its parts would need more feed than max_feed_mm_per_min, or more than ten times the programmed feed if max_feed_mm_per_min is not stated. Check the contact there, or state max_feed_mm_per_min"
            }
            Self::ContactUnsettled => {
                "the block is over the tolerance but was not divided: the same rule gives its parts other contacts, which differ by more than the tolerance; state contact points or normals, or take a larger tolerance"
            }
            Self::ExactStop => {
                "an exact stop (G60, G61 or G9) is active in a divided block: the machine stops at the end of every part; if the surface must not show it, switch to continuous path (G64)"
            }
            Self::ShortBlocks => {
                "parts of divided blocks take less time than block_time_ms of the machine's profile: the control may slow down there; use a larger tolerance or a lower feed"
            }
            Self::TravelNotChecked => {
                "under tool-centre-point control the positions of X Y Z depend on the work offset (and, with a head axis, on the tool length), which is not stated. The travel was not checked. State work_offset_mm and tool_length_mm"
            }
            Self::UnitDisagrees => {
                "the unit in the program differs from `unit` or the machine's profile; the program's unit is used"
            }
            Self::NoFeed => {
                "no feed is known here (none was given, or its value is an expression, or the table has no column F); inserted blocks have no F word"
            }
            Self::NothingChecked => {
                "no motion could be checked: both rotary axes and X Y Z must be known at both ends of a G1; if the program never names an axis, state its position in `start` (as start.A=0)"
            }
            Self::ToleranceNotReached => {
                "the deviation is over the tolerance after the seed correction; use the even correction, or take a larger tolerance"
            }
            Self::EffectUnknown => {
                "a call or a code has an unknown effect. After it, positions, modes and the zero are not known, and later motions may be left unchanged to the end of the program. Replace a call by the blocks that it runs, or remove a code that the machine does not need"
            }
            Self::TextAfterEnd => "blocks after the program's end are copied, neither checked nor changed",
            Self::WordsWithoutPoint => {
                "axis words without a decimal point are read in millimetres or degrees; controls that count in least increments read them a thousand times smaller"
            }
            Self::NearestContact => {
                "the stated contact point does not lie on the nominal cutter; the cutter's nearest point was used"
            }
            Self::FlatContact => {
                "the surface normal lies along the tool axis: the cutter's whole flat touches, and the tip moves by the length difference only"
            }
            Self::NearlyFlatContact => {
                "the surface normal is within 0.1° of the tool axis: the side on which the cutter touches depends on the last digits"
            }
            Self::NoContactAtEnd => {
                "no contact is known at the end of this motion at feed; its tip moves by the length difference only"
            }
            Self::PositionUnknown => {
                "not all five axes are known here, so the motion is left unchanged; if the program never names an axis, state its position in `start` (as start.A=0)"
            }
            Self::Uncut => {
                "no motion cuts these samples. They keep their stock, and no count over the limit includes them. If the cutter passed there, the stock is higher than the cutter"
            }
            Self::LargerCutter => {
                "the cutter reaches beyond the nominal one. Motions without a contact of their own keep the shift of the last contact. Approaches and links are not checked for collision: verify the program"
            }
            Self::HeldAtPole => {
                "the tool is nearly parallel to the rotary axis next to the workpiece: that axis keeps its last correction, the other axis gets its best fit, and the tip stays exact"
            }
            Self::ControlCalibrated => {
                "under tool-centre-point control the control itself has to know the calibrated axes; X Y Z are positions on the workpiece, so only rotary words were computed again. The same holds in a tilted plane, which has no rotary words"
            }
            Self::ToolUnknown => {
                "the tool that cuts here is not known, while others are known. The motion is left unchanged. Put the tool into the machine's tool table (the report names it under resolved.tools)"
            }
            Self::StatedToolUnused => {
                "each section takes its tool from the machine's tool table, so the tool of the request is not used. If the request is for one tool only, name it by tool_number"
            }
            Self::CutterDiffers => {
                "the cutter in CUTTER/ differs from the one in the request or the tool table. The tool of the request is used. A section whose tool is from the table is left unchanged: correct CUTTER/ or the table"
            }
            Self::WrittenOut => {
                "loops and calls were written out, and the report counts the lines of the written-out program. The assignments of parameters and variables that are counted here are left out; the line is that of the first one in the program that was sent. A program that reads these parameters later finds their old values"
            }
            Self::FileNotCalled => {
                "no block that runs calls these files, which were sent with the program. Compare their names with the calls, and check which program is the main one"
            }
            Self::NoContactKept => {
                "no contact was found in the program; tips move by the length difference only"
            }
        }
    }
}

/// One warning: its count, its first line and its worst value.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The kind.
    pub kind: WarningKind,
    /// Number of motions or points.
    pub count: u64,
    /// First line of the upload.
    pub line: Option<u64>,
    /// Line with the largest distance, if the warning has a distance.
    pub worst_line: Option<u64>,
    /// Largest distance \[mm\], if the warning has one.
    pub max_distance_mm: Option<f64>,
    /// Shortest time \[s\], if the warning has one.
    pub min_time_s: Option<f64>,
    /// Why a motion could not be followed, for the first such line.
    pub reason: Option<Unfollowable>,
}
