// What can be taken from the page: the model's file, the recordings as rows, the panels as figures.

function give(name, kind, text) {
  const link = html("a", "", document.body);
  link.href = URL.createObjectURL(new Blob([text], { type: kind }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
  link.remove();
}

function rowsText() {
  const names = ["line", ...rows.labels.map(([name]) => name), ...(data.time ? ["time_utc"] : []),
    "az_deg", "el_deg", ...axes.flatMap((axis) =>
      ["before", "after"].map((name) => `residual_${axis.name.replace(/\W+/g, "_")}_${name}_${data.unit}`))];
  const cell = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  const number = (value, digits) => (Number.isNaN(value) ? "" : value.toFixed(digits));
  const lines = everyone.map((i) => [rows.line[i], ...rows.labels.map(([, one]) => cell(one.names[one.codes[i]])),
    ...(data.time ? [Number.isNaN(rows.seconds[i]) ? "" : clock(rows.seconds[i])] : []),
    number(rows.az[i], 5), number(rows.el[i], 5),
    ...axes.flatMap((axis) => [number(axis.before[i], 4), number(axis.after[i], 4)])].join(","));
  return `${[names.join(","), ...lines].join("\n")}\n`;
}

// A panel as a file of its own: what the page's style says of each part is written into it.
const STYLED = ["fill", "fill-opacity", "stroke", "stroke-opacity", "stroke-width", "stroke-dasharray",
  "stroke-linecap", "stroke-linejoin", "font", "visibility", "paint-order"];

function figureText(svg) {
  const copy = svg.cloneNode(true);
  const parts = [...svg.querySelectorAll("*")];
  [...copy.querySelectorAll("*")].forEach((part, n) => {
    const style = getComputedStyle(parts[n]);
    part.setAttribute("style", STYLED.map((key) => `${key}:${style.getPropertyValue(key)}`).join(";"));
  });
  copy.setAttribute("xmlns", SVG);
  return new XMLSerializer().serializeToString(copy);
}

function downloads(host) {
  const stem = data.file.replace(/\.\w+$/, "");
  const button = (parent, text, what) => {
    const one = html("button", "clear", parent, text);
    one.type = "button";
    one.addEventListener("click", what);
  };
  html("span", "hint", host, "download: ");
  if (data.model) button(host, "model", () => give(`${stem}.toml`, "application/toml", data.model));
  button(host, "rows", () => give(`${stem}-rows.csv`, "text/csv", rowsText()));
  button(host, "figures", () => {
    const figures = [...document.querySelectorAll("main .drawing svg")].map((svg) =>
      `<figure><figcaption>${svg.getAttribute("aria-label")}</figcaption>${figureText(svg)}</figure>`);
    give(`${stem}-figures.html`, "text/html", `<!doctype html><meta charset="utf-8">${figures.join("\n")}`);
  });
  for (const box of document.querySelectorAll("main figure.panel")) {
    const one = html("button", "save", box, "SVG");
    one.type = "button";
    one.title = "save this panel as a figure";
    one.addEventListener("click", () => {
      const svg = box.querySelector("svg");
      give(`${stem}-${svg.getAttribute("aria-label").replace(/\W+/g, "-")}.svg`, "image/svg+xml", figureText(svg));
    });
  }
}
