use proptest::prelude::*;

use super::*;
use crate::machine::{Preset, RotaryLetter};

fn machine(id: &str, travels: [Option<[f64; 2]>; 2], rule: PlaneRule, axis: Option<RotaryLetter>) -> Machine {
    let mut parts = Preset::by_id(id).unwrap().parts();
    for (axis, travel) in parts.rotary_axes.iter_mut().zip(travels) {
        axis.travel_deg = travel.map(|[min, max]| Travel { min, max });
    }
    Machine::new(parts).unwrap().with_plane_solution(Some(PlaneSolution { rule, axis }))
}

/// The direction of a plane that is turned about Y by this angle.
fn about_y(deg: f64) -> [f64; 3] {
    [deg.to_radians().sin(), 0.0, deg.to_radians().cos()]
}

fn seq(positive: bool) -> PlaneWish {
    PlaneWish { side: Some(PlaneSide { positive, or_other: false }), ..PlaneWish::default() }
}

fn is_near(found: Option<[f64; 2]>, wanted: Option<[f64; 2]>) -> bool {
    match (found, wanted) {
        (Some(found), Some(wanted)) => found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9),
        (None, None) => true,
        _ => false,
    }
}

/// The table in a manual for conversational controls: a table C on a tilting table A, and `PLANE SPATIAL SPA+0 SPB+45
/// SPC+0`. It takes +45 where both ways are the same; here the rule does not decide that.
#[test]
fn the_positions_are_those_of_the_manual() {
    let none = PlaneWish::default();
    let rows = [
        (None, [0.0, 0.0], none, None),
        (None, [0.0, 0.0], seq(true), Some([45.0, 90.0])),
        (None, [0.0, 0.0], seq(false), Some([-45.0, -90.0])),
        (None, [0.0, -105.0], none, Some([-45.0, -90.0])),
        (None, [0.0, -105.0], seq(true), Some([45.0, 90.0])),
        (None, [0.0, -105.0], seq(false), Some([-45.0, -90.0])),
        (Some([-90.0, 10.0]), [0.0, 0.0], none, Some([-45.0, -90.0])),
        (Some([-90.0, 10.0]), [0.0, 0.0], seq(true), None),
        (None, [0.0, -135.0], seq(true), Some([45.0, 90.0])),
    ];
    for (travel, from, wish, expected) in rows {
        let machine = machine("ac-table", [travel, None], PlaneRule::Shortest, None);
        let axes = PlaneAxes::of(&machine.with_plane_solution(Some(PlaneSolution {
            rule: PlaneRule::Shortest,
            axis: wish.side.map(|_| RotaryLetter::A),
        })))
        .unwrap();
        let mut found = axes.choose(about_y(45.0), from.map(Some), wish);
        // The manual writes C+90 for the same place a turn further.
        if let Some([_, c]) = &mut found {
            *c = principal_deg(*c);
        }
        assert!(is_near(found, expected), "{travel:?} {from:?} {wish:?}: {found:?}");
    }
}

#[test]
fn a_rule_decides_by_its_axis_and_nothing_is_chosen_where_it_does_not() {
    let normal = about_y(30.0);
    let any = [None; 2];
    let choose = |rule, axis, from| {
        PlaneAxes::of(&machine("ac-table", [Some([-120.0, 120.0]), None], rule, axis)).unwrap().choose(
            normal,
            from,
            PlaneWish::default(),
        )
    };
    let (a, c) = (Some(RotaryLetter::A), Some(RotaryLetter::C));
    let [up, down] = [Some([30.0, 90.0]), Some([-30.0, -90.0])];
    assert!(is_near(choose(PlaneRule::PositiveFirst, a, any), up));
    assert!(is_near(choose(PlaneRule::NegativeFirst, a, any), down));
    assert!(is_near(choose(PlaneRule::PositiveFirst, c, any), up));
    assert!(is_near(choose(PlaneRule::NegativeFirst, None, any), down));
    // The way is not known, or both ways are the same, or one axis goes farther and the other less far.
    assert_eq!(choose(PlaneRule::Shortest, None, any), None);
    assert_eq!(choose(PlaneRule::Shortest, None, [Some(0.0), Some(0.0)]), None);
    assert_eq!(choose(PlaneRule::Shortest, None, [Some(10.0), Some(-80.0)]), None);
    assert!(is_near(choose(PlaneRule::Shortest, a, [Some(10.0), Some(-80.0)]), up));
    assert!(is_near(choose(PlaneRule::Shortest, c, [Some(10.0), Some(-80.0)]), down));
    assert!(is_near(choose(PlaneRule::Shortest, None, [Some(0.0), Some(400.0)]), Some([30.0, 450.0])));
    // Half a turn of an axis without limits leads to one place.
    assert!(is_near(choose(PlaneRule::PositiveFirst, a, [Some(0.0), Some(-90.0)]), Some([30.0, 90.0])));
}

