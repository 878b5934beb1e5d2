// The operator's clock, as this page knows it: by messages that the console sends straight back.
//
// Such a message was answered after it was sent and before it came back, which leaves the difference of the two
// clocks between two bounds; all messages together leave what all of them allow. So a line that has been quick
// once is known for as slow as it gets later, in which direction ever.

// Clocks drift apart by no more: 100 in a million, twice what quartzes are allowed.
const DRIFT = 1e-4;

export class LineClock {
  // operator's clock less this page's, milliseconds: at least, at most, and as of when
  #low = -Infinity;
  #high = Infinity;
  #asOfMs = performance.now();

  get isKnown() {
    return Number.isFinite(this.#low) && Number.isFinite(this.#high);
  }

  // A message that was sent at one time of this page's clock was answered at `operatorUs` and came at another.
  answered(sentMs, operatorUs, cameMs) {
    this.#take(operatorUs / 1000 - cameMs, operatorUs / 1000 - sentMs, cameMs);
  }

  // A message of the operator came now.
  heard(operatorUs) {
    const nowMs = performance.now();
    this.#take(operatorUs / 1000 - nowMs, Infinity, nowMs);
  }

  // How long ago a time of the operator's clock was, milliseconds, give or take `within`; null where that is not
  // known yet.
  age(operatorUs) {
    if (!this.isKnown) return null;
    const nowMs = performance.now();
    const drift = DRIFT * (nowMs - this.#asOfMs);
    const age = nowMs + (this.#low + this.#high) / 2 - operatorUs / 1000;
    return { ms: Math.max(0, age), within: (this.#high - this.#low) / 2 + drift };
  }

  #take(low, high, nowMs) {
    const drift = DRIFT * (nowMs - this.#asOfMs);
    this.#asOfMs = nowMs;
    this.#low = Math.max(this.#low - drift, low);
    this.#high = Math.min(this.#high + drift, high);
    // one of the clocks has stood still, or the operator has another now: what was known is of no use
    if (this.#low > this.#high) [this.#low, this.#high] = [low, high];
  }
}
