//! Programs that are changed in tilted planes: they are changed as the same motions under tool-centre-point control,
//! seen by an independent witness with rotation matrices and a sphere.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

use trunnion::contact::PartSurface;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, PRESETS, PlaneRule, PlaneSolution, Preset, RotaryLetter};
use trunnion::motion::{Interpolation, Unfollowable};
use trunnion::process::{
    CcParameters, CcReport, CcStep, CompensationParameters, ContactSource, Fault, LengthInControl, LineFault,
    LineFaultKind, NotModelledKind, ProgramSetup, WarningKind, WearParameters, WearStep, WornCutter,
    compensate, compensate_wear,
};
use trunnion::program::Dialect;
use trunnion::surface::{Bulge, Mesh, Sphere};
use trunnion::units::Length;

use super::one_pass::{angle, done};
use crate::models::displaced::{displaced, errors, with_errors};
use crate::models::finishing::tool;
use crate::models::set_ups::in_mm;
use crate::models::tessellation::facets;
use crate::models::witness::Tables;

type V = Vector3<f64>;

/// Half a unit of five decimals on three axes [mm].
const HALF_MM: f64 = 0.866_025_404e-5;
/// Source and output are rounded, in the plane and in the workpiece [mm].
const ROUNDED_MM: f64 = 4.0 * HALF_MM;
/// What the facets of the sphere leave of its normals, at a radius of 5 mm [mm].
const FACETS_MM: f64 = 2e-5;
const TOLERANCE_MM: f64 = 0.01;
const SPHERE_MM: f64 = 30.0;
const BALL_MM: f64 = 5.0;
const DIALECTS: [Dialect; 3] = [Dialect::Iso, Dialect::Siemens, Dialect::Heidenhain];

/// A plane: turned about Z by the first angle, then about the turned X by the second one [deg].
#[derive(Debug, Clone, Copy)]
struct Plane {
    zero_mm: V,
    turns_deg: [f64; 2],
}

impl Plane {
    fn turn(&self) -> Rotation3<f64> {
        let [about_z, about_x] = self.turns_deg.map(f64::to_radians);
        Rotation3::from_axis_angle(&V::z_axis(), about_z) * Rotation3::from_axis_angle(&V::x_axis(), about_x)
    }

    fn normal(&self) -> V {
        self.turn() * V::z()
    }

    fn words(&self, place_mm: V) -> V {
        self.turn().inverse() * (place_mm - self.zero_mm)
    }

    fn place(&self, words_mm: V) -> V {
        self.zero_mm + self.turn() * words_mm
    }

    /// The zero of a `PLANE SPATIAL` is that of the workpiece.
    fn of(self, dialect: Dialect) -> Self {
        if dialect == Dialect::Heidenhain { Self { zero_mm: V::zeros(), ..self } } else { self }
    }
}

fn machine(id: &str, axis: RotaryLetter) -> Machine {
    let rule = PlaneSolution { rule: PlaneRule::PositiveFirst, axis: Some(axis) };
    Machine::new(Preset::by_id(id).unwrap().parts()).unwrap().with_plane_solution(Some(rule))
}

/// The control takes the position with a positive A: A and C are then the angles of the plane.
fn tables() -> Machine {
    machine("ac-table", RotaryLetter::A)
}

/// The same with location errors.
fn displaced_tables() -> Machine {
    with_errors(&tables(), errors()).with_plane_solution(tables().plane_solution())
}

fn set_up(dialect: Dialect) -> ProgramSetup {
    let setup = Setup { work_offset_mm: V::new(70.0, -40.0, 95.0), tool_length_mm: 80.0, ..Setup::default() };
    ProgramSetup { dialect: Some(dialect), ..in_mm(&setup) }
}

/// Lines with places of the tip, the first and the last of them rapids.
fn lines(dialect: Dialect, words_mm: &[V], rotary: &str) -> String {
    let mut text = String::new();
    for (k, at) in words_mm.iter().enumerate() {
        let is_rapid = k == 0 || k + 1 == words_mm.len();
        let [x, y, z] = [at.x, at.y, at.z];
        match (dialect, is_rapid) {
            (Dialect::Heidenhain, true) => writeln!(text, "L X{x:+.5} Y{y:+.5} Z{z:+.5} FMAX"),
            (Dialect::Heidenhain, false) => writeln!(text, "L X{x:+.5} Y{y:+.5} Z{z:+.5} R0 F900"),
            (_, true) => writeln!(text, "G0 X{x:.5} Y{y:.5} Z{z:.5}{rotary}"),
            (_, false) => writeln!(text, "G1 X{x:.5} Y{y:.5} Z{z:.5}{rotary} F900"),
        }
        .unwrap();
    }
    text
}

