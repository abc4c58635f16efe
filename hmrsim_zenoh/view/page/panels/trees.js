// Behavior trees that controllers publish on `_tree`: one collapsible tree per robot.

import { Facts, el, icon, mark, say, sign } from './dom.js';
import { clockWords } from '../model/phrases.js';

/** The words for a node's outcomes. */
const ENDS = [['SUCCESS', 'succeeded'], ['FAILURE', 'failed']];

export class TreesPanel {
  constructor(app) {
    this.app = app;
    this.title = 'Trees';
    this.views = new Map();
    this.list = el('div', { class: 'trees' });
    this.hint = el('div', { class: 'empty' },
      el('p', { text: 'No controller publishes a behavior tree.' }),
      el('p', {}, 'Start one: ', el('code', { text: 'bt-controller run TREE --robot NAME' })));
    this.element = el('div', { class: 'panel-body scroll' }, this.hint, this.list);
  }

  /** @param {boolean} seen Whether the panel is open; only then are trees requested. */
  seen(seen) { this.app.live?.watchTrees(seen); }

  render() {
    const { trees } = this.app.model;
    const { selected } = this.app.map;
    this.hint.hidden = trees.size > 0;
    for (const [robot, { element }] of this.views) if (!trees.has(robot)) element.remove(), this.views.delete(robot);
    for (const [robot, state] of trees) this.#view(robot).render(state, robot === selected);
    this.#raise(selected);
  }

  /** Put the selected robot's tree first, and open it. */
  #raise(selected) {
    if (selected === this.raised) return;
    const view = this.views.get(selected);
    if (!view && selected !== null) return;
    this.raised = selected;
    if (!view) return;
    view.element.open = true;
    this.list.prepend(view.element);
  }

  #view(robot) {
    const known = this.views.get(robot);
    if (known) return known;
    const view = new TreeView(this.app, robot, this.views.size === 0 || robot === this.app.map.selected);
    this.views.set(robot, view);
    this.list.append(view.element);
    return view;
  }
}

class TreeView {
  constructor(app, robot, open) {
    this.shape = sign('tree', '');
    this.tick = el('span', { class: 'long' });
    const find = el('button', { type: 'button', class: 'link', text: robot, onclick: () => app.select(robot, { center: true }) });
    this.tree = el('div', { role: 'tree', 'aria-label': `Behavior tree of ${robot}`, class: 'tree' });
    this.board = new Facts();
    this.boardBox = el('details', { class: 'board' }, el('summary', { text: 'Blackboard' }), this.board.element);
    this.element = el('details', { class: 'card', open },
      el('summary', {}, icon('right'), this.shape, find, this.tick), this.tree, this.boardBox);
    this.folded = new Set();
    this.made = '';
    this.rows = [];
    this.tree.addEventListener('keydown', (event) => this.#key(event));
    this.element.addEventListener('toggle', () => this.state && this.render(this.state, false));
  }

  render(state, selected) {
    this.state = state;
    mark(this.shape, 'data-is', state.status);
    const at = state.sim_time === null ? '' : `, ${clockWords(state.sim_time)}`;
    say(this.tick, `${state.status.toLowerCase()}${state.ended ? ', ended' : ''} · tick ${state.tick}${at}`);
    mark(this.element, 'data-selected', selected);
    if (!this.element.open) return;
    const made = JSON.stringify(state.nodes.map(({ depth, name, kind }) => [depth, name, kind]));
    if (made !== this.made) this.#make(state.nodes, made);
    state.nodes.forEach((node, i) => this.#fill(this.rows[i], node));
    this.#renderBoard(state.blackboard);
  }

  #make(nodes, made) {
    this.made = made;
    this.rows = nodes.map((node, i) => this.#row(node, i, (nodes[i + 1]?.depth ?? 0) > node.depth));
    this.tree.replaceChildren(...this.rows.map((row) => row.element));
    this.#fold();
  }

  #row(node, index, parent) {
    const shape = sign('tree', '');
    const [message, status, covered] = ['message', 'unseen', 'covered'].map((name) => el('span', { class: name }));
    const fold = el('span', { class: 'fold', 'aria-hidden': 'true' }, parent ? icon('down') : '');
    const element = el('div', {
      role: 'treeitem', class: 'node', 'aria-level': node.depth + 1, tabindex: index ? '-1' : '0',
      'aria-expanded': parent ? 'true' : null, title: [node.kind, node.origin].filter(Boolean).join(', '),
      onclick: () => parent && this.#toggle(index),
    }, fold, shape, el('span', { class: 'symbol', text: node.symbol, 'aria-hidden': 'true' }),
    el('span', { class: 'node-name', text: node.name }), status, message, covered);
    element.style.setProperty('--depth', node.depth);
    return { element, shape, message, status, covered, depth: node.depth, parent };
  }

  #fill(row, node) {
    for (const element of [row.shape, row.element]) mark(element, 'data-is', node.status);
    say(row.status, node.status.toLowerCase());
    say(row.message, node.message);
    if (node.coverage) this.#count(row, node.coverage);
  }

  /** Show how often a node has succeeded and failed, and which outcomes it never had. */
  #count(row, { counts, never }) {
    const said = JSON.stringify([counts, never]);
    if (said === row.said) return;
    row.said = said;
    const tried = !never.includes('ticked');
    mark(row.covered, 'data-never', tried ? '' : 'ticked');
    const seen = Object.entries(counts).map(([outcome, count]) => `${outcome} ${count}`);
    mark(row.covered, 'title', [...seen, ...never.map((word) => `never ${word}`)].join(', '));
    row.covered.replaceChildren(...(tried ? ENDS : []).flatMap(([outcome, word]) => {
      if (!(outcome in counts) && !never.includes(word)) return [];
      const count = counts[outcome] ?? 0;
      return [sign('tree', outcome), el('span', { text: count, data: { none: count === 0 } }), el('span', { class: 'unseen', text: word })];
    }), tried ? '' : 'never ticked');
  }

  #toggle(index) {
    if (!this.folded.delete(index)) this.folded.add(index);
    this.#fold();
  }

  #fold() {
    let hiddenBelow = Infinity;
    this.rows.forEach((row, i) => {
      if (row.depth <= hiddenBelow) hiddenBelow = Infinity;
      row.element.hidden = row.depth > hiddenBelow;
      if (!row.parent) return;
      const folded = this.folded.has(i);
      mark(row.element, 'aria-expanded', !folded);
      if (folded) hiddenBelow = Math.min(hiddenBelow, row.depth);
    });
  }

  #key(event) {
    const index = this.rows.findIndex((row) => row.element === document.activeElement);
    if (index < 0) return;
    const seen = this.rows.filter((row) => !row.element.hidden);
    const at = seen.indexOf(this.rows[index]);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: seen.length - 1 }[event.key];
    if (seen[to]) seen[to].element.focus();
    else if (event.key === 'ArrowLeft' && !this.folded.has(index)) this.#toggle(index);
    else if (event.key === 'ArrowRight' && this.folded.has(index)) this.#toggle(index);
    else if (event.key === 'Enter' && this.rows[index].parent) this.#toggle(index);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  #renderBoard(blackboard) {
    const all = Object.entries(blackboard ?? {});
    this.boardBox.hidden = all.length === 0;
    if (!this.boardBox.open) return;
    this.board.show(all.map(([key, value]) => [key, typeof value === 'string' ? value : JSON.stringify(value)]));
  }
}
