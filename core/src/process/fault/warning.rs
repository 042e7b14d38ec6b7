//! What a caller should know although the program was compensated.

use crate::motion::Unfollowable;

/// What a caller should know although the program was compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum WarningKind {
    /// A stated contact point does not lie on the tool; its offset was carried as it is.
    ContactOffTool,
    /// Nobody says where the cutter touches: the tip stands for the contact.
    ContactUnknown,
    /// The contact is open at an end of a motion: the tip stands for it.
    ContactOpen,
    /// Contacts were assumed from the feed direction.
    ContactAssumed,
    /// A motion at whose ends no contact is known: neither checked nor changed.
    NoContact,
    /// The contact runs across the tool's end within the motion: neither checked nor changed.
    ContactSwings,
    /// A motion that cannot be followed: neither checked nor changed.
    NotFollowed,
    /// A motion under another work offset than the first: neither checked nor changed.
    WorkOffsetChanged,
    /// A rotary axis without an end turns by half a turn or more: neither checked nor changed.
    MayRollOver,
    /// An arc that turns rotary axes: neither checked nor changed.
    ArcWithRotary,
    /// A block over tolerance was not divided, because its parts would run too fast.
    FeedTooHigh,
    /// A block over tolerance was not divided, because its parts would have other contacts than it has.
    ContactUnsettled,
    /// Divided blocks with an exact stop.
    ExactStop,
    /// Divided blocks that are shorter than the control's block time.
    ShortBlocks,
    /// The positions of linear axes were not held against their travel.
    TravelNotChecked,
    /// The text states another unit than the caller.
    UnitDisagrees,
    /// Divided blocks got no F word because the program has no feed.
    NoFeed,
    /// Nothing in the program could be checked.
    NothingChecked,
    /// The seed correction leaves more than the tolerance.
    ToleranceNotReached,
    /// A call or a code whose effect cannot be seen: positions and modes are unknown behind it.
    EffectUnknown,
    /// Blocks behind the program's end.
    TextAfterEnd,
    /// Axis words without a point in a program that writes points elsewhere.
    WordsWithoutPoint,
    /// A stated contact point off the nominal cutter: the nearest point of it was kept.
    NearestContact,
    /// The whole flat of the cutter touches: no shift but for the length.
    FlatContact,
    /// Nearly so: the side follows from the last digits of the normal.
    NearlyFlatContact,
    /// A motion at feed without a contact at its end: moved by the length alone.
    NoContactAtEnd,
    /// A rapid before all five axes are known: left as it is.
    PositionUnknown,
    /// No contact was found in the whole program.
    NoContactKept,
    /// A cut by a tool that neither the request nor the tool table tells: left alone.
    ToolUnknown,
    /// The request states a tool, and each section's own is taken from the table.
    StatedToolUnused,
    /// `CUTTER/` states another cutter.
    CutterDiffers,
    /// A sample of the surface that no motion cuts.
    Uncut,
    /// A cutter that reaches beyond the nominal one.
    LargerCutter,
    /// Posted anew inside the pole cone.
    HeldAtPole,
    /// Posted anew under tool-centre-point control.
    ControlCalibrated,
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
        }
    }

    /// What it means, in a sentence.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::ContactOffTool => {
                "the stated contact point does not lie on the tool; its offset from the tip is carried as it is"
            }
            Self::ContactUnknown => {
                "nothing states where the cutter touches, so the tip stands for the contact. The tip keeps its line, and how the contact moves round the cutter is not corrected. State the contact by U V W words, by normals (columns nx ny nz, or nine values in GOTO), or by the part's surface. contact=feed-plane assumes a contact from the feed"
            }
            Self::ContactOpen => {
                "the contact is open here, and the tip stands for it: the normal lies along the tool axis, the tool plunges, it is fed across its axis, or it pivots about its tip"
            }
            Self::ContactAssumed => {
                "the contacts of these motions are assumed from the feed; give contact points, normals or the part's surface where they are known"
            }
            Self::NoContact => {
                "no contact is known at an end of this motion; it is neither checked nor changed"
            }
            Self::ContactSwings => {
                "the contact swings round the tool's end within this motion, as when the lead changes its sign. It has no line to follow, and the motion is neither checked nor changed"
            }
            Self::NotFollowed => "this motion cannot be followed; it is neither checked nor changed",
            Self::WorkOffsetChanged => {
                "the work offset in force is not known: the program calls one that nobody states, or shifts its zero itself (G92, G52, G10, TRANS, a probing cycle). The motion is neither checked nor changed. State the offset in `work_offsets_mm`, in the request or in the machine's profile; set a shift at the control instead of in the program. The report lists the lines in `resolved.work_offsets`"
            }
            Self::MayRollOver => {
                "a rotary axis without a travel limit turns by half a turn or more in one block. Some controls turn it the other way round, so the motion is neither checked nor changed. State a travel in the machine's profile, or divide the turn"
            }
            Self::ArcWithRotary => "an arc that turns rotary axes cannot be checked; it is left as it is",
            Self::FeedTooHigh => {
                "the block is over the tolerance and was not divided: its parts would need more feed than max_feed_mm_per_min, or more than ten times the programmed feed where max_feed_mm_per_min is not stated. Check the contact there, or state max_feed_mm_per_min"
            }
            Self::ContactUnsettled => {
                "the block is over the tolerance and was not divided: the contacts of its parts, found by the same rule, would differ from its own by more than the tolerance; state contact points or normals, or take a larger tolerance"
            }
            Self::ExactStop => {
                "an exact stop (G60, G61 or G9) is active in a divided block: the machine stops at the end of every part; switch to continuous path (G64) where the surface must not show it"
            }
            Self::ShortBlocks => {
                "parts of divided blocks take less time than block_time_ms of the machine's profile: the control may slow down there; use a larger tolerance or a lower feed"
            }
            Self::TravelNotChecked => {
                "under tool-centre-point control the positions of X Y Z depend on the work offset (and, with a head axis, on the tool length), which is not stated. Their travel was not checked. State work_offset_mm and tool_length_mm"
            }
            Self::UnitDisagrees => {
                "the program states another unit than `unit` or the machine's profile; the unit of the program counts"
            }
            Self::NoFeed => {
                "no feed is known here (none was given, or its value is an expression, or the table has no column F); inserted blocks carry no F word"
            }
            Self::NothingChecked => {
                "no motion could be checked: both rotary axes and X Y Z must be known at both ends of a G1; where the program never names an axis, state by `start` where it stands (as start.A=0)"
            }
            Self::ToleranceNotReached => "the seed correction leaves more than the tolerance",
            Self::EffectUnknown => {
                "a call or a code whose effect cannot be seen; positions and modes are unknown after it until words set them again"
            }
            Self::TextAfterEnd => "blocks after the program's end are copied, neither checked nor changed",
            Self::WordsWithoutPoint => {
                "axis words without a decimal point are read in millimetres or degrees; controls that count least increments read them a thousand times smaller"
            }
            Self::NearestContact => {
                "the stated contact point does not lie on the nominal cutter; the cutter's nearest point was kept"
            }
            Self::FlatContact => {
                "the surface normal lies along the tool axis: the cutter's whole flat touches, and the tip moves by the length alone"
            }
            Self::NearlyFlatContact => {
                "the surface normal is within 0.1° of the tool axis: on which side the cutter touches follows from the last digits"
            }
            Self::NoContactAtEnd => {
                "no contact is known at the end of this motion at feed; its tip moves by the length alone"
            }
            Self::PositionUnknown => {
                "not all five axes are known here; the motion is left as it is; where the program never names an axis, state by `start` where it stands (as start.A=0)"
            }
            Self::Uncut => {
                "no motion cuts these samples: they keep their stock, and no count over the limit includes them. Where the cutter was there, the stock is higher than the cutter covers"
            }
            Self::LargerCutter => {
                "the cutter reaches beyond the nominal one. Motions without a contact of their own keep the shift of the last contact. Approaches and links are not checked for collision: verify the program"
            }
            Self::HeldAtPole => {
                "the tool stands nearly along the rotary axis next to the workpiece: that axis keeps its last correction, the other fits best, the tip stays exact"
            }
            Self::ControlCalibrated => {
                "under tool-centre-point control the control itself has to know the calibrated axes; X Y Z are places of the workpiece, and only rotary words were posted anew"
            }
            Self::ToolUnknown => {
                "the tool that cuts here is not known, while others are known. The motion is left as it is. Put the tool into the machine's tool table (the report names it under resolved.tools)"
            }
            Self::StatedToolUnused => {
                "each section has its tool from the machine's tool table, so the tool of the request is not used. If the request means one tool alone, name it by tool_number"
            }
            Self::CutterDiffers => {
                "CUTTER/ states another cutter than the request or the tool table. The tool of the request counts. A section whose tool is from the table is left as it is: correct CUTTER/ or the table"
            }
            Self::NoContactKept => "no contact was found in the program; tips move by the length alone",
        }
    }
}

/// One warning: how often, first where, and how bad at worst.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// What happened.
    pub kind: WarningKind,
    /// How many motions or points.
    pub count: u64,
    /// First line of the upload.
    pub line: Option<u64>,
    /// Line with the largest distance, where a distance belongs to the warning.
    pub worst_line: Option<u64>,
    /// Largest distance \[mm\], where one belongs to the warning.
    pub max_distance_mm: Option<f64>,
    /// Shortest time \[s\], where one belongs to the warning.
    pub min_time_s: Option<f64>,
    /// Why a motion could not be followed, for the first such line.
    pub reason: Option<Unfollowable>,
}
