//! Laws of scallops and of advice for worn cutters.

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::machine::Tool;
use trunnion::units::{Angle, Length};
use trunnion::wear::{
    Advice, CutterPass, CutterWear, Surface, WearQuestion, advise, end_milling_shift, uncompensated_excess_mm,
};

/// Rounding of heights of micrometres to millimetres (relative).
const ROUNDING: f64 = 1e-9;
/// Rounding of sums of tens of millimetres [mm].
const ROUNDING_MM: f64 = 1e-12;

fn mm(value: f64) -> Length {
    Length::from_mm(value)
}

fn surfaces() -> impl Strategy<Value = Surface> {
    prop_oneof![
        Just(Surface::Flat),
        (1.0..500.0).prop_map(|radius| Surface::Convex { radius: mm(radius) }),
        (11.0..500.0).prop_map(|radius| Surface::Concave { radius: mm(radius) }),
    ]
}

/// A tool of up to 10 mm: radius, and corner radius as a share of it, often all of it.
fn tools() -> impl Strategy<Value = Tool> {
    (1.0..10.0, prop_oneof![2 => Just(1.0), 1 => Just(0.0), 2 => 0.05..0.95])
        .prop_map(|(radius, share): (f64, f64)| Tool::new(mm(radius), mm(radius * share)).expect("a tool"))
}

fn questions() -> impl Strategy<Value = WearQuestion> {
    (
        (tools(), 0.5..1.1, -0.2..0.2),
        (surfaces(), 5.0..80.0, 0.005..0.5),
        (1.0..200.0, 0.0..1.0, 0.0..90.0, 0.0..90.0),
    )
        .prop_map(|((nominal, left, shorter), (surface, lead, share), (allowed, least, one, other))| {
            let scaled = |length: Length| length * left;
            let actual =
                Tool::new(scaled(nominal.radius()), scaled(nominal.corner_radius())).expect("a tool");
            let stepover = nominal.radius() * share;
            WearQuestion {
                wear: CutterWear { nominal, actual, shorter_by: mm(shorter) },
                lead: Angle::from_deg(lead),
                surface,
                stepover,
                allowed: Length::from_um(allowed),
                least_stepover: stepover * least,
                contact_angles: [f64::min(one, other), f64::max(one, other)].map(Angle::from_deg),
            }
        })
}

proptest! {
    #[test]
    fn whoever_follows_the_advice_keeps_the_height_or_changes_the_tool(question in questions()) {
        let found = advise(&question);
        prop_assume!(found.is_ok());
        let found = found.expect("advice");
        let allowed_mm = question.allowed.mm() * (1.0 + ROUNDING);
        let after_mm = found.after.expect("a residual").mm();
        match found.advice {
            Advice::Keep => {
                prop_assert!(found.before.expect("a residual").mm() <= allowed_mm);
                prop_assert!(found.offset[0].mm() >= -ROUNDING);
            }
            Advice::Compensate => prop_assert!(after_mm <= allowed_mm),
            Advice::ReduceStepover => {
                let closer = found.stepover.expect("a step-over");
                prop_assert!(closer < question.stepover && closer >= question.least_stepover);
                let pass = CutterPass { tool: question.wear.actual, lead: question.lead, surface: question.surface };
                prop_assert!(pass.height(closer).expect("a scallop").mm() <= allowed_mm);
                prop_assert!(after_mm <= allowed_mm);
            }
            Advice::ChangeTool => prop_assert!(found.stepover.is_none()),
        }
    }

    #[test]
    fn a_cutter_that_wears_on_never_gets_a_cheaper_advice(question in questions(), more in 0.5..1.0) {
        // Of a ball with its own length in the control: a worn bull-nose may cut better where its core is flatter.
        let nominal = Tool::new(question.wear.nominal.radius(), question.wear.nominal.radius()).expect("a ball");
        let ball = |radius: Length| Tool::new(radius, radius).expect("a ball");
        let worn = nominal.radius() * f64::min(question.wear.actual.radius() / nominal.radius(), 1.0);
        let with = |actual| WearQuestion { wear: CutterWear::new(nominal, actual), ..question };
        let (less, more) = (advise(&with(ball(worn))), advise(&with(ball(worn * more))));
        prop_assume!(less.is_ok() && more.is_ok());
        let (less, more) = (less.expect("advice"), more.expect("advice"));
        prop_assert!(more.advice >= less.advice, "{less:?} {more:?}");
    }

    #[test]
    fn the_offsets_are_those_of_every_contact_between_the_angles(question in questions()) {
        let found = advise(&question);
        prop_assume!(found.is_ok());
        let found = found.expect("advice");
        let [from, to] = question.contact_angles.map(Angle::rad);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..=400_u32 {
            let angle = from + (to - from) * f64::from(k) / 400.0;
            let normal = Vec3::new(angle.sin(), 0.0, angle.cos());
            let left_mm = uncompensated_excess_mm(&question.wear, Vec3::z(), normal).expect("a contact");
            (least, most) = (least.min(left_mm), most.max(left_mm));
        }
        let [told_least, told_most] = found.offset.map(Length::mm);
        prop_assert!(told_least <= least + ROUNDING_MM && told_most >= most - ROUNDING_MM);
        // A sine wave of up to 10 mm between samples of at most 0.23°.
        let missed = 10.0 * 0.004_f64.powi(2) / 8.0;
        prop_assert!(least - told_least <= missed && told_most - most <= missed);
    }

    #[test]
    fn no_wear_is_no_shift(tool in tools(), x in -1.0..1.0, y in -1.0..1.0, z in 0.0..1.0) {
        let normal = Vec3::new(x, y, z);
        prop_assume!(normal.norm() > 0.1);
        let shift = end_milling_shift(&CutterWear::new(tool, tool), Vec3::z(), normal).expect("a shift");
        prop_assert_eq!(shift.shift_mm, Vec3::zeros());
    }

    #[test]
    fn a_wider_step_over_and_a_smaller_tool_leave_more(
        tool in tools(),
        surface in surfaces(),
        lead in 1.0..90.0,
        share in 0.01..1.0,
        wider in 1.001..1.5,
    ) {
        let pass = CutterPass { tool, lead: Angle::from_deg(lead), surface };
        let stepover = tool.radius() * share;
        let (low, high) = (pass.height(stepover), pass.height(stepover * wider));
        prop_assume!(low.is_ok() && high.is_ok());
        let (low, high) = (low.expect("a scallop"), high.expect("a scallop"));
        prop_assert!(high > low);
        let smaller = Tool::new(tool.radius() * 0.99, tool.corner_radius() * 0.99).expect("a tool");
        if let Ok(higher) = (CutterPass { tool: smaller, ..pass }).height(stepover) {
            prop_assert!(higher > low);
        }
    }
}
