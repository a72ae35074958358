// Arrays of numbers, compressed and in base64, as `packed` in page_data.py writes them.

const KINDS = { f32: Float32Array, u16: Uint16Array, u32: Uint32Array };

/** The value with typed arrays in place of all packed ones; bytes are little-endian, as browsers are. */
export async function unpacked(value) {
  if (value === null || typeof value !== "object") return value;
  if (Array.isArray(value)) return Promise.all(value.map(unpacked));
  if ("zlib" in value) return numbers(value);
  const entries = Object.entries(value).map(async ([key, each]) => [key, await unpacked(each)]);
  return Object.fromEntries(await Promise.all(entries));
}

async function numbers({ kind, zlib }) {
  const bytes = Uint8Array.from(atob(zlib), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[kind](await new Response(stream).arrayBuffer());
}