/// A program whose tip goes through these places in a plane.
fn in_plane(dialect: Dialect, plane: &Plane, tips_mm: &[V]) -> String {
    let plane = plane.of(dialect);
    let words: Vec<V> = tips_mm.iter().map(|tip| plane.words(*tip)).collect();
    let (zero, [z, x], lines) = (plane.zero_mm, plane.turns_deg, lines(dialect, &words, ""));
    match dialect {
        Dialect::Heidenhain => format!(
            "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL A+0 C+0 FMAX\n\
             PLANE SPATIAL SPA{x:+} SPB+0 SPC{z:+} TURN FMAX\n{lines}PLANE RESET STAY\nEND PGM P MM\n"
        ),
        Dialect::Siemens => format!(
            "G90 G71 G94 G17\nG54 G0 A0 C0\nCYCLE800(0,\"TC1\",0,39,{},{},{},{z},{x},0,0,0,0,1,100,1)\n{lines}CYCLE800()\nM30\n",
            zero.x, zero.y, zero.z
        ),
        _ => format!(
            "G90 G21 G94 G17 G54\nG0 A0 C0\nG68.2 X{} Y{} Z{} I{z} J{x} K0\nG53.1\n{lines}G69\nM30\n",
            zero.x, zero.y, zero.z
        ),
    }
}

/// The same with tool-centre-point control.
fn by_tips(plane: &Plane, tips_mm: &[V]) -> String {
    let [c, a] = plane.turns_deg;
    let lines = lines(Dialect::Iso, tips_mm, &format!(" A{a} C{c}"));
    format!("G90 G21 G94 G17 G54\nG43.4 H1\n{lines}G49\nM30\n")
}

/// The places of a program in a plane or under tool-centre-point control, by a reading of its own. In G91 words count
/// from the place before.
fn places(text: &str) -> Vec<V> {
    let (mut at, mut counts, mut found) = (V::zeros(), false, Vec::new());
    for line in text.lines().filter(|line| ["G68.2", "CYCLE800"].iter().all(|name| !line.contains(name))) {
        let mut moves = false;
        for word in line.split(' ') {
            counts = (counts || word == "G91") && word != "G90";
            let Some(k) = ['X', 'Y', 'Z'].into_iter().position(|letter| word.starts_with(letter)) else {
                continue;
            };
            let Ok(value) = word[1..].trim_start_matches('=').parse::<f64>() else { continue };
            at[k] = if counts { at[k] + value } else { value };
            moves = true;
        }
        found.extend(moves.then_some(at));
    }
    found
}

/// The lines that do not move in the plane.
fn others(text: &str) -> Vec<&str> {
    let moves = |line: &&str| line.contains(['X', 'Y', 'Z']) && !line.contains("G68.2");
    text.lines().filter(|line| line.contains("CYCLE800") || line.contains("Z S") || !moves(line)).collect()
}

/// A cap of a sphere about this centre that faces along the normal of a plane.
fn cap(plane: &Plane, centre_mm: V) -> PartSurface {
    let sphere = Sphere::new(V::zeros(), SPHERE_MM, 0.6, Bulge::Convex).unwrap();
    let turned = facets(&sphere, [70, 70]).into_iter();
    let turned = turned.map(|facet| facet.map(|corner| centre_mm + plane.turn() * corner));
    PartSurface {
        mesh: Arc::new(Mesh::from_facets(turned, 0.02).unwrap()),
        contact_gap: PartSurface::DEFAULT_CONTACT_GAP,
    }
}

