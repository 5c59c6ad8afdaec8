// Vectors, matrices (by columns), meshes.

const add3 = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub3 = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times3 = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit3 = (a) => times3(a, 1 / (Math.hypot(...a) || 1));

/** Product of two matrices. */
function product(a, b) {
  const c = new Float32Array(16);
  for (let j = 0; j < 4; j++) for (let i = 0; i < 4; i++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

/** The projection of an opening angle (rad) up and down. */
function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

/** From the world to the axes of an eye that looks at a point. */
function lookAt(eye, target, up) {
  const z = unit3(sub3(eye, target));
  const x = unit3(cross3(up, z));
  const y = cross3(z, x);
  return new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot3(x, eye), -dot3(y, eye), -dot3(z, eye), 1]);
}

/** Directions whose angle is below this (cosine) are smoothed into each other. */
const SMOOTH = Math.cos((35 * Math.PI) / 180);

/** Points that are the same get one number. */
function welded(vertices, triangles) {
  let size = 0;
  for (const x of vertices) size = Math.max(size, Math.abs(x));
  const numbers = new Map();
  const of = new Uint32Array(vertices.length / 3);
  for (let k = 0; k < of.length; k++) {
    const key = [0, 1, 2].map((a) => Math.round((vertices[3 * k + a] / size) * 1e5)).join(" ");
    if (!numbers.has(key)) numbers.set(key, k);
    of[k] = numbers.get(key);
  }
  return Uint32Array.from(triangles, (k) => of[k]);
}

/** Directions of triangles, as long as their areas are large. */
function directions(vertices, triangles) {
  const at = (k) => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]];
  return Array.from({ length: triangles.length / 3 }, (_, t) => {
    const [a, b, c] = [0, 1, 2].map((k) => at(triangles[3 * t + k]));
    return cross3(sub3(b, a), sub3(c, a));
  });
}

/** Corners of triangles with normals that are smooth where the surface is: `[x, y, z, nx, ny, nz]` each. */
function smoothCorners(vertices, corners) {
  const triangles = welded(vertices, corners);
  const normals = directions(vertices, triangles);
  const units = normals.map(unit3);
  const around = new Map();
  triangles.forEach((k, place) => {
    if (!around.has(k)) around.set(k, []);
    around.get(k).push(Math.floor(place / 3));
  });
  const made = new Float32Array(6 * triangles.length);
  triangles.forEach((k, place) => {
    const own = units[Math.floor(place / 3)];
    let sum = [0, 0, 0];
    for (const t of around.get(k)) if (dot3(units[t], own) > SMOOTH) sum = add3(sum, normals[t]);
    made.set([vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2], ...unit3(sum)], 6 * place);
  });
  return made;
}

/** A coarser surface: the points of each cube of a grid become one. */
function coarser(vertices, triangles, cubes) {
  const [low, high] = extents(vertices);
  const width = Math.max(...sub3(high, low)) / cubes || 1;
  const cells = new Map();
  const of = new Uint32Array(vertices.length / 3);
  const sums = [];
  for (let k = 0; k < of.length; k++) {
    const key = [0, 1, 2].map((a) => Math.floor((vertices[3 * k + a] - low[a]) / width + 1e-6)).join(" ");
    if (!cells.has(key)) cells.set(key, sums.push([0, 0, 0, 0]) - 1);
    of[k] = cells.get(key);
    for (let a = 0; a < 3; a++) sums[of[k]][a] += vertices[3 * k + a];
    sums[of[k]][3] += 1;
  }
  const points = Float32Array.from(sums.flatMap(([x, y, z, n]) => [x / n, y / n, z / n]));
  const kept = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [of[triangles[t]], of[triangles[t + 1]], of[triangles[t + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return { vertices: points, triangles: Uint32Array.from(kept) };
}

/** Corners of the box around points. */
function extents(vertices) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let k = 0; k < vertices.length; k++) {
    low[k % 3] = Math.min(low[k % 3], vertices[k]);
    high[k % 3] = Math.max(high[k % 3], vertices[k]);
  }
  return [low, high];
}

/** Ends of the edges that show a surface: borders and creases. */
function featureEdges(vertices, corners) {
  const triangles = welded(vertices, corners);
  const units = directions(vertices, triangles).map(unit3);
  const edges = new Map();
  for (let place = 0; place < triangles.length; place++) {
    const t = Math.floor(place / 3);
    const [a, b] = [triangles[place], triangles[3 * t + ((place + 1) % 3)]];
    const key = a < b ? `${a} ${b}` : `${b} ${a}`;
    if (!edges.has(key)) edges.set(key, { ends: [a, b], of: [] });
    edges.get(key).of.push(t);
  }
  const isFeature = ({ of }) => of.length !== 2 || Math.abs(dot3(units[of[0]], units[of[1]])) < 0.95;
  const ends = [...edges.values()].filter(isFeature).flatMap(({ ends }) => ends);
  return Float32Array.from(ends.flatMap((k) => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]]));
}

/** The edges of a box. */
function boxEdges(low, high) {
  const corner = (k) => [0, 1, 2].map((a) => ((k >> a) & 1 ? high[a] : low[a]));
  const pairs = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
  return Float32Array.from(pairs.flatMap(([a, b]) => [...corner(a), ...corner(b)]));
}
