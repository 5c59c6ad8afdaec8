// What was run, what `check` said and whether it came true, warnings.

/** The last part of a run: the one before the first restart, or the one after the last. */
function lastPart(run) {
  return run?.parts?.at(-1) ?? null;
}

/** How a run stands: a word, what it means, and how good that is. */
function verdict({ run, status }, isRunning) {
  const part = lastPart(run);
  const state = part?.state ?? status?.state;
  if (isRunning) return ["running", "The run goes on.", "good"];
  if (state === "finished") return ["finished", "The run has come to its end.", "good"];
  if (state === "stopped") {
    const by = { request: "it was asked to", signal: "a signal asked it to", walltime: "its time was up" };
    const why = by[part?.stopped_by ?? status?.stopped_by] ?? "it was asked to";
    return ["stopped", `The run stopped because ${why}; --restart latest goes on.`, "warn"];
  }
  if (state === "failed") return ["failed", part?.error ?? "The run ended with an error.", "bad"];
  if (state === "running") return ["unfinished", "The run has not told of its end: it goes on, or was killed.", "warn"];
  return ["unknown", "The files do not say how the run ended.", "warn"];
}

function showHead(description, isRunning) {
  const [word, meaning, quality] = verdict(description, isRunning);
  byId("title").textContent = description.name || description.directory || "A run";
  byId("verdict").replaceChildren(element("span", { class: `badge ${quality}` }, word), meaning);
  const part = lastPart(description.run);
  byId("origin").textContent = [part?.program, part && `begun ${part.begun}`, `results in ${description.directory}`].filter(Boolean).join(" · ");
}

function showWarnings(description) {
  const parts = description.run?.parts ?? [];
  const all = [...new Set(parts.flatMap((part) => part.warnings ?? []))];
  byId("warnings").hidden = all.length === 0;
  byId("warnings").querySelector("ul").replaceChildren(...all.map((text) => element("li", {}, text)));
}

function fact(value, name) {
  return element("div", { class: "fact" }, element("b", {}, value), element("span", {}, name));
}

function showFacts(description) {
  const { run, status } = description;
  const parts = run?.parts ?? [];
  const part = lastPart(run);
  const seconds = parts.reduce((sum, p) => sum + (p.seconds ?? 0), 0);
  const facts = [];
  const time = part?.time_s ?? status?.time_s;
  const end = status?.end_s ?? part?.end_s;
  if (time !== undefined && time !== null) facts.push(fact(`${shown(time)} s`, end ? `simulated, of ${shown(end)} s` : "simulated"));
  if (part?.particles) facts.push(fact(counted(part.particles.inside), `particles inside, ${counted(part.particles.inserted)} inserted`));
  else if (status?.particles) facts.push(fact(counted(status.particles), "particles"));
  if (part?.fluid) facts.push(fact(counted(part.fluid.cells), "cells of the fluid"));
  if (seconds > 0) facts.push(fact(duration(seconds), parts.length > 1 ? `on the clock, in ${parts.length} parts` : "on the clock"));
  const step = part?.microseconds_per_particle_step;
  if (step) facts.push(fact(`${shown(step, 3)} µs`, "per particle and step"));
  if (part?.fluid?.nanoseconds_per_cell_step) facts.push(fact(`${shown(part.fluid.nanoseconds_per_cell_step, 3)} ns`, "per cell and step of the fluid"));
  if (part?.memory_bytes) facts.push(fact(bytes(part.memory_bytes.all), "memory at the peak"));
  if (part?.disk_bytes) facts.push(fact(bytes(part.disk_bytes), "on disk"));
  if (part?.machine) facts.push(fact(counted(part.machine.ranks), part.machine.ranks === 1 ? "rank" : "ranks"));
  byId("facts").replaceChildren(...facts);
}

function panel(title, ...children) {
  return element("div", { class: "panel" }, element("h3", {}, title), ...children);
}

function rows(pairs) {
  const kept = pairs.filter(([, value]) => value !== null && value !== undefined && value !== "");
  return element("table", {}, kept.map(([name, value]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value))));
}

/** Whether a prediction came true, in words. */
function judged(predicted, measured, factor) {
  if (!(predicted > 0) || !(measured > 0)) return ["", ""];
  const ratio = measured / predicted;
  const off = Math.max(ratio, 1 / ratio);
  if (off <= 1.1) return ["as predicted", "good"];
  if (off <= factor) return [`${shown(off, 3)} times ${ratio > 1 ? "more" : "less"}`, "good"];
  return [`${shown(off, 2)} times ${ratio > 1 ? "more" : "less"}`, off > 2 * factor ? "bad" : "warn"];
}

