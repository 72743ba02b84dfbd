// Buttons, keys and panels of the page.
import { Vector3, Quaternion } from "three";
import { read } from "../src/episode.js";
import { OWN_PERIOD_S } from "./choices.js";
import * as files from "./files.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const ICONS = {
  play: '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M5 2.5v15l12-7.5z"/></svg>',
  pause: '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M4 3h4.4v14H4zM11.6 3H16v14h-4.4z"/></svg>',
};
const KEYS = {
  own: "<kbd>W</kbd> <kbd>A</kbd> <kbd>S</kbd> <kbd>D</kbd> or arrows move your hand (<kbd>Shift</kbd> faster), <kbd>R</kbd> holds back, <kbd>T</kbd> takes the lead; or drag on the floor, or use a gamepad. <kbd>Space</kbd> play, <kbd>1</kbd> to <kbd>4</kbd> view",
  watch: "<kbd>Space</kbd> play, <kbd>←</kbd> <kbd>→</kbd> one step, <kbd>↑</kbd> <kbd>↓</kbd> speed, <kbd>1</kbd> to <kbd>4</kbd> view, <kbd>N</kbd> <kbd>P</kbd> next and previous event",
};
const VIEWS = ["overview", "follow", "shoulder", "map"];
const WIDE = matchMedia("(min-width: 1280px)");
// Where a wall begins that a button adds, m from the middle between A and B.
const HALF_WALL_M = 0.75;
const $ = (id) => document.getElementById(id);
const press = (button, isPressed) => button.setAttribute("aria-pressed", isPressed);

export class Controls {
  constructor(app) {
    this.app = app;
    this.#transport();
    this.#views();
    this.#carrying();
    this.#world();
    this.#sharing();
    document.querySelectorAll("#tabs button").forEach((button) => button.addEventListener("click", () => this.tab(button.dataset.tab)));
    $("dismiss").addEventListener("click", () => app.warn(""));
    addEventListener("keydown", (event) => this.#key(event));
    addEventListener("keyup", (event) => app.carry.key(event, false));
  }

  #transport() {
    const { app } = this;
    $("play").addEventListener("click", () => app.play(!app.runner.isPlaying));
    $("step").addEventListener("click", () => app.step(1));
    $("again").addEventListener("click", () => this.again());
    for (const speed of SPEEDS) $("speed").add(new Option(`${speed}×`, speed));
    $("speed").value = 1;
    $("speed").addEventListener("change", () => (app.runner.speed = Number($("speed").value)));
  }

  again() {
    const { app } = this, isPlaying = app.runner.isPlaying || app.runner.isAtEnd;
    app.make();
    app.play(isPlaying);
  }

  playing(isPlaying) {
    $("play").innerHTML = isPlaying ? ICONS.pause : ICONS.play;
    $("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    if (!isPlaying) $("slow").textContent = "";
  }

  #views() {
    document.querySelectorAll("#cameras button").forEach((button) => {
      if (button.dataset.camera !== "map" && !this.app.view) button.disabled = true;
      button.addEventListener("click", () => this.camera(button.dataset.camera));
    });
  }

  // Chooses a camera, or the map.
  camera(name) {
    const { app } = this, known = VIEWS.includes(name) ? name : "follow";
    const isMap = known === "map" || !app.view || app.isLost;
    app.showsMap = isMap;
    document.querySelectorAll("#cameras button").forEach((button) => press(button, button.dataset.camera === (isMap ? "map" : known)));
    for (const [id, isShown] of [["view", !isMap], ["labels", !isMap], ["map", isMap], ["map-labels", isMap], ["tools", isMap && !app.choices.isOwn]]) {
      $(id).toggleAttribute("hidden", !isShown);
    }
    $("player").classList.toggle("mapped", isMap);
    if (!isMap) app.view.choose(known);
    app.resize();
  }

