//! Laws of contacts that are assumed from the feed, because nothing states them: where no rotary axis turns nothing
//! changes, each pass has its own normal, an open contact stays open, and nothing that rests on the assumption counts
//! as proven.

use std::fmt::Write;

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::machine::{Machine, PRESETS, Preset, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{
    Assumption, CcParameters, ContactSource, ProgramSetup, WarningKind, WearParameters, WornCutter,
};
use trunnion::units::{Angle, Length};

use crate::assume_nothing::{cc, in_mm_alone, warning, wear};
use crate::models::finishing::{
    FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool, wall,
};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::witness::{Tables, scan};

const SOURCES: [ContactSource; 3] = [ContactSource::Auto, ContactSource::FeedPlane, ContactSource::Tip];

/// The tightest tolerance there is: whatever deviates at all is over it.
fn strictest(contact: ContactSource, tool: Tool, program: ProgramSetup) -> CcParameters {
    let tolerance = CcParameters::MIN_TOLERANCE;
    CcParameters { contact, tolerance, ..CcParameters::new(tool, program) }
}

/// Every table, head and mixed machine of the presets, and one whose axes do not meet.
fn machines() -> Vec<Machine> {
    let preset = |preset: &Preset| Machine::new(preset.parts()).expect("a machine");
    PRESETS.iter().map(preset).chain([ac_machine()]).collect()
}

/// The program of the first row of the issue: a plunge and a cut across, the tool upright all along.
const PLUNGE_AND_CUT: &str = "G21 G90 G94 G17
G0 X0.000 Y-2.000 Z5.000 A0.000 C0.000
G1 Z-1.000 F1577
Y-6.000
X12.500 Y-9.000
G0 Z5.000
M30
";

#[test]
fn a_plunge_and_a_corner_with_the_tool_upright_come_back_byte_for_byte() {
    for contact in SOURCES {
        for parameters in [
            CcParameters { contact, ..CcParameters::new(tool(5.0, 5.0), in_mm_alone()) },
            strictest(contact, tool(5.0, 5.0), in_mm_alone()),
        ] {
            let (output, report) = cc(&ac_machine(), &parameters, PLUNGE_AND_CUT).expect("compensated");
            assert_eq!(output, PLUNGE_AND_CUT, "{contact:?}");
            assert_eq!((report.motions_checked, report.motions_over_tolerance), (3, 0), "{contact:?}");
            assert!(report.steps.is_empty() && report.before == report.after, "{report:?}");
        }
    }
}

/// One move of a program of three axes.
#[derive(Debug, Clone, Copy)]
enum Step {
    Rapid([f64; 3]),
    Line([f64; 3]),
    Plunge(f64),
    /// Centre from the start, angle [rad], and how far Z goes on the way: 0 for an arc in its plane.
    Arc([f64; 2], f64, f64),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let place = || prop::array::uniform3(-60.0..60.0_f64);
    let centre = || prop::array::uniform2(-20.0..20.0_f64);
    let step = prop_oneof![
        1 => place().prop_map(Step::Rapid),
        4 => place().prop_map(Step::Line),
        2 => (-60.0..60.0_f64).prop_map(Step::Plunge),
        1 => (centre(), 0.1..6.0_f64).prop_map(|(centre, turn)| Step::Arc(centre, turn, 0.0)),
        1 => (centre(), 0.1..6.0_f64, -9.0..9.0_f64).prop_map(|(c, turn, down)| Step::Arc(c, turn, down)),
    ];
    prop::collection::vec(step, 1..25)
}

/// The program of these moves with both rotary axes where the header puts them, which some blocks say again.
fn three_axes(machine: &Machine, steps: &[Step], rotary_deg: [f64; 2]) -> String {
    let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    let words = |text: &mut String| {
        for (letter, deg) in letters.iter().zip(rotary_deg) {
            write!(text, " {letter}{deg:.3}").expect("text");
        }
    };
    let mut text = String::from("G21 G90 G94 G17\nG0 X0.0000 Y0.0000 Z0.0000");
    words(&mut text);
    text.push_str("\nF1577\n");
    let mut at = [0.0_f64; 3];
    for (k, step) in steps.iter().enumerate() {
        match *step {
            Step::Rapid(to) | Step::Line(to) => at = to,
            Step::Plunge(z) => at[2] = z,
            Step::Arc([i, j], turn, down) => {
                let (sin, cos) = turn.sin_cos();
                at = [at[0] + i - i * cos + j * sin, at[1] + j - i * sin - j * cos, at[2] + down];
            }
        }
        let [x, y, z] = at;
        match step {
            Step::Rapid(_) => write!(text, "G0 X{x:.4} Y{y:.4} Z{z:.4}"),
            Step::Line(_) => write!(text, "G1 X{x:.4} Y{y:.4} Z{z:.4}"),
            Step::Plunge(_) => write!(text, "G1 Z{z:.4}"),
            Step::Arc([i, j], _, down) if *down == 0.0 => write!(text, "G3 X{x:.4} Y{y:.4} I{i:.4} J{j:.4}"),
            Step::Arc([i, j], ..) => write!(text, "G3 X{x:.4} Y{y:.4} Z{z:.4} I{i:.4} J{j:.4}"),
        }
        .expect("text");
        if k % 3 == 1 && !matches!(step, Step::Arc(..)) {
            words(&mut text);
        }
        text.push('\n');
    }
    text.push_str("M30\n");
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

    #[test]
    fn a_path_of_three_axes_comes_back_byte_for_byte_wherever_the_rotary_axes_stand(
        steps in steps(),
        machine in 0..PRESETS.len() + 1,
        rotary_deg in prop::array::uniform2(-50.0..50.0_f64),
        shape in prop::sample::select(vec![(5.0, 5.0), (6.0, 1.5), (8.0, 0.0)]),
    ) {
        let machine = &machines()[machine];
        // Presets have travels: what lies beyond them is another matter.
        let rotary_deg: [f64; 2] = std::array::from_fn(|k| {
            let travel = machine.rotary_axes()[k].travel_deg;
            travel.map_or(rotary_deg[k], |travel| rotary_deg[k].clamp(travel.min, travel.max))
        });
        let text = three_axes(machine, &steps, rotary_deg);
        let tool = tool(shape.0, shape.1);
        for contact in SOURCES {
            let (output, report) = cc(machine, &strictest(contact, tool, in_mm_alone()), &text).expect("compensated");
            prop_assert_eq!(&output, &text);
            prop_assert_eq!(report.motions_over_tolerance, 0);
            prop_assert!(report.steps.is_empty());
            // What is at rest is no motion, and what an arc of rounded words leaves behind is not of this law.
            let lines = steps.iter().filter(|step| matches!(step, Step::Line(_))).count() as u64;
            let is_straight = !steps.iter().any(|step| matches!(step, Step::Arc(..)));
            prop_assert!(!is_straight || report.motions_checked >= lines);
        }
        // A worn cutter of the same length: nothing says where it touches, so nothing moves.
        let worn = WornCutter::Tool(crate::models::finishing::tool(shape.0 * 0.95, shape.1 * 0.95));
        let parameters = WearParameters { contact: ContactSource::FeedPlane, ..WearParameters::new(tool, worn, in_mm_alone()) };
        let (output, report) = wear(machine, &parameters, &text).expect("compensated");
        prop_assert_eq!(&output, &text);
        prop_assert_eq!(report.contacts_assumed, 0);
        let found = report.assumption.expect("an assumption");
        prop_assert_eq!((found.compensated, found.open), (0, 0));
        prop_assert_eq!(found.not_turning, found.cuts);
    }

    #[test]
    fn a_level_feed_across_an_upright_tool_leaves_the_contact_open_and_the_tip_stands_for_it(
        points in prop::collection::vec((prop::array::uniform2(-60.0..60.0_f64), -170.0..170.0_f64), 2..12),
        down in prop::bool::ANY,
    ) {
        // C alone turns: the tool is upright in the part, and feed and axis are square, or one.
        let mut text = String::from("G21 G90 G94 G17\nG43.4 H1\nG0 X0.0000 Y0.0000 Z0.0000 A0.0000 C0.0000\nF900\n");
        for (k, ([x, y], c)) in points.iter().enumerate() {
            if down {
                writeln!(text, "G1 Z{:.4} C{c:.4}", -f64::from(u32::try_from(k).expect("few")) - x.abs() / 100.0).expect("text");
            } else {
                writeln!(text, "G1 X{x:.4} Y{y:.4} C{c:.4}").expect("text");
            }
        }
        for mode in [Interpolation::Tcp, Interpolation::Machine] {
            if down && mode == Interpolation::Machine {
                // On X0 Y0 of the machine the tip turns about A's and C's lines: no plunge in the part.
                continue;
            }
            let program = ProgramSetup { interpolation: Some(mode), ..at_zero() };
            let run = |contact| {
                let parameters = CcParameters { contact, ..CcParameters::new(tool(5.0, 5.0), program.clone()) };
                cc(&ac_machine(), &parameters, &text).expect("compensated")
            };
            let ((by_feed, report), (by_tip, _)) = (run(ContactSource::FeedPlane), run(ContactSource::Tip));
            prop_assert_eq!(by_feed, by_tip);
            let open = warning(&report.warnings, WarningKind::ContactOpen).map_or(0, |open| open.count);
            prop_assert_eq!(open, report.motions_checked);
            prop_assert!(warning(&report.warnings, WarningKind::ContactAssumed).is_none());
            // And for a worn cutter the wall stays where it is, which is said.
            let worn = WornCutter::Tool(tool(4.8, 4.8));
            let parameters = WearParameters { contact: ContactSource::FeedPlane, ..WearParameters::new(tool(5.0, 5.0), worn, program) };
            let (output, report) = wear(&ac_machine(), &parameters, &text).expect("compensated");
            prop_assert_eq!(&output, &text);
            let found = report.assumption.expect("an assumption");
            prop_assert_eq!((found.compensated, found.path_compensated), (0, Length::ZERO));
            prop_assert_eq!(found.open, found.cuts);
            prop_assert!(found.cuts == points.len() as u64 && found.path.mm() > 0.0);
            prop_assert_eq!(report.contacts_assumed, 0);
        }
    }
}

/// The axes of the machine that turns its tables, as the witness has them, the tip programmed in the part.
fn by_tips() -> Tables {
    let machine = ac_machine();
    let [first, second] = machine.rotary_axes();
    Tables {
        first: (first.direction, first.point_mm),
        second: (second.direction, second.point_mm),
        letters: ['A', 'C'],
        offset: Vec3::zeros(),
        corner: 5.0,
        core: 0.0,
        tcp: true,
    }
}

/// Two cuts of 10 mm under tool-centre-point control that turn both axes, the second at this angle to the first. With
/// `pivot_deg` the tool turns by so much on the spot between them.
fn corner(turn_deg: f64, tilt_deg: f64, pivot_deg: Option<f64>) -> String {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let mut text = String::from("G21 G90 G94 G17\nG43.4 H1\n");
    writeln!(text, "G0 X0.00000 Y0.00000 Z0.00000 A{tilt_deg:.5} C10.00000").expect("text");
    let (a, c) = (tilt_deg + 0.2, 10.3);
    writeln!(text, "G1 X10.00000 Z-3.00000 A{a:.5} C{c:.5} F1000").expect("text");
    let (x, y) = (10.0 + 10.0 * cos, 10.0 * sin);
    let (a, c) = pivot_deg.map_or((a, c), |pivot_deg| (a + pivot_deg, c));
    if pivot_deg.is_some() {
        writeln!(text, "A{a:.5}").expect("text");
    }
    let (a, c) = (a + 0.2, c + 0.3);
    writeln!(text, "X{x:.5} Y{y:.5} Z-6.00000 A{a:.5} C{c:.5}\nM30").expect("text");
    text
}

/// The angle between the feeds of both cuts [deg]: both fall by 3 mm on 10.
fn feeds_apart_deg(turn_deg: f64) -> f64 {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let before = Vec3::new(10.0, 0.0, -3.0).normalize();
    let after = Vec3::new(10.0 * cos, 10.0 * sin, -3.0).normalize();
    before.dot(&after).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Half a unit of five decimals on three axes, over the half millimetre that the cutter is worn by.
const NORMAL_OFF: f64 = 1e-5 / 0.5;

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, ..ProptestConfig::default() })]

    #[test]
    fn a_pass_ends_where_the_feed_turns_by_more_than_the_pass_break_and_each_side_has_its_own_normal(
        turn_deg in -90.0..90.0_f64,
        tilt_deg in 5.0..50.0_f64,
        break_deg in 2.0..60.0_f64,
    ) {
        prop_assume!((feeds_apart_deg(turn_deg) - break_deg).abs() > 0.01);
        let text = corner(turn_deg, -tilt_deg, None);
        let parameters = WearParameters {
            contact: ContactSource::FeedPlane,
            pass_break: Angle::from_deg(break_deg),
            ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero())
        };
        let (output, _) = wear(&ac_machine(), &parameters, &text).expect("compensated");
        let (source, written) = (scan(&text, ['A', 'C']), scan(&output, ['A', 'C']));
        prop_assert_eq!(source.len(), written.len());
        let machine = by_tips();
        for k in 0..source.len() {
            let t = machine.forward(source[k].q, source[k].angle).1;
            let chord = |from: usize, to: usize| (source[to].q - source[from].q).normalize();
            let feed = match k {
                2 => chord(1, 2),
                1 if feeds_apart_deg(turn_deg) <= break_deg => chord(0, 2),
                _ => chord(0, 1),
            };
            // A feed across the axis leaves the contact open.
            prop_assume!(t.dot(&feed).abs() > 0.01);
            // n = (t - (t.f) f)/|...|, and a ball of another radius keeps its contact where its tip goes by dR (t - n).
            let normal = (t - feed * t.dot(&feed)).normalize();
            let found = t - (written[k].q - source[k].q) / 0.5;
            prop_assert!((found - normal).norm() < 2.0 * NORMAL_OFF, "point {} {:?} {:?}", k, found, normal);
        }
    }

    #[test]
    fn a_tool_that_turns_on_the_spot_touches_by_its_pass_and_between_two_passes_it_is_open(
        turn_deg in -70.0..70.0_f64,
        tilt_deg in 10.0..40.0_f64,
        break_deg in 2.0..60.0_f64,
    ) {
        prop_assume!((feeds_apart_deg(turn_deg) - break_deg).abs() > 0.01);
        let text = corner(turn_deg, -tilt_deg, Some(-12.0));
        let at = scan(&text, ['A', 'C']);
        let chord = |from: usize, to: usize| (at[to].q - at[from].q).normalize();
        let (before, after) = (chord(0, 1), chord(2, 3));
        let sides = [(0, before), (1, before), (1, before + after), (2, before + after), (2, after), (3, after)];
        let is_closed = |(k, feed): (usize, Vec3)| {
            by_tips().forward(at[k].q, at[k].angle).1.dot(&feed.normalize()).abs() > 0.01
        };
        prop_assume!(sides.into_iter().all(is_closed));
        let parameters = CcParameters {
            contact: ContactSource::FeedPlane,
            pass_break: Angle::from_deg(break_deg),
            ..strictest(ContactSource::FeedPlane, tool(5.0, 5.0), at_zero())
        };
        let parameters = CcParameters { tolerance: Length::from_um(5.0), ..parameters };
        let (_, report) = cc(&ac_machine(), &parameters, &text).expect("compensated");
        let goes_on = feeds_apart_deg(turn_deg) <= break_deg;
        let open = warning(&report.warnings, WarningKind::ContactOpen);
        prop_assert_eq!(open.map(|open| (open.count, open.line)), (!goes_on).then_some((1, Some(5))));
        let assumed = warning(&report.warnings, WarningKind::ContactAssumed).map(|assumed| assumed.count);
        prop_assert_eq!(assumed, Some(if goes_on { 3 } else { 2 }));
    }
}

