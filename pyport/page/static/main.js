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
  const kinds = data.layers.length ? ["before", "after"] : ["before"];
  for (const polar of [true, false]) {
    for (const name of kinds) {
      add(skies, "panel", `${NAMES[name]}${polar ? "" : ", over azimuth and elevation"}`,
        (host) => sky(host, name, polar));
    }
  }
  const against_ = document.getElementById("against-panels");
  const first = columns.filter((one) => ["az", "el", "hour_angle"].includes(one.name));
  const time = columns.find((one) => one.name === "time");
  const others = columns.filter((one) => !first.includes(one) && one !== time);
  // Whole lines of three panels, at most two.
  const rest = Math.min(others.length, 6 - first.length);
  const shown = [...first, ...others.slice(0, rest - (first.length + rest) % 3)];
  for (const column of shown) add(against_, "panel", "", (host) => against(host, column));
  if (time) add(against_, "panel full", "", (host) => against(host, time));
  const more = others.filter((one) => !shown.includes(one));
  if (more.length) addChoice(against_, more);
  const spreads = document.getElementById("spread-panels");
  for (const axis of axes) add(spreads, "panel", "", (host) => spread(host, axis));
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
    const left = data.layers.length ? "after" : "before";
    const found = everyone.filter((i) => state.chosen[i])
      .sort((a, b) => size(b, left) - size(a, left)).slice(0, MOST);
    html("h3", "", host, `Chosen recordings${found.length === MOST ? `, the ${MOST} furthest off` : ""}`);
    const table = html("table", "", html("div", "scroll", host));
    const head = html("tr", "", html("thead", "", table));
    const body = html("tbody", "", table);
    const names = ["line", ...rows.labels.map(([name]) => name), "az", "el",
      ...axes.flatMap((axis) => [`${axis.name}, before`, ...(data.layers.length ? ["after"] : [])])];
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
built.forEach(render);
// On paper every panel is drawn for the width of the paper; what is folded is opened.
addEventListener("beforeprint", () => {
  document.documentElement.classList.add("paper");
  for (const details of document.querySelectorAll("details")) details.open = true;
  built.forEach(render);
});
addEventListener("afterprint", () => {
  document.documentElement.classList.remove("paper");
  built.forEach(render);
});
listeners.push((what) => built.forEach((one) => {
  const skipped = what === "stretch" && !one.host.closest("#sky-panels");
  if (one.drawn && !skipped) one.drawn(what);
}));
changed("all");
new ResizeObserver(() => requestAnimationFrame(() => {
  built.forEach(render);
})).observe(document.querySelector("main"));
document.documentElement.dataset.ready = "";
