// Both axes together: one against the other around the bull's eye, and how many are how near.

const apart = (name) => everyone.map((i) => size(i, name));
const kindsShown = () => (data.layers.length ? ["before", "after"] : ["after"]);
// What a panel is made large enough for: the residuals that it shows first.
const kindsFirst = () => (data.show === "after" ? ["after"] : kindsShown());
const isCounted = (i) => !uncounted(i) && (!state.chosen || state.chosen[i]);

// The offset along elevation over the one across: circles at the rms and at what holds 95 %.
function bullseye(host) {
  const wide = Math.max(240, Math.floor(host.clientWidth)), tall = Math.min(wide, 360);
  const svg = canvas(host, wide, tall, "residuals on both axes around the bull's eye");
  const cx = wide / 2, cy = tall / 2, radius = tall / 2 - 26;
  const reach = Math.max(across.near, along.near);
  const at = (axis, name, i) => axis[name][i] / reach * radius;
  for (const value of ticks(-reach, reach, 6)) {
    const x = cx + value / reach * radius, kind = value === 0 ? "zero" : "grid";
    el("line", { class: kind, x1: x, x2: x, y1: cy - radius, y2: cy + radius }, svg);
    el("line", { class: kind, x1: cx - radius, x2: cx + radius, y1: cy + cx - x, y2: cy + cx - x }, svg);
    el("text", { class: "label", x, y: cy + radius + 13, "text-anchor": "middle" }, svg, plain(value));
  }
  el("text", { class: "title", x: cx, y: tall - 1, "text-anchor": "middle" }, svg,
    `${across.name}, up: ${along.name} [${data.unit}]`);
  const inFrame = (i, name) => Math.abs(at(across, name, i)) <= radius && Math.abs(at(along, name, i)) <= radius;
  const px = (i, name) => cx + at(across, name, i), py = (i, name) => cy - at(along, name, i);
  const clouds = kindsShown().map((name) => [name, cloud(svg, `cloud ${name}`), cloud(svg, `cloud ${name} dim`)]);
  const rings = [0, 1].map(() => el("circle", { class: "ring", cx, cy }, svg));
  const told = el("text", { class: "axis", x: 10, y: 12 }, svg);
  const both = everyone.filter((i) => !Number.isNaN(across.before[i]) && !Number.isNaN(along.before[i]));
  const shown = (name) => state.show === "both" || state.show === name || !data.layers.length;
  listen(svg, () => kindsShown().filter(shown).flatMap((name) =>
    both.map((i) => [i, px(i, name), py(i, name)])), true);
  function draw(what) {
    if (what === "at") return;
    for (const [name, bright, dim] of clouds) {
      const there = shown(name) ? both.filter((i) => inFrame(i, name)) : [];
      fill(bright, there.filter((i) => !state.chosen || state.chosen[i]), (i) => px(i, name), (i) => py(i, name));
      fill(dim, there.filter((i) => state.chosen && !state.chosen[i]), (i) => px(i, name), (i) => py(i, name));
    }
    const sizes = both.filter(isCounted).map((i) => size(i, "after")).sort((a, b) => a - b);
    const total = Math.sqrt(sizes.reduce((sum, one) => sum + one * one, 0) / (sizes.length || 1));
    const most = sizes[Math.ceil(0.95 * sizes.length) - 1] || 0;
    rings.forEach((ring, n) => ring.setAttribute("r", Math.min(radius, (n ? most : total) / reach * radius)));
    told.textContent = `rms ${short(total)}, 95 % within ${short(most)} ${data.unit}`;
  }
  draw("all");
  return draw;
}

// The share of recordings that are nearer than some distance.
function cumulative(host) {
  const wide = Math.max(240, Math.floor(host.clientWidth)), tall = 240;
  const left = 40, right = wide - 14, top = 20, bottom = tall - 36;
  const svg = canvas(host, wide, tall, "share of recordings within a distance");
  const every = kindsFirst().flatMap((name) => apart(name).filter((_, i) => !uncounted(i)));
  const reach = 1.1 * (every.sort((a, b) => a - b)[Math.floor(0.97 * (every.length - 1))] || 1);
  const px = (value) => left + Math.min(1, value / reach) * (right - left);
  const py = (share) => bottom - share * (bottom - top);
  for (const value of ticks(0, reach, wide / 70)) {
    el("line", { class: "grid", x1: px(value), x2: px(value), y1: top, y2: bottom }, svg);
    el("text", { class: "label", x: px(value), y: bottom + 14, "text-anchor": "middle" }, svg, plain(value));
  }
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    el("line", { class: "grid", x1: left, x2: right, y1: py(share), y2: py(share) }, svg);
    el("text", { class: "label", x: left - 6, y: py(share) + 3.5, "text-anchor": "end" }, svg, `${100 * share}%`);
  }
  el("text", { class: "title", x: (left + right) / 2, y: tall - 4, "text-anchor": "middle" }, svg,
    `distance on the sky [${data.unit}]`);
  const curves = kindsShown().map((name) => [name, el("path", { class: `median ${name}` }, svg)]);
  const told = el("text", { class: "axis", x: left, y: 12 }, svg);
  function draw(what) {
    if (what === "at") return;
    for (const [name, path] of curves) {
      const sizes = everyone.filter(isCounted).map((i) => size(i, name)).sort((a, b) => a - b);
      const every = Math.max(1, Math.floor(sizes.length / 400));
      const steps = sizes.map((value, n) => [value, (n + 1) / sizes.length])
        .filter(([value], n) => value <= reach && (n % every === 0 || n === sizes.length - 1));
      path.setAttribute("d", steps.map(([value, share], n) =>
        `${n ? "" : `M${left} ${bottom}`}H${px(value).toFixed(1)}V${py(share).toFixed(1)}`).join(""));
      if (name === "after") {
        const at = (share) => short(sizes[Math.max(0, Math.ceil(share * sizes.length) - 1)] ?? NaN);
        told.textContent = `half within ${at(0.5)}, 90 % within ${at(0.9)} ${data.unit}`;
      }
    }
  }
  draw("all");
  return draw;
}

// Hysteresis: what is left beside how far an axis had moved since the recording before.
function moved(name, label, values, wrap) {
  const group = (i) => rows.labels.filter(([key]) => key === "antenna" || key === "session")
    .map(([, one]) => one.codes[i]).join(" ");
  const order = [...everyone].sort((a, b) => (rows.seconds ? rows.seconds[a] - rows.seconds[b] : 0) || a - b);
  const last = new Map(), found = new Float64Array(count).fill(NaN);
  for (const i of order) {
    const before = last.get(group(i));
    if (before !== undefined) {
      const far = values[i] - values[before];
      found[i] = wrap ? ((far + 180) % 360 + 360) % 360 - 180 : far;
    }
    last.set(group(i), i);
  }
  return { name, label, unit: "deg", values: found, regions: [] };
}
