/** Texts for people about events, by templates that come with `_world/view`. */

import { attempt, goalWords } from './phrases.js';

const PART = /\[([^\]]*)\]|\{[^}]*\}|[^[{]+/g;
const FIELD = /\{(\w+)(?:([:=])([^}]*))?\}/g;

/** Formats by name: each returns a field's text, or "" for a value that counts as missing. */
const FORMATS = {
  '': plain,
  and: (names) => [names.slice(0, -1).map(plain).join(', '), ...names.slice(-1).map(plain)].filter(Boolean).join(' and '),
  point: ([x, y]) => `(${plain(x)}, ${plain(y)})`,
  end: (points) => (points.length ? FORMATS.point(points.at(-1)) : ''),
  percent: (share) => `${Math.round(share * 100)}%`,
  lane: (ends) => ends.join('-'),
  error: ({ error_msg: text, error_code: code, result }) => String(text || code?.message || result?.error_message || ''),
};

/**
 * Fill in a template, which is written as described in hmrsim/events/_text.py.
 * @param {Record<string, (value: any) => string>} [formats] Further formats, or replacements.
 */
export function render(template, event, formats = {}) {
  const known = { ...FORMATS, ...formats };
  return template.replaceAll(PART, (text, optional) => {
    const alternatives = optional === undefined ? [text] : optional.split('|');
    return alternatives.map((each) => filled(each, event, known)).find((said) => said !== null) ?? '';
  });
}

/** Fill in an alternative; null if one of its fields is missing. */
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

const SUBJECTS = ['robot', 'door', 'lift', 'dock', 'entity', 'participant'];

function subjectOf(event, { subject: names = SUBJECTS }) {
  const value = names.map((name) => event[name]).find((each) => (each ?? null) !== null) ?? '';
  if (Array.isArray(value)) return FORMATS.lane(value);
  return value === '_world' ? '' : String(value);
}

/**
 * Return the description of an event for people; its text is without its subject: "waits for eve".
 * @param {import('./model.js').Model} model For templates, and names of points.
 * @returns {{subject: string, text: string, severity: string, group: string}} `subject` is "" for the world; `severity` is
 *   debug, info, warning or error.
 */
export function describe(event, { texts, world }) {
  const known = texts[event.kind] ?? { text: '', severity: 'info' };
  const formats = {
    point: (at) => world.nameAt(at) || FORMATS.point(at),
    goal: (goal) => goalWords(event.action, goal, world),
  };
  return {
    subject: attempt(() => subjectOf(event, known)),
    text: attempt(() => render(known.text, event, formats)) || String(event.kind).replaceAll('_', ' '),
    severity: attempt(() => render(known.severity, event)) || 'info',
    group: known.group ?? '',
  };
}
