/** Pointer and wheel gestures: pan, zoom, pinch, click and menu, in css pixels. */

const SLACK = 6; // css pixels of movement that still count as a click
const LONG_PRESS = 550; // ms
const DOUBLE = 320; // ms

/**
 * Tells a handler what pointers do: pan(dx, dy), zoom(px, py, factor, smooth), click(px, py), menu(px, py) and hover(px, py),
 * with nulls after the pointer has left; zoomsOnDouble(px, py) returns whether a double click there zooms.
 */
export class Gestures {
  constructor(element, handler) {
    this.element = element;
    this.handler = handler;
    this.pointers = new Map(); // the position of each pointer by id
    this.moved = false;
    this.timer = 0;
    this.lastClick = { time: -1e9, px: 0, py: 0 };
    const on = (kind, listener, options) => element.addEventListener(kind, listener, options);
    on('pointerdown', (event) => this.down(event));
    on('pointermove', (event) => this.move(event));
    on('pointerup', (event) => this.up(event));
    on('pointercancel', (event) => this.drop(event));
    on('pointerleave', () => this.handler.hover(null, null));
    on('wheel', (event) => this.wheel(event), { passive: false });
    on('contextmenu', (event) => {
      event.preventDefault();
      if (event.pointerType !== 'touch') this.handler.menu(...this.at(event));
    });
  }

  at(event) {
    const { left, top } = this.element.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 18 : event.deltaMode === 2 ? 300 : 1;
    // A pinch on a touchpad comes as a wheel with ctrl, in small steps.
    const step = Math.max(-240, Math.min(240, event.deltaY * lines)) * (event.ctrlKey ? 0.012 : 0.0022);
    this.handler.zoom(...this.at(event), Math.exp(-step), false);
  }

  down(event) {
    if (event.button > 1) return;
    const [px, py] = this.at(event);
    this.element.setPointerCapture?.(event.pointerId);
    this.pointers.set(event.pointerId, { px, py, startX: px, startY: py });
    clearTimeout(this.timer);
    if (this.pointers.size > 1) {
      this.moved = true;
      return;
    }
    this.moved = event.button === 1;
    if (event.pointerType === 'touch') {
      this.timer = setTimeout(() => {
        this.moved = true;
        this.handler.menu(px, py);
      }, LONG_PRESS);
    }
  }

  move(event) {
    const [px, py] = this.at(event);
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) {
      if (event.pointerType !== 'touch') this.handler.hover(px, py);
      return;
    }
    if (!this.moved && Math.hypot(px - pointer.startX, py - pointer.startY) > SLACK) {
      this.moved = true;
      clearTimeout(this.timer);
      this.element.style.cursor = 'grabbing';
    }
    if (this.pointers.size === 2) this.pinch(event.pointerId, px, py);
    else if (this.moved) this.handler.pan(px - pointer.px, py - pointer.py);
    // Movement within the slack counts once a pan has begun.
    if (this.moved) Object.assign(pointer, { px, py });
  }

  pinch(id, px, py) {
    const pointer = this.pointers.get(id);
    const other = [...this.pointers.values()].find((each) => each !== pointer);
    const before = Math.hypot(pointer.px - other.px, pointer.py - other.py);
    const after = Math.hypot(px - other.px, py - other.py);
    this.handler.pan((px - pointer.px) / 2, (py - pointer.py) / 2);
    if (before > 8 && after > 8) this.handler.zoom((px + other.px) / 2, (py + other.py) / 2, after / before, false);
  }

  up(event) {
    const pointer = this.pointers.get(event.pointerId);
    this.drop(event);
    if (!pointer || this.moved || this.pointers.size) return;
    const [px, py] = this.at(event);
    const last = this.lastClick;
    const again = event.timeStamp - last.time < DOUBLE && Math.hypot(px - last.px, py - last.py) < 24;
    if (again && this.handler.zoomsOnDouble(px, py)) {
      this.lastClick = { time: -1e9, px, py };
      this.handler.zoom(px, py, event.shiftKey ? 0.5 : 2, true);
      return;
    }
    this.lastClick = { time: event.timeStamp, px, py };
    this.handler.click(px, py);
  }

  drop(event) {
    clearTimeout(this.timer);
    this.pointers.delete(event.pointerId);
    this.element.style.cursor = '';
  }
}
