use super::*;
use proptest::prelude::*;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, ImageCovariance, Observation, ObservationState};

const PERIOD_US: u64 = 16_667;
const START_US: u64 = 1_000_000;
const DELAY_US: u64 = 3_000;

/// A ball on a straight way at a steady speed, so that what is told between pictures is exact.
fn ball(at: usize, t_us: u64) -> Observation {
    let t = (t_us as f64 - START_US as f64) * 1e-6;
    let centre = ImagePoint::new((100.0 + 50.0 * at as f64 + 200.0 * t) as f32, (200.0 - 80.0 * t) as f32);
    Observation {
        state: ObservationState::Visible,
        centre,
        diameter: (20.0 + 3.0 * t) as f32,
        covariance: ImageCovariance { uu: 0.01, uv: 0.002, vv: 0.02 },
        visible: 1.0,
    }
}

fn sighting(capture_us: u64, received_us: u64) -> Sighting {
    let balls = std::array::from_fn(|at| ball(at, capture_us));
    Sighting { capture_us, ready_us: received_us.saturating_sub(500), received_us, balls, size: (640, 480) }
}

/// What comes: when, from which camera, taken when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Arrival {
    received_us: u64,
    camera: usize,
    capture_us: u64,
}

/// A camera's pictures from the start on.
fn film(camera: usize, offset_us: u64, period_us: u64, count: u64) -> impl Iterator<Item = Arrival> {
    (0..count).map(move |frame| {
        let capture_us = START_US + offset_us + frame * period_us;
        Arrival { received_us: capture_us + DELAY_US, camera, capture_us }
    })
}

/// Each instant, and when it went.
fn play(pairing: &mut Pairing, arrivals: impl IntoIterator<Item = Arrival>) -> Vec<(u64, Joined)> {
    let mut arrivals: Vec<Arrival> = arrivals.into_iter().collect();
    arrivals.sort();
    let mut went = Vec::new();
    for (at, arrival) in arrivals.iter().enumerate() {
        let now_us = arrival.received_us;
        pairing.take(arrival.camera, &sighting(arrival.capture_us, now_us));
        went.extend(pairing.next(now_us).map(|joined| (now_us, joined)));
        // as a station would: when somebody becomes late, though nothing came
        let next_us = arrivals.get(at + 1).map_or(now_us, |next| next.received_us);
        let mut now_us = now_us;
        while let Some(due_us) = pairing.due_us(now_us).filter(|&due_us| due_us < next_us) {
            now_us = due_us;
            went.extend(pairing.next(now_us).map(|joined| (now_us, joined)));
        }
    }
    for pair in went.windows(2) {
        assert!(pair[0].1.t_us < pair[1].1.t_us, "instants go back: {pair:?}");
    }
    went
}

fn two(offset_us: u64, count: u64) -> Vec<Arrival> {
    film(0, 0, PERIOD_US, count).chain(film(1, offset_us, PERIOD_US, count)).collect()
}

fn is_whole(joined: &Joined) -> bool {
    joined.views.iter().all(|view| view.source != Source::Missing)
}

/// Every ball that is told is where it was at the instant.
fn check_places(went: &[(u64, Joined)]) {
    for (_, joined) in went {
        for view in joined.views.iter().filter(|view| view.source != Source::Missing) {
            for (at, seen) in view.balls.iter().enumerate() {
                let truth = ball(at, joined.t_us);
                // what is taken together may be apart by 100 us: 0.02 px here
                assert!(seen.centre.distance(truth.centre) < 0.03, "{joined:?}");
                assert!((seen.diameter - truth.diameter).abs() < 0.01, "{joined:?}");
            }
        }
    }
}

#[test]
fn pictures_taken_together_are_paired_as_they_are() {
    for offset_us in [0, 1, 60, TOGETHER_US] {
        let went = play(&mut Pairing::new(2), two(offset_us, 50));
        let (first, rest) = went.split_first().unwrap();
        assert_eq!(first.1.views[1].source, Source::Missing, "nobody knows yet that another camera is there");
        assert!(rest.len() >= 48);
        for (now_us, joined) in rest {
            assert!(joined.views.iter().all(|view| view.source == Source::Seen), "{joined:?}");
            let expected = [joined.t_us, joined.t_us + offset_us].map(|t_us| sighting(t_us, 0).balls);
            assert_eq!(
                joined.views.iter().map(|view| view.balls).collect::<Vec<_>>(),
                expected,
                "bit for bit"
            );
            assert_eq!(*now_us, joined.t_us + offset_us + DELAY_US, "as soon as both were there");
            let stamps = [joined.first_us, joined.last_us, joined.ready_us];
            assert_eq!(stamps, [joined.t_us + DELAY_US, *now_us, now_us - 500]);
        }
    }
}

