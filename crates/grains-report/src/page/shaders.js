// Programs of the graphics processor (GLSL ES 3.00).

/** What instances of spheres and of surfaces share: where they are between two states, and their colour. */
const INSTANCES = `#version 300 es
precision highp float;
layout(location=2) in vec3 positionA;   // 0 to 1 in the box
layout(location=3) in vec3 positionB;
layout(location=4) in vec2 values;      // 0 to 1 in the range of the field, of both states
layout(location=5) in float scale;
uniform mat4 view, projection;
uniform vec3 boxLower, boxSize;
uniform float between;                  // 0 at state A, 1 at state B
uniform vec4 range;                     // smallest, largest, low, high
uniform bool isLog;
uniform vec4 cut;                       // normal and offset: what is beyond is not drawn
uniform sampler2D colours;
out vec3 tint;
float shareOf(float value) {
  float x = mix(range.x, range.y, value);
  if (!isLog) return (x - range.z) / max(range.w - range.z, 1e-30);
  float low = max(range.z, range.w * 1e-6);
  return log(max(x, low) / low) / max(log(range.w / low), 1e-30);
}
vec3 centre() {
  return boxLower + boxSize * mix(positionA, positionB, between);
}
bool isCut(vec3 at) {
  return dot(cut.xyz, at) > cut.w;
}
vec3 tintOf() {
  float share = clamp(shareOf(mix(values.x, values.y, between)), 0.0, 1.0);
  return texture(colours, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
}
`;

const SPHERE_VERTEX = `${INSTANCES}
layout(location=0) in vec2 corner;
uniform float radius;
out vec3 middle;
out vec3 ray;
out float size;
void main() {
  vec3 at = centre();
  tint = tintOf();
  size = radius * scale;
  middle = (view * vec4(at, 1.0)).xyz;
  float distance = length(middle);
  if (isCut(at) || distance <= size) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  // A square that faces the eye and holds the outline of the sphere.
  vec3 forth = middle / distance;
  vec3 side = normalize(cross(abs(forth.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), forth));
  vec3 up = cross(forth, side);
  float wide = size * distance / sqrt(max(distance * distance - size * size, 1e-20));
  ray = middle + wide * (corner.x * side + corner.y * up);
  gl_Position = projection * vec4(ray, 1.0);
}
`;

const LIGHT = `
vec3 lit(vec3 tint, vec3 normal, vec3 toEye) {
  float front = max(dot(normal, normalize(toEye + vec3(0.35, 0.55, 0.2))), 0.0);
  float sky = 0.5 + 0.5 * normal.y;
  float shine = pow(max(dot(normal, normalize(toEye + vec3(0.3, 0.6, 0.3))), 0.0), 40.0);
  // Dark colours keep a shape.
  vec3 base = mix(tint, vec3(1.0), 0.07);
  return base * (0.40 + 0.14 * sky + 0.56 * front) + 0.10 * shine;
}
`;

const SPHERE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 middle;
in vec3 ray;
in float size;
in vec3 tint;
uniform mat4 projection;
out vec4 shown;
${LIGHT}
void main() {
  vec3 way = normalize(ray);
  float along = dot(way, middle);
  float inside = along * along - dot(middle, middle) + size * size;
  if (inside < 0.0) discard;
  vec3 at = way * (along - sqrt(inside));
  vec4 clip = projection * vec4(at, 1.0);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  shown = vec4(lit(tint, (at - middle) / size, -way), 1.0);
}
`;

const SURFACE_VERTEX = `${INSTANCES}
layout(location=0) in vec3 vertex;
layout(location=1) in vec3 normal;
layout(location=6) in vec4 turnA;       // w, x, y, z
layout(location=7) in vec4 turnB;
out vec3 facing;
out vec3 toEye;
vec3 turned(vec4 q, vec3 v) {
  return v + 2.0 * cross(q.yzw, cross(q.yzw, v) + q.x * v);
}
void main() {
  vec4 turn = normalize(mix(turnA, turnB, between));
  vec3 at = centre();
  tint = tintOf();
  vec4 seen = view * vec4(at + turned(turn, vertex * scale), 1.0);
  facing = mat3(view) * turned(turn, normal);
  toEye = -seen.xyz;
  gl_Position = isCut(at) ? vec4(2.0, 2.0, 2.0, 1.0) : projection * seen;
}
`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing;
in vec3 toEye;
in vec3 tint;
out vec4 shown;
${LIGHT}
void main() {
  vec3 eye = normalize(toEye);
  vec3 normal = normalize(facing);
  shown = vec4(lit(tint, dot(normal, eye) < 0.0 ? -normal : normal, eye), 1.0);
}
`;

const WALL_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec3 vertex;
layout(location=1) in vec3 normal;
uniform mat4 view, projection, pose;
out vec3 facing;
out vec3 toEye;
void main() {
  vec4 seen = view * pose * vec4(vertex, 1.0);
  facing = mat3(view) * mat3(pose) * normal;
  toEye = -seen.xyz;
  gl_Position = projection * seen;
}
`;

const WALL_FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing;
in vec3 toEye;
uniform vec4 tint;
out vec4 shown;
void main() {
  float front = abs(dot(normalize(facing), normalize(toEye)));
  // Glass is denser where one looks along it.
  float dense = tint.a * (1.0 + 0.8 * (1.0 - front));
  shown = vec4(tint.rgb * (0.6 + 0.4 * front), min(dense, 1.0));
}
`;

const LINE_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec3 vertex;
uniform mat4 view, projection, pose;
void main() {
  gl_Position = projection * view * pose * vec4(vertex, 1.0);
}
`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 tint;
out vec4 shown;
void main() {
  shown = tint;
}
`;

const SLICE_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec3 vertex;      // 0 to 1 in the grid
uniform mat4 view, projection;
uniform vec3 gridLower, gridSize;
out vec3 place;
void main() {
  place = vertex;
  gl_Position = projection * view * vec4(gridLower + gridSize * vertex, 1.0);
}
`;

const SLICE_FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler3D;
in vec3 place;
uniform sampler3D field;
uniform sampler2D colours;
uniform vec2 ends;                      // shares of the range where colours begin and end
uniform float opacity;
out vec4 shown;
void main() {
  float share = clamp((texture(field, place).r - ends.x) / max(ends.y - ends.x, 1e-6), 0.0, 1.0);
  shown = vec4(texture(colours, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb, opacity);
}
`;