/** What `check` predicted beside what was measured. */
function predictions(part) {
  const said = part?.predicted;
  if (!said) return null;
  const line = (name, a, b, [word, quality]) =>
    element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "number" }, a), element("td", { class: "number" }, b), element("td", { class: quality }, word));
  const body = [];
  // Predictions are of the whole case: a part of a run is no test of what adds up.
  const isWhole = part.state === "finished" && part.from_step === 0 && part.time_s > 0.995 * part.end_s;
  const upTo = isWhole ? 1 : null;
  if (said.time_step_s) body.push(line("time step", `${shown(said.time_step_s)} s`, `${shown(part.time_step_s ?? said.time_step_s)} s`, ["", ""]));
  if (said.steps && part.particles) body.push(line("steps", counted(said.steps), counted(part.steps), isWhole ? judged(said.steps, part.steps, 1.05) : ["", ""]));
  if (said.memory_bytes) body.push(line("memory", bytes(said.memory_bytes), bytes(part.memory_bytes?.all), judged(said.memory_bytes, part.memory_bytes?.all, 1.5)));
  if (said.disk_bytes) body.push(line("disk", bytes(said.disk_bytes), bytes(part.disk_bytes), upTo ? judged(said.disk_bytes, part.disk_bytes, 1.4) : ["", ""]));
  if (said.seconds) body.push(line("time on the clock", duration(said.seconds), duration(part.seconds), upTo ? judged(said.seconds, part.seconds, 2) : ["", ""]));
  if (said.max_overlap !== null && said.max_overlap !== undefined && part.particles) {
    const [found, limit] = [part.particles.max_overlap, said.overlap_limit];
    const word = found > said.max_overlap ? (found > limit / 2 ? ["near the limit", "bad"] : ["deeper than at time.impact_speed", "warn"]) : ["below", "good"];
    body.push(line("overlap over radius", `${shown(100 * said.max_overlap, 3)} % at impact`, `${shown(100 * found, 3)} %`, word));
  }
  const heading = element("tr", {}, ...["", "check said", "came out", ""].map((name, k) => element("th", { class: k === 1 || k === 2 ? "number" : "" }, name)));
  const reason = said.time_step_reason ? element("p", { class: "note" }, `Time step: ${said.time_step_reason}.`) : null;
  const whole = isWhole ? null : element("p", { class: "note" }, "Predictions are of the whole case up to its end; what adds up over time is not compared, as this is a part of it.");
  return panel("What check said, and what came of it", element("table", {}, heading, body), reason, whole);
}

function phases(part) {
  const all = (part?.phases ?? []).filter((phase) => phase.mean > 0).sort((a, b) => b.mean - a.mean);
  if (all.length === 0) return null;
  const total = part.seconds || all.reduce((sum, phase) => sum + phase.mean, 0);
  const line = (phase) => {
    const share = (100 * phase.mean) / total;
    const bar = element("div", { class: "bar", style: `width:${Math.min(100, share)}%` });
    const spread = phase.max > 0 ? `${shown(phase.min, 3)} to ${shown(phase.max, 3)} s` : "";
    return element("tr", {}, element("th", { scope: "row" }, phase.name), element("td", { class: "share" }, bar), element("td", { class: "number" }, `${shown(share, 3)} %`), element("td", { class: "number" }, spread));
  };
  return panel("Time by phase", element("table", {}, all.map(line)), element("p", { class: "note" }, "Share of the time on the clock; from the least to the most busy rank."));
}

function showTables(description) {
  const part = lastPart(description.run);
  const machine = part?.machine;
  const parts = description.run?.parts ?? [];
  const about = rows([
    ["program", part?.program],
    ["case file", part?.case_file],
    ["case and inputs, SHA-256", part?.case_sha256],
    ...(part?.inputs ?? []).map((file) => [`${file.path}, SHA-256`, file.sha256]),
    ["begun", part?.begun],
    ["ended", part?.ended],
    ["restarted from", part?.restart ? `${part.restart}, step ${counted(part.from_step)}` : null],
    ["processor", machine?.processor],
    ["ranks", machine && `${machine.ranks} on ${machine.hosts.length === 1 ? machine.hosts[0] : `${machine.hosts.length} hosts: ${machine.hosts.join(", ")}`}`],
    ["cores of a host", machine?.cores],
    ["memory of the largest rank", part?.memory_bytes && bytes(part.memory_bytes.largest_rank)],
    ["work of the busiest rank", part?.imbalance && `${shown(part.imbalance, 3)} times the mean`],
  ]);
  const history = parts.length < 2 ? null : panel("Parts of the run", element("table", {},
    element("tr", {}, ...["begun", "from step", "to step", "clock", "state"].map((name) => element("th", {}, name))),
    parts.map((p) => element("tr", {}, ...[p.begun, counted(p.from_step), counted(p.step), duration(p.seconds), p.state].map((text) => element("td", {}, text ?? "–"))))));
  const found = [part && panel("Program and machine", about), predictions(part), phases(part), history].filter(Boolean);
  if (!part) found.push(element("p", { class: "note" }, "The run was written by a version without run.json: machine, predictions and warnings are not known."));
  byId("tables").replaceChildren(...found);
}
