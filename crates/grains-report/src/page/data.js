// The block of numbers, and the states of the scene in it.

/** The arrays of a block by the places that the description gives. */
class Block {
  constructor(buffer) {
    this.buffer = buffer;
  }

  /** Inflates a block from its text. */
  static async read(text) {
    const binary = atob(text.trim());
    const deflated = new Uint8Array(binary.length);
    for (let k = 0; k < binary.length; k++) deflated[k] = binary.charCodeAt(k);
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Block(await new Response(stream).arrayBuffer());
  }

  /** The array at a place. */
  get({ at, length, kind }) {
    const type = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array }[kind];
    return new type(this.buffer, at, length);
  }
}

/** States of things that are quantised over 16 bits, from what differs between them: low bytes, then high bytes. */
function channelStates(encoded, present) {
  const last = new Uint16Array(present.things);
  let at = 0;
  return present.states.map((things) => {
    const values = new Uint16Array(things.length);
    for (let k = 0; k < things.length; k++) {
      last[things[k]] += encoded[at + k] | (encoded[at + things.length + k] << 8);
      values[k] = last[things[k]];
    }
    at += 2 * things.length;
    return values;
  });
}

/** The particles of a scene, by state: which there are, their positions, orientations and fields. */
class ParticleStates {
  constructor(described, shapes, materials, block) {
    this.described = described;
    const [first, last] = [block.get(described.first), block.get(described.last)];
    const present = { things: first.length, states: described.shown.map((count) => new Uint32Array(count)) };
    present.states.forEach((things, state) => {
      for (let k = 0, n = 0; k < first.length; k++) if (first[k] <= state && state <= last[k]) things[n++] = k;
    });
    this.present = present.states;
    this.count = first.length;
    this.id = block.get(described.id);
    this.scale = block.get(described.scale);
    const states = (place) => channelStates(block.get(place), present);
    this.position = described.position.map(states);
    this.orientation = described.orientation.map(states);
    // Things are sorted by shape.
    this.ends = [];
    described.of_shape.reduce((end, count) => (this.ends.push(end + count), end + count), 0);
    this.fields = described.fields.map((field, k) => {
      const values = states(described.values[k]);
      return { ...field, of: (state) => values[state] };
    });
    this.addFixed(shapes, materials, block.get(described.material));
  }

  /** Adds colours that do not change: size, where it began, shape, material. */
  addFixed(shapes, materials, material) {
    const { lower, upper } = this.described;
    const add = (name, unit, values, more = {}) => {
      let [min, max] = [Infinity, -Infinity];
      for (const x of values) [min, max] = [Math.min(min, x), Math.max(max, x)];
      if (!(max > min)) return;
      const quantised = Uint16Array.from(values, (x) => (65535 * (x - min)) / (max - min));
      const of = (state) => Uint16Array.from(this.present[state], (thing) => quantised[thing]);
      this.fields.push({ name, unit, min, max, low: min, high: max, of, ...more });
    };
    const shapeOf = new Uint16Array(this.count);
    this.ends.forEach((end, shape) => shapeOf.fill(shape, this.ends[shape - 1] ?? 0, end));
    add("size over that of its shape", "-", this.scale);
    ["x", "y", "z"].forEach((axis, a) => {
      const began = new Float32Array(this.count).fill(NaN);
      const width = (upper[a] - lower[a]) / 65535;
      this.present.forEach((things, state) => {
        for (let k = 0; k < things.length; k++) {
          if (Number.isNaN(began[things[k]])) began[things[k]] = lower[a] + width * this.position[a][state][k];
        }
      });
      if (this.present.length > 1) add(`${axis} where it began`, "m", began);
    });
    add("shape", "-", shapeOf, { names: shapes });
    add("material", "-", material, { names: materials });
  }

  /** Position (m) of the k-th of a state. */
  at(state, k) {
    const { lower, upper } = this.described;
    return [0, 1, 2].map((a) => lower[a] + ((upper[a] - lower[a]) * this.position[a][state][k]) / 65535);
  }
}

/** States of a field of the fluid, in 8 bits, from what differs between them. */
function fluidStates(encoded, cells, count) {
  const last = new Uint8Array(cells);
  return Array.from({ length: count }, (_, state) => {
    for (let k = 0; k < cells; k++) last[k] += encoded[state * cells + k];
    return last.slice();
  });
}
