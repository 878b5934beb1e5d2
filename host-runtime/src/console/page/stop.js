// STOP: for everybody, always. Over the socket, and by a request of its own in case the socket is stuck. Gives
// what the button does, for pages with other ways to ask for it.

import { isWriting } from "./page.js";

// A stop that is not answered by then is not taken for heard: a line that hangs answers nothing.
const HEARD_MS = 1500;

// By its letter; where the key at its place writes no Latin letter, by the place. (One that does may be another button's.)
const isS = ({ key, code }) => key?.toLowerCase() === "s" || (code === "KeyS" && !/^[a-z]$/i.test(key));

export function stopWith(live, button) {
  let pressed = 0;
  let told = 0;
  // the newest press counts of which something is known
  const tell = (press, heard) => {
    if (press < told) return;
    told = press;
    button.classList.toggle("failed", !heard);
  };
  const stop = () => {
    const press = ++pressed;
    live.send({ type: "stop" });
    fetch("/api/stop", { method: "POST", keepalive: true, signal: AbortSignal.timeout(HEARD_MS) }).then(
      (answer) => tell(press, answer.ok),
      () => tell(press, false),
    );
  };
  // at the touch, not at the end of it
  button.addEventListener("pointerdown", stop);
  button.addEventListener("click", stop);
  // and at the key's way down, not up
  button.addEventListener("keydown", (event) => {
    if (!event.repeat && (event.code === "Space" || event.key === "Enter")) stop();
  });
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" || (isS(event) && !isWriting(event) && !event.ctrlKey)) {
      event.preventDefault();
      stop();
    }
  });
  return stop;
}
