// Positions of vertices in folded states, and between two of them.

/** For each state, the positions of all vertices, three numbers each. */
export function sheetStates(sheet, count) {
  const all = sheet.positions;
  const size = all.length / count;
  return Array.from({ length: count }, (_, k) => all.subarray(k * size, (k + 1) * size));
}

/** Write into `out` the positions at a place on the slider, 0 for the first state. */
export function between(states, place, out) {
  const first = Math.min(Math.floor(place), states.length - 1);
  const second = Math.min(first + 1, states.length - 1);
  const [a, b, share] = [states[first], states[second], place - first];
  for (let i = 0; i < out.length; i++) out[i] = a[i] + share * (b[i] - a[i]);
}

/** Middle of the box around all states. */
export function boxMiddle(states) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const coords of states) {
    for (let i = 0; i < coords.length; i++) {
      low[i % 3] = Math.min(low[i % 3], coords[i]);
      high[i % 3] = Math.max(high[i % 3], coords[i]);
    }
  }
  return low.map((value, k) => (value + high[k]) / 2);
}
