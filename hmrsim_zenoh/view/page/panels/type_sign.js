// The body of a type of robots as the map draws it, for lists and the legend.

import { drawBody, lookOf } from '../map/bodies.js';
import { el, mark } from './dom.js';

const SIZE = 22; // css pixels

export class TypeSign {
  element = el('canvas', { class: 'type-sign', 'aria-hidden': 'true', width: 2 * SIZE, height: 2 * SIZE });

  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
  }

  /** @param {string} type @param {boolean} [flies] */
  show(type, flies = this.app.model.world.types.get(type)?.flies ?? false) {
    const { palette, theme, model } = this.app;
    const drawn = `${type} ${flies} ${theme.name} ${model.world.typeIndex(type)}`;
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const c = this.element.getContext('2d');
    c.setTransform(SIZE * 0.92, 0, 0, SIZE * 0.92, SIZE, SIZE);
    c.clearRect(-2, -2, 4, 4);
    drawBody(c, lookOf(model.world.typeIndex(type), palette), flies, palette[theme.name].robot_outline, 0.09);
    mark(this.element, 'title', type);
  }
}
