// The data embedded in the page.

const given = JSON.parse(document.getElementById("data").textContent);

/** The number of a frame in the recording. */
const numberOf = (frame) => given.start + frame * given.step;