#[test]
fn one_instant_a_period_with_the_least_waiting() {
    for offset_us in (500..PERIOD_US).step_by(500) {
        let went = play(&mut Pairing::new(2), two(offset_us, 100));
        check_places(&went);
        let settled = &went[6..];
        assert!(settled.iter().all(|(_, joined)| is_whole(joined)));
        for pair in settled.windows(2) {
            assert_eq!(pair[1].1.t_us - pair[0].1.t_us, PERIOD_US, "{offset_us}");
        }
        let least_us = offset_us.min(PERIOD_US - offset_us);
        let (now_us, joined) = settled.last().unwrap();
        let waited_us = now_us - DELAY_US - joined.t_us;
        // near half a period either does, and the first stays
        let slack_us = if least_us > PERIOD_US * 3 / 8 { PERIOD_US / 8 } else { 0 };
        assert!(waited_us <= least_us + slack_us, "{offset_us}: {waited_us}");
        assert_eq!(joined.views.iter().filter(|view| view.source == Source::Seen).count(), 1);
    }
}

/// Two cameras on one trigger, and clocks that are compared to a few microseconds.
#[test]
fn which_of_two_that_go_together_is_first_makes_no_difference() {
    let shakes_us = [0_u64, 90, 10, 70, 95, 5, 60, 30];
    let arrivals = two(0, 200).into_iter().enumerate().map(|(at, arrival)| {
        let capture_us = arrival.capture_us + shakes_us[(at * 5) % 8];
        Arrival { capture_us, received_us: capture_us + DELAY_US, ..arrival }
    });
    let mut pairing = Pairing::new(2);
    let went = play(&mut pairing, arrivals);
    check_places(&went);
    assert!(went.len() >= 199, "{}", went.len());
    assert!(went[3..].iter().all(|(now_us, joined)| now_us - joined.t_us <= DELAY_US + 100));
    assert_eq!(pairing.counts().changes, 0);
}

/// They drift through each other, and every picture is used at once all the same.
#[test]
fn cameras_that_drift_through_each_other_lose_no_step() {
    let arrivals = film(0, 2_000, PERIOD_US, 400).chain(film(1, 0, PERIOD_US + 10, 400));
    let mut pairing = Pairing::new(2);
    let went = play(&mut pairing, arrivals);
    check_places(&went);
    assert!(went.len() >= 399, "{}", went.len());
    for (now_us, joined) in &went[4..] {
        assert!(is_whole(joined));
        assert!(now_us - joined.t_us <= DELAY_US + 2_100, "{joined:?}");
    }
    assert!(pairing.counts().changes <= 3, "{:?}", pairing.counts());
}

#[test]
fn eight_cameras_wait_for_all_but_the_widest_gap() {
    let offsets_us = [0, 1_000, 3_000, 3_050, 6_000, 7_000, 8_000, 9_000];
    let arrivals = offsets_us.iter().enumerate().flat_map(|(at, &us)| film(at, us, PERIOD_US, 60));
    let went = play(&mut Pairing::new(8), arrivals);
    check_places(&went);
    for (now_us, joined) in &went[10..] {
        assert!(is_whole(joined), "{joined:?}");
        assert_eq!(joined.reference, 0, "the one behind the gap");
        assert_eq!(now_us - DELAY_US - joined.t_us, 9_000);
    }
}

#[test]
fn cameras_of_different_rates_give_one_instant_for_each_picture_of_the_slower() {
    let arrivals = film(0, 0, 33_333, 60).chain(film(1, 4_000, PERIOD_US, 120));
    let went = play(&mut Pairing::new(2), arrivals);
    check_places(&went);
    assert!((57..=61).contains(&went.len()), "{}", went.len());
    assert!(went[6..].iter().all(|(_, joined)| is_whole(joined)));
}

