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
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const lines = (text + value).split("\n");
      text = lines.pop();
      yield* lines.map(JSON.parse);
    }
  } finally {
    reader.cancel().catch(() => {});
  }
}

/** The pieces after the last one, as they arrive, until the source ends or `signal` aborts. */
async function* pulled(signal) {
  try {
    for await (const answer of answers(signal)) {
      if (answer.pieces.length) feed.last = unpack(answer.pieces.at(-1).numbers).at(-1);
      feed.over = answer.over;
      if (!feed.over) tell(answer);
      yield answer.pieces;
      if (feed.over) return await tell(answer);
    }
  } catch { /* the server has gone, or it was told to stop */ }
  if (signal.aborted || feed.over) return;
  feed.over = true;
  tell({ state: "gone", message: "The command tfra live has ended. To continue, start it again and reload this page." });
}

/** A new reading of the server's stream: its pieces, and what stops it. */
function opened() {
  const stop = new AbortController();
  return { pieces: pulled(stop.signal), stop };
}

/** Say what became of the tare, where there can be a new one. */
function tellTare(tare) {
  const [place, button] = [document.getElementById("tared"), document.getElementById("tare")];
  button.parentElement.hidden = tare === undefined;
  button.hidden = feed.over;
  if (tare !== undefined && place.textContent !== tare) place.textContent = tare;
}

document.getElementById("tare").addEventListener("click", async () => {
  const answer = await fetch("tare", { method: "POST" }).catch(() => {});
  if (answer?.ok) tellTare(await answer.text());
});

/** Show the source of the frames and their counts; resolves when the server knows how many were drawn. */
function tell({ state, message, came, estimated, malformed, fault, tare }) {
  const place = (id) => document.getElementById(id);
  if (place("state").textContent !== message) place("state").textContent = message;
  tellTare(tare);
  place("live").classList.toggle("over", ["ended", "broken", "gone"].includes(state));
  const [now, whole] = [performance.now(), (number) => number.toLocaleString("en")];
  if (came === undefined || (now - told.at < READABLE && !feed.over)) return;
  const each = (count, before) => Math.round((1000 * (count - before)) / (now - told.at));
  const rates = feed.over ? ["", ""] : [` (${each(came, told.came)} a second)`, ` (${each(feed.all, told.all)} a second)`];
  const age = feed.over || !feed.all ? "" : ` The frame shown was ${Math.round(feed.age)} ms old when it was drawn.`;
  place("counts").textContent = `${whole(came)} frames came${rates[0]}, ${whole(estimated)} were estimated, ${whole(feed.all)} drawn here${rates[1]}.${age}`;
  place("fault").hidden = !malformed;
  if (malformed) place("fault").textContent = `Malformed lines: ${whole(malformed)}. The first: ${fault}.`;
  const drawn = fetch(`drawn?count=${feed.all - told.all}`).catch(() => {});
  told = { at: now, came, all: feed.all };
  return drawn;
}

let source = opened();

/** The first pieces: none if the source ends without any. */
async function firstPieces() {
  for (;;) {
    const { done, value } = await source.pieces.next();
    if (done) return [];
    if (value.length) return value;
  }
}

document.getElementById("kept").textContent = described.seconds;
document.body.classList.add("waiting");
const early = await firstPieces();
if (!early.length) return;
document.body.classList.remove("waiting");
const given = { ...described, time: early[0].time, results: [{ ...described.results[0], ...early[0].results[0] }] };
