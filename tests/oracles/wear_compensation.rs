//! Shifts of a worn cutter's tip against the published value, the tools of P3, and the touching surfaces themselves.

use trunnion::contact::{CutterContact, Touch};
use trunnion::geometry::{Vec3, across, angle_between};
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::Tool;
use trunnion::units::{Angle, Length};
use trunnion::wear::{
    Advice, CutterWear, FlatContact, ShiftFault, Surface, WearQuestion, WearTable, WearTableFault, advise,
    end_milling_shift, end_milling_shift_at, largest_stepover, side_milling_shift, side_milling_shift_at,
    uncompensated_excess_mm,
};

use crate::cutter_contact::ac_table;

/// Values given to nine significant digits are met to half a unit of the last [mm].
const NINE_DIGITS_MM: f64 = 5e-10;
/// Rounding of coordinates of tens of millimetres [mm].
const ROUNDING_MM: f64 = 1e-13;

fn mm(value: f64) -> Length {
    Length::from_mm(value)
}

fn tool(radius_mm: f64, corner_mm: f64) -> Tool {
    Tool::new(mm(radius_mm), mm(corner_mm)).expect("a tool")
}

fn wear(nominal: [f64; 2], actual: [f64; 2]) -> CutterWear {
    CutterWear::new(tool(nominal[0], nominal[1]), tool(actual[0], actual[1]))
}

/// Normals from along the axis to across it, on every side, for a slanted axis.
fn contacts() -> impl Iterator<Item = (Vec3, Vec3)> {
    let axis = Vec3::new(0.1, 0.25, 0.95).normalize();
    let side = across(Vec3::x(), axis).normalize();
    let other = axis.cross(&side);
    (1..=18_u32).flat_map(move |k| {
        (0..8_u32).map(move |j| {
            let (lean, turn) = (f64::from(k) * 5.0_f64.to_radians(), f64::from(j) * 0.8);
            let across = side * turn.cos() + other * turn.sin();
            (axis, axis * lean.cos() + across * lean.sin())
        })
    })
}

/// c − w of a cutter touching with this normal, written out (§2): `−r·n − (R − r)·m + r·t`.
fn contact_from_tip(tool: &Tool, axis: Vec3, n: Vec3) -> Vec3 {
    let (radius, corner) = (tool.radius().mm(), tool.corner_radius().mm());
    let m = (n - axis * n.dot(&axis)).normalize();
    axis * corner - n * corner - m * (radius - corner)
}

#[test]
fn the_published_value_of_a_bull_nose_is_met() {
    let (n, t) = (Vec3::new(0.3, -0.2, 0.9), Vec3::new(0.1, 0.25, 0.95).normalize());
    let shift = end_milling_shift(&wear([5.0, 1.0], [4.6, 0.8]), t, n).expect("a shift");
    let expected = Vec3::new(-0.132_032_774, 0.266_534_599, -0.029_677_414_5);
    assert!((shift.shift_mm - expected).amax() <= NINE_DIGITS_MM, "{}", shift.shift_mm);
    assert_eq!(shift.note, None);
}

#[test]
fn the_worn_cutter_touches_the_same_point() {
    for (nominal, actual) in [
        ([5.0, 5.0], [4.0, 4.0]),
        ([5.0, 3.0], [4.75, 2.75]),
        ([5.0, 1.0], [4.6, 0.8]),
        ([5.0, 0.0], [4.9, 0.0]),
        ([5.0, 0.0], [4.9, 0.3]),
        ([5.0, 5.0], [5.2, 4.9]),
    ] {
        let wear = wear(nominal, actual);
        for (t, n) in contacts() {
            let tip = Vec3::new(12.0, -7.0, 35.0);
            let shift = end_milling_shift(&wear, t, n).expect("a shift").shift_mm;
            let nominal = tip + contact_from_tip(&wear.nominal, t, n);
            let worn = tip + shift + contact_from_tip(&wear.actual, t, n);
            assert!((nominal - worn).norm() < ROUNDING_MM, "{nominal} {worn}");
            // What is left without the shift: how far the worn surface stands off along the normal.
            let left = (tip + contact_from_tip(&wear.actual, t, n) - nominal).dot(&n);
            let told = uncompensated_excess_mm(&wear, t, n).expect("an excess");
            assert!((left - told).abs() < ROUNDING_MM, "{left} {told}");
        }
    }
}

