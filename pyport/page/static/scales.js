// From a column's values to places along a panel, with ticks: plain, of angles, of labels, of time.

// The stretch of azimuth that is drawn: the whole circle, or what was observed of it.
const circle = (() => {
  const low = Math.min(...rows.az), high = Math.max(...rows.az);
  if (high - low > 220) return low < 0 ? [-180, 180] : [0, 360];
  const pad = 4 + 0.04 * (high - low);
  return [low - pad, high + pad];
})();

function scaleOf(column, left, right) {
  if (column.stretches) return timeScale(column, left, right);
  if (column.names) return labelScale(column, left, right);
  let low = Infinity, high = -Infinity;
  for (const value of column.values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const pad = (high - low || 1) * 0.03;
  const [a, b] = column.name === "az" ? circle : [low - pad, high + pad];
  const at = (value) => left + (value - a) / (b - a) * (right - left);
  const most = Math.max(2, (right - left) / 58);
  const angle = column.unit === "deg" && b - a > 20;
  const found = angle ? angleTicks(a, b, most) : ticks(a, b, most);
  return { at, ticks: found.map((value) => [at(value), plain(value)]), cuts: [] };
}

function labelScale(column, left, right) {
  const step = (right - left) / column.names.length;
  // Points of one label are spread a little, always the same way.
  const spread = (i) => ((i * 0.618034) % 1 - 0.5) * 0.7;
  const at = (value, i) => left + (value + 0.5 + (i === undefined ? 0 : spread(i))) * step;
  const every = Math.ceil(46 / step);
  const found = column.names.map((name, n) => [at(n), clip(name, Math.max(5, step * every / 6.5))]);
  return { at, ticks: found.filter((_, n) => n % every === 0), cuts: [] };
}

const clip = (text, most) => (text.length > most ? text.slice(0, most - 1) + "…" : text);

const STEPS = [60, 300, 600, 1800, 3600, 7200, 10800, 21600, 43200, 86400, 172800, 604800,
  2592000, 7776000, 31536000];

function timeScale(column, left, right) {
  const parts = column.stretches;
  const gap = parts.length > 1 ? Math.min(14, (right - left) / parts.length / 3) : 0;
  const room = right - left - gap * (parts.length - 1);
  const least = room / parts.length * 0.25;
  const total = parts.reduce((sum, [a, b]) => sum + (b - a), 0) || 1;
  const starts = [];
  let x = left;
  for (const [a, b] of parts) {
    const wide = least + (b - a) / total * (room - least * parts.length);
    starts.push([x, wide]);
    x += wide + gap;
  }
  const at = (value) => {
    let n = 0;
    while (n < parts.length - 1 && value >= parts[n + 1][0]) n++;
    const [a, b] = parts[n], [start, wide] = starts[n];
    const inner = Math.min(3, wide / 4);
    return start + inner + (b > a ? (value - a) / (b - a) : 0.5) * (wide - 2 * inner);
  };
  const found = [];
  let last = -Infinity;
  parts.forEach(([a, b], n) => {
    const [start, wide] = starts[n];
    if (parts.length === 1) {
      const step = STEPS.find((s) => (b - a) / s <= wide / 70) || STEPS[STEPS.length - 1];
      const zero = column.first % step;
      for (let t = Math.ceil((a + zero) / step) * step - zero; t <= b; t += step) {
        const text = step >= 86400 ? clock(t).slice(0, 10) : clock(t).slice(11, 16);
        found.push([at(t), text]);
      }
    } else if (start - last > 74 && start + 66 < right + 12) {
      found.push([start + 1, clock(a).slice(0, 10), "start"]);
      last = start;
    }
  });
  const cuts = starts.slice(1).map(([start]) => start - gap / 2);
  return { at, ticks: found, cuts };
}
