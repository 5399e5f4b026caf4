// A live page asks the server for what is new whenever it has the last of it, so that nothing waits anywhere.

const described = JSON.parse(document.getElementById("data").textContent);
const feed = { last: -1, drawn: 0, all: 0, came: 0, age: 0, over: false };
let told = { at: 0, came: 0, all: 0 };
/** Milliseconds between two texts of numbers, so that they can be read. */
const READABLE = 500;

/** The pieces behind the last one: none after a while without any, and when the server has gone. */
async function pulled() {
  const drawn = feed.drawn;
  feed.drawn = 0;
  let answer;
  try {
    answer = await (await fetch(`frames?after=${feed.last}&drawn=${drawn}`)).json();
  } catch {
    feed.over = true;
    tell({ state: "gone", said: "The command tfra live was ended. To go on, start it again and reload this page." });
    return [];
  }
  const pieces = answer.pieces;
  if (pieces.length) feed.last = unpack(pieces.at(-1).numbers).at(-1);
  feed.over = ["ended", "broken"].includes(answer.state) && !pieces.length && !feed.drawn;
  tell(answer);
  return pieces;
}

/** Say where frames come from and what became of them. */
function tell({ state, said, came, estimated, malformed, fault }) {
  const place = (id) => document.getElementById(id);
  if (place("state").textContent !== said) place("state").textContent = said;
  place("live").classList.toggle("over", ["ended", "broken", "gone"].includes(state));
  const [now, whole] = [performance.now(), (number) => number.toLocaleString("en")];
  if (came === undefined || (now - told.at < READABLE && !feed.over)) return;
  const each = (count, before) => Math.round((1000 * (count - before)) / (now - told.at));
  const rates = feed.over ? ["", ""] : [` (${each(came, told.came)} a second)`, ` (${each(feed.all, told.all)} a second)`];
  const age = feed.over || !feed.all ? "" : ` The frame shown was ${Math.round(feed.age)} ms old when it was drawn.`;
  place("counts").textContent = `${whole(came)} frames came${rates[0]}, ${whole(estimated)} were estimated, ${whole(feed.all)} drawn here${rates[1]}.${age}`;
  place("fault").hidden = !malformed;
  if (malformed) place("fault").textContent = `Malformed lines: ${whole(malformed)}. The first: ${fault}.`;
  told = { at: now, came, all: feed.all };
}

async function firstPieces() {
  document.body.classList.add("waiting");
  let pieces = [];
  while (!pieces.length && !feed.over) pieces = await pulled();
  return pieces;
}

document.getElementById("kept").textContent = described.seconds;
const early = await firstPieces();
if (!early.length) return;
document.body.classList.remove("waiting");
const given = { ...described, time: early[0].time, results: [{ ...described.results[0], ...early[0].results[0] }] };
