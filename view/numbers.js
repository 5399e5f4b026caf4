// Taxels, and numbers as they are shown.

const TAXELS = given.rows * given.columns;
const TOP = 32767;

const modulus = (...parts) => Math.hypot(...parts);

/** The values of all taxels of a frame, in SI. */
function plane({ codes, scale }, frame) {
  const found = new Float32Array(TAXELS);
  for (let k = 0; k < TAXELS; k += 1) found[k] = codes[frame * TAXELS + k] * scale[frame];
  return found;
}

/** A unit in which `peak`, in SI, has few digits before and after the point. */
function unitFor(peak, name) {
  const [prefix, size] = [["k", 1e3], ["", 1], ["m", 1e-3], ["µ", 1e-6]].find(([, least]) => peak >= least) ?? ["", 1];
  return { name: prefix + name, size, of: (value) => figures(value / size) };
}

/** A number with four significant digits. */
function figures(value) {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

/** The position of a taxel in mm. */
const placeOf = (k) => [(k % given.columns) * given.pitch[0], Math.floor(k / given.columns) * given.pitch[1]];
