// Live examples: a link to the page's chapter that says an episode (page.md#world=...) gets a button that runs the episode
// in place of the picture above it. Nothing is loaded before. Without this script it is a link and a picture.
const demo = new URL("demo/index.html", document.currentScript.src);

for (const link of document.querySelectorAll('main a[href*="page.html#"]')) {
  const episode = link.hash.slice(1);
  if (episode.includes("=")) live(link, episode);
}

// What scrolls can be scrolled by keys.
for (const part of document.querySelectorAll("pre code, .table-wrapper")) if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;

function live(link, episode) {
  const paragraph = link.closest("p"), words = link.textContent;
  const above = paragraph.previousElementSibling, still = above?.querySelector("img") ? above : null;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "live";
  button.textContent = words;
  link.replaceWith(button);
  link.href = `${demo}#${episode}`;
  link.textContent = "in a page of its own";
  button.after(" or ", link);
  let frame = null;
  button.addEventListener("click", () => {
    if (frame) frame.remove();
    frame = frame ? null : paragraph.parentElement.insertBefore(document.createElement("iframe"), paragraph);
    if (frame) {
      frame.className = "live";
      frame.title = words;
      frame.src = `${demo}#embed=${episode.includes("belief=learn") ? "plane" : 1}&${episode}`;
    }
    if (still) still.hidden = Boolean(frame);
    button.textContent = frame ? "Stop" : words;
  });
}
