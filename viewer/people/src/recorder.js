// Records what happens in a trial: every second, and at its end, a numbered chunk goes to the journal, then to the sink.
const INTERVAL_MS = 1000;

export const hex = (bytes) => Array.from(new Uint8Array(bytes), (byte) => byte.toString(16).padStart(2, "0")).join("");
export const sha256 = async (text) => hex(await crypto.subtle.digest("SHA-256", new TextEncoder().encode(text)));

// The digest of a whole session: of a line for every chunk, in the order of their numbers.
export function wholeDigest(chunks) {
  const sorted = [...chunks].sort((a, b) => a.trial - b.trial || a.number - b.number);
  return sha256(sorted.map(({ trial, number, sha256 }) => `${trial} ${number} ${sha256}\n`).join(""));
}

export class Recorder {
  #journal;
  #sink;
  #say;
  #fail;
  #trial = 0;
  #number = 0;
  #records = [];
  #isOver = false;
  // one after the other: making chunks, and sending them
  #making = Promise.resolve();
  #sending = Promise.resolve();
  // every chunk of the session
  chunks;

  // `chunks` are those of the journal.
  constructor({ journal, sink, chunks, say, fail }) {
    this.#journal = journal;
    this.#sink = sink;
    this.#say = say;
    this.#fail = fail;
    this.chunks = chunks;
    chunks.filter((chunk) => !chunk.isStored).forEach((chunk) => this.#send(chunk));
    setInterval(() => this.#flush(), INTERVAL_MS);
    addEventListener("visibilitychange", () => {
      this.note(document.hidden ? "hidden" : "visible");
      if (document.hidden) this.#flush();
    });
  }

  // The trials that are done.
  get done() {
    const isDone = ({ body }) => JSON.parse(body).some(({ kind }) => kind === "done");
    return new Set(this.chunks.filter(isDone).map(({ trial }) => trial));
  }

  // Begins a trial, perhaps again after the page was loaded anew.
  begin(trial) {
    const numbers = this.chunks.filter((chunk) => chunk.trial === trial).map(({ number }) => number);
    [this.#trial, this.#number] = [trial, Math.max(-1, ...numbers) + 1];
    this.note("begin", { data: { at: new Date().toISOString(), width: innerWidth, height: innerHeight } });
  }

  note(kind, more = {}) {
    if (this.#isOver) return;
    this.#records.push({ kind, at_ms: Math.round(performance.now()), ...more });
  }

  // Ends the trial: what it recorded is in the journal when this returns.
  async end(data) {
    this.note("done", { data });
    await this.#flush();
  }

  #flush() {
    if (!this.#records.length) return this.#making;
    const [trial, number, body] = [this.#trial, this.#number++, JSON.stringify(this.#records)];
    this.#records = [];
    this.#making = this.#making.then(async () => {
      const chunk = { trial, number, body, sha256: await sha256(body), isStored: false };
      this.chunks.push(chunk);
      await this.#keep(chunk);
      this.#send(chunk);
    });
    return this.#making;
  }

  async #keep(chunk) {
    try {
      await this.#journal.add(chunk);
    } catch (error) {
      // where chunks are not sent there is no other place
      if (!this.#sink.put) return this.#fail(`This browser cannot keep your answers (${error.name}). Free some space on the disk and load this page again.`);
      this.#say("This browser cannot keep your answers. They are sent, but do not close or reload this page.");
    }
  }

  #send(chunk) {
    if (!this.#sink.put) return;
    this.#sending = this.#sending.then(async () => {
      try {
        await this.#sink.put(chunk);
      } catch (error) {
        return this.#fail(`${sentence(error.message)} Your answers up to here are kept.`);
      }
      chunk.isStored = true;
      await this.#keep(chunk);
    });
  }

  // Waits until the sink has everything; returns its answer, which may have the code.
  async finish() {
    // whoever leaves the last page for another tab, with the code, adds nothing to a session that is finished
    this.#isOver = true;
    await this.#flush();
    await this.#sending;
    const digest = await wholeDigest(this.chunks);
    try {
      return await this.#sink.finish(digest, this.chunks);
    } catch (error) {
      if (error.reason !== "not-whole") throw error;
    }
    // what the server lost, if it lost anything
    const known = new Set((await this.#sink.chunks()).chunks.map(([trial, number]) => `${trial} ${number}`));
    for (const chunk of this.chunks) if (!known.has(`${chunk.trial} ${chunk.number}`)) this.#send(chunk);
    await this.#sending;
    return this.#sink.finish(digest);
  }
}

// A sentence that begins with a capital letter and ends.
export const sentence = (text) => text[0].toUpperCase() + text.slice(1).replace(/\.?$/, ".");
