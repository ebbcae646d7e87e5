// Columns of numbers out of the text that pack.rs makes: base64, zlib, zigzag LEB128 differences (of order 1 or 2), quanta.

/** All columns by name, each a Float64Array with one value per row. */
async function unpack({ rows, columns, packed }) {
  const bytes = await inflate(Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0)));
  let at = 0;
  const next = () => {
    let code = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = bytes[at++];
      code += (byte & 127) * factor;
      if (byte < 128) return code % 2 === 0 ? code / 2 : -(code + 1) / 2;
    }
  };
  const unpacked = new Map();
  for (const { name, same, low, quantum, order } of columns) {
    if (same !== undefined) {
      unpacked.set(name, unpacked.get(same).slice());
      continue;
    }
    const values = new Float64Array(rows);
    let number = 0;
    let slope = 0;
    for (let row = 0; row < rows; row++) {
      slope = order === 2 ? slope + next() : next();
      number += slope;
      values[row] = number < 0 ? NaN : low + number * quantum;
    }
    unpacked.set(name, values);
  }
  return unpacked;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
