//! Stepping in blocks, wherever it is cut and whatever the processor, against one step after the other; what a trace
//! keeps.

use proptest::prelude::*;
use trunnion::kinematics::InstructionSet;
use trunnion::servo::{
    AxisServo, Drive, DrivePreset, Feedback, Resonance, StateSpace, Step, Trace, TracePoint, stable_poles,
};

/// Blocks of steps against single steps, of the largest position: rounding of sums of 13 or 15 terms.
const RELATIVE: f64 = 1e-13;
/// The same with acceleration feed-forward, whose states carry the command itself at some 1e4 times its size (A B2 r),
/// which cancels but for its rounding: nanometres in half a metre.
const RELATIVE_WITH_BLOWS: f64 = 1e-11;
/// Samples of a block of the stepping.
const BLOCK: usize = 8;
const PERIODS_S: [f64; 4] = [1e-5, 2.5e-4, 1e-3, 1e-2];

/// Stable drives of every kind: rigid, with a filter, of two masses; both feedbacks, feed-forward, load.
fn any_drive() -> impl Strategy<Value = Drive> {
    let reference = DrivePreset::by_id("reference-linear").expect("a preset").drive;
    (
        (5.0..200.0, 0.3..3.0, 0.3..3.0),
        (0..3_u32, 20.0..300.0, 0.02..0.5, any::<bool>()),
        (0.0..1.2, prop_oneof![Just(0.0), 0.0..1.2], -3.0..3.0),
    )
        .prop_map(move |((gain, inertia, integral), (kind, frequency_hz, damping_ratio, motor), feeds)| {
            Drive {
                position_gain_per_s: gain,
                inertia_kg_m2: reference.inertia_kg_m2 * inertia,
                velocity_integral_time_s: reference.velocity_integral_time_s * integral,
                load_inertia_kg_m2: (kind == 2).then_some(reference.inertia_kg_m2 * 0.4),
                resonance: (kind > 0).then_some(Resonance { frequency_hz, damping_ratio }),
                feedback: if motor { Feedback::Motor } else { Feedback::Load },
                velocity_feedforward: feeds.0,
                acceleration_feedforward: feeds.1,
                load_torque_nm: feeds.2,
                ..reference
            }
        })
        .prop_filter("stable", |drive| stable_poles(drive).is_ok())
}

/// Where the command is told to be: on from the last sample, and now and then far away.
fn command() -> impl Strategy<Value = Vec<f64>> {
    let step = prop_oneof![9 => -0.1..0.1, 1 => -20.0..20.0];
    (-500.0..500.0, proptest::collection::vec(step, 1..400)).prop_map(|(start, steps): (f64, Vec<f64>)| {
        steps
            .iter()
            .scan(start, |at, step| {
                *at += step;
                Some(*at)
            })
            .collect()
    })
}

fn in_one_go(drive: &Drive, period_s: f64, command: &[f64], set: InstructionSet) -> Vec<f64> {
    let mut positions = Vec::new();
    let servo = AxisServo::new(drive, period_s, command[0]).expect("a step");
    servo.with_instructions(set).follow(command, &mut positions);
    positions
}

fn cut_at(drive: &Drive, period_s: f64, command: &[f64], cuts: &[usize]) -> Vec<f64> {
    let mut servo = AxisServo::new(drive, period_s, command[0]).expect("a step");
    let (mut all, mut piece, mut from) = (Vec::new(), Vec::new(), 0);
    for &cut in cuts.iter().chain([&command.len()]) {
        let to = cut.clamp(from, command.len());
        servo.follow(&command[from..to], &mut piece);
        all.extend_from_slice(&piece);
        from = to;
    }
    all
}

fn step_by_step(drive: &Drive, period_s: f64, command: &[f64]) -> Vec<f64> {
    let system = StateSpace::of(drive);
    let step = Step::new(&system, period_s).expect("a step");
    let mut state = system.at_rest(command[0]);
    let mut old = command[0];
    let one = |&new: &f64| {
        state = step.advance(&state, old, new);
        old = new;
        state[step.output]
    };
    command.iter().map(one).collect()
}

fn relative(drive: &Drive) -> f64 {
    if drive.acceleration_feedforward > 0.0 { RELATIVE_WITH_BLOWS } else { RELATIVE }
}

/// Largest difference over the largest size.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, v| most.max(v.abs()));
    let off = largest(&mut found.iter().zip(expected).map(|(a, b)| a - b));
    off / largest(&mut expected.iter().copied()).max(1.0)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn blocks_of_steps_are_the_steps_one_by_one(
        drive in any_drive(), period in 0..PERIODS_S.len(), command in command(),
    ) {
        let period_s = PERIODS_S[period];
        let found = in_one_go(&drive, period_s, &command, InstructionSet::Fastest);
        let off = apart(&found, &step_by_step(&drive, period_s, &command));
        prop_assert!(off <= relative(&drive), "off by {off:e}");
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits(
        drive in any_drive(), period in 0..PERIODS_S.len(), command in command(),
    ) {
        let with = |set| bits(&in_one_go(&drive, PERIODS_S[period], &command, set));
        let plain = with(InstructionSet::Baseline);
        for set in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Fastest] {
            prop_assert_eq!(&with(set), &plain, "{:?}", set);
        }
    }

    #[test]
    fn a_run_may_be_cut_anywhere(
        drive in any_drive(), period in 0..PERIODS_S.len(), command in command(),
        mut cuts in proptest::collection::vec(0..400_usize, 0..6),
    ) {
        cuts.sort_unstable();
        let period_s = PERIODS_S[period];
        let whole = in_one_go(&drive, period_s, &command, InstructionSet::Fastest);
        let off = apart(&cut_at(&drive, period_s, &command, &cuts), &whole);
        prop_assert!(off <= relative(&drive), "off by {off:e} when cut at {cuts:?}");
        let at_blocks: Vec<usize> = cuts.iter().map(|cut| cut / BLOCK * BLOCK).collect();
        prop_assert_eq!(bits(&cut_at(&drive, period_s, &command, &at_blocks)), bits(&whole));
    }

    #[test]
    fn a_trace_keeps_its_worst_point_in_at_most_2000(
        samples in prop_oneof![0..60_usize, 1900..2100_usize, 3900..4100_usize, 0..30_000_usize],
        worst in any::<prop::sample::Index>(), seed in any::<u64>(), sign in prop_oneof![Just(-1.0), Just(1.0)],
    ) {
        let worst = (samples > 0).then(|| worst.index(samples));
        let mut trace = Trace::new();
        for k in 0..samples {
            // Anything below 1, the same for the same seed.
            let noise = ((k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(seed) >> 11) as f64 * 2_f64.powi(-53);
            let contour_mm = if Some(k) == worst { 2.0 * sign } else { 0.999 * noise };
            trace.take(TracePoint {
                time_s: k as f64, line: k as u64, phi_rad: 0.0, contour_mm, axis_rad: 0.0, following: [0.0; 5],
            });
        }
        let points = trace.into_points();
        prop_assert!(points.len() <= Trace::MAX_POINTS, "{}", points.len());
        // Each point stands for the samples since the one before: none is lost, and half of the room is used.
        prop_assert!(points.len() >= samples.min(Trace::MAX_POINTS / 2), "{} of {samples}", points.len());
        prop_assert!(points.windows(2).all(|pair| pair[0].time_s < pair[1].time_s), "out of order");
        let kept = points.iter().find(|point| point.contour_mm.abs() > 1.0);
        prop_assert_eq!(kept.map(|point| point.line), worst.map(|k| k as u64));
    }
}
