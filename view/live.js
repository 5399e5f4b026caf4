// Live frames: appended, drawn, and dropped after some seconds.

let numbers = unpack(early[0].numbers);

/** The number of a frame among those that came. */
function numberOf(frame) {
  return numbers[frame];
}

/** Frames of a live page come and go: its address names none. */
function link() {}

/** Milliseconds between two drawings of the charts, at least, and as a multiple of the time that one takes. */
const CHARTS = { least: 1000, times: 20 };
let charted = { at: 0, cost: 0 };

/** An array without its first `drop` numbers and with `fresh` appended; it is copied only when its buffer is full. */
function moved(kept, drop, fresh) {
  const [stays, length] = [kept.length - drop, kept.length - drop + fresh.length];
  const start = kept.byteOffset + drop * kept.BYTES_PER_ELEMENT;
  const full = start + length * kept.BYTES_PER_ELEMENT > kept.buffer.byteLength;
  const next = full ? new kept.constructor(2 * length).subarray(0, length) : new kept.constructor(kept.buffer, start, length);
  if (full) next.set(kept.subarray(drop));
  next.set(fresh, stays);
  return next;
}

/** The same for all arrays of an object, each with some numbers per frame of COUNT. */
function extended(kept, fresh, drop) {
  if (ArrayBuffer.isView(kept)) return moved(kept, drop * (kept.length / COUNT), fresh);
  if (typeof kept === "object") for (const key of Object.keys(fresh)) kept[key] = extended(kept[key], fresh[key], drop);
  return kept;
}

function append(piece) {
  const fresh = unpackResult(piece.results[0]);
  const seconds = unpack(piece.time);
  const count = seconds.length;
  const old = (frame) => times[frame] < seconds.at(-1) - given.seconds || COUNT - frame + count > given.most;
  let drop = 0;
  while (drop < COUNT && old(drop)) drop += 1;
  extended(results[0], fresh, drop);
  [times, numbers] = [moved(times, drop, seconds), moved(numbers, drop, unpack(piece.numbers))];
  COUNT += count - drop;
  state.frame = Math.max(0, state.frame - drop);
  $("frame").max = COUNT - 1;
}

/** Draw the charts over the frames, unless they are recent. */
function chart() {
  const begun = performance.now();
  if (begun - charted.at < Math.max(CHARTS.least, CHARTS.times * charted.cost)) return;
  drawPanels($("panels"));
  charted = { at: performance.now(), cost: performance.now() - begun };
}

let asked = 0;

/** Draw the newest frame; frames since the last drawing are skipped. */
function drawLast() {
  asked = 0;
  measure();
  if (!state.playing) return;
  show(COUNT - 1);
  chart();
  feed.all += 1;
  feed.age = Date.now() - 1000 * feed.came;
}

/** Read frames until the source ends or is stopped; what came last is drawn at once, before the server hears of it. */
async function follow() {
  source ??= opened();
  show(COUNT - 1);
  for await (const pieces of source.pieces) {
    if (feed.over && asked) {
      cancelAnimationFrame(asked);
      drawLast();
    }
    if (!pieces.length) continue;
    pieces.forEach(append);
    feed.came = pieces.at(-1).came;
    if (!asked) asked = requestAnimationFrame(drawLast);
  }
  if (state.playing && feed.over) play(false);
}

/** Follow the newest frame, or pause. */
function play(wanted) {
  const [begins, ends] = [wanted && !state.playing, !wanted && state.playing];
  state.playing = wanted;
  $("play").textContent = wanted ? "Pause" : "Follow";
  if (begins) follow();
  if (!ends) return;
  source.stop.abort();
  source = undefined;
  drawPanels($("panels"));
  settle();
}

$("frame").max = COUNT - 1;
early.slice(1).forEach(append);
begin(COUNT - 1).then(() => {
  feed.all += 1;
  play(true);
});
