//! Scallop heights against the printed formula in twice the digits, against the geometry itself, and against the table
//! and the trends of P3.

use trunnion::machine::Tool;
use trunnion::units::{Angle, Length};
use trunnion::wear::{
    ScallopFault, Surface, cutter_radius, effective_radius, largest_stepover, scallop_height,
    smallest_tool_radius,
};

use crate::double_double::Double2;

/// Values given to nine significant digits are met to half a unit of the last (relative).
const NINE_DIGITS: f64 = 5.5e-9;
/// What is stated of the height (relative).
const STATED: f64 = 1e-14;
/// What the printed formula may itself be off by in 106 bits for a case to count (relative).
const ORACLE: f64 = 1e-16;
/// One unit of the largest term of the printed formula in 106 bits (relative).
const ORACLE_UNIT: f64 = 1e-31;

fn mm(value: f64) -> Length {
    Length::from_mm(value)
}

/// k of the notation: 0 flat.
fn surface(k: i32, radius_mm: f64) -> Surface {
    match k {
        1 => Surface::Convex { radius: mm(radius_mm) },
        -1 => Surface::Concave { radius: mm(radius_mm) },
        _ => Surface::Flat,
    }
}

fn height_mm(stepover_mm: f64, tool_mm: f64, surface: Surface) -> f64 {
    scallop_height(mm(stepover_mm), mm(tool_mm), surface).expect("a scallop").mm()
}

/// P3 eq. (4) as printed, in 106 bits; for k = 0 its limit.
fn printed(k: i32, d: f64, r: f64, rs: f64) -> f64 {
    let [d, r, rs, one, two, four] = [d, r, rs, f64::from(k), 2.0, 4.0].map(Double2::from);
    let h = if k == 0 {
        r - (r * r - d * d / four).sqrt()
    } else {
        let a = rs + one * r;
        one * a * (four * rs * rs - d * d).sqrt() / (two * rs)
            - (r * r - d * d * a * a / (four * rs * rs)).sqrt()
            - one * rs
    };
    h.0 + h.1
}

/// A repeatable stream of numbers in [0, 1).
fn stream() -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) * 2.0_f64.powi(-53)
    }
}

fn close(value: f64, expected: f64, relative: f64) {
    let off = (value - expected).abs() / expected.abs();
    assert!(off <= relative, "{value} is not {expected}: off by {off:e}");
}

#[test]
fn the_values_of_the_table_are_met() {
    for (k, height, stepover) in [
        (0, 2.500_062_50e-4, 0.893_532_316),
        (1, 3.750_304_72e-4, 0.728_716_609),
        (-1, 1.250_007_81e-4, 1.264_278_45),
    ] {
        close(height_mm(0.1, 5.0, surface(k, 10.0)), height, NINE_DIGITS);
        let largest = largest_stepover(mm(0.02), mm(5.0), surface(k, 10.0)).expect("a step-over");
        close(largest.mm(), stepover, NINE_DIGITS);
    }
}

#[test]
fn the_height_keeps_fourteen_digits_of_the_printed_formula() {
    let mut next = stream();
    let (mut counted, mut near_limit, mut worst) = ([0_u32; 3], 0_u32, 0.0_f64);
    for attempt in 0..300_000_usize {
        let k = [0, 1, -1][attempt % 3];
        let r = 10.0_f64.powf(-2.0 + 4.0 * next());
        let rs = if k < 0 {
            // from a whisker above the tool to ten thousand times it
            r * (1.0 + 10.0_f64.powf(-6.0 + 10.0 * next()))
        } else {
            r * 10.0_f64.powf(-4.0 + 8.0 * next())
        };
        let a = rs + f64::from(k) * r;
        let widest = if k == 0 { 2.0 * r } else { 2.0 * rs * (r / a).min(1.0) };
        // half of them over all decades, half up to where passes meet
        let d = widest * if next() < 0.5 { 10.0_f64.powf(-7.0 * next()) } else { next() };
        let w = if k == 0 { 0.5 * d } else { d / (2.0 * rs) * a };
        let expected = printed(k, d, r, rs);
        let largest_term = if k == 0 { r } else { r.max(rs) };
        if w > (1.0 - 1e-12) * r || ORACLE_UNIT * largest_term > ORACLE * expected {
            continue;
        }
        counted[attempt % 3] += 1;
        near_limit += u32::from(w > 0.9 * r);
        let off = (height_mm(d, r, surface(k, rs)) / expected - 1.0).abs();
        worst = worst.max(off);
        assert!(off <= STATED, "k {k} D {d} r {r} Rs {rs}: off by {off:e}");
    }
    println!("{counted:?} compared, {near_limit} near the limit, worst {worst:e}");
    assert!(counted.iter().all(|count| *count > 50_000) && near_limit > 10_000, "{counted:?} {near_limit}");
    assert!(worst > 1e-16, "nothing was compared");
}

