// The eye that looks at a scene.

/** An eye that circles a point; angles in degrees. */
class Camera {
  constructor(lower, upper) {
    this.angle = (35 * Math.PI) / 180;
    this.lower = lower;
    this.upper = upper;
    this.reset();
  }

  reset() {
    this.target = times3(add3(this.lower, this.upper), 0.5);
    this.radius = 0.5 * Math.hypot(...sub3(this.upper, this.lower));
    [this.turn, this.height] = [-60, 18];
    this.distance = this.radius / Math.sin(this.angle / 2);
  }

  /** Fits the box into a view that is so many times as wide as high. */
  fit(aspect) {
    const tangent = Math.tan(this.angle / 2) * 0.94;
    const [right, up] = this.sides();
    const corners = Array.from({ length: 8 }, (_, k) => sub3([0, 1, 2].map((a) => ((k >> a) & 1 ? this.upper[a] : this.lower[a])), this.target));
    // How far a corner lies to the side of the eye's way, and before the target.
    const needed = corners.map((corner) => dot3(corner, this.way()) + Math.max(Math.abs(dot3(corner, right)) / aspect, Math.abs(dot3(corner, up))) / tangent);
    this.distance = Math.max(...needed);
  }

  /** From where it looks, as seen from the target. */
  way() {
    const [turn, height] = [this.turn, this.height].map((angle) => (angle * Math.PI) / 180);
    return [Math.cos(height) * Math.cos(turn), Math.cos(height) * Math.sin(turn), Math.sin(height)];
  }

  eye() {
    return add3(this.target, times3(this.way(), this.distance));
  }

  /** Directions to the right and up. */
  sides() {
    const right = unit3(cross3([0, 0, 1], this.way()));
    return [right, cross3(this.way(), right)];
  }

  orbit(dx, dy) {
    this.turn -= 0.4 * dx;
    this.height = Math.min(89.9, Math.max(-89.9, this.height + 0.4 * dy));
  }

  shift(dx, dy, pixels) {
    const length = (2 * this.distance * Math.tan(this.angle / 2)) / pixels;
    const [right, up] = this.sides();
    this.target = add3(this.target, add3(times3(right, -dx * length), times3(up, dy * length)));
  }

  zoom(factor) {
    this.distance = Math.min(20 * this.radius, Math.max(0.01 * this.radius, this.distance * factor));
  }
}
