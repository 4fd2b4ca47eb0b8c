// Residual vectors over the sky: around the zenith, and over azimuth and elevation.

const [across, along] = ["x", "y"].map((letter) => axes.find((axis) => axis.letter === letter));
const size = (i, name) => Math.hypot(
  across ? across[name][i] || 0 : 0, along ? along[name][i] || 0 : 0);

// What is not counted on an axis where it was measured.
const uncounted = (i) =>
  axes.some((axis) => !Number.isNaN(axis.before[i]) && !(axis.share[i] > 0));

// How long a long vector is. Both kinds share a scale unless one would be too short to see.
function long(name) {
  const sizes = everyone.filter((i) => !uncounted(i)).map((i) => size(i, name));
  return sizes.sort((a, b) => a - b)[Math.floor(0.9 * (sizes.length - 1))] || 1;
}
const LONG = { before: long("before"), after: long("after") };
if (LONG.before < 8 * LONG.after) LONG.after = LONG.before;

function sky(host, name, polar) {
  const wide = Math.max(240, Math.floor(host.clientWidth));
  const tall = polar ? Math.min(wide, 430) : Math.min(250, Math.max(210, wide * 0.5));
  const svg = canvas(host, wide, tall, `residual vectors ${name}, over the sky`);
  const grid = polar ? polarGrid(svg, wide, tall) : flatGrid(svg, wide, tall);
  regions(svg, grid);
  const group = el("g", { class: `vectors ${name}` }, svg);
  const dim = el("path", { class: "dim" }, group);
  const out = el("path", { class: "out" }, group);
  const line = el("path", {}, group);
  const feet = cloud(group, `cloud feet ${name}`);
  const hot = el("circle", { class: `hot ${name}`, r: 5, visibility: "hidden" }, svg);
  const key = el("g", { class: "key" }, svg);
  const scale = LONG[name] / grid.long;
  const foot = everyone.map((i) => grid.at(rows.az[i], rows.el[i]));

  function draw(what) {
    if (what === "at") {
      hot.setAttribute("visibility", state.at < 0 ? "hidden" : "visible");
      if (state.at >= 0) {
        hot.setAttribute("cx", foot[state.at][0].toFixed(1));
        hot.setAttribute("cy", foot[state.at][1].toFixed(1));
      }
      return;
    }
    const parts = { in: [], out: [], dim: [] };
    for (const i of everyone) {
      const [ex, ey] = onSky(i, across ? across[name][i] || 0 : 0, along ? along[name][i] || 0 : 0);
      const dx = ex * state.stretch / scale, dy = ey * state.stretch / scale;
      const [x, y] = foot[i];
      const [tx, ty] = grid.turn(rows.az[i], dx, dy);
      const long = Math.hypot(tx, ty);
      const cut = Math.min(1, 2.5 * grid.long / (long || 1), grid.room(x, y, tx, ty));
      const text = `M${x.toFixed(1)} ${y.toFixed(1)}l${(tx * cut).toFixed(1)} ${(ty * cut).toFixed(1)}`;
      parts[state.chosen && !state.chosen[i] ? "dim" : uncounted(i) ? "out" : "in"].push(text);
    }
    line.setAttribute("d", parts.in.join(""));
    out.setAttribute("d", parts.out.join(""));
    dim.setAttribute("d", parts.dim.join(""));
    fill(feet, state.chosen ? everyone.filter((i) => state.chosen[i]) : everyone,
      (i) => foot[i][0], (i) => foot[i][1]);
    drawKey(key, wide, tall, scale);
  }
  listen(svg, () => foot.map(([x, y], i) => [i, x, y]), true);
  draw("all");
  return draw;
}

// Offsets along the mount's axes as they are across and along elevation.
function onSky(i, x, y) {
  const t = rows.turn;
  return t ? [t[0][i] * x + t[2][i] * y, t[1][i] * x + t[3][i] * y] : [x, y];
}

function drawKey(key, wide, tall, scale) {
  key.replaceChildren();
  const per = scale / state.stretch;
  const value = niceStep(per * 34, 1);
  const long = value / per;
  const y = tall - 8;
  el("path", { d: `M${wide - long - 6} ${y}h${long}m0 -3v6m${-long} 0v-6` }, key);
  el("text", { class: "label", x: wide - long - 12, y: y + 3.5, "text-anchor": "end" }, key,
    `${plain(value)} ${data.unit}`);
}

