// Frames in typed arrays, and the numbers of a frame from them.

/** Values by name, and |F| if its components are known. */
function unpackValues(packed) {
  const values = unpackAll(packed);
  if (values.f_z) values.f = Float32Array.from(values.f_z, (z, n) => modulus(values.f_x[n], values.f_y[n], z));
  return values;
}

const unpackResult = (result) => ({
  ...result,
  values: unpackValues(result.values),
  status: unpack(result.status),
  index: unpack(result.index),
  stress: unpackAll(result.stress),
  forces: result.forces?.map(unpackAll),
  left: result.left && unpackAll(result.left),
  sweep: result.sweep && unpackAll(result.sweep),
});

const results = given.results.map(unpackResult);
const references = given.references.map((known) => ({ ...known, values: unpackValues(known.values) }));
const tested = results.some(({ values }) => values.residual);
const judged = results.some(({ threshold }) => threshold);
const distributed = results.some(({ forces }) => forces);
const swept = results.some(({ sweep }) => sweep);
let times = given.time && unpack(given.time);
let COUNT = results[0].status.length;

/** The largest magnitude of these planes, of one frame or of all. */
function peakOf(planes, frame) {
  let largest = 0;
  for (const { scale } of planes) {
    if (frame !== undefined) largest = Math.max(largest, scale[frame]);
    else for (const one of scale) largest = Math.max(largest, one);
  }
  return TOP * largest;
}

/** The largest tangential and normal resultants of one frame or of all. */
function peakResultants(frame) {
  let [resultant, pressing] = [0, 0];
  const [first, end] = frame === undefined ? [0, COUNT] : [frame, frame + 1];
  for (const { values: { f_x: x, f_y: y, f_z: z } } of results) {
    for (let n = first; n < end; n += 1) {
      resultant = Math.max(resultant, modulus(x[n], y[n]));
      pressing = Math.max(pressing, Math.abs(z[n]));
    }
  }
  return { resultant, pressing };
}

/** The largest magnitudes of one frame or of all. */
const peaksAt = (frame) => ({
  ...peakResultants(frame),
  stress: peakOf(results.map(({ stress }) => stress), frame),
  left: peakOf(results.flatMap(({ left }) => left ?? []), frame),
  tangential: peakOf(results.flatMap(({ forces }) => forces?.slice(0, 2) ?? []), frame),
  normal: peakOf(results.flatMap(({ forces }) => forces?.[2] ?? []), frame),
});

let [PEAKS, STRESS, FORCE] = [];

/** Find the scales and units of all frames. */
function measure() {
  PEAKS = peaksAt();
  STRESS = unitFor(PEAKS.stress, "Pa");
  FORCE = unitFor(Math.max(PEAKS.tangential, PEAKS.normal), "N");
  for (const place of document.querySelectorAll("[data-unit]")) place.textContent = (place.dataset.unit === "stress" ? STRESS : FORCE).name;
}

const has = (result, frame, bits) => (result.status[frame] & bits) !== 0;

/** Whether a frame determines a value: without a tangential force there is no angle. */
function tells(result, name, frame) {
  if (["f_z", "f", "uncertainty", "residual"].includes(name)) return !has(result, frame, given.bits.noContact);
  return !has(result, frame, given.bits.withoutForce | (name === "phi" ? given.bits.noDirection : 0));
}

const valueOf = (result, name, frame) => (tells(result, name, frame) ? result.values[name]?.[frame] : undefined);

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
