// The few things that every panel is made of: elements, ticks, numbers, clouds of points.

const SVG = "http://www.w3.org/2000/svg";

function el(name, attributes, parent, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}

function html(name, className, parent, text) {
  const node = document.createElement(name);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}

function canvas(host, width, height, label) {
  return el("svg", {
    viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label,
  }, host);
}

function niceStep(span, most) {
  const rough = span / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 2.5, 5, 10].map((m) => m * power).find((step) => step >= rough * 0.999);
}

function ticks(low, high, most) {
  if (!(high > low)) return [low];
  const step = niceStep(high - low, most);
  const out = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
    out.push(Number((n * step).toPrecision(12)));
  }
  return out;
}

const angleTicks = (low, high, most) =>
  [5, 10, 15, 30, 45, 60, 90].map((step) => {
    const out = [];
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) out.push(v);
    return out;
  }).find((out) => out.length <= most + 1) || ticks(low, high, most);

const plain = (value) => String(value).replace("-", "−");

function short(value) {
  if (Number.isNaN(value)) return "–";
  const size = Math.abs(value);
  const digits = size === 0 || size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 ? 2 : 3;
  return plain(value.toFixed(digits));
}

function clock(seconds) {
  return new Date(1000 * (data.time.first + seconds)).toISOString();
}

// A cloud as few paths: overlapping points of different paths grow darker, of one path do not.
const SHADES = 4;

function cloud(parent, className) {
  const group = el("g", { class: className }, parent);
  return Array.from({ length: SHADES }, () => el("path", {}, group));
}

function fill(paths, rowsOf, px, py) {
  const parts = paths.map(() => []);
  for (const i of rowsOf) {
    const x = px(i), y = py(i);
    if (x === x && y === y) parts[i % paths.length].push(`M${x.toFixed(1)} ${y.toFixed(1)}h0`);
  }
  paths.forEach((path, n) => path.setAttribute("d", parts[n].join("")));
}

const everyone = Array.from({ length: count }, (_, i) => i);
const density = count > 1500 ? "many" : count > 400 ? "some" : "few";
document.documentElement.dataset.density = density;

// Where the pointer is, in the coordinates of a drawing.
function inside(svg, event) {
  const box = svg.getBoundingClientRect();
  const view = svg.viewBox.baseVal;
  return [(event.clientX - box.left) * view.width / box.width,
    (event.clientY - box.top) * view.height / box.height];
}
