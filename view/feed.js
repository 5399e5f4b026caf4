// A live page reads the server's stream and draws the newest frame.

const described = JSON.parse(document.getElementById("data").textContent);
const feed = { last: -1, all: 0, came: 0, age: 0, over: false };
let told = { at: 0, came: 0, all: 0 };
/** Milliseconds between two updates of the numbers, so that they stay readable. */
const READABLE = 500;

/** The server's lines, until it ends or `signal` aborts. */
async function* answers(signal) {
  const { body } = await fetch(`frames?after=${feed.last}`, { signal });
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const lines = (text + value).split("\n");
    text = lines.pop();
    yield* lines.map(JSON.parse);
  }
}

/** The pieces after the last one, as they arrive, until the source ends or `signal` aborts. */
async function* pulled(signal) {
  try {
    for await (const answer of answers(signal)) {
      if (answer.pieces.length) feed.last = unpack(answer.pieces.at(-1).numbers).at(-1);
      tell(answer);
      yield answer.pieces;
      feed.over = answer.over;
      if (feed.over) tell(answer);
    }
  } catch { /* the server has gone, or it was told to stop */ }
  if (signal.aborted || feed.over) return;
  feed.over = true;
  tell({ state: "gone", message: "The command tfra live has ended. To continue, start it again and reload this page." });
}

/** Show the source of the frames and their counts. */
function tell({ state, message, came, estimated, malformed, fault }) {
  const place = (id) => document.getElementById(id);
  if (place("state").textContent !== message) place("state").textContent = message;
  place("live").classList.toggle("over", ["ended", "broken", "gone"].includes(state));
  const [now, whole] = [performance.now(), (number) => number.toLocaleString("en")];
  if (came === undefined || (now - told.at < READABLE && !feed.over)) return;
  const each = (count, before) => Math.round((1000 * (count - before)) / (now - told.at));
  const rates = feed.over ? ["", ""] : [` (${each(came, told.came)} a second)`, ` (${each(feed.all, told.all)} a second)`];
  const age = feed.over || !feed.all ? "" : ` The frame shown was ${Math.round(feed.age)} ms old when it was drawn.`;
  place("counts").textContent = `${whole(came)} frames came${rates[0]}, ${whole(estimated)} were estimated, ${whole(feed.all)} drawn here${rates[1]}.${age}`;
  place("fault").hidden = !malformed;
  if (malformed) place("fault").textContent = `Malformed lines: ${whole(malformed)}. The first: ${fault}.`;
  fetch(`drawn?count=${feed.all - told.all}`);
  told = { at: now, came, all: feed.all };
}

/** The first pieces: none if the source ends without any. */
async function firstPieces() {
  const stop = new AbortController();
  for await (const pieces of pulled(stop.signal)) {
    if (!pieces.length) continue;
    stop.abort();
    return pieces;
  }
  return [];
}

document.getElementById("kept").textContent = described.seconds;
document.body.classList.add("waiting");
const early = await firstPieces();
if (!early.length) return;
document.body.classList.remove("waiting");
const given = { ...described, time: early[0].time, results: [{ ...described.results[0], ...early[0].results[0] }] };