fn parts() -> [Finishing; 4] {
    let ball = tool(5.0, 5.0);
    [
        blade(ac_machine(), ball, 25, 3),
        impeller_flank(ac_machine(), ball, 30, 3),
        dome_near_pole(ac_machine(), ball, 41, 3),
        wall(ac_machine(), ball, 25, 3),
    ]
}

/// What four decimals leave of an angle of words and of their place, at a contact of the parts [mm].
const ROUNDED_MM: f64 = 2e-4;

#[test]
fn what_rests_on_an_assumed_contact_never_counts_as_kept() {
    let mut largest_mm = 0.0_f64;
    for part in parts() {
        let worn = WornCutter::Tool(tool(4.8, 4.8));
        let with = |contact| WearParameters {
            contact,
            ..WearParameters::new(part.tool, worn.clone(), in_mm(&part.setup))
        };
        let name = part.name;
        let plain = part.program(Form::Plain, FeedForm::PerMinute);
        let (output, report) = wear(&part.machine, &with(ContactSource::FeedPlane), &plain).expect(name);
        let found = report.assumption.unwrap_or_else(|| panic!("{name}"));
        let Assumption { cuts, compensated, open, not_turning, path, path_compensated } = found;
        assert_eq!(cuts, part.points.iter().filter(|point| !point.first_of_pass).count() as u64, "{name}");
        assert_eq!(cuts, compensated + open + not_turning, "{name}: {found:?}");
        assert!(path_compensated <= path && path.mm() > 0.0, "{name}: {found:?}");
        assert_eq!(
            (path_compensated == path, open + not_turning),
            (open + not_turning == 0, cuts - compensated)
        );
        // Contacts where a rapid hands over to a cut are assumed as well.
        assert!(report.contacts_assumed >= compensated && report.contacts_kept == 0, "{name}: {report:?}");
        println!("{name}: {found:?}, {:?} -> {:?}", report.before, report.after_if_assumed);
        assert!(output != plain && compensated > 0, "{name}: {:?}", report.before);
        largest_mm = report.before.max_mm.max(largest_mm);
        assert_eq!(report.after.max_mm.to_bits(), report.before.max_mm.to_bits(), "{name}");
        let if_right = report.after_if_assumed.unwrap_or_else(|| panic!("{name}"));
        assert!(if_right.max_mm <= ROUNDED_MM, "{name}: {if_right:?}");
        // The same part with contacts that the program states: these are kept, and nothing is assumed.
        let stated = part.program(Form::ContactWords, FeedForm::PerMinute);
        let (_, report) = wear(&part.machine, &with(ContactSource::Auto), &stated).expect(name);
        assert!(report.contacts_kept > 0 && report.contacts_assumed == 0, "{name}");
        assert!(report.assumption.is_none() && report.after_if_assumed.is_none(), "{name}");
        assert!(report.after.max_mm <= ROUNDED_MM, "{name}: {:?}", report.after);
    }
    assert!(largest_mm > 1e-3, "{largest_mm}: on every part the rule answers what was there anyway");
}