#[test]
fn a_lost_packet_costs_one_step_at_most() {
    for lost in [0, 1] {
        let arrivals = two(4_000, 60).into_iter().enumerate();
        let kept = arrivals.filter(|(at, arrival)| !(arrival.camera == lost && at % 60 == 30));
        let went = play(&mut Pairing::new(2), kept.map(|(_, arrival)| arrival));
        check_places(&went);
        // the camera that follows closely is there again before anybody gives it up
        let without = went[3..].iter().filter(|(_, joined)| !is_whole(joined)).count();
        assert_eq!(without, usize::from(lost == 0));
        let steps = went.windows(2).map(|pair| pair[1].1.t_us - pair[0].1.t_us);
        assert!(steps.skip(3).all(|us| us <= 2 * PERIOD_US), "{lost}: no longer pause than the lost picture");
    }
}

#[test]
fn a_camera_that_is_gone_stalls_nothing_and_joins_when_it_is_back() {
    let (gone, back) = (30, 60);
    for offset_us in [0, 4_000, 8_000, 15_000] {
        let frame = |arrival: &Arrival| (arrival.capture_us - START_US) / PERIOD_US;
        let away = |arrival: &Arrival| arrival.camera == 1 && (gone..back).contains(&frame(arrival));
        let arrivals = two(offset_us, 90).into_iter().filter(|arrival| !away(arrival));
        let went = play(&mut Pairing::new(2), arrivals);
        check_places(&went);
        for pair in went.windows(2) {
            let pause_us = pair[1].0 - pair[0].0;
            assert!(pause_us <= (2.6 * PERIOD_US as f64) as u64, "{offset_us}: {pause_us} us without a step");
        }
        for (now_us, joined) in &went[3..] {
            let at = (joined.t_us - START_US) / PERIOD_US;
            let lost = joined.views[1].balls.iter().all(|ball| ball.state == ObservationState::Lost);
            match at {
                _ if at < gone - 1 => assert!(is_whole(joined), "{offset_us}, frame {at}"),
                _ if (gone + 2..back - 1).contains(&at) => {
                    assert!(lost && joined.views[0].source == Source::Seen, "{offset_us}, frame {at}");
                    assert!(at < gone + 3 || now_us - joined.t_us == DELAY_US, "nobody is waited for");
                }
                // its first picture is not around any instant yet
                _ if at > back + 2 => assert!(is_whole(joined), "{offset_us}, frame {at}"),
                _ => {}
            }
        }
    }
}

#[test]
fn a_camera_with_a_longer_way_is_waited_for_up_to_the_bound() {
    let later = |us: u64| {
        let late = film(1, 0, PERIOD_US, 90)
            .map(move |arrival| Arrival { received_us: arrival.received_us + us, ..arrival });
        let went = play(&mut Pairing::new(2), film(0, 0, PERIOD_US, 90).chain(late));
        went[40..].iter().filter(|(_, joined)| is_whole(joined)).count() as f64 / (went.len() - 40) as f64
    };
    assert_eq!(later(10_000), 1.0);
    assert_eq!(later(60_000), 1.0);
    assert_eq!(later(1_000_000), 0.0, "a pose alone and in time is better than one that is a second old");
}

#[test]
fn a_camera_that_was_never_there_is_lost_and_of_unknown_size() {
    let went = play(&mut Pairing::new(2), film(0, 0, PERIOD_US, 5));
    assert_eq!(went.len(), 5);
    assert!(went.iter().all(|(now_us, joined)| now_us - joined.t_us == DELAY_US));
    assert!(went.iter().all(|(_, joined)| joined.views[1].size.is_none()));
}

#[test]
fn what_is_old_or_of_nobody_is_left_out() {
    let mut pairing = Pairing::new(1);
    pairing.take(0, &sighting(START_US, START_US + 5));
    pairing.take(0, &sighting(START_US, START_US + 6));
    pairing.take(0, &sighting(START_US - 1, START_US + 7));
    pairing.take(1, &sighting(START_US + 9, START_US + 9));
    assert_eq!(pairing.counts().old, 3);
    assert_eq!(pairing.next(START_US + 10).unwrap().t_us, START_US);
    assert_eq!(pairing.next(START_US + 11), None, "once");
    // a clock that is wrong by an hour: no picture comes before it was taken
    pairing.take(0, &sighting(START_US + 3_600_000_000, START_US + 20));
    assert_eq!(pairing.next(START_US + 20).unwrap().t_us, START_US + 20);
}

