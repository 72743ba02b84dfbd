// "Take over from here": a link to the page that runs the simulator, in which the reader goes on as the human from the
// moment that is shown. It holds the scenario, the decisions so far, the time, and where the object is, to be compared.
import { packed } from "./packed.js";

const LOOPBACK = /^https?:\/\/(127\.0\.0\.1|localhost)[:/]/;

export class TakeOver {
  // `box` has the link, or the sentence why there is none.
  constructor(box, episode) {
    Object.assign(this, { box, episode, step: null });
    const { refused, address } = episode.take_over;
    box.hidden = false;
    if (refused) return this.#say(refused);
    this.link = document.createElement("a");
    Object.assign(this.link, { target: "_blank", rel: "noopener" });
    const words = document.createElement("span");
    words.textContent = LOOPBACK.test(address) ? "as the human, in the page of the program: cocarry demo must run" : "as the human";
    box.replaceChildren(this.link, " ", words);
    this.#pack().catch((error) => this.#say(`This episode cannot be taken over: this browser cannot make the link (${error.message}).`));
  }

  async #pack() {
    const { address, scenario, log } = this.episode.take_over;
    const parts = [`scenario=${await packed(scenario)}`, ...(log ? [`log=${await packed(JSON.stringify(log))}`] : []), "carry=1"];
    this.start = `${address}#${parts.join("&")}`;
    this.step = null;
    this.update(this.time ?? 0);
  }

  #say(sentence) {
    this.link = null;
    this.box.textContent = sentence;
  }

  // The link for a time: from the beginning of its planning step.
  update(time) {
    this.time = time;
    if (!this.link) return;
    const { frames, period_s: period, duration } = this.episode, { before } = this.episode.between(time);
    const step = Math.min(Math.floor(frames.time_s[before] / period + 1e-6), Math.ceil(duration / period - 1e-6) - 1);
    if (step === this.step) return;
    this.step = step;
    const at = Number((step * period).toFixed(6)), [x, y, z] = this.#object(at);
    // before the scenario is packed the link leads nowhere yet
    if (this.start) this.link.href = `${this.start}&t=${at}&object=${x},${y},${z}`;
    this.link.textContent = `Take over from ${at.toFixed(1)} s`;
  }

  // Where the recording has the object at a time.
  #object(time) {
    const { before } = this.episode.between(time);
    return this.episode.frames.object.slice(7 * before, 7 * before + 3);
  }
}
