"use strict";
// Draws what the server sends; text is set as text, so that no name of a file or source is markup.
const at = (id) => document.getElementById(id);
const NS = "http://www.w3.org/2000/svg";

function put(parent, name, attributes, text) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}

function clock(data, value) {
  return data.timed ? new Date(value * 1000).toISOString().slice(11, 16) : String(Math.round(value));
}

function alarms(data) {
  const list = at("alarms").querySelector("ol");
  list.replaceChildren();
  if (!data.alarms.length) list.append("none");
  for (const one of data.alarms) {
    const item = document.createElement("li");
    item.className = one.state;
    const head = document.createElement("strong");
    head.textContent = `${one.number}. ${one.state}, since ${one.since} `;
    const next = document.createElement("em");
    next.textContent = one.ended ? ` ended ${one.ended}` : ` Next: ${one.next}`;
    item.append(head, one.antenna ? `antenna ${one.antenna}: ` : "", one.sentence, next);
    list.append(item);
  }
}

function sky(data) {
  const svg = at("sky");
  svg.replaceChildren();
  for (const el of [0, 30, 60]) put(svg, "circle", { class: "frame", r: 90 - el });
  for (const [name, x, y] of [["N", 0, -96], ["E", 98, 3], ["S", 0, 103], ["W", -98, 3]])
    put(svg, "text", { x, y, "text-anchor": "middle" }, name);
  const sizes = data.recent.map((r) => Math.hypot(r[3] || 0, r[4] || 0)).sort((a, b) => a - b);
  const scale = 12 / (sizes[Math.floor(sizes.length * 0.9)] || 1);
  data.recent.forEach((row, n) => {
    const turn = (row[1] * Math.PI) / 180, r = 90 - row[2];
    const x = r * Math.sin(turn), y = -r * Math.cos(turn);
    const across = (row[3] || 0) * scale, up = (row[4] || 0) * scale;
    // up is toward the zenith, across toward growing azimuth
    const dx = across * Math.cos(turn) - up * Math.sin(turn);
    const dy = across * Math.sin(turn) + up * Math.cos(turn);
    const late = n >= data.recent.length - 10;
    put(svg, "line", { x1: x, y1: y, x2: x + dx, y2: y + dy, class: late ? "two" : "one" });
    put(svg, "circle", { cx: x, cy: y, r: 0.9 });
  });
  put(svg, "path", { d: "M-108 104h12", class: "one" });
  put(svg, "text", { x: -92, y: 108 }, `${(12 / scale).toFixed(1)} arcsec`);
  put(svg, "path", { d: "M30 104h12", class: "two" });
  put(svg, "text", { x: 46, y: 108 }, "the last ten");
}

function axes(svg, data, low, high, height) {
  svg.replaceChildren();
  put(svg, "rect", { class: "frame", x: 36, y: 6, width: 556, height: height - 26 });
  const times = data.recent.map((r) => r[0]);
  const first = times[0], last = times[times.length - 1];
  const x = (t) => 36 + (556 * (t - first)) / Math.max(last - first, 1e-9);
  const y = (v) => 6 + ((height - 26) * (high - v)) / Math.max(high - low, 1e-9);
  for (let k = 0; k <= 4; k++) {
    const v = low + ((high - low) * k) / 4, t = first + ((last - first) * k) / 4;
    put(svg, "text", { x: 32, y: y(v) + 3, "text-anchor": "end" }, v.toPrecision(2));
    put(svg, "text", { x: x(t), y: height - 6, "text-anchor": "middle" }, clock(data, t));
  }
  return [x, y];
}

function lines(id, data, names) {
  const values = names.flatMap((name) => data.running.map((r) => r[name]).filter((v) => v));
  if (!values.length) return;
  const low = Math.min(0, ...values.map(([v, s]) => v - 2 * s));
  const high = Math.max(0, ...values.map(([v, s]) => v + 2 * s));
  const svg = at(id), [x, y] = axes(svg, data, low, high, 200);
  put(svg, "line", { class: "frame", x1: 36, x2: 592, y1: y(0), y2: y(0) });
  names.forEach((name, k) => {
    const own = data.running.filter((r) => r[name]);
    const edge = (sign) => own.map((r) => `${x(r.time)},${y(r[name][0] + sign * 2 * r[name][1])}`);
    put(svg, "polygon", { class: `band-${k ? "two" : "one"}`, points: [...edge(1), ...edge(-1).reverse()].join(" ") });
    put(svg, "polyline", { class: k ? "two" : "one", points: own.map((r) => `${x(r.time)},${y(r[name][0])}`).join(" ") });
    const label = { xel: data.axes[0], el: data.axes[1], north: "toward north", east: "toward east" }[name];
    put(svg, "text", { x: 44 + 150 * k, y: 16, class: "label" }, `${k ? "orange" : "blue"}: ${label}`);
  });
}

function evidence(data) {
  const own = data.recent.filter((r) => r[7] !== null);
  if (!own.length) return;
  const high = Math.max(data.threshold * 1.15, ...own.map((r) => Math.min(r[7], data.threshold * 3)));
  const svg = at("evidence"), [x, y] = axes(svg, data, Math.min(0, ...own.map((r) => r[7])), high, 160);
  put(svg, "line", { class: "mark", x1: 36, x2: 592, y1: y(data.threshold), y2: y(data.threshold) });
  put(svg, "text", { x: 44, y: y(data.threshold) - 3 }, "alarm");
  put(svg, "polyline", { class: "one", points: own.map((r) => `${x(r[0])},${y(Math.min(r[7], high))}`).join(" ") });
}

function next(data) {
  const list = at("next");
  list.replaceChildren();
  for (const one of data.next) {
    const item = document.createElement("li");
    item.textContent = `az ${one.az_deg.toFixed(0)}, el ${one.el_deg.toFixed(0)} deg: ${one.why}`;
    list.append(item);
  }
}

function draw(data) {
  const standing = data.standing.length;
  at("state").textContent =
    `${data.rows} pointings, the last at ${data.updated}; ` +
    `${standing} alarm${standing === 1 ? "" : "s"}; at most one false alarm in ${data.pointings_per_false_alarm} pointings`;
  document.title = standing ? `(${standing}) pointing watch` : "pointing watch";
  alarms(data);
  next(data);
  if (!data.recent.length) return;
  sky(data);
  lines("zeros", data, ["xel", "el"]);
  lines("tilts", data, ["north", "east"]);
  evidence(data);
}

// The token, where one is needed, came with the page's address and goes on with each request.
const source = new EventSource("events" + window.location.search);
source.onmessage = (event) => draw(JSON.parse(event.data));
source.onerror = () => { at("state").textContent = "no connection; trying again"; };
