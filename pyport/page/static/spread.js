// Distributions: residuals before and after in bins, beside what noise alone would give.

function spread(host, axis) {
  const wide = Math.max(240, Math.floor(host.clientWidth)), tall = 190;
  const left = 10, right = wide - 10, top = 20, bottom = tall - 34;
  const svg = canvas(host, wide, tall, `distribution of ${axis.name} residuals`);
  const reach = axis.reach;
  const bins = wide > 420 ? 48 : 32;
  const px = (value) => left + (value / reach + 1) / 2 * (right - left);
  for (const value of ticks(-reach, reach, wide / 70)) {
    const x = px(value);
    el("line", { class: value === 0 ? "zero" : "grid", x1: x, x2: x, y1: top, y2: bottom }, svg);
    el("text", { class: "label", x, y: bottom + 14, "text-anchor": "middle" }, svg, plain(value));
  }
  const shapes = ["before", "after"].map((name) => el("path", { class: `bins ${name}` }, svg));
  const normal = el("path", { class: "normal" }, svg);
  el("line", { class: "edge", x1: left, x2: right, y1: bottom, y2: bottom }, svg);
  el("text", { class: "title", x: (left + right) / 2, y: tall - 4, "text-anchor": "middle" },
    svg, `${axis.name} [${data.unit}]`);
  const told = el("text", { class: "axis", x: left, y: 12 }, svg);

  function tally(values) {
    const out = new Float64Array(bins);
    let total = 0;
    for (let i = 0; i < count; i++) {
      if (!(axis.share[i] > 0) || Number.isNaN(values[i])) continue;
      if (state.chosen && !state.chosen[i]) continue;
      total++;
      const bin = Math.floor((values[i] / reach + 1) / 2 * bins);
      if (bin >= 0 && bin < bins) out[bin]++;
    }
    return [out, total];
  }
  function draw(what) {
    if (what === "at") return;
    const [before, total] = tally(axis.before), [after] = tally(axis.after);
    const both = data.layers.length > 0;
    let high = 1;
    for (let b = 0; b < bins; b++) high = Math.max(high, before[b], both ? after[b] : 0);
    const py = (value) => bottom - value / high * (bottom - top) * 0.96;
    [before, both ? after : new Float64Array(0)].forEach((tallied, n) => {
      let text = "";
      tallied.forEach((value, b) => {
        const x = left + b / bins * (right - left), y = py(value).toFixed(1);
        text += `${b ? "L" : `M${left} ${bottom}L`}${x.toFixed(1)} ${y}`
          + `L${(x + (right - left) / bins).toFixed(1)} ${y}`;
      });
      shapes[n].setAttribute("d", text && `${text}L${right} ${bottom}Z`);
    });
    normal.setAttribute("d", axis.floor ? bell(axis.floor, total, py) : "");
    const now = both ? ` → ${short(rms(axis.after, axis.share))}` : "";
    told.textContent = `rms ${short(rms(axis.before, axis.share))}${now} ${data.unit}`
      + (axis.floor ? `, noise ${short(axis.floor)}` : "");
  }
  function bell(sigma, total, py) {
    let text = "";
    for (let n = 0; n <= 120; n++) {
      const value = (n / 60 - 1) * reach;
      const expected = total * (2 * reach / bins) / (sigma * Math.sqrt(2 * Math.PI))
        * Math.exp(-0.5 * (value / sigma) ** 2);
      text += `${n ? "L" : "M"}${px(value).toFixed(1)} ${Math.max(top - 4, py(expected)).toFixed(1)}`;
    }
    return text;
  }
  draw("all");
  return draw;
}
