// From the text in the page to columns of whole numbers: the mirror of columns.py.

function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const plain = atob(text);
  const bytes = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) bytes[i] = plain.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// `count` numbers of either sign from seven bits a byte, low bits first; they begin at byte `at`.
function numbers(bytes, at, count) {
  const values = new Int32Array(count);
  for (let i = 0; i < count; i++) {
    let byte = bytes[at++];
    let value = byte & 127;
    let weight = 128;
    while (byte > 127) {
      byte = bytes[at++];
      value += (byte & 127) * weight;
      weight *= 128;
    }
    values[i] = value % 2 ? -(value + 1) / 2 : value / 2;
  }
  return values;
}

async function columnsOf(index, text) {
  const bytes = await inflate(bytesOf(text));
  const columns = {};
  let at = 0;
  for (const [name, count, size] of index) {
    columns[name] = numbers(bytes, at, count);
    at += size;
  }
  return columns;
}

// Running totals: the inverse of differences.
function totals(steps) {
  const sums = new Float64Array(steps.length);
  let sum = 0;
  for (let i = 0; i < steps.length; i++) sums[i] = sum += steps[i];
  return sums;
}

// Where each group begins, and after the last one where it ends.
function starts(counts) {
  const first = new Int32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) first[i + 1] = first[i] + counts[i];
  return first;
}

// The last of `times[low..high-1]` that is at most `time`; low - 1 if there is none.
function lastBefore(times, time, low = 0, high = times.length) {
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// The row that holds for a robot at a time, of rows in order of time; it is mostly the one it was or the next.
function rowAt(times, first, cursor, robot, time) {
  const low = first[robot], high = first[robot + 1];
  let i = cursor[robot];
  if (times[i] <= time && i + 1 < high && times[i + 1] <= time) i++;
  if (times[i] > time || (i + 1 < high && times[i + 1] <= time)) i = Math.max(lastBefore(times, time, low, high), low);
  return (cursor[robot] = i);
}