#[test]
fn p3_table_1_moves_the_corner_s_centre_by_a_quarter_of_a_millimetre_along_the_normal() {
    let worn = wear([5.0, 3.0], [4.75, 2.75]);
    for (t, n) in contacts() {
        let shift = end_milling_shift(&worn, t, n).expect("a shift").shift_mm;
        // the centre stands r above the tip
        let centre = shift + t * (2.75 - 3.0);
        assert!((centre + n * 0.25).norm() < ROUNDING_MM);
        // Fig. 6 reads about 0.2 mm between the tips' paths: 2·0.25·sin(ψ/2), at most 0.25·√2
        let half_angle = 0.5 * angle_between(n, t);
        assert!((shift.norm() - 0.5 * half_angle.sin()).abs() < ROUNDING_MM);
    }
}

#[test]
fn p3_table_4_shifts_by_one_half_and_a_quarter_and_leaves_the_rotary_words() {
    let machine = ac_table();
    let setup = Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), ..Setup::default() };
    let kinematics = Kinematics::new(&machine, &setup);
    let rotary_rad = [35.0_f64.to_radians(), -50.0_f64.to_radians()];
    let linear_mm = Vec3::new(10.0, 20.0, 30.0);
    let pose =
        ToolPose { tip_mm: kinematics.tip_mm(linear_mm, rotary_rad), axis: kinematics.axis(rotary_rad) };
    for (_, local) in contacts() {
        // the same leans about this pose's axis
        let n = (local + pose.axis * 1.2).normalize();
        let contact_mm = pose.tip_mm + contact_from_tip(&tool(5.0, 5.0), pose.axis, n);
        let words: Vec<Vec3> = [(4.0, 1.0), (4.5, 0.5), (4.75, 0.25), (5.0, 0.0)]
            .into_iter()
            .map(|(radius, lost)| {
                let shift = end_milling_shift(&wear([5.0, 5.0], [radius, radius]), pose.axis, n);
                let shift = shift.expect("a shift").shift_mm;
                assert!((shift - (pose.axis - n) * lost).norm() < ROUNDING_MM);
                let words = kinematics.linear_mm(pose.tip_mm + shift, rotary_rad);
                let worn = kinematics.tip_mm(words, rotary_rad)
                    + contact_from_tip(&tool(radius, radius), pose.axis, n);
                assert!((worn - contact_mm).norm() < ROUNDING_MM * 10.0);
                words
            })
            .collect();
        // Fig. 7: the smaller the wear, the nearer to the nominal program, and in its proportion
        let off = |k: usize| (words[k] - linear_mm).norm();
        assert!(off(3) < ROUNDING_MM * 10.0);
        assert!((off(0) - 2.0 * off(1)).abs() < 1e-12 && (off(1) - 2.0 * off(2)).abs() < 1e-12);
    }
}

#[test]
fn along_the_axis_the_whole_flat_touches_and_nothing_moves() {
    let t = Vec3::new(0.1, 0.25, 0.95).normalize();
    let side = across(Vec3::x(), t).normalize();
    let lean = |angle_deg: f64| t * angle_deg.to_radians().cos() + side * angle_deg.to_radians().sin();
    let bull = wear([5.0, 1.0], [4.6, 0.8]);
    let whole = end_milling_shift(&bull, t, t * 3.0).expect("a shift");
    assert_eq!((whole.shift_mm, whole.note), (Vec3::zeros(), Some(FlatContact::Whole)));
    let nearly = end_milling_shift(&bull, t, lean(0.09)).expect("a shift");
    assert!(
        matches!(nearly.note, Some(FlatContact::Nearly { angle_rad }) if (angle_rad.to_degrees() - 0.09).abs() < 1e-9)
    );
    assert!((nearly.shift_mm.norm() - 0.2).abs() < 1e-3);
    assert_eq!(end_milling_shift(&bull, t, lean(0.11)).expect("a shift").note, None);
    // a ball has no flat
    let ball = end_milling_shift(&wear([5.0, 5.0], [4.0, 4.0]), t, t).expect("a shift");
    assert!(ball.shift_mm.norm() < 1e-15 && ball.note.is_none());
}

