// The time that is shown: it runs evenly between frames that come unevenly, a little behind the newest one.

const BEHIND = 1.2; // control steps
const LEAST_BEHIND = 0.1; // s of a real clock, in which a frame that is late still comes in time

/** A clock that follows the run. */
export class Clock {
  constructor() {
    this.shown = 0;
    this.#last = 0;
  }

  #last;

  reset() {
    this.shown = 0;
  }

  /**
   * Move on to the animation frame at `now` (ms): how far the run has come (s), its speed and its control period (s).
   * @param {number} now
   * @param {number} newest
   * @param {boolean} paused
   * @param {number} times
   * @param {number} period
   */
  tick(now, newest, paused, times, period) {
    const passed = Math.min((now - this.#last) / 1000, 0.25);
    this.#last = now;
    if (paused) {
      this.shown = newest;
      return;
    }
    const lag = Math.max(BEHIND * period, LEAST_BEHIND * times);
    const wanted = newest - lag;
    this.shown += passed * times;
    // Where it is off by more than a little, it goes faster or slower until it is not; far off it jumps.
    const error = wanted - this.shown;
    if (Math.abs(error) > 4 * lag + 0.5 * times) this.shown = wanted;
    else this.shown += Math.min(1, 2 * passed) * error;
    this.shown = Math.min(Math.max(this.shown, 0), newest);
  }
}
