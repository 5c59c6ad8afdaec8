// Curves: charts of columns that belong together, with zoom, readout, and lines that can be hidden.

const LINE_COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31", "#7b5ea7", "#767676"];

/** Which columns of a time series belong together, in the order of the charts; the rest goes by its unit. */
const GROUPS = [
  ["Particles", /^(particles|inserted|left)$/],
  ["Contacts", /^(contacts|wall_contacts|bonds.*|broken.*)$/],
  ["Kinetic energy", /^(kinetic_translation|kinetic_rotation|fluid_kinetic.*)$/],
  ["Potential energy", /^potential$/],
  ["Largest speed", /^max_speed$/],
  ["Largest overlap over radius", /^max_overlap$/],
  ["Through planes", /_(count)$/],
  ["Mass through planes", /_(mass)$/],
  ["Force on walls and bodies", /_f[xyz]$/],
  ["Torque on walls and bodies", /_t[xyz]$/],
  ["Momentum", /^momentum_/],
  ["Angular momentum", /^angular_momentum_/],
  ["Stress", /stress_/],
  ["Deep penetrations", /^deep_penetrations$/],
];

/** Lines of a chart at most; with more there is a chart per wall or body. */
const FEW_LINES = 9;

function groupsOf(columns) {
  const groups = new Map();
  const add = (name, column) => {
    const key = `${name}|${column.unit}`;
    if (!groups.has(key)) groups.set(key, { name, unit: column.unit, columns: [] });
    groups.get(key).columns.push(column);
  };
  const named = columns.map((column) => [GROUPS.findIndex(([, pattern]) => pattern.test(column.name)), column]);
  named.filter(([k]) => k >= 0).sort(([a], [b]) => a - b).forEach(([k, column]) => add(GROUPS[k][0], column));
  named.filter(([k]) => k < 0).forEach(([, column]) => add(column.unit && column.unit !== "-" ? "Others" : "Other numbers", column));
  return [...groups.values()].flatMap((group) => {
    if (group.columns.length <= FEW_LINES) return [group];
    const parts = new Map();
    for (const column of group.columns) {
      const owner = column.name.replace(/_[ft]?[xyz]{1,2}$|_[^_]*$/, "");
      if (!parts.has(owner)) parts.set(owner, []);
      parts.get(owner).push(column);
    }
    return [...parts].flatMap(([owner, list]) => chunks(list, FEW_LINES).map((few) => ({ name: `${group.name}: ${words(owner)}`, unit: group.unit, columns: few })));
  });
}

function chunks(list, size) {
  return Array.from({ length: Math.ceil(list.length / size) }, (_, k) => list.slice(k * size, (k + 1) * size));
}

