// The page of a study: session, journal and pages in their order. Reloaded, it goes on at the first page that is not done.
import { initJsPsych } from "jspsych";
import { CarryAlong } from "./carry.js";
import { Journal } from "./journal.js";
import { make, paragraphs, show } from "./page.js";
import { Percentages } from "./percentages.js";
import { Recorder, hex, sentence, wholeDigest } from "./recorder.js";
import { Refused, Server } from "./server.js";
import { DataPipe, Download, Jatos, saved } from "./sinks.js";
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
function platformIds({ platform_ids: names, sink }) {
  const given = { ...Object.fromEntries(new URLSearchParams(location.search)), ...(sink === "jatos" && Jatos.parameters()) };
  return names.map((name) => [name, given[name]]).filter(([, value]) => value && /^[\w-]{1,200}$/.test(value));
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
  if (study.sink === "jatos") await Jatos.loaded();
  const ids = platformIds(study);
  const name = [study.digest, ...ids.slice(0, 1).flat()].join(" ");
  if (!(await locked(`cocarry study ${name}`))) throw new Stopped("This study is open in another tab or window already. Go on there, or close it and load this page again.");
  const journal = await opened(name);
  let session = await journal.session();
  if (!session) {
    session = { key: random(32) };
    // before the server knows it, so that it is the same after a reload
    await journal.keep(session);
  }
  const sink = SINKS[study.sink]({ study: study.digest, key: session.key, ids }, study);
  if (session.place === undefined) {
    Object.assign(session, await sink.begin(ids, study.digest));
    await journal.keep(session);
  }
  if (!session.isDone) await answered({ study, session, journal, sink });
  ended(study, session, journal, ids);
}

const SINKS = {
  server: ({ key }) => new Server(key, say),
  jatos: (session) => new Jatos(session, say),
  datapipe: (session, { datapipe }) => new DataPipe(session, say, datapipe),
  download: () => new Download(),
};

const TASKS = { consent: Consent, instructions: Instructions, percentages: Percentages, switch: Switch, carry: CarryAlong, question: Question, scale: Scale };

// Goes through the pages that are not done, and ends the session.
async function answered({ study, session, journal, sink }) {
  const recorder = new Recorder({ journal, sink, say, fail: stop, chunks: await journal.chunks() });
  const row = session.place % study.orders.length, pages = study.orders[row], done = recorder.done;
  const progress = document.getElementById("progress");
  const parts = (page) => ({
    consent: study.consent, order: row + 1, text: study.instructions[page.of], of: page.of, world: study.worlds[page.world],
    option: page.option, repetition: page.repetition, practice: page.practice, carry: study.carry, method: page.method, question: study.questions[page.question], scale: study.scales[page.scale],
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
  show(display, "One moment", make("p", {}, "Your answers are being sent."));
  try {
    Object.assign(session, await recorder.finish());
  } catch (error) {
    // what is not taken goes into a file, which a participant can hand over; our own server has a reason not to
    if (!(error instanceof Refused) || study.sink === "server") throw error;
    Object.assign(session, { isDownload: true, why: sentence(error.message) });
  }
  session.isDone = true;
  await journal.keep(session);
  // a computer that several people use keeps nothing that the sink has
  if (!session.isDownload) await journal.clear();
}

// What is shown once the answers have arrived somewhere: a code, and where to go on.
function receipt({ end }, { code = end.code, participant }) {
  const parts = [];
  if (code) parts.push(make("p", {}, "Your code:"), make("p", { class: "code", id: "code" }, code));
  if (participant) parts.push(make("p", {}, "Your number, by which you can have your answers removed: ", make("strong", { id: "number" }, participant)));
  if (end.redirect) parts.push(make("p", {}, make("a", { class: "button", href: end.redirect, rel: "noreferrer" }, "Go on")));
  return make("div", { id: "receipt" }, ...parts);
}

// A button that saves the session as a file; `onSaved` is called when it was.
function download({ digest: study }, session, journal, ids, onSaved) {
  const save = make("button", { type: "button", id: "save" }, "Save my answers as a file");
  save.addEventListener("click", async () => {
    const chunks = await journal.chunks(), digest = await wholeDigest(chunks);
    const address = URL.createObjectURL(new Blob([saved({ study, key: session.key, ids }, chunks, { digest })], { type: "application/json" }));
    make("a", { href: address, download: `answers-${session.key.slice(0, 8)}.json` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 60e3);
    await onSaved();
  });
  return save;
}

// The last page.
function ended(study, session, journal, ids) {
  const parts = paragraphs(study.end.text || "Thank you. That was all."), received = receipt(study, session);
  if (session.isDownload) {
    received.hidden = !session.isSaved;
    const save = download(study, session, journal, ids, async () => {
      session.isSaved = true;
      await journal.keep(session);
      received.hidden = false;
    });
    if (session.why) parts.push(make("p", {}, session.why));
    parts.push(make("p", {}, "Your answers are in this browser only. Save them, and give the file to whoever asked you to take part."), make("p", {}, save));
  } else {
    parts.push(make("p", {}, "All your answers have arrived."));
  }
  parts.push(received);
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