#[test]
fn between_two_pictures_the_worse_state_counts_and_the_noise_is_weighed() {
    let (mut a, mut b) = (sighting(0, 0), sighting(10_000, 0));
    a.balls[0].state = ObservationState::Occluded;
    a.balls[0].visible = 0.5;
    b.balls[1].state = ObservationState::Predicted;
    (a.balls[2].state, b.balls[3].state) = (ObservationState::Lost, ObservationState::Lost);
    let balls = between(None, &a, &b, 2_500);
    let states = balls.map(|ball| ball.state);
    use ObservationState::{Lost, Occluded, Predicted};
    assert_eq!(states, [Occluded, Predicted, Lost, Lost]);
    assert_eq!(balls[0].visible, 0.5);
    let weight = 0.75_f32.powi(2) + 0.25_f32.powi(2);
    assert!((balls[0].covariance.uu - weight * 0.01).abs() < 1e-6);
    assert!((balls[0].covariance.uv - weight * 0.002).abs() < 1e-6);
    assert_eq!(balls[2].covariance, ImageCovariance::default());
    let quarter = a.balls[0].centre + (b.balls[0].centre - a.balls[0].centre) * 0.25;
    assert!(balls[0].centre.distance(quarter) < 1e-4);
}

#[test]
fn what_the_straight_way_leaves_out_is_in_the_covariance() {
    // 4,000 px/s² to the right
    let at = |t_us: u64| {
        let t = t_us as f32 * 1e-6;
        let mut sighting = sighting(t_us, 0);
        for ball in &mut sighting.balls {
            ball.centre = ImagePoint::new(100.0 + 2_000.0 * t * t, 50.0);
            ball.covariance = ImageCovariance::default();
        }
        sighting
    };
    let [first, second, third] = [20_000, 40_000, 60_000].map(at);
    let balls = between(Some(&first), &second, &third, 50_000);
    let off = balls[0].centre.u - at(50_000).balls[0].centre.u;
    assert!((off - 0.2).abs() < 1e-3, "{off}");
    assert!((balls[0].covariance.uu.sqrt() - off).abs() < 1e-3, "{:?}", balls[0].covariance);
    assert!(balls.iter().all(|ball| ball.covariance.is_valid()));
}

proptest! {
    /// Whatever the jitter, the losses and the phases: instants increase (`play` checks it), balls are
    /// where they were, and no step is older than the bound.
    #[test]
    fn jitter_and_loss_make_nothing_wrong(
        offset_us in 0..PERIOD_US,
        draws in proptest::collection::vec((0_u64..6_000, 0_u64..2_000, 0_u32..100), 160),
        loss in 0_u32..40,
    ) {
        let arrivals = two(offset_us, 80).into_iter().zip(draws).filter(|(_, (.., draw))| *draw >= loss);
        let arrivals: Vec<Arrival> = arrivals
            .map(|(arrival, (late_us, shake_us, _))| {
                let capture_us = arrival.capture_us + shake_us;
                Arrival { received_us: capture_us + DELAY_US + late_us, capture_us, ..arrival }
            })
            .collect();
        let mut pairing = Pairing::new(2);
        let went = play(&mut pairing, arrivals.iter().copied());
        check_places(&went);
        let counts = pairing.counts();
        prop_assert_eq!(counts.complete + counts.partial, went.len() as u64);
        for (now_us, joined) in &went {
            prop_assert_eq!(joined.views.len(), 2);
            for view in &joined.views {
                prop_assert_eq!(view.balls.len(), BALLS);
                prop_assert!(view.balls.iter().all(|ball| ball.covariance.is_valid()));
            }
            // learnt periods are of what came: up to some lost in a row
            prop_assert!(now_us - joined.t_us < 12 * PERIOD_US, "{} us old", now_us - joined.t_us);
        }
        if loss == 0 && went.len() > 20 {
            let whole = went[10..].iter().filter(|(_, joined)| is_whole(joined)).count();
            prop_assert!(whole == went.len() - 10, "{whole} of {}", went.len() - 10);
        }
    }
}
