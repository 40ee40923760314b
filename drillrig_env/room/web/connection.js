// The websocket: it says when the server is gone, comes back by itself, and then asks for the same setting again.

/** @typedef {(message: {is: string} & Record<string, unknown>) => void} OnText */

const FIRST_WAIT = 500;
const LONGEST_WAIT = 5000;
const ALIVE = 30_000;

/** A connection to the room at /room of the server that this page came from. */
export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #wait = FIRST_WAIT;
  #timer = 0;

  /**
   * @param {OnText} onText
   * @param {(buffer: ArrayBuffer) => void} onFrame
   * @param {(sentence: string) => void} onLost with a sentence for the user, empty when all is well
   */
  constructor(onText, onFrame, onLost) {
    this.onText = onText;
    this.onFrame = onFrame;
    this.onLost = onLost;
    setInterval(() => this.send({ do: "alive" }), ALIVE);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/room`);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    socket.onmessage = (event) => {
      if (typeof event.data !== "string") {
        this.onFrame(event.data);
        return;
      }
      const message = JSON.parse(event.data);
      if (message.is === "welcome") {
        this.#wait = FIRST_WAIT;
        this.onLost("");
      }
      this.onText(message);
    };
    socket.onclose = (event) => this.#lost(event);
  }

  /** @param {CloseEvent} event */
  #lost(event) {
    this.#socket = null;
    const why = event.reason ? `The server closed the room: ${event.reason}.` : "The server does not answer.";
    this.onLost(`${why} The rigs stand still; trying again …`);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.open(), this.#wait);
    this.#wait = Math.min(2 * this.#wait, LONGEST_WAIT);
  }

  /** @param {Record<string, unknown>} message */
  send(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }
}
