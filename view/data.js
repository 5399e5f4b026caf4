// What the page was given: typed arrays, and the numbers of a frame from them.

const given = JSON.parse(document.getElementById("data").textContent);
const TYPES = { float32: Float32Array, float64: Float64Array, int16: Int16Array, uint8: Uint8Array };
const TAXELS = given.rows * given.columns;
const TOP = 32767;

function unpack({ type, data }) {
  const text = atob(data);
  const bytes = new Uint8Array(text.length);
  for (let at = 0; at < text.length; at += 1) bytes[at] = text.charCodeAt(at);
  return new TYPES[type](bytes.buffer);
}

const unpackAll = (packed) => Object.fromEntries(Object.entries(packed).map(([name, value]) => [name, unpack(value)]));

const results = given.results.map((result) => ({
  ...result,
  values: unpackAll(result.values),
  status: unpack(result.status),
  index: unpack(result.index),
  stress: unpackAll(result.stress),
  forces: result.forces.map(unpackAll),
  sweep: unpackAll(result.sweep),
}));
const references = given.references.map((known) => ({ ...known, values: unpackAll(known.values) }));
const times = given.time && unpack(given.time);
const COUNT = results[0].status.length;

const modulus = (...parts) => Math.hypot(...parts);
for (const { values } of [...results, ...references]) {
  if (values.f_z) values.f = Float32Array.from(values.f_z, (z, n) => modulus(values.f_x[n], values.f_y[n], z));
}

/** The number of a frame in the recording. */
const numberOf = (frame) => given.start + frame * given.step;

/** The values of all taxels of a frame, in SI. */
function plane({ codes, scale }, frame) {
  const found = new Float32Array(TAXELS);
  for (let k = 0; k < TAXELS; k += 1) found[k] = codes[frame * TAXELS + k] * scale[frame];
  return found;
}

/** The largest magnitude of these planes, of one frame or of all. */
function peakOf(planes, frame) {
  let largest = 0;
  for (const { scale } of planes) {
    if (frame !== undefined) largest = Math.max(largest, scale[frame]);
    else for (const one of scale) largest = Math.max(largest, one);
  }
  return TOP * largest;
}

const PEAKS = {
  stress: peakOf(results.map(({ stress }) => stress)),
  tangential: peakOf(results.flatMap(({ forces }) => [forces[0], forces[1]])),
  normal: peakOf(results.map(({ forces }) => forces[2])),
};

/** A unit in which `peak`, in SI, has few digits before and behind the point. */
function unitFor(peak, name) {
  const [prefix, size] = [["k", 1e3], ["", 1], ["m", 1e-3], ["µ", 1e-6]].find(([, least]) => peak >= least) ?? ["", 1];
  return { name: prefix + name, size, of: (value) => figures(value / size) };
}

/** Four figures. */
function figures(value) {
  if (value === undefined || Number.isNaN(value)) return "–";
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

const STRESS = unitFor(PEAKS.stress, "Pa");
const FORCE = unitFor(Math.max(PEAKS.tangential, PEAKS.normal), "N");

const has = (result, frame, bits) => (result.status[frame] & bits) !== 0;

/** Whether a value says something in a frame: there is no angle without a tangential force. */
function tells(result, name, frame) {
  if (["f_z", "f"].includes(name)) return !has(result, frame, given.bits.noContact);
  return !has(result, frame, given.bits.withoutForce | (name === "phi" ? given.bits.noDirection : 0));
}

const valueOf = (result, name, frame) => (tells(result, name, frame) ? result.values[name][frame] : undefined);

/** The place of a taxel in mm. */
const placeOf = (k) => [(k % given.columns) * given.pitch[0], Math.floor(k / given.columns) * given.pitch[1]];

/** The centroid of the stress of one sign in mm (Eqs. 19-22); undefined without any. */
function centroid(stress, sign) {
  let [sum, x, y] = [0, 0, 0];
  stress.forEach((value, k) => {
    const part = Math.max(sign * value, 0);
    const place = placeOf(k);
    sum += part;
    x += part * place[0];
    y += part * place[1];
  });
  return sum > 0 ? [x / sum, y / sum] : undefined;
}
