// The player: wires the episode in the page to the scene, the charts and the controls.
import { PCFShadowMap, WebGLRenderer } from "three";
import { Cameras } from "./cameras.js";
import { Charts, led } from "./charts.js";
import { Episode, symbol } from "./episode.js";
import { Labels } from "./labels.js";
import { Learned } from "./learned.js";
import { Postures, mark, robotControls } from "./postures.js";
import { Stage } from "./scene.js";
import { TakeOver } from "./takeover.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const ICONS = {
  play: '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M5 2.5v15l12-7.5z"/></svg>',
  pause: '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M4 3h4.4v14H4zM11.6 3H16v14h-4.4z"/></svg>',
};
const PLANTS = { point: "planning level (a point; bodies drawn for orientation)", kinematic: "kinematic plant", rapier: "physical plant" };
const $ = (id) => document.getElementById(id);

const episode = new Episode(JSON.parse($("episode").textContent));
// a link can name a time, a camera and whether to play: #t=9.4&camera=follow&play=0
const asked = new URLSearchParams(location.hash.slice(1));
const isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;
const state = { time: 0, isPlaying: false, speed: 1 };
let takeOver, renderer, stage, charts, learned, cameras, labels, isDirty = true, before = null;

const redraw = () => (isDirty = true);
const { seed, method, plant, robot, alpha, gamma } = episode.facts;
document.title = episode.postures ? episode.title : `${episode.world.name}: ${episode.title}`;
$("title").textContent = episode.world.name;
// for participants of a study: the scene alone
$("player").classList.toggle("stimulus", Boolean(episode.is_stimulus));
$("facts").textContent = episode.facts.about ?? [
  method === null ? "custom policy" : `method ${method}`, PLANTS[plant] ?? plant, robot && `robot ${robot}`,
  alpha === null ? "custom human" : `human α ${round(alpha)}, γ ${round(gamma)}`, `seed ${seed}`,
].filter(Boolean).join(" · ");

controls();
if (episode.take_over) takeOver = new TakeOver($("takeover"), episode);
try {
  scene();
} catch (error) {
  $("failure").hidden = false;
  $("failure").textContent = `This browser cannot draw in three dimensions (${error.message}). The figures and events work without it.`;
}
// the scene comes first: it takes longest
if (!stage) finish();
seek(Number(asked.get("t")) || 0);
if (cameras) choose(asked.get("camera") ?? "overview");
if (episode.postures) collide(asked.get("shapes") === "collisions");
play(asked.get("play") !== "0" && !isStill);
requestAnimationFrame(frame);

function round(value) {
  return Number(value.toFixed(3));
}

function scene() {
  // a picture for another page has that page's background
  const isPicture = asked.has("picture");
  if (isPicture) $("player").classList.add("picture");
  renderer = new WebGLRenderer({ canvas: $("view"), antialias: true, alpha: isPicture });
  // asking for errors waits for every shader
  renderer.debug.checkShaderErrors = false;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  stage = new Stage(episode, redraw);
  if (isPicture) stage.bare();
  stage.update(0);
  cameras = new Cameras($("view"), stage, redraw);
  labels = new Labels($("labels"), stage);
  const resize = () => {
    const { clientWidth: width, clientHeight: height } = $("stage");
    renderer.setSize(width, height, false);
    cameras.resize(width / height);
    labels.measure();
    charts?.layout();
    learned?.layout();
    show();
  };
  new ResizeObserver(resize).observe($("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    stage.paint();
    if (isPicture) stage.bare();
    redraw();
  });
}

// Makes what the first picture does without.
function finish() {
  if (episode.is_stimulus) charts = { update() {}, layout() {} };
  else charts = episode.postures ? new Postures($("charts"), episode) : new Charts($("charts"), episode, seek);
  if (episode.learned) learned = new Learned($("charts"), episode);
  stage?.finish();
  show();
}

function controls() {
  if (episode.postures) robotControls(collide);
  $("time").max = episode.duration;
  $("time").addEventListener("input", () => seek(Number($("time").value)));
  $("play").addEventListener("click", () => play(!state.isPlaying));
  for (const speed of SPEEDS) $("speed").add(new Option(`${speed}×`, speed));
  $("speed").value = 1;
  $("speed").addEventListener("change", () => (state.speed = Number($("speed").value)));
  document.querySelectorAll("#cameras button").forEach((b) => b.addEventListener("click", () => choose(b.dataset.camera)));
  let at = 0;
  for (const [from, to] of [...led(episode), [episode.duration, episode.duration]]) {
    const band = (end, kind) => {
      $("leads").insertAdjacentHTML("beforeend", `<span class="${kind}" style="width:${(100 * (end - at)) / episode.duration}%"></span>`);
      at = end;
    };
    band(from, "robot");
    band(to, "human");
  }
  episode.events.forEach((event, i) => {
    $("marks").insertAdjacentHTML("beforeend", `<span style="left:${(100 * event.time_s) / episode.duration}%"></span>`);
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.type = "button";
    button.innerHTML = `<time>${event.time_s.toFixed(1)} s</time><span></span>`;
    button.lastChild.textContent = event.sentence;
    button.addEventListener("click", () => seek(episode.events[i].time_s));
    item.append(button);
    document.querySelector("#events ol").append(item);
  });
  addEventListener("keydown", key);
}

