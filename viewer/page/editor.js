// The world that is shown and changed: every change is drawn at once where it is a world, and refused with the module's
// sentence where it is none; then the last good one stays.
import * as edit from "./edit.js";

export class Editor {
  // `most` is what a world file may have, bytes. `draw` gets every good world as the module draws it; `fault` a sentence,
  // or nothing; `done` the text of a change.
  constructor(module, most, { draw, fault, done }) {
    Object.assign(this, { module, most, tell: fault, draw, done, undone: [], robotWidth: null });
  }

  // Draws the same world for a robot of another width, m.
  fit(robotWidth) {
    if (robotWidth === this.robotWidth) return;
    this.robotWidth = robotWidth;
    if (this.text !== undefined) this.#try(this.text);
  }

  // Shows a world from its text. Returns whether it is one; else the last good one stays.
  open(text) {
    this.undone = [];
    return this.#try(text);
  }

  #try(text) {
    const { size } = new Blob([text]);
    if (size > this.most) return this.#refuse(`this world has ${size} bytes; expected at most ${this.most}`);
    try {
      const world = this.module.world({ text, file: "world.toml", robot_width_m: this.robotWidth ?? undefined, regions: true });
      Object.assign(this, { text, drawn: { ...world, world }, file: parsed(text) });
    } catch (error) {
      if (error.name !== "Refused") throw error;
      return this.#refuse(error.message);
    }
    this.tell("");
    this.draw(this.drawn, this.file);
    return true;
  }

  #refuse(sentence) {
    this.tell(sentence);
    return false;
  }

  // A change by mouse, touch or keys: "begin" and "end" enclose what is one for `undo`.
  change(kind, ...words) {
    if (!this.file) return this.tell("this world cannot be changed here");
    if (kind === "begin") Object.assign(this, { held: { text: this.text, file: this.file }, isChanged: false });
    else if (kind === "end") {
      if (this.isChanged) {
        this.undone.push(this.held.text);
        this.done(this.text);
      }
      this.held = null;
    } else {
      const next = this.#changed(kind, words);
      if (next && this.#show(next, kind === "wall" || kind === "remove")) this.isChanged = true;
    }
  }

  #changed(kind, words) {
    // a drag moves from where it began, a key from where the thing is
    const { file } = this.held;
    if (kind === "wall") {
      const next = edit.wall(file, ...words);
      return next === file ? null : next;
    }
    const [item, ...rest] = words;
    const index = item.startsWith("obstacle:") ? Number(item.slice(9)) : null;
    if (index === null) return kind === "move" ? edit.moveEnd(file, item, ...rest) : null;
    if (kind === "turn" && !edit.isTurnable(file.obstacle[index])) return null;
    return edit[kind](file, index, ...rest);
  }

  // Tries a changed world with the openings and options that it declares, and where they no longer hold, with those that
  // are found.
  #show(next, isNew) {
    const isDeclared = edit.hasDeclared(next);
    if (isDeclared && !isNew && this.#try(edit.written(next))) return true;
    if (!this.#try(edit.written(next, true))) return false;
    // what a moved obstacle closed can be opened again; a new wall makes other openings
    if (!isNew) this.file = next;
    return true;
  }

  get canUndo() {
    return this.undone.length > 0;
  }

  undo() {
    const text = this.undone.pop();
    if (text !== undefined && this.#try(text)) this.done(text);
  }
}

// The parsed text of a world; nothing where this page cannot change it.
function parsed(text) {
  try {
    const world = edit.read(text);
    return world.map ? null : world;
  } catch {
    return null;
  }
}