#[test]
fn side_milling_moves_across_the_axis_by_the_radius_lost() {
    let t = Vec3::new(0.1, 0.25, 0.95).normalize();
    let n = across(Vec3::new(1.0, 2.0, 0.3), t).normalize();
    let worn = wear([5.0, 1.0], [4.6, 0.8]);
    let shift = side_milling_shift(&worn, t, n * 7.0).expect("a shift").shift_mm;
    assert!((shift + n * 0.4).norm() < ROUNDING_MM && shift.dot(&t).abs() < ROUNDING_MM);
    // rounding of the normal moves nothing along the axis
    let rounded = side_milling_shift(&worn, t, n + t * 0.9e-3).expect("a shift").shift_mm;
    assert!(rounded.dot(&t).abs() < ROUNDING_MM && (rounded - shift).norm() < 1e-6);
    for lean in [1.1e-3, -1.1e-3, 0.5] {
        let fault = side_milling_shift(&worn, t, n + t * lean).expect_err("a refusal");
        assert!(matches!(fault, ShiftFault::NotFlank { cosine, .. } if cosine * lean > 0.0), "{fault}");
    }
    assert!(matches!(side_milling_shift(&worn, t, Vec3::zeros()), Err(ShiftFault::ZeroNormal { .. })));
}

#[test]
fn a_control_with_the_nominal_length_is_told_how_much_is_missing() {
    let t = Vec3::new(0.1, 0.25, 0.95).normalize();
    let n = across(Vec3::new(1.0, 2.0, 0.3), t).normalize();
    let plain = wear([5.0, 5.0], [4.8, 4.8]);
    let short = CutterWear { shorter_by: mm(0.3), ..plain };
    let missing = t * -0.3;
    for (a, b) in [
        (end_milling_shift(&plain, t, n + t), end_milling_shift(&short, t, n + t)),
        (side_milling_shift(&plain, t, n), side_milling_shift(&short, t, n)),
    ] {
        let (a, b) = (a.expect("a shift").shift_mm, b.expect("a shift").shift_mm);
        assert!((b - a - missing).norm() < ROUNDING_MM);
    }
    // uncompensated, a shorter tool leaves what it is shorter along the normal
    let (a, b) = (uncompensated_excess_mm(&plain, t, t), uncompensated_excess_mm(&short, t, t));
    assert!((b.expect("an excess") - a.expect("an excess") - 0.3).abs() < ROUNDING_MM);
}

#[test]
fn an_undercut_and_a_normal_without_length_are_refused() {
    let t = Vec3::z();
    let ball = wear([5.0, 5.0], [4.0, 4.0]);
    let fault = end_milling_shift(&ball, t, Vec3::new(1.0, 0.0, -0.2)).expect_err("a refusal");
    assert!(matches!(fault, ShiftFault::Undercut { angle_deg } if (angle_deg - 101.309_932_5).abs() < 1e-6));
    for normal in [Vec3::zeros(), Vec3::new(f64::NAN, 0.0, 1.0), Vec3::new(f64::INFINITY, 0.0, 1.0)] {
        assert!(end_milling_shift(&ball, t, normal).is_err(), "{normal}");
    }
    assert!(end_milling_shift(&ball, t, Vec3::x()).is_ok());
}

