// The page of a sweep: a table that sorts, parallel coordinates that filter, both marking the same row.
const { columns, rows, pictures } = JSON.parse(document.getElementById("data").textContent);
const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 1000, TOP = 52, BOTTOM = 330, SIDE = 60, MOST_ROWS = 500;
const axes = columns.flatMap((column, place) => column.axis ? [{ ...column, place }] : []);
const ranges = new Map(); // by the number of an axis: lowest and highest share of its height
let order = rows.map((_, number) => number);
let sorted = { place: 0, down: false };

const made = (name, attributes = {}, text) => {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
};
const shown = (value) => value === null ? "–" : typeof value === "number" && !Number.isInteger(value) ? Number(value.toPrecision(5)).toString() : String(value);

// Where a value is on its axis, from 0 below to 1 above; texts are at equal distances.
for (const axis of axes) {
  const values = rows.map((row) => row[axis.place]).filter((value) => value !== null);
  if (axis.numbers) {
    const low = Math.min(...values), high = Math.max(...values);
    axis.ends = [shown(low), shown(high)];
    axis.share = (value) => high > low ? (value - low) / (high - low) : 0.5;
  } else {
    const kinds = [...new Set(values)].sort();
    axis.kinds = kinds;
    axis.share = (value) => kinds.length > 1 ? kinds.indexOf(value) / (kinds.length - 1) : 0.5;
  }
}
const xOf = (number) => axes.length > 1 ? SIDE + (WIDTH - 2 * SIDE) * number / (axes.length - 1) : WIDTH / 2;
const yOf = (share) => BOTTOM - share * (BOTTOM - TOP);
const within = (row) => [...ranges].every(([number, [low, high]]) => {
  const value = row[axes[number].place];
  if (value === null) return false;
  const share = axes[number].share(value);
  return share >= low - 1e-9 && share <= high + 1e-9;
});

const svg = document.getElementById("axes");
const lines = rows.map((row, number) => {
  const points = axes.flatMap((axis, place) => row[axis.place] === null ? [] : [`${xOf(place)},${yOf(axis.share(row[axis.place]))}`]);
  const line = made("polyline", { points: points.join(" ") });
  line.addEventListener("pointerenter", () => mark(number));
  return line;
});
svg.append(...lines);
axes.forEach((axis, number) => {
  const x = xOf(number);
  svg.append(made("line", { x1: x, x2: x, y1: TOP, y2: BOTTOM }));
  svg.append(made("text", { x, y: number % 2 ? 12 : 26, "text-anchor": "middle" }, axis.axis));
  const ends = axis.numbers ? axis.ends.map((text, place) => [text, place]) : axis.kinds.map((kind) => [shown(kind), axis.share(kind)]);
  for (const [text, share] of ends) svg.append(made("text", { x: x + 6, y: yOf(share) + (share < 0.5 ? 14 : -3), "text-anchor": "start" }, text));
  const box = made("rect", { x: x - 9, width: 18, y: TOP, height: 0, visibility: "hidden" });
  const grip = made("rect", { class: "grip", x: x - 14, width: 28, y: TOP - 6, height: BOTTOM - TOP + 12 });
  svg.append(box, grip);
  let from = null;
  const shareAt = (event) => {
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return Math.min(1, Math.max(0, (BOTTOM - place.y) / (BOTTOM - TOP)));
  };
  const put = (low, high) => {
    ranges.set(number, [low, high]);
    box.setAttribute("y", yOf(high));
    box.setAttribute("height", yOf(low) - yOf(high));
    box.setAttribute("visibility", "visible");
    update();
  };
  grip.addEventListener("pointerdown", (event) => { from = shareAt(event); grip.setPointerCapture(event.pointerId); });
  grip.addEventListener("pointermove", (event) => { if (from !== null) put(Math.min(from, shareAt(event)), Math.max(from, shareAt(event))); });
  grip.addEventListener("pointerup", (event) => {
    if (from !== null && Math.abs(shareAt(event) - from) < 0.01) { ranges.delete(number); box.setAttribute("visibility", "hidden"); update(); }
    from = null;
  });
  axis.clear = () => { ranges.delete(number); box.setAttribute("visibility", "hidden"); };
});

const body = document.querySelector("table.rows tbody");
const heads = [...document.querySelectorAll("table.rows th button")];
heads.forEach((button, place) => button.addEventListener("click", () => {
  sorted = { place, down: sorted.place === place && !sorted.down };
  update();
}));
document.getElementById("clear").addEventListener("click", () => { axes.forEach((axis) => axis.clear()); update(); });

let marked = null;
function mark(number) {
  for (const each of [marked, number]) {
    if (each === null) continue;
    lines[each].classList.toggle("marked", each === number);
    document.getElementById(`row${each}`)?.classList.toggle("marked", each === number);
  }
  if (number !== null) lines[number].parentNode.insertBefore(lines[number], svg.querySelector("line"));
  marked = number;
}

function update() {
  const { place, down } = sorted;
  const kept = rows.map((_, number) => number).filter((number) => within(rows[number]));
  const inside = new Set(kept);
  lines.forEach((line, number) => line.classList.toggle("out", !inside.has(number)));
  order = kept.sort((first, second) => {
    const [a, b] = [rows[first][place], rows[second][place]];
    if (a === null || b === null) return (a === null) - (b === null) || first - second; // unknown last
    return (a < b ? -1 : a > b ? 1 : 0) * (down ? -1 : 1) || first - second;
  });
  heads.forEach((button, number) => button.parentNode.setAttribute("aria-sort", number !== place ? "none" : down ? "descending" : "ascending"));
  body.replaceChildren(...order.slice(0, MOST_ROWS).map((number) => {
    const line = document.createElement("tr");
    line.id = `row${number}`;
    columns.forEach((column, at) => {
      const cell = line.insertCell();
      cell.textContent = shown(rows[number][at]);
      cell.title = cell.textContent;
      if (!column.numbers) cell.className = "text";
    });
    if (pictures.some(Boolean)) {
      const cell = line.insertCell(1);
      if (pictures[number]) {
        const picture = document.createElement("img");
        picture.src = pictures[number];
        picture.alt = `folded form of variation ${rows[number][0]}`;
        cell.append(picture);
      }
    }
    line.addEventListener("pointerenter", () => mark(number));
    return line;
  }));
  const more = order.length > MOST_ROWS ? `, the first ${MOST_ROWS} shown` : "";
  document.getElementById("count").textContent = `${order.length} of ${rows.length} variations${more}`;
}
update();
