// The server of a study: every request is tried until it answers.

// An answer that a repetition does not change; `message` is a sentence for the participant.
export class Refused extends Error {
  constructor(reason, sentence) {
    super(sentence);
    this.reason = reason;
  }
}

const MIN_WAIT_MS = 500, MAX_WAIT_MS = 15e3, PATIENCE_MS = 20e3;
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

// What `ask` answers: it is asked again, with growing pauses, until it does or throws `Refused`. `say` shows a sentence meanwhile.
export async function persistently(say, ask) {
  for (let wait = MIN_WAIT_MS; ; wait = Math.min(2 * wait, MAX_WAIT_MS)) {
    try {
      const answer = await ask();
      say("");
      return answer;
    } catch (error) {
      if (error instanceof Refused) throw error;
    }
    say("The connection is interrupted. Your answers are kept in this browser and are sent as soon as it is back.");
    await Promise.race([sleep(wait * (0.75 + Math.random() / 2)), new Promise((back) => addEventListener("online", back, { once: true }))]);
  }
}

export class Server {
  #say;
  #key;

  // `say` shows a sentence, or none.
  constructor(key, say) {
    this.#key = key;
    this.#say = say;
  }

  begin = (platform_ids, study) => this.#ask("POST", "api/session", JSON.stringify({ key: this.#key, platform_ids, study }));
  put = ({ trial, number, sha256, body }) => this.#ask("PUT", `api/chunks/${trial}/${number}`, body, { "x-sha256": sha256 });
  chunks = () => this.#ask("GET", "api/session");
  finish = (digest) => this.#ask("POST", "api/finish", JSON.stringify({ digest }));

  #ask = (method, path, body, headers = {}) => persistently(this.#say, async () => {
    const answer = await fetch(path, {
      method, body, headers: { ...headers, "x-session-key": this.#key }, signal: AbortSignal.timeout(PATIENCE_MS),
    });
    const value = await answer.json();
    if (answer.ok) return value;
    // damaged on its way, too many at once, or a fault of the server: again
    if (answer.status < 500 && ![422, 429].includes(answer.status)) throw new Refused(value.reason, value.error);
    throw new Error(value.reason);
  });
}