/// Tips of a ball on the sphere, along a meridian of the plane beside the top, from `from` to `to` [rad].
fn meridian(plane: &Plane, centre_mm: V, beside: f64, ways: [f64; 2], count: usize) -> Vec<V> {
    let normal = plane.normal();
    let tips = (0..=count).map(|k| {
        let way = ways[0] + (ways[1] - ways[0]) * k as f64 / count as f64;
        let out = plane.turn() * V::new(way.tan(), beside.tan(), 1.0).normalize();
        centre_mm + out * (SPHERE_MM + BALL_MM) - normal * BALL_MM
    });
    let mut tips: Vec<V> = tips.collect();
    let [first, last] = [tips[0], tips[count]];
    tips.insert(0, first + normal * 40.0);
    tips.push(last + normal * 40.0);
    tips
}

fn compensated(dialect: Dialect, part: &PartSurface, text: &str) -> (String, CcReport) {
    let parameters = CcParameters {
        contact: ContactSource::Surface,
        part: Some(part.clone()),
        tolerance: Length::from_mm(TOLERANCE_MM),
        ..CcParameters::new(tool(BALL_MM, BALL_MM), set_up(dialect))
    };
    let (mut output, source) = (Vec::new(), text.as_bytes().to_vec());
    let report =
        compensate(&tables(), &parameters, &source, &mut output, &|| ControlFlow::Continue(())).unwrap();
    (String::from_utf8(output).unwrap(), report)
}

/// The largest distance of the contact from its line over all blocks of the source, in the written program.
fn largest_bow(plane: &Plane, centre_mm: V, source: &[V], written: &[V]) -> f64 {
    let (normal, mut at, mut largest) = (plane.normal(), 1, 0.0_f64);
    assert_eq!(written[0], source[0]);
    for ends in source[..source.len() - 1].windows(2) {
        let first = at;
        while (written[at] - ends[1]).norm() > 1e-9 {
            at += 1;
        }
        at += 1;
        let out = |tip: V| (tip + normal * BALL_MM - centre_mm).normalize();
        let [from, to] = [ends[0], ends[1]].map(out);
        let contact = |tip: V, n: V| tip + normal * BALL_MM - n * BALL_MM;
        let line = contact(ends[1], to) - contact(ends[0], from);
        let arc = angle(from, to);
        if (ends[0] - source[0]).norm() < 1e-9 {
            assert_eq!(at - first, 1, "the way in touches nothing");
            continue;
        }
        for part in first..at {
            let share = |s: f64| ((part - first) as f64 + s) / (at - first) as f64;
            for step in 0..=40 {
                let s = f64::from(step) / 40.0;
                let n = (from * ((1.0 - share(s)) * arc).sin() + to * (share(s) * arc).sin()) / arc.sin();
                let tip = written[part - 1] + (written[part] - written[part - 1]) * s;
                let off = contact(tip, n) - contact(ends[0], from);
                largest = largest.max(off.cross(&line).norm() / line.norm());
            }
        }
    }
    assert_eq!(at + 1, written.len());
    largest
}

fn plane() -> Plane {
    Plane { zero_mm: V::new(12.0, -30.5, 44.0), turns_deg: [35.1234, 40.5678] }
}

#[test]
fn blocks_are_divided_in_a_plane_as_under_tool_centre_point_control() {
    let (plane, centre) = (plane(), V::new(5.0, 8.0, -20.0));
    let (part, tips) = (cap(&plane, centre), meridian(&plane, centre, 0.1, [-0.35, 0.4], 3));
    let (by_tips, whole) = compensated(Dialect::Iso, &part, &by_tips(&plane, &tips));
    let wanted = places(&by_tips);
    for dialect in DIALECTS {
        let text = in_plane(dialect, &plane, &tips);
        let (output, report) = compensated(dialect, &part, &text);
        assert_eq!((report.motions_checked, report.motions_over_tolerance), (3, 3), "{output}");
        assert_eq!(report.motions_left_over, 0);
        assert!((report.before.max_mm - whole.before.max_mm).abs() < ROUNDED_MM);
        assert_eq!(others(&output)[..3], others(&text)[..3], "{output}");
        // No rotary word is written in the plane.
        assert_eq!(output.matches(['A', 'C']).count(), text.matches(['A', 'C']).count(), "{output}");
        let plane = plane.of(dialect);
        let [source, found] = [&text, &output]
            .map(|text| places(text).into_iter().map(|at| plane.place(at)).collect::<Vec<_>>());
        assert_eq!(found.len(), wanted.len(), "{output}\n{by_tips}");
        for (found, wanted) in found.iter().zip(&wanted) {
            assert!((found - wanted).norm() <= ROUNDED_MM, "{output}\n{by_tips}");
        }
        let [before, after] = [&source, &found].map(|found| largest_bow(&plane, centre, &source, found));
        assert!((before - report.before.max_mm).abs() < FACETS_MM && before > 2.0 * TOLERANCE_MM);
        assert!(after <= TOLERANCE_MM + FACETS_MM, "{after}");
    }
}

