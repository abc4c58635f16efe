/** Fetching of recordings, which the server sends as one line of JSON for each sample. */

/** Return what a server answers. @throws {Error} It does not answer, or with an error. */
async function answerOf(address) {
  const response = await fetch(address).catch(() => {
    throw new Error('the server does not answer');
  });
  if (!response.ok) throw new Error(`the server answers ${response.status} ${response.statusText}`.trim());
  return response;
}

/**
 * Return the kind of source that the server shows: `live` or `recording`, which has a name, begins and ends at nanoseconds,
 * and may be truncated.
 * @param {string} address Of `/source`, with any token.
 */
export async function fetchSource(address) { return (await answerOf(address)).json(); }

/**
 * Fetch a recording; if the transfer breaks off, the recording is truncated.
 * @param {object} source The result of `fetchSource`.
 * @param {string} address Of `/recording`, with any token.
 * @param {(share: number) => void} onProgress Called with the loaded share, from 0 to 1.
 * @returns {Promise<{name: string, samples: [number, string, any][], truncated: boolean}>} A sample has nanoseconds of
 *   simulated time, the key below the prefix, and the payload.
 */
export async function fetchRecording({ name, begin, end, truncated }, address, onProgress) {
  const reader = (await answerOf(address)).body.getReader();
  const lines = new Lines();
  let whole = true;
  try {
    for (let read = await reader.read(); !read.done; read = await reader.read()) {
      lines.add(read.value);
      const last = lines.samples.at(-1)?.[0] ?? begin;
      onProgress(end > begin ? Math.min(1, Math.max(0, (last - begin) / (end - begin))) : 0);
    }
  } catch {
    whole = false;
  }
  whole = lines.end() && whole;
  if (lines.samples.length === 0) throw new Error('the recording is empty');
  return { name, samples: lines.samples, truncated: truncated || !whole };
}

/** Splits text chunks into lines of samples; other lines are ignored. */
export class Lines {
  constructor() {
    this.samples = [];
    this._rest = '';
    this._decoder = new TextDecoder();
    this._whole = true;
  }

  add(bytes) {
    const lines = (this._rest + this._decoder.decode(bytes, { stream: true })).split('\n');
    this._rest = lines.pop();
    for (const line of lines) this._take(line);
  }

  /** Process the rest. @returns {boolean} Whether all lines were samples. */
  end() {
    this._take(this._rest + this._decoder.decode());
    this._rest = '';
    return this._whole;
  }

  _take(line) {
    if (line.trim() === '') return;
    try {
      const sample = JSON.parse(line);
      if (Array.isArray(sample) && Number.isFinite(sample[0]) && typeof sample[1] === 'string') this.samples.push(sample);
      else this._whole = false;
    } catch {
      this._whole = false;
    }
  }
}
