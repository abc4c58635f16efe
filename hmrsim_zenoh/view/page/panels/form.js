// A dialog made from JSON Schemas: choose an action or a fault, fill in its fields, see errors at the fields.

import { poseStamped } from '../commands.js';
import { button, el, mark, say } from './dom.js';

const NANOSECONDS = 1e9;
const PLACES = 'form-places';

/**
 * Return a field of a form: `read` returns its value, or undefined if it is empty, and throws if it is invalid; `complain`
 * shows an error, and "" clears it; `wrong` returns whether there is one.
 */
function makeField({ schema, path, required }, app, asked) {
  const id = `field-${path.join('-')}`;
  const kind = KINDS.find(({ takes }) => takes(schema));
  const given = asked.values?.[path.join('.')] ?? schema.default;
  const input = kind.input(schema, app, asked.robot, given);
  for (const [name, value] of [['id', id], ['aria-describedby', `${id}-error`]]) input.setAttribute(name, value);
  if (required) input.setAttribute('aria-required', 'true');
  input.classList.add('field');
  const error = el('small', { class: 'field-error', id: `${id}-error`, role: 'alert', hidden: true });
  const unit = schema.unit?.replace(/^m\b/, app.model.world.units);
  const label = `${schema.title}${unit ? `, ${unit}` : ''}${required ? '' : schema.default === undefined ? ' (optional)' : ''}`;
  const complain = (text) => {
    say(error, text);
    error.hidden = text === '';
    mark(input, 'aria-invalid', text !== '');
  };
  input.addEventListener('input', () => complain(''));
  const text = () => (input.type === 'checkbox' ? input.checked : input.value.trim());
  const read = () => {
    if (text() === '' && !input.validity?.badInput) {
      if (required) throw new Error(kind.expected ?? 'Fill this in.');
      return undefined;
    }
    return kind.value(text(), schema, app, input);
  };
  const look = { class: input.type === 'checkbox' ? 'check' : null, title: schema.description };
  const element = el('label', look, el('span', { text: label }), input, error);
  return { path, element, input, advanced: schema.advanced === true, read, complain, wrong: () => !error.hidden };
}

const POINT = 'Name a place, or give x, y.';

/** The kinds of fields; the first one that takes a schema creates the field. */
const KINDS = [
  {
    takes: ({ format }) => format === 'pose',
    expected: POINT,
    input: (_schema, app, _robot, given) => el('input', {
      type: 'text', list: places(app), placeholder: 'Place, or x, y or x, y, heading in °', autocomplete: 'off', value: given,
    }),
    value: (text, _schema, app) => poseOf(text, app),
  },
  {
    takes: ({ type, items }) => type === 'array' && items?.format === 'pose',
    expected: 'Name at least one place, or give x, y.',
    input: (_schema, _app, _robot, given) => el('textarea', { rows: 4, placeholder: 'A place, or x, y, on each line', text: given }),
    value: (text, _schema, app) => text.split(/[\n;]/).filter((line) => line.trim()).map((line) => poseOf(line, app)),
  },
  {
    takes: ({ choices, enum: values }) => Boolean(choices ?? values),
    expected: 'Choose one.',
    input(schema, app, robot, given) {
      const names = schema.enum ?? CHOICES[schema.choices]?.(app.model, robot) ?? [];
      return el('select', {}, ...names.map((name) => el('option', { value: name, text: name, selected: name === given })));
    },
    value: (text) => text,
  },
  {
    takes: ({ type }) => type === 'boolean',
    input: (_schema, _app, _robot, given) => el('input', { type: 'checkbox', checked: given === true }),
    value: (checked) => checked,
  },
  {
    takes: ({ type, format }) => format === 'duration' || type === 'number' || type === 'integer',
    expected: 'Give a number.',
    input: (_schema, _app, _robot, given) => el('input', { type: 'number', step: 'any', value: given }),
    value(text, schema) {
      const number = numberOf(text, schema);
      if (schema.format !== 'duration') return number;
      return { sec: Math.floor(number), nanosec: Math.round((number % 1) * NANOSECONDS) };
    },
  },
  {
    takes: () => true,
    input: (schema, _app, _robot, given) => el('input', { type: 'text', maxlength: schema.maxLength, value: given }),
    value: (text) => text,
  },
];

/** The choices from the world, by the schema's word. */
const CHOICES = {
  items: (model) => [...model.items.values()].filter(({ carrier }) => !carrier).map(({ name }) => name),
  held: (model, robot) => [...(model.robots.get(robot)?.holds ?? [])],
  docks: (model) => [...model.docks.keys()],
};

function numberOf(text, { type, minimum, maximum, exclusiveMinimum: above, exclusiveMaximum: below }) {
  const number = Number(text);
  const wrong = [
    [text === '' || !Number.isFinite(number), 'Give a number.'],
    [type === 'integer' && !Number.isInteger(number), 'Give a whole number.'],
    [number < minimum, `Give at least ${minimum}.`], [number > maximum, `Give at most ${maximum}.`],
    [number <= above, `Give more than ${above}.`], [number >= below, `Give less than ${below}.`],
  ].find(([applies]) => applies);
  if (wrong) throw new Error(wrong[1]);
  return number;
}

/** Return the PoseStamped of a place's name, or of x, y and a heading in degrees. */
function poseOf(text, app) {
  const numbers = app.model.world.point(text.trim()) ?? text.trim().split(/[\s,]+/).map(Number);
  if (numbers.length < 2 || numbers.length > 3 || !numbers.every(Number.isFinite)) throw new Error(POINT);
  const [x, y, degrees = 0] = numbers;
  return poseStamped(x, y, (degrees * Math.PI) / 180);
}