  #carrying() {
    const { app } = this, { carry, choices } = app;
    $("own").addEventListener("click", () => {
      if (choices.isOwn) return choices.change({ carry: false });
      // from here on; an episode that has not begun, or is over, begins with a hand that is asked more often
      const hasBegun = app.episode.isRunning && app.core.value("step") > 0;
      choices.change({ carry: true, ...(!hasBegun && { period: OWN_PERIOD_S }) });
      app.seek(app.episode.end);
      app.play(true);
    });
    const hold = (isHeld) => carry.resist(isHeld);
    $("resist").addEventListener("pointerdown", () => hold(true));
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) $("resist").addEventListener(end, () => hold(false));
    $("resist").addEventListener("keydown", (event) => [" ", "Enter"].includes(event.key) && (event.preventDefault(), hold(true)));
    $("resist").addEventListener("keyup", (event) => [" ", "Enter"].includes(event.key) && (event.preventDefault(), hold(false)));
    $("lead").addEventListener("click", () => carry.lead(!carry.isLeading));
  }

  // Shows what a person does.
  stances() {
    const { carry, choices } = this.app;
    press($("own"), choices.isOwn);
    $("own").textContent = choices.isOwn ? "Stop carrying" : "Carry it yourself";
    for (const id of ["resist", "lead"]) $(id).hidden = !choices.isOwn;
    press($("resist"), carry.isResisting);
    press($("lead"), carry.isLeading);
    $("keys").innerHTML = KEYS[choices.isOwn ? "own" : "watch"];
    $("tools").toggleAttribute("hidden", !this.app.showsMap || choices.isOwn);
  }

  #world() {
    const { app } = this, { choices, editor, map } = app;
    const tool = (name) => {
      map.tool = name;
      for (const known of ["move", "wall"]) press($(`tool-${known}`), known === name);
      $("map").classList.toggle("draws", name === "wall");
    };
    $("tool-move").addEventListener("click", () => tool("move"));
    $("tool-wall").addEventListener("click", () => tool("wall"));
    $("add-wall").addEventListener("click", () => this.addWall());
    $("undo").addEventListener("click", () => {
      editor.undo();
      $("undo").disabled = !editor.canUndo;
    });
    $("edit-map").addEventListener("click", () => {
      if (choices.isOwn) choices.change({ carry: false });
      this.camera("map");
      $("tool-move").focus();
    });
    const use = (text) => editor.open(text) && (choices.change({ toml: text }), true);
    const open = async (file) => {
      try {
        app.openFile(file.name, await files.text(file, Math.max(...Object.values(app.catalogue.max_bytes))));
      } catch (error) {
        app.fault("world-fault", error.message);
      }
    };
    $("open").addEventListener("click", () => $("file").click());
    $("file").addEventListener("change", () => {
      if ($("file").files[0]) open($("file").files[0]);
      $("file").value = "";
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer?.files[0]) open(event.dataTransfer.files[0]);
    });
    const paste = (isShown) => {
      $("pasted").hidden = !isShown;
      if (isShown) {
        $("text").value = editor.text;
        $("text").focus();
      } else $("paste").focus();
    };
    $("paste").addEventListener("click", () => paste(true));
    $("cancel").addEventListener("click", () => paste(false));
    $("use").addEventListener("click", () => use($("text").value) && paste(false));
  }

  // A wall in the middle between A and B, to be moved from there.
  addWall() {
    const { editor, map } = this.app, { start: [ax, ay], target: [bx, by] } = editor.drawn.world;
    const middle = [(ax + bx) / 2, (ay + by) / 2], length = Math.hypot(bx - ax, by - ay) || 1;
    const across = [(-(by - ay) / length) * HALF_WALL_M, ((bx - ax) / length) * HALF_WALL_M];
    for (const change of [["begin"], ["wall", [middle[0] - across[0], middle[1] - across[1]], [middle[0] + across[0], middle[1] + across[1]]], ["end"]]) map.edit(...change);
    $("map").querySelector(`[data-item="obstacle:${(editor.file?.obstacle?.length ?? 0) - 1}"]`)?.focus();
  }

  #sharing() {
    const { app } = this;
    const said = (button, words) => {
      const before = button.dataset.words ??= button.textContent;
      button.textContent = $("said").textContent = words;
      setTimeout(() => (button.textContent = before), 1800);
    };
    $("share").addEventListener("click", async () => said($("share"), (await files.copy(await app.address())) ? "Link copied" : "Copy the address above"));
    $("copy-command").addEventListener("click", async () => said($("copy-command"), (await files.copy($("command").textContent)) ? "Copied" : "Select it and copy"));
    document.querySelectorAll("#download [data-file]").forEach((button) => button.addEventListener("click", () => {
      const kind = button.dataset.file;
      if (kind === "scenario") files.save("scenario.toml", app.made.scenario);
      if (kind === "world") files.save("world.toml", app.editor.text);
      if (kind === "log") files.save("episode.json", JSON.stringify(app.core.log()), "application/json");
    }));
    addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !$("download").open) return;
      $("download").open = false;
      $("download").querySelector("summary").focus();
    });
    addEventListener("pointerdown", (event) => !event.target.closest("#download") && ($("download").open = false));
  }

  // An episode was made: the command that gives the same.
  made() {
    const { app } = this;
    $("command").textContent = app.hasDecided ? "cocarry replay episode.json" : app.made.command;
    this.stances();
  }

  ended() {
    if (!WIDE.matches) this.tab("report");
    else $("report").scrollIntoView({ block: "nearest" });
  }

  tab(name) {
    $("player").dataset.tab = name;
    document.querySelectorAll("#tabs button").forEach((button) => press(button, button.dataset.tab === name));
    this.app.plane.layout();
    // charts that were hidden have no cursor yet
    this.app.charts.layout();
    this.app.shown.update();
  }

  rates() {
    const { rates, slow, speed } = this.app.runner;
    const words = slow === null ? "" : `This machine runs it at ${slow.toFixed(2)}× instead of ${speed}×: the steps stay as they are.`;
    if ($("slow").textContent !== words) $("slow").textContent = words;
    if (rates.pictures_per_s === null) return;
    const text = `${rates.pictures_per_s.toFixed(0)} pictures per second, ${(100 * rates.physics_share).toFixed(0)} % of the time for the simulation`;
    if ($("rates").textContent !== text) $("rates").textContent = text;
  }

  // The outlines of the team on the floor, for the map.
  bodies(episode, time) {
    const place = episode.between(time);
    const pose = (poses) => {
      const at = new Vector3(), to = new Vector3(), turned = new Quaternion(), end = new Quaternion();
      read(poses, place.before, at, turned);
      read(poses, place.after, to, end);
      return { at: at.lerp(to, place.part), turned: turned.slerp(end, place.part) };
    };
    const { at, turned } = pose(episode.frames.object), torso = pose(episode.frames.torso).at;
    const [length, width] = episode.world.object_m;
    const corner = (x, y) => {
      const { x: u, y: v } = new Vector3(x, y, 0).applyQuaternion(turned).add(at);
      return [u, v];
    };
    // on the planning level there is no robot: it would be behind the object
    const base = pose(episode.frames.base).at, [x, y] = Number.isFinite(base.x) ? [base.x, base.y] : corner(-length / 2 - 0.45, 0);
    return [
      { kind: "bot", center: [x, y], radius: episode.world.robot_width_m / 2 },
      { kind: "person", center: [torso.x, torso.y], radius: 0.22 },
      { kind: "object", corners: [corner(length / 2, width / 2), corner(length / 2, -width / 2), corner(-length / 2, -width / 2), corner(-length / 2, width / 2)] },
    ];
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const { app } = this, isOn = (selector) => event.target.closest?.(selector);
    if (isOn("input:not(#time):not([type=radio]):not([type=checkbox]), textarea, select, [data-item]")) return;
    if (isOn("input[type=radio]") && event.key.startsWith("Arrow")) return;
    if (app.carry.key(event, true)) return event.preventDefault();
    const { runner, episode } = app;
    const faster = (by) => {
      const i = Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(runner.speed) + by));
      $("speed").value = runner.speed = SPEEDS[i];
    };
    const jump = (by) => {
      const times = episode.events.map(({ time_s }) => time_s);
      const next = by > 0 ? times.find((t) => t > runner.time + 1e-6) : times.filter((t) => t < runner.time - 1e-6).pop();
      if (next !== undefined) app.seek(next);
    };
    const act = {
      " ": () => app.play(!runner.isPlaying),
      ArrowLeft: () => app.step(event.shiftKey ? -5 : -1), ArrowRight: () => app.step(event.shiftKey ? 5 : 1),
      ArrowUp: () => faster(1), ArrowDown: () => faster(-1),
      Home: () => app.seek(0), End: () => app.seek(episode.end),
      1: () => this.camera("overview"), 2: () => this.camera("follow"), 3: () => this.camera("shoulder"), 4: () => this.camera("map"),
      n: () => jump(1), p: () => jump(-1),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act || (event.key === " " && isOn("button, summary, input"))) return;
    event.preventDefault();
    act();
  }
}
