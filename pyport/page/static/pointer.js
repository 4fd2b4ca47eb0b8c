// Pointing and choosing: the nearest recording is told, a dragged box chooses what lies in it.

const tip = html("div", "tip", document.body);
tip.setAttribute("role", "status");
const NEAR = 16;

function tell(i, event) {
  tip.replaceChildren();
  html("b", "", tip, rows.labels.map(([, one]) => one.names[one.codes[i]]).filter(Boolean)
    .join(" · ") || `recording ${i + 1}`);
  const when = rows.seconds && !Number.isNaN(rows.seconds[i])
    ? clock(rows.seconds[i]).slice(0, 19).replace("T", " ") + " UTC" : "";
  html("span", "", tip, `line ${rows.line[i]}${when && " · " + when}`);
  html("span", "", tip, `az ${rows.az[i].toFixed(2)}°, el ${rows.el[i].toFixed(2)}°`);
  for (const axis of axes) {
    if (Number.isNaN(axis.before[i])) continue;
    const after = data.layers.length ? ` → ${short(axis.after[i])}` : "";
    const out = axis.share[i] > 0 ? "" : " (not counted)";
    html("span", "", tip, `${axis.name} ${short(axis.before[i])}${after} ${data.unit}${out}`);
  }
  tip.hidden = false;
  const width = tip.offsetWidth, height = tip.offsetHeight;
  const room = document.documentElement.clientWidth;
  const left = Math.min(Math.max(8, event.clientX + 14), room - width - 8);
  const over = event.clientY - height - 14;
  tip.style.left = `${left}px`;
  tip.style.top = `${over > 8 ? over : event.clientY + 18}px`;
}

function quiet() {
  tip.hidden = true;
  if (state.at >= 0) {
    state.at = -1;
    changed("at");
  }
}

// `places` yields [row, x, y] of everything drawn; `box` tells where a drag may begin.
function listen(svg, places, box) {
  let from = null, rubber = null, drawn = [];
  const nearest = (event) => {
    const [x, y] = inside(svg, event);
    let best = -1, least = NEAR * NEAR;
    for (const [i, px, py] of places()) {
      const d = (px - x) ** 2 + (py - y) ** 2;
      if (d < least) { least = d; best = i; }
    }
    return best;
  };
  const point = (event) => {
    const i = nearest(event);
    if (i < 0) return quiet();
    if (i !== state.at) {
      state.at = i;
      changed("at");
    }
    tell(i, event);
  };
  svg.addEventListener("pointermove", (event) => {
    if (from) {
      const [x, y] = inside(svg, event);
      const left = Math.min(x, from[0]), top = Math.min(y, from[1]);
      const wide = Math.abs(x - from[0]), tall = Math.abs(y - from[1]);
      for (const [key, value] of Object.entries({ x: left, y: top, width: wide, height: tall })) {
        rubber.setAttribute(key, value);
      }
      state.dragging = true;
      if (wide + tall > 6) choose(drawn, left, top, left + wide, top + tall);
      return;
    }
    point(event);
  });
  // A finger that leaves has tapped: what it told stays until the next tap or until one scrolls.
  svg.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") quiet();
  });
  svg.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") return point(event);
    if (event.button !== 0 || !box) return;
    from = inside(svg, event);
    drawn = places();
    quiet();
    rubber = el("rect", { class: "rubber" }, svg);
    svg.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  const end = (event) => {
    if (!from) return;
    const [x, y] = inside(svg, event);
    state.dragging = false;
    if (Math.abs(x - from[0]) + Math.abs(y - from[1]) <= 6) forget();
    else changed("chosen");
    rubber.remove();
    from = null;
  };
  svg.addEventListener("pointerup", end);
  svg.addEventListener("pointercancel", end);
}

function choose(places, left, top, right, bottom) {
  const chosen = new Uint8Array(count);
  for (const [i, x, y] of places) {
    if (x >= left && x <= right && y >= top && y <= bottom) chosen[i] = 1;
  }
  state.chosen = chosen;
  changed("chosen");
}

function forget() {
  if (!state.chosen) return;
  state.chosen = null;
  changed("chosen");
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") { quiet(); forget(); }
});
document.addEventListener("scroll", quiet, { passive: true });
