// Builds the panels where the page has room for them, and keeps them in step.

const built = [];

function build(id, what) {
  const host = document.getElementById(id);
  if (host) built.push({ host, what, drawn: null, width: 0 });
}

function render(one) {
  const width = Math.floor(one.host.clientWidth);
  if (!width || width === one.width) return;
  one.width = width;
  one.host.replaceChildren();
  one.drawn = one.what(one.host);
}

const NAMES = { before: data.names[0], after: data.names[1] };

function figure(parent, className, caption) {
  const box = html("figure", className, parent);
  if (caption) html("figcaption", "", box, caption);
  return html("div", "drawing", box);
}

function add(parent, className, caption, what) {
  const host = figure(parent, className, caption);
  built.push({ host, what, drawn: null, width: 0 });
}

function lay() {
  const skies = document.getElementById("sky-panels");
  const kinds = data.layers.length ? ["before", "after"] : ["after"];
  for (const polar of [true, false]) {
    for (const name of kinds) {
      add(skies, "panel", `${NAMES[name]}${polar ? "" : ", over azimuth and elevation"}`,
        (host) => sky(host, name, polar));
    }
  }
  const against_ = document.getElementById("against-panels");
  const always = columns.filter((one) => ["az", "el", "hour_angle"].includes(one.name));
  const time = columns.find((one) => one.name === "time");
  const others = columns.filter((one) => !always.includes(one) && one !== time);
  // Whole lines of three panels, at most two.
  const rest = Math.min(others.length, 6 - always.length);
  const shown = [...always, ...others.slice(0, rest - (always.length + rest) % 3)];
  for (const column of shown) add(against_, "panel", "", (host) => against(host, column));
  if (time) add(against_, "panel full", "", (host) => against(host, time));
  const more = others.filter((one) => !shown.includes(one));
  if (more.length) addChoice(against_, more);
  const spreads = document.getElementById("spread-panels");
  if (across && along) add(spreads, "panel", "both axes", bullseye);
  add(spreads, "panel", "how many within", cumulative);
  for (const axis of axes) add(spreads, "panel", "", (host) => spread(host, axis));
  for (const [name, turn, values, wrap] of [["moved_az", "azimuth", rows.az, true],
    ["moved_el", "elevation", rows.el, false]]) {
    const column = moved(name, `${turn} moved since the recording before`, values, wrap);
    add(spreads, "panel", `hysteresis in ${turn}`, (host) => against(host, column));
  }
  const first = document.getElementById("first-sky");
  add(first, "panel", `${NAMES.after}, over the sky`, (host) => sky(host, "after", true));
}

// The columns that show least share one panel.
function addChoice(parent, more) {
  const box = html("figure", "panel full", parent);
  const label = html("label", "choice", box, "against ");
  const select = html("select", "", label);
  more.forEach((column, n) => {
    html("option", "", select, column.label).value = n;
  });
  const host = html("div", "drawing", box);
  const one = { host, what: (h) => against(h, more[select.value]), drawn: null, width: 0 };
  built.push(one);
  select.addEventListener("change", () => {
    one.width = 0;
    render(one);
  });
}

function toolbar() {
  const bar = document.getElementById("bar");
  if (data.layers.length) {
    const show = html("div", "segments", bar);
    show.setAttribute("role", "group");
    show.setAttribute("aria-label", "which residuals are drawn");
    for (const [name, text] of [["before", NAMES.before], ["both", "both"], ["after", NAMES.after]]) {
      const button = html("button", name, show, text);
      button.type = "button";
      button.addEventListener("click", () => {
        state.show = name;
        changed("show");
      });
      listeners.push(() => button.setAttribute("aria-pressed", String(state.show === name)));
    }
    const chips = html("div", "chips", bar);
    html("span", "hint", chips, "taken off:");
    data.layers.forEach((layer, n) => {
      const label = html("label", "chip", chips);
      const box = html("input", "", label);
      box.type = "checkbox";
      box.dataset.layer = n;
      html("span", "", label, layer.name);
      label.title = layer.name;
    });
  }
  const told = html("p", "told", bar);
  told.setAttribute("aria-live", "polite");
  const clear = html("button", "clear", bar, "clear the choice");
  clear.type = "button";
  clear.addEventListener("click", forget);
  listeners.push((what) => {
    if (what === "at") return;
    const sizes = axes.map((axis) => {
      const after = data.layers.length ? ` → ${short(rms(axis.after, axis.share))}` : "";
      return `${axis.name} ${short(rms(axis.before, axis.share))}${after}`;
    });
    const chosen = state.chosen ? state.chosen.reduce((a, b) => a + b, 0) : count;
    const which = state.chosen ? `${chosen} of ${count} chosen` : drawnText();
    told.textContent = `${which}: rms ${sizes.join(", ")} ${data.unit}`;
    clear.hidden = !state.chosen;
  });
}

