// Decodes the arrays of the page.

const TYPES = { float32: Float32Array, float64: Float64Array, int16: Int16Array, uint8: Uint8Array };

function unpack({ type, data }) {
  const text = atob(data);
  const bytes = new Uint8Array(text.length);
  for (let at = 0; at < text.length; at += 1) bytes[at] = text.charCodeAt(at);
  return new TYPES[type](bytes.buffer);
}

const unpackAll = (packed) => Object.fromEntries(Object.entries(packed).map(([name, value]) => [name, unpack(value)]));