#[test]
fn at_a_micrometre_the_printed_form_loses_what_the_stable_one_keeps() {
    let (d, r, rs): (f64, f64, f64) = (0.001, 5.0, 10.0);
    let naive = (rs + r) * (4.0 * rs * rs - d * d).sqrt() / (2.0 * rs)
        - (r * r - d * d * (rs + r).powi(2) / (4.0 * rs * rs)).sqrt()
        - rs;
    let expected = printed(1, d, r, rs);
    assert!((naive / expected - 1.0).abs() > 1e-9);
    close(height_mm(d, r, surface(1, rs)), expected, STATED);
}

#[test]
fn where_passes_just_meet_no_digit_is_lost() {
    let r = 5.0;
    for k in [0, 1, -1] {
        for share in [1e-3, 1e-6, 1e-9, 1e-12, 0.0] {
            for rs in [12.0, if k < 0 { 10.0 } else { 1e-3 }] {
                let a = if k == 0 { rs } else { rs + f64::from(k) * r };
                let d = 2.0 * r * (1.0 - share) * if k == 0 { 1.0 } else { rs / a };
                let off = (height_mm(d, r, surface(k, rs)) / printed(k, d, r, rs) - 1.0).abs();
                // The limit itself moves by a rounding of D: there the height changes by its root.
                let allowed = if share == 0.0 { 4.0 * f64::EPSILON.sqrt() } else { STATED };
                assert!(off <= allowed, "k {k} Rs {rs} share {share}: {off:e}");
            }
        }
    }
}

/// The height by bisection: the lowest point above the surface, on the normal half way between two balls, that neither
/// ball has cut.
fn by_bisection(k: i32, d: f64, r: f64, rs: f64) -> f64 {
    // the ball's centre in the plane across the feed; the surface's point half way is the origin, its normal +y
    let (x, y) = if k == 0 {
        (0.5 * d, r)
    } else {
        let (sine, one) = (d / (2.0 * rs), f64::from(k));
        let a = rs + one * r;
        // the surface's centre stands at (0, −k·Rs)
        (sine * a, one * (a * (1.0 - sine * sine).sqrt() - rs))
    };
    let (mut uncut, mut cut) = (0.0, y);
    for _ in 0..200 {
        let middle = 0.5 * (uncut + cut);
        if x.hypot(y - middle) < r { cut = middle } else { uncut = middle }
    }
    uncut
}

/// The bisection's own rounding: distances of tens of millimetres [mm].
const BISECTION_MM: f64 = 1e-12;

#[test]
fn the_height_is_where_two_balls_meet() {
    let mut next = stream();
    for attempt in 0..2000_usize {
        let k = [0, 1, -1][attempt % 3];
        let r = 1.0 + 9.0 * next();
        let rs = r * (1.1 + 3.0 * next());
        let a = rs + f64::from(k) * r;
        let widest = if k == 0 { 2.0 * r } else { 2.0 * rs * (r / a).min(1.0) };
        let d = 0.9 * next() * widest;
        let found = height_mm(d, r, surface(k, rs));
        let expected = by_bisection(k, d, r, rs);
        assert!((found - expected).abs() < BISECTION_MM, "k {k} D {d} r {r} Rs {rs}: {found} {expected}");
    }
}

/// 1/r between 4 and 5 bows from its chord by 5.6 % of its change.
const NEARLY_LINEAR: f64 = 0.06;

#[test]
fn p3_figure_4_has_its_trends() {
    let surfaces: Vec<f64> = (1..=10_u32).map(|tens| 10.0 * f64::from(tens)).collect();
    let radii: Vec<f64> = (0..=10_u32).map(|k| 4.0 + 0.1 * f64::from(k)).collect();
    for k in [1, -1] {
        for rs in &surfaces {
            let heights: Vec<f64> = radii.iter().map(|r| height_mm(0.1, *r, surface(k, *rs))).collect();
            // 1) the smaller the tool the higher, and nearly along a line
            assert!(heights.windows(2).all(|pair| pair[1] < pair[0]));
            let (first, last) = (heights[0], heights[10]);
            for (j, height) in heights.iter().enumerate() {
                let line = first + (last - first) * j as f64 / 10.0;
                assert!((height - line).abs() < NEARLY_LINEAR * (first - last).abs(), "{rs} {j}");
            }
        }
        // 2) convex: falls as the surface gets flatter, 3) concave: rises; both toward the plane
        for r in &radii {
            let heights: Vec<f64> = surfaces.iter().map(|rs| height_mm(0.1, *r, surface(k, *rs))).collect();
            let plane = height_mm(0.1, *r, Surface::Flat);
            assert!(heights.windows(2).all(|pair| f64::from(k) * (pair[0] - pair[1]) > 0.0));
            assert!(heights.iter().all(|height| f64::from(k) * (height - plane) > 0.0));
        }
    }
}