/** Return the id of a list of the names of places, docks and waypoints. */
function places({ model: { world } }) {
  document.getElementById(PLACES)?.remove();
  const names = new Set([...world.places.keys(), ...world.docks.keys(), ...world.waypoints.keys()]);
  document.body.append(el('datalist', { id: PLACES }, ...Array.from(names, (value) => el('option', { value }))));
  return PLACES;
}

export class FormDialog {
  constructor(app) {
    this.app = app;
    this.title = el('h2', { id: 'form-title' });
    this.label = el('span');
    this.choice = el('select', { class: 'field', onchange: () => this.#choose() });
    this.about = el('p', { class: 'note' });
    this.error = el('p', { class: 'form-error', role: 'alert', hidden: true });
    this.fields = el('div', { class: 'fields' });
    this.more = el('div', { class: 'fields' });
    this.moreBox = el('details', {}, el('summary', { text: 'More options' }), this.more);
    this.submit = el('button', { type: 'submit', class: 'button primary' });
    const form = el('form', { method: 'dialog', novalidate: true, onsubmit: (event) => this.#submit(event), oninput: () => this.#complain('') }, this.title,
      el('label', {}, this.label, this.choice), this.about, this.fields, this.moreBox, this.error,
      el('div', { class: 'actions' },
        el('button', { type: 'button', class: 'button', text: 'Cancel', onclick: () => this.element.close() }), this.submit));
    this.element = el('dialog', { class: 'dialog', 'aria-labelledby': 'form-title' },
      button('close', 'Close', () => this.element.close(), { class: 'quiet corner' }), form);
  }

  /**
   * Open the dialog.
   * @param {object} asked Its title, the label of the choice, the verb of the button; the forms: JSON Schemas by name, as
   *   `_world/view` has them; the form that is chosen first, and initial values by dotted path. `send` gets the name of a form
   *   and values, and throws if they are refused; `details` has field and message, as in the simulator's answers.
   */
  open(asked) {
    const { title, label, verb, forms, chosen } = asked;
    this.asked = asked;
    this.submit.disabled = false;
    for (const [element, text] of [[this.title, title], [this.label, label], [this.submit, verb]]) say(element, text);
    this.choice.replaceChildren(...Object.entries(forms).map(([name, form]) => el('option', { value: name, text: form.title })));
    if (forms[chosen]) this.choice.value = chosen;
    this.#choose();
    this.element.showModal();
    (this.controls[0]?.input ?? this.submit).focus();
  }

  #choose() {
    const schema = this.asked.forms[this.choice.value];
    say(this.about, schema.description ?? '');
    this.controls = [...fieldsOf(schema)].map((field) => makeField(field, this.app, this.asked));
    for (const box of [this.fields, this.more]) {
      box.replaceChildren(...this.controls.filter(({ advanced }) => advanced === (box === this.more)).map(({ element }) => element));
    }
    this.moreBox.hidden = this.more.children.length === 0;
    this.moreBox.open = false;
    this.#complain('');
  }

  async #submit(event) {
    event.preventDefault();
    this.#complain('');
    const values = {};
    for (const control of this.controls) {
      try {
        const value = control.read();
        if (value !== undefined) put(values, control.path, value);
        control.complain('');
      } catch (error) {
        control.complain(error.message);
      }
    }
    if (this.#showFirst()) return;
    this.submit.disabled = true;
    const { asked } = this;
    const shown = () => this.element.open && this.asked === asked;
    try {
      await asked.send(this.choice.value, values);
      if (shown()) this.element.close();
    } catch (error) {
      if (shown()) {
        this.#place(error);
        this.#showFirst();
      } else {
        this.app.toasts.show('error', `${asked.title}: ${error.message}`);
      }
    } finally {
      if (this.asked === asked) this.submit.disabled = false;
    }
  }

  /** Show errors at their fields, and others below the form. */
  #place(error) {
    const others = [];
    for (const { field, message } of error.details ?? []) {
      const control = this.controls.find(({ path }) => `${field}.`.startsWith(`${path.join('.')}.`));
      if (control) control.complain(message);
      else others.push(`${field}: ${message}`);
    }
    if (others.length || !error.details?.length) this.#complain([error.message, ...others].join('; '));
  }

  /** Focus the first invalid field. @returns {boolean} Whether there is one. */
  #showFirst() {
    const wrong = this.controls.find(({ wrong }) => wrong());
    if (wrong?.advanced) this.moreBox.open = true;
    wrong?.input.focus();
    return wrong !== undefined;
  }

  #complain(text) {
    say(this.error, text);
    this.error.hidden = text === '';
    mark(this.element, 'data-refused', text !== '');
  }
}

/** Yield the fields of a schema and its nested objects: schema, path, and whether it is required. */
function* fieldsOf(schema, path = []) {
  for (const [name, part] of Object.entries(schema.properties ?? {})) {
    if (part.type === 'object' && !part.format) yield* fieldsOf(part, [...path, name]);
    else yield { schema: part, path: [...path, name], required: schema.required?.includes(name) ?? false };
  }
}

function put(values, path, value) {
  const part = path.slice(0, -1).reduce((outer, name) => (outer[name] ??= {}), values);
  part[path.at(-1)] = value;
}
