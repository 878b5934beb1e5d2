// Overview: what is ready and what is not, in words.

import { Live } from "./live.js";
import { find, isHeard, items, knownBy, lines, ms, watchLink, write } from "./page.js";
import { stopWith } from "./stop.js";

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));

const mark = (good) => (good ? "\u2713" : "\u2717");

live.addEventListener("live", ({ detail: { control, snapshot } }) => {
  const checks = snapshot.cameras.map((camera) => {
    const seen = camera.balls.filter((ball) => ball.state === "visible" || ball.state === "occluded").length;
    return `${mark(seen === 4 && isHeard(camera.age_us))} ${camera.name}: ${seen} of 4 balls, heard ${ms(camera.age_us)} ago`;
  });
  const hand = snapshot.hand;
  const known = hand ? `known by ${knownBy(hand)}` : "not seen yet";
  checks.push(`${mark(hand?.position_mm && isHeard(hand.age_us))} hand: ${known}`);
  for (const link of snapshot.links) {
    checks.push(`${mark(link.connected && isHeard(link.age_us))} ${link.name}: ${link.connected ? `heard ${ms(link.age_us)} ago` : "AWAY"}`);
  }
  const arm = snapshot.arm;
  checks.push(`${mark(arm && arm.state !== "fault" && !arm.silent)} arm: ${arm ? arm.standing : "not heard yet"}`);
  if (arm) checks.push(`${mark(arm.controller === "ready" && !arm.silent)} controller: ${arm.controller}`);
  const { slave, recording } = snapshot;
  if (slave) checks.push(`${mark(true)} at the slave: ${slave.port}${slave.moves_an_arm ? ", AN ARM THAT MOVES" : ", nothing that moves"}`);
  if (recording) {
    const words = recording.failed ? "WRITING HAS FAILED" : recording.left_out ? `${recording.left_out} messages left out` : "all of it";
    checks.push(`${mark(!recording.failed && !recording.left_out)} recorded to ${recording.file}: ${words}`);
  }
  checks.push(
    control.drives
      ? `${mark(!control.stopped)} buttons: here; ${control.holder ?? "nobody"} is in control${control.stopped ? "; stopped: reset on the drive page" : ""}`
      : `${mark(true)} buttons: not in the console; STOP works from here`,
  );
  items(find("list"), checks);
  lines(find("lines"), snapshot.lines);
});

// What `tetrad check` notes of the file and this computer, and what is plugged in.
async function look() {
  find("again").disabled = true;
  try {
    const answer = await fetch("/api/checklist");
    const { file, notes, devices } = await answer.json();
    const fine = file ? `${mark(true)} nothing to note: what ${file} names is there` : `${mark(true)} nothing is needed: cameras and arm are simulated`;
    items(find("notes"), notes.length ? notes.map((note) => `${mark(false)} ${note}`) : [fine]);
    write(find("devices"), devices);
  } catch {
    items(find("notes"), [`${mark(false)} the console did not answer: look again`]);
  } finally {
    find("again").disabled = false;
  }
}
find("again").addEventListener("click", look);
look();
