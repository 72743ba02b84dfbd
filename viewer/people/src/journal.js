// What this browser keeps of a session until the server has it, and until the participant ends it: in IndexedDB.
import { openDB } from "idb";

export class Journal {
  #base;

  // One journal for each study and person: `name` has both.
  static async open(name) {
    const journal = new Journal();
    journal.#base = await openDB(`cocarry study ${name}`, 1, {
      upgrade(base) {
        base.createObjectStore("session");
        base.createObjectStore("chunks", { keyPath: ["trial", "number"] });
      },
      // another tab wants to remove it
      blocking: (_current, _next, event) => event.target.close(),
    });
    return journal;
  }

  session = () => this.#base.get("session", 0);

  // Stores a value of the session; on the disk when it returns.
  async keep(session) {
    const change = this.#base.transaction("session", "readwrite", { durability: "strict" });
    await Promise.all([change.store.put(session, 0), change.done]);
  }

  chunks = () => this.#base.getAll("chunks");

  async add(chunk) {
    const change = this.#base.transaction("chunks", "readwrite", { durability: "strict" });
    await Promise.all([change.store.put(chunk), change.done]);
  }

  // Forgets what was recorded; with `session`, that there was one.
  async clear(...others) {
    const stores = ["chunks", ...others], change = this.#base.transaction(stores, "readwrite");
    await Promise.all([...stores.map((name) => change.objectStore(name).clear()), change.done]);
  }
}
