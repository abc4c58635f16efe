// A dialog made from JSON Schemas: what to ask for is chosen, its fields are filled in, errors are shown at the fields.

import { button, el, mark, say } from './dom.js';
import { makeField } from './fields.js';

/**
 * @typedef {object} Asked
 * @property {string} title Of the dialog.
 * @property {string} label Of what is chosen, such as "Action".
 * @property {Record<string, object>} forms JSON Schemas by name, as `_world/view` has them.
 * @property {string} [chosen] Which comes first.
 * @property {Record<string, any>} [values] By dotted path: what is filled in already.
 * @property {string} verb On the button.
 * @property {(name: string, values: object) => Promise<void>} send What it is refused with, it throws: `details` has
 *   field and message, as the simulator's answers do.
 */

export class FormDialog {
  /** @param {import('../app.js').App} app */
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
    const form = el('form', { method: 'dialog', novalidate: true, onsubmit: (event) => this.#submit(event) }, this.title,
      el('label', {}, this.label, this.choice), this.about, this.fields, this.moreBox, this.error,
      el('div', { class: 'actions' },
        el('button', { type: 'button', class: 'button', text: 'Cancel', onclick: () => this.element.close() }), this.submit));
    this.element = el('dialog', { class: 'dialog', 'aria-labelledby': 'form-title' },
      button('close', 'Close', () => this.element.close(), { class: 'quiet corner' }), form);
  }

  /** @param {Asked} asked */
  open(asked) {
    this.asked = asked;
    say(this.title, asked.title);
    say(this.label, asked.label);
    say(this.submit, asked.verb);
    this.choice.replaceChildren(...Object.entries(asked.forms).map(([name, { title }]) => el('option', { value: name, text: title })));
    if (asked.forms[asked.chosen]) this.choice.value = asked.chosen;
    this.#choose();
    this.element.showModal();
    (this.controls[0]?.input ?? this.submit).focus();
  }

  #choose() {
    const schema = this.asked.forms[this.choice.value];
    say(this.about, schema.description ?? '');
    this.controls = [...fieldsOf(schema)].map((field) => makeField(field, this.app, this.asked));
    this.fields.replaceChildren(...this.controls.filter(({ advanced }) => !advanced).map(({ element }) => element));
    this.more.replaceChildren(...this.controls.filter(({ advanced }) => advanced).map(({ element }) => element));
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
    try {
      await this.asked.send(this.choice.value, values);
      this.element.close();
    } catch (error) {
      this.#place(error);
      this.#showFirst();
    } finally {
      this.submit.disabled = false;
    }
  }

  /** Show what was refused at the fields that it is about; the rest below all. */
  #place(error) {
    const others = [];
    for (const { field, message } of error.details ?? []) {
      const control = this.controls.find(({ path }) => `${field}.`.startsWith(`${path.join('.')}.`));
      if (control) control.complain(message);
      else others.push(`${field}: ${message}`);
    }
    if (others.length || !error.details?.length) this.#complain([error.message, ...others].join('; '));
  }

  /** @returns {boolean} whether something is wrong with a field, which has the focus then */
  #showFirst() {
    const wrong = this.controls.find(({ wrong }) => wrong());
    if (wrong?.advanced) this.moreBox.open = true;
    wrong?.input.focus();
    return wrong !== undefined;
  }

  #complain(text) {
    say(this.error, text);
    this.error.hidden = text === '';
    mark(this.element, 'data-refused', String(text !== ''));
  }
}

/** Yield the fields of a schema, those of nested objects too: schema, path, and whether it has to be filled in. */
function* fieldsOf(schema, path = []) {
  for (const [name, part] of Object.entries(schema.properties ?? {})) {
    if (part.type === 'object' && !part.format) yield* fieldsOf(part, [...path, name]);
    else yield { schema: part, path: [...path, name], required: schema.required?.includes(name) ?? false };
  }
}

function put(values, path, value) {
  const last = path.at(-1);
  let part = values;
  for (const name of path.slice(0, -1)) part = part[name] ??= {};
  part[last] = value;
}
