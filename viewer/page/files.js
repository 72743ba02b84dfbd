// Files from and to the reader's machine.

export function save(name, text, type = "text/plain") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10e3);
}

// The text of a file of at most so many bytes; a sentence where it is none.
export async function text(file, most) {
  if (file.size > most) throw new Error(`${file.name} has ${file.size} bytes; expected at most ${most}`);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer());
  } catch {
    throw new Error(`${file.name} is not a text; expected a world file (TOML)`);
  }
}

// Copies a text; returns whether the browser allowed it.
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}
