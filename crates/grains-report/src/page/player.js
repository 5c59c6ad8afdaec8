// The player: time, camera, colours, slices, and the pointer.

const AXES = ["x", "y", "z"];

class Player {
  constructor(scene, block) {
    this.canvas = byId("view");
    this.renderer = new Renderer(this.canvas);
    this.between = 0;
    this.frame = 0;
    this.speed = 1;
    this.walls = 0.45;
    this.isBoxShown = true;
    this.fieldName = null;
    this.cutAxis = -1;
    this.cutPlace = 0.5;
    this.slice = null;
    this.ends = {};
    this.isLog = false;
    this.take(scene, block);
    this.camera = new Camera(scene.lower, scene.upper);
    this.controls();
    this.listen();
    this.fit();
    this.readHash(location.hash);
    if (!location.hash.includes("frame=")) this.setFrame(this.count - 1);
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
  }

  /** Takes the scene: at the beginning, and when a run has written more. */
  take(scene, block) {
    this.scene = scene;
    this.block = block;
    this.count = scene.times.length;
    this.renderer.take(scene, block);
    this.states = null;
    if (scene.particles) {
      const names = scene.shapes.map((shape) => shape.name);
      this.states = new ParticleStates(scene.particles, names, scene.materials, block);
      this.field = this.states.fields.find((field) => field.name === this.fieldName) ?? this.states.fields[0];
    }
    this.volumes = null;
    if (scene.fluid) {
      const { cells, values, times } = scene.fluid;
      const all = cells[0] * cells[1] * cells[2];
      this.volumes = values.map((place) => fluidStates(block.get(place), all, times.length));
      this.slice ??= { field: 0, axis: this.thinnest(), place: 0.5, opacity: 0.85 };
    }
    this.loaded = null;
    this.setColours();
  }

  update(scene, block) {
    const wasLast = this.frame === this.count - 1;
    this.take(scene, block);
    byId("frame").max = this.count - 1;
    this.showColourControls();
    this.setFrame(wasLast ? this.count - 1 : Math.min(this.frame, this.count - 1));
  }

  /** The axis along which the fluid is thinnest: across it there is most to be seen. */
  thinnest() {
    const { lower, upper } = this.scene.fluid;
    const size = sub3(upper, lower);
    return size[1] <= size[0] && size[1] <= size[2] ? 1 : size.indexOf(Math.min(...size));
  }