function drawnText() {
  const masked = state.fit ? state.fit.masked.reduce((a, b) => a + b, 0) : 0;
  if (masked) return `${count - masked} of ${count} recordings, the others masked`;
  return count < data.total
    ? `${count} of ${data.total} drawn, chosen at random` : `${count} recordings`;
}

function switches() {
  for (const box of document.querySelectorAll("input[data-layer]")) {
    box.checked = true;
    box.addEventListener("change", () => {
      state.on[box.dataset.layer] = box.checked;
      for (const other of document.querySelectorAll("input[data-layer]")) {
        other.checked = state.on[other.dataset.layer];
      }
      changed("layers");
    });
  }
  const stretch = document.getElementById("stretch");
  stretch.addEventListener("input", () => {
    state.stretch = 2 ** Number(stretch.value);
    changed("stretch");
  });
}

// The chosen recordings as a table, the largest residuals first.
function listChosen() {
  const host = document.getElementById("chosen");
  const MOST = 40;
  listeners.push((what) => {
    if (what !== "chosen" && what !== "layers") return;
    host.replaceChildren();
    if (!state.chosen) return;
    const found = everyone.filter((i) => state.chosen[i])
      .sort((a, b) => size(b, "after") - size(a, "after")).slice(0, MOST);
    html("h3", "", host, `Chosen recordings${found.length === MOST ? `, the ${MOST} furthest off` : ""}`);
    const table = html("table", "", html("div", "scroll", host));
    const head = html("tr", "", html("thead", "", table));
    const body = html("tbody", "", table);
    const names = ["line", ...rows.labels.map(([name]) => name), "az", "el",
      ...axes.flatMap((axis) => (data.layers.length ? [`${axis.name}, before`, "after"] : [axis.name]))];
    for (const name of names) html("th", "", head, name);
    for (const i of found) {
      const row = html("tr", "", body);
      const cells = [rows.line[i], ...rows.labels.map(([, one]) => one.names[one.codes[i]]),
        rows.az[i].toFixed(2), rows.el[i].toFixed(2),
        ...axes.flatMap((axis) => [short(axis.before[i]),
          ...(data.layers.length ? [short(axis.after[i])] : [])])];
      for (const cell of cells) html("td", "", row, cell);
    }
  });
}

lay();
toolbar();
switches();
listChosen();
if (again) refitTable(document.getElementById("refit-table"));
downloads(document.getElementById("downloads"));
built.forEach(render);
// On paper every panel is drawn for the width of the paper; what is folded stays so.
addEventListener("beforeprint", () => {
  document.documentElement.classList.add("paper");
  built.forEach(render);
});
addEventListener("afterprint", () => {
  document.documentElement.classList.remove("paper");
  built.forEach(render);
});
// While a box is dragged only what is on the screen follows; the rest does when it is let go.
const onScreen = (one) => {
  const box = one.host.getBoundingClientRect();
  return box.bottom > 0 && box.top < innerHeight;
};
listeners.push((what) => {
  if (what === "all") return; // every panel has just been drawn
  const shown = state.dragging ? built.filter(onScreen) : built;
  for (const one of shown) {
    const skipped = what === "stretch" && !one.host.closest("#sky-panels, #first-sky");
    if (one.drawn && !skipped) one.drawn(what);
  }
});
changed("all");
new ResizeObserver(() => requestAnimationFrame(() => {
  built.forEach(render);
})).observe(document.querySelector("main"));
document.documentElement.dataset.ready = "";
