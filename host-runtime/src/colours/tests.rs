use super::*;
use proptest::prelude::*;

const RED: &str = "\
[red]
reference = [203, 41, 52]
typical = [198, 44, 55]
background = [120, 118, 110]
diameter_px = 16.5
";

fn problem(text: &str) -> ColoursError {
    Colours::parse(text, "colours.toml").unwrap_err()
}

#[test]
fn a_file_with_one_ball_is_read() {
    let colours = Colours::parse(RED, "colours.toml").unwrap();
    let BallColours { learnt: red, at } = colours.balls[0].unwrap();
    assert_eq!(red.reference.reference, Rgb::new(203, 41, 52));
    assert_eq!(red.reference.typical, Rgb::new(198, 44, 55));
    assert_eq!(red.reference.background, Rgb::new(120, 118, 110));
    assert_eq!(red.reference.primary, Primary::Red);
    assert_eq!((red.diameter, red.aspect, at), (16.5, 1.0, None));
    assert_eq!(colours.balls[1..], [None; 3]);
    assert_eq!(colours.origin, None);
}

#[test]
fn every_bad_value_is_named_by_file_and_key() {
    let cases = [
        ("typical = [198, 44, 55]", "typical = [nan, 44, 55]", "[red] typical", "0 to 255"),
        ("typical = [198, 44, 55]", "typical = [198, 44, 256]", "[red] typical", "0 to 255"),
        ("typical = [198, 44, 55]", "typical = [-1, 44, 55]", "[red] typical", "0 to 255"),
        ("typical = [198, 44, 55]", "typical = [198, 44]", "[red] typical", "three whole numbers"),
        ("typical = [198, 44, 55]", "typical = 7", "[red] typical", "three whole numbers"),
        ("typical = [198, 44, 55]", "", "[red] typical", "missing"),
        ("typical = [198, 44, 55]", "typical = [120, 118, 110]", "[red] typical", "equals background"),
        ("typical = [198, 44, 55]", "typical = [20, 218, 110]", "[red] typical", "no better"),
        ("16.5", "nan", "[red] diameter_px", "3 to 128"),
        ("16.5", "-inf", "[red] diameter_px", "3 to 128"),
        ("16.5", "0", "[red] diameter_px", "3 to 128"),
        ("16.5", "128.1", "[red] diameter_px", "3 to 128"),
        ("16.5", "\"16\"", "[red] diameter_px", "3 to 128"),
        ("16.5", "16.5\naspect = nan", "[red] aspect", "0.5 to 2"),
        ("16.5", "16.5\naspect = 3", "[red] aspect", "0.5 to 2"),
        ("16.5", "16.5\nat = [1.0, nan]", "[red] at", "finite"),
        ("16.5", "16.5\nalpha = 0.5", "[red] alpha", "unknown key"),
        ("[red]", "[pink]", "[pink]", "unknown table"),
        ("[red]", "[learnt_from]\nsource = 3\nframe = 0\n[red]", "[learnt_from] source", "string"),
        ("[red]", "[learnt_from]\nsource = \"a\"\nframe = -1\n[red]", "[learnt_from] frame", "from 0"),
    ];
    for (from, to, key, words) in cases {
        let error = problem(&RED.replace(from, to));
        assert_eq!((error.file.as_str(), error.key.as_str()), ("colours.toml", key), "{to}: {error}");
        assert!(error.problem.contains(words), "{to}: {error}");
        assert_eq!(error.to_string(), format!("colours.toml: {key}: {}", error.problem));
    }
}

#[test]
fn text_without_a_ball_is_refused() {
    assert!(problem("").to_string().contains("no ball"));
    assert!(problem("red = 3").to_string().contains("colours.toml: red: a table is needed"));
    assert!(problem("[red").to_string().contains("not TOML"));
    assert!(problem(&format!("{RED}{RED}")).to_string().contains("not TOML"), "a ball given twice");
}

#[test]
fn a_ball_that_was_not_learnt_is_named_when_it_is_asked_for() {
    let colours = Colours::parse(RED, "c.toml").unwrap();
    let error = colours.clone().select(BallSet::ALL, "c.toml").unwrap_err();
    assert_eq!(error.key, "[green]");
    assert!(error.to_string().contains("tetrad learn --at green=X,Y"), "{error}");
    assert_eq!(colours.clone().select("red".parse().unwrap(), "c.toml"), Ok(colours));
}

prop_compose! {
    fn any_rgb()(r: u8, g: u8, b: u8) -> Rgb { Rgb::new(r, g, b) }
}

fn any_ball(ball: Ball) -> impl Strategy<Value = Option<BallColours>> {
    let point = (-100.0f32..9000.0, -100.0f32..9000.0).prop_map(|(u, v)| ImagePoint::new(u, v));
    let learnt = (any_rgb(), any_rgb(), any_rgb(), MIN_DIAMETER..=MAX_DIAMETER, 0.5f32..=2.0)
        .prop_map(move |(reference, typical, background, diameter, aspect)| LearntBall {
            reference: Reference { primary: Primary::of(ball), reference, typical, background },
            diameter,
            aspect,
        })
        .prop_filter("contrast", |b| Matcher::new(&b.reference, 128).is_ok());
    let ball = (learnt, proptest::option::of(point)).prop_map(|(learnt, at)| BallColours { learnt, at });
    proptest::option::of(ball)
}

proptest! {
    #[test]
    fn what_is_written_reads_back_the_same(
        red in any_ball(Ball::Red).prop_filter("one ball at least", Option::is_some),
        green in any_ball(Ball::Green),
        blue in any_ball(Ball::Blue),
        yellow in any_ball(Ball::Yellow),
        source in proptest::option::of(any::<String>()),
        frame in 0..=u64::try_from(i64::MAX).unwrap(),
    ) {
        let origin = source.map(|source| Origin { source, frame });
        let colours = Colours { balls: [red, green, blue, yellow], origin };
        prop_assert_eq!(Colours::parse(&colours.to_toml(), "colours.toml"), Ok(colours));
    }

    #[test]
    fn damaged_text_is_an_answer_and_never_a_panic(at in 0..RED.len(), byte in 0u8..128, cut: bool) {
        let mut text = RED.to_owned().into_bytes();
        text[at] = byte;
        text.truncate(if cut { at } else { RED.len() });
        let _ = Colours::parse(&String::from_utf8(text).unwrap(), "colours.toml");
    }
}
