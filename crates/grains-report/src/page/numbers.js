// How numbers read, and small helpers of the document.

/** A number with so many digits; powers of ten where zeros would be counted. */
function shown(x, digits = 4) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  const size = Math.abs(x);
  if (size !== 0 && (size >= 1e6 || size < 1e-3)) {
    const [mantissa, power] = x.toExponential(digits - 1).split("e");
    const raised = String(Number(power)).replace(/[-0-9]/g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
    return `${Number(mantissa)}·10${raised}`.replace("-", "−");
  }
  return String(Number(x.toPrecision(digits))).replace("-", "−");
}

/** A number and its unit; a unit of "-" is none. */
function withUnit(x, unit, digits = 4) {
  const text = unitText(unit);
  return shown(x, digits) + (text ? ` ${text}` : "");
}

/** A unit as it is printed. */
function unitText(unit) {
  if (!unit || unit === "-") return "";
  return unit.replace(/([a-zA-Z])2\b/g, "$1²").replace(/([a-zA-Z])3\b/g, "$1³");
}

/** A whole number with spaces between thousands. */
function counted(x) {
  return x === null || x === undefined ? "–" : Math.round(x).toString().replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** Seconds as people say them. */
function duration(s) {
  if (s === null || s === undefined || !Number.isFinite(s)) return "–";
  if (s < 1) return `${shown(1000 * s, 3)} ms`;
  if (s < 120) return `${shown(s, 3)} s`;
  if (s < 7200) return `${shown(s / 60, 3)} min`;
  return s < 172800 ? `${shown(s / 3600, 3)} h` : `${shown(s / 86400, 3)} days`;
}

/** Bytes as people say them. */
function bytes(b) {
  if (b === null || b === undefined || !Number.isFinite(b)) return "–";
  const power = Math.min(4, Math.max(0, Math.floor(Math.log10(Math.max(b, 1)) / 3)));
  return `${shown(b / 1000 ** power, 3)} ${["B", "kB", "MB", "GB", "TB"][power]}`;
}

/** Names of columns as words. */
function words(name) {
  return name.replaceAll("_", " ");
}

/** An element with attributes and children; texts become text. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

/** The element of an id. */
function byId(id) {
  return document.getElementById(id);
}

/** A colour of the style sheet. */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Round numbers in a range, about so many. */
function ticks(min, max, count) {
  const rough = (max - min) / Math.max(count, 1);
  if (!(rough > 0)) return [min];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough * 0.999);
  const found = [];
  for (let k = Math.ceil(min / step - 1e-9); k * step <= max + 1e-9 * step; k++) found.push(k * step);
  return found;
}
