// Questions to the studio, and its answers: a head of JSON and arrays of numbers (messages.py).

const KINDS = { f32: Float32Array, u32: Uint32Array };

/** The head of an answer, with its arrays by name under `numbers` and what follows under `rest`. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let place = 4 + length;
  head.numbers = {};
  for (const [name, kind, count] of head.arrays) {
    head.numbers[name] = new KINDS[kind](buffer, place, count);
    place += 4 * count;
  }
  head.rest = buffer.slice(place);
  return head;
}

const tab = crypto.randomUUID(); // tabs stop what they asked for, and not one another

/** Ask and wait for the answer; one that says why there is none has "refused", "lost" or "stopped". */
export const ask = (name, message) => post(name, JSON.stringify({ ...message, tab }));

/** Stop what this tab asks for, also while its page is left. */
export const leave = () => navigator.sendBeacon("stop", JSON.stringify({ tab }));

/** The same with a body of any kind, such as a file. */
export async function post(name, body) {
  let response;
  try {
    response = await fetch(name, { method: "POST", body });
  } catch {
    return { lost: "The studio does not answer: it was ended, or its address has changed." };
  }
  if (!response.ok) return { refused: await response.text() };
  return unpack(await response.arrayBuffer());
}

/** One question in flight and the newest one waiting; the answers go to `use`, in order. */
export class Newest {
  constructor(use) {
    this.use = use;
    this.waiting = undefined;
    this.busy = false;
  }

  /** question : a function that asks, called when its turn comes. */
  async ask(question) {
    this.waiting = question;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.waiting) {
        const next = this.waiting;
        this.waiting = undefined;
        this.use(await next(), this.waiting !== undefined);
      }
    } finally {
      this.busy = false;
    }
  }
}