#[test]
fn a_stated_point_gives_the_shift_of_its_normal_and_its_distance_from_the_cutter() {
    for (nominal, actual) in [([5.0, 5.0], [4.0, 4.0]), ([5.0, 3.0], [4.75, 2.75]), ([5.0, 0.0], [4.9, 0.0])]
    {
        let wear = wear(nominal, actual);
        for (t, n) in contacts() {
            let pose = ToolPose { tip_mm: Vec3::new(12.0, -7.0, 35.0), axis: t };
            let contact_mm = pose.tip_mm + contact_from_tip(&wear.nominal, t, n);
            let stated = end_milling_shift_at(&wear, &pose, contact_mm).expect("a shift");
            let expected = end_milling_shift(&wear, t, n).expect("a shift").shift_mm;
            assert!((stated.shift.shift_mm - expected).norm() < 1e-12);
            assert!(stated.off_tool_mm < 1e-12);
            if wear.nominal.corner_radius().mm() > 0.0 {
                // The same point stated a tenth inside or outside, along its normal.
                for off in [0.1, -0.1] {
                    let stated = end_milling_shift_at(&wear, &pose, contact_mm + n * off).expect("a shift");
                    assert!((stated.shift.shift_mm - expected).norm() < 1e-12);
                    assert!((stated.off_tool_mm - 0.1).abs() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn stated_points_without_a_normal_are_refused_and_those_on_the_flat_stay() {
    let pose = ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::z() };
    let bull = wear([5.0, 1.0], [4.6, 0.8]);
    let flat = end_milling_shift_at(&bull, &pose, Vec3::new(2.0, 0.0, 0.01)).expect("a shift");
    assert_eq!((flat.shift.shift_mm, flat.shift.note), (Vec3::zeros(), Some(FlatContact::Whole)));
    assert!((flat.off_tool_mm - 0.01).abs() < ROUNDING_MM);
    let deep = end_milling_shift_at(&wear([5.0, 5.0], [4.0, 4.0]), &pose, Vec3::new(0.1, 0.0, 4.9));
    assert!(matches!(deep, Err(ShiftFault::NoNormal { .. })), "{deep:?}");
    let above = end_milling_shift_at(&bull, &pose, Vec3::new(5.0, 0.0, 8.0));
    assert!(matches!(above, Err(ShiftFault::Undercut { .. })), "{above:?}");
    let rounded = end_milling_shift_at(&wear([5.0, 0.0], [4.9, 0.2]), &pose, Vec3::new(5.0, 0.0, 0.0));
    assert!(matches!(rounded, Err(ShiftFault::EdgeWithoutNormal { .. })), "{rounded:?}");
    // The flank: eight millimetres up, a tenth outside; and below its beginning.
    let flank = side_milling_shift_at(&bull, &pose, Vec3::new(5.1, 0.0, 8.0)).expect("a shift");
    assert!((flank.shift.shift_mm - Vec3::new(0.4, 0.0, 0.0)).norm() < ROUNDING_MM);
    assert!((flank.off_tool_mm - 0.1).abs() < 1e-12);
    let low = side_milling_shift_at(&bull, &pose, Vec3::new(5.0, 0.0, 0.6)).expect("a shift");
    assert!((low.off_tool_mm - 0.4).abs() < 1e-12);
    assert!(side_milling_shift_at(&bull, &pose, Vec3::new(0.0, 0.0, 8.0)).is_err());
}

#[test]
fn a_point_far_off_the_ball_is_told_with_the_distance_of_its_touch() {
    let pose = ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::z() };
    let contact_mm = Vec3::new(0.3, 0.2, 0.25);
    let ball = wear([5.0, 5.0], [4.5, 4.5]);
    let stated = end_milling_shift_at(&ball, &pose, contact_mm).expect("a shift");
    let touch = Touch::from_point(&ball.nominal, &pose, contact_mm).expect("a touch");
    assert!(matches!(touch.contact, CutterContact::Offset { .. }));
    assert!((stated.off_tool_mm - touch.off_tool_mm).abs() < 1e-15 && stated.off_tool_mm > 0.2);
}

fn table(entries: &[(f64, f64)]) -> Result<WearTable, WearTableFault> {
    let entries: Vec<_> =
        entries.iter().map(|(deg, um)| (Angle::from_deg(*deg), Length::from_um(*um))).collect();
    WearTable::new(&entries)
}

#[test]
fn a_constant_table_is_a_ball_of_another_radius() {
    let table = table(&[(0.0, -100.0), (90.0, -100.0)]).expect("a table");
    let ball = CutterWear { shorter_by: mm(0.05), ..wear([5.0, 5.0], [4.9, 4.9]) };
    for (t, n) in contacts() {
        let by_table = table.shift(t, n, mm(0.05)).expect("a shift").shift_mm;
        let by_radius = end_milling_shift(&ball, t, n).expect("a shift").shift_mm;
        assert!((by_table - by_radius).norm() < ROUNDING_MM);
    }
}

#[test]
fn a_table_keeps_the_tangent_plane_of_a_ball_that_sits_askew() {
    // A ball of radius r′ whose centre has come e higher: δ(ψ) = r′ − r − e·cos ψ, tabled every tenth of a degree.
    let (r, worn, e) = (5.0, 4.93, 0.04);
    let entries: Vec<(f64, f64)> = (0..=900_u32)
        .map(|k| {
            let deg = f64::from(k) * 0.1;
            (deg, (worn - r - e * deg.to_radians().cos()) * 1e3)
        })
        .collect();
    let table = table(&entries).expect("a table");
    for (t, n) in contacts() {
        let shift = table.shift(t, n, Length::ZERO).expect("a shift").shift_mm;
        let contact = contact_from_tip(&tool(r, r), t, n);
        // The worn tip stands r′ below its centre.
        let plane = (shift + t * worn - n * worn - contact).dot(&n);
        // linear between entries: e·(0.1°)²/8
        assert!(plane.abs() < 0.04 * 0.1_f64.to_radians().powi(2) / 8.0 * 1.01 + ROUNDING_MM, "{plane:e}");
    }
}

#[test]
fn tables_are_read_linearly_and_never_beyond_their_end() {
    let short = table(&[(0.0, 0.0), (30.0, -30.0), (60.0, -90.0)]).expect("a table");
    for (deg, um) in [(0.0, 0.0), (10.0, -10.0), (30.0, -30.0), (45.0, -60.0), (60.0, -90.0)] {
        let found = short.deviation(Angle::from_deg(deg)).expect("a deviation").um();
        assert!((found - um).abs() < 1e-9, "{deg}: {found}");
    }
    assert_eq!(short.deviation(Angle::from_deg(60.001)), None);
    let t = Vec3::z();
    let beyond = short.shift(t, Vec3::x(), Length::ZERO);
    assert!(matches!(beyond, Err(ShiftFault::BeyondTable { max_deg, .. }) if (max_deg - 60.0).abs() < 1e-9));
    assert!(matches!(short.shift(t, -t, Length::ZERO), Err(ShiftFault::Undercut { .. })));
    assert!(table(&[(0.0, 0.0), (90.0, -20.0)]).expect("a table").shift(t, Vec3::x(), Length::ZERO).is_ok());
    assert!(matches!(table(&[]), Err(WearTableFault::NoTip)));
    assert!(matches!(table(&[(1.0, 0.0)]), Err(WearTableFault::NoTip)));
    for (entries, index) in [
        (vec![(0.0, 0.0), (0.0, 1.0)], 1),
        (vec![(0.0, 0.0), (50.0, 1.0), (40.0, 1.0)], 2),
        (vec![(0.0, 0.0), (91.0, 1.0)], 1),
        (vec![(0.0, 0.0), (f64::NAN, 1.0)], 1),
    ] {
        assert!(matches!(table(&entries), Err(WearTableFault::Angle { index: at, .. }) if at == index));
    }
    for um in [f64::NAN, 1e5, f64::NEG_INFINITY] {
        assert!(matches!(table(&[(0.0, um)]), Err(WearTableFault::Deviation { index: 0, .. })));
    }
}

#[test]
fn p3_says_that_five_and_ten_per_cent_pay_and_twenty_do_not() {
    // Its finishing leaves 0.02 mm with the nominal ball of 10 mm.
    let allowed = mm(0.02);
    for surface in [Surface::Flat, Surface::Concave { radius: mm(60.0) }] {
        let stepover = largest_stepover(allowed, mm(5.0), surface).expect("a step-over");
        for (radius, expected) in [
            (5.0, Advice::Keep),
            (4.75, Advice::ReduceStepover),
            (4.5, Advice::ReduceStepover),
            (4.0, Advice::ChangeTool),
        ] {
            let question = WearQuestion {
                wear: wear([5.0, 5.0], [radius, radius]),
                lead: Angle::from_deg(90.0),
                surface,
                stepover,
                allowed,
                least_stepover: stepover * 0.9,
                contact_angles: [Angle::from_deg(0.0), Angle::from_deg(60.0)],
            };
            let found = advise(&question).expect("advice");
            assert_eq!(found.advice, expected, "{radius} {surface:?}");
            // compensation takes away (r − r′)(1 − cos 60°)
            let [least, most] = found.offset.map(Length::mm);
            assert!(least.abs() < ROUNDING_MM && (most - 0.5 * (5.0 - radius)).abs() < ROUNDING_MM);
            // Its own limit of 0.03 mm lets compensation alone do for all three.
            let wider = advise(&WearQuestion { allowed: mm(0.03), ..question }).expect("advice");
            assert_eq!(
                wider.advice,
                if radius < 5.0 { Advice::Compensate } else { Advice::Keep },
                "{radius}"
            );
            assert!(wider.after <= wider.before);
        }
    }
}