function polarGrid(svg, wide, tall) {
  const cx = wide / 2, cy = tall / 2, radius = Math.min(wide, tall) / 2 - 20;
  const far = (elevation) => radius * (90 - elevation) / 90;
  const at = (az, elevation) => {
    const a = az * Math.PI / 180;
    return [cx + far(elevation) * Math.sin(a), cy - far(elevation) * Math.cos(a)];
  };
  for (const elevation of [0, 15, 30, 45, 60, 75]) {
    const kind = elevation === 0 ? "edge" : "grid";
    el("circle", { class: kind, cx, cy, r: far(elevation) }, svg);
    if (elevation % 30 === 0 && elevation) {
      el("text", { class: "label", x: cx + 3, y: cy - far(elevation) - 2 }, svg, `${elevation}°`);
    }
  }
  ["N", "E", "S", "W"].forEach((text, n) => {
    const [x1, y1] = at(n * 90, 0), [x2, y2] = at(n * 90, 85), [x, y] = at(n * 90, -7);
    el("line", { class: "grid", x1, y1, x2, y2 }, svg);
    el("text", { class: "axis", x, y: y + 4, "text-anchor": "middle" }, svg, text);
  });
  // Up the sky is towards the zenith, across it along growing azimuth.
  const turn = (az, dx, dy) => {
    const a = az * Math.PI / 180;
    return [dx * Math.cos(a) - dy * Math.sin(a), dx * Math.sin(a) + dy * Math.cos(a)];
  };
  return { at, turn, room: () => 1, long: radius * 0.13, low: 0, polar: true };
}

function flatGrid(svg, wide, tall) {
  const left = 34, right = wide - 14, top = 6, bottom = tall - 44;
  let low = 90;
  for (const value of rows.el) low = Math.min(low, value);
  low = Math.max(-5, Math.floor((low - 4) / 10) * 10);
  const [first, last] = circle;
  const at = (az, elevation) => [left + (az - first) / (last - first) * (right - left),
    bottom - (elevation - low) / (92 - low) * (bottom - top)];
  for (const value of angleTicks(low, 90, 6)) {
    const y = at(0, value)[1];
    el("line", { class: "grid", x1: left, x2: right, y1: y, y2: y }, svg);
    el("text", { class: "label", x: left - 5, y: y + 3.5, "text-anchor": "end" }, svg, value);
  }
  for (const value of angleTicks(first, last, (right - left) / 40)) {
    const x = at(value, 0)[0];
    el("line", { class: "tick", x1: x, x2: x, y1: bottom, y2: bottom + 4 }, svg);
    el("text", { class: "label", x, y: bottom + 15, "text-anchor": "middle" }, svg, plain(value));
  }
  el("text", { class: "title", x: left, y: tall - 5 }, svg, "azimuth, elevation [deg]");
  el("rect", { class: "edge", x: left, y: top, width: right - left, height: bottom - top }, svg);
  // Vectors end at the frame: the share of one that is inside.
  const room = (x, y, dx, dy) => Math.max(0, Math.min(
    dx > 0 ? (right - x) / dx : dx < 0 ? (left - x) / dx : 1,
    dy > 0 ? (bottom - y) / dy : dy < 0 ? (top - y) / dy : 1));
  return { at, room, turn: (az, dx, dy) => [dx, -dy], long: (bottom - top) * 0.12, low, polar: false };
}

// Where findings are confined to on the sky, and edges across it.
function regions(svg, grid) {
  const stretches = (column, n, whole) => {
    const found = column.regions.filter(([, , layer]) => layer === n);
    return found.length ? found : [whole];
  };
  data.layers.forEach((layer, n) => {
    const azimuths = stretches(columns[0], n, grid.polar ? [0, 360] : circle);
    const elevations = stretches(columns[1], n, [0, 90]);
    const confined = [columns[0], columns[1]].some((one) => one.regions.some((r) => r[2] === n));
    for (const az of confined ? azimuths : []) {
      for (const high of elevations) {
        el("path", { class: "region", d: outline(grid, az, high) }, svg);
      }
    }
    if (layer.curve.length) el("path", { class: "curve", d: curve(grid, layer.curve) }, svg);
  });
}

function outline(grid, [a, b], [low, high]) {
  const points = [];
  const steps = Array.from({ length: 73 }, (_, n) => a + (b - a) * n / 72);
  for (const az of steps) points.push(grid.at(az, Math.max(grid.low, low)));
  for (const az of steps.reverse()) points.push(grid.at(az, Math.min(90, high)));
  return points.map(([x, y], n) => `${n ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("") + "Z";
}

function curve(grid, points) {
  let text = "", pen = "M";
  const [first, last] = circle;
  const within = (az) => ((az - first) % 360 + 360) % 360 + first;
  const closed = grid.polar ? [...points, points[0]]
    : points.map(([az, high]) => [within(az), high]).filter(([az]) => az <= last)
      .sort((one, other) => one[0] - other[0]);
  for (const [az, elevation] of closed) {
    if (elevation < grid.low || elevation > 90) { pen = "M"; continue; }
    const [x, y] = grid.at(az, elevation);
    text += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = "L";
  }
  return text;
}