/** A chart of lines over x. */
class Chart {
  constructor({ name, unit, columns }, x) {
    this.x = x;
    this.unit = unit;
    this.lines = columns.map((column, k) => ({ ...column, colour: LINE_COLOURS[k % LINE_COLOURS.length], isShown: true }));
    this.isLog = false;
    this.canvas = element("canvas", { role: "img", "aria-label": `${name} over ${words(x.name)}` });
    this.read = element("div", { class: "read", hidden: true });
    const log = element("button", { type: "button", "aria-pressed": "false", title: "Logarithmic scale", onclick: () => {
      this.isLog = !this.isLog;
      log.setAttribute("aria-pressed", this.isLog);
      this.draw();
    } }, "log");
    const title = unitText(unit) ? `${name} (${unitText(unit)})` : name;
    const isLoggable = this.lines.some((line) => line.values.some((y) => y > 0));
    this.root = element("div", { class: "chart" }, element("div", { class: "head" }, element("h3", {}, title), isLoggable ? log : null), this.canvas, this.names(), this.read);
    this.reset();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  names() {
    return element("div", { class: "names" }, this.lines.map((line) => {
      const button = element("button", { type: "button", "aria-pressed": "true", onclick: () => {
        line.isShown = !line.isShown;
        button.setAttribute("aria-pressed", line.isShown);
        this.draw();
      } }, element("i", { style: `background:${line.colour}` }), words(line.name));
      return button;
    }));
  }

  reset() {
    let [min, max] = [Infinity, -Infinity];
    for (const x of this.x.values) if (Number.isFinite(x)) [min, max] = [Math.min(min, x), Math.max(max, x)];
    this.span = max > min ? [min, max] : [min - 0.5, min + 0.5];
  }

  /** Takes other values of the same columns. */
  update(columns, x) {
    const wasWhole = this.isWhole();
    this.x = x;
    for (const line of this.lines) line.values = columns.find((column) => column.name === line.name)?.values ?? line.values;
    if (wasWhole) this.reset();
    this.draw();
  }

  isWhole() {
    const [min, max] = this.span;
    return this.x.values[0] >= min && this.x.values[this.x.values.length - 1] <= max;
  }

  listen() {
    const { canvas } = this;
    const place = (event) => event.clientX - canvas.getBoundingClientRect().left;
    canvas.addEventListener("pointerdown", (event) => {
      this.from = place(event);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = place(event);
      this.draw();
      this.tell(event);
    });
    canvas.addEventListener("pointerup", () => {
      if (this.from !== undefined && Math.abs(this.pointer - this.from) > 6) {
        const ends = [this.from, this.pointer].map((px) => this.value(px)).sort((a, b) => a - b);
        if (ends[1] > ends[0]) this.span = ends;
      }
      this.from = undefined;
      this.draw();
    });
    canvas.addEventListener("pointercancel", () => (this.from = undefined));
    canvas.addEventListener("pointerleave", () => {
      this.pointer = undefined;
      this.read.hidden = true;
      this.draw();
    });
    canvas.addEventListener("dblclick", () => {
      this.reset();
      this.draw();
    });
  }

  /** The x at a pixel. */
  value(pixel) {
    const { left, right } = this.frame;
    const share = Math.min(1, Math.max(0, (pixel - left) / (right - left)));
    return this.span[0] + share * (this.span[1] - this.span[0]);
  }

  nearest(x) {
    let best = 0;
    for (let k = 1; k < this.x.values.length; k++) if (Math.abs(this.x.values[k] - x) < Math.abs(this.x.values[best] - x)) best = k;
    return best;
  }

  /** Shows the values under the pointer. */
  tell() {
    const k = this.nearest(this.value(this.pointer));
    const lines = this.lines.filter((line) => line.isShown).map((line) => element("div", {}, element("i", { style: `color:${line.colour};font-style:normal` }, "■ "), `${words(line.name)} ${withUnit(line.values[k], this.unit, 5)}`));
    this.read.replaceChildren(element("b", {}, `${words(this.x.name)} ${withUnit(this.x.values[k], this.x.unit, 5)}`), ...lines);
    this.read.hidden = false;
    const width = this.root.clientWidth;
    const isRight = this.pointer > width / 2;
    this.read.style.left = isRight ? "" : `${this.pointer + 26}px`;
    this.read.style.right = isRight ? `${width - this.pointer + 6}px` : "";
    this.read.style.top = "40px";
  }

  /** Range of what is to be seen. */
  range() {
    let [min, max] = [Infinity, -Infinity];
    for (const line of this.lines.filter((l) => l.isShown)) {
      for (let k = 0; k < line.values.length; k++) {
        const [x, y] = [this.x.values[k], line.values[k]];
        if (x < this.span[0] || x > this.span[1] || !Number.isFinite(y) || (this.isLog && y <= 0)) continue;
        [min, max] = [Math.min(min, y), Math.max(max, y)];
      }
    }
    if (!(min <= max)) return this.isLog ? [0, 1] : [0, 1];
    if (this.isLog) {
      const [a, b] = [Math.log10(min), Math.log10(max)];
      return b - a > 0.1 ? [a - 0.03 * (b - a), b + 0.03 * (b - a)] : [a - 0.5, b + 0.5];
    }
    // What is as good as constant is not blown up.
    const size = Math.max(Math.abs(min), Math.abs(max));
    const pad = max - min > 1e-6 * size ? 0.05 * (max - min) : Math.max(0.05 * size, 1e-30);
    return [min >= 0 && min < 0.5 * max ? 0 : min - pad, max + pad];
  }

  draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0) return;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "11px system-ui, sans-serif";
    const [min, max] = this.range();
    const marks = ticks(min, max, 4).filter((y) => !this.isLog || Number.isInteger(y) || max - min < 2);
    const label = (y) => (this.isLog ? shown(10 ** y, 2) : shown(Math.abs(y) < 1e-12 * (max - min) ? 0 : y, 4));
    const left = 10 + Math.max(18, ...marks.map((y) => pen.measureText(label(y)).width));
    this.frame = { left, right: width - 8, top: 8, bottom: height - 32 };
    const { right, top, bottom } = this.frame;
    const px = (x) => left + ((x - this.span[0]) / (this.span[1] - this.span[0])) * (right - left);
    const py = (y) => bottom - ((y - min) / (max - min)) * (bottom - top);
    this.grid(pen, { marks, label, px, py });
    pen.save();
    pen.beginPath();
    pen.rect(left, top - 2, right - left, bottom - top + 4);
    pen.clip();
    // The first line is on top.
    for (const line of this.lines.filter((l) => l.isShown).reverse()) this.curve(pen, line, px, py);
    if (this.pointer !== undefined) this.cursor(pen, px, py);
    pen.restore();
  }

  grid(pen, { marks, label, px, py }) {
    const { left, right, top, bottom } = this.frame;
    pen.strokeStyle = colour("grid");
    pen.fillStyle = colour("soft");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const y of marks) {
      pen.beginPath();
      pen.moveTo(left, py(y));
      pen.lineTo(right, py(y));
      pen.stroke();
      pen.fillText(label(y), left - 5, py(y));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const x of ticks(...this.span, Math.max(2, (right - left) / 90))) {
      pen.beginPath();
      pen.moveTo(px(x), top);
      pen.lineTo(px(x), bottom);
      pen.stroke();
      pen.fillText(shown(x, 5), Math.min(px(x), right - 10), bottom + 4);
    }
    const unit = unitText(this.x.unit);
    pen.textAlign = "right";
    pen.fillText(words(this.x.name) + (unit ? ` (${unit})` : ""), right, bottom + 18);
  }

  curve(pen, line, px, py) {
    pen.strokeStyle = line.colour;
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.beginPath();
    let isDown = false;
    for (let k = 0; k < line.values.length; k++) {
      const y = this.isLog ? Math.log10(line.values[k]) : line.values[k];
      if (!Number.isFinite(y)) {
        isDown = false;
        continue;
      }
      if (isDown) pen.lineTo(px(this.x.values[k]), py(y));
      else pen.moveTo(px(this.x.values[k]), py(y));
      isDown = true;
    }
    pen.stroke();
  }

  cursor(pen, px, py) {
    const { top, bottom } = this.frame;
    if (this.from !== undefined) {
      pen.fillStyle = colour("accent");
      pen.globalAlpha = 0.15;
      pen.fillRect(Math.min(this.from, this.pointer), top, Math.abs(this.pointer - this.from), bottom - top);
      pen.globalAlpha = 1;
    }
    const k = this.nearest(this.value(this.pointer));
    const x = px(this.x.values[k]);
    pen.strokeStyle = colour("soft");
    pen.beginPath();
    pen.moveTo(x, top);
    pen.lineTo(x, bottom);
    pen.stroke();
    for (const line of this.lines.filter((l) => l.isShown)) {
      const y = this.isLog ? Math.log10(line.values[k]) : line.values[k];
      if (!Number.isFinite(y)) continue;
      pen.fillStyle = line.colour;
      pen.beginPath();
      pen.arc(x, py(y), 3, 0, 2 * Math.PI);
      pen.fill();
    }
  }
}

