// Least squares from sums over the recordings: the Gram matrix of the columns, and its inverse.

// A column that others draw to this share of its length is not determined.
const DRAWN = 1e-9;

// `columns` are arrays of m numbers, `values` what they are to add up to. Returns how many of each,
// their errors when all numbers scatter alike, and what is left.
function leastSquares(columns, values) {
  const m = values.length, lengths = columns.map((one) => Math.sqrt(dot(one, one)) || 1);
  const gram = columns.map((a, i) => columns.map((b, j) => dot(a, b) / (lengths[i] * lengths[j])));
  const right = columns.map((a, i) => dot(a, values) / lengths[i]);
  const known = columns.map(() => true);
  const inverse = inverted(gram, known);
  const sizes = inverse.map((row, i) => dot(row, right) / lengths[i]);
  const left = Float64Array.from(values);
  columns.forEach((column, i) => {
    for (let n = 0; n < m; n++) left[n] -= sizes[i] * column[n];
  });
  const free = m - known.filter(Boolean).length;
  const scatter = Math.sqrt(dot(left, left) / Math.max(free, 1));
  const sigmas = inverse.map((row, i) => scatter * Math.sqrt(Math.max(row[i], 0)) / lengths[i]);
  return { sizes, sigmas, known, left };
}

function dot(a, b) {
  let sum = 0;
  for (let n = 0; n < a.length; n++) sum += a[n] * b[n];
  return sum;
}

// The inverse by sweeps, the largest pivot first; what has no pivot left is marked as not known.
function inverted(gram, known) {
  const k = gram.length, out = gram.map((row) => Float64Array.from(row));
  const open = new Set(gram.keys());
  while (open.size) {
    let p = -1;
    for (const i of open) if (p < 0 || out[i][i] > out[p][p]) p = i;
    if (!(out[p][p] > DRAWN)) break;
    open.delete(p);
    const pivot = out[p][p];
    for (let i = 0; i < k; i++) {
      if (i === p) continue;
      const share = out[i][p] / pivot;
      for (let j = 0; j < k; j++) if (j !== p) out[i][j] -= share * out[p][j];
    }
    for (let i = 0; i < k; i++) {
      if (i === p) continue;
      out[i][p] = -out[i][p] / pivot;
      out[p][i] = out[p][i] / pivot;
    }
    out[p][p] = 1 / pivot;
  }
  for (const i of open) {
    known[i] = false;
    for (let j = 0; j < k; j++) out[i][j] = out[j][i] = 0;
  }
  return out;
}
