// What the server says in JSON; docs/room_protocol.md has the words for it.

/** @typedef {{heading: string, text: string}} Part */
/** @typedef {{name: string, title: string, parts: Part[]}} Story */
/**
 * @typedef {object} Welcome
 * @property {number} version
 * @property {string[]} rigs
 * @property {string[]} policies
 * @property {string[]} sensors
 * @property {number} longest_delay
 * @property {Story[]} stories
 * @property {{story: string | null, full_screen: boolean}} begin
 */
/** @typedef {Record<string, string | number | null>} Setting */
/** @typedef {{name: string, policy: string, hand: number | null, reference: number, channels: [string, string][], own_drive: boolean}} LaneState */
/**
 * @typedef {object} State
 * @property {number} run
 * @property {Setting} setting
 * @property {boolean} paused
 * @property {number} times
 * @property {number} step
 * @property {number} period
 * @property {boolean} at_end
 * @property {boolean} replay
 * @property {Record<string, number>} ramps
 * @property {{name: string, part: number} | null} story
 * @property {Record<string, [number, number, number]>} sliders
 * @property {number} largest_reference
 * @property {number} largest_force
 * @property {number} time_scale
 * @property {string} law
 * @property {LaneState[]} lanes
 */
/** @typedef {{forces: number[], critical: (number | null)[], end_forces: number[], end: (number | null)[], followed: boolean, critical_now: number | null, end_now: number | null, note: string}} Chart */
/** @typedef {{speed: number, calm_twist: number, calm_speed: number, twist: number[], bit_speed: number[], period: number | null}} Orbit */
/** @typedef {{name: string, map: Chart, orbit: Orbit | null}} LaneChart */

export {};
