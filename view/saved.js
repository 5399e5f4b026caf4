// What is saved of the page: the curves over the frames as CSV, the maps as PNG.  What a page adds: table.

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** A cell of CSV; it is empty where there is no value. */
function csv(cell) {
  const text = String(cell ?? "");
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** A value of a curve with the digits that single precision has. */
const single = (value) => (Number.isFinite(value) ? Number(value.toPrecision(8)) : null);

/** The first cells of a row: the frame's number and, where it is known, its time; and their names. */
const cellsOf = (frame) => [numberOf(frame), ...(times ? [times[frame]] : [])];
const namesOfCells = () => ["frame", ...(times ? ["time_s"] : [])];

function saveCurves() {
  const lines = table().map((row) => row.map(csv).join(","));
  save("curves.csv", new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
}

/** Pixels around the maps; the frame's number is above them. */
const MARGINS = { side: 8, top: 30 };

/** The maps as they are on the page, with their names and the legend, under the number of the frame. */
function pictureOfMaps() {
  const [whole, dots] = [document.querySelector(".maps"), window.devicePixelRatio || 1];
  const base = whole.getBoundingClientRect();
  const [width, height] = [base.width + 2 * MARGINS.side, $("legend").getBoundingClientRect().bottom - base.top + MARGINS.top + MARGINS.side];
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width * dots, height * dots];
  const pen = canvas.getContext("2d");
  pen.scale(dots, dots);
  pen.fillStyle = INK.paper;
  pen.fillRect(0, 0, width, height);
  pen.fillStyle = INK.text;
  pen.font = "13px system-ui, sans-serif";
  pen.textBaseline = "middle";
  pen.fillText($("where").textContent, MARGINS.side, MARGINS.top / 2);
  const placed = (place, draw) => {
    const box = place.getBoundingClientRect();
    draw(box.left - base.left + MARGINS.side, box.top - base.top + MARGINS.top, box.width, box.height);
  };
  for (const map of whole.querySelectorAll("canvas")) placed(map, (...box) => pen.drawImage(map, ...box));
  for (const text of whole.querySelectorAll("figcaption, #legend .ticks > span, #key li")) {
    placed(text, (x, y, width, tall) => pen.fillText(text.innerText, x, y + tall / 2, width));
  }
  placed($("bar"), (x, y, width, tall) => {
    for (let at = 0; at < width; at += 1) {
      pen.fillStyle = colourOf((2 * at) / width - 1);
      pen.fillRect(x + at, y, 1.5, tall);
    }
  });
  return canvas;
}

function listenToSaving() {
  $("save-curves").addEventListener("click", saveCurves);
  $("save-map").addEventListener("click", () => pictureOfMaps().toBlob((blob) => save(`frame-${numberOf(state.frame)}.png`, blob)));
}