/// Increments divide into increments.
#[test]
fn increments_in_a_plane_are_divided_into_increments() {
    let (plane, centre) = (plane(), V::new(5.0, 8.0, -20.0));
    let (part, tips) = (cap(&plane, centre), meridian(&plane, centre, 0.1, [-0.35, 0.4], 3));
    let absolute = in_plane(Dialect::Iso, &plane, &tips);
    let words = places(&absolute);
    let mut text: Vec<String> = absolute.lines().map(str::to_owned).collect();
    for k in 2..5 {
        let step = words[k] - words[k - 1];
        text[4 + k] = format!("G1 X{:.5} Y{:.5} Z{:.5} F900", step.x, step.y, step.z);
    }
    text.insert(6, "G91".to_owned());
    text.insert(10, "G90".to_owned());
    let text = text.join("\n") + "\n";
    let (output, report) = compensated(Dialect::Iso, &part, &text);
    assert_eq!((report.motions_over_tolerance, report.motions_left_over), (3, 0), "{output}");
    let [by_steps, by_words] =
        [&output, &compensated(Dialect::Iso, &part, &absolute).0].map(|text| places(text));
    assert_eq!(by_steps.len(), by_words.len());
    for (a, b) in by_steps.iter().zip(&by_words) {
        assert!((a - b).norm() <= ROUNDED_MM, "{output}");
    }
}

#[test]
fn inches_in_a_plane_are_divided_into_inches() {
    let (plane, centre) = (plane(), V::new(5.0, 8.0, -20.0));
    let (part, tips) = (cap(&plane, centre), meridian(&plane, centre, 0.1, [-0.35, 0.4], 3));
    let in_inches = Plane { zero_mm: plane.zero_mm / 25.4, ..plane };
    let tips: Vec<V> = tips.iter().map(|tip| tip / 25.4).collect();
    let text = in_plane(Dialect::Iso, &in_inches, &tips).replace("G21", "G20").replace("F900", "F35.4");
    let (output, report) = compensated(Dialect::Iso, &part, &text);
    assert_eq!((report.motions_over_tolerance, report.motions_left_over), (3, 0), "{output}");
    let [source, found] =
        [&text, &output].map(|text| places(text).iter().map(|at| plane.place(at * 25.4)).collect::<Vec<_>>());
    let bow = largest_bow(&plane, centre, &source, &found);
    assert!(bow <= TOLERANCE_MM + FACETS_MM + ROUNDED_MM, "{bow}");
}

