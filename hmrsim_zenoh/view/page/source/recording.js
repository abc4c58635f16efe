/** Fetching of recordings, which the server sends as one line of JSON for each sample. */

/**
 * @typedef {[number, string, any]} Sample Nanoseconds of simulated time, key below the prefix, payload.
 * @typedef {{kind: 'live'}|{kind: 'recording', name: string, begin: number, end: number, truncated: boolean}} Source
 *   `begin` and `end` are nanoseconds.
 * @typedef {object} Recording
 * @property {string} name The file's name.
 * @property {Sample[]} samples In order of time.
 * @property {boolean} truncated Whether the end is missing.
 */

/** A recording can't be fetched. */
class RecordingError extends Error {}

/** Return the kind of source that the server shows. @param {string} [address] Of `/source`, with any token. */
export async function fetchSource(address = '/source') {
  return (await answerOf(address)).json();
}

/**
 * Fetch a recording; if the transfer breaks off, the recording is truncated.
 * @param {Source} source The result of `fetchSource`.
 * @param {string} [options.address] Of `/recording`, with any token.
 * @param {(progress: {share: number, samples: number}) => void} [options.onProgress] `share` is from 0 to 1.
 */
export async function fetchRecording(source, { address = '/recording', onProgress, signal } = {}) {
  const response = await answerOf(address, signal);
  const lines = new Lines();
  let cut = false;
  try {
    for await (const chunk of chunksOf(response.body)) {
      lines.add(chunk);
      onProgress?.({ share: shareOf(source, lines.samples), samples: lines.samples.length });
    }
  } catch (error) {
    if (signal?.aborted) throw error;
    cut = true;
  }
  const complete = lines.end();
  const { samples } = lines;
  if (samples.length === 0) throw new RecordingError('the recording is empty');
  onProgress?.({ share: 1, samples: samples.length });
  return { name: source?.name ?? '', samples, truncated: cut || !complete || source?.truncated === true };
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
      if (Array.isArray(sample) && Number.isFinite(sample[0]) && typeof sample[1] === 'string') {
        this.samples.push(sample);
        return;
      }
    } catch {
      // Handled below.
    }
    this._whole = false;
  }
}

async function answerOf(address, signal) {
  let response;
  try {
    response = await fetch(address, { signal });
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new RecordingError('the server does not answer');
  }
  if (!response.ok) throw new RecordingError(`the server answers ${response.status} ${response.statusText}`.trim());
  return response;
}

/** Yield the chunks of a stream; few browsers can iterate over streams. */
async function* chunksOf(body) {
  const reader = body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    yield value;
  }
}

function shareOf(source, samples) {
  const length = source?.end - source?.begin;
  const last = samples.length ? samples[samples.length - 1][0] : source?.begin;
  return length > 0 ? Math.min(1, Math.max(0, (last - source.begin) / length)) : 0;
}
