// Draws a scene with WebGL 2: spheres exactly, other shapes as instances of their surface, walls as glass, a slice of the fluid.

/** Colours from dark to bright (viridis), at equal distances. */
const VIRIDIS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
/** Colours of kinds. */
const KINDS = ["#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1", "#76b7b2", "#edc948", "#9c755f", "#ff9da7", "#bab0ac"];
/** Triangles of all instances that are drawn at rest, and while something moves. */
const TRIANGLES = { rest: 4e6, moving: 1.5e6 };
/** Cubes along a shape in its coarser surfaces. */
const COARSER = [24, 14, 8, 5, 3];

const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** 256 colours, blended between some or of kinds. */
function ramp(stops) {
  const made = new Uint8Array(256 * 4);
  for (let k = 0; k < 256; k++) {
    const place = (k / 255) * (stops.length - 1);
    const low = Math.min(Math.floor(place), stops.length - 2);
    const [a, b] = [rgb(stops[low]), rgb(stops[low + 1])];
    made.set([...a.map((x, c) => x + (b[c] - x) * (place - low)), 255], 4 * k);
  }
  return made;
}

/** As many colours as there are kinds, each at its share. */
function kinds(count) {
  const made = new Uint8Array(256 * 4);
  for (let k = 0; k < 256; k++) made.set([...rgb(KINDS[Math.round((k / 255) * (count - 1)) % KINDS.length]), 255], 4 * k);
  return made;
}