fn worn_by(
    dialect: Dialect,
    machine: &Machine,
    parameters: &WearParameters,
    text: &str,
) -> Result<String, Fault> {
    let (mut output, source) = (Vec::new(), text.as_bytes().to_vec());
    let parameters = WearParameters { program: set_up(dialect), ..parameters.clone() };
    compensate_wear(machine, &parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok(String::from_utf8(output).unwrap())
}

/// How far the ball with these tips is from touching the sphere, at the ends that touch [mm].
fn off_sphere(centre_mm: V, radius_mm: f64, tips_mm: &[V], axis: V) -> f64 {
    let touching = &tips_mm[1..tips_mm.len() - 1];
    let off = |tip: &V| ((tip + axis * radius_mm - centre_mm).norm() - SPHERE_MM - radius_mm).abs();
    touching.iter().map(off).fold(0.0, f64::max)
}

fn any_plane() -> impl Strategy<Value = Plane> {
    let zero = prop::array::uniform3((-90_i32..90).prop_map(|value| f64::from(value) / 2.0));
    // Rotary words of many digits.
    (zero, [-1_650_000_i32..1_650_000, 80_000_i32..800_000]).prop_map(|(zero, turns)| Plane {
        zero_mm: V::from(zero),
        turns_deg: turns.map(|turn| f64::from(turn) / 1e4),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// In any plane and dialect: the divided path keeps its line, the worn ball touches where the nominal one did, and
    /// on the machine with location errors too.
    #[test]
    fn in_any_plane_the_contact_is_where_it_was_meant(
        plane in any_plane(),
        centre in prop::array::uniform3(-40.0_f64..40.0),
        beside in -0.15_f64..0.15,
        ways in [-0.42_f64..-0.1, 0.1_f64..0.42],
        worn_mm in 4.2_f64..5.0,
        dialect in prop::sample::select(DIALECTS.to_vec()),
    ) {
        let (centre, own) = (V::from(centre), plane.of(dialect));
        let (part, tips) = (cap(&plane, centre), meridian(&plane, centre, beside, ways, 2));
        let text = in_plane(dialect, &plane, &tips);
        let tips_of = |text: &str| places(text).into_iter().map(|at| own.place(at)).collect::<Vec<_>>();
        let source = tips_of(&text);
        let (output, _) = compensated(dialect, &part, &text);
        let bow = largest_bow(&own, centre, &source, &tips_of(&output));
        prop_assert!(bow <= TOLERANCE_MM + FACETS_MM, "{}: {}", bow, output);

        let wear = WearParameters {
            contact: ContactSource::Surface,
            part: Some(part.clone()),
            ..WearParameters::new(tool(BALL_MM, BALL_MM), WornCutter::Tool(tool(worn_mm, worn_mm)), set_up(dialect))
        };
        let output = worn_by(dialect, &tables(), &wear, &text).unwrap();
        let off = off_sphere(centre, worn_mm, &tips_of(&output), plane.normal());
        prop_assert!(off <= 2.0 * HALF_MM + FACETS_MM * 1e-3, "{}: {}", off, output);
        let by_tips = worn_by(Dialect::Iso, &tables(), &wear, &by_tips(&plane, &tips)).unwrap();
        for (found, wanted) in tips_of(&output).iter().zip(places(&by_tips)) {
            prop_assert!((found - wanted).norm() <= ROUNDED_MM, "{}\n{}", output, by_tips);
        }

        let machine = displaced_tables();
        let step = WearStep { contact: ContactSource::Surface, ..WearStep::new(tool(BALL_MM, BALL_MM), WornCutter::Tool(tool(worn_mm, worn_mm))) };
        let parameters = CompensationParameters {
            wear: Some(step),
            location_errors: true,
            part: Some(part),
            ..CompensationParameters::new(set_up(dialect))
        };
        let (output, report, _) = done(&machine, &parameters, &text);
        let axis = real_axis(&plane);
        let off = off_sphere(centre, worn_mm, &tips_of(&output), axis);
        prop_assert!(off <= 2.0 * HALF_MM + FACETS_MM * 1e-3, "{}: {}", off, output);
        let left = report.location_errors.unwrap().max_axis_left.rad();
        prop_assert!((left - angle(axis, plane.normal())).abs() < 1e-9, "{}", left);
    }
}

/// The tool axis of the tables with location errors, where the nominal tables stand on the plane.
fn real_axis(plane: &Plane) -> V {
    let lines = tables().rotary_axes().each_ref().map(|axis| (axis.direction, axis.point_mm));
    let [first, second] = displaced(lines, errors());
    let real =
        Tables { first, second, letters: ['A', 'C'], offset: V::zeros(), corner: 5.0, core: 0.0, tcp: true };
    let [c, a] = plane.turns_deg;
    real.forward(V::zeros(), [a, c]).1
}

/// The tip is where the control puts it. The rotary axes have no words in the plane, so the tool axis stays off.
#[test]
fn location_errors_alone_leave_the_motions_of_a_plane_and_tell_the_axis() {
    let (plane, centre) = (plane(), V::new(5.0, 8.0, -20.0));
    let tips = meridian(&plane, centre, 0.1, [-0.35, 0.4], 3);
    for dialect in DIALECTS {
        let text = in_plane(dialect, &plane, &tips);
        let parameters =
            CompensationParameters { location_errors: true, ..CompensationParameters::new(set_up(dialect)) };
        let (output, report, changes) = done(&displaced_tables(), &parameters, &text);
        assert_eq!((output.as_str(), changes.len()), (text.as_str(), 0));
        let location = report.location_errors.unwrap();
        let off = angle(real_axis(&plane), plane.normal());
        assert!((location.max_axis_left.rad() - off).abs() < 1e-9 && off > 1e-5, "{location:?}");
        assert!((location.max_axis.rad() - off).abs() < 1e-9);
        assert_eq!((location.motions_posted, report.interpolation), (6, Interpolation::Machine));
        let not_modelled = report.budget.not_modelled;
        assert!(not_modelled.iter().any(|entry| entry.kind == NotModelledKind::ControlCalibration));
    }
}

/// A line of a course in a plane, and the same line for a tool that is shorter.
fn course_line(step: (u8, [i32; 3], bool), shorter: i32, is_first: bool) -> [String; 2] {
    let (kind, [x, y, z], states_z) = step;
    let number = |value: i32| format!("{:.3}", f64::from(value) / 1000.0);
    let (x, y) = (number(x), number(y));
    [0, shorter].map(|shorter| {
        let height = if states_z || is_first { format!(" Z{}", number(z - shorter)) } else { String::new() };
        match kind {
            _ if is_first => format!("G0 X{x} Y{y}{height}\n"),
            0 => format!("G0 X{x} Y{y}{height}\n"),
            1 => format!("G1 X{x} Y{y}{height} F900\n"),
            // A whole circle, and an increment: both are carried.
            2 => "G2 I4.5 J-2.25 F500\n".to_owned(),
            _ => format!("G91 G1 X{x} Y{y} Z1.5 F700\nG90\n"),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// On every layout of machine, a shorter tool of which the control does not know is fed farther along the normal:
    /// Z of the plane is lower by the difference, and nothing else of the text changes.
    #[test]
    fn on_every_machine_a_shorter_tool_changes_z_of_the_plane_alone(
        preset in prop::sample::select(PRESETS.to_vec()),
        k in 0_usize..2,
        turns in prop::array::uniform3(-50_i32..50),
        zero in prop::array::uniform3(-90_i32..90),
        steps in prop::collection::vec((0_u8..4, prop::array::uniform3(-90_000_i32..90_000), any::<bool>()), 1..9),
        shorter in prop_oneof![-900_i32..-1, 1_i32..900],
    ) {
        let machine = machine(preset.id, preset.parts().rotary_axes[k].letter);
        let ([i, j, third], [x, y, z]) = (turns, zero);
        let head = format!("G90 G21 G94 G17 G54\nG68.2 X{x} Y{y} Z{z} I{i} J{j} K{third}\nG53.1\nG43 H1\n");
        let [source, wanted] = [0, 1].map(|side| {
            let lines = steps.iter().enumerate().map(|(k, step)| course_line(*step, shorter, k == 0)[side].clone());
            format!("{head}{}G69\nM30\n", lines.collect::<String>())
        });
        let ball = tool(BALL_MM, BALL_MM);
        let parameters = WearParameters {
            shorter_by: Length::from_um(f64::from(shorter)),
            length_in_control: LengthInControl::Nominal,
            ..WearParameters::new(ball, WornCutter::Tool(ball), set_up(Dialect::Iso))
        };
        match worn_by(Dialect::Iso, &machine, &parameters, &source) {
            Ok(output) => prop_assert_eq!(output.lines().filter(|line| !line.contains("trunnion")).collect::<Vec<_>>(), wanted.lines().collect::<Vec<_>>()),
            // Which position the control takes may not be decided.
            Err(Fault::Lines(faults)) => {
                let is_undecided = |fault: &LineFault| fault.kind == LineFaultKind::NotMovable(Unfollowable::PlaneSolution);
                prop_assert!(faults.kept.iter().any(is_undecided), "{faults:?}\n{source}");
            }
            Err(other) => return Err(TestCaseError::fail(format!("{other:?}\n{source}"))),
        }
    }
}

/// Before the plane, in it and after it, a shorter tool is fed farther, whatever the words before were off by.
#[test]
fn words_outside_and_inside_a_plane_move_each_in_their_own_coordinates() {
    let text = "G90 G21 G94 G17 G54\nG0 X0.000 Y0.000 Z50.000 A0 C0\nG1 Z20.000 F500\nG0 Z50.000\n\
                G68.2 X10 Y0 Z0 I90 J30 K0\nG53.1\nG0 X5.000 Y6.000\nZ9.000\nG1 Z-1.000 F500\nX7.000\n\
                G2 X9.000 I1.000 J0.000\nG0 Z50.000\nG69\nG0 X1.000 Y2.000 Z60.000\nM30\n";
    let ball = tool(BALL_MM, BALL_MM);
    let parameters = WearParameters {
        shorter_by: Length::from_mm(0.25),
        ..WearParameters::new(ball, WornCutter::Tool(ball), set_up(Dialect::Iso))
    };
    let output = worn_by(Dialect::Iso, &tables(), &parameters, text).unwrap();
    let mut wanted = text.to_owned();
    for z in ["50.000", "20.000", "9.000", "60.000"] {
        let lower = z.parse::<f64>().unwrap() - 0.25;
        wanted = wanted.replace(&format!("Z{z}"), &format!("Z{lower:.3}"));
    }
    wanted = wanted.replace("Z-1.000", "Z-1.250");
    let found: Vec<&str> = output.lines().filter(|line| !line.contains("trunnion")).collect();
    assert_eq!(found, wanted.lines().collect::<Vec<_>>(), "{output}");
}

/// An arc about a separate centre stays one if it moves along the normal of the plane, wherever this points.
#[test]
fn arcs_of_a_plane_move_along_its_normal() {
    let text = "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL A+0 C+0 FMAX\nPLANE SPATIAL SPA+30 SPB+0 SPC+90 TURN FMAX\n\
                L X+0.000 Y+0.000 Z+9.000 FMAX\nL Z-1.000 R0 F500\nCC X+5 Y+0\nC X+10.000 Y+0.000 DR+\n\
                L IX+1.500 IZ+2.000\nL X+0.000 Z+9.000 FMAX\nPLANE RESET STAY\nEND PGM P MM\n";
    let ball = tool(BALL_MM, BALL_MM);
    let parameters = WearParameters {
        shorter_by: Length::from_mm(0.25),
        ..WearParameters::new(ball, WornCutter::Tool(ball), set_up(Dialect::Heidenhain))
    };
    let output = worn_by(Dialect::Heidenhain, &tables(), &parameters, text).unwrap();
    let wanted = text.replace("Z+9.000", "Z+8.750").replace("Z-1.000", "Z-1.250");
    let found: Vec<&str> = output.lines().filter(|line| !line.contains("trunnion")).collect();
    assert_eq!(found, wanted.lines().collect::<Vec<_>>(), "{output}");
}

/// Far away a double has no ten millionths of a millimetre. What is left unchanged is what it was all the same.
#[test]
fn places_far_away_in_a_plane_are_left_as_they_are() {
    let ball = tool(BALL_MM, BALL_MM);
    let shorter = WearParameters {
        shorter_by: Length::from_mm(0.25),
        ..WearParameters::new(ball, WornCutter::Tool(ball), set_up(Dialect::Iso))
    };
    for [zero, place] in [["9999999", "0.001"], ["0", "900000000"], ["-9999999", "987654321.123"]] {
        let text = format!(
            "G90 G21 G94 G17 G54\nG0 X0 Y0 Z50 A0 C0\nG68.2 X{zero} Y0 Z0 I10 J20 K0\nG53.1\nG0 X{place} Y0 Z0\nG1 X5 F100\nG69\nM30\n"
        );
        let written =
            worn_by(Dialect::Iso, &tables(), &shorter, &text).unwrap_or_else(|fault| panic!("{text}{fault}"));
        assert!(written.contains("G69"), "{written}");
    }
}

/// Blocks of a plane that are not followed are left alone where they need not move, and refused where they must.
#[test]
fn what_is_not_certain_in_a_plane_is_left_or_refused() {
    let head = "G90 G21 G94 G17 G54\nG0 X0 Y0 Z50 A0 C0\nG68.2 X10 Y0 Z0 I90 J30 K0\nG53.1\nG0 X5 Y6 Z9\n";
    let ball = tool(BALL_MM, BALL_MM);
    let shorter = WearParameters {
        shorter_by: Length::from_mm(0.25),
        ..WearParameters::new(ball, WornCutter::Tool(ball), set_up(Dialect::Iso))
    };
    let tilted = Unfollowable::TiltedPlane;
    for (lines, line, reason) in [
        ("G1 X1 C10 F500\n", 6, tilted),
        ("G52 X5\nG1 X1 Y2 Z3 F500\n", 7, tilted),
        ("G81 X1 Y2 Z-3 R2 F500\nG80\n", 6, Unfollowable::CannedCycle),
        ("G41 D1\nG1 X1 Y2 Z3 F500\n", 7, Unfollowable::CutterCompensation),
        ("/G1 X1 F500\n", 6, Unfollowable::BlockDelete),
    ] {
        let text = format!("{head}{lines}G69\nM30\n");
        let Err(Fault::Lines(faults)) = worn_by(Dialect::Iso, &tables(), &shorter, &text) else {
            panic!("{text}")
        };
        let first = &faults.kept[0];
        assert_eq!((first.line, &first.kind), (line, &LineFaultKind::NotMovable(reason)), "{text}");
        let parameters = CcParameters::new(ball, set_up(Dialect::Iso));
        let (mut output, source) = (Vec::new(), text.clone().into_bytes());
        let go_on = || ControlFlow::Continue(());
        let report = compensate(&tables(), &parameters, &source, &mut output, &go_on).unwrap();
        assert_eq!(output, source);
        let left = report.warnings.iter().find(|warning| warning.kind == WarningKind::NotFollowed).unwrap();
        assert_eq!((left.line, left.reason), (Some(line), Some(reason)), "{text}");
    }
    // Without a rule in the profile.
    let undecided = tables().with_plane_solution(None);
    let Err(Fault::Lines(faults)) = worn_by(Dialect::Iso, &undecided, &shorter, &format!("{head}M30\n"))
    else {
        panic!("the rotary positions are not decided")
    };
    let kinds: Vec<_> = faults.kept.iter().map(|fault| (fault.line, &fault.kind)).collect();
    let undecided = Unfollowable::PlaneSolution;
    assert_eq!(kinds, [(4, &LineFaultKind::NotMovable(tilted)), (5, &LineFaultKind::NotMovable(undecided))]);
}

/// All steps in one pass: the program of the plane and that of the tips become the same.
#[test]
fn all_steps_in_one_pass_do_in_a_plane_as_under_tool_centre_point_control() {
    let (plane, centre) = (plane(), V::new(5.0, 8.0, -20.0));
    let (part, tips) = (cap(&plane, centre), meridian(&plane, centre, 0.1, [-0.35, 0.4], 3));
    let worn = tool(4.5, 4.5);
    let outcomes = [by_tips(&plane, &tips), in_plane(Dialect::Iso, &plane, &tips)].map(|text| {
        let ball = tool(BALL_MM, BALL_MM);
        let cc = CcStep {
            tolerance: Length::from_mm(TOLERANCE_MM),
            contact: ContactSource::Surface,
            ..CcStep::new(ball)
        };
        let wear =
            WearStep { contact: ContactSource::Surface, ..WearStep::new(ball, WornCutter::Tool(worn)) };
        let parameters = CompensationParameters {
            wear: Some(wear),
            cc: Some(cc),
            part: Some(part.clone()),
            ..CompensationParameters::new(set_up(Dialect::Iso))
        };
        let (output, report, changes) = done(&tables(), &parameters, &text);
        (places(&output), report.budget, changes)
    });
    let [(tips, by_tips, moved), (words, by_plane, changes)] = outcomes;
    assert_eq!((tips.len(), moved.len()), (words.len(), changes.len()));
    assert!(tips.len() > 6, "{tips:?}");
    for (tip, at) in tips.iter().zip(&words) {
        assert!((tip - plane.place(*at)).norm() <= ROUNDED_MM);
    }
    for (a, b) in moved.iter().zip(&changes) {
        assert!((a.blocks_out, a.kind) == (b.blocks_out, b.kind));
        assert!((a.wear_mm - b.wear_mm).abs() < ROUNDED_MM && (a.cc_mm - b.cc_mm).abs() < ROUNDED_MM);
    }
    assert!((by_tips.sum.after_mm - by_plane.sum.after_mm).abs() < ROUNDED_MM);
    assert!(by_plane.sum.after_mm <= TOLERANCE_MM + ROUNDED_MM && by_plane.sum.before_mm > 0.05);
}
