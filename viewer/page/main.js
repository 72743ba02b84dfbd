// The page: loads the module, and wires what is chosen to the episode, the pictures and the figures.
import { load } from "../../crates/web/cocarry.js";
import { App } from "./app.js";
import { Choices } from "./choices.js";
import * as link from "./link.js";

const failure = document.getElementById("failure");
const fail = (sentence) => {
  failure.hidden = false;
  failure.textContent = sentence;
  document.body.dataset.failed = "true";
};

async function begin() {
  if (typeof WebAssembly !== "object") return fail("This browser has no WebAssembly, which the simulator needs. The program runs without a browser: cocarry run.");
  let module, catalogue;
  try {
    module = await load(fetch("cocarry.wasm"));
    catalogue = module.catalogue();
  } catch (error) {
    return fail(`The simulator could not be loaded (${error.message}). Load the page again, or use the program: cocarry run.`);
  }
  const asked = await link.read(location.hash, catalogue);
  const app = new App({ module, catalogue, choices: new Choices(asked.choices), view: asked.view });
  if (asked.faults.length) app.warn(`This link is not whole: ${asked.faults.join("; ")}. The rest of it holds.`);
  app.begin(asked.log);
  addEventListener("hashchange", () => {
    if (location.hash.slice(1) !== app.fragment) location.reload();
  });
}

begin().catch((error) => {
  fail(`The page stopped: ${error.message}. Load it again.`);
  throw error;
});
