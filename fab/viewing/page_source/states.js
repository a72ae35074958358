// Positions of vertices in folded states, and between two of them.

/** For each state, the positions of all vertices, three numbers each. */
export function sheetStates(sheet, count) {
  const all = sheet.positions;
  const size = all.length / count;
  return Array.from({ length: count }, (_, k) => all.subarray(k * size, (k + 1) * size));
}

/** The same of rigid bodies, whose vertices move with a face: quaternion x, y, z, w and shift. */
export function bodyStates(bodies, count) {
  const { positions: flat, verticesFace: faces, poses } = bodies;
  const size = poses.length / count;
  return Array.from({ length: count }, (_, k) =>
    posed(flat, faces, poses.subarray(k * size, (k + 1) * size)),
  );
}

function posed(flat, faces, poses) {
  const out = new Float32Array(flat.length);
  for (let v = 0; v < faces.length; v++) {
    const p = 7 * faces[v];
    const [qx, qy, qz, qw] = [poses[p], poses[p + 1], poses[p + 2], poses[p + 3]];
    const [x, y, z] = [flat[3 * v], flat[3 * v + 1], flat[3 * v + 2]];
    const tx = 2 * (qy * z - qz * y);
    const ty = 2 * (qz * x - qx * z);
    const tz = 2 * (qx * y - qy * x);
    out[3 * v] = x + qw * tx + qy * tz - qz * ty + poses[p + 4];
    out[3 * v + 1] = y + qw * ty + qz * tx - qx * tz + poses[p + 5];
    out[3 * v + 2] = z + qw * tz + qx * ty - qy * tx + poses[p + 6];
  }
  return out;
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
