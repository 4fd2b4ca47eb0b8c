// Numbers and labels out of the page's data, and what is computed from them.

const data = JSON.parse(document.getElementById("data").textContent);
const NOTHING = { 2: 0xffff, 4: 0xffffffff };

function codes(packed) {
  const raw = atob(packed.data);
  const bytes = Uint8Array.from(raw, (c) => c.charCodeAt(0));
  return packed.bytes === 4 ? new Uint32Array(bytes.buffer) : new Uint16Array(bytes.buffer);
}

function numbers(packed) {
  return Float64Array.from(codes(packed), (code) =>
    code === NOTHING[packed.bytes] ? NaN : packed.low + packed.unit * code);
}

function words(packed) {
  return { names: packed.names, codes: codes(packed) };
}

const rows = {
  line: numbers(data.line).map(Math.round),
  az: numbers(data.columns[0].numbers),
  el: numbers(data.columns[1].numbers),
  turn: data.turn && data.turn.map(numbers),
  seconds: data.time && numbers(data.time.seconds),
  labels: Object.entries(data.labels).map(([name, packed]) => [name, words(packed)]),
};
const count = rows.az.length;

const columns = data.columns.map((column) => ({
  ...column,
  values: column.words ? Float64Array.from(words(column.words).codes) : numbers(column.numbers),
  names: column.words && column.words.names,
  regions: column.regions || [],
}));
if (rows.seconds) {
  columns.push({
    name: "time", label: "time", unit: "UTC", values: rows.seconds, regions: [],
    stretches: data.time.stretches, first: data.time.first,
  });
}

const axes = data.axes.map((axis) => ({
  ...axis,
  before: numbers(axis.before),
  after: new Float64Array(count),
  layers: axis.layers.map(numbers),
  counted: numbers(axis.share),
  share: numbers(axis.share),
}));

// What is switched on, shown, chosen and pointed at; whoever draws listens.
const state = {
  on: data.layers.map(() => true),
  show: data.show,
  chosen: null,
  at: -1,
  stretch: 1,
  fit: null,
  dragging: false,
};
const listeners = [];

function changed(what) {
  if (what === "layers") takeOff();
  for (const listener of listeners) listener(what);
}

function takeOff() {
  for (const axis of axes) {
    if (state.fit) {
      axis.after.set(state.fit.left[axis.letter]);
      for (let i = 0; i < count; i++) axis.share[i] = state.fit.masked[i] ? 0 : 1;
      continue;
    }
    axis.share.set(axis.counted);
    axis.after.set(axis.before);
    axis.layers.forEach((layer, n) => {
      if (state.on[n]) for (let i = 0; i < count; i++) axis.after[i] -= layer[i];
    });
  }
}
takeOff();

function rms(values, share) {
  let sum = 0, weight = 0;
  for (let i = 0; i < count; i++) {
    if (!(share[i] > 0) || Number.isNaN(values[i]) || (state.chosen && !state.chosen[i])) continue;
    sum += share[i] * values[i] * values[i];
    weight += share[i];
  }
  return weight > 0 ? Math.sqrt(sum / weight) : NaN;
}

// Medians in bins of equal count: what a cloud of points follows.
function medians(at, ys, share, bins) {
  const kept = [], xs = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    xs[i] = at(i);
    if (share[i] > 0 && !Number.isNaN(xs[i]) && !Number.isNaN(ys[i])
        && (!state.chosen || state.chosen[i])) kept.push(i);
  }
  if (kept.length < 3 * bins) return [];
  kept.sort((a, b) => xs[a] - xs[b]);
  const out = [];
  for (let b = 0; b < bins; b++) {
    const part = kept.slice(Math.floor(b * kept.length / bins),
      Math.floor((b + 1) * kept.length / bins));
    const sorted = part.map((i) => ys[i]).sort((a, b2) => a - b2);
    const middle = sorted.length >> 1;
    const median = sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
    out.push([part.reduce((sum, i) => sum + xs[i], 0) / part.length, median]);
  }
  return out;
}