  fit() {
    this.camera.fit(this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1));
  }

  // Colours

  setColours() {
    if (!this.field) return;
    const { names, max } = this.field;
    this.renderer.upload(this.renderer.colours, names ? kinds(max + 1) : ramp(VIRIDIS));
  }

  /** Where the colours of a field begin and end. */
  endsOf(field) {
    return this.ends[field.name] ?? [field.low, field.high];
  }

  setField(name) {
    this.fieldName = name;
    this.field = this.states.fields.find((field) => field.name === name) ?? this.states.fields[0];
    this.loaded = null;
    this.setColours();
    this.showColourControls();
    this.redraw();
  }

  // Time

  setFrame(frame, between = 0) {
    this.frame = Math.min(this.count - 1, Math.max(0, Math.round(frame)));
    this.between = between;
    byId("frame").value = this.frame;
    const time = this.scene.times[this.frame];
    const next = this.scene.times[Math.min(this.frame + 1, this.count - 1)];
    byId("time").textContent = `${shown(time + between * (next - time), 4)} s  (${this.frame + 1}/${this.count})`;
    this.redraw();
  }

  play(isPlaying = !this.isPlaying) {
    this.isPlaying = isPlaying && this.count > 1;
    byId("play").textContent = this.isPlaying ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
    if (this.isPlaying && this.frame >= this.count - 1) this.setFrame(0);
    this.ticked = undefined;
    if (this.isPlaying) requestAnimationFrame((now) => this.tick(now));
    else this.setFrame(this.frame);
  }

  tick(now) {
    if (!this.isPlaying) return;
    const passed = Math.min(0.1, (now - (this.ticked ?? now)) / 1000);
    this.ticked = now;
    // At speed 1 all states take ten seconds.
    const place = this.frame + this.between + (passed * this.speed * (this.count - 1)) / 10;
    if (place >= this.count - 1) {
      this.setFrame(this.count - 1);
      this.play(false);
      return;
    }
    this.setFrame(Math.floor(place), place - Math.floor(place));
    requestAnimationFrame((next) => this.tick(next));
  }

  /** Gives the renderer the particles of this state and of the next. */
  load() {
    if (!this.states || this.loaded === this.frame) return;
    this.loaded = this.frame;
    const [a, b] = [this.frame, Math.min(this.frame + 1, this.count - 1)];
    const { present, position, orientation, scale, ends } = this.states;
    const [there, then] = [present[a], present[b]];
    const [valuesA, valuesB] = [this.field.of(a), this.field.of(b)];
    const n = there.length;
    const made = {
      counts: ends.map(() => 0), positionA: new Uint16Array(4 * n), positionB: new Uint16Array(4 * n), values: new Uint16Array(2 * n),
      scale: new Float32Array(n), turnA: new Int16Array(4 * n), turnB: new Int16Array(4 * n),
    };
    for (let k = 0, j = 0, shape = 0; k < n; k++) {
      const thing = there[k];
      while (thing >= ends[shape]) shape++;
      made.counts[shape]++;
      while (j < then.length && then[j] < thing) j++;
      const follows = j < then.length && then[j] === thing;
      for (let axis = 0; axis < 3; axis++) {
        const from = position[axis][a][k];
        const to = follows ? position[axis][b][j] : from;
        made.positionA[4 * k + axis] = from;
        // What leaves a periodic box on one side comes in on the other.
        made.positionB[4 * k + axis] = this.scene.periodic[axis] && Math.abs(to - from) > 32767 ? from : to;
      }
      for (let c = 0; c < orientation.length; c++) {
        made.turnA[4 * k + c] = orientation[c][a][k];
        made.turnB[4 * k + c] = follows ? orientation[c][b][j] : orientation[c][a][k];
      }
      made.values[2 * k] = valuesA[k];
      made.values[2 * k + 1] = follows ? valuesB[j] : valuesA[k];
      made.scale[k] = scale[thing];
    }
    this.renderer.setParticles(made);
  }

  // Drawing

  redraw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.draw();
    });
  }

  draw() {
    this.load();
    const look = { camera: this.camera, frame: this.frame, between: this.between, walls: this.walls, isBoxShown: this.isBoxShown, isMoving: this.isPlaying || this.isDragging, cut: this.cut() };
    if (this.states) {
      const [low, high] = this.endsOf(this.field);
      look.particles = { range: [this.field.min, this.field.max, low, high], isLog: this.isLog && !this.field.names };
    }
    if (this.scene.fluid && this.slice.axis >= 0) {
      const { fluid } = this.scene;
      const state = fluid.of_frame[this.frame] ?? 0;
      this.renderer.setVolume(this.volumes[this.slice.field][state], fluid.cells);
      const field = fluid.fields[this.slice.field];
      const share = (x) => (field.max > field.min ? (x - field.min) / (field.max - field.min) : 0);
      look.slice = { ...this.slice, ends: [share(field.low), share(field.high)] };
    }
    this.renderer.draw(look);
    this.showLegend();
    document.body.dataset.frame = this.frame;
    this.writeHash();
  }

  cut() {
    if (this.cutAxis < 0) return [0, 0, 0, 1];
    const { lower, upper } = this.scene;
    const normal = [0, 0, 0];
    normal[this.cutAxis] = 1;
    return [...normal, lower[this.cutAxis] + this.cutPlace * (upper[this.cutAxis] - lower[this.cutAxis])];
  }

  showLegend() {
    const scale = (title, unit, [low, high]) => element("div", { class: "part" }, element("div", {}, title + (unitText(unit) ? ` (${unitText(unit)})` : "")),
      element("div", { class: "scale", style: `background:linear-gradient(90deg,${VIRIDIS.join(",")})` }), element("div", { class: "ends" }, element("span", {}, shown(low, 3)), element("span", {}, shown(high, 3))));
    const parts = [];
    if (this.states && this.field.names) {
      const chips = this.field.names.slice(0, 12).flatMap((name, k) => [element("i", { class: "chip", style: `background:${KINDS[k % KINDS.length]}` }), name]);
      parts.push(element("div", { class: "part" }, ...chips));
    } else if (this.states) parts.push(scale(`${this.field.name}${this.isLog ? ", logarithmic" : ""}`, this.field.unit, this.endsOf(this.field)));
    if (this.scene.fluid && this.slice.axis >= 0) {
      const field = this.scene.fluid.fields[this.slice.field];
      parts.push(scale(`fluid: ${field.name}`, field.unit, [field.low, field.high]));
    }
    byId("legend").replaceChildren(...parts);
    byId("legend").hidden = parts.length === 0;
  }

  // Controls

  controls() {
    const slider = byId("frame");
    slider.max = this.count - 1;
    slider.addEventListener("input", () => {
      this.play(false);
      this.setFrame(Number(slider.value));
    });
    byId("play").addEventListener("click", () => this.play());
    byId("back").addEventListener("click", () => this.step(-1));
    byId("forth").addEventListener("click", () => this.step(1));
    this.showColourControls();
  }

  step(by) {
    this.play(false);
    this.setFrame(this.frame + by);
  }

  select(label, options, chosen, set) {
    const made = element("select", { "aria-label": label, onchange: () => set(made.value) }, options.map(([value, text]) => element("option", { value, selected: String(value) === String(chosen) }, text)));
    return element("label", {}, label, made);
  }

  range(label, value, set, [min, max] = [0, 1]) {
    const made = element("input", { type: "range", min, max, step: (max - min) / 200, value, "aria-label": label, oninput: () => set(Number(made.value)) });
    return made;
  }

  showColourControls() {
    const { scene } = this;
    const found = [];
    const redraw = (set) => (value) => {
      set(value);
      this.redraw();
    };
    const again = (set) => redraw((value) => {
      set(value);
      this.showColourControls();
    });
    if (this.states) {
      found.push(this.select("Colour", this.states.fields.map((field) => [field.name, field.name]), this.field.name, (name) => this.setField(name)));
      if (!this.field.names) found.push(this.colourEnds());
      found.push(element("span", { class: "group" }, this.select("Cut", [[-1, "nothing"], ...AXES.map((axis, k) => [k, `across ${axis}`])], this.cutAxis, again((axis) => (this.cutAxis = Number(axis)))), this.cutAxis < 0 ? null : this.range("Place of the cut", this.cutPlace, redraw((x) => (this.cutPlace = x)))));
    }
    if (scene.walls.length > 0) found.push(element("label", {}, "Walls", this.range("Walls", this.walls, redraw((x) => (this.walls = x)))));
    if (scene.fluid) {
      found.push(element("span", { class: "group" }, this.select("Fluid", scene.fluid.fields.map((field, k) => [k, field.name]), this.slice.field, redraw((k) => (this.slice.field = Number(k)))),
        this.select("slice", [[-1, "none"], ...AXES.map((axis, k) => [k, `across ${axis}`])], this.slice.axis, again((axis) => (this.slice.axis = Number(axis)))),
        this.slice.axis < 0 ? null : this.range("Place of the slice", this.slice.place, redraw((x) => (this.slice.place = x)))));
    }
    found.push(this.select("Speed", [0.25, 0.5, 1, 2, 4].map((x) => [x, `${x}×`]), this.speed, (x) => (this.speed = Number(x))));
    const view = (text, turn, height) => element("button", { type: "button", onclick: () => {
      [this.camera.turn, this.camera.height] = [turn, height];
      this.redraw();
    } }, text);
    found.push(element("span", { class: "group" }, view("Front", -90, 0), view("Side", 0, 0), view("Top", -90, 89.9),
      element("button", { type: "button", onclick: () => this.resetView() }, "Reset"), element("button", { type: "button", onclick: () => this.save() }, "Save picture"), this.fullScreen()));
    byId("controls").replaceChildren(...found);
  }

  fullScreen() {
    const stage = this.canvas.parentElement;
    if (!stage.requestFullscreen) return null;
    return element("button", { type: "button", onclick: () => (document.fullscreenElement ? document.exitFullscreen() : stage.requestFullscreen()) }, "Full screen");
  }

  colourEnds() {
    const [low, high] = this.endsOf(this.field);
    const input = (k, value) => element("input", { type: "number", step: "any", value: Number(value.toPrecision(3)), "aria-label": ["Colours from", "Colours to"][k], onchange: (event) => {
      const ends = [...this.endsOf(this.field)];
      ends[k] = Number(event.target.value);
      if (ends[1] > ends[0]) this.ends[this.field.name] = ends;
      this.redraw();
    } });
    const log = element("button", { type: "button", "aria-pressed": this.isLog, onclick: () => {
      this.isLog = !this.isLog;
      log.setAttribute("aria-pressed", this.isLog);
      this.redraw();
    } }, "log");
    const all = element("button", { type: "button", title: "Colours over all values, or over all but a few extremes", onclick: () => {
      if (this.ends[this.field.name]) delete this.ends[this.field.name];
      else this.ends[this.field.name] = [this.field.min, this.field.max];
      this.showColourControls();
      this.redraw();
    } }, "all values");
    return element("span", { class: "group" }, "from", input(0, low), "to", input(1, high), log, all);
  }

  resetView() {
    this.camera.reset();
    this.fit();
    this.redraw();
  }

  save() {
    this.draw();
    this.canvas.toBlob((blob) => {
      const link = element("a", { href: URL.createObjectURL(blob), download: `frame-${this.frame}.png` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  // The pointer and the keyboard

  listen() {
    const { canvas } = this;
    const down = new Map();
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, [event.clientX, event.clientY]);
      this.isDragging = true;
      this.moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!down.has(event.pointerId)) return;
      const before = [...down.values()];
      const [dx, dy] = sub3([event.clientX, event.clientY, 0], [...down.get(event.pointerId), 0]);
      down.set(event.pointerId, [event.clientX, event.clientY]);
      this.moved += Math.abs(dx) + Math.abs(dy);
      if (down.size === 2) this.pinch(before, [...down.values()]);
      else if (event.buttons & 6 || event.shiftKey) this.camera.shift(dx, dy, canvas.clientHeight);
      else this.camera.orbit(dx, dy);
      this.redraw();
    });
    const up = (event) => {
      if (!down.delete(event.pointerId)) return;
      if (event.type === "pointerup" && down.size === 0 && this.moved < 4) this.pick(event);
      this.isDragging = down.size > 0;
      this.redraw();
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(0.0012 * event.deltaY));
      this.redraw();
    }, { passive: false });
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("hashchange", () => {
      if (location.hash !== this.written) this.readHash(location.hash);
    });
  }

  pinch([a, b], [c, d]) {
    const apart = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]);
    const middle = (p, q) => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
    this.camera.zoom(apart(a, b) / Math.max(apart(c, d), 1));
    const [from, to] = [middle(a, b), middle(c, d)];
    this.camera.shift(to[0] - from[0], to[1] - from[1], this.canvas.clientHeight);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(event.target.tagName)) return;
    const does = { " ": () => this.play(), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), Home: () => this.setFrame(0), End: () => this.setFrame(this.count - 1), r: () => this.resetView() }[event.key];
    if (!does) return;
    event.preventDefault();
    does();
  }

  /** Tells which particle is under the pointer. */
  pick(event) {
    const told = byId("picked");
    told.hidden = true;
    if (!this.states) return;
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2];
    const eye = this.camera.eye();
    const tangent = Math.tan(this.camera.angle / 2);
    const [right, up] = this.camera.sides();
    const way = unit3(add3(times3(this.camera.way(), -1), add3(times3(right, (x * tangent * box.width) / box.height), times3(up, y * tangent))));
    const { present, scale, ends, id } = this.states;
    const cut = this.cut();
    let best = null;
    let shape = 0;
    present[this.frame].forEach((thing, k) => {
      while (thing >= ends[shape]) shape++;
      const at = this.states.at(this.frame, k);
      if (dot3(cut, at) > cut[3]) return;
      const radius = (this.scene.shapes[shape]?.radius ?? this.radiusOf(shape)) * scale[thing];
      const from = sub3(at, eye);
      const along = dot3(from, way);
      if (dot3(from, from) - along * along < radius * radius && along > 0 && (!best || along < best.along)) best = { along, k, thing, at, shape };
    });
    if (!best) return;
    const { names, min, max, unit, name } = this.field;
    const value = min + ((max - min) * this.field.of(this.frame)[best.k]) / 65535;
    const said = names ? names[Math.round(value)] : withUnit(value, unit, 3);
    told.textContent = `${this.scene.shapes[best.shape]?.name ?? "particle"} ${id[best.thing]} at (${best.at.map((c) => shown(c, 4)).join(", ")}) m: ${name} ${said}`;
    told.hidden = false;
  }

  /** Radius (m) of a ball of about the size of a shape. */
  radiusOf(shape) {
    this.radii ??= [];
    this.radii[shape] ??= (() => {
      const [low, high] = extents(this.block.get(this.scene.shapes[shape].vertices));
      return 0.5 * Math.max(...sub3(high, low));
    })();
    return this.radii[shape];
  }

  // The address

  readHash(hash) {
    const asked = new URLSearchParams(hash.slice(1));
    const number = (key) => (asked.has(key) && Number.isFinite(Number(asked.get(key))) ? Number(asked.get(key)) : null);
    const set = (key, take) => {
      const value = number(key);
      if (value !== null) take(value);
    };
    set("turn", (x) => (this.camera.turn = x));
    set("height", (x) => (this.camera.height = Math.min(89.9, Math.max(-89.9, x))));
    set("zoom", (x) => (this.camera.distance = x * this.camera.radius));
    set("walls", (x) => (this.walls = x));
    const axis = (key, take) => {
      const [name, place] = (asked.get(key) ?? "").split("@");
      if (asked.has(key)) take(AXES.indexOf(name), Number(place ?? 0.5));
    };
    axis("cut", (k, place) => ([this.cutAxis, this.cutPlace] = [k, place]));
    if (this.slice) {
      axis("slice", (k, place) => ([this.slice.axis, this.slice.place] = [k, place]));
      const of = this.scene.fluid.fields.findIndex((field) => field.name === asked.get("fluid"));
      if (of >= 0) this.slice.field = of;
    }
    if (asked.has("field") && this.states) this.setField(asked.get("field"));
    this.showColourControls();
    set("frame", (k) => this.setFrame(k));
    this.redraw();
  }

  writeHash() {
    clearTimeout(this.writing);
    this.writing = setTimeout(() => {
      const { camera } = this;
      const asked = new URLSearchParams({ frame: this.frame, turn: camera.turn.toFixed(1), height: camera.height.toFixed(1), zoom: (camera.distance / camera.radius).toFixed(3), walls: this.walls.toFixed(2) });
      if (this.states) asked.set("field", this.field.name);
      if (this.cutAxis >= 0) asked.set("cut", `${AXES[this.cutAxis]}@${this.cutPlace.toFixed(3)}`);
      if (this.slice) {
        asked.set("slice", this.slice.axis >= 0 ? `${AXES[this.slice.axis]}@${this.slice.place.toFixed(3)}` : "none");
        asked.set("fluid", this.scene.fluid.fields[this.slice.field].name);
      }
      this.written = `#${asked}`;
      // Before anything is touched the address stays as it was given.
      if (this.isTouched) history.replaceState(null, "", this.written);
      this.isTouched = true;
    }, 400);
  }
}