#[test]
fn a_plane_across_the_axis_next_to_the_workpiece_leaves_it_where_it_is_or_is_not_chosen() {
    let up = [0.0, 0.0, 1.0];
    let of = |rule| PlaneAxes::of(&machine("ac-table", [None; 2], rule, Some(RotaryLetter::A))).unwrap();
    let stays = PlaneWish { free_axis: FreeAxis::Stays, ..PlaneWish::default() };
    let unknown = PlaneWish { free_axis: FreeAxis::Unknown, ..PlaneWish::default() };
    let from = [Some(20.0), Some(70.0)];
    assert!(is_near(of(PlaneRule::Shortest).choose(up, from, PlaneWish::default()), Some([0.0, 70.0])));
    assert!(is_near(of(PlaneRule::PositiveFirst).choose(up, from, stays), Some([0.0, 70.0])));
    assert_eq!(of(PlaneRule::PositiveFirst).choose(up, from, PlaneWish::default()), None);
    assert_eq!(of(PlaneRule::Shortest).choose(up, from, unknown), None);
    assert_eq!(of(PlaneRule::Shortest).choose(up, from, seq(true)), None);
    assert_eq!(of(PlaneRule::Shortest).choose(up, [None; 2], PlaneWish::default()), None);
    assert_eq!(of(PlaneRule::Shortest).choose([1e-10, 0.0, 1.0], from, PlaneWish::default()), None);
}

#[test]
fn an_axis_with_several_turns_has_no_sign_and_a_side_that_only_prefers_needs_limits() {
    let wound = machine(
        "ac-head",
        [Some([-360.0, 360.0]), Some([-110.0, 110.0])],
        PlaneRule::PositiveFirst,
        Some(RotaryLetter::C),
    );
    let axes = PlaneAxes::of(&wound).unwrap();
    assert_eq!(axes.choose(about_y(30.0), [Some(0.0); 2], PlaneWish::default()), None);
    let prefer =
        |positive| PlaneWish { side: Some(PlaneSide { positive, or_other: true }), ..PlaneWish::default() };
    let limited =
        machine("ac-table", [Some([-30.0, 120.0]), None], PlaneRule::Shortest, Some(RotaryLetter::A));
    let axes = PlaneAxes::of(&limited).unwrap();
    assert!(is_near(axes.choose(about_y(20.0), [Some(0.0); 2], prefer(false)), Some([-20.0, -90.0])));
    // The travel has no such position on the negative side.
    assert!(is_near(axes.choose(about_y(40.0), [Some(0.0); 2], prefer(false)), Some([40.0, 90.0])));
    assert_eq!(axes.choose(about_y(40.0), [Some(0.0); 2], seq(false)), None);
    let unlimited = machine("ac-table", [None; 2], PlaneRule::Shortest, Some(RotaryLetter::A));
    assert_eq!(PlaneAxes::of(&unlimited).unwrap().choose(about_y(20.0), [Some(0.0); 2], prefer(true)), None);
}

proptest! {
    /// On every layout of machine, what is chosen points the tool along the normal and lies within travel.
    #[test]
    fn the_chosen_words_point_the_tool_along_the_normal(
        preset in prop::sample::select(crate::machine::PRESETS.to_vec()),
        rule in prop::sample::select(vec![PlaneRule::PositiveFirst, PlaneRule::NegativeFirst, PlaneRule::Shortest]),
        named in prop::option::of(0_usize..2),
        normal in prop::array::uniform3(-1.0_f64..1.0),
        from in prop::array::uniform2(prop::option::of(-100.0_f64..100.0)),
        side in prop::option::of((any::<bool>(), any::<bool>())),
    ) {
        let normal = Vec3::from(normal);
        prop_assume!(normal.norm() > 0.1);
        let normal = normal.normalize();
        let machine = Machine::new(preset.parts()).unwrap();
        let axis = named.map(|k| machine.rotary_axes()[k].letter);
        let machine = machine.with_plane_solution(Some(PlaneSolution { rule, axis }));
        let side = side.map(|(positive, or_other)| PlaneSide { positive, or_other });
        let wish = PlaneWish { side, ..PlaneWish::default() };
        let Some(words) = PlaneAxes::of(&machine).unwrap().choose(normal.into(), from, wish) else { return Ok(()) };
        let axes = machine.rotary_axes();
        let rad = [0, 1].map(|k| axes[k].angle_rad(words[k]));
        let points = Kinematics::new(&machine, &Setup { apply_errors: false, ..Setup::default() }).axis(rad);
        prop_assert!((points - normal).norm() < 1e-8, "{words:?}");
        for k in 0..2 {
            prop_assert!(axes[k].travel_deg.is_none_or(|travel| travel.contains(words[k], 1e-6)));
        }
    }
}