function key(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const isOn = (selector) => event.target.closest?.(selector);
  const step = (by) => {
    play(false);
    const { decided_s: times } = episode.steps;
    const now = episode.step(state.time);
    const next = by < 0 && state.time > times[now] + 1e-6 ? now : now + by;
    seek(next >= times.length ? episode.duration : times[Math.max(0, next)]);
  };
  const faster = (by) => {
    const i = Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(state.speed) + by));
    $("speed").value = state.speed = SPEEDS[i];
  };
  const jump = (by) => {
    const times = episode.events.map((e) => e.time_s);
    const next = by > 0 ? times.find((t) => t > state.time + 1e-6) : times.filter((t) => t < state.time - 1e-6).pop();
    if (next !== undefined) seek(next);
  };
  const actions = {
    " ": () => play(!state.isPlaying),
    ArrowLeft: () => step(event.shiftKey ? -5 : -1),
    ArrowRight: () => step(event.shiftKey ? 5 : 1),
    ArrowUp: () => faster(1),
    ArrowDown: () => faster(-1),
    Home: () => seek(0),
    End: () => seek(episode.duration),
    1: () => choose("overview"),
    2: () => choose("follow"),
    3: () => choose("shoulder"),
    n: () => jump(1),
    p: () => jump(-1),
    c: episode.postures && (() => collide(!stage?.isColliding)),
  };
  const act = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  // a focused button or list has its own space and arrows
  if (!act || (event.key === " " && isOn("button")) || isOn("select")) return;
  event.preventDefault();
  act();
}

function play(isPlaying) {
  if (isPlaying && state.time >= episode.duration - 1e-6) seek(0);
  state.isPlaying = isPlaying;
  before = null;
  $("play").innerHTML = isPlaying ? ICONS.pause : ICONS.play;
  $("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
}

function choose(name) {
  if (!cameras) return;
  const known = ["overview", "follow", "shoulder"].includes(name) ? name : "overview";
  cameras.choose(known);
  document.querySelectorAll("#cameras button").forEach((b) => b.setAttribute("aria-pressed", b.dataset.camera === known));
  redraw();
}

// Shows the shapes of a robot that collide, or those that are drawn.
function collide(isColliding) {
  mark(isColliding);
  stage?.collide(isColliding);
  redraw();
}

function seek(time) {
  state.time = Math.min(episode.duration, Math.max(0, time));
  show();
  if (cameras) cameras.follow(1);
}

// Shows the present time: figures, words, scene.
function show() {
  const { time } = state, step = episode.step(time), isHuman = episode.isHumanLed(step);
  const preferred = episode.steps.preferred[step];
  charts?.update(episode.postures ? episode.between(time) : time, step);
  learned?.update(time);
  takeOver?.update(time);
  $("clock").textContent = `${time.toFixed(1)} / ${episode.duration.toFixed(1)} s`;
  $("time").value = time;
  $("time").setAttribute("aria-valuetext", `${time.toFixed(1)} seconds, the ${isHuman ? "human" : "robot"} leads`);
  $("player").classList.toggle("human", isHuman);
  const leader = `${isHuman ? "Human" : "Robot"} leads on option ${symbol(episode.steps.executed[step])}`;
  const prefers = preferred && preferred !== episode.steps.executed[step] ? `; human prefers ${symbol(preferred)}` : "";
  if ($("leader-text").innerHTML !== leader + prefers) $("leader-text").innerHTML = leader + prefers;
  const newest = episode.event(time);
  const event = episode.events[newest];
  const together = episode.events.filter((other) => event && other.time_s === event.time_s);
  const words = event?.about === "posture" ? `Posture ${event.sentence}` : event ? `${event.time_s.toFixed(1)} s: ${together.map((e) => e.sentence).join("; ")}` : "";
  if ($("caption").textContent !== words) $("caption").textContent = words;
  $("caption").classList.toggle("old", !episode.postures && (!event || time - event.time_s > 4));
  document.querySelectorAll("#events button").forEach((button, i) => button.setAttribute("aria-current", together.includes(episode.events[i])));
  stage?.update(time);
  redraw();
}

// The areas of the picture in which no label may be: the controls, and the team.
function covered(width, height) {
  const { left, top } = $("stage").getBoundingClientRect();
  const controls = ["cameras", "leader", "caption"].map((id) => {
    const box = $(id).getBoundingClientRect();
    return [box.left - left, box.top - top, box.right - left, box.bottom - top];
  });
  const team = stage.outline().map((place) => place.project(cameras.camera)).filter(({ z }) => z < 1);
  if (!team.length) return controls;
  const [xs, ys] = [team.map(({ x }) => ((x + 1) / 2) * width), team.map(({ y }) => ((1 - y) / 2) * height)];
  return [...controls, [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)]];
}

// After the first picture: says when it was there, and makes the rest.
function first() {
  // waits for the graphics processor
  const context = renderer.getContext();
  context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
  document.body.dataset.drawn = performance.now().toFixed(0);
  finish();
}

function frame(now) {
  if (state.isPlaying) {
    if (before !== null) {
      const passed = Math.min(0.1, (now - before) / 1000);
      state.time = Math.min(episode.duration, state.time + state.speed * passed);
      show();
      cameras?.follow(1 - Math.exp(-2.5 * passed * state.speed));
      if (state.time >= episode.duration) play(false);
    }
    before = now;
  }
  if (isDirty && stage) {
    isDirty = stage.clear(cameras.camera);
    renderer.render(stage.scene, cameras.camera);
    if (!charts) first();
    const { clientWidth: width, clientHeight: height } = $("stage");
    labels.update(cameras.camera, width, height, covered(width, height));
  }
  requestAnimationFrame(frame);
}
