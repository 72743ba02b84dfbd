// The page of a study: session, journal and pages in their order. Reloaded, it goes on at the first page that is not done.
import { initJsPsych } from "jspsych";
import { CarryAlong } from "./carry.js";
import { Journal } from "./journal.js";
import { make, paragraphs, show } from "./page.js";
import { Percentages } from "./percentages.js";
import { Recorder, hex, sentence } from "./recorder.js";
import { Server } from "./server.js";
import { Switch } from "./switch.js";
import { Consent, Instructions, Question, Scale } from "./texts.js";

const display = document.getElementById("study");
const say = (text) => {
  const status = document.getElementById("status");
  if (status.textContent !== text) status.textContent = text;
};

// Ends the page with a sentence.
class Stopped extends Error {}
let hasStopped = false;
function stop(text) {
  hasStopped = true;
  say("");
  show(display, "The study cannot go on", make("p", { id: "stopped" }, text));
}

const random = (bytes) => hex(crypto.getRandomValues(new Uint8Array(bytes)));

// The parameters of the address that the study keeps.
function platformIds(names) {
  const given = new URLSearchParams(location.search);
  return names.map((name) => [name, given.get(name)]).filter(([, value]) => value && /^[\w-]{1,200}$/.test(value));
}

// Whether this tab alone has the journal: the lock is held until the tab is closed, or breaks down.
function locked(name) {
  if (!navigator.locks) return Promise.resolve(true);
  return new Promise((decide) => {
    navigator.locks.request(name, { ifAvailable: true }, (lock) => {
      decide(Boolean(lock));
      return lock && new Promise(() => {});
    });
  });
}

async function opened(name) {
  try {
    return await Journal.open(name);
  } catch (error) {
    throw new Stopped(`This browser does not let the page keep your answers (${error.name}). Leave its private mode, or use another browser.`);
  }
}

async function begin() {
  if (!globalThis.crypto?.subtle) throw new Stopped("This page must be opened by an address that begins with https:// (or on this computer).");
  const study = await (await fetch("study.json")).json();
  document.title = study.title;
  document.getElementById("title").textContent = study.title;
  const ids = platformIds(study.platform_ids);
  const name = [study.digest, ...ids.slice(0, 1).flat()].join(" ");
  if (!(await locked(`cocarry study ${name}`))) throw new Stopped("This study is open in another tab or window already. Go on there, or close it and load this page again.");
  const journal = await opened(name);
  let session = await journal.session();
  if (!session) {
    session = { key: random(32) };
    // before the server knows it, so that it is the same after a reload
    await journal.keep(session);
  }
  const server = study.sink === "server" ? new Server(session.key, say) : null;
  if (session.place === undefined) {
    const begun = server ? await server.begin(ids, study.digest) : { participant: null, place: crypto.getRandomValues(new Uint32Array(1))[0] };
    Object.assign(session, begun);
    await journal.keep(session);
  }
  if (session.code === undefined) await answered({ study, session, journal, server });
  ended(study, session, journal, ids);
}

const TASKS = { consent: Consent, instructions: Instructions, percentages: Percentages, switch: Switch, carry: CarryAlong, question: Question, scale: Scale };

// Goes through the pages that are not done, and ends the session.
async function answered({ study, session, journal, server }) {
  const recorder = new Recorder({ journal, server, say, fail: stop, chunks: await journal.chunks() });
  const row = session.place % study.orders.length, pages = study.orders[row], done = recorder.done;
  const progress = document.getElementById("progress");
  const parts = (page) => ({
    consent: study.consent, order: row + 1, text: study.instructions[page.of], of: page.of, world: study.worlds[page.world],
    option: page.option, practice: page.practice, carry: study.carry, method: page.method, question: study.questions[page.question], scale: study.scales[page.scale],
  });
  const timeline = pages.map((page, index) => ({
    type: TASKS[page.task],
    ...parts(page),
    note: (kind, more) => recorder.note(kind, more),
    begin() {
      progress.textContent = `Page ${index + 1} of ${pages.length}`;
      recorder.begin(index);
    },
    finish: async (data) => {
      await recorder.end(data);
      // nothing follows where the page has stopped
      if (hasStopped) await new Promise(() => {});
    },
  })).filter((_, index) => !done.has(index));
  if (timeline.length) await initJsPsych({ display_element: display }).run(timeline);
  progress.textContent = "";
  if (server) {
    show(display, "One moment", make("p", {}, "Your answers are being sent."));
    Object.assign(session, await recorder.finish());
  } else {
    session.code = null;
  }
  await journal.keep(session);
  // a computer that several people use keeps nothing that the server has
  if (server) await journal.clear();
}

// The last page.
function ended({ end, digest, sink }, session, journal, ids) {
  const parts = paragraphs(end.text || "Thank you. That was all.");
  if (sink === "server") {
    parts.push(make("p", {}, "All your answers have arrived. Your code:"), make("p", { class: "code", id: "code" }, session.code));
    parts.push(make("p", {}, "Your number, by which you can have your answers removed: ", make("strong", { id: "number" }, session.participant)));
  } else {
    const save = make("button", { type: "button", id: "save" }, "Save my answers as a file");
    save.addEventListener("click", async () => {
      const chunks = (await journal.chunks()).map(({ trial, number, body }) => [trial, number, body]);
      const text = JSON.stringify({ version: 1, study: digest, key: session.key, platform_ids: ids, chunks });
      const address = URL.createObjectURL(new Blob([text], { type: "application/json" }));
      make("a", { href: address, download: `answers-${session.key.slice(0, 8)}.json` }).click();
      setTimeout(() => URL.revokeObjectURL(address), 60e3);
    });
    parts.push(make("p", {}, "Your answers are in this browser only. Save them, and give the file to whoever asked you to take part."), make("p", {}, save));
  }
  if (end.redirect) parts.push(make("p", {}, make("a", { class: "button", href: end.redirect, rel: "noreferrer" }, "Go on")));
  if (!ids.length) {
    const another = make("button", { type: "button", class: "quiet", id: "another" }, "Another person begins on this computer");
    another.addEventListener("click", async () => {
      await journal.clear("session");
      location.reload();
    });
    parts.push(make("p", {}, another));
  }
  show(display, "The end", ...parts);
}

begin().catch((error) => {
  // the page shows it already
  if (hasStopped) return;
  if (error instanceof Stopped) return stop(error.message);
  if (error.reason) return stop(sentence(error.message));
  stop(`The page stopped (${error.message}). Load it again: what you have answered is kept.`);
  throw error;
});
