// Overview: what is ready, in words.

import { Live } from "./live.js";
import { find, items, lines, ms, watchLink } from "./page.js";
import { stopWith } from "./stop.js";

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));

live.addEventListener("live", ({ detail: { control, snapshot } }) => {
  const mark = (good) => (good ? "\u2713" : "\u2717");
  const checks = snapshot.cameras.map((camera) => {
    const seen = camera.balls.filter((ball) => ball.state === "visible" || ball.state === "occluded").length;
    return `${mark(seen === 4)} ${camera.name}: ${seen} of 4 balls, heard ${ms(camera.age_us)} ago`;
  });
  const hand = snapshot.hand;
  checks.push(`${mark(hand?.position_mm)} hand: ${hand ? hand.state : "not seen yet"}`);
  const arm = snapshot.arm;
  checks.push(`${mark(arm && arm.state !== "fault")} arm: ${arm ? arm.standing : "not heard yet"}`);
  checks.push(
    control.drives
      ? `${mark(!control.stopped)} buttons: here; ${control.holder ?? "nobody"} is in control`
      : `${mark(true)} buttons: not in the console; STOP works from here`,
  );
  items(find("list"), checks);
  lines(find("lines"), snapshot.lines);
});