#[test]
fn the_cusp_of_a_worn_ball_grows_as_the_curvatures_say() {
    // h′/h = (1/r′ + k/Rs)/(1/r + k/Rs) to first order in D²
    for (k, rs) in [(0, 1.0), (1, 40.0), (-1, 40.0)] {
        let curvature = f64::from(k) / rs;
        let grown = (1.0 / 4.0 + curvature) / (1.0 / 5.0 + curvature);
        close(height_mm(0.01, 4.0, surface(k, rs)) / height_mm(0.01, 5.0, surface(k, rs)), grown, 1e-5);
    }
    close(height_mm(0.01, 4.0, Surface::Flat) / height_mm(0.01, 5.0, Surface::Flat), 1.25, 1e-5);
}

/// An inverse and the height pass through some tens of roundings, magnified up to where passes meet (relative).
const ROUND_TRIP: f64 = 1e-12;

#[test]
fn the_inverses_undo_the_height() {
    let mut next = stream();
    let mut counted = 0;
    for attempt in 0..50_000_usize {
        let k = [0, 1, -1][attempt % 3];
        let r = 10.0_f64.powf(-1.0 + 2.0 * next());
        let rs = r * if k < 0 { 1.05 + 10.0 * next() } else { 0.2 + 10.0 * next() };
        let a = rs + f64::from(k) * r;
        let widest = if k == 0 { 2.0 * r } else { 2.0 * rs * (r / a).min(1.0) };
        let d = widest * (0.001 + 0.949 * next());
        let shape = surface(k, rs);
        let h = scallop_height(mm(d), mm(r), shape).expect("a scallop");
        close(largest_stepover(h, mm(r), shape).expect("a step-over").mm(), d, ROUND_TRIP);
        let least = smallest_tool_radius(h, mm(d), shape).expect("a radius").expect("a tool").mm();
        // the radius follows from differences: its own condition is r/h
        close(least, r, ROUND_TRIP.max(8.0 * f64::EPSILON * r / h.mm()));
        // the answers may be asked again
        height_mm(largest_stepover(h, mm(r), shape).expect("a step-over").mm(), r, shape);
        counted += 1;
    }
    assert_eq!(counted, 50_000);
}

#[test]
fn beyond_the_highest_scallop_the_inverses_stop_where_passes_meet() {
    let high = mm(100.0);
    let widest = |r, shape| largest_stepover(high, mm(r), shape).expect("a step-over").mm();
    close(widest(5.0, Surface::Flat), 10.0, STATED);
    close(widest(5.0, surface(1, 10.0)), 2.0 * 10.0 * 5.0 / 15.0, STATED);
    close(widest(5.0, surface(-1, 15.0)), 2.0 * 15.0 * 5.0 / 10.0, STATED);
    close(widest(5.0, surface(-1, 8.0)), 16.0, STATED);
    for (r, shape) in
        [(5.0, Surface::Flat), (5.0, surface(1, 10.0)), (5.0, surface(-1, 15.0)), (5.0, surface(-1, 8.0))]
    {
        let highest = height_mm(widest(r, shape), r, shape);
        assert!(highest.is_finite() && highest > 0.0);
        let just_below = largest_stepover(mm(highest * 0.999_999), mm(r), shape).expect("a step-over").mm();
        assert!(just_below < widest(r, shape) && just_below > 0.99 * widest(r, shape), "{just_below}");
    }
    let least = |d, shape| smallest_tool_radius(high, mm(d), shape).expect("a radius").map(Length::mm);
    close(least(1.0, Surface::Flat).expect("a tool"), 0.5, STATED);
    close(least(1.0, surface(1, 10.0)).expect("a tool"), 0.5 / 0.95, STATED);
    close(least(1.0, surface(-1, 10.0)).expect("a tool"), 0.5 / 1.05, STATED);
    height_mm(1.0, 0.5 / 0.95, surface(1, 10.0));
}

