// Poses of rigid bodies in all states: what moves with a face is moved by one matrix.

const SIZE = 12; // of a matrix: three rows of turn and shift

export class Poses {
  /** bodies : as of result pages; count : of states in their poses, of which the first `used` are shown. */
  constructor({ positions, verticesFace, poses }, count, used) {
    this.flat = positions;
    this.face = verticesFace;
    this.faces = poses.length / (7 * count);
    this.count = used;
    this.matrices = matricesOf(poses.subarray(0, 7 * this.faces * used));
    this.mixed = new Float32Array(SIZE * this.faces);
  }

  /** Write into `out` where vertices are at a place among the states, 0 for the first. */
  fold(place, out) {
    const first = Math.min(Math.floor(place), this.count - 1);
    const second = Math.min(first + 1, this.count - 1);
    const { flat, face, mixed } = this;
    mix(this.#state(first), this.#state(second), place - first, mixed);
    for (let v = 0; v < face.length; v++) move(mixed, SIZE * face[v], flat, 3 * v, out);
  }

  /** Of each state, corners of the boxes around what moves with each face: all is within them. */
  boxes() {
    const [corners, owners] = boxCorners(this.flat, this.face, this.faces);
    return Array.from({ length: this.count }, (_, k) => {
      const out = new Float32Array(corners.length);
      owners.forEach((owner, v) => move(this.#state(k), SIZE * owner, corners, 3 * v, out));
      return out;
    });
  }

  #state(k) {
    const size = SIZE * this.faces;
    return this.matrices.subarray(k * size, (k + 1) * size);
  }
}

function mix(a, b, share, out) {
  for (let i = 0; i < out.length; i++) out[i] = a[i] + share * (b[i] - a[i]);
}

function move(matrices, m, from, v, out) {
  const [x, y, z] = [from[v], from[v + 1], from[v + 2]];
  out[v] = matrices[m] * x + matrices[m + 1] * y + matrices[m + 2] * z + matrices[m + 3];
  out[v + 1] = matrices[m + 4] * x + matrices[m + 5] * y + matrices[m + 6] * z + matrices[m + 7];
  out[v + 2] = matrices[m + 8] * x + matrices[m + 9] * y + matrices[m + 10] * z + matrices[m + 11];
}

/** Of quaternions x, y, z, w with shifts, seven numbers each. */
function matricesOf(poses) {
  const out = new Float32Array((poses.length / 7) * SIZE);
  for (let p = 0, m = 0; p < poses.length; p += 7, m += SIZE) {
    const [x, y, z, w, ...shift] = poses.subarray(p, p + 7);
    const turn = [
      [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ];
    turn.forEach((row, k) => out.set([...row, shift[k]], m + 4 * k));
  }
  return out;
}

/** Corners of boxes, and the face that each moves with. */
function boxCorners(flat, face, faces) {
  const low = new Float32Array(3 * faces).fill(Infinity);
  const high = new Float32Array(3 * faces).fill(-Infinity);
  for (let i = 0; i < flat.length; i++) {
    const at = 3 * face[Math.floor(i / 3)] + (i % 3);
    low[at] = Math.min(low[at], flat[i]);
    high[at] = Math.max(high[at], flat[i]);
  }
  const [corners, owners] = [[], []];
  for (let owner = 0; owner < faces; owner++) {
    if (low[3 * owner] === Infinity) continue;
    for (let corner = 0; corner < 8; corner++) {
      for (let k = 0; k < 3; k++) corners.push(((corner >> k) & 1 ? high : low)[3 * owner + k]);
      owners.push(owner);
    }
  }
  return [Float32Array.from(corners), owners];
}
