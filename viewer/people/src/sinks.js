// Where answers go. A sink has `begin`, which says who and which order the participant is, `put` for a chunk, unless it takes the
// session as a whole, and `finish`, which returns when the sink has everything.
import { Refused, persistently } from "./server.js";
import { sha256 } from "./recorder.js";

// Without a server nobody counts participants: the order is drawn.
const drawn = async () => ({ participant: null, place: crypto.getRandomValues(new Uint32Array(1))[0] });

// A session, or a part of it, as `collect --add` reads it.
export function saved({ study, key, ids }, chunks, more) {
  const bodies = chunks.map(({ trial, number, body }) => [trial, number, body]);
  return JSON.stringify({ version: 1, study, key, platform_ids: ids, chunks: bodies, ...more });
}

// JATOS, in which the page is a component of a study: https://www.jatos.org, `window.jatos` of its jatos.js. Every chunk is
// appended to the component's result as a line; a line that comes twice is the same.
export class Jatos {
  #session;
  #say;
  begin = drawn;

  constructor(session, say) {
    this.#session = session;
    this.#say = say;
  }

  // The page may ask once JATOS has loaded what it knows of the study.
  static loaded() {
    if (!globalThis.jatos) throw new Refused("jatos", "this page was made for JATOS, and is not in it");
    return new Promise((done) => jatos.onLoad(done));
  }

  // JATOS has the parameters of the address by which the study began.
  static parameters = () => jatos.urlQueryParameters ?? {};

  #append = (chunks, more) => persistently(this.#say, () => jatos.appendResultData(`${saved(this.#session, chunks, more)}\n`));

  put = (chunk) => this.#append([chunk], { part: true });

  async finish(digest) {
    await this.#append([], { digest });
    // the page stays, with the code; older versions know the second name alone
    await persistently(this.#say, () => (jatos.endStudyWithoutRedirect ?? jatos.endStudyAjax)(true));
    return {};
  }
}

// DataPipe, which passes a session on to a project of the Open Science Framework: https://pipe.jspsych.org.
export class DataPipe {
  #session;
  #say;
  #to;
  begin = drawn;

  constructor(session, say, to) {
    this.#session = session;
    this.#say = say;
    this.#to = to;
  }

  async finish(digest, chunks) {
    // a file of this name has this content: it came before, and its receipt was lost
    const body = JSON.stringify({
      experimentID: this.#to.experiment, filename: `answers-${(await sha256(this.#session.key + digest)).slice(0, 16)}.json`,
      data: saved(this.#session, chunks, { digest }),
    });
    await persistently(this.#say, async () => {
      const answer = await fetch(this.#to.address, { method: "POST", headers: { "content-type": "application/json" }, body });
      if (answer.ok) return;
      const { error = `status ${answer.status}` } = await answer.json().catch(() => ({}));
      if (error === "OSF_FILE_EXISTS") return;
      if (answer.status < 500 && answer.status !== 429 && error !== "OSF_UPLOAD_ERROR") throw new Refused(error, `your answers could not be handed over (${error})`);
      throw new Error(error);
    });
    return {};
  }
}

// A file, which the participant saves on the last page.
export class Download {
  begin = drawn;
  finish = async () => ({ isDownload: true });
}