/** Columns with their values. */
function valuesOf(table, block) {
  return table.columns.map((column) => ({ name: column.name, unit: column.unit, values: block.get(column.values) }));
}

/** Shows the time series; charts that are there already take the new values. */
function showCurves(series, block, charts) {
  if (!series) return [];
  const columns = valuesOf(series, block);
  const x = columns.find((column) => column.name === "time") ?? columns[0];
  const rest = columns.filter((column) => column !== x && column.name !== "step");
  const isSame = charts.length > 0 && rest.every((column) => charts.some((chart) => chart.lines.some((line) => line.name === column.name)));
  if (isSame) {
    charts.forEach((chart) => chart.update(columns, x));
    return charts;
  }
  const made = groupsOf(rest).map((group) => new Chart(group, x));
  byId("curves").hidden = made.length === 0;
  byId("curves").querySelector(".charts").replaceChildren(...made.map((chart) => chart.root));
  const thinned = series.rows < series.stored ? `${counted(series.rows)} of ${counted(series.stored)} rows are here; maxima are those of all rows. ` : "";
  const zeros = series.zeros.length > 0 ? `Zero throughout: ${series.zeros.map(words).join(", ")}.` : "";
  byId("curves-note").textContent = thinned + zeros;
  return made;
}

/** Shows profiles: over the first column each unit has its chart. */
function showProfiles(profiles, block) {
  const made = profiles.flatMap((table) => {
    const [x, ...rest] = valuesOf(table, block);
    const units = [...new Set(rest.map((column) => column.unit))];
    return units.map((unit) => new Chart({ name: words(table.name), unit, columns: rest.filter((column) => column.unit === unit) }, x));
  });
  byId("profiles").hidden = made.length === 0;
  byId("profiles").querySelector(".charts").replaceChildren(...made.map((chart) => chart.root));
}
