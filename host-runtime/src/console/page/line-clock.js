// The operator's clock, as this page knows it: by messages that the console sends straight back.
//
// Such a message was answered after it was sent and before it came back, which leaves the difference of the two
// clocks between two bounds; all messages together leave what all of them allow. So a line that has been quick
// once is known for as slow as it gets later, in which direction ever.

// Clocks drift apart by no more: 100 in a million, twice what quartzes are allowed.
const DRIFT = 1e-4;

// Bounds contradict each other by no more, milliseconds, because of the browser's timers, which are rounded (to 1 ms,
// some), or of a clock that is being set right slowly.
const HAIR_MS = 5;

// What is so much later than now, milliseconds, and certainly so, is a time of another clock. That of a picture from
// another station may be a little wrong.
const LATER_MS = 100;

export class LineClock {
  // operator's clock less this page's, milliseconds: at least, at most, and as of when
  #low = -Infinity;
  #high = Infinity;
  #asOfMs = 0;

  get isKnown() {
    return Number.isFinite(this.#low) && Number.isFinite(this.#high);
  }

  // A message that was sent at one time of this page's clock was answered at `operatorUs` and came at another.
  answered(sentMs, operatorUs, cameMs) {
    this.#take(operatorUs / 1000 - cameMs, operatorUs / 1000 - sentMs, cameMs);
  }

  // A message of the operator came.
  heard(operatorUs, cameMs = performance.now()) {
    this.#take(operatorUs / 1000 - cameMs, Infinity, cameMs);
  }

  // How long ago a time of the operator's clock was, milliseconds, give or take `within`; null where that is not
  // known: not yet, or it is a time of the operator's clock before the last start.
  age(operatorUs, nowMs = performance.now()) {
    if (!this.isKnown) return null;
    const drift = DRIFT * (nowMs - this.#asOfMs);
    const age = nowMs + (this.#low + this.#high) / 2 - operatorUs / 1000;
    const within = (this.#high - this.#low) / 2 + drift;
    return age < -(within + LATER_MS) ? null : { ms: Math.max(0, age), within };
  }

  #take(low, high, nowMs) {
    const drift = DRIFT * (nowMs - this.#asOfMs);
    this.#asOfMs = nowMs;
    const least = Math.max(this.#low - drift, low);
    const most = Math.min(this.#high + drift, high);
    // bounds that miss each other by a hair hold what is between; by more, one of the clocks has stood still, or the
    // operator has another now, and what was known is of no use
    const agree = least - most <= HAIR_MS;
    [this.#low, this.#high] = agree ? [Math.min(least, most), Math.max(least, most)] : [low, high];
  }
}
