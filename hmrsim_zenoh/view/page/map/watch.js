/** Notices what in a model has changed, so that only that is drawn anew. */

export class Watch {
  /**
   * @param {import('../model/model.js').Model} model
   * @param {{worldChanged: () => void, changed: (still: boolean) => void}} view
   */
  constructor(model, view) {
    this.model = model;
    this.view = view;
    /** The fixtures as they were drawn; what is said of one is replaced and never changed. */
    this.fixtures = [];
    this.closed = '';
    model.addEventListener('world', () => view.worldChanged());
    for (const kind of ['scene', 'robots', 'faults']) model.addEventListener(kind, () => this.look());
  }

  look() {
    this.view.changed(false);
    if (this.fixturesChanged() || this.closuresChanged()) this.view.changed(true);
  }

  fixturesChanged() {
    let count = 0;
    let changed = false;
    for (const fixtures of [this.model.docks, this.model.doors, this.model.lifts]) {
      for (const fixture of fixtures.values()) {
        if (this.fixtures[count] !== fixture) {
          this.fixtures[count] = fixture;
          changed = true;
        }
        count += 1;
      }
    }
    this.fixtures.length = count;
    return changed;
  }

  closuresChanged() {
    const closed = this.model.closedLanes.size ? [...this.model.closedLanes.keys()].join() : '';
    const changed = closed !== this.closed;
    this.closed = closed;
    return changed;
  }
}
