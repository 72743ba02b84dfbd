// Participants of `cocarry study` in Chromium: node test/people.mjs PROGRAM. One goes through everything with the keyboard
// alone, while requests are doubled, lose their answers and fail, the page is reloaded and closed, and the server is killed.
// Nothing that the server acknowledged is lost, nothing is counted twice, and every page keeps the rules of axe-core.
//   node test/people.mjs PROGRAM simulated [N]       people of known alpha, gamma and eta: simulated.mjs
//   node test/people.mjs PROGRAM hands               touch and gamepad in the task carry alone
//   node test/people.mjs PROGRAM kills [TABS SERVERS]    tabs and servers killed at random times: kills.mjs
import assert from "node:assert/strict";
import { existsSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import {
  Acknowledged, PAGES, carries, faults, goThrough, isReady, killed, leftAndBack, looked, needPeople, newStudy, onPage, opened, serve, simulator, stored, world,
} from "./participants.mjs";
import { launch, serve as serveFolder } from "./serving.mjs";

const [program, mode, ...words] = process.argv.slice(2);
needPeople(program);
if (mode === "kills" || mode === "simulated") {
  await (await import(`./${mode}.mjs`)).run(program, ...words.map(Number));
  process.exit(0);
}
// the scale "robot" asks Hoffman's statements
const study = newStudy(program, { "short.toml": world("Short") }, (text) => text
  .replace(/kind = "likert"\nstatements[^]*?\npoints[^]*?\nends[^\n]*\n/, 'kind = "fluency"\n')
);
const { folder, cocarry } = study;

const browser = await launch();
let { server, address, port } = await serve(study);
const acknowledged = new Acknowledged();
const counts = { doubled: 0, unanswered: 0, failed: 0 };

// A participant's browser, in which requests suffer: `some` says how many in ten of each kind do.
async function participant({ width, height, some = 0 }) {
  const context = await browser.newContext({ viewport: { width, height } });
  let n = 0;
  await context.route("**/api/**", async (route) => {
    const request = route.request(), headers = request.headers();
    const body = request.postData() ?? undefined;
    const send = () => fetch(request.url(), { method: request.method(), headers: { ...headers, origin: address.slice(0, -1) }, body });
    n += 1;
    try {
      if (n % 10 < some) {
        counts.doubled += 1;
        await send();
      } else if (n % 10 < 2 * some) {
        counts.unanswered += 1;
        await send();
        return await route.abort("connectionreset");
      } else if (n % 10 < 3 * some) {
        counts.failed += 1;
        return await route.abort("connectionrefused");
      }
      const answer = await send();
      acknowledged.note(request.url(), headers, answer.ok);
      await route.fulfill({ status: answer.status, contentType: "application/json", body: await answer.text() });
    } catch {
      await route.abort("connectionrefused").catch(() => {});
    }
  });
  return context;
}

// One participant, wide screen, every fault.
async function one() {
  const context = await participant({ width: 1024, height: 760, some: 1 });
  let tab = await opened(context, address);
  const seen = new Set();
  tab = await goThrough(tab, async (number, title) => {
    if (!seen.has(title)) {
      seen.add(title);
      await looked(tab, `${seen.size}-wide`);
    }
    if (title.startsWith("How likely") && number === 5) {
      // a half answer, and the page is loaded anew
      await tab.locator(".shares input").first().fill("12");
      await tab.waitForTimeout(1300);
      await tab.reload();
      await onPage(tab, number);
      assert.equal(await tab.locator(".shares input").first().inputValue(), "");
      const other = await opened(context, address);
      assert.match(await other.locator("#stopped").textContent(), /open in another tab/);
      await other.close();
    }
    if (title === "The robot leads") {
      // the tab breaks down, and another one is opened
      await tab.close();
      tab = await opened(context, address);
      await onPage(tab, number);
    }
    if (title === "How was it?") {
      // the server is killed; the participant goes on, and is told
      await killed(server);
      await PAGES[title](tab, {});
      await tab.waitForFunction(() => document.getElementById("status").textContent.includes("connection is interrupted"), null, { timeout: 30e3 });
      await onPage(tab, number + 1);
      acknowledged.check(study);
      ({ server } = await serve(study, port));
    }
    return tab;
  });
  await tab.waitForSelector("#code", { timeout: 60e3 });
  await looked(tab, "end-wide");
  const [code, number] = [await tab.locator("#code").textContent(), await tab.locator("#number").textContent()];
  assert.match(code, /^[0-9A-F]{8}$/);
  await leftAndBack(tab);
  assert.equal(await tab.locator("#code").textContent(), code);
  await tab.reload();
  assert.equal(await tab.locator("#code").textContent(), code);
  assert.deepEqual(faults(tab), []);
  await context.close();
  const { sessions } = stored(study);
  assert.deepEqual(sessions, [[number, 1]]);
  const { acknowledged: count, stored: chunks } = acknowledged.check(study);
  console.log(`one participant by keyboard: ${seen.size} kinds of pages, ${count} chunks acknowledged of ${chunks} stored; requests: ${JSON.stringify(counts)}`);
  return number;
}

// What was answered is in the tables, and the fits read them.
function collected(number) {
  assert.match(cocarry("study", "check", "study.toml"), /sound; 1 began, 1 finished/);
  cocarry("study", "collect", "study.toml", "-o", "study-answers");
  const table = (name) => readFileSync(join(folder, "study-answers", name), "utf8").trim().split("\n").map((line) => line.split(","));
  const answers = table("answers.csv").slice(1).map((row) => row.slice(0, 4).join(","));
  assert.deepEqual(answers, [`${number},worlds/short.toml,1,30`, `${number},worlds/short.toml,2,70`]);
  const switches = table("switches.csv").slice(1);
  assert.equal(switches.length, 2);
  const [stopped, followed] = ["3", ""].map((_, i) => switches[i]);
  const ms = Number(stopped[4]);
  assert.equal(Number(stopped[3]), Math.floor(ms / 200));
  // the key came 3.1 s after the start, by the clock of this program
  assert.ok(ms > 2900 && ms < 4500, `${ms} ms`);
  assert.ok(Number(stopped[5]) > 10, `${stopped[5]} pictures`);
  assert.deepEqual(followed.slice(3, 6), ["", "", ""]);
  if (carries) {
    const [header, row, ...others] = table("carries.csv");
    assert.equal(others.length, 0);
    const carried = Object.fromEntries(header.map((name, i) => [name, row[i]]));
    assert.equal(carried.differs_within_s, "", "run again, it is another episode");
    assert.ok(Number(carried.human_led_from_s) > 0.5, JSON.stringify(carried));
    assert.ok(["1", "2", ""].includes(carried.options_walked), carried.options_walked);
    assert.match(cocarry("replay", `study-answers/${carried.recording}`), /identical/);
    console.log(`carried: ${carried.outcome} after ${carried.duration_s} s, led from ${carried.human_led_from_s} s; the log gives the same episode, digest by digest`);
  }
  // two questions, six scales of workload, 23 statements about fluency with the means of seven subscales: all have answer 5
  const responses = study.table("study-answers/responses.csv");
  assert.equal(responses.length, 2 + 6 + 23 + 7);
  const mean = (name) => responses.find(({ item }) => item === `mean: ${name}`).answer;
  assert.deepEqual([mean("human-robot fluency"), mean("robot relative contribution")], ["5.000", "4.000"]);
  const { flags, eta_group: group } = study.table("study-answers/participants.csv")[0];
  assert.ok(["", "5", "10.5", "15"].includes(group), group);
  assert.ok(!flags.includes("left-out"), flags);
  cocarry("fit", "risk-weight", "study-answers/answers.csv", "--resamples", "40");
  cocarry("fit", "eta", "study-answers/switches.csv");
  cocarry("infer", "study-answers/answers.csv", "study-answers/switches.csv", "--draws", "100");
  console.log(`collected: a switch after ${ms} ms is step ${stopped[3]}; fit and infer read the tables; flags: ${flags || "none"}`);
}

// A narrow screen; killed tabs and servers at any time; then the person is forgotten.
async function killedOften() {
  const context = await participant({ width: 390, height: 800 });
  const query = "?PROLIFIC_PID=abc123def456&STUDY_ID=study1234567";
  let tab = await opened(context, address, query), kills = 0, closed = 0;
  const seen = new Set();
  tab = await goThrough(tab, async (number, title) => {
    if (!seen.has(title)) {
      seen.add(title);
      await looked(tab, `${seen.size}-narrow`);
    }
    if (title.startsWith("How likely")) {
      for (let round = 0; round < 5; round++) {
        await tab.locator(".shares input").first().fill(String(10 + round));
        // at another part of a second every time
        await tab.waitForTimeout((round * 377) % 1000);
        await killed(server);
        kills += 1;
        ({ server } = await serve(study, port));
        acknowledged.check(study);
        await tab.locator(".shares input").nth(1).fill(String(20 + round));
        await tab.waitForTimeout((round * 577) % 1300);
        await tab.close();
        closed += 1;
        tab = await opened(context, address, query);
        await onPage(tab, number);
      }
    }
    return tab;
  });
  await tab.waitForSelector("#code", { timeout: 60e3 });
  await looked(tab, "end-narrow");
  const number = await tab.locator("#number").textContent();
  await context.close();
  acknowledged.check(study);
  // the same person in another browser
  const again = await participant({ width: 390, height: 800 });
  const refused = await opened(again, address, query);
  await refused.waitForSelector("#stopped");
  assert.match(await refused.locator("#stopped").textContent(), /already, in another browser/);
  await again.close();
  const has = (text) => ["study.sqlite", "study.sqlite-wal"].some((name) => {
    try {
      return readFileSync(join(folder, name)).includes(text);
    } catch {
      return false;
    }
  });
  assert.ok(has("abc123def456") && has(number));
  // while the server runs
  assert.match(cocarry("study", "forget", "study.toml", "abc123def456"), new RegExp(`^${number} is removed: \\d+ chunks and 2 parameters`));
  assert.ok(!has("abc123def456") && !has(number));
  assert.deepEqual(stored(study).integrity, [["ok"]]);
  assert.equal(stored(study).sessions.length, 1);
  console.log(`${kills} kills of the server and ${closed} of the tab: nothing acknowledged was lost; the person is forgotten`);
}

// A finger, the buttons beside the picture, and a gamepad carry; what they sent is recorded.
async function handled() {
  const other = newStudy(program, { "short.toml": world("Short") }, (text) => text.replace('["percentages", "switch", "carry"]', '["carry"]').replace(/\[practice\]\nworld[^\n]*\n/, ""));
  const running = await serve(other);
  const notes = async (act, options, before) => {
    const context = await browser.newContext(options);
    if (before) await context.addInitScript(before);
    const kinds = new Map(), bodies = [];
    context.on("request", (request) => /\/api\/chunks\//.test(request.url()) && bodies.push(request.postData()));
    const tab = await goThrough(await opened(context, running.address), async (number, title) => {
      if (title === "Carry along") await looked(tab0(context), `carry-${options.viewport.width}`);
      return tab0(context);
    }, { ...PAGES, "Carry along": async (tab) => {
      await isReady(tab);
      await tab.keyboard.press("Enter");
      await tab.waitForTimeout(800);
      await act(tab);
      await isReady(tab, "Continue");
      await tab.keyboard.press("Enter");
    } });
    assert.deepEqual(faults(tab), []);
    await context.close();
    for (const record of bodies.flatMap((body) => JSON.parse(body))) kinds.set(record.kind, [...(kinds.get(record.kind) ?? []), record.data]);
    return kinds;
  };
  const tab0 = (context) => context.pages()[0];
  const pressed = (tab, name) => tab.waitForFunction((name) => [...document.querySelectorAll('main button[aria-pressed="true"]')].some((button) => button.textContent.startsWith(name)), name);
  const touched = await notes(async (tab) => {
    const protocol = await tab.context().newCDPSession(tab);
    const touch = (type, ...points) => protocol.send("Input.dispatchTouchEvent", { type, touchPoints: points });
    const middle = async (selector) => {
      const { x, y, width, height } = await tab.locator(selector).boundingBox();
      return { x: x + width / 2, y: y + height / 2 };
    };
    const stage = await middle("#map"), [lead, resist] = [await middle("button:has-text('lead')"), await middle("button:has-text('Resist')")];
    await tab.touchscreen.tap(lead.x, lead.y);
    await pressed(tab, "Give");
    await touch("touchStart", { ...stage, id: 1 });
    for (let i = 0; i < 10; i++) {
      await touch("touchMove", { x: stage.x + 4 * i, y: stage.y, id: 1 });
      await tab.waitForTimeout(80);
    }
    // a second finger holds the button
    await touch("touchStart", { x: stage.x + 36, y: stage.y, id: 1 }, { ...resist, id: 2 });
    await pressed(tab, "Resist");
    await touch("touchEnd");
    await tab.touchscreen.tap(lead.x, lead.y);
  }, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  assert.ok(touched.get("pointermove").length > 3 && touched.get("pointerdown")[0].by === "touch", "a finger");
  assert.deepEqual(touched.get("resist").map(({ on }) => on), [true, false]);
  const padded = await notes(async (tab) => {
    const pad = (change) => tab.evaluate((change) => Object.assign(globalThis.pad, change), change);
    const buttons = (lead, resist) => [{ pressed: lead }, { pressed: resist }];
    await pad({ buttons: buttons(true, false) });
    await pressed(tab, "Give");
    // some planning steps under this lead, before one holds back
    await pad({ axes: [1, 0], buttons: buttons(false, false) });
    await tab.waitForTimeout(800);
    await pad({ axes: [1, 0], buttons: buttons(false, true) });
    await pressed(tab, "Resist");
    await tab.waitForTimeout(800);
    await pad({ axes: [0, 0], buttons: buttons(true, false) });
  }, { viewport: { width: 1024, height: 760 } }, () => {
    globalThis.pad = { connected: true, axes: [0, 0], buttons: [{ pressed: false }, { pressed: false }] };
    navigator.getGamepads = () => [globalThis.pad];
  });
  assert.ok(padded.get("gamepad").some(({ stick, pressed }) => stick[0] === 1 && pressed.includes(1)), JSON.stringify(padded.get("gamepad")));
  running.server.kill("SIGKILL");
  other.cocarry("study", "collect", "study.toml", "-o", "answers");
  const carried = other.table("answers/carries.csv");
  assert.deepEqual(carried.map(({ differs_within_s, human_led_from_s }) => [differs_within_s, human_led_from_s !== ""]), [["", true], ["", true]]);
  rmSync(other.folder, { recursive: true });
  console.log(`hands: ${touched.get("pointermove").length} moves of a finger, a button held by a second one, and a gamepad are recorded, lead and resist; both episodes replay equal`);
}

// Those who have finished; the table has all who began.
const participants = (of = "study") => {
  const table = `${of}-answers/participants.csv`;
  return existsSync(join(folder, table)) ? study.table(table).filter(({ finished_utc }) => finished_utc).length : 0;
};
const collect = (file, of = "study") => cocarry("study", "collect", `${of}.toml`, "--add", file, "-o", `${of}-answers`, "--overwrite");
// Builds the page of the study `name`, or of a brief one, for a sink, with a code that all get, and serves it as any host does.
// The brief one has no walks and no carrying: they take a minute, and their records are brought by the others.
async function built(name, edit, ...sink) {
  writeFileSync(join(folder, `${name}.toml`), edit(readFileSync(join(folder, "study.toml"), "utf8").replace("# code = ", "code = ")));
  cocarry("study", "build", `${name}.toml`, "-o", name, ...sink, ...simulator);
  return serveFolder(join(folder, `${name}/`));
}
const whole = (text) => text, brief = (text) => text.replace(/^tasks = .*$/m, 'tasks = ["percentages"]');

// Plain files on any host: the participant saves a file, and has a code only then.
async function withoutServer() {
  const host = await built("site", whole);
  const context = await browser.newContext({ viewport: { width: 1024, height: 760 }, acceptDownloads: true });
  const tab = await goThrough(await opened(context, host.address));
  assert.ok(!(await tab.locator("#code").isVisible()));
  await looked(tab, "end-saved");
  const [saved] = await Promise.all([tab.waitForEvent("download"), tab.locator("#save").click()]);
  await saved.saveAs(join(folder, "saved.json"));
  await tab.locator("#code").waitFor();
  await tab.reload();
  assert.equal(await tab.locator("#code").textContent(), "C0FFEE");
  assert.deepEqual(faults(tab), []);
  await context.close();
  host.close();
  const before = participants();
  for (const _ of [1, 2]) assert.match(collect("saved.json"), /added saved.json as p\w+\n/);
  assert.equal(participants(), before + 1);
  console.log("without a server: the code is shown after the download; the file that a participant saves is added once");
}

// JATOS, by a stub of its published functions: a host that has jatos.js next to the page, keeps lines, and fails at times.
const JATOS = `
let n = 0;
const kept = () => localStorage.getItem("result") ?? "";
const later = (act) => new Promise((done, fail) => setTimeout(() => (++n % 5 === 2 ? fail("no connection") : done(act())), 20));
globalThis.jatos = {
  urlQueryParameters: { PROLIFIC_PID: "jatos123456" },
  onLoad: (callback) => setTimeout(callback, 50),
  appendResultData: (text) => later(() => localStorage.setItem("result", kept() + text)),
  endStudyWithoutRedirect: (isGood) => later(() => localStorage.setItem("ended", String(isGood))),
};`;
async function inJatos() {
  const host = await built("jatos", brief, "--sink", "jatos");
  const context = await browser.newContext({ viewport: { width: 390, height: 800 } });
  // outside of it a sentence says so
  const outside = await opened(context, host.address);
  await outside.waitForSelector("#stopped");
  assert.match(await outside.locator("#stopped").textContent(), /made for JATOS, and is not in it/);
  await outside.close();
  writeFileSync(join(folder, "jatos/jatos.js"), JATOS);
  const host2 = await serveFolder(join(folder, "jatos/"));
  let tab = await opened(context, host2.address), isEarly = true;
  const result = () => tab.evaluate(() => localStorage.getItem("result"));
  tab = await goThrough(tab, async (number) => {
    if (number === 4 && isEarly) {
      isEarly = false;
      await tab.waitForTimeout(1500);
      writeFileSync(join(folder, "early.txt"), await result());
      await tab.reload();
      await onPage(tab, number);
    }
    return tab;
  });
  await tab.locator("#code").waitFor();
  await looked(tab, "end-jatos");
  assert.equal(await tab.locator("#code").textContent(), "C0FFEE");
  assert.equal(await tab.evaluate(() => localStorage.getItem("ended")), "true");
  writeFileSync(join(folder, "results.txt"), await result());
  assert.deepEqual(faults(tab), []);
  await context.close();
  host.close();
  host2.close();
  assert.match(collect("early.txt", "jatos"), /, which has no end\n/);
  assert.equal(participants("jatos"), 0);
  for (const _ of [1, 2]) assert.match(collect("results.txt", "jatos"), /added results.txt as p\w+\n/);
  assert.equal(participants("jatos"), 1);
  console.log("JATOS (a stub of its functions): results of a session so far, and of the whole one, are added once");
}

// DataPipe, by a stub of its published address: it fails, loses a receipt, and knows the file the second time.
async function throughDataPipe() {
  const host = await built("datapipe", whole, "--sink", "datapipe=abc123");
  const briefHost = await built("refusing", brief, "--sink", "datapipe=abc123");
  const files = new Map(), answers = [];
  const through = async (answer, { address } = host) => {
    const context = await browser.newContext({ viewport: { width: 390, height: 800 } });
    await context.route("https://pipe.jspsych.org/api/data/", async (route) => {
      if (route.request().method() === "OPTIONS") return route.fulfill({ status: 204, headers: { "access-control-allow-origin": "*", "access-control-allow-headers": "*" } });
      const { experimentID, filename, data } = JSON.parse(route.request().postData());
      assert.equal(experimentID, "abc123");
      return answer(route, filename, data);
    });
    const tab = await goThrough(await opened(context, address));
    return { context, tab };
  };
  const reply = (route, status, body) => route.fulfill({ status, headers: { "access-control-allow-origin": "*" }, contentType: "application/json", body: JSON.stringify(body) });
  const { context, tab } = await through((route, filename, data) => {
    answers.push(filename);
    if (answers.length === 1) return reply(route, 400, { error: "OSF_UPLOAD_ERROR" });
    if (files.has(filename)) return reply(route, 400, { error: "OSF_FILE_EXISTS" });
    files.set(filename, data);
    return route.abort("connectionreset");
  });
  await tab.locator("#code").waitFor();
  assert.deepEqual([answers.length, files.size], [3, 1]);
  assert.deepEqual(faults(tab).filter((fault) => fault !== "asked https://pipe.jspsych.org/api/data/"), []);
  // the page may send nothing anywhere else
  assert.equal(await tab.evaluate(() => fetch("https://example.org/").then(() => "sent", () => "refused")), "refused");
  await context.close();
  const [[name, data]] = files;
  writeFileSync(join(folder, name), data);
  const before = participants();
  for (const _ of [1, 2]) collect(name);
  assert.equal(participants(), before + 1);
  // what DataPipe does not take, the participant saves
  const refused = await through((route) => reply(route, 400, { error: "DATA_COLLECTION_NOT_ACTIVE" }), briefHost);
  assert.ok(!(await refused.tab.locator("#code").isVisible()));
  await looked(refused.tab, "end-refused");
  const [saved] = await Promise.all([refused.tab.waitForEvent("download"), refused.tab.locator("#save").click()]);
  await saved.saveAs(join(folder, "refused.json"));
  await refused.tab.locator("#code").waitFor();
  await refused.context.close();
  collect("refused.json", "refusing");
  assert.equal(participants("refusing"), 1);
  host.close();
  briefHost.close();
  console.log("DataPipe (a stub of its address): a failure and a lost receipt give one file, which is added once; what it refuses is saved");
}

try {
  if (mode === "hands") await handled();
  else {
    collected(await one());
    await killedOften();
    if (carries) await handled();
    await withoutServer();
    await inJatos();
    await throughDataPipe();
  }
} finally {
  await browser.close();
  server.kill("SIGKILL");
  rmSync(folder, { recursive: true });
}