class Renderer {
  /** @throws what is missing. */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("This browser has no WebGL 2, so that nothing can be shown in motion. All else is below.");
    this.gl = gl;
    this.canvas = canvas;
    this.programs = {
      sphere: this.program(SPHERE_VERTEX, SPHERE_FRAGMENT),
      surface: this.program(SURFACE_VERTEX, SURFACE_FRAGMENT),
      wall: this.program(WALL_VERTEX, WALL_FRAGMENT),
      line: this.program(LINE_VERTEX, LINE_FRAGMENT),
      slice: this.program(SLICE_VERTEX, SLICE_FRAGMENT),
    };
    this.ofScene = [];
    this.quad = this.buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
    this.instances = ["positionA", "positionB", "values", "scale", "turnA", "turnB"].map(() => gl.createBuffer());
    this.colours = this.texture();
    this.fluidColours = this.texture();
    this.upload(this.fluidColours, ramp(VIRIDIS));
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`The graphics processor refuses a program: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`The graphics processor refuses a program: ${gl.getProgramInfoLog(program)}`);
    const places = {};
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
      const { name } = gl.getActiveUniform(program, k);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  buffer(values) {
    const { gl } = this;
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    this.ofScene.push(made);
    return made;
  }

  texture() {
    const { gl } = this;
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const [name, value] of [["MIN_FILTER", "NEAREST"], ["MAG_FILTER", "NEAREST"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"]]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl[value]);
    return made;
  }

  upload(texture, colours) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colours);
  }

  /** Takes the shapes, walls and boxes of a scene. */
  take(scene, block) {
    const { gl } = this;
    this.scene = scene;
    // What an earlier scene of the same run took is given back.
    this.ofScene.filter((buffer) => buffer !== this.quad).forEach((buffer) => gl.deleteBuffer(buffer));
    this.ofScene = [];
    gl.deleteTexture(this.volume ?? null);
    this.shapes = scene.shapes.map((shape) => {
      if (shape.radius !== null) return { radius: shape.radius };
      const [vertices, triangles] = [block.get(shape.vertices), block.get(shape.triangles)];
      const surfaces = [{ vertices, triangles }, ...COARSER.map((cubes) => coarser(vertices, triangles, cubes))];
      const levels = surfaces.filter(({ triangles: t }, k) => t.length >= 12 && (k === 0 || t.length < 0.8 * surfaces[k - 1].triangles.length));
      return { levels: levels.map((level) => ({ ...level, buffer: null, count: level.triangles.length })) };
    });
    this.walls = scene.walls.map(({ surfaces, poses }) => ({
      poses,
      surfaces: surfaces.map((surface) => {
        const [vertices, triangles] = [block.get(surface.vertices), block.get(surface.triangles)];
        const edges = featureEdges(vertices, triangles);
        return { buffer: this.buffer(smoothCorners(vertices, triangles)), count: triangles.length, edges: this.buffer(edges), ends: edges.length / 3 };
      }),
    }));
    this.box = { buffer: this.buffer(boxEdges(scene.lower, scene.upper)), ends: 24 };
    this.volume = null;
    if (scene.fluid) {
      this.volume = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_3D, this.volume);
      for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"], ["WRAP_R", "CLAMP_TO_EDGE"]]) gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}`], gl[value]);
    }
  }

  /** Takes the particles of two states between which is drawn. */
  setParticles({ counts, positionA, positionB, values, scale, turnA, turnB }) {
    const { gl } = this;
    this.counts = counts;
    [positionA, positionB, values, scale, turnA, turnB].forEach((array, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.instances[k]);
      gl.bufferData(gl.ARRAY_BUFFER, array, gl.DYNAMIC_DRAW);
    });
  }

  /** Takes a state of a field of the fluid. */
  setVolume(values, [x, y, z]) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_3D, this.volume);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.R8, x, y, z, 0, gl.RED, gl.UNSIGNED_BYTE, values);
  }

  /** Draws what `look` says. */
  draw(look) {
    const { gl, canvas } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [Math.max(1, Math.round(canvas.clientWidth * ratio)), Math.max(1, Math.round(canvas.clientHeight * ratio))];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    gl.clearColor(...rgb(colour("stage")).map((x) => x / 255), 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const eye = look.camera.eye();
    const size = Math.hypot(...sub3(this.scene.upper, this.scene.lower));
    const far = Math.hypot(...sub3(eye, look.camera.target)) + 2 * size;
    this.view = lookAt(eye, look.camera.target, [0, 0, 1]);
    this.projection = perspective(look.camera.angle, width / height, Math.max(far * 1e-3, 1e-12), far);
    if (look.particles) this.particles(look);
    const ink = rgb(colour("soft")).map((x) => x / 255);
    if (look.isBoxShown) this.lines(this.box, REST_POSE, [...ink, 1]);
    if (this.volume && look.slice) this.slice(look.slice);
    if (look.walls > 0) this.glass(look, ink);
  }

  use(name) {
    const { gl } = this;
    const { program, places } = this.programs[name];
    gl.useProgram(program);
    gl.uniformMatrix4fv(places.view, false, this.view);
    gl.uniformMatrix4fv(places.projection, false, this.projection);
    return places;
  }

  attribute(place, buffer, size, kind, isWhole, first, perInstance) {
    const { gl } = this;
    const bytesOf = { [gl.FLOAT]: 4, [gl.UNSIGNED_SHORT]: 2, [gl.SHORT]: 2 }[kind];
    // Three numbers of 16 bits are stored as four, so that rows begin at multiples of 4 bytes.
    const stride = size === 3 && bytesOf === 2 ? 8 : size * bytesOf;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, kind, isWhole, stride, first * stride);
    gl.vertexAttribDivisor(place, perInstance ? 1 : 0);
  }

  release(...places) {
    for (const place of places) {
      this.gl.vertexAttribDivisor(place, 0);
      this.gl.disableVertexAttribArray(place);
    }
  }

  particles(look) {
    const { gl, counts } = this;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    const total = counts.reduce((sum, count, k) => sum + (this.shapes[k]?.levels ? count * this.shapes[k].levels[0].count / 3 : 0), 0);
    const limit = look.isMoving ? TRIANGLES.moving : TRIANGLES.rest;
    let first = 0;
    counts.forEach((count, k) => {
      const shape = this.shapes[k] ?? { radius: 0 };
      const places = this.use(shape.levels ? "surface" : "sphere");
      const { lower, upper } = this.scene.particles;
      gl.uniform3fv(places.boxLower, lower);
      gl.uniform3fv(places.boxSize, sub3(upper, lower));
      gl.uniform1f(places.between, look.between);
      gl.uniform4fv(places.range, look.particles.range);
      gl.uniform1i(places.isLog, look.particles.isLog ? 1 : 0);
      gl.uniform4fv(places.cut, look.cut);
      gl.uniform1i(places.colours, 0);
      const [positionA, positionB, values, scale, turnA, turnB] = this.instances;
      this.attribute(2, positionA, 3, gl.UNSIGNED_SHORT, true, first, true);
      this.attribute(3, positionB, 3, gl.UNSIGNED_SHORT, true, first, true);
      this.attribute(4, values, 2, gl.UNSIGNED_SHORT, true, first, true);
      this.attribute(5, scale, 1, gl.FLOAT, false, first, true);
      if (count > 0 && shape.levels) {
        const share = (limit * 3) / Math.max(total / (shape.levels[0].count / 3), 1);
        const level = shape.levels.find((l) => l.count <= share) ?? shape.levels.at(-1);
        level.buffer ??= this.buffer(smoothCorners(level.vertices, level.triangles));
        this.attribute(0, level.buffer, 3, gl.FLOAT, false, 0, false);
        gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
        this.attribute(1, level.buffer, 3, gl.FLOAT, false, 0, false);
        gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
        this.attribute(6, turnA, 4, gl.SHORT, true, first, true);
        this.attribute(7, turnB, 4, gl.SHORT, true, first, true);
        gl.drawArraysInstanced(gl.TRIANGLES, 0, level.count, count);
        this.release(0, 1, 2, 3, 4, 5, 6, 7);
      } else if (count > 0) {
        gl.uniform1f(places.radius, shape.radius);
        this.attribute(0, this.quad, 2, gl.FLOAT, false, 0, false);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
        this.release(0, 2, 3, 4, 5);
      }
      first += count;
    });
  }

  lines({ buffer, ends }, pose, tint) {
    const { gl } = this;
    const places = this.use("line");
    gl.uniformMatrix4fv(places.pose, false, pose);
    gl.uniform4fv(places.tint, tint);
    this.attribute(0, buffer, 3, gl.FLOAT, false, 0, false);
    gl.drawArrays(gl.LINES, 0, ends);
    this.release(0);
  }

  glass(look, ink) {
    const { gl } = this;
    const tint = rgb(colour("accent")).map((x) => x / 255);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    for (const wall of this.walls) {
      const pose = wall.poses[look.frame];
      if (!pose) continue;
      const surface = wall.surfaces[pose.surface];
      const matrix = poseMatrix(pose.motion);
      this.lines({ buffer: surface.edges, ends: surface.ends }, matrix, [...ink, Math.min(1, 0.25 + look.walls)]);
      const places = this.use("wall");
      gl.uniformMatrix4fv(places.pose, false, matrix);
      gl.uniform4fv(places.tint, [...tint, 0.55 * look.walls ** 1.5]);
      this.attribute(0, surface.buffer, 3, gl.FLOAT, false, 0, false);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
      this.attribute(1, surface.buffer, 3, gl.FLOAT, false, 0, false);
      gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
      gl.drawArrays(gl.TRIANGLES, 0, surface.count);
      this.release(0, 1);
    }
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  slice({ axis, place, ends, opacity }) {
    const { gl } = this;
    const { lower, upper } = this.scene.fluid;
    const places = this.use("slice");
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    const corners = [[0, 0], [1, 0], [0, 1], [1, 1]].flatMap(([a, b]) => {
      const corner = [0, 0, 0];
      [corner[axis], corner[u], corner[v]] = [place, a, b];
      return corner;
    });
    this.sliceBuffer ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.sliceBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.DYNAMIC_DRAW);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.fluidColours);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_3D, this.volume);
    gl.uniform1i(places.colours, 0);
    gl.uniform1i(places.field, 1);
    gl.uniform3fv(places.gridLower, lower);
    gl.uniform3fv(places.gridSize, sub3(upper, lower));
    gl.uniform2fv(places.ends, ends);
    gl.uniform1f(places.opacity, opacity);
    gl.enable(gl.BLEND);
    this.attribute(0, this.sliceBuffer, 3, gl.FLOAT, false, 0, false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    this.release(0);
    gl.disable(gl.BLEND);
    gl.activeTexture(gl.TEXTURE0);
  }
}

const REST_POSE = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** The matrix of rows of a rotation and a displacement. */
function poseMatrix([a, b, c, d, e, f, g, h, i, x, y, z]) {
  return new Float32Array([a, d, g, 0, b, e, h, 0, c, f, i, 0, x, y, z, 1]);
}
