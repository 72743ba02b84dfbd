// Tabs and servers killed at random times: node test/people.mjs PROGRAM kills [TABS [SERVERS [SEED]]]. Several participants at once
// answer through a proxy that doubles requests, delivers the double later than what follows, delays, and drops requests and answers;
// now and then a browser is offline for ten seconds. After every kill the database is sound and has, once, every
// chunk that a browser had an answer for; at the end everybody has a code, and every answer is in the tables once.
import assert from "node:assert/strict";
import { rmSync } from "node:fs";
import { createServer, request as ask } from "node:http";
import { Acknowledged, PAGES, faults, heading, isShown, killed, newStudy, offPage, opened, pageNumber, progress, serve, stored, world } from "./participants.mjs";
import { launch } from "./serving.mjs";

const PEOPLE = 5, OFFLINE_MS = 10e3;
// How long a tab lives at most, ms.
const MAX_LIFE_MS = 3000;
// Of requests, how many suffer what.
const DOUBLED = 0.08, DROPPED = 0.05, UNANSWERED = 0.05, DELAYED = 0.1;

// Numbers from 0 to 1 that a seed gives (mulberry32).
function generator(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

// A proxy between browsers and the server at a port, whose faults have counts.
async function proxy(port, random, acknowledged) {
  const counts = { requests: 0, doubled: 0, late: 0, delayed: 0, dropped: 0, unanswered: 0 };
  const send = (method, path, headers, body) => new Promise((done, fail) => {
    const host = `127.0.0.1:${port}`;
    const given = { ...headers, host, ...(headers.origin && { origin: `http://${host}` }) };
    const sent = ask({ port, host: "127.0.0.1", method, path, headers: given, agent: false }, (answer) => {
      const parts = [];
      answer.on("data", (part) => parts.push(part));
      answer.on("end", () => done({ status: answer.statusCode, headers: answer.headers, body: Buffer.concat(parts) }));
      answer.on("error", fail);
    });
    sent.on("error", fail);
    sent.end(body);
  });
  const server = createServer(async (request, answer) => {
    const parts = [];
    for await (const part of request) parts.push(part);
    const body = Buffer.concat(parts), { method, url, headers } = request;
    const again = () => send(method, url, headers, body);
    const broken = () => request.socket.destroy();
    try {
      if (!url.startsWith("/api/")) {
        const { status, headers: named, body: text } = await again();
        return void answer.writeHead(status, named).end(text);
      }
      counts.requests += 1;
      if (random() < DROPPED) {
        counts.dropped += 1;
        return broken();
      }
      if (random() < DELAYED) {
        counts.delayed += 1;
        await sleep(random() * 1500);
      }
      if (random() < DOUBLED) {
        counts.doubled += 1;
        if (random() < 0.5) {
          // after what the page asks next
          counts.late += 1;
          setTimeout(() => again().catch(() => {}), 500 + random() * 3000);
        } else {
          again().catch(() => {});
        }
      }
      const { status, headers: named, body: text } = await again();
      if (random() < UNANSWERED) {
        counts.unanswered += 1;
        return broken();
      }
      answer.writeHead(status, named).end(text);
      acknowledged.note(url, headers, status === 200);
    } catch {
      broken();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { address: `http://127.0.0.1:${server.address().port}/`, counts, close: () => (server.close(), server.closeAllConnections()) };
}

// Watches a walk and stops it. On a busy computer the walk may be over before the press, or begin anew.
async function watched(tab, number) {
  const isFocused = (text) => tab.evaluate((text) => document.activeElement?.textContent === text, text);
  while ((await progress(tab)).startsWith(`Page ${number} `)) {
    if (await isFocused("Start")) await tab.keyboard.press("Space").then(() => tab.waitForTimeout(1500));
    else if (await tab.locator("text=has arrived").count()) await tab.keyboard.press("Enter");
    else await tab.keyboard.press("Space");
    await tab.waitForTimeout(200);
  }
}

// Begins an answer on the page that is shown, and leaves it; whole where the tab should go on.
async function touched(tab, isWhole) {
  const title = await heading(tab);
  if (title === "The end") return true;
  const number = await pageNumber(tab);
  if (Number.isNaN(number)) return false;
  if (isWhole || title === "Before you begin") {
    await (title.startsWith("When would") ? watched(tab, number) : PAGES[title](tab, { walks: { count: 0 } }));
    await offPage(tab, number).catch(async (error) => {
      throw new Error(`stays on page ${number}: ${await tab.locator("body").innerText()}`, { cause: error });
    });
  } else if (title.startsWith("How likely")) {
    for (const text of ["1", "2", "3"]) {
      await tab.locator(".shares input").first().fill(text);
      await tab.waitForTimeout(200);
    }
  } else if (title.startsWith("When would") || title === "Carry along") {
    await tab.keyboard.press("Space");
  }
  return false;
}

export async function run(program, tabs = 20, servers = 2, seed = 1) {
  const random = generator(seed), acknowledged = new Acknowledged();
  const study = newStudy(program, { "short.toml": world("Short") });
  let { server, port } = await serve(study);
  const browser = await launch();
  const between = await proxy(port, random, acknowledged);
  const done = { tabs: 0, crashed: 0, servers: 0, offline: 0 }, began = Date.now();
  const codes = new Set();

  // kills tabs of one person as long as there are some to kill, then goes to the end
  async function person(index) {
    const context = await browser.newContext({ viewport: { width: index % 2 ? 390 : 1024, height: 760 } });
    const query = `?PROLIFIC_PID=killed${index}`;
    const open = async () => {
      for (;;) {
        try {
          const tab = await opened(context, between.address, query);
          return tab;
        } catch {
          // the page itself was asked for while the server was dead
          await Promise.all(context.pages().map((tab) => tab.close()));
          await sleep(200);
        }
      }
    };
    let tab = await open();
    while (done.tabs < tabs) {
      // one in three answers a page before it dies
      const isWhole = random() < 0.33, life = random() * MAX_LIFE_MS;
      const acting = isShown(tab).then(() => touched(tab, isWhole)).catch(() => false);
      await (isWhole ? acting : Promise.race([acting.then(() => sleep(life)), sleep(life)]));
      if (done.offline < tabs / 20 && random() < 0.1) {
        done.offline += 1;
        await context.setOffline(true);
        await sleep(OFFLINE_MS);
        await context.setOffline(false);
      }
      done.tabs += 1;
      if (random() < 0.5) {
        // its process dies
        done.crashed += 1;
        const protocol = await context.newCDPSession(tab);
        protocol.send("Page.crash").catch(() => {});
        await Promise.race([new Promise((crashed) => tab.once("crash", crashed)), sleep(5000)]);
      }
      await tab.close();
      acknowledged.check(study);
      tab = await open();
    }
    for (;;) {
      await isShown(tab);
      // loaded while the server was dead
      if (await tab.locator("#stopped").count()) await sleep(300).then(() => tab.reload()).catch(() => {});
      else if (await touched(tab, true)) break;
    }
    await tab.waitForSelector("#code", { timeout: 60e3 });
    codes.add(await tab.locator("#number").textContent());
    assert.deepEqual(faults(tab), []);
    await context.close();
  }

  // kills the server, as often and as spread
  async function killer() {
    while (done.servers < servers) {
      const next = (done.servers + random()) * (tabs / servers);
      while (done.tabs < Math.min(next, tabs - 1)) await sleep(50);
      await sleep(random() * 1000);
      await killed(server);
      done.servers += 1;
      await sleep(random() * 1000);
      ({ server } = await serve(study, port));
      acknowledged.check(study);
    }
  }
  try {
    await Promise.all([killer(), ...Array.from({ length: PEOPLE }, (_, index) => person(index))]);
    await sleep(4000);
    const { acknowledged: count, stored: chunks } = acknowledged.check(study);
    const { sessions, chunks: all } = stored(study);
    assert.deepEqual(sessions.map(([name, isFinished]) => [codes.has(name), isFinished]), sessions.map(() => [true, 1]));
    assert.equal(sessions.length, PEOPLE);
    assert.equal(all.length, chunks);
    study.cocarry("study", "collect", "study.toml", "-o", "answers");
    assert.ok(study.table("answers/participants.csv").every(({ flags }) => !flags.includes("left-out")));
    assert.equal(study.table("answers/answers.csv").length, 2 * PEOPLE);
    assert.equal(study.table("answers/switches.csv").length, 2 * PEOPLE);
    console.log(`${done.tabs} kills of tabs (${done.crashed} of their process), ${done.servers} of the server, ${done.offline} times offline for 10 s: ${count} of ${count} acknowledged chunks stored, once; ${chunks} chunks in all; requests: ${JSON.stringify(between.counts)}; ${study.table("answers/switches.csv").filter(({ plays }) => plays !== "1").length} walks were shown anew; ${Math.round((Date.now() - began) / 1000)} s`);
  } finally {
    await browser.close();
    between.close();
    server.kill("SIGKILL");
    rmSync(study.folder, { recursive: true });
  }
}
