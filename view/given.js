// What the page was made with.

const given = JSON.parse(document.getElementById("data").textContent);

/** The number of a frame in the recording. */
const numberOf = (frame) => given.start + frame * given.step;
