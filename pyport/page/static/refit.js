// The model's terms fitted again in the page: held or left out, recordings masked.

const again = data.linear && readLinear(data.linear);

function readLinear(packed) {
  const sides = axes.map((axis) => axis.letter);
  const left = {}, whole = {}, columns = {};
  for (const side of sides) {
    left[side] = numbers(packed.left[side]);
    columns[side] = packed.columns[side].map((one) => one && numbers(one));
    // What was measured: what is left, and all that the model adds.
    whole[side] = Float64Array.from(left[side]);
    columns[side].forEach((column, k) => {
      if (column) for (let i = 0; i < count; i++) whole[side][i] += packed.values[k] * column[i];
    });
  }
  return {
    ...packed, sides, whole, columns, masked: new Uint8Array(count),
    states: packed.free.map((free) => (free ? "fitted" : "held")),
  };
}

// Fits what is free to what is not masked; every panel then shows what that leaves.
function fitAgain() {
  const free = again.names.map((_, k) => k).filter((k) => again.states[k] === "fitted");
  const used = [];
  for (const side of again.sides) {
    for (let i = 0; i < count; i++) {
      if (!again.masked[i] && !Number.isNaN(again.whole[side][i])) used.push([side, i]);
    }
  }
  const held = ([side, i]) => again.names.reduce((sum, _, k) => sum
    - (again.states[k] === "held" && again.columns[side][k]
      ? again.values[k] * again.columns[side][k][i] : 0), again.whole[side][i]);
  const values = Float64Array.from(used, held);
  const columns = free.map((k) => Float64Array.from(used, ([side, i]) =>
    (again.columns[side][k] ? again.columns[side][k][i] : 0)));
  const found = leastSquares(columns, values);
  const now = again.values.map((value, k) => (again.states[k] === "held" ? value : 0));
  const sigma = again.values.map(() => null);
  free.forEach((k, n) => {
    now[k] = found.known[n] ? found.sizes[n] : NaN;
    sigma[k] = found.sigmas[n];
  });
  const left = {};
  for (const side of again.sides) {
    left[side] = Float64Array.from(again.whole[side]);
    now.forEach((value, k) => {
      const column = again.columns[side][k];
      if (column && value) for (let i = 0; i < count; i++) left[side][i] -= value * column[i];
    });
  }
  const stars = new Set(used.map(([, i]) => i)).size;
  state.fit = { now, sigma, left, stars, masked: again.masked, rms: Math.sqrt(dot(found.left, found.left) / (stars || 1)) };
  changed("layers");
}

function forgetFit() {
  state.fit = null;
  again.masked.fill(0);
  again.states = again.free.map((free) => (free ? "fitted" : "held"));
  changed("layers");
}

function mask(which) {
  for (let i = 0; i < count; i++) if (which(i)) again.masked[i] = 1;
  forget();
  fitAgain();
}

const quoted = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replace(/'/g, "'\\''")}'`);
const modelName = () => data.file.replace(/\.\w+$/, "") + ".toml";

// The commands that do the same: the model's file is what the page gives.
function commands() {
  const lines = stretchesOf(everyone.filter((i) => again.masked[i]).map((i) => rows.line[i]));
  const file = quoted(data.file);
  const named = (which, word) => [...new Set(again.names.filter((_, k) => which(k)))]
    .map((name) => ` ${word} ${quoted(name)}`).join("");
  const is = (state, free) => (k) => again.states[k] === state && again.free[k] === free;
  const out = (k) => again.states[k] === "left out";
  // A term that the file holds is free once it was left out and came in again.
  const fit = `pyport fit ${file} --model ${quoted(modelName())} --weights equal`
    + named((k) => out(k) || is("fitted", false)(k), "--drop") + named(is("fitted", false), "--add")
    + named(is("held", true), "--fix");
  return lines ? [`pyport mask ${file} --lines ${lines} --reason 'masked on the page'`, fit] : [fit];
}

function stretchesOf(lines) {
  const out = [];
  for (const line of [...lines].sort((a, b) => a - b)) {
    const last = out[out.length - 1];
    if (last && line === last[1] + 1) last[1] = line;
    else if (!last || line !== last[1]) out.push([line, line]);
  }
  return out.map(([a, b]) => (a === b ? `${a}` : `${a}-${b}`)).join(",");
}

function refitTable(host) {
  const bar = html("div", "buttons", host);
  const button = (text, what) => {
    const one = html("button", "clear", bar, text);
    one.type = "button";
    one.addEventListener("click", what);
    return one;
  };
  const chosen = button("mask the chosen recordings", () => mask((i) => state.chosen && state.chosen[i]));
  if (everyone.some(uncounted)) button("mask the outliers", () => mask(uncounted));
  button("fit", fitAgain);
  button("back to the page's values", forgetFit);
  const table = html("table", "", html("div", "scroll", host));
  const head = html("tr", "", html("thead", "", table));
  for (const name of ["term", "", "on the page", "fitted again", "sigma", "unit"]) {
    html("th", "", head, name);
  }
  const body = html("tbody", "", table);
  const lines = again.labels.map((label, k) => {
    const row = html("tr", "", body);
    html("td", "", row, label.replace(/_/g, " "));
    const select = html("select", "", html("td", "", row));
    select.setAttribute("aria-label", label);
    for (const name of ["fitted", "held", "left out"]) html("option", "", select, name);
    select.addEventListener("change", () => {
      // A name stands for all its antennas and sessions, here as in the command.
      again.names.forEach((name, other) => {
        if (name === again.names[k]) again.states[other] = select.value;
      });
      fitAgain();
    });
    const cells = [0, 1, 2].map(() => html("td", "n", row));
    html("td", "", row, again.units[k]);
    cells[0].textContent = plain(again.values[k].toFixed(2));
    return { select, cells };
  });
  const told = html("p", "told-again", host);
  told.setAttribute("aria-live", "polite");
  const code = html("pre", "command", host);
  const copy = html("button", "clear", host, "copy the command");
  copy.type = "button";
  copy.addEventListener("click", () => {
    getSelection().selectAllChildren(code);
    document.execCommand("copy");
  });
  listeners.push((what) => {
    if (what === "at") return;
    chosen.disabled = !state.chosen;
    if (what === "chosen") return;
    lines.forEach(({ select, cells }, k) => {
      select.value = again.states[k];
      const value = state.fit ? state.fit.now[k] : NaN;
      const sigma = state.fit ? state.fit.sigma[k] : null;
      cells[1].textContent = Number.isNaN(value) ? (state.fit ? "not determined" : "") : plain(value.toFixed(2));
      cells[1].dataset.value = value;
      cells[2].textContent = sigma === null || Number.isNaN(value) ? "" : sigma.toFixed(2);
      cells[2].dataset.value = sigma;
    });
    const masked = again.masked.reduce((a, b) => a + b, 0);
    told.textContent = state.fit
      ? `Sky rms ${state.fit.rms.toFixed(4)} ${data.unit}, all readings alike, of ${state.fit.stars} `
        + `pointings; ${masked} masked.` : "";
    code.textContent = commands().join("\n");
  });
}
