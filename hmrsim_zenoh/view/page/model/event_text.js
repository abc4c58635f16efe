/**
 * Texts of events from the templates in `_world/view`; as hmrsim/events/_text.py, which says how they are written. An
 * entry is {severity, subject, text, group}: `severity` and `text` are templates, `subject` names fields.
 */

const PART = /\[([^\]]*)\]|\{[^}]*\}|[^[{]+/g;
const FIELD = /\{(\w+)(?:([:=])([^}]*))?\}/g;

/** By name; each takes a field's value and returns text, "" where it is as if it were not given. */
export const FORMATS = {
  '': plain,
  and: (names) => [names.slice(0, -1).map(plain).join(', '), ...names.slice(-1).map(plain)].filter(Boolean).join(' and '),
  point: ([x, y]) => `(${plain(x)}, ${plain(y)})`,
  end: (points) => (points.length ? FORMATS.point(points[points.length - 1]) : ''),
  percent: (share) => `${Math.round(share * 100)}%`,
  lane: (ends) => ends.join('-'),
  error: ({ error_msg: text, error_code: code, result }) => String(text || code?.message || result?.error_message || ''),
};

/**
 * Return a template filled in.
 * @param {string} template
 * @param {Record<string, any>} event
 * @param {Record<string, (value: any) => string>} [formats] Further formats, or others for the same names.
 * @returns {string}
 */
export function render(template, event, formats = {}) {
  const known = { ...FORMATS, ...formats };
  return template.replaceAll(PART, (text, optional) => {
    const alternatives = optional === undefined ? [text] : optional.split('|');
    return alternatives.map((each) => filled(each, event, known)).find((said) => said !== null) ?? '';
  });
}

/** Return an alternative filled in; null if one of its fields is not given. */
function filled(alternative, event, formats) {
  let given = true;
  const text = alternative.replaceAll(FIELD, (_, name, sign, more) => {
    const value = event[name] ?? null;
    if (sign === '=') {
      given &&= value !== null && plain(value) === more;
      return '';
    }
    const said = value === null ? '' : formats[more ?? '']?.(value) ?? '';
    given &&= said !== '';
    return said;
  });
  return given ? text : null;
}

function plain(value) {
  if (Array.isArray(value)) return value.map(plain).join(', ');
  return typeof value === 'number' ? String(+value.toFixed(2)) : String(value);
}

/**
 * Return what an event says of its subject: "waits for eve".
 * @param {Record<string, any>} event
 * @param {Record<string, {text: string}>} texts The `events` of `_world/view`.
 * @param {Record<string, (value: any) => string>} [formats] Such as a `point` that knows names.
 * @returns {string}
 */
export function textOf(event, texts, formats) {
  const known = texts[event.kind];
  return (known && render(known.text, event, formats)) || String(event.kind ?? '').replaceAll('_', ' ');
}

/** Return how much an event matters: debug, info, warning or error. */
export function severityOf(event, texts) {
  const known = texts[event.kind];
  return known ? render(known.severity, event) : 'info';
}

/** Return the name of what an event is about; "" for the whole world. */
export function subjectOf(event, texts) {
  const names = texts[event.kind]?.subject ?? ['robot', 'door', 'lift', 'dock', 'entity', 'participant'];
  const value = names.map((name) => event[name]).find((each) => each !== undefined && each !== null) ?? '';
  if (Array.isArray(value)) return FORMATS.lane(value);
  return value === '_world' ? '' : String(value);
}
