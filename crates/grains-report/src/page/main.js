// Puts the page together; `watch` gives it new numbers while a run goes on.

const page = { player: null, charts: [], isRunning: false };

/** Errors are collected where a test, or whoever is sent the page, finds them. */
function note(error) {
  const errors = document.body.dataset;
  errors.errors = `${errors.errors}${error?.message ?? error}\n`;
}

function showPictures(pictures) {
  byId("pictures").hidden = pictures.length === 0;
  byId("pictures").querySelector(".pictures").replaceChildren(...pictures.map(({ name, data }) => element("figure", {}, element("img", { src: data, alt: name, loading: "lazy" }), element("figcaption", {}, name))));
}

function showContents() {
  const sections = [...document.querySelectorAll("main > section")].filter((section) => !section.hidden);
  byId("contents").replaceChildren(...sections.map((section) => element("a", { href: `#${section.id}`, onclick: (event) => {
    // The address belongs to the player.
    event.preventDefault();
    section.scrollIntoView();
  } }, section.querySelector("h2").textContent)));
}

function showPlayer(scene, block, notes) {
  byId("player").hidden = !scene;
  byId("player-note").textContent = notes.join(" ");
  if (!scene) return;
  try {
    if (page.player) page.player.update(scene, block);
    else page.player = new Player(scene, block);
    page.player.draw();
  } catch (error) {
    byId("no-view").hidden = false;
    byId("no-view").textContent = error.message;
    if (error.message.includes("WebGL 2")) return;
    throw error;
  }
}

/** Shows all of a description and its block. */
async function show(description, text) {
  const block = await Block.read(text);
  showHead(description, page.isRunning);
  showWarnings(description);
  showFacts(description);
  showTables(description);
  page.charts = showCurves(description.series, block, page.charts);
  showProfiles(description.profiles, block);
  showPictures(description.pictures);
  byId("case").querySelector("pre").textContent = description.case;
  showPlayer(description.scene, block, description.notes);
  showContents();
}

/** Says how far a run is, and takes what it has written since. */
async function follow() {
  const told = await (await fetch("status")).json();
  const { status } = told;
  const isOver = page.isRunning && !told.is_running;
  page.isRunning = told.is_running;
  byId("live").hidden = false;
  byId("live-stop").hidden = !told.is_running;
  const left = status?.seconds_left;
  byId("live-text").textContent = told.is_running
    ? `Running: t = ${shown(status?.time_s)} of ${shown(status?.end_s)} s${left ? `, ${duration(left)} left` : ""}`
    : "The run has ended.";
  if (told.is_new || isOver) {
    const { description, block } = await (await fetch("data")).json();
    await show(description, block);
  }
}

async function followAlways() {
  try {
    await follow();
  } catch {
    byId("live").hidden = false;
    byId("live-text").textContent = "The program that serves this page has ended; what is here was its last word.";
    byId("live-stop").hidden = true;
  }
  setTimeout(followAlways, 2000);
}

async function askToStop() {
  if (!confirm("Ask the run to write a checkpoint and leave?")) return;
  const answer = await fetch("stop", { method: "POST" });
  byId("live-text").textContent = (await answer.text()).trim();
}

async function begin() {
  const read = (id) => JSON.parse(byId(id).textContent);
  const isLive = read("is-live");
  await show(read("description"), byId("block").textContent);
  if (isLive) {
    byId("live-stop").addEventListener("click", () => askToStop().catch(note));
    followAlways();
  }
}

window.addEventListener("error", (event) => note(event.error ?? event.message));
window.addEventListener("unhandledrejection", (event) => note(event.reason));
begin().then(
  () => (document.body.dataset.state = "ready"),
  (error) => {
    note(error);
    document.body.dataset.state = "failed";
  },
);