#[test]
fn where_no_tool_is_large_enough_there_is_none() {
    let none = |h, d, shape| smallest_tool_radius(mm(h), mm(d), shape).expect("an answer").is_none();
    // Even a plane tool leaves Rs·(1/c − 1) above a convex surface.
    let (rs, d): (f64, f64) = (10.0, 1.0);
    let plane_tool = rs * (1.0 / (1.0 - (d / (2.0 * rs)).powi(2)).sqrt() - 1.0);
    assert!(none(plane_tool * 0.999, d, surface(1, rs)));
    assert!(!none(plane_tool * 1.001, d, surface(1, rs)));
    assert!(none(1.0, 20.0, surface(1, 10.0)));
    assert!(none(0.0, 1.0, Surface::Flat));
    assert!(none(1e-300, 1.0, Surface::Flat));
    // A ball of the surface's own radius leaves nothing in a hollow.
    let hollow = smallest_tool_radius(mm(0.0), mm(1.0), surface(-1, 10.0)).expect("an answer");
    close(hollow.expect("a tool").mm(), 10.0, STATED);
    assert!(height_mm(1.0, 10.0, surface(-1, 10.0)).abs() < 1e-300);
}

#[test]
fn what_cannot_be_cut_is_refused_with_its_bound() {
    let fault = |d, r, shape| scallop_height(mm(d), mm(r), shape).expect_err("a refusal");
    for (d, r, shape, bound) in [
        (10.1, 5.0, Surface::Flat, 10.0),
        (7.0, 5.0, surface(1, 10.0), 2.0 * 10.0 * 5.0 / 15.0),
        (15.5, 5.0, surface(-1, 15.0), 15.0),
    ] {
        let ScallopFault::PassesDoNotMeet { max_stepover_mm, .. } = fault(d, r, shape) else {
            panic!("{d} {r} {shape:?}: {}", fault(d, r, shape))
        };
        close(max_stepover_mm, bound, STATED);
        assert!(fault(d, r, shape).to_string().contains(&max_stepover_mm.to_string()));
    }
    assert!(
        matches!(fault(16.1, 5.0, surface(-1, 8.0)), ScallopFault::NoChord { max_stepover_mm, .. } if (max_stepover_mm - 16.0).abs() < 1e-12)
    );
    assert!(matches!(fault(1.0, 5.0, surface(-1, 4.9)), ScallopFault::Gouge { .. }));
    for (d, r, shape) in [
        (-0.1, 5.0, Surface::Flat),
        (f64::NAN, 5.0, Surface::Flat),
        (f64::INFINITY, 5.0, Surface::Flat),
        (0.1, 0.0, Surface::Flat),
        (0.1, -1.0, surface(1, 10.0)),
        (0.1, f64::NAN, surface(1, 10.0)),
        (0.1, 5.0, surface(1, 0.0)),
        (0.1, 5.0, surface(-1, -10.0)),
        (0.1, 5.0, surface(1, f64::INFINITY)),
    ] {
        assert!(matches!(fault(d, r, shape), ScallopFault::OutOfRange { .. }), "{d} {r} {shape:?}");
    }
    assert!(largest_stepover(mm(-1.0), mm(5.0), Surface::Flat).is_err());
    assert!(largest_stepover(mm(0.1), mm(5.0), surface(-1, 4.0)).is_err());
    assert!(smallest_tool_radius(mm(0.1), mm(21.0), surface(-1, 10.0)).is_err());
}

#[test]
fn an_inclined_cutter_cuts_with_its_effective_radius() {
    let tool = |radius, corner| Tool::new(mm(radius), mm(corner)).expect("a tool");
    let at = |tool: Tool, lead_deg| effective_radius(&tool, Angle::from_deg(lead_deg));
    close(at(tool(5.0, 1.0), 30.0).expect("a radius").mm(), 1.0 + 4.0 / 0.5, STATED);
    close(at(tool(5.0, 0.0), 90.0).expect("a radius").mm(), 5.0, STATED);
    close(at(tool(5.0, 5.0), 0.0).expect("a ball has its own").mm(), 5.0, STATED);
    for lead_deg in [0.0, -3.0, 90.1, f64::NAN] {
        assert!(at(tool(5.0, 1.0), lead_deg).is_err(), "{lead_deg}");
    }
    let back = cutter_radius(mm(9.0), mm(1.0), Angle::from_deg(30.0)).expect("a cutter");
    close(back.mm(), 5.0, STATED);
    close(cutter_radius(mm(0.5), mm(1.0), Angle::from_deg(30.0)).expect("a ball").mm(), 1.0, STATED);
}
