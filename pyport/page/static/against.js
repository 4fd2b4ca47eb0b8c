// Residuals against a column: one drawing, one frame for each measured axis.

const FRAME = { left: 46, right: 14, top: 20, height: 132, gap: 26, bottom: 34 };

function against(host, column, options = {}) {
  const wide = Math.max(240, Math.floor(host.clientWidth));
  const tall = FRAME.top + axes.length * (FRAME.height + FRAME.gap) - FRAME.gap + FRAME.bottom;
  const left = FRAME.left, right = wide - FRAME.right;
  const title = column.unit ? `${column.label} [${column.unit}]` : column.label;
  const svg = canvas(host, wide, tall, `residuals against ${title}`);
  const scale = scaleOf(column, left, right);
  const px = (i) => scale.at(column.values[i], i);
  const parts = axes.map((axis, n) => frame(svg, axis, n, column, scale, left, right));
  const bottom = tall - FRAME.bottom;
  for (const [x, text, anchor] of scale.ticks) {
    if (!anchor) el("line", { class: "tick", x1: x, x2: x, y1: bottom, y2: bottom + 4 }, svg);
    el("text", { class: "label", x, y: bottom + 15, "text-anchor": anchor || "middle" }, svg, text);
  }
  if (!options.untitled) {
    el("text", { class: "title", x: (left + right) / 2, y: tall - 4, "text-anchor": "middle" },
      svg, title);
  }
  const places = () => {
    const out = [];
    for (const part of parts) {
      for (const i of everyone) {
        if (Number.isNaN(part.axis.before[i])) continue;
        if (state.show !== "after") out.push([i, px(i), part.py(part.axis.before[i])]);
        if (state.show !== "before") out.push([i, px(i), part.py(part.axis.after[i])]);
      }
    }
    return out;
  };
  listen(svg, places, true);
  const draw = (what) => {
    for (const part of parts) {
      if (what === "at") part.mark(px);
      else part.draw(px, !column.names);
    }
  };
  draw("all");
  return draw;
}

function frame(svg, axis, n, column, scale, left, right) {
  const top = FRAME.top + n * (FRAME.height + FRAME.gap), bottom = top + FRAME.height;
  let reach = axis.reach;
  const py = (value) => {
    const bounded = Math.max(-reach, Math.min(reach, value));
    return (top + bottom) / 2 - bounded / reach * (FRAME.height / 2 - 3);
  };
  const group = el("g", { class: "frame" }, svg);
  for (const [low, high] of column.regions) {
    const a = Math.max(left, Math.min(right, scale.at(low)));
    const b = Math.max(left, Math.min(right, scale.at(high)));
    const [x, width] = [Math.min(a, b), Math.max(2, Math.abs(b - a))];
    el("rect", { class: "region", x, y: top, width, height: FRAME.height }, group);
  }
  for (const x of scale.cuts) {
    el("line", { class: "cut", x1: x, x2: x, y1: top, y2: bottom }, group);
  }
  const marks = el("g", {}, group);
  const kinds = ["before", "after"];
  const outs = kinds.map((name) => cloud(group, `cloud ${name} out`));
  const clouds = kinds.map((name) => cloud(group, `cloud ${name}`));
  const dims = kinds.map((name) => cloud(group, `cloud ${name} dim`));
  const lines = kinds.map((name) => el("path", { class: `median ${name}` }, group));
  const dots = kinds.map((name) => el("circle", { class: `hot ${name}`, r: 4.5 }, group));
  el("text", { class: "axis", x: left, y: top - 6 }, group, `${axis.name} [${data.unit}]`);
  el("rect", { class: "edge", x: left, y: top, width: right - left, height: FRAME.height }, group);

  const shown = (name) => state.show === "both" || state.show === name;
  const bins = Math.max(6, Math.min(24, Math.floor((right - left) / 26)));
  // What is left alone is drawn as large as it needs; with an effect left in, beside what was.
  function measure() {
    reach = state.show === "after" && state.on.every(Boolean) ? axis.near : axis.reach;
    marks.replaceChildren();
    for (const value of ticks(-reach, reach, 4)) {
      const y = py(value), kind = value === 0 ? "zero" : "grid";
      el("line", { class: kind, x1: left, x2: right, y1: y, y2: y }, marks);
      el("text", { class: "label", x: left - 6, y: y + 3.5, "text-anchor": "end" }, marks,
        plain(value));
    }
  }
  function draw(px, lined) {
    measure();
    kinds.forEach((name, k) => {
      const values = axis[name];
      const there = shown(name) ? everyone : [];
      const bright = state.chosen ? there.filter((i) => state.chosen[i]) : there;
      const rest = state.chosen ? there.filter((i) => !state.chosen[i]) : [];
      fill(outs[k], bright.filter((i) => !(axis.share[i] > 0)), px, (i) => py(values[i]));
      fill(clouds[k], bright.filter((i) => axis.share[i] > 0), px, (i) => py(values[i]));
      fill(dims[k], rest, px, (i) => py(values[i]));
      const line = lined && shown(name) ? medians(px, values, axis.share, bins) : [];
      lines[k].setAttribute("d", line.map(([x, y], j) =>
        `${j ? "L" : "M"}${x.toFixed(1)} ${py(y).toFixed(1)}`).join(""));
    });
  }
  function mark(px) {
    kinds.forEach((name, k) => {
      const value = state.at < 0 ? NaN : axis[name][state.at];
      const there = shown(name) && !Number.isNaN(value) && !Number.isNaN(px(state.at));
      dots[k].setAttribute("visibility", there ? "visible" : "hidden");
      if (!there) return;
      dots[k].setAttribute("cx", px(state.at).toFixed(1));
      dots[k].setAttribute("cy", py(value).toFixed(1));
    });
  }
  mark(() => NaN);
  return { axis, py, draw, mark };
}
