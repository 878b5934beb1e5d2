use super::*;
use crossterm::event::ModifierKeyCode;

fn keyboard(tells_releases: bool) -> Keyboard {
    Keyboard::of(File::open("/dev/null").unwrap().into(), tells_releases)
}

const MS: Duration = Duration::from_millis(1);

fn press(code: KeyCode) -> KeyEvent {
    KeyEvent::new(code, KeyModifiers::NONE)
}

#[test]
fn a_release_that_is_told_counts_at_once() {
    let mut keyboard = keyboard(true);
    let now = Instant::now();
    assert_eq!(keyboard.key(press(KeyCode::Char(' ')), now), None);
    assert!(keyboard.is_held(now) && keyboard.is_held(now + 690 * MS), "before the first repeat");
    assert!(keyboard.take_strike() && !keyboard.take_strike());
    for repeat in 0..20 {
        let _ = keyboard.key(press(KeyCode::Char(' ')), now + repeat * 33 * MS);
    }
    let now = now + 19 * 33 * MS;
    assert!(keyboard.is_held(now + 199 * MS), "it need not be guessed");
    let release = KeyEvent::new_with_kind(KeyCode::Char(' '), KeyModifiers::NONE, KeyEventKind::Release);
    assert_eq!(keyboard.key(release, now), None);
    assert!(!keyboard.is_held(now));
}

#[test]
fn any_other_key_stops_and_lets_go() {
    let now = Instant::now();
    for (code, key) in [
        (KeyCode::Char('s'), Key::Stop),
        (KeyCode::Esc, Key::Stop),
        (KeyCode::Enter, Key::Stop),
        (KeyCode::Char('r'), Key::Reset),
        (KeyCode::Char('c'), Key::Homed),
        (KeyCode::Char('+'), Key::Stop),
        (KeyCode::Modifier(ModifierKeyCode::LeftShift), Key::Stop),
        (KeyCode::Char('q'), Key::Quit),
    ] {
        let mut keyboard = keyboard(true);
        let _ = keyboard.key(press(KeyCode::Char(' ')), now);
        assert_eq!(keyboard.key(press(code), now), Some(key));
        assert!(!keyboard.is_held(now), "{code:?}");
    }
}

#[test]
fn h_is_held_for_the_way_home_and_the_bar_beside_it_stops() {
    let (bar, h) = (KeyCode::Char(' '), KeyCode::Char('h'));
    let now = Instant::now();
    let mut keyboard = keyboard(true);
    assert_eq!(keyboard.key(press(h), now), None);
    assert!(keyboard.is_held(now) && keyboard.held_for() == PressFor::Home);
    let release = |code| KeyEvent::new_with_kind(code, KeyModifiers::NONE, KeyEventKind::Release);
    assert_eq!(keyboard.key(release(bar), now), None);
    assert!(keyboard.is_held(now), "the release of a key that is not the one");
    assert_eq!(keyboard.key(press(bar), now), Some(Key::Stop));
    assert!(!keyboard.is_held(now));
    assert_eq!(keyboard.key(press(bar), now), None);
    assert!(keyboard.is_held(now) && keyboard.held_for() == PressFor::Follow);
    assert_eq!(keyboard.key(release(bar), now), None);
    assert!(!keyboard.is_held(now));
    // a tap of each in turn is no repeat of either
    let mut taps = self::keyboard(false);
    for (tap, code) in [h, bar, h, bar].into_iter().enumerate() {
        let at = now + tap as u32 * 100 * MS;
        assert_eq!(taps.key(press(code), at), None);
        assert!(!taps.is_held(at), "{tap}");
    }
}

#[test]
fn the_scale_is_stepped_while_nothing_is_held() {
    let now = Instant::now();
    let mut keyboard = keyboard(true);
    assert_eq!(keyboard.key(press(KeyCode::Char('-')), now), Some(Key::Finer));
    assert_eq!(keyboard.key(press(KeyCode::Char('+')), now), Some(Key::Coarser));
    // the same where + is above =, as kitty's protocol tells it
    let shift = press(KeyCode::Modifier(ModifierKeyCode::LeftShift));
    assert_eq!(keyboard.key(shift, now), None);
    let shifted = KeyEvent::new(KeyCode::Char('='), KeyModifiers::SHIFT);
    assert_eq!(keyboard.key(shifted, now), Some(Key::Coarser));
    let _ = keyboard.key(press(KeyCode::Char(' ')), now);
    assert_eq!(keyboard.key(press(KeyCode::Char('-')), now), Some(Key::Stop), "held: any other key");
    let mut scale = ScaleShare::FULL;
    let finer: Vec<u8> = std::iter::repeat_with(|| {
        scale = next_scale(scale, Key::Finer);
        scale.percent()
    })
    .take(6)
    .collect();
    assert_eq!(finer, [50, 25, 10, 5, 2, 2]);
    let odd = ScaleShare::from_percent(30).unwrap();
    assert_eq!(next_scale(odd, Key::Coarser).percent(), 50);
    assert_eq!(next_scale(ScaleShare::FULL, Key::Coarser), ScaleShare::FULL);
}

#[test]
fn a_terminal_that_is_hung_up_lets_go_and_says_so() {
    use serialport::SerialPort as _;
    let (master, slave) = serialport::TTYPort::pair().unwrap();
    let terminal = File::options().read(true).write(true).open(slave.name().unwrap()).unwrap();
    drop(slave);
    let mut keyboard = Keyboard::of(terminal.into(), true);
    let last = Instant::now();
    keyboard.held.strike(last);
    assert_eq!(keyboard.next().unwrap(), None);
    assert!(keyboard.is_held(last));
    drop(master);
    assert_eq!(keyboard.next().unwrap_err().to_string(), "it was hung up");
    assert!(!keyboard.is_held(last));
}

#[test]
fn more_keys_than_a_hand_strikes_are_a_stop() {
    let mut keyboard = keyboard(false);
    for _ in 0..=STRUCK {
        keyboard.reader.desk().strike(press(KeyCode::Char(' ')), Instant::now());
    }
    assert_eq!(keyboard.next().unwrap(), Some(Key::Stop));
    assert_eq!(keyboard.next().unwrap(), None);
}
