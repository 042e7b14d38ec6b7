//! Deviation and repair of the contact path against closed forms and the published example.

use std::sync::Arc;

use trunnion::contact::{
    BlockTime, Carry, Correction, CutterContact, Effort, Node, Resolution, SourceBlock, Station, Touch,
    block_time_s, divide, feed_word, prove, sample_until_sure, segments,
};
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{Machine, RotaryLetter, Tool};
use trunnion::motion::{AxisWords, FeedMode, FeedRules, Interpolation};
use trunnion::program::Dialect;
use trunnion::units::Length;

use crate::tables::tables;

/// A and C tables through the machine's origin, no limits.
pub(crate) fn ac_table() -> Machine {
    tables([RotaryLetter::A, RotaryLetter::C], false)
}

fn words(linear_mm: [f64; 3], rotary_deg: [f64; 2]) -> AxisWords {
    AxisWords { linear_mm, rotary_deg }
}

fn tip_block<'a>(
    machine: &'a Machine,
    kinematics: &Arc<Kinematics>,
    ends: [AxisWords; 2],
) -> SourceBlock<'a> {
    let mode = Interpolation::Machine;
    let stations = ends.map(|words| Station::new(machine, kinematics, mode, words));
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    SourceBlock::new(machine, kinematics, tool, mode, stations, Carry::Tip)
}

/// The notation's own table states two digits.
const TWO_DIGITS: f64 = 0.03;

#[test]
fn a_table_turn_bows_the_tip_by_rho_times_angle_squared_over_eight() {
    let machine = ac_table();
    let kinematics = Arc::new(Kinematics::new(&machine, &Setup::default()));
    for (turn_deg, expected_um) in [(0.5, 0.95), (1.0, 3.8), (2.0, 15.2), (5.0, 95.2)] {
        let block = tip_block(
            &machine,
            &kinematics,
            [words([100.0, 0.0, 0.0], [0.0, 0.0]), words([100.0, 0.0, 0.0], [0.0, turn_deg])],
        );
        let found = sample_until_sure(&block, &block.whole(), 0.01);
        // Exactly the sagitta of the arc.
        let sagitta_mm = 100.0 * (1.0 - (turn_deg.to_radians() / 2.0).cos());
        assert!((found.max_mm - sagitta_mm).abs() < 1e-9, "{} {}", found.max_mm, sagitta_mm);
        assert!((found.max_mm * 1000.0 / expected_um - 1.0).abs() < TWO_DIGITS);
    }
}

#[test]
fn with_tcp_only_the_ball_s_own_turn_remains() {
    let machine = ac_table();
    let kinematics = Arc::new(Kinematics::new(&machine, &Setup::default()));
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    for (turn_deg, expected_um) in [(1.0, 0.2), (2.0, 0.8), (3.0, 1.7)] {
        let mode = Interpolation::Tcp;
        let ends = [words([0.0; 3], [20.0, 0.0]), words([0.0, 10.0, 0.0], [20.0 + turn_deg, 0.0])]
            .map(|words| Station::new(&machine, &kinematics, mode, words));
        let normal = Vec3::new(0.0, -0.1, 1.0);
        let touches = ends.map(|end| Touch::from_normal(&tool, &end.pose, normal).expect("no undercut"));
        let carry =
            Carry::between(&tool, [&touches[0].contact, &touches[1].contact], ends.map(|end| end.pose.axis));
        let block = SourceBlock::new(&machine, &kinematics, tool, mode, ends, carry);
        let found = sample_until_sure(&block, &block.whole(), 0.01);
        let closed_um = 5.0 * turn_deg.to_radians().powi(2) / 8.0 * 1000.0;
        assert!((closed_um - expected_um).abs() < 0.06);
        // The part of the bow across the line is what counts; here the line is nearly across t.
        assert!(
            (found.max_mm * 1000.0 / closed_um - 1.0).abs() < 0.1,
            "{} {closed_um}",
            found.max_mm * 1000.0
        );
    }
}

/// P0 Table 1, decimals restored as the notation has them.
const P0_START: ([f64; 3], [f64; 2], [f64; 3]) =
    ([24.4858, 41.5567, 135.2477], [51.4129, -2.1123], [24.6403, 41.1138, 135.1819]);
const P0_END: ([f64; 3], [f64; 2], [f64; 3]) =
    ([23.4497, 43.0454, 134.2505], [51.5534, -2.1123], [23.9962, 42.1778, 134.5159]);

