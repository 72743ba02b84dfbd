// The timeline of an episode that still runs: what is known, who led, what happened, and the list of events.
const $ = (id) => document.getElementById(id);

export class Timeline {
  constructor(seek) {
    this.seek = seek;
    $("time").addEventListener("input", () => seek(Number($("time").value)));
  }

  begin(episode) {
    this.episode = episode;
    this.shown = 0;
    document.querySelector("#events ol").replaceChildren();
    this.grow();
  }

  // Shows what is new since the last call.
  grow() {
    const { episode } = this, { duration } = episode;
    $("time").max = duration;
    const { mode, decided_s: times } = episode.steps;
    const bands = [];
    for (let k = 0; k < times.length; k++) {
      const end = times[k + 1] ?? episode.end;
      if (bands.length && bands[bands.length - 1].mode === mode[k]) bands[bands.length - 1].end = end;
      else bands.push({ mode: mode[k], from: times[k], end });
    }
    $("leads").replaceChildren(...bands.map(({ mode: kind, from, end }) => {
      const band = document.createElement("span");
      band.className = kind === "human-led" ? "human" : "robot";
      band.style.width = `${(100 * (end - from)) / duration}%`;
      return band;
    }));
    $("marks").replaceChildren(...episode.events.map((event) => {
      const mark = document.createElement("span");
      mark.style.left = `${(100 * event.time_s) / duration}%`;
      return mark;
    }));
    const fresh = episode.events.slice(this.shown);
    // a screen reader hears the newest
    if (fresh.length) $("said").textContent = fresh.map(({ sentence }) => sentence).slice(-2).join("; ");
    for (; this.shown < episode.events.length; this.shown++) {
      const event = episode.events[this.shown], item = document.createElement("li"), button = document.createElement("button");
      button.type = "button";
      button.innerHTML = `<time>${event.time_s.toFixed(1)} s</time><span></span>`;
      button.lastChild.textContent = event.sentence;
      button.addEventListener("click", () => this.seek(event.time_s));
      item.append(button);
      document.querySelector("#events ol").append(item);
    }
  }

  // Shows a time.
  update(time, leader) {
    const { episode } = this;
    $("clock").textContent = `${time.toFixed(1)} s`;
    $("time").value = time;
    $("time").setAttribute("aria-valuetext", `${time.toFixed(1)} seconds, the ${leader} leads`);
    const now = episode.events[episode.event(time)];
    const together = episode.events.filter((other) => now && other.time_s === now.time_s);
    const words = now ? `${now.time_s.toFixed(1)} s: ${together.map(({ sentence }) => sentence).join("; ")}` : "";
    if ($("caption").textContent !== words) $("caption").textContent = words;
    $("caption").classList.toggle("old", !now || time - now.time_s > 4);
    document.querySelectorAll("#events button").forEach((button, i) => button.setAttribute("aria-current", together.includes(episode.events[i])));
  }
}
