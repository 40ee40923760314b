// The binary frames of docs/room_protocol.md, read. Little-endian throughout.

/** @typedef {{index: number, mean: number, calmSince: number, stuck: number, full: boolean, calm: boolean, mitigated: boolean}} Verdict */
/** @typedef {{verdict: Verdict, seen: Float32Array, values: Float32Array, signals: Float32Array}} LaneFrame */
/** @typedef {{run: number, first: number, steps: number, samples: number, period: number, gap: boolean, given: Float32Array, lanes: LaneFrame[]}} Frame */

const KIND = 0x44;
const VERSION = 1;
const HEADER = 20;
const GIVEN = 5;
const VERDICT = 6;
const STEP_VALUES = 7;
const SIGNALS = 7;

/** What the values of a control step are, by their place. */
export const VALUE = { reference: 0, action: 1, byHand: 2, variance: 3, tracking: 4, effort: 5, voltage: 6 };

/** What the signals are, by their place. */
export const SIGNAL = { bit: 0, collar: 1, top: 2, twist12: 3, twist23: 4, torque: 5, current: 6 };

/** What is given, by its place. */
export const GIVEN_AT = { normalForce: 0, muS: 1, muK: 2, vB: 3, target: 4 };

/**
 * Read a frame; null for one of another kind or version, which is not for this page.
 * @param {ArrayBuffer} buffer
 * @returns {Frame | null}
 */
export function readFrame(buffer) {
  const head = new DataView(buffer);
  if (buffer.byteLength < HEADER || head.getUint8(0) !== KIND || head.getUint8(1) !== VERSION) return null;
  const laneCount = head.getUint8(2);
  const steps = head.getUint16(4, true);
  const samples = head.getUint16(6, true);
  let at = HEADER;
  /** @param {number} count */
  const floats = (count) => {
    const found = new Float32Array(buffer, at, count);
    at += 4 * count;
    return found;
  };
  const given = floats(steps * GIVEN);
  const lanes = [];
  for (let lane = 0; lane < laneCount; lane++) {
    const [index, mean, calmSince, stuck, flags, channels] = floats(VERDICT);
    const verdict = {
      index,
      mean,
      calmSince,
      stuck,
      full: (flags & 1) !== 0,
      calm: (flags & 2) !== 0,
      mitigated: (flags & 4) !== 0,
    };
    const seen = floats(channels);
    lanes.push({ verdict, seen, values: floats(steps * STEP_VALUES), signals: floats(steps * samples * SIGNALS) });
  }
  return {
    run: head.getUint32(8, true),
    first: head.getUint32(12, true),
    steps,
    samples,
    period: head.getFloat32(16, true),
    gap: (head.getUint8(3) & 1) !== 0,
    given,
    lanes,
  };
}
