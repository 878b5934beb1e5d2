//! The slave's view, in each of its ways for two eyes, by the pixels of its canvas.

use super::browser::{Browser, DESK, lit};
use super::pages::screens;
use super::program::Program;
use super::proxy::Proxy;
use super::turn;
use serde_json::{Value, json};

/// Draws both eyes in turn until both have been seen, takes the canvas in the other ways too, and compares. The left
/// eye is the one that is at the left side by side.
const COMPARE: &str = "
const stage = document.getElementById('stage');
const [width, height] = [stage.width, stage.height];
const frame = () => new Promise((done) => requestAnimationFrame(done));
const scratch = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
const pixels = (x = 0, wide = width) => {
  scratch.drawImage(stage, 0, 0);
  return scratch.getImageData(x, 0, wide, height);
};
const way = async (name) => {
  document.querySelector(`input[value=${name}]`).click();
  await frame();
  await frame();
  return pixels();
};
const same = (one, other) => one.data.every((value, at) => value === other.data[at]);
// the mean difference of two pictures, of 255
const differ = (one, other) => {
  let sum = 0;
  for (let at = 0; at < one.data.length; at += 1) sum += Math.abs(one.data[at] - other.data[at]);
  return sum / one.data.length;
};
// a picture as large as half the canvas, as it is fitted in there
const halved = (picture) => {
  const whole = Object.assign(document.createElement('canvas'), { width, height });
  whole.getContext('2d').putImageData(picture, 0, 0);
  // the pictures are 4:3, and as high as the canvas
  const shown = Math.min(width, height * 4 / 3);
  const scale = Math.min(width / 2 / shown, 1);
  const half = Object.assign(document.createElement('canvas'), { width: width / 2, height });
  const pen = half.getContext('2d');
  pen.fillRect(0, 0, width / 2, height);
  const [w, h] = [shown * scale, height * scale];
  pen.drawImage(whole, (width - shown) / 2, 0, shown, height, (width / 2 - w) / 2, (height - h) / 2, w, h);
  return pen.getImageData(0, 0, width / 2, height);
};

const first = await way('flip');
let second = null;
let turns = 0;
for (let tries = 0; tries < 400 && turns < 4; tries += 1) {
  await frame();
  const now = pixels();
  if (!second && !same(now, first)) second = now;
  if (second && same(now, turns % 2 ? second : first)) turns += 1;
}
if (!second) return { told: 'in turn shows one picture' };

await way('beside');
const halves = [0, width / 2].map((x) => pixels(x, width / 2));
const [a, b] = [halved(first), halved(second)];
const straight = differ(halves[0], a) + differ(halves[1], b);
const crossed = differ(halves[0], b) + differ(halves[1], a);
const [left, right] = straight < crossed ? [first, second] : [second, first];

const anaglyph = await way('anaglyph');
let red = 0;
let cyan = 0;
for (let at = 0; at < anaglyph.data.length; at += 4) {
  red = Math.max(red, Math.abs(anaglyph.data[at] - left.data[at]));
  cyan = Math.max(cyan, Math.abs(anaglyph.data[at + 1] - right.data[at + 1]), Math.abs(anaglyph.data[at + 2] - right.data[at + 2]));
}

const wrong = (rows, even, odd) => {
  let wrong = 0;
  for (let y = 0; y < height; y += 1) {
    const from = y % 2 ? odd : even;
    for (let at = 4 * y * width; at < 4 * (y + 1) * width; at += 1) wrong += Math.abs(rows.data[at] - from.data[at]) > 1;
  }
  return wrong;
};
const rows = wrong(await way('rows'), left, right);
document.getElementById('swap').click();
await frame();
await frame();
const swapped = wrong(pixels(), right, left);
document.getElementById('swap').click();
return {
  told: 'all', turns, eyes: differ(first, second), fits: Math.min(straight, crossed), crossed: Math.max(straight, crossed),
  red, cyan, rows, swapped,
};";

#[test]
fn one_camera_is_shown_to_both_eyes() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::eyes::one_camera_is_shown_to_both_eyes") else { return };
    let program = Program::with_one_eye();
    browser.go(&program.url("/slave"));
    for (key, way) in [("1", "beside"), ("2", "anaglyph"), ("3", "rows"), ("4", "flip")] {
        browser.tap(key);
        browser.until(&format!("document.querySelector('input[value={way}]').checked"));
        browser.until(
            "/^\\d+ ms$/.test(document.getElementById('stamp').textContent) && !document.body.classList.contains('stale')",
        );
        browser.until(&format!("{} > 0.05", lit("#stage")));
    }
    // nor is there a dead view beside it
    browser.go(&program.url("/drive"));
    browser.until("document.querySelectorAll('#views figure.eye').length === 1");
    browser.until("/\\d ms$/.test(document.querySelector('figure.eye .stamp').textContent)");
}

#[test]
fn both_eyes_see_their_own_picture_in_every_way() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::eyes::both_eyes_see_their_own_picture_in_every_way") else {
        return;
    };
    let program = Program::operator();
    let proxy = Proxy::to(program.address());
    browser.go(&proxy.url("/slave"));
    browser.until("/^\\d+ ms$/.test(document.getElementById('stamp').textContent)");
    // by its keys, photographed
    let folder = screens();
    for (key, way) in [("1", "beside"), ("2", "anaglyph"), ("3", "rows"), ("4", "flip")] {
        browser.tap(key);
        browser.until(&format!("document.querySelector('input[value={way}]').checked"));
        for scheme in ["light", "dark"] {
            browser.look(DESK, scheme);
            std::fs::write(folder.join(format!("slave-{way}-{scheme}.png")), browser.picture())
                .expect("a picture");
        }
    }
    browser.look(DESK, "light");

    // the same two pictures in every way: none comes any more
    proxy.hold_up("/pictures");
    browser.until("document.body.classList.contains('stale')");
    let told = browser.script(&format!("return (async () => {{ {COMPARE} }})()"));
    println!("measured: eyes: {told}");
    assert_eq!(told["told"], "all", "{told}");
    let number = |name: &str| told[name].as_f64().unwrap_or(f64::NAN);
    assert!(number("turns") >= 4.0, "in turn, again and again: {told}");
    assert!(number("eyes") > 0.5, "two cameras see two pictures: {told}");
    assert!(number("fits") < number("crossed") / 2.0, "side by side: {told}");
    assert!(
        number("red") <= 1.0 && number("cyan") <= 1.0,
        "red for the left eye, cyan for the right: {told}"
    );
    assert_eq!((&told["rows"], &told["swapped"]), (&json!(0), &json!(0)), "row by row: {told}");
    let wrong: Vec<Value> = browser.log();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