#[test]
fn p0_table_1_has_the_length_time_and_contact_distances_it_states() {
    let machine = ac_table();
    let kinematics = Arc::new(Kinematics::new(&machine, &Setup::default()));
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let mode = Interpolation::Machine;
    let points = [P0_START, P0_END].map(|(linear, rotary, contact)| {
        let station = Station::new(&machine, &kinematics, mode, words(linear, rotary));
        let contact_mm = Station::new(&machine, &kinematics, mode, words(contact, rotary)).pose.tip_mm;
        (station, contact_mm)
    });
    let touches = points.map(|(station, contact_mm)| {
        Touch::from_point(&tool, &station.pose, contact_mm).expect("carried as an offset")
    });
    for (touch, (station, contact_mm), distance_mm) in
        [(touches[0], points[0], 0.474), (touches[1], points[1], 1.059)]
    {
        assert!(touch.off_tool_mm > 0.005);
        assert!(matches!(touch.contact, CutterContact::Offset { .. }));
        assert!(((station.pose.tip_mm - contact_mm).norm() - distance_mm).abs() < 0.0006);
    }
    let ends = points.map(|(station, _)| station);
    let carry =
        Carry::between(&tool, [&touches[0].contact, &touches[1].contact], ends.map(|end| end.pose.axis));
    let block = SourceBlock::new(&machine, &kinematics, tool, mode, ends, carry);
    assert!((block.line.start_mm - points[0].1).norm() < 1e-12);
    assert!((block.line.start_mm + block.line.along_mm - points[1].1).norm() < 1e-12);
    let time = BlockTime::of(&block, &block.whole(), 1.0, FeedRules::of(Dialect::Iso).paths);
    assert!((time.path_units - 2.069_816_113).abs() < 5e-10, "{}", time.path_units);
    let tau_s = block_time_s(FeedMode::PerMinute, 1000.0, &time).expect("a feed");
    assert!(((tau_s / 0.002).ceil() - 63.0).abs() < 1e-12);
    assert!(block.deviation_at(&block.whole(), 0.0).distance_mm < 1e-12);
    assert!(block.deviation_at(&block.whole(), 1.0).distance_mm < 1e-12);
}

#[test]
fn dividing_keeps_the_tolerance_with_hardly_more_parts_than_the_square_root_law() {
    let machine = ac_table();
    let kinematics = Arc::new(Kinematics::new(&machine, &Setup::default()));
    let block = tip_block(
        &machine,
        &kinematics,
        [words([100.0, 0.0, 0.0], [10.0, 0.0]), words([100.0, 5.0, 2.0], [14.0, 9.0])],
    );
    let resolution = Resolution::absolute(5, 5, 1.0);
    let before = sample_until_sure(&block, &block.whole(), 0.001);
    let divided_to = |tolerance_mm: f64| {
        let sizes_mm = [before.max_mm, tolerance_mm];
        let proof = |nodes: &[Node], effort: &mut Effort<'_>| prove(&block, nodes, tolerance_mm, effort);
        divide(&block, Correction::Even, sizes_mm, &resolution, &mut Effort::default(), proof)
    };
    for tolerance_mm in [0.05, 0.01, 0.002] {
        let divided = divided_to(tolerance_mm).expect("reachable");
        for segment in segments(&block, &divided) {
            assert!(sample_until_sure(&block, &segment, tolerance_mm).max_mm <= tolerance_mm * (1.0 + 1e-4));
        }
        let law = (before.max_mm / tolerance_mm).sqrt().ceil();
        assert!(divided.len() as f64 <= law * 1.05 + 1.0, "{} {law}", divided.len());
    }
    assert!(divided_to(1e-6).is_err());
}

#[test]
fn inserted_feeds_share_the_block_s_time() {
    let machine = ac_table();
    let kinematics = Arc::new(Kinematics::new(&machine, &Setup::default()));
    let block = tip_block(
        &machine,
        &kinematics,
        [words([100.0, 0.0, 0.0], [0.0, 0.0]), words([110.0, 0.0, 0.0], [0.0, 5.0])],
    );
    let whole = BlockTime::of(&block, &block.whole(), 1.0, FeedRules::of(Dialect::Iso).paths);
    let half = BlockTime { path_units: 4.0, turn_deg: 2.5 };
    let tau_s = block_time_s(FeedMode::PerMinute, 600.0, &whole).expect("a feed");
    let feed = feed_word(FeedMode::PerMinute, 600.0, &whole, &half, 0.5).expect("a feed");
    let half_s = block_time_s(FeedMode::PerMinute, feed, &half).expect("a feed");
    assert!((half_s - tau_s / 2.0).abs() < 1e-12);
    assert!(
        (feed_word(FeedMode::InverseTime, 159.0, &whole, &half, 0.5).expect("a feed") - 318.0).abs() < 1e-12
    );
}
