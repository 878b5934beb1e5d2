// STOP: for everybody, always. Over the socket, and by a request of its own in case the socket is stuck.

export function stopWith(live, button) {
  const stop = () => {
    live.send({ type: "stop" });
    fetch("/api/stop", { method: "POST", keepalive: true }).then(
      (answer) => button.classList.toggle("failed", !answer.ok),
      () => button.classList.add("failed"),
    );
  };
  // at the touch, not at the end of it
  button.addEventListener("pointerdown", stop);
  button.addEventListener("click", stop);
  addEventListener("keydown", (event) => {
    const typing = event.target.closest("input, textarea, select");
    if (event.key === "Escape" || (event.key.toLowerCase() === "s" && !typing && !event.ctrlKey)) {
      event.preventDefault();
      stop();
    }
  });
}
